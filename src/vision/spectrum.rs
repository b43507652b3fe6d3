//! An image's spectrum and the responses of the channels to it.

use std::f64::consts::PI;

use rayon::prelude::*;
use rustfft::num_complex::Complex64;

use super::{
    eye::{ADAPTATION_DEG, Channel, Eye},
    fft::{self, next_fast_length},
    image::{Field, Grid, LuminanceImage},
};

/// A channel is computed up to at least this multiple of its preferred frequency, beyond which it passes less than a
/// hundredth.
const REACH: f64 = 4.0;
/// The multiple for coarse channels. It is higher because their energy has flat peaks, which cannot be located exactly
/// with few samples.
const COARSE_REACH: f64 = 8.0;
/// [`COARSE_REACH`] applies only up to this frequency, cycles per degree. Beyond it, the higher multiple would take
/// most of the time and change little.
const COARSE_TOP: f64 = 10.0;
/// Highest frequency of the mean light, cycles per degree.
const MEAN_TOP: f64 = 2.0;

/// A channel's responses on a grid.
pub(super) struct Responses {
    pub(super) grid: Grid,
    pub(super) even: Vec<f64>,
    /// The rightward part in the real component, and the downward part in the imaginary component.
    pub(super) odd: Vec<Complex64>,
    /// Even² + odd².
    pub(super) energy: Vec<f64>,
}

/// The spectrum of an image, including its continuation beyond the edges.
pub(super) struct Spectrum {
    /// Spectrum of the light, from which the mean light is computed.
    light: Vec<Complex64>,
    /// Spectrum of the eye's response.
    response: Vec<Complex64>,
    columns: usize,
    rows: usize,
    /// Width and height of the image, pixels.
    size: [usize; 2],
    px_per_deg: f64,
    /// The nonnegative frequencies, row by row. The negative frequencies mirror them.
    frequencies: Vec<Frequency>,
}

/// One frequency of a spectrum.
#[derive(Clone, Copy)]
struct Frequency {
    /// Natural logarithm of the frequency in cycles per degree.
    log: f64,
    /// Unit vector `[right, down]` of its direction.
    direction: [f64; 2],
}

/// A frequency on one axis of a channel's transform.
struct Place {
    /// Index in the transform.
    to: usize,
    /// Index in the whole spectrum.
    from: usize,
    /// Index in [`Spectrum::frequencies`].
    size: usize,
    /// 1 for frequencies that point to the right or down, −1 for those that point to the left or up.
    sign: f64,
    /// Phase factor that moves the first value to the grid's first place.
    shift: Complex64,
}

impl Spectrum {
    pub(super) fn new(picture: &LuminanceImage, eye: &Eye) -> Spectrum {
        let side = picture.width.min(picture.height);
        // At least half a period of the coarsest channel, since the shorter side has room for at least two of its
        // periods.
        let beyond = (side / 4).max(8);
        let (columns, rows) = (next_fast_length(picture.width + beyond), next_fast_length(picture.height + beyond));
        let mut light = make_periodic(picture, columns, rows);
        let px_per_deg = picture.px_per_deg;
        transform(&mut light, columns, rows);
        let (across, down) = (columns / 2 + 1, rows / 2 + 1);
        // Pixels are squares, so high frequencies are attenuated.
        let square = |k: usize, n: usize| sinc(k as f64 / n as f64);
        let squares: Vec<f64> = (0..across).map(|k| square(k, columns)).collect();
        // No channel passes the constant part.
        let mut frequencies = vec![Frequency { log: f64::NEG_INFINITY, direction: [0.0; 2] }; across * down];
        let mut sensitivity = vec![0.0; across * down];
        frequencies.par_chunks_mut(across).zip(sensitivity.par_chunks_mut(across)).enumerate().for_each(
            |(row, (to, sensitivity))| {
                let fy = row as f64 * px_per_deg / rows as f64;
                for (column, (to, sensitivity)) in to.iter_mut().zip(sensitivity).enumerate() {
                    let fx = column as f64 * px_per_deg / columns as f64;
                    let f = fx.hypot(fy);
                    if f > 0.0 {
                        *to = Frequency { log: f.ln(), direction: [fx / f, fy / f] };
                        *sensitivity = eye.sensitivity(f) * squares[column] * square(row, rows);
                    }
                }
            },
        );
        let mirrored = |k: usize, n: usize| k.min(n - k);
        let gain = |i: usize| sensitivity[mirrored(i / columns, rows) * across + mirrored(i % columns, columns)];
        let response = light.par_iter().enumerate().map(|(i, value)| value * gain(i)).collect();
        Spectrum { light, response, columns, rows, size: [picture.width, picture.height], px_per_deg, frequencies }
    }

