//! Cosine transforms of pictures of any size, planned once per thread; and what a picture was before it was rounded, which
//! they smooth. A picture continues beyond its borders as its own mirror image, so a border is no edge.

use std::{cell::RefCell, sync::Arc};

use rayon::prelude::*;
use rustdct::{DctPlanner, TransformType2And3};

use crate::system::checkpoint;

thread_local! {
    static COSINES: RefCell<DctPlanner<f64>> = RefCell::new(DctPlanner::new());
}

/// Returns the transforms of `length` values.
fn plan(length: usize) -> Arc<dyn TransformType2And3<f64>> {
    COSINES.with_borrow_mut(|planner| planner.plan_dct2(length))
}

/// The amplitudes of the cosines whose sum is a picture, column by column: the one at `across · rows + down` has
/// `across` and `down` half periods over the picture.
#[derive(Clone)]
pub(super) struct Cosines {
    pub(super) amplitudes: Vec<f64>,
    size: [usize; 2],
}

impl Cosines {
    /// Analyzes a picture of `size` pixels `[across, down]`, row by row.
    pub(super) fn of(mut picture: Vec<f64>, size: [usize; 2]) -> Cosines {
        let [columns, rows] = size;
        each(&mut picture, columns, |plan, row, scratch| plan.process_dct2_with_scratch(row, scratch));
        let mut amplitudes = vec![0.0; picture.len()];
        transpose(&picture, &mut amplitudes, [columns, rows]);
        drop(picture);
        let scale = 4.0 / (columns * rows) as f64;
        each(&mut amplitudes, rows, |plan, column, scratch| {
            plan.process_dct2_with_scratch(column, scratch);
            column.iter_mut().for_each(|value| *value *= scale);
        });
        Cosines { amplitudes, size }
    }

    /// Returns a picture of nothing.
    pub(super) fn none(size: [usize; 2]) -> Cosines {
        Cosines { amplitudes: vec![0.0; size[0] * size[1]], size }
    }

    /// Multiplies each amplitude by `gain(across, down)`, half periods over the picture.
    pub(super) fn filter(&mut self, gain: impl Fn(usize, usize) -> f64 + Sync) {
        self.amplitudes
            .par_chunks_mut(self.size[1])
            .enumerate()
            .with_min_len(SHORT / self.size[1].min(SHORT))
            .for_each(|(across, column)| {
                checkpoint();
                column.iter_mut().enumerate().for_each(|(down, value)| *value *= gain(across, down));
            });
    }

    /// Adds the cosines of a picture that was sampled at fewer places.
    pub(super) fn add(&mut self, other: &Cosines) {
        let (rows, fewer) = (self.size[1], other.size[1]);
        for (column, other) in self.amplitudes.chunks_exact_mut(rows).zip(other.amplitudes.chunks_exact(fewer)) {
            column.iter_mut().zip(other).for_each(|(value, other)| *value += other);
        }
    }

    /// Returns the picture at `places` `[across, down]`, row by row; coarser places lose the finer cosines. Each
    /// amplitude is multiplied by `gain`. Along an `odd` axis, 0 across or 1 down, sines take the place of cosines.
    pub(super) fn at(
        &self,
        places: [usize; 2],
        odd: Option<usize>,
        gain: impl Fn(usize, usize) -> f64 + Sync,
    ) -> Vec<f64> {
        let ([columns, rows], whole) = (places, self.size[1]);
        let mut values = vec![0.0; columns * rows];
        let out = values.par_chunks_mut(rows).zip(self.amplitudes.par_chunks(whole)).enumerate();
        out.with_min_len(SHORT / rows.min(SHORT)).for_each(|(across, (to, from))| {
            to.iter_mut().zip(from).enumerate().for_each(|(down, (to, from))| *to = from * gain(across, down));
        });
        each(&mut values, rows, |plan, column, scratch| inverse(plan, column, scratch, odd == Some(1)));
        let mut picture = vec![0.0; values.len()];
        transpose(&values, &mut picture, [rows, columns]);
        drop(values);
        each(&mut picture, columns, |plan, row, scratch| inverse(plan, row, scratch, odd == Some(0)));
        picture
    }
}

