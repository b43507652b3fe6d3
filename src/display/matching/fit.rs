//! γ of one channel from its answers, by maximum likelihood.
//!
//! The observer's spread σ is not known: the likelihood of γ is averaged over it, evenly in σ, so that it does not take
//! few answers for more certain than they are. Other channels, compared by the same observer, may tell of it ([`Spread`]).

use super::{observation::Observation, plan::Plan};
use crate::light::Transfer;

/// Exponents searched.
const GAMMAS: (f64, f64) = (0.6, 6.0);
/// Exponents of the first, coarse search.
const COARSE: usize = 48;
/// Spreads averaged over: thresholds of 0.4 % to 20 %.
const SIGMAS: usize = 12;
/// The smallest and largest of them, natural logarithms of light.
const SIGMA_RANGE: (f64, f64) = (0.006, 0.3);
/// Fall of the log-likelihood at the ends of a 95 % interval: half the 95 % point of χ² with one degree of freedom.
const FALL: f64 = 1.920_729;
/// Standard normal deviate of a two-sided 95 % interval.
const Z: f64 = 1.959_964;
/// 75 % point of the standard normal distribution: spread to difference threshold.
const QUARTILE: f64 = 0.674_490;
/// Fewest answers that say anything.
const FEWEST: usize = 3;
/// Offsets tried in the model of gain, offset and gamma, encoded values.
const OFFSETS: (f64, f64) = (-0.2, 0.2);

/// What is known of the observer's spread before a channel is looked at: log-likelihoods, from small to large.
#[derive(Clone, Debug, PartialEq)]
pub struct Spread([f64; SIGMAS]);

impl Default for Spread {
    /// Nothing.
    fn default() -> Self {
        Self([0.0; SIGMAS])
    }
}

impl Spread {
    /// With what the answers of another channel, of exponent `gamma`, say of it.
    #[must_use]
    pub fn and(mut self, observations: &[Observation], gamma: f64) -> Self {
        let each = by_sigma(observations, |code| power(code, gamma));
        self.0.iter_mut().zip(each).for_each(|(sum, one)| *sum += one);
        self
    }
}

/// Why there is no γ.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FitError {
    /// Not enough trials.
    #[error("{0} answers; expected at least 3")]
    TooFew(usize),
    /// No patch was ever too bright, or none too dark.
    #[error("all answers are the same; expected some of each kind, since the patches lie on both sides of the match")]
    OneSided,
    /// Every γ explains the answers about as well.
    #[error("the answers hardly depend on what was shown, and leave γ open; expected a patch compared with its field")]
    Open,
}

/// The exponent that makes the answers likeliest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GammaFit {
    /// γ.
    pub gamma: f64,
    /// The 95 % interval: the exponents whose log-likelihood is at most 1.92 below the largest.
    pub interval: [f64; 2],
    /// Half the width of the interval over 1.96.
    pub standard_error: f64,
    /// The observer's spread σ, natural logarithms of light.
    pub sigma: f64,
    /// Answers used.
    pub answers: usize,
}

impl GammaFit {
    /// γ of the answers of one channel; `spread` tells what other channels say of the observer.
    ///
    /// # Errors
    /// When they do not tell one.
    pub fn new(observations: &[Observation], spread: &Spread) -> Result<Self, FitError> {
        use super::observation::Judgement::{Brighter, Darker};
        if observations.len() < FEWEST {
            return Err(FitError::TooFew(observations.len()));
        }
        for only in [Brighter, Darker] {
            if observations.iter().all(|observation| observation.judgement == only) {
                return Err(FitError::OneSided);
            }
        }
        let of = |gamma: f64| averaged(observations, spread, |code| power(code, gamma));
        let (gamma, most) = maximum(GAMMAS, COARSE, of);
        let falls_at = |end: f64| crossing(gamma, end, |at| of(at) - (most - FALL));
        let interval = [falls_at(GAMMAS.0).ok_or(FitError::Open)?, falls_at(GAMMAS.1).ok_or(FitError::Open)?];
        let sigma = sigma(observations, spread, |code| power(code, gamma));
        let standard_error = (interval[1] - interval[0]) / (2.0 * Z);
        Ok(Self { gamma, interval, standard_error, sigma, answers: observations.len() })
    }

    /// The difference threshold that the answers show: the relative difference of light judged rightly in 75 % of all
    /// trials.
    #[must_use]
    pub fn threshold(&self) -> f64 {
        self.sigma * QUARTILE
    }
}