    /// Returns a grid over the whole periodic image with enough samples for frequencies up to `top`.
    fn grid(&self, top: f64) -> Grid {
        let fit = |n: usize| next_fast_length(((2.0 * top * n as f64 / self.px_per_deg).ceil() as usize).max(8)).min(n);
        let (columns, rows) = (fit(self.columns), fit(self.rows));
        let step = [self.columns as f64 / columns as f64, self.rows as f64 / rows as f64];
        let first = |n: usize, side: usize, step: f64| side as f64 / 2.0 - (n / 2) as f64 * step + step / 2.0;
        let first = [first(columns, self.size[0], step[0]), first(rows, self.size[1], step[1])];
        Grid { columns, rows, first, step }
    }

    /// Returns the frequencies of a transform of `n` values along an axis of `whole` values. If `n` is even, the
    /// highest frequency is left out.
    fn places(&self, n: usize, whole: usize, first: f64) -> Vec<Place> {
        let place = |k: usize| {
            let (size, sign) = if 2 * k < n { (k, 1.0) } else { (n - k, -1.0) };
            let from = if sign > 0.0 { size } else { whole - size };
            // Positions count from the middle of the first pixel.
            let turns = sign * size as f64 * (first - 0.5) / whole as f64;
            Place { to: k, from, size, sign, shift: Complex64::cis(2.0 * PI * turns) }
        };
        (0..n).filter(|k| 2 * k != n).map(place).collect()
    }

    /// Calls `value` for each frequency in the transform of `grid` with its row, its column, its index, and the value
    /// of the spectrum `of`, shifted to the grid's first place.
    fn each(&self, grid: &Grid, of: &[Complex64], mut value: impl FnMut(&Place, &Place, usize, Complex64)) {
        let across = self.places(grid.columns, self.columns, grid.first[0]);
        for row in &self.places(grid.rows, self.rows, grid.first[1]) {
            let of = &of[row.from * self.columns..][..self.columns];
            for column in &across {
                let moved = of[column.from] * (row.shift * column.shift);
                value(row, column, row.to * grid.columns + column.to, moved);
            }
        }
    }

    /// Computes a channel's even and odd responses with the monogenic signal (Felsberg & Sommer 2001, IEEE Trans.
    /// Signal Process. 49:3136). Its odd part is a vector `[right, down]`: the response of the quadrature pair oriented
    /// across the local structure. All orientations are therefore treated alike, and none has to be sampled.
    pub(super) fn respond(&self, channel: Channel) -> Responses {
        let own = channel.frequency;
        let grid = self.grid((COARSE_REACH * own).min(COARSE_TOP).max(REACH * own));
        let (log, whole) = (own.ln(), self.columns / 2 + 1);
        let scale = 1.0 / (self.columns * self.rows) as f64;
        let [mut even, mut odd] = [0; 2].map(|_| vec![Complex64::default(); grid.columns * grid.rows]);
        self.each(&grid, &self.response, |row, column, to, value| {
            let frequency = &self.frequencies[row.size * whole + column.size];
            let value = value * (channel.passes_log(frequency.log - log) * scale);
            even[to] = value;
            let [right, down] = [column.sign * frequency.direction[0], row.sign * frequency.direction[1]];
            // Multiplied by down − i·right.
            odd[to] = Complex64::new(value.re * down + value.im * right, value.im * down - value.re * right);
        });
        let cropped = self.cropped(&grid);
        let even = inverse(even, &grid, &cropped, |value| value.re);
        let odd: Vec<Complex64> = inverse(odd, &grid, &cropped, |value| value);
        let energy = even.iter().zip(&odd).map(|(even, odd)| even * even + odd.norm_sqr()).collect();
        Responses { grid: cropped.grid, even, odd, energy }
    }

    /// Computes the mean light to which the eye is adapted.
    pub(super) fn mean(&self) -> Field {
        let grid = self.grid(MEAN_TOP);
        let scale = 1.0 / (self.columns * self.rows) as f64;
        let passes = |k: usize, whole: usize| {
            let f = k as f64 * self.px_per_deg / whole as f64;
            (-2.0 * (PI * ADAPTATION_DEG * f).powi(2)).exp()
        };
        let [across, down] = [(grid.columns, self.columns), (grid.rows, self.rows)]
            .map(|(n, whole)| (0..=n / 2).map(|k| passes(k, whole)).collect::<Vec<_>>());
        let mut mean = vec![Complex64::default(); grid.columns * grid.rows];
        self.each(&grid, &self.light, |row, column, to, value| {
            mean[to] = value * (across[column.size] * down[row.size] * scale);
        });
        let cropped = self.cropped(&grid);
        let values = inverse(mean, &grid, &cropped, |value| value.re);
        Field { grid: cropped.grid, values }
    }

