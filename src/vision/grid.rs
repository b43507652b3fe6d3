//! Places over an area of so many degrees, and what is computed at them.

use rayon::prelude::*;

use crate::light::image::resampled;

/// Pictures with at least twice this number of pixels per degree are averaged down to it, or a little more: the eye
/// sees nothing finer.
pub(super) const ENOUGH_PX_PER_DEG: f64 = 120.0;

/// Places at equal distances over an area.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    /// Number of places `[across, down]`.
    pub(super) size: [usize; 2],
    /// Size of the area, degrees.
    pub(super) extent: [f64; 2],
}

impl Grid {
    /// Returns the distance between neighbors, degrees.
    pub(super) fn step(&self) -> [f64; 2] {
        [0, 1].map(|axis| self.extent[axis] / self.size[axis] as f64)
    }

    /// Returns the two parts of the frequency of a cosine with `x` and `y` half periods over the area, cycles per degree.
    pub(super) fn frequencies(&self, x: usize, y: usize) -> [f64; 2] {
        [0.5 * x as f64 / self.extent[0], 0.5 * y as f64 / self.extent[1]]
    }

    /// Returns the frequency of a cosine, cycles per degree.
    pub(super) fn frequency(&self, x: usize, y: usize) -> f64 {
        let [right, down] = self.frequencies(x, y);
        (right * right + down * down).sqrt()
    }

    /// Returns a frequency above that of every cosine, cycles per degree.
    pub(super) fn finest(&self) -> f64 {
        self.step().map(f64::recip).into_iter().fold(0.0, f64::max)
    }

    /// Pools responses with this power for a gaze at the middle of the `shown` places from the place `first` on. `weight` is that of a response at a distance in degrees
    /// from the gaze, to the same power; for a line, it is integrated along the bars.
    pub(super) fn pooled(
        &self,
        responses: &[f64],
        [first, shown]: [[usize; 2]; 2],
        power: f64,
        weight: &Lookup,
        is_line: bool,
    ) -> f64 {
        let step = self.step();
        let middle = [0, 1].map(|axis| first[axis] as f64 + 0.5 * shown[axis] as f64 - 0.5);
        let of = |(row, values): (usize, &[f64])| {
            let down = (row as f64 - middle[1]) * step[1];
            let each = values.iter().enumerate().map(|(column, value)| {
                let right = (column as f64 - middle[0]) * step[0];
                value.abs().powf(power) * weight.at((right * right + down * down).sqrt())
            });
            each.sum::<f64>()
        };
        // In order: a parallel sum would be rounded differently in every run.
        let rows: Vec<f64> = responses.par_chunks(self.size[0]).enumerate().map(of).collect();
        let area = if is_line { step[0] } else { step[0] * step[1] };
        (rows.iter().sum::<f64>() * area).powf(1.0 / power)
    }
}

/// Returns a size that is smaller by about the factor `ratio`, but never too small; the same size below a factor of 2.
pub(super) fn coarser(size: [usize; 2], ratio: f64) -> [usize; 2] {
    size.map(|side| side.div_ceil((ratio as usize).max(1)))
}

/// Averages a picture of `size` over fewer pixels that divide it equally.
///
/// # Panics
/// Panics if the picture does not have this size.
pub(super) fn averaged(picture: Vec<f64>, size: [usize; 2], to: [usize; 2]) -> Vec<f64> {
    assert_eq!(picture.len(), size[0] * size[1], "there is one value for each pixel");
    if size == to {
        return picture;
    }
    let areas = |i: usize, to: usize, from: usize| {
        // In units of 1 / `to` pixels, so that all ends are whole numbers.
        let (start, end) = (i * from, (i + 1) * from);
        let part = |pixel: usize| (end.min((pixel + 1) * to) - start.max(pixel * to)) as f64 / from as f64;
        (start / to..end.div_ceil(to)).map(|pixel| (pixel, part(pixel))).collect()
    };
    resampled(size, to, areas, |x, y| [picture[y * size[0] + x]]).into_flattened()
}

/// Puts a picture into the middle of a `whole` picture of nothing, and returns that with the first place that shows it.
pub(super) fn within(picture: &[f64], size: [usize; 2], whole: [usize; 2]) -> (Vec<f64>, [usize; 2]) {
    let first = [0, 1].map(|axis| (whole[axis] - size[axis]) / 2);
    let mut values = vec![0.0; whole[0] * whole[1]];
    for (row, from) in picture.chunks_exact(size[0]).enumerate() {
        values[(first[1] + row) * whole[0] + first[0]..][..size[0]].copy_from_slice(from);
    }
    (values, first)
}

/// A function of a number that is not negative, interpolated between values that lie densest near 0.
pub(super) struct Lookup {
    values: Vec<f64>,
    per_root: f64,
}

/// Number of values in a table; the error is below a millionth.
const TABLE: usize = 8192;

impl Lookup {
    pub(super) fn new(most: f64, value: impl Fn(f64) -> f64) -> Lookup {
        let per_root = (TABLE - 2) as f64 / most.sqrt();
        Lookup { values: (0..TABLE).map(|i| value((i as f64 / per_root).powi(2))).collect(), per_root }
    }

    pub(super) fn at(&self, of: f64) -> f64 {
        let at = of.sqrt() * self.per_root;
        let i = (at as usize).min(TABLE - 2);
        self.values[i] + (self.values[i + 1] - self.values[i]) * (at - i as f64)
    }
}
