//! How stimuli are drawn. Most vary in one direction only: their profile gives the light of every pixel, and its code.
//!
//! An edge that runs along the pixels is perfectly sharp. An oblique edge that a profile lists in `jumps` is
//! anti-aliased in linear light: each pixel mixes both sides in proportion to its area on each side. A Mach band lists
//! none: its step, the limit of narrow ramps, stays as sharp as the pixels at every orientation.

use std::f64::consts::FRAC_1_SQRT_2;

use crate::light::{LinearImage, Quantizer};
use crate::system::checkpoint;

/// A stimulus that varies in both directions and is drawn pixel by pixel.
pub(super) trait Area {
    /// Returns the light of a window of `size` × `size` pixels.
    fn linear(&self, size: u32) -> LinearImage;

    /// Returns the light at the centers of a row of `size` pixels through the middle, along the orientation.
    fn profile(&self, size: u32) -> Vec<[f32; 3]>;
}

/// Light that varies along one direction only. Positions are measured from the center line in window sides, positive in
/// the direction of the orientation.
pub(super) trait Profile {
    /// Returns the light at `x`; `added` is added to the luminance. At a jump, this is the value on the far side.
    fn light(&self, x: f64, added: f64) -> [f64; 3];

    /// Returns the positions where the luminance jumps, and the height of each jump.
    fn jumps(&self) -> Vec<(f64, f64)> {
        Vec::new()
    }

    /// Returns, in any order, the positions where a channel may turn from rising to falling or vice versa, or where the
    /// light may jump. Between neighboring positions, every channel is monotonic and continuous.
    fn turning_points(&self) -> Vec<f64>;

    /// Returns whether the light is constant to the last bit between the turning points on either side of `x`.
    fn is_level(&self, x: f64) -> bool;