/// What the answers at one level say by themselves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MatchedLevel {
    /// Index into [`Plan::levels`].
    pub level: usize,
    /// Answers.
    pub answers: usize,
    /// Mean light of the field under the channel's γ, 0…1, as it was shown last.
    pub share: f64,
    /// The code that matches the field.
    pub code: f64,
    /// Its standard error.
    pub code_error: f64,
    /// Standard deviation of the codes accepted with the slider; `None` for the staircase and for a single match.
    pub code_sd: Option<f64>,
    /// How much more light the γ of the channel gives the match than the field has, as a share: 0 where they agree.
    pub excess: f64,
    /// The same over its standard error: beyond ±3 the level disagrees with the γ.
    pub z: f64,
}

impl MatchedLevel {
    /// Each level of the plan that has answers.
    #[must_use]
    pub fn of_all(observations: &[Observation], plan: &Plan, fit: &GammaFit) -> Vec<Self> {
        (0..plan.levels.len())
            .filter_map(|level| {
                let own: Vec<_> = observations.iter().filter(|o| o.level == level).copied().collect();
                Self::new(level, &own, fit)
            })
            .collect()
    }

    fn new(level: usize, own: &[Observation], fit: &GammaFit) -> Option<Self> {
        let last = own.last()?;
        let light = |code: u8| power(code, fit.gamma);
        let ratios: Vec<f64> = own.iter().map(|observation| observation.log_ratio(light)).collect();
        let at = |shift: f64| -> f64 {
            own.iter().zip(&ratios).map(|(o, ratio)| o.log_likelihood(ratio - shift, fit.sigma)).sum()
        };
        // A few answers of one kind would put the match anywhere: no farther than any patch was.
        let farthest = ratios.iter().fold(2.0 * fit.sigma, |most, ratio| most.max(ratio.abs()));
        let (shift, most) = maximum_between(-farthest, farthest, 24, at);
        let half_width = |end: f64| crossing(shift, end, |x| at(x) - (most - 0.5)).map(|x| (x - shift).abs());
        let wide = 4.0 * farthest;
        let error = match (half_width(shift - wide), half_width(shift + wide)) {
            (Some(below), Some(above)) => below.max(above),
            _ => wide,
        };
        let share = last.stimulus.rows.mean(light);
        let code = 255.0 * (share * shift.exp()).min(1.0).powf(fit.gamma.recip());
        let accepted: Vec<f64> = own.iter().map(|o| f64::from(o.stimulus.patch)).collect();
        let by_slider = last.judgement == super::Judgement::Matched;
        Some(Self {
            level,
            answers: own.len(),
            share,
            code,
            // dV/V = d ln L/γ.
            code_error: code * error / fit.gamma,
            code_sd: by_slider.then(|| standard_deviation(&accepted)).flatten(),
            excess: shift.exp_m1(),
            z: shift / error,
        })
    }
}

/// The model of gain, offset and gamma, gain = 1 − offset: light ∝ max((1 − o)·V + o, 0)^γ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GogFit {
    /// γ.
    pub gamma: f64,
    /// The offset o, encoded values.
    pub offset: f64,
    /// Twice the gain in log-likelihood over the power alone: χ² with one degree of freedom where the display is a power.
    pub chi_squared: f64,
}

impl GogFit {
    /// The likeliest offset and γ; `None` where no offset makes the answers likelier.
    #[must_use]
    pub fn new(observations: &[Observation], fit: &GammaFit) -> Option<Self> {
        let of = |gamma: f64, offset: f64| {
            let Ok(transfer) = Transfer::gog(gamma, 1.0 - offset, offset) else { return f64::NEG_INFINITY };
            sum(observations, fit.sigma, |code| transfer.linear_from_encoded(f64::from(code) / 255.0))
        };
        let around = (fit.gamma * 0.6, fit.gamma * 1.5);
        let best_gamma = |offset: f64| maximum(around, 8, |gamma| of(gamma, offset));
        let (offset, most) = maximum_between(OFFSETS.0, OFFSETS.1, 9, |offset| best_gamma(offset).1);
        let alone = sum(observations, fit.sigma, |code| power(code, fit.gamma));
        let chi_squared = 2.0 * (most - alone);
        (chi_squared > 0.0).then(|| Self { gamma: best_gamma(offset).0, offset, chi_squared })
    }
}

fn power(code: u8, gamma: f64) -> f64 {
    (f64::from(code) / 255.0).powf(gamma)
}

