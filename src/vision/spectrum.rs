//! An image's spectrum and the responses of the channels to it.

use std::f64::consts::PI;

use rayon::prelude::*;
use rustfft::num_complex::Complex64;

use super::{
    channel::{Fields, FrequencyChannel, SAMPLES_PER_PERIOD, SLOPE_PERIODS},
    eye::ADAPTATION_DEG,
    fft::{self, next_fast_length, transform, transpose},
    image::{Grid, GridValues, LuminanceImage},
};

/// Highest frequency of the mean light, cycles per degree.
const MEAN_TOP: f64 = 2.0;

/// The spectrum of an image, including its continuation beyond the edges.
pub(super) struct Spectrum {
    /// Spectrum of the light.
    light: Vec<Complex64>,
    /// Spectrum of the light without its smooth part.
    periodic: Vec<Complex64>,
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
    pub(super) fn new(picture: &LuminanceImage) -> Spectrum {
        let side = picture.width.min(picture.height);
        let (columns, rows) = (periodic_length(picture.width, side), periodic_length(picture.height, side));
        let mut both = continued(picture, columns, rows);
        let px_per_deg = picture.px_per_deg;
        transform(&mut both, columns, rows);
        let (across, down) = (columns / 2 + 1, rows / 2 + 1);
        // Pixels are squares, so high frequencies are attenuated.
        let square = |k: usize, n: usize| sinc(k as f64 / n as f64);
        let squares: Vec<f64> = (0..across).map(|k| square(k, columns)).collect();
        // No channel passes the constant part.
        let mut frequencies = vec![Frequency { log: f64::NEG_INFINITY, direction: [0.0; 2] }; across * down];
        frequencies.par_chunks_mut(across).enumerate().for_each(|(row, to)| {
            let fy = row as f64 * px_per_deg / rows as f64;
            for (column, to) in to.iter_mut().enumerate() {
                let fx = column as f64 * px_per_deg / columns as f64;
                let f = fx.hypot(fy);
                if f > 0.0 {
                    *to = Frequency { log: f.ln(), direction: [fx / f, fy / f] };
                }
            }
        });
        let mirrored = |k: usize, n: usize| k.min(n - k);
        let turns = |n: usize| (0..n).map(|k| 2.0 * (2.0 * PI * k as f64 / n as f64).cos()).collect::<Vec<_>>();
        let (across, down) = (turns(columns), turns(rows));
        let [mut light, mut periodic] = [0; 2].map(|_| vec![Complex64::default(); columns * rows]);
        let out = light.par_chunks_mut(columns).zip(periodic.par_chunks_mut(columns));
        out.enumerate().for_each(|(row, (light, periodic))| {
            let square = square(mirrored(row, rows), rows);
            let opposite = &both[(rows - row) % rows * columns..][..columns];
            for column in 0..columns {
                let (a, b) = (both[row * columns + column], opposite[(columns - column) % columns].conj());
                let square = square * squares[mirrored(column, columns)];
                // The transforms of the real part and of the imaginary part.
                light[column] = 0.5 * square * (a + b);
                let jumps = Complex64::new(0.0, -0.5 * square) * (a - b);
                let curvature = across[column] + down[row] - 4.0;
                let smooth = if row + column > 0 { jumps / curvature } else { Complex64::default() };
                periodic[column] = light[column] - smooth;
            }
        });
        Spectrum { light, periodic, columns, rows, size: [picture.width, picture.height], px_per_deg, frequencies }
    }

