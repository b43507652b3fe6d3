//! How stimuli are drawn. Most vary in one direction only: their profile gives the light of every pixel, and its code.
//!
//! An edge that runs along the pixels is perfectly sharp. An oblique edge for which a profile states the height of a jump is
//! anti-aliased in linear light: each pixel mixes both sides in proportion to its area on each side. A Mach band states
//! none: its step, the limit of narrow ramps, stays as sharp as the pixels at every orientation.

use std::f64::consts::FRAC_1_SQRT_2;

use rayon::prelude::*;

use crate::light::{Bits, CodeImage, LinearImage, Quantizer, Samples};
use crate::system::checkpoint;

/// What a window shows.
pub(super) trait Area {
    /// Returns the light of a window of `size` × `size` pixels.
    fn linear(&self, size: u32) -> LinearImage;

    /// Returns its codes, which equal the quantized light.
    fn codes(&self, size: u32, quantizer: &Quantizer) -> CodeImage {
        quantizer.quantize(&self.linear(size))
    }

    /// Returns the light at the centers of a row of `size` pixels through the middle, along the orientation.
    fn profile(&self, size: u32) -> Vec<[f32; 3]>;
}

/// Light that varies along one direction only. Positions are measured from the center line in window sides, positive in
/// the direction of the orientation.
pub(super) trait Profile: Sync {
    /// Returns the light at `x`; `added` is added to the luminance. At a jump, this is the value on the far side.
    fn light(&self, x: f64, added: f64) -> [f64; 3];

    /// Returns, in any order, the positions where a channel may turn from rising to falling or vice versa, or where the
    /// luminance jumps, each with the height of the jump. Between neighboring positions, every channel is monotonic and
    /// continuous. `None` if they are not known, as in the colors between two hues: every pixel is then computed.
    fn turns(&self) -> Option<Vec<(f64, f64)>>;
}

/// Computes the light of a window that varies along its orientation, one pixel at a time. This defines the result;
/// faster paths must match it.
struct Pixels<'a> {
    profile: &'a dyn Profile,
    grid: Grid,
    /// The jumps to anti-alias; none if the edges run along the pixels.
    jumps: Vec<(f64, f64)>,
}

impl<'a> Pixels<'a> {
    fn new(profile: &'a dyn Profile, orientation_deg: f64, size: u32) -> Self {
        let grid = Grid::new(size, orientation_deg);
        let jumps = profile.turns().into_iter().flatten().filter(|(_, height)| *height != 0.0);
        Self { profile, grid, jumps: if grid.is_along_pixels() { Vec::new() } else { jumps.collect() } }
    }

    fn light(&self, ix: u32, iy: u32) -> [f32; 3] {
        let x = self.grid.across(ix, iy);
        let (reach, side) = (half_extent(&self.grid), f64::from(self.grid.size));
        let smoothed: f64 = self
            .jumps
            .iter()
            .map(|(at, height)| ((x - at) * side, height))
            .filter(|(distance, _)| distance.abs() < reach)
            .map(|(distance, height)| {
                let sharp = if distance >= 0.0 { 1.0 } else { 0.0 };
                height * (share_beyond(&self.grid, distance) - sharp)
            })
            .sum();
        self.profile.light(x, smoothed).map(|light| light as f32)
    }
}

/// A profile along an orientation, in degrees.
pub(super) struct Line<P>(pub f64, pub P);

impl<P: Profile> Area for Line<P> {
    fn linear(&self, size: u32) -> LinearImage {
        let pixels = Pixels::new(&self.1, self.0, size);
        LinearImage::from_fn(size, size, |ix, iy| pixels.light(ix, iy))
    }

    fn codes(&self, size: u32, quantizer: &Quantizer) -> CodeImage {
        if quantizer.bits() != Bits::Eight || self.1.turns().is_none() {
            return quantizer.quantize(&self.linear(size));
        }
        CodeImage { width: size, height: size, samples: Samples::Eight(codes(&self.1, self.0, size, quantizer)) }
    }

    fn profile(&self, size: u32) -> Vec<[f32; 3]> {
        (0..size).map(|i| self.1.light(place(i, size), 0.0).map(|light| light as f32)).collect()
    }
}

