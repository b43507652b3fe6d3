//! Random orders determined by a seed, implemented here so that no new version of a library can change them.

use rand_chacha::{ChaCha8Rng, rand_core::Rng as _};

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
