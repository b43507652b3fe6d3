//! Codes of a ramp between two colors, looked up: the same bytes as quantising every pixel, several times sooner.
//!
//! All pixels of equal distance from the centre line are alike, so a table over that distance will do. No channel changes
//! faster than a bound that is known, so in most of the table's cells no code can change; a pixel in one of the others is
//! computed.

use super::passage::Between;
use super::{MachBand, Ramp};
use crate::light::Quantizer;
use crate::stimulus::orientation::Grid;

/// Cells across the ramp.
const CELLS: usize = 1 << 15;
/// Pixels a side below which a table is not worth making.
const SMALLEST_PX: u32 = 256;
/// Pixels that a ramp should be wide for a table to be worth making.
const NARROWEST_PX: f64 = 8.0;
/// How far, in cells, the arithmetic of a pixel may put it beside its cell. Far more than it does.
const DOUBT_CELLS: f64 = 1e-3;
/// How far the arithmetic of a light may be off. Far more than it is.
const DOUBT_LIGHT: f64 = 1e-12;

/// Codes of any pixel.
struct Pixels<'a> {
    grid: Grid,
    ramp: Ramp,
    passage: &'a Between,
    quantizer: &'a Quantizer,
}

/// Writes the 8-bit codes of `band`, `size` × `size` pixels, to `out`, which has 3·size² bytes.
pub(super) fn render(band: &MachBand, passage: &Between, size: u32, quantizer: &Quantizer, out: &mut [u8]) {
    if size == 0 {
        return;
    }
    let pixels = Pixels { grid: Grid::new(size, band.orientation_deg), ramp: band.ramp(), passage, quantizer };
    let mut rows = (0..size).zip(out.chunks_exact_mut(3 * size as usize));
    if pixels.grid.sin == 0.0 {
        let Some((_, first)) = rows.next() else { return };
        (0..size).zip(first.as_chunks_mut().0).for_each(|(ix, pixel)| *pixel = pixels.codes(pixels.grid.across(ix, 0)));
        rows.for_each(|(_, row)| row.copy_from_slice(first));
    } else if pixels.grid.cos == 0.0 {
        rows.for_each(|(iy, row)| row.as_chunks_mut().0.fill(pixels.codes(pixels.grid.across(0, iy))));
    } else {
        let worth_it = size >= SMALLEST_PX && band.width * f64::from(size) >= NARROWEST_PX;
        let table = worth_it.then(|| Table::new(&pixels));
        for (iy, row) in rows {
            for (ix, pixel) in (0..size).zip(row.as_chunks_mut().0) {
                let x = pixels.grid.across(ix, iy);
                let known = table.as_ref().and_then(|table| table.get(x));
                *pixel = known.unwrap_or_else(|| pixels.codes(x));
            }
        }
    }
}

impl Pixels<'_> {
    /// The codes at `x` window sides from the centre line: the definition.
    fn codes(&self, x: f64) -> [u8; 3] {
        codes_of(self.quantizer, self.passage.light_at_part(self.ramp.part_at(x)))
    }
}

/// The 8-bit codes of `light`.
fn codes_of(quantizer: &Quantizer, light: [f64; 3]) -> [u8; 3] {
    // An 8-bit code fits.
    quantizer.codes(light.map(|linear| linear as f32)).map(|code| code as u8)
}

/// The codes across the ramp, where they are certain.
struct Table {
    /// Of every cell, and of one more on either side of the ramp.
    cells: Vec<Option<[u8; 3]>>,
    low: [u8; 3],
    high: [u8; 3],
    /// Half the ramp's width, and cells to a window side.
    half: f64,
    scale: f64,
}

impl Table {
    fn new(pixels: &Pixels<'_>) -> Self {
        let (ramp, width) = (&pixels.ramp, pixels.ramp.width);
        let scale = CELLS as f64 / width;
        // No I_n is steeper than at its middle.
        let per_cell = ramp.interpolation.slope(0.5) / CELLS as f64;
        let reach = pixels.passage.steepness().map(|most| most * per_cell * (0.5 + DOUBT_CELLS) + DOUBT_LIGHT);
        let codes = |light: [f64; 3]| codes_of(pixels.quantizer, light);
        let cell = |cell: usize| {
            let part = ramp.interpolation.value((cell as f64 + 0.5) / CELLS as f64);
            let light = pixels.passage.light_at_part(part);
            let least = codes(std::array::from_fn(|channel| light[channel] - reach[channel]));
            let most = codes(std::array::from_fn(|channel| light[channel] + reach[channel]));
            (least == most).then_some(least)
        };
        // In the first and the last cell the ramp begins and ends, for the infinite depth with a jump.
        let inner = (1..CELLS - 1).map(cell);
        let cells = [None; 2].into_iter().chain(inner).chain([None; 2]).collect();
        let [low, high] = [0.0, 1.0].map(|part| codes(pixels.passage.light_at_part(part)));
        Self { cells, low, high, half: width / 2.0, scale }
    }

    #[inline]
    fn get(&self, x: f64) -> Option<[u8; 3]> {
        // The cell before the ramp is number 0.
        let at = (x + self.half) * self.scale + 1.0;
        if at < 0.0 {
            Some(self.low)
        } else {
            // `as` rounds down here.
            self.cells.get(at as usize).copied().unwrap_or(Some(self.high))
        }
    }
}