/// Returns the 8-bit codes of a window of `size` × `size` pixels. They are exactly the quantized light.
///
/// All pixels at the same distance from the center line are alike, so the profile is divided into runs of positions
/// that are certain to have the same code. Rows are filled run by run; the few pixels between two runs are computed
/// individually.
fn codes(profile: &dyn Profile, orientation_deg: f64, size: u32, quantizer: &Quantizer) -> Vec<u8> {
    let pixels = Pixels::new(profile, orientation_deg, size);
    // An 8-bit code fits.
    let pixel = |ix: usize, iy: usize| quantizer.codes(pixels.light(ix as u32, iy as u32)).map(|code| code as u8);
    let (runs, Grid { cos, sin, .. }) = (pixels.runs(quantizer), pixels.grid);
    let (side, middle) = (size as usize, 0.5 * (f64::from(size) - 1.0));
    let mut codes = vec![[0; 3]; side * side];
    codes.par_chunks_exact_mut(side.max(1)).enumerate().for_each(|(iy, row)| {
        checkpoint();
        if cos == 0.0 {
            return row.fill(pixel(0, iy));
        }
        // Where the center line crosses the row.
        let crossing = middle - (middle - iy as f64) * (sin / cos);
        let mut done = 0;
        for run in &runs[runs.partition_point(|run| run.to + crossing < 0.0)..] {
            // The casts round down, and turn negative values into 0.
            let first = ((run.from + crossing + 1.0) as usize).max(done);
            let end = ((run.to + crossing) as usize + 1).min(side);
            if first >= side {
                break;
            }
            if first < end {
                (done..first).for_each(|ix| row[ix] = pixel(ix, iy));
                row[first..end].fill(run.codes);
                done = end;
            }
        }
        (done..side).for_each(|ix| row[ix] = pixel(ix, iy));
    });
    codes.into_flattened()
}

/// Bound on the rounding error of a position, in window sides. The actual error is far smaller.
const ERROR_X: f64 = 1e-12;
/// Bound on the rounding error of a pixel's position in a row, in pixels.
const ERROR_PX: f64 = 1e-6;
/// Bound on the rounding error of light.
const ERROR_LIGHT: f64 = 1e-12;
/// The search for runs stops at this fraction of a pixel.
const MIN_RUN_PX: f64 = 1.0 / 128.0;

/// A range of positions along a row that all have the same code, in pixels from where the center line crosses the row.
struct Run {
    from: f64,
    to: f64,
    codes: [u8; 3],
}

impl Pixels<'_> {
    /// Returns the runs along a row, from left to right.
    fn runs(&self, quantizer: &Quantizer) -> Vec<Run> {
        let (grid, side) = (&self.grid, f64::from(self.grid.size));
        let mut found = Vec::new();
        // Pixels at an oblique jump mix the light of both sides.
        let mixed = |turn: f64| self.jumps.iter().any(|(at, _)| *at == turn);
        let near = |turn: f64| if mixed(turn) { ERROR_X + half_extent(grid) / side } else { ERROR_X };
        // No pixel is farther than 1 window side from the center line.
        let mut turns: Vec<(f64, f64)> =
            self.profile.turns().into_iter().flatten().map(|(at, _)| (at, near(at))).collect();
        turns.sort_by(|a, b| a.0.total_cmp(&b.0));
        for i in 0..=turns.len() {
            let from = turns[..i].iter().map(|(at, near)| at + near).fold(-1.0, f64::max);
            let to = turns[i..].iter().map(|(at, near)| at - near).fold(1.0, f64::min);
            if from < to {
                self.between([from, to], [from, to].map(|x| self.profile.light(x, 0.0)), quantizer, &mut found);
            }
        }
        let scale = side / grid.cos;
        let error = ERROR_X * scale.abs() + ERROR_PX;
        let along = |run: Run| {
            let (a, b) = (run.from * scale, run.to * scale);
            Run { from: a.min(b) + error, to: a.max(b) - error, codes: run.codes }
        };
        let mut runs: Vec<Run> = found.into_iter().map(along).collect();
        if grid.cos < 0.0 {
            runs.reverse();
        }
        runs
    }

    /// Searches for runs between two positions, from the lower to the higher one; `light` is the light there.
    fn between(&self, positions: [f64; 2], light: [[f64; 3]; 2], quantizer: &Quantizer, runs: &mut Vec<Run>) {
        let ([from, to], [a, b]) = (positions, light);
        let (least, most) = ([0, 1, 2].map(|i| a[i].min(b[i])), [0, 1, 2].map(|i| a[i].max(b[i])));
        // An 8-bit code fits.
        let codes =
            |light: [f64; 3], off: f64| quantizer.codes(light.map(|light| (light + off) as f32)).map(|code| code as u8);
        let lowest = codes(least, -ERROR_LIGHT);
        if lowest == codes(most, ERROR_LIGHT) {
            match runs.last_mut() {
                Some(last) if last.to == from && last.codes == lowest => last.to = to,
                _ => runs.push(Run { from, to, codes: lowest }),
            }
        } else if to - from > MIN_RUN_PX / f64::from(self.grid.size) {
            let middle = 0.5 * (from + to);
            let light_there = self.profile.light(middle, 0.0);
            self.between([from, middle], [light[0], light_there], quantizer, runs);
            self.between([middle, to], [light_there, light[1]], quantizer, runs);
        }
    }
}

