//! Estimates γ of each channel from its matches; the spread of the matches gives the uncertainty.

use super::procedure::Match;
use crate::{
    display::channel::Channel,
    light::{Transfer, TransferError, Transfers},
    statistics::{mean_and_sd, t_quantile},
};

/// Half-width of the 95 % interval of γ above which a channel should be matched again.
const MAX_HALF_WIDTH: f64 = 0.1;

/// The result of the matches of one channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelGamma {
    /// The matched channel.
    pub channel: Channel,
    /// The exponent γ.
    pub gamma: f64,
    /// The 95 % interval of γ, by Student's t.
    pub interval: [f64; 2],
    /// Number of matches.
    pub matches: usize,
    /// The field's share of full light, 0…1.
    pub share: f64,
    /// Mean of the matched codes.
    pub code: f64,
    /// Standard deviation of the matched codes.
    pub code_sd: f64,
}

/// Why γ cannot be estimated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GammaError {
    /// Too few matches.
    #[error("{0} matches; expected at least 2")]
    TooFew(usize),
    /// Matches to different fields.
    #[error("the matches have different rows; expected matches of one run")]
    Mixed,
    /// Matches that differ so much, or are so close to black or white, that they do not determine γ.
    #[error("the matches do not determine γ; expected codes that agree with each other")]
    Open,
}

/// Estimates γ of each channel that has matches, in the order of [`Channel::ALL`].
#[must_use]
pub fn estimate(matches: &[Match]) -> Vec<(Channel, Result<ChannelGamma, GammaError>)> {
    let of = |channel: Channel| {
        let own: Vec<Match> = matches.iter().filter(|one| one.channel == channel).copied().collect();
        (!own.is_empty()).then(|| (channel, channel_gamma(channel, &own)))
    };
    Channel::ALL.into_iter().filter_map(of).collect()
}

/// A match means (c/255)^γ = share, so ln(255/c), the quantity that varies from match to match, equals |ln share|/γ.
fn channel_gamma(channel: Channel, own: &[Match]) -> Result<ChannelGamma, GammaError> {
    let n = own.len() as f64;
    if own.len() < 2 {
        return Err(GammaError::TooFew(own.len()));
    }
    if own.iter().any(|one| one.rows != own[0].rows) {
        return Err(GammaError::Mixed);
    }
    let codes: Vec<f64> = own.iter().map(|one| f64::from(one.code.max(1))).collect();
    let (mean, sd) = mean_and_sd(&codes.iter().map(|code| (255.0 / code).ln()).collect::<Vec<_>>());
    // Equal codes do not mean zero uncertainty: a match is precise to one code at best.
    let rounding = codes.iter().sum::<f64>().recip() * n / 12f64.sqrt();
    let half = t_quantile(n - 1.0) * sd.hypot(rounding) / n.sqrt();
    if mean - half <= 0.0 {
        return Err(GammaError::Open);
    }
    let share = own[0].rows.share();
    let gamma = |mean: f64| -share.ln() / mean;
    let (code, code_sd) = mean_and_sd(&codes);
    let interval = [gamma(mean + half), gamma(mean - half)];
    Ok(ChannelGamma { channel, gamma: gamma(mean), interval, matches: own.len(), share, code, code_sd })
}

impl ChannelGamma {
    /// Returns a warning if γ is too uncertain.
    #[must_use]
    pub fn warning(&self) -> Option<String> {
        let half = (self.interval[1] - self.interval[0]) / 2.0;
        (half > MAX_HALF_WIDTH).then(|| {
            format!(
                "{}: gamma is uncertain by ± {half:.2}. Sit far enough away that the rows blend, and repeat the \
                    matches.",
                self.channel.capitalized()
            )
        })
    }

    /// Returns the transfer function, with γ rounded for a profile.
    ///
    /// # Errors
    /// Returns an error if γ is implausible for a display.
    fn transfer(&self) -> Result<Transfer, TransferError> {
        Transfer::gamma((self.gamma * 1e3).round() / 1e3)
    }
}

/// Returns the display's transfer functions: one each for red, green, and blue if all were matched, otherwise the
/// transfer function of gray for all three. `None` if a required channel is missing or has no γ.
#[must_use]
pub fn transfers(estimates: &[(Channel, Result<ChannelGamma, GammaError>)]) -> Option<Transfers> {
    let of = |wanted: Channel| {
        let (_, found) = estimates.iter().find(|(channel, _)| *channel == wanted)?;
        found.as_ref().ok()?.transfer().ok()
    };
    match (of(Channel::Red), of(Channel::Green), of(Channel::Blue)) {
        (Some(red), Some(green), Some(blue)) => Some(Transfers::new([red, green, blue])),
        _ => of(Channel::Gray).map(Transfers::from),
    }
}