    /// Returns the part of a grid that covers the image, up to and including the first value beyond each edge.
    fn cropped(&self, grid: &Grid) -> Crop {
        let range = |axis: usize, n: usize| {
            let index = |place: f64| (place - grid.first[axis]) / grid.step[axis];
            let first = index(0.0).floor().max(0.0) as usize;
            let last = (index(self.size[axis] as f64).ceil() as usize).min(n - 1);
            (first, last + 1 - first)
        };
        let ((left, columns), (top, rows)) = (range(0, grid.columns), range(1, grid.rows));
        Crop { left, top, grid: Grid { columns, rows, first: grid.place(left, top), step: grid.step } }
    }
}

/// Part of a grid.
struct Crop {
    left: usize,
    top: usize,
    grid: Grid,
}

fn sinc(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) }
}

/// Makes the image periodic. It is continued beyond its edges by point reflection and faded from one side to the other,
/// so that light and slope continue. Repeating the last pixels instead would bend every oblique ramp.
fn make_periodic(picture: &LuminanceImage, columns: usize, rows: usize) -> Vec<Complex64> {
    let (width, height) = (picture.width, picture.height);
    let mut values = vec![Complex64::default(); columns * rows];
    for (y, row) in picture.light.chunks_exact(width).enumerate() {
        let to = &mut values[y * columns..][..columns];
        for (value, light) in to.iter_mut().zip(row) {
            value.re = *light;
        }
        for k in 0..columns - width {
            to[width + k].re = padding_value(k, columns - width, width, |x| row[x]);
        }
    }
    for x in 0..columns {
        for k in 0..rows - height {
            values[(height + k) * columns + x].re =
                padding_value(k, rows - height, height, |y| values[y * columns + x].re);
        }
    }
    values
}

/// Returns value `k` of the `gap` values that lead from the end of `n` values back to their beginning.
fn padding_value(k: usize, gap: usize, n: usize, value: impl Fn(usize) -> f64) -> f64 {
    let t = (k + 1) as f64 / (gap + 1) as f64;
    let fade = t * t * (3.0 - 2.0 * t);
    let after = 2.0 * value(n - 1) - value((n - 1).saturating_sub(k + 1));
    let before = 2.0 * value(0) - value((gap - k).min(n - 1));
    after + (before - after) * fade
}

/// Performs an unnormalized two-dimensional Fourier transform in place.
fn transform(values: &mut [Complex64], columns: usize, rows: usize) {
    let (across, down) = (fft::forward(columns), fft::forward(rows));
    values.par_chunks_exact_mut(columns).for_each(|row| across.process(row));
    let mut turned = vec![Complex64::default(); values.len()];
    transpose(values, &mut turned, columns, 0, [columns, rows], |value| value);
    turned.par_chunks_exact_mut(rows).for_each(|column| down.process(column));
    transpose(&turned, values, rows, 0, [rows, columns], |value| value);
}

/// Returns the part within `crop` of the inverse transform of `transformed`, which lies on `grid`.
fn inverse<T: Copy>(
    mut transformed: Vec<Complex64>,
    grid: &Grid,
    crop: &Crop,
    value: impl Fn(Complex64) -> T,
) -> Vec<T> {
    fft::inverse(grid.columns).process(&mut transformed);
    let wanted = crop.grid.columns;
    let mut turned = vec![Complex64::default(); wanted * grid.rows];
    transpose(&transformed, &mut turned, grid.columns, crop.left, [wanted, grid.rows], |value| value);
    fft::inverse(grid.rows).process(&mut turned);
    let mut values = vec![value(Complex64::default()); wanted * crop.grid.rows];
    transpose(&turned, &mut values, grid.rows, crop.top, [crop.grid.rows, wanted], value);
    values
}

/// Turns columns into rows. It takes the `columns` that start at `left` from rows that are `stride` long, and works in
/// tiles that fit in the processor's cache.
fn transpose<T>(
    from: &[Complex64],
    to: &mut [T],
    stride: usize,
    left: usize,
    [columns, rows]: [usize; 2],
    value: impl Fn(Complex64) -> T,
) {
    const TILE: usize = 16;
    for top in (0..rows).step_by(TILE) {
        for first in (0..columns).step_by(TILE) {
            for y in top..(top + TILE).min(rows) {
                for x in first..(first + TILE).min(columns) {
                    to[x * rows + y] = value(from[y * stride + left + x]);
                }
            }
        }
    }
}
