//! A simulated observer who looks at a display with a known profile.

use machband::{display::matching::Match, light::Transfers};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};

/// Standard deviation of a normal distribution, divided by its upper quartile.
const SD_PER_QUARTILE: f64 = 1.482_602_218_505_602;

/// The code at which the square vanishes for an observer who judges a relative difference of `threshold` correctly in
/// 75 % of all cases. It is the code whose light is nearest to the light of the field as perceived in this match.
pub fn matched_code(display: &Transfers, shown: &Match, threshold: f64, rng: &mut ChaCha8Rng) -> u8 {
    let deviate: f64 = StandardNormal.sample(rng);
    let noise = deviate * threshold * SD_PER_QUARTILE;
    let index = shown.channel.index().unwrap_or(1);
    let ratio = |code: u8| display.linear_from_encoded([f64::from(code) / 255.0; 3])[index] / shown.rows.share();
    let away = |code: &u8| (ratio(*code).ln() - noise).abs();
    (0..=255u8).min_by(|a, b| away(a).total_cmp(&away(b))).unwrap()
}
