//! An observer without eyes before a display that is known.

use machband::{display::matching::Match, light::Transfers};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};

/// Standard deviation of a normal distribution over its upper quartile.
const SD_PER_QUARTILE: f64 = 1.482_602_218_505_602;

/// The code at which the square vanishes for an observer who judges a relative difference of `threshold` rightly in 75 %
/// of all cases: that of the light nearest to the field's as it looks this time.
pub fn matched_code(display: &Transfers, shown: &Match, threshold: f64, rng: &mut ChaCha8Rng) -> u8 {
    let deviate: f64 = StandardNormal.sample(rng);
    let noise = deviate * threshold * SD_PER_QUARTILE;
    let index = shown.channel.index().unwrap_or(1);
    let ratio = |code: u8| display.linear_from_encoded([f64::from(code) / 255.0; 3])[index] / shown.rows.share();
    let away = |code: &u8| (ratio(*code).ln() - noise).abs();
    (0..=255u8).min_by(|a, b| away(a).total_cmp(&away(b))).unwrap()
}