/// Returns half the extent of a pixel along the orientation, pixels.
fn half_extent(grid: &Grid) -> f64 {
    (grid.cos.abs() + grid.sin.abs()) / 2.0
}

/// Returns the share of a pixel's area that lies beyond an edge. The pixel's center is `distance` pixels past the edge,
/// or before it if `distance` is negative.
///
/// The distance of a random point in the pixel is the sum of two uniform variables with widths |cos θ| and |sin θ|.
/// This function is its distribution function: a quadratic, then a straight line, then a quadratic.
fn share_beyond(grid: &Grid, distance: f64) -> f64 {
    let (a, b) = (grid.cos.abs(), grid.sin.abs());
    let (outer, inner) = ((a + b) / 2.0, (a - b).abs() / 2.0);
    let d = distance.abs();
    let beyond = if d >= outer {
        1.0
    } else if d <= inner {
        0.5 + d / a.max(b)
    } else {
        1.0 - (outer - d).powi(2) / (2.0 * a * b)
    };
    if distance >= 0.0 { beyond } else { 1.0 - beyond }
}

/// Steps of orientation per degree. They are finer than any picture can show (1e-9° moves the corner of a window 10,000
/// pixels wide by 1e-7 pixels), yet coarse enough that θ and θ + 180, each rounded to f64, are always exactly half a
/// turn of steps apart.
const STEPS_PER_DEG: f64 = 1e9;
const QUARTER: i64 = 90_000_000_000;

/// Returns cos θ and sin θ for θ = `degrees`, rounded to 1e-9°.
///
/// The result for θ + 180° is exactly the negative of the result for θ, and the result for 90° − θ has cosine and sine
/// exactly swapped. Multiples of 90° and 45° are exact.
pub(super) fn cos_sin(degrees: f64) -> (f64, f64) {
    let steps = ((degrees % 360.0) * STEPS_PER_DEG).round() as i64;
    let (quarters, rest) = (steps.div_euclid(QUARTER), steps.rem_euclid(QUARTER));
    let (cos, sin) = first_quarter(rest);
    match quarters.rem_euclid(4) {
        0 => (cos, sin),
        1 => (-sin, cos),
        2 => (-cos, -sin),
        _ => (sin, -cos),
    }
}

/// Returns the cosine and sine for 0 ≤ `steps` < [`QUARTER`].
fn first_quarter(steps: i64) -> (f64, f64) {
    if steps == 0 {
        (1.0, 0.0)
    } else if 2 * steps == QUARTER {
        (FRAC_1_SQRT_2, FRAC_1_SQRT_2)
    } else if 2 * steps < QUARTER {
        let (sin, cos) = (steps as f64 / STEPS_PER_DEG).to_radians().sin_cos();
        (cos, sin)
    } else {
        let (cos, sin) = first_quarter(QUARTER - steps);
        (sin, cos)
    }
}

/// The pixel centers of a square window, and the direction across its ramp.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    /// Number of pixels per side, at least 1.
    pub size: u32,
    pub cos: f64,
    pub sin: f64,
}

impl Grid {
    pub fn new(size: u32, orientation_deg: f64) -> Self {
        let (cos, sin) = cos_sin(orientation_deg);
        Self { size, cos, sin }
    }

    /// Returns whether edges of this orientation run along the pixels.
    pub fn is_along_pixels(&self) -> bool {
        self.cos == 0.0 || self.sin == 0.0
    }

    /// Returns x of Bangay §3.1 in window sides: (p − center)·(cos θ, sin θ), where p is the center of the pixel in
    /// column `ix` and row `iy`.
    ///
    /// The diametrically opposite pixel has exactly −x.
    #[inline]
    pub fn across(&self, ix: u32, iy: u32) -> f64 {
        let n = i64::from(self.size);
        let scale = (2 * n) as f64;
        let right = (2 * i64::from(ix) + 1 - n) as f64 / scale;
        // Row numbers increase downward; y increases upward.
        let up = (n - 1 - 2 * i64::from(iy)) as f64 / scale;
        right * self.cos + up * self.sin
    }
}

/// Returns the position of the center of pixel `i` in a row of `size` pixels, in window sides from the window's center.
pub(super) fn place(i: u32, size: u32) -> f64 {
    (2.0 * f64::from(i) + 1.0 - f64::from(size)) / (2.0 * f64::from(size))
}
