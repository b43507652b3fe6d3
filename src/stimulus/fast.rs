//! The fast path from a specification to 8-bit codes: the same bytes as the reference, for little
//! more than writing them.
//!
//! Quantised, the ramp is a staircase of at most a few hundred steps, and every row shows the same
//! staircase, shifted. What a row looks like depends on where its shift falls between two pixels,
//! and changes by one pixel at a time as that part of the shift grows from 0 to 1. So one template
//! is made, rows are visited in order of the fraction of their shift, the template is corrected
//! pixel by pixel on the way, and every row is a copy of a piece of it. Pixels whose centre lies on
//! a step to within rounding are computed by the reference.

use super::mach_band::{MachBand, Ramp};
use super::orientation::Grid;
use super::staircase::{self, Staircase};
use crate::light::Quantizer;

/// Longest template, in rows of the image: it is written once and should stay in a near cache.
const LONGEST_TEMPLATE: f64 = 64.0;
/// Doubt, in pixels, up to which the template's order of steps and rows is certain enough.
const LARGEST_DOUBT_PX: f64 = 0.01;
/// Fractions of a pixel are compared as whole numbers of 2⁻⁴⁰, which leaves room for an index
/// below.
const FRACTION_BITS: u32 = 40;
const ONE: u64 = 1 << FRACTION_BITS;
const INDEX_BITS: u32 = 24;
const INDEX_MASK: u64 = (1 << INDEX_BITS) - 1;

/// Codes of any pixel, by the reference.
struct Reference<'a> {
    grid: Grid,
    ramp: Ramp,
    weights: [f64; 3],
    quantizer: &'a Quantizer,
}

impl Reference<'_> {
    fn pixel(&self, ix: usize, iy: usize) -> [u8; 3] {
        // Both are below the size, a u32.
        let x = self.grid.across(ix as u32, iy as u32);
        staircase::codes(self.weights, self.ramp.luminance_at(x), self.quantizer)
    }
}

/// Writes the 8-bit codes of `band`, `size` × `size` pixels, to `out`, which has 3·size² bytes.
pub(super) fn render(band: &MachBand, size: u32, quantizer: &Quantizer, out: &mut [u8]) {
    if size == 0 {
        return;
    }
    let grid = Grid::new(size, band.orientation_deg);
    let reference = Reference { grid, ramp: band.ramp(), weights: band.color.rgb(), quantizer };
    let n = size as usize;
    if grid.sin == 0.0 {
        let (first, others) = out.split_at_mut(3 * n);
        write_row(&reference, 0, first);
        others.chunks_exact_mut(3 * n).for_each(|row| copy(first, row));
    } else if grid.cos == 0.0 {
        let mut above: Option<(&[u8], [u8; 3])> = None;
        for (iy, row) in out.chunks_exact_mut(3 * n).enumerate() {
            let rgb = reference.pixel(0, iy);
            match above {
                Some((above, same)) if same == rgb => copy(above, row),
                _ => fill(row, rgb),
            }
            above = Some((row, rgb));
        }
    } else {
        let stairs = Staircase::new(&reference.ramp, reference.weights, quantizer);
        let along = Along::new(&grid, &stairs);
        if !along.is_certain(stairs.steps.len()) {
            out.chunks_exact_mut(3 * n).enumerate().for_each(|(iy, row)| write_row(&reference, iy, row));
        } else if along.template_rows() <= LONGEST_TEMPLATE {
            along.copy_rows(&reference, out);
        } else {
            along.fill_rows(&reference, out);
        }
    }
}

/// One row by the reference.
fn write_row(reference: &Reference<'_>, iy: usize, row: &mut [u8]) {
    for (ix, pixel) in row.chunks_exact_mut(3).enumerate() {
        pixel.copy_from_slice(&reference.pixel(ix, iy));
    }
}

/// Copies a row, in pieces. From about 2 KiB on the C library may use the processor's string move, which on some
/// processors is six times slower when source and target lie unluckily within their pages.
fn copy(from: &[u8], to: &mut [u8]) {
    const PIECE: usize = 1536;
    for (from, to) in from.chunks(PIECE).zip(to.chunks_mut(PIECE)) {
        to.copy_from_slice(from);
    }
}

/// Makes every pixel of `run` the same.
fn fill(run: &mut [u8], rgb: [u8; 3]) {
    let mut done = run.len().min(96);
    run[..done].chunks_exact_mut(3).for_each(|pixel| pixel.copy_from_slice(&rgb));
    // What is there is copied behind itself, twice as much each time.
    while done < run.len() {
        let more = done.min(run.len() - done);
        run.copy_within(..more, done);
        done += more;
    }
}