    /// Returns whether the turning points are known. If they are not, as in the colors between two hues, every pixel is
    /// computed.
    fn is_plain(&self) -> bool {
        true
    }
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
        let jumps = if grid.is_along_pixels() { Vec::new() } else { profile.jumps() };
        Self { profile, grid, jumps }
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

/// Returns the light of a window of `size` × `size` pixels.
pub(super) fn linear(profile: &dyn Profile, orientation_deg: f64, size: u32) -> LinearImage {
    let pixels = Pixels::new(profile, orientation_deg, size);
    LinearImage::from_fn(size, size, |ix, iy| pixels.light(ix, iy))
}

/// Returns the 8-bit codes of a window of `size` × `size` pixels. They are exactly the quantized light of [`linear`].
///
/// All pixels at the same distance from the center line are alike, so the profile is divided into runs of positions
/// that are certain to have the same code. Rows are filled run by run; the few pixels between two runs are computed
/// individually.
pub(super) fn codes(profile: &dyn Profile, orientation_deg: f64, size: u32, quantizer: &Quantizer) -> Vec<u8> {
    let pixels = Pixels::new(profile, orientation_deg, size);
    // An 8-bit code fits.
    let pixel = |ix, iy| quantizer.codes(pixels.light(ix, iy)).map(|code| code as u8);
    if size == 0 {
        return Vec::new();
    }
    let codes = if pixels.grid.sin == 0.0 {
        (0..size).map(|ix| pixel(ix, 0)).collect::<Vec<_>>().repeat(size as usize)
    } else if pixels.grid.cos == 0.0 {
        let mut codes = Vec::with_capacity(size as usize * size as usize);
        (0..size).for_each(|iy| codes.extend_from_slice(&[pixel(0, iy)].repeat(size as usize)));
        codes
    } else {
        Runs::new(&pixels, quantizer).draw(size, pixel)
    };
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
/// The number of templates: the center line crosses a row in one of this many intervals between two pixels.
const PHASES: usize = 48;
/// The largest shift from row to row, in pixels, for which templates are made.
const MAX_SHIFT_PX: f64 = 4.0;

/// A range of positions along a row that all have the same code.
struct Run {
    from: f64,
    to: f64,
    codes: [u8; 3],
}

/// The runs along a row, from left to right. Their positions are in pixels from the point where the center line crosses
/// the row.
struct Runs {
    runs: Vec<Run>,
    middle: f64,
    /// Shift from one row to the next, pixels.
    tan: f64,
}

impl Runs {
    fn new(pixels: &Pixels<'_>, quantizer: &Quantizer) -> Self {
        let grid = &pixels.grid;
        let side = f64::from(grid.size);
        let mut search =
            Search { profile: pixels.profile, quantizer, shortest: MIN_RUN_PX / side, level: false, runs: Vec::new() };
        // Pixels at an oblique jump mix the light of both sides.
        let mixed = |turn: f64| pixels.jumps.iter().any(|(at, _)| *at == turn);
        let near = |turn: f64| if mixed(turn) { ERROR_X + half_extent(grid) / side } else { ERROR_X };
        // No pixel is farther than 1 window side from the center line.
        let mut turning_points: Vec<(f64, f64)> =
            pixels.profile.turning_points().into_iter().map(|at| (at, near(at))).collect();
        turning_points.sort_by(|a, b| a.0.total_cmp(&b.0));
        for i in 0..=turning_points.len() {
            let from = turning_points[..i].iter().map(|(at, near)| at + near).fold(-1.0, f64::max);
            let to = turning_points[i..].iter().map(|(at, near)| at - near).fold(1.0, f64::min);
            search.level = pixels.profile.is_level(0.5 * (from + to));
            if from < to {
                search.between([from, to], [from, to].map(|x| pixels.profile.light(x, 0.0)));
            }
        }
        let scale = side / grid.cos;
        let error = ERROR_X * scale.abs() + ERROR_PX;
        let along = |run: Run| {
            let (a, b) = (run.from * scale, run.to * scale);
            Run { from: a.min(b) + error, to: a.max(b) - error, codes: run.codes }
        };
        let mut runs: Vec<Run> = search.runs.into_iter().map(along).collect();
        if grid.cos < 0.0 {
            runs.reverse();
        }
        Self { runs, middle: 0.5 * f64::from(grid.size - 1), tan: grid.sin / grid.cos }
    }

    /// Returns the codes of a window of `size` rows. `pixel` computes the pixels that are not certain to lie in a run.
    ///
    /// If the center line crosses rows at nearly the same place between two pixels, the rows are shifted copies of one
    /// template.
    fn draw(&self, size: u32, pixel: impl Fn(u32, u32) -> [u8; 3]) -> Vec<[u8; 3]> {
        let width = size as usize;
        let mut codes = Vec::with_capacity(width * width);
        let mut templates: [Option<Template>; PHASES] = [const { None }; PHASES];
        let reach = self.middle * self.tan.abs();
        for iy in 0..size {
            checkpoint();
            let shift = self.middle - (self.middle - f64::from(iy)) * self.tan;
            let of_row;
            let (template, start) = if self.tan.abs() > MAX_SHIFT_PX {
                // The rows are shifted so far that a shared template would be longer than all rows together. A row
                // crosses only a few runs, which are quickly filled.
                of_row = self.template(shift, 0.0, width);
                (&of_row, 0)
            } else {
                let phase = ((shift - shift.floor()) * PHASES as f64) as usize;
                // A template starts where the row that is shifted farthest to the right starts.
                let first = (self.middle + reach).floor();
                let template = templates[phase].get_or_insert_with(|| {
                    let length = width + 2 * reach.ceil() as usize + 1;
                    self.template(first + phase as f64 / PHASES as f64, 1.0 / PHASES as f64, length)
                });
                (&*template, (first - shift.floor()) as usize)
            };
            codes.extend_from_slice(&template.codes[start..start + width]);
            let row = &mut codes[iy as usize * width..];
            for at in &template.open[template.open.partition_point(|at| *at < start)..] {
                let Some(to) = row.get_mut(at - start) else { break };
                *to = pixel((at - start) as u32, iy);
            }
        }
        codes
    }

    /// Returns a row of `length` pixels, filled where a pixel keeps its code at every shift of the row from `shift` to
    /// `shift + slack`.
    fn template(&self, shift: f64, slack: f64, length: usize) -> Template {
        let (mut codes, mut open, mut done) = (vec![[0; 3]; length], Vec::new(), 0);
        for run in &self.runs[self.runs.partition_point(|run| run.to + shift < 0.0)..] {
            // The cast turns negative values into 0.
            let first = ((run.from + shift + slack).ceil() as usize).max(done);
            let end = ((run.to + shift).floor() as usize + 1).min(length);
            if first >= length {
                break;
            }
            if first < end {
                open.extend(done..first);
                // Copying four pixels takes no longer than copying one.
                let (blocks, rest) = codes[first..end].as_chunks_mut::<4>();
                blocks.fill([run.codes; 4]);
                rest.fill(run.codes);
                done = end;
            }
        }
        open.extend(done..length);
        Template { codes, open }
    }
}

/// A row that contains every row of its interval, each shifted by whole pixels.
struct Template {
    codes: Vec<[u8; 3]>,
    /// The pixels whose code depends on where in the interval the center line crosses; they are not filled.
    open: Vec<usize>,
}

/// Searches for runs from lower to higher positions.
struct Search<'a> {
    profile: &'a dyn Profile,
    quantizer: &'a Quantizer,
    shortest: f64,
    level: bool,
    runs: Vec<Run>,
}

impl Search<'_> {
    /// Searches between two positions; `light` is the light there.
    fn between(&mut self, positions: [f64; 2], light: [[f64; 3]; 2]) {
        let ([from, to], [a, b]) = (positions, light);
        let (least, most) = ([0, 1, 2].map(|i| a[i].min(b[i])), [0, 1, 2].map(|i| a[i].max(b[i])));
        let error = if self.level { 0.0 } else { ERROR_LIGHT };
        // An 8-bit code fits.
        let codes = |light: [f64; 3], off: f64| {
            self.quantizer.codes(light.map(|light| (light + off) as f32)).map(|code| code as u8)
        };
        let lowest = codes(least, -error);
        if lowest == codes(most, error) {
            match self.runs.last_mut() {
                Some(last) if last.to == from && last.codes == lowest => last.to = to,
                _ => self.runs.push(Run { from, to, codes: lowest }),
            }
        } else if to - from > self.shortest {
            let middle = 0.5 * (from + to);
            let light_there = self.profile.light(middle, 0.0);
            self.between([from, middle], [light[0], light_there]);
            self.between([middle, to], [light_there, light[1]]);
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
pub fn place(i: u32, size: u32) -> f64 {
    (2.0 * f64::from(i) + 1.0 - f64::from(size)) / (2.0 * f64::from(size))
}
