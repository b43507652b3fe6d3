//! The smoothest picture that has given codes: what a picture was before it was rounded, as far as its codes tell.

use rayon::prelude::*;

use super::transforms::Cosines;

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
