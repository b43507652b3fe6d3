//! Fourier transforms of any length, each planned once per thread.

use std::{cell::RefCell, sync::Arc};

use rayon::prelude::*;
use rustfft::{Fft, FftPlanner, num_complex::Complex64};

use crate::system::checkpoint;

thread_local! {
    static PLANNER: RefCell<FftPlanner<f64>> = RefCell::new(FftPlanner::new());
}

/// Returns the forward transform for `length` values.
fn forward(length: usize) -> Arc<dyn Fft<f64>> {
    PLANNER.with_borrow_mut(|planner| planner.plan_fft_forward(length))
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

/// Performs an unnormalized two-dimensional Fourier transform in place.
pub(super) fn transform(values: &mut [Complex64], columns: usize, rows: usize) {
    let (across, down) = (forward(columns), forward(rows));
    values.par_chunks_exact_mut(columns).for_each(|row| {
        checkpoint();
        across.process(row);
    });
    let mut turned = vec![Complex64::default(); values.len()];
    transpose(values, &mut turned, [columns, rows]);
    turned.par_chunks_exact_mut(rows).for_each(|column| {
        checkpoint();
        down.process(column);
    });
    transpose(&turned, values, [rows, columns]);
}

/// Fewer runs, or values, than this are not worth another thread.
pub(super) const SHORT: usize = 4096;

/// Turns rows of `columns` values into columns, in tiles that fit in the processor's cache.
pub(super) fn transpose<T: Copy + Send + Sync>(from: &[T], to: &mut [T], [columns, rows]: [usize; 2]) {
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
