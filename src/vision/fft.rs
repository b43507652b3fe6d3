//! Fourier transforms of any length, each planned once per thread.

use std::{cell::RefCell, sync::Arc};

use rustfft::{Fft, FftPlanner};

thread_local! {
    static PLANNER: RefCell<FftPlanner<f64>> = RefCell::new(FftPlanner::new());
}

/// Returns the forward transform for `length` values.
#[must_use]
pub fn forward(length: usize) -> Arc<dyn Fft<f64>> {
    PLANNER.with_borrow_mut(|planner| planner.plan_fft_forward(length))
}

/// Returns the inverse transform for `length` values, without the factor 1/`length`.
#[must_use]
pub fn inverse(length: usize) -> Arc<dyn Fft<f64>> {
    PLANNER.with_borrow_mut(|planner| planner.plan_fft_inverse(length))
}

/// Returns the smallest number that is at least `least` and has no prime factor above 5. Transforms of such lengths are
/// fast.
#[must_use]
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