    /// Returns a grid over the whole periodic image with enough samples for frequencies up to `top`.
    fn grid(&self, top: f64) -> Grid {
        let fit = |n: usize| next_fast_length(((2.0 * top * n as f64 / self.px_per_deg).ceil() as usize).max(8)).min(n);
        let (columns, rows) = (fit(self.columns), fit(self.rows));
        let step = [self.columns as f64 / columns as f64, self.rows as f64 / rows as f64];
        let first = |n: usize, side: usize, step: f64| (side as f64 - (n as f64 - 1.0) * step) / 2.0;
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

    /// Calls `value` for each frequency in the transform of `grid` with its row, its column, its index there, its index
    /// in the whole spectrum, and the factor that shifts the first place to that of the grid and normalizes.
    fn each(&self, grid: &Grid, mut value: impl FnMut(&Place, &Place, usize, usize, Complex64)) {
        let across = self.places(grid.columns, self.columns, grid.first[0]);
        let scale = 1.0 / (self.columns * self.rows) as f64;
        for row in &self.places(grid.rows, self.rows, grid.first[1]) {
            let shift = row.shift * scale;
            for column in &across {
                let (to, from) = (row.to * grid.columns + column.to, row.from * self.columns + column.from);
                value(row, column, to, from, shift * column.shift);
            }
        }
    }

    /// Computes a channel's responses with the Riesz transform (Felsberg & Sommer 2001, IEEE Trans. Signal Process.
    /// 49:3136). The odd part is a vector: the response of the quadrature pair oriented across the local structure. All
    /// orientations are therefore treated alike, and none has to be sampled.
    pub(super) fn respond(&self, channel: FrequencyChannel) -> Fields {
        let grid = self.grid(SAMPLES_PER_PERIOD / 2.0 * channel.frequency);
        let whole = self.columns / 2 + 1;
        let coarse = channel.octave_below();
        let logs = [channel, coarse].map(|channel| channel.frequency.ln());
        // e^(−½(2πσν)²), where σ is given in periods of the channel.
        let blur = -0.5 * (2.0 * PI * SLOPE_PERIODS / channel.frequency).powi(2);
        let [mut even, mut odd, mut straight, mut slope] =
            [0; 4].map(|_| vec![Complex64::default(); grid.columns * grid.rows]);
        self.each(&grid, |row, column, to, from, shift| {
            let frequency = &self.frequencies[row.size * whole + column.size];
            if frequency.log == f64::NEG_INFINITY {
                return;
            }
            let value = self.periodic[from] * shift;
            let of = |k: usize, channel: FrequencyChannel| value * channel.passes_log(frequency.log - logs[k]);
            let (own, coarse) = (of(0, channel), of(1, coarse));
            let [right, down] = [column.sign * frequency.direction[0], row.sign * frequency.direction[1]];
            let direction = Complex64::new(right, down);
            // A real field in the real part plus i times another.
            even[to] = own + coarse * Complex64::i();
            odd[to] = own * direction * -Complex64::i();
            straight[to] = own * direction * direction;
            let length = frequency.log.exp();
            slope[to] =
                self.light[from] * shift * direction * Complex64::i() * (length * (blur * length * length).exp());
        });
        let cropped = self.cropped(&grid);
        let [even, odd, straight, slope] = [even, odd, straight, slope].map(|field| inverse(field, &grid, &cropped));
        Fields { grid: cropped.grid, even, odd, straight, slope }
    }

    /// Computes the mean light to which the eye is adapted.
    pub(super) fn mean(&self) -> GridValues {
        let grid = self.grid(MEAN_TOP);
        let passes = |k: usize, whole: usize| {
            let f = k as f64 * self.px_per_deg / whole as f64;
            (-2.0 * (PI * ADAPTATION_DEG * f).powi(2)).exp()
        };
        let [across, down] = [(grid.columns, self.columns), (grid.rows, self.rows)]
            .map(|(n, whole)| (0..=n / 2).map(|k| passes(k, whole)).collect::<Vec<_>>());
        let mut mean = vec![Complex64::default(); grid.columns * grid.rows];
        self.each(&grid, |row, column, to, from, shift| {
            mean[to] = self.light[from] * shift * (across[column.size] * down[row.size]);
        });
        let cropped = self.cropped(&grid);
        let values = inverse(mean, &grid, &cropped).into_iter().map(|value| value.re).collect();
        GridValues { grid: cropped.grid, values }
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

/// Returns the length to which a side of `n` values is continued. `side` is the shorter side: it has room for at least 1.4
/// periods of the coarsest channel, so that at least a third of one is added.
pub(super) fn periodic_length(n: usize, side: usize) -> usize {
    next_fast_length(n + (side / 4).max(8))
}

fn sinc(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) }
}

/// Continues the image beyond its edges by point reflection, so that light and slope continue; repeating the last pixels
/// instead would bend every oblique ramp. Halfway to the opposite edge, the light jumps. The imaginary part is the second
/// difference of the smooth function that has the same jumps (Moisan 2011, J. Math. Imaging Vis. 39:161): without it, the
/// image is periodic and has no jumps.
fn continued(picture: &LuminanceImage, columns: usize, rows: usize) -> Vec<Complex64> {
    let (width, height) = (picture.width, picture.height);
    let mut values = vec![Complex64::default(); columns * rows];
    for (y, row) in picture.light.chunks_exact(width).enumerate() {
        let to = &mut values[y * columns..][..columns];
        for (value, light) in to.iter_mut().zip(row) {
            value.re = *light;
        }
        for k in 0..columns - width {
            to[width + k].re = reflected(k, columns - width, width, |x| row[x]);
        }
    }
    for x in 0..columns {
        for k in 0..rows - height {
            values[(height + k) * columns + x].re = reflected(k, rows - height, height, |y| values[y * columns + x].re);
        }
    }
    let mut jump = |before: usize, after: usize| {
        let jump = values[after].re - values[before].re;
        values[before].im += jump;
        values[after].im -= jump;
    };
    let seam = |n: usize, whole: usize| n + (whole - n) / 2;
    let (x, y) = (seam(width, columns), seam(height, rows));
    (0..rows).for_each(|row| jump(row * columns + x - 1, row * columns + x));
    (0..columns).for_each(|column| jump((y - 1) * columns + column, y * columns + column));
    values
}

/// Returns value `k` of the `gap` values between the end of `n` values and their next repetition.
fn reflected(k: usize, gap: usize, n: usize, value: impl Fn(usize) -> f64) -> f64 {
    if k < gap / 2 {
        2.0 * value(n - 1) - value((n - 1).saturating_sub(k + 1))
    } else {
        2.0 * value(0) - value((gap - k).min(n - 1))
    }
}

/// Returns the part within `crop` of the inverse transform of `transformed`, which lies on `grid`.
fn inverse(mut transformed: Vec<Complex64>, grid: &Grid, crop: &Crop) -> Vec<Complex64> {
    fft::inverse(grid.columns).process(&mut transformed);
    let wanted = crop.grid.columns;
    let mut turned = vec![Complex64::default(); wanted * grid.rows];
    transpose(&transformed, &mut turned, grid.columns, crop.left, [wanted, grid.rows]);
    fft::inverse(grid.rows).process(&mut turned);
    let mut values = vec![Complex64::default(); wanted * crop.grid.rows];
    transpose(&turned, &mut values, grid.rows, crop.top, [crop.grid.rows, wanted]);
    values
}