fn sum(observations: &[Observation], sigma: f64, light: impl Fn(u8) -> f64) -> f64 {
    observations.iter().map(|o| o.log_likelihood(o.log_ratio(&light), sigma)).sum()
}

fn sigmas() -> impl Iterator<Item = f64> {
    let step = (SIGMA_RANGE.1 / SIGMA_RANGE.0).ln() / (SIGMAS - 1) as f64;
    (0..SIGMAS).map(move |i| SIGMA_RANGE.0 * (step * i as f64).exp())
}

/// The log-likelihood under each spread.
fn by_sigma(observations: &[Observation], light: impl Fn(u8) -> f64) -> Vec<f64> {
    let ratios: Vec<f64> = observations.iter().map(|o| o.log_ratio(&light)).collect();
    let of = |sigma: f64| observations.iter().zip(&ratios).map(|(o, ratio)| o.log_likelihood(*ratio, sigma)).sum();
    sigmas().map(of).collect()
}

/// Logarithm of the largest, and each over it times its spread, for an average even in σ.
fn weights(observations: &[Observation], spread: &Spread, light: impl Fn(u8) -> f64) -> (f64, Vec<f64>) {
    let mut each = by_sigma(observations, light);
    each.iter_mut().zip(&spread.0).for_each(|(one, before)| *one += before);
    let most = each.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (most, each.iter().zip(sigmas()).map(|(one, sigma)| (one - most).exp() * sigma).collect())
}

/// Logarithm of the likelihood averaged over the spreads, but for a constant.
fn averaged(observations: &[Observation], spread: &Spread, light: impl Fn(u8) -> f64) -> f64 {
    let (most, weights) = weights(observations, spread, light);
    most + weights.iter().sum::<f64>().ln()
}

/// The mean spread, in its logarithm.
fn sigma(observations: &[Observation], spread: &Spread, light: impl Fn(u8) -> f64) -> f64 {
    let (_, weights) = weights(observations, spread, light);
    let total: f64 = weights.iter().sum();
    (sigmas().zip(&weights).map(|(sigma, weight)| sigma.ln() * weight).sum::<f64>() / total).exp()
}

/// [`maximum_between`] on a logarithmic scale.
fn maximum(range: (f64, f64), coarse: usize, of: impl Fn(f64) -> f64) -> (f64, f64) {
    let (at, most) = maximum_between(range.0.ln(), range.1.ln(), coarse, |at| of(at.exp()));
    (at.exp(), most)
}

/// Where `of` is largest between `low` and `high`, and how large: the best of `coarse` + 1 places, then by golden
/// section between its neighbours.
fn maximum_between(low: f64, high: f64, coarse: usize, of: impl Fn(f64) -> f64) -> (f64, f64) {
    const GOLDEN: f64 = 0.618_033_988_749_895;
    let step = (high - low) / coarse as f64;
    let place = |i: usize| low + step * i as f64;
    let values = (0..=coarse).map(|i| (i, of(place(i))));
    let best = values.fold((0, f64::NEG_INFINITY), |best, one| if one.1 > best.1 { one } else { best }).0;
    let (mut a, mut b) = (place(best.saturating_sub(1)), place((best + 1).min(coarse)));
    let mut inner = [b - GOLDEN * (b - a), a + GOLDEN * (b - a)];
    let mut values = inner.map(&of);
    while b - a > 1e-3 * step {
        if values[0] < values[1] {
            a = inner[0];
            inner = [inner[1], a + GOLDEN * (b - a)];
            values = [values[1], of(inner[1])];
        } else {
            b = inner[1];
            inner = [b - GOLDEN * (b - a), inner[0]];
            values = [of(inner[0]), values[0]];
        }
    }
    if values[0] < values[1] { (inner[1], values[1]) } else { (inner[0], values[0]) }
}

/// Where `of` becomes 0 between `from`, where it is above, and `to`; `None` where it stays above.
fn crossing(from: f64, to: f64, of: impl Fn(f64) -> f64) -> Option<f64> {
    if of(to) > 0.0 {
        return None;
    }
    let (mut above, mut below) = (from, to);
    for _ in 0..24 {
        let middle = (above + below) / 2.0;
        if of(middle) > 0.0 { above = middle } else { below = middle }
    }
    Some((above + below) / 2.0)
}

fn standard_deviation(values: &[f64]) -> Option<f64> {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (values.len() > 1).then(|| (squares / (values.len() - 1) as f64).sqrt())
}
