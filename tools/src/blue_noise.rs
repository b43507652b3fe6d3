//! Blue noise: a mask of ranks without pattern and without slow undulation, made by void and cluster.
//!
//! R. Ulichney, *The void-and-cluster method for dither array generation*, Proc. SPIE 1913 (1993).

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Seed of the committed mask.
pub const MASK_SEED: u64 = 1;

/// exp(−1/(2σ²)) with Ulichney's σ = 1.5 px. A literal: a library's exp may differ in its last digit
/// between machines.
const FALL_OFF: f64 = 0.800_737_402_916_808_1;
/// The filter's weight at distance 0. Weights are whole numbers: sums are then exact in any order.
const FULL_WEIGHT: f64 = (1u64 << 48) as f64;
/// The initial pattern lights one pixel in this many, Ulichney's "one tenth or so".
const INITIAL_SHARE: usize = 10;

/// Ranks as the mask's file holds them: 16 bits each, lower byte first.
#[must_use]
pub fn to_bytes(ranks: &[u16]) -> Vec<u8> {
    ranks.iter().flat_map(|rank| rank.to_le_bytes()).collect()
}

/// A mask of `size` × `size` ranks whose edges join: every rank 0…`size`²−1 once, row by row, such that
/// for any k the pixels of rank below k are spread evenly and without pattern. Ulichney 1993.
///
/// Takes time as `size`⁴; the same ranks on every machine.
///
/// # Panics
/// When `size` is 0 or above 256: a rank has 16 bits.
#[must_use]
pub fn void_and_cluster(size: u32, seed: u64) -> Vec<u16> {
    assert!((1..=256).contains(&size), "a mask of {size} × {size} pixels; expected a side of 1…256");
    let prototype = settled_pattern(size as usize, seed);
    let ones = prototype.lit.iter().filter(|&&lit| lit).count();
    let mut ranks = vec![0; prototype.lit.len()];
    // Phase I: the pattern's own pixels, ranked downwards by taking out the tightest cluster.
    let mut pattern = prototype.clone();
    for rank in (0..ones).rev() {
        let place = pattern.tightest_cluster();
        pattern.set(place, false);
        // Below size² ≤ 2¹⁶.
        ranks[place] = rank as u16;
    }
    // Phases II and III: the others, ranked upwards by filling the largest void. Phase III asks for the
    // tightest cluster of dark pixels; the filter's answer to all pixels is a constant, so that is the
    // largest void still.
    let mut pattern = prototype;
    for rank in ones..ranks.len() {
        let place = pattern.largest_void();
        pattern.set(place, true);
        ranks[place] = rank as u16;
    }
    ranks
}

/// The initial pattern: pixels lit at random, then moved from the tightest cluster to the largest void
/// until that gains nothing. Every move lowers the pattern's energy, so it ends.
fn settled_pattern(size: usize, seed: u64) -> Pattern {
    let mut pattern = Pattern::dark(size);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut places: Vec<usize> = (0..size * size).collect();
    for i in 0..(size * size / INITIAL_SHARE).max(1) {
        let left = (places.len() - i) as u64;
        // The top of a 64-bit product, less than `left`: uniform to 2⁻¹⁶, which is enough here.
        let pick = i + ((u64::from(rng.next_u32()) * left) >> 32) as usize;
        places.swap(i, pick);
        pattern.set(places[i], true);
    }
    loop {
        let cluster = pattern.tightest_cluster();
        pattern.set(cluster, false);
        let void = pattern.largest_void();
        if pattern.energy[void] >= pattern.energy[cluster] {
            pattern.set(cluster, true);
            return pattern;
        }
        pattern.set(void, true);
    }
}

/// A binary pattern on a torus, and how crowded every pixel is.
#[derive(Clone)]
struct Pattern {
    size: usize,
    lit: Vec<bool>,
    /// Σ over lit pixels of exp(−d²/2σ²), d the shortest distance on the torus.
    energy: Vec<u64>,
    /// The filter, by horizontal and vertical distance.
    weights: Vec<u64>,
}

impl Pattern {
    fn dark(size: usize) -> Self {
        let around = |i: usize| i.min(size - i);
        let weights = (0..size * size).map(|i| weight(around(i % size), around(i / size))).collect();
        Self { size, lit: vec![false; size * size], energy: vec![0; size * size], weights }
    }

    fn set(&mut self, place: usize, lit: bool) {
        self.lit[place] = lit;
        let (px, py) = (place % self.size, place / self.size);
        for (y, row) in self.energy.chunks_exact_mut(self.size).enumerate() {
            let weights = &self.weights[y.abs_diff(py) * self.size..][..self.size];
            for (x, energy) in row.iter_mut().enumerate() {
                let weight = weights[x.abs_diff(px)];
                *energy = if lit { *energy + weight } else { *energy - weight };
            }
        }
    }

    /// The most crowded lit pixel, the first of equals.
    fn tightest_cluster(&self) -> usize {
        self.first_by(true, |a, b| a > b)
    }

    /// The least crowded dark pixel, the first of equals.
    fn largest_void(&self) -> usize {
        self.first_by(false, |a, b| a < b)
    }

    fn first_by(&self, lit: bool, better: impl Fn(u64, u64) -> bool) -> usize {
        let mut best: Option<(usize, u64)> = None;
        for (i, (&energy, _)) in self.energy.iter().zip(&self.lit).enumerate().filter(|(_, (_, is))| **is == lit) {
            if best.is_none_or(|(_, so_far)| better(energy, so_far)) {
                best = Some((i, energy));
            }
        }
        best.map_or(0, |(i, _)| i)
    }
}

/// exp(−(dx² + dy²)/2σ²) of [`FULL_WEIGHT`], by multiplication, which is the same everywhere.
fn weight(dx: usize, dy: usize) -> u64 {
    let mut weight = FULL_WEIGHT;
    for _ in 0..dx * dx + dy * dy {
        weight *= FALL_OFF;
        if weight < 0.5 {
            return 0;
        }
    }
    weight.round() as u64
}