/// Adds up the cosines, or the sines, of these amplitudes.
fn inverse(plan: &dyn TransformType2And3<f64>, values: &mut [f64], scratch: &mut [f64], is_odd: bool) {
    if is_odd {
        // The first sine has half a period, and there is no constant one.
        values.rotate_left(1);
        if let Some(last) = values.last_mut() {
            *last = 0.0;
        }
        plan.process_dst3_with_scratch(values, scratch);
    } else {
        plan.process_dct3_with_scratch(values, scratch);
    }
}

/// Transforms each run of `length` values.
fn each(
    values: &mut [f64],
    length: usize,
    transform: impl Fn(&dyn TransformType2And3<f64>, &mut [f64], &mut [f64]) + Sync,
) {
    let plan = plan(length);
    let least = (SHORT / length).max(1);
    values.par_chunks_exact_mut(length).with_min_len(least).for_each_init(
        || vec![0.0; plan.get_scratch_len()],
        |scratch, run| {
            checkpoint();
            transform(&*plan, run, scratch);
        },
    );
}

/// Returns the smallest number that is at least `least` and has no prime factor above 5. Transforms of such lengths are
/// fast.
pub fn next_fast_length(least: usize) -> usize {
    let is_smooth = |mut n: usize| {
        for factor in [2, 3, 5] {
            while n.is_multiple_of(factor) {
                n /= factor;
            }
        }
        n == 1
    };
    (least.max(1)..).find(|n| is_smooth(*n)).unwrap_or(least)
}

/// Fewer runs, or values, than this are not worth another thread.
const SHORT: usize = 4096;

/// Turns rows of `columns` values into columns, in tiles that fit in the processor's cache.
fn transpose<T: Copy + Send + Sync>(from: &[T], to: &mut [T], [columns, rows]: [usize; 2]) {
    const TILE: usize = 16;
    to.par_chunks_mut(TILE * rows).enumerate().with_min_len(SHORT.div_ceil(TILE * rows)).for_each(|(tile, to)| {
        let first = tile * TILE;
        for top in (0..rows).step_by(TILE) {
            for (x, column) in to.chunks_exact_mut(rows).enumerate() {
                let bottom = (top + TILE).min(rows);
                for (y, to) in column[top..bottom].iter_mut().enumerate() {
                    *to = from[(top + y) * columns + first + x];
                }
            }
        }
    });
}

/// How often the picture is smoothed at each scale.
const ROUNDS: usize = 8;
/// The finest scale, pixels.
const FINEST: f64 = 0.5;

/// Returns the smoothest values that round to the codes of one channel, row by row. Values diffuse from place to place,
/// from the scale of the whole picture down to that of a pixel, and each stays within what `reach` gives for its own code:
/// how far values below and above it were rounded to it.
pub fn unrounded(codes: &[f64], size: [usize; 2], reach: impl Fn(f64) -> [f64; 2] + Sync) -> Vec<f64> {
    let mut values = codes.to_vec();
    let mut sigma = 0.25 * size[0].max(size[1]) as f64;
    while sigma >= FINEST {
        let decay = |k: usize, n: usize| (-0.5 * (std::f64::consts::PI * sigma * k as f64 / n as f64).powi(2)).exp();
        let [across, down] = size.map(|n| (0..n).map(|k| decay(k, n)).collect::<Vec<f64>>());
        for _ in 0..ROUNDS {
            values = Cosines::of(values, size).at(size, None, |x, y| across[x] * down[y]);
            let kept = values.par_iter_mut().zip(codes);
            kept.for_each(|(value, code)| {
                let [below, above] = reach(*code);
                *value = value.clamp(code - below, code + above);
            });
        }
        sigma *= 0.5;
    }
    values
}
