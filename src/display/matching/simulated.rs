//! An observer without eyes before a display that is known, to try the procedure on.

use rand_chacha::{ChaCha8Rng, rand_core::Rng};
use rand_distr::{Distribution as _, StandardNormal};

use super::{
    Channel,
    observation::{Judgement, NullingStimulus},
};
use crate::light::Transfers;

/// Share of white's luminance that red, green and blue give, IEC 61966-2-1.
const SHARES: [f64; 3] = [0.2126, 0.7152, 0.0722];
/// Standard deviation of a normal distribution over its upper quartile.
const SD_PER_QUARTILE: f64 = 1.482_602_218_505_602;

/// A display that is known.
#[derive(Clone, Debug)]
pub struct SimulatedDisplay {
    /// Code to light, channel by channel.
    pub transfers: Transfers,
    /// Light of the black screen and of the room upon it, relative to the white of the channel that is shown.
    pub flare: f64,
}

impl SimulatedDisplay {
    /// The luminance of `code` in `channel`, relative to that of 255 in it.
    #[must_use]
    pub fn luminance(&self, channel: Channel, code: u8) -> f64 {
        let linear = self.transfers.linear_from_encoded([f64::from(code) / 255.0; 3]);
        let added = match channel.index() {
            Some(index) => linear[index],
            None => linear.iter().zip(SHARES).map(|(light, share)| light * share).sum(),
        };
        self.flare + added
    }

    /// Luminance of the patch over that of the rows, their mean: they have blended.
    fn ratio(&self, stimulus: &NullingStimulus) -> f64 {
        let of = |code| self.luminance(stimulus.channel, code);
        of(stimulus.patch) / stimulus.rows.mean(of)
    }
}

/// An observer whose comparison of two luminances has normal noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimulatedObserver {
    /// The difference threshold: the relative difference in luminance that is judged rightly in 75 % of all trials
    /// (without lapses). The noise of the comparison, in natural logarithms of luminance, has 1.48 times this standard
    /// deviation, which is also that of a setting of the slider.
    pub threshold: f64,
    /// Share of answers given with closed eyes.
    pub lapse: f64,
}

impl SimulatedObserver {
    /// Whether the patch looks brighter.
    pub fn judge(&self, display: &SimulatedDisplay, stimulus: &NullingStimulus, rng: &mut ChaCha8Rng) -> Judgement {
        let seen = display.ratio(stimulus).ln() + self.noise(rng);
        let brighter = if unit(rng) < self.lapse { unit(rng) < 0.5 } else { seen > 0.0 };
        if brighter { Judgement::Brighter } else { Judgement::Darker }
    }

    /// The code at which the border vanishes: that of the light nearest to the field's as it is seen this time. After a
    /// lapse, the slider is left where it stood.
    pub fn adjust(&self, display: &SimulatedDisplay, stimulus: &NullingStimulus, rng: &mut ChaCha8Rng) -> u8 {
        let noise = self.noise(rng);
        if unit(rng) < self.lapse {
            return stimulus.patch;
        }
        let away = |code: &u8| (display.ratio(&NullingStimulus { patch: *code, ..*stimulus }).ln() - noise).abs();
        (0..=255u8).min_by(|a, b| away(a).total_cmp(&away(b))).unwrap_or(stimulus.patch)
    }

    fn noise(&self, rng: &mut ChaCha8Rng) -> f64 {
        let deviate: f64 = StandardNormal.sample(rng);
        deviate * self.threshold * SD_PER_QUARTILE
    }
}

/// Uniform in 0…1, 1 excluded.
fn unit(rng: &mut ChaCha8Rng) -> f64 {
    (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}