/// The staircase along a row from left to right, in pixels.
struct Along {
    size: usize,
    stairs: Staircase,
    /// Where the steps are, in pixels, for a row of shift 0.
    places: Vec<f64>,
    /// Pixels by which a row is shifted against the one below it.
    tan: f64,
    /// In pixels.
    doubt: f64,
}

impl Along {
    /// `grid`'s cosine is not 0.
    fn new(grid: &Grid, stairs: &Staircase) -> Self {
        let stairs = if grid.cos < 0.0 { stairs.reversed() } else { stairs.clone() };
        let scale = f64::from(grid.size) / grid.cos.abs();
        let places = stairs.steps.iter().map(|step| step.x * scale).collect();
        let doubt = stairs.doubt * scale + 8.0 / ONE as f64;
        // Turned half round, sine and cosine change sign together.
        Self { size: grid.size as usize, stairs, places, tan: grid.sin / grid.cos, doubt }
    }

    /// Whether steps are known well enough, and few enough, to be worth the trouble.
    fn is_certain(&self, steps: usize) -> bool {
        self.doubt <= LARGEST_DOUBT_PX && self.size < INDEX_MASK as usize && steps < INDEX_MASK as usize
    }

    /// Length of the template in rows.
    fn template_rows(&self) -> f64 {
        1.0 + self.tan.abs()
    }

    /// Pixels from the places of the steps to where row `iy` has them: pixel i of the row is after
    /// the step of place p when i ≥ p + shift.
    fn shift(&self, iy: usize) -> f64 {
        let last = (self.size - 1) as f64;
        0.5 * last - (0.5 * last - iy as f64) * self.tan
    }

    /// Every row a copy of a piece of one template.
    fn copy_rows(&self, reference: &Reference<'_>, out: &mut [u8]) {
        let n = self.size;
        let shifts: Vec<f64> = (0..n).map(|iy| self.shift(iy)).collect();
        let whole: Vec<i64> = shifts.iter().map(|&shift| floor(shift)).collect();
        let rows = sorted(shifts.iter().zip(&whole).map(|(shift, &whole)| shift - whole as f64));
        // A step crosses the first pixel after it when the fraction of the shift reaches the gap
        // between them.
        let gaps = sorted(self.places.iter().map(|place| place.ceil() - place));
        let (first, last) = (whole[0], whole[n - 1]);
        // The template's pixel 0 is this far from that of shift 0; the row with the largest shift
        // begins there.
        let origin = -first.max(last);
        let mut template = self.template(origin, n + first.abs_diff(last) as usize);
        let doubt = (self.doubt * ONE as f64).ceil() as u64;
        let mut passed = 0;
        for &row in &rows {
            while passed < gaps.len() && fraction(gaps[passed]) < fraction(row) {
                let step = index(gaps[passed]);
                let at = self.places[step].ceil() as i64 - origin;
                if let Some(pixel) = usize::try_from(at).ok().and_then(|at| template.get_mut(3 * at..3 * at + 3)) {
                    pixel.copy_from_slice(&self.stairs.before(step));
                }
                passed += 1;
            }
            let iy = index(row);
            let start = (-whole[iy] - origin) as usize;
            let target = &mut out[3 * n * iy..3 * n * (iy + 1)];
            copy(&template[3 * start..3 * (start + n)], target);
            each_near(&gaps, passed, fraction(row), doubt, |step| {
                settle(reference, iy, self.places[step] + shifts[iy], target);
            });
        }
    }

    /// The template as it is for rows of fraction 0: `length` pixels from pixel `origin`.
    fn template(&self, origin: i64, length: usize) -> Vec<u8> {
        let mut template = vec![0; 3 * length];
        let mut begin = 0;
        for step in 0..=self.places.len() {
            let end = match self.places.get(step) {
                Some(place) => (place.ceil() as i64 - origin).clamp(0, length as i64) as usize,
                None => length,
            };
            fill(&mut template[3 * begin..3 * end], self.stairs.before(step));
            begin = end;
        }
        template
    }

