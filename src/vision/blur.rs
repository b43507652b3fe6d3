//! Gaussian blur onto a coarser grid, and interpolation back onto a finer one.
//!
//! The blur works in space rather than in frequency because what is blurred spans more orders of magnitude than a
//! Fourier transform resolves.

use super::image::Grid;

/// A field at every `stride`-th place of a grid along one axis, centered so that a mirrored image has the same places.
#[derive(Clone, Copy)]
struct Axis {
    values: usize,
    places: usize,
    stride: usize,
    /// The first place, in grid steps.
    first: f64,
}

impl Axis {
    fn new(values: usize, stride: usize) -> Axis {
        let places = values.div_ceil(stride);
        let first = (values as f64 - 1.0) / 2.0 - (places as f64 - 1.0) / 2.0 * stride as f64;
        Axis { values, places, stride, first }
    }

    /// Returns the weights of the values around a place, and the first value's index for place 0.
    fn weights(&self, sigma: f64, reach: f64) -> (Vec<f64>, isize) {
        if self.values == 1 {
            return (vec![1.0], 0);
        }
        let base = (self.first - sigma * reach).floor() as isize;
        let end = (self.first + sigma * reach).ceil() as isize;
        let weights: Vec<f64> =
            (base..=end).map(|i| (-0.5 * ((i as f64 - self.first) / sigma).powi(2)).exp()).collect();
        let total: f64 = weights.iter().sum();
        (weights.into_iter().map(|weight| weight / total).collect(), base)
    }

    /// Returns the index of a value. Beyond the ends, the last value continues.
    fn index(&self, i: isize) -> usize {
        i.clamp(0, self.values as isize - 1) as usize
    }
}

/// Blurs fields on one grid and keeps every few places.
pub(super) struct Blur {
    across: Axis,
    down: Axis,
    pub(super) grid: Grid,
}

impl Blur {
    /// Keeps every `stride`-th place of `grid`.
    pub(super) fn new(grid: &Grid, stride: usize) -> Blur {
        let (across, down) = (Axis::new(grid.columns, stride), Axis::new(grid.rows, stride));
        let first =
            [(across.first, 0), (down.first, 1)].map(|(first, axis)| grid.first[axis] + first * grid.step[axis]);
        let step = grid.step.map(|step| step * stride as f64);
        let grid = Grid { columns: across.places, rows: down.places, first, step };
        Blur { across, down, grid }
    }

    /// Blurs `values` with a Gaussian of `sigma` grid steps `[across, down]`, cut off at `reach` σ.
    pub(super) fn blur(&self, values: &[f64], sigma: [f64; 2], reach: f64) -> Vec<f64> {
        let columns = self.across.values;
        let (across, left) = self.across.weights(sigma[0], reach);
        let (down, top) = self.down.weights(sigma[1], reach);
        let needed = (self.across.places - 1) * self.across.stride + across.len();
        // One blurred row, continued beyond both ends.
        let mut row = vec![0.0; columns];
        let mut padded = vec![0.0; needed];
        let mut blurred = Vec::with_capacity(self.across.places * self.down.places);
        for place in 0..self.down.places {
            row.fill(0.0);
            let first = top + (place * self.down.stride) as isize;
            for (k, weight) in down.iter().enumerate() {
                let from = &values[self.down.index(first + k as isize) * columns..][..columns];
                row.iter_mut().zip(from).for_each(|(sum, value)| *sum += weight * value);
            }
            for (k, value) in padded.iter_mut().enumerate() {
                *value = row[self.across.index(left + k as isize)];
            }
            let windows = (0..self.across.places).map(|place| &padded[place * self.across.stride..][..across.len()]);
            blurred.extend(windows.map(|window| dot(window, &across)));
        }
        blurred
    }
}

/// Returns the scalar product. Four partial sums let the processor work on several at once.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (a, b) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a.zip(b) {
        for k in 0..4 {
            sums[k] += a[k] * b[k];
        }
    }
    sums.iter().sum::<f64>() + rest
}

/// The four nearest values of a grid axis and their weights (Catmull & Rom 1974), for each place of another grid's axis.
struct Taps(Vec<([usize; 4], [f64; 4])>);

impl Taps {
    fn new(from: &Grid, to: &Grid, axis: usize) -> Taps {
        let (values, places) = if axis == 0 { (from.columns, to.columns) } else { (from.rows, to.rows) };
        let tap = |place: usize| {
            let at = to.first[axis] + place as f64 * to.step[axis];
            let at = ((at - from.first[axis]) / from.step[axis]).clamp(0.0, values as f64 - 1.0);
            let first = at.floor();
            let t = at - first;
            let index = |k: isize| (first as isize + k).clamp(0, values as isize - 1) as usize;
            let weights = [
                t * (t * (2.0 - t) - 1.0) / 2.0,
                (t * t * (3.0 * t - 5.0) + 2.0) / 2.0,
                t * (t * (4.0 - 3.0 * t) + 1.0) / 2.0,
                t * t * (t - 1.0) / 2.0,
            ];
            ([index(-1), index(0), index(1), index(2)], weights)
        };
        Taps((0..places).map(tap).collect())
    }
}

/// Interpolates fields on one grid at the places of another.
pub(super) struct Interpolation {
    across: Taps,
    down: Taps,
    columns: usize,
}

impl Interpolation {
    pub(super) fn new(from: &Grid, to: &Grid) -> Interpolation {
        Interpolation { across: Taps::new(from, to, 0), down: Taps::new(from, to, 1), columns: from.columns }
    }

    /// Interpolates one row. `buffer` is scratch space.
    pub(super) fn row(&self, values: &[f64], row: usize, buffer: &mut Vec<f64>, to: &mut [f64]) {
        let (rows, weights) = &self.down.0[row];
        let [a, b, c, d] = rows.map(|row| &values[row * self.columns..][..self.columns]);
        buffer.clear();
        buffer.extend(
            (0..self.columns).map(|i| weights[0] * a[i] + weights[1] * b[i] + weights[2] * c[i] + weights[3] * d[i]),
        );
        for (to, (at, weights)) in to.iter_mut().zip(&self.across.0) {
            *to = (0..4).map(|k| buffer[at[k]] * weights[k]).sum();
        }
    }
}
