//! Random orders determined by a seed, implemented here so that no new version of a library can change them, and the
//! quantile of the normal distribution used for every 95 % interval.

use rand_chacha::{ChaCha8Rng, rand_core::Rng as _};

/// The number of standard errors from an estimate to either end of its 95 % interval: the 97.5 % quantile of the normal
/// distribution.
pub const Z_95: f64 = 1.959_963_984_540_054;

/// Puts `items` into a random order with the Fisher–Yates shuffle.
pub fn shuffle<T>(items: &mut [T], rng: &mut ChaCha8Rng) {
    for i in (1..items.len()).rev() {
        items.swap(i, below(rng, i as u64 + 1) as usize);
    }
}

/// Returns a uniform random number in `0..bound`. Rejection makes every value equally likely. `bound` must be above 0.
pub fn below(rng: &mut ChaCha8Rng, bound: u64) -> u64 {
    let limit = u64::MAX - u64::MAX % bound;
    loop {
        let draw = rng.next_u64();
        if draw < limit {
            return draw % bound;
        }
    }
}