    /// Every row by itself, from step to step: for ramps so nearly level that a row sees few of
    /// them.
    fn fill_rows(&self, reference: &Reference<'_>, out: &mut [u8]) {
        let n = self.size;
        for (iy, row) in out.chunks_exact_mut(3 * n).enumerate() {
            let shift = self.shift(iy);
            let mut step = self.places.partition_point(|place| place + shift <= 0.0);
            let mut begin = 0;
            while begin < n {
                let end = match self.places.get(step) {
                    Some(place) => ((place + shift).ceil() as usize).min(n),
                    None => n,
                };
                fill(&mut row[3 * begin..3 * end], self.stairs.before(step));
                (begin, step) = (end, step + 1);
            }
            let from = self.places.partition_point(|place| place + shift < -self.doubt);
            for place in self.places[from..].iter().map(|place| place + shift) {
                if place > (n - 1) as f64 + self.doubt {
                    break;
                }
                if (place - place.round()).abs() <= self.doubt {
                    settle(reference, iy, place, row);
                }
            }
        }
    }
}

/// The largest whole number not above `x`, which fits an i64. `f64::floor` is a call where the
/// processor's floor may not be used.
fn floor(x: f64) -> i64 {
    let whole = x as i64;
    if (whole as f64) > x { whole - 1 } else { whole }
}

/// Asks the reference about the pixel of row `iy` nearest to `place`, if there is one.
fn settle(reference: &Reference<'_>, iy: usize, place: f64, row: &mut [u8]) {
    let ix = place.round();
    if ix >= 0.0 && ix < f64::from(reference.grid.size) {
        let ix = ix as usize;
        row[3 * ix..3 * ix + 3].copy_from_slice(&reference.pixel(ix, iy));
    }
}

/// The fraction of a key that [`sorted`] made, in 2⁻⁴⁰.
fn fraction(key: u64) -> u64 {
    key >> INDEX_BITS
}

/// The index of a key that [`sorted`] made.
fn index(key: u64) -> usize {
    (INDEX_MASK - (key & INDEX_MASK)) as usize
}

/// `fractions` (0…1) in rising order, each in one word with its index. Of equal fractions the later
/// comes first: two steps before the same pixel are crossed from the far one to the near one.
fn sorted(fractions: impl ExactSizeIterator<Item = f64>) -> Vec<u64> {
    let mut keys: Vec<u64> = fractions
        .enumerate()
        // A fraction may round up to 1, which is as good as the largest below it.
        .map(|(i, fraction)| ((fraction * ONE as f64) as u64).min(ONE - 1) << INDEX_BITS | (INDEX_MASK - i as u64))
        .collect();
    sort(&mut keys);
    keys
}

/// Sorts. The fractions of many rows are spread evenly: bucketed by their first bits, hardly one is out of place.
fn sort(keys: &mut Vec<u64>) {
    const BUCKET_BITS: u32 = 10;
    let bucket = |key: u64| (key >> (FRACTION_BITS + INDEX_BITS - BUCKET_BITS)) as usize;
    let mut ends = [0; 1 << BUCKET_BITS];
    keys.iter().for_each(|&key| ends[bucket(key)] += 1);
    if keys.len() < ends.len() / 2 || ends.iter().any(|&count| count > 16) {
        return keys.sort_unstable();
    }
    let mut total = 0;
    for end in &mut ends {
        total += *end;
        *end = total;
    }
    let mut spread = vec![0; keys.len()];
    for &key in keys.iter() {
        let end = &mut ends[bucket(key)];
        *end -= 1;
        spread[*end] = key;
    }
    // Insertion: nothing moves further than its bucket reaches.
    for i in 1..spread.len() {
        let (key, mut to) = (spread[i], i);
        while to > 0 && spread[to - 1] > key {
            spread[to] = spread[to - 1];
            to -= 1;
        }
        spread[to] = key;
    }
    *keys = spread;
}

/// Calls `each` with the index of every one of `gaps` within `doubt` of `at`, all in 2⁻⁴⁰; 0 and 1
/// are neighbours. The first `passed` gaps are below `at`.
fn each_near(gaps: &[u64], passed: usize, at: u64, doubt: u64, mut each: impl FnMut(usize)) {
    let near = |gap: &&u64| {
        let distance = fraction(**gap).abs_diff(at);
        distance <= doubt || ONE - distance <= doubt
    };
    let mut call = |gap: &u64| each(index(*gap));
    gaps[..passed].iter().rev().take_while(near).for_each(&mut call);
    gaps[passed..].iter().take_while(near).for_each(&mut call);
    if at <= doubt {
        gaps[passed..].iter().rev().take_while(near).for_each(&mut call);
    }
    if ONE - at <= doubt {
        gaps[..passed].iter().take_while(near).for_each(&mut call);
    }
}
