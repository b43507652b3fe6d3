//! Applies filters as large as the image, in the frequency domain.

use std::fmt;
use std::sync::Arc;

use rayon::prelude::*;
use rustfft::Fft;
use rustfft::num_complex::Complex;

use machband::vision::fft::{self, smooth};

/// Filters of one size, ready for images of the same size.
pub struct Bank {
    width: usize,
    height: usize,
    plane: Plane,
    /// Spectra of the filters, two in each: one real, one imaginary.
    pairs: Vec<Vec<Complex<f64>>>,
    count: usize,
}

impl Bank {
    /// The bank of these filters, each with `width` × `height` samples, row by row.
    pub fn new(kernels: &[Vec<f64>], width: usize, height: usize) -> Self {
        // Room for the image and for half a filter on either side of it.
        let plane = Plane::new(smooth(2 * width - 1), smooth(2 * height - 1));
        let pairs = kernels
            .chunks(2)
            .map(|pair| {
                let none = Vec::new();
                let second = pair.get(1).unwrap_or(&none);
                plane.spectrum(height, |row, line| {
                    for (column, value) in line.iter_mut().enumerate().take(width) {
                        let at = row * width + column;
                        *value = Complex::new(pair[0][at], second.get(at).copied().unwrap_or(0.0));
                    }
                })
            })
            .collect();
        Self { width, height, plane, pairs, count: kernels.len() }
    }

    /// Number of pixels of an image.
    pub fn len(&self) -> usize {
        self.width * self.height
    }

    /// The response of every filter to the image. Beyond its border, the light is `outside`, or that of the nearest pixel if
    /// `outside` is `None`. Filters must have no response to uniform light.
    pub fn filtered(&self, light: &[f32], outside: Option<f64>) -> Vec<Vec<f64>> {
        let (left, top) = (before(self.width), before(self.height));
        // Subtracting the mean or the surround reduces rounding errors and does not change the response.
        let level = outside.unwrap_or_else(|| mean(light));
        let spectrum = self.plane.spectrum(2 * self.height - 1, |row, line| {
            for (column, value) in line.iter_mut().enumerate().take(2 * self.width - 1) {
                let inside = (top..top + self.height).contains(&row) && (left..left + self.width).contains(&column);
                if inside || outside.is_none() {
                    let y = row.saturating_sub(top).min(self.height - 1);
                    let x = column.saturating_sub(left).min(self.width - 1);
                    *value = Complex::from(f64::from(light[y * self.width + x]) - level);
                }
            }
        });
        let through = |pair: &Vec<Complex<f64>>| {
            let product = pair.par_iter().zip(&spectrum).map(|(a, b)| a * b).collect();
            let values = self.plane.inverse(product, self.height - 1, self.height, self.width - 1, self.width);
            [values.iter().map(|v| v.re).collect(), values.iter().map(|v| v.im).collect()]
        };
        // Pairs are processed one after the other: each uses all threads, and the memory for one pair is enough.
        self.pairs.iter().flat_map(through).take(self.count).collect()
    }
}

impl fmt::Debug for Bank {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Bank").field("width", &self.width).field("height", &self.height).finish_non_exhaustive()
    }
}

/// Samples of surround before a side of `side` pixels: half a filter, minus one if its center is between two pixels.
fn before(side: usize) -> usize {
    side - 1 - side / 2
}

fn mean(light: &[f32]) -> f64 {
    light.iter().map(|value| f64::from(*value)).sum::<f64>() / light.len().max(1) as f64
}

/// The transforms of a plane of samples. A spectrum is stored column by column.
struct Plane {
    width: usize,
    height: usize,
    rows: [Arc<dyn Fft<f64>>; 2],
    columns: [Arc<dyn Fft<f64>>; 2],
}

impl Plane {
    fn new(width: usize, height: usize) -> Self {
        let both = |size| [fft::forward(size), fft::inverse(size)];
        let (rows, columns) = (both(width), both(height));
        Self { width, height, rows, columns }
    }

    /// The spectrum of a plane. `fill` writes the first `used` rows; all other values are zero.
    fn spectrum(&self, used: usize, fill: impl Fn(usize, &mut [Complex<f64>]) + Sync) -> Vec<Complex<f64>> {
        let mut lines = vec![Complex::default(); self.width * used];
        lines.par_chunks_mut(self.width).enumerate().for_each_init(
            || scratch(&self.rows[0]),
            |scratch, (row, line)| {
                fill(row, line);
                self.rows[0].process_with_scratch(line, scratch);
            },
        );
        let mut columns = transposed(&lines, self.width, 0..self.width, self.height);
        transform(&self.columns[0], &mut columns, self.height);
        columns
    }

    /// The samples of the plane with this spectrum, in `height` rows from `top` and `width` columns from `left`.
    fn inverse(
        &self,
        mut spectrum: Vec<Complex<f64>>,
        top: usize,
        height: usize,
        left: usize,
        width: usize,
    ) -> Vec<Complex<f64>> {
        transform(&self.columns[1], &mut spectrum, self.height);
        let mut lines = transposed(&spectrum, self.height, top..top + height, self.width);
        transform(&self.rows[1], &mut lines, self.width);
        let scale = 1.0 / (self.width * self.height) as f64;
        lines.chunks(self.width).flat_map(|line| line[left..left + width].iter().map(|value| value * scale)).collect()
    }
}

/// Transforms every run of `len` values.
fn transform(fft: &Arc<dyn Fft<f64>>, values: &mut [Complex<f64>], len: usize) {
    values.par_chunks_mut(len).for_each_init(|| scratch(fft), |scratch, line| fft.process_with_scratch(line, scratch));
}

fn scratch(fft: &Arc<dyn Fft<f64>>) -> Vec<Complex<f64>> {
    vec![Complex::default(); fft.get_inplace_scratch_len()]
}

/// Transposes the columns `wanted` of `lines` (of `width` values each) into lines of `len` values. Missing values are 0.
fn transposed(lines: &[Complex<f64>], width: usize, wanted: std::ops::Range<usize>, len: usize) -> Vec<Complex<f64>> {
    /// Columns processed at once, so that a cache line is used while it is still in the cache.
    const BLOCK: usize = 8;
    let mut out = vec![Complex::default(); wanted.len() * len];
    out.par_chunks_mut(BLOCK * len).enumerate().for_each(|(block, out)| {
        let first = wanted.start + block * BLOCK;
        for (row, line) in lines.chunks(width).enumerate() {
            for (i, target) in out.chunks_mut(len).enumerate() {
                target[row] = line[first + i];
            }
        }
    });
    out
}
