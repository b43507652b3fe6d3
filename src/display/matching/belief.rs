//! What the answers so far say of one channel, to choose the next patch: a Bayesian staircase on a grid of γ and of the
//! observer's spread (after Watson and Pelli 1983, doi:10.3758/BF03202828, who place each trial where the answers before
//! it put the threshold).
//!
//! The display need not follow a power exactly: a level is placed by its own answers and by those of the other levels,
//! these blurred, so that each level can find a γ of its own.

use std::sync::LazyLock;

use super::{
    observation::{Observation, RowField},
    plan::Plan,
};

/// Exponents, evenly spaced in their logarithm.
const GAMMAS: usize = 121;
/// The lowest exponent of the grid.
const LOWEST: f64 = 0.9;
/// The highest exponent of the grid.
const HIGHEST: f64 = 4.5;
/// Spreads of the comparison, natural logarithms of light: thresholds of 0.7 % to 13 %.
const SIGMAS: [f64; 5] = [0.01, 0.02, 0.04, 0.08, 0.2];
/// How far the γ of one level may lie from that of the others, standard deviation.
const BETWEEN_LEVELS: f64 = 0.1;
/// Most a display's γ is expected to lie from [`TYPICAL`], standard deviation. Places the first trials only: no part of
/// the estimate.
const PRIOR_SD: f64 = 0.6;
/// The γ of most displays.
const TYPICAL: f64 = 2.2;

/// The exponents, and how strongly each is smeared over each: the same for every channel and run.
static GRID: LazyLock<(Vec<f64>, Vec<Vec<f64>>)> = LazyLock::new(|| {
    let step = (HIGHEST / LOWEST).ln() / (GAMMAS - 1) as f64;
    let gammas: Vec<f64> = (0..GAMMAS).map(|i| LOWEST * (step * i as f64).exp()).collect();
    let near = |a: f64, b: f64| (-0.5 * ((a - b) / BETWEEN_LEVELS).powi(2)).exp();
    let blur = gammas.iter().map(|at| gammas.iter().map(|from| near(*from, *at)).collect()).collect();
    (gammas, blur)
});

/// What the answers of one channel say.
#[derive(Clone, Debug)]
pub struct Belief {
    /// For each level, the log-likelihood of each γ and, within it, each spread.
    levels: Vec<Vec<f64>>,
}

impl Belief {
    /// Before the first answer.
    #[must_use]
    pub fn new(plan: &Plan) -> Self {
        Self { levels: vec![vec![0.0; GAMMAS * SIGMAS.len()]; plan.levels.len()] }
    }

    /// Takes an answer in.
    pub fn update(&mut self, observation: &Observation) {
        let Some(level) = self.levels.get_mut(observation.level) else { return };
        for (gamma, row) in GRID.0.iter().zip(level.chunks_mut(SIGMAS.len())) {
            let log_ratio = observation.log_ratio(|code| (f64::from(code) / 255.0).powf(*gamma));
            for (sigma, cell) in SIGMAS.iter().zip(row) {
                *cell += observation.log_likelihood(log_ratio, *sigma);
            }
        }
    }

    /// The γ of all levels together.
    #[must_use]
    pub fn gamma(&self) -> f64 {
        mean_gamma(&self.weights(|_| true, true))
    }

    /// The γ that the level `level` is matched with.
    #[must_use]
    pub fn gamma_of(&self, level: usize) -> f64 {
        let own = self.weights(|l| l == level, false);
        let others = self.weights(|l| l != level, true);
        let smeared = |row: &Vec<f64>| row.iter().zip(&others).map(|(near, weight)| near * weight).sum::<f64>();
        let both: Vec<f64> = GRID.1.iter().zip(own).map(|(row, own)| smeared(row) * own).collect();
        mean_gamma(&both)
    }

    /// The observer's spread, natural logarithms of light.
    #[must_use]
    pub fn sigma(&self) -> f64 {
        let sums = self.sums(|_| true);
        let most = sums.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mut weights = [0.0; SIGMAS.len()];
        for row in sums.chunks(SIGMAS.len()) {
            weights.iter_mut().zip(row).for_each(|(weight, sum)| *weight += (sum - most).exp());
        }
        let total: f64 = weights.iter().sum();
        (weights.iter().zip(SIGMAS).map(|(weight, sigma)| weight * sigma.ln()).sum::<f64>() / total).exp()
    }

    /// The code that is believed to make the light `share`, 0…1.
    #[must_use]
    pub fn code(&self, share: f64) -> u8 {
        code_of(share, self.gamma())
    }

    /// The code of a patch that is believed to have e^`log_ratio` times the light of `rows`, at the plan's level
    /// `level`.
    #[must_use]
    pub fn patch(&self, level: usize, rows: &RowField, log_ratio: f64) -> u8 {
        let gamma = self.gamma_of(level);
        let field = rows.mean(|code| (f64::from(code) / 255.0).powf(gamma));
        code_of(field * log_ratio.exp(), gamma)
    }

    fn sums(&self, of: impl Fn(usize) -> bool) -> Vec<f64> {
        let mut sums = vec![0.0; GAMMAS * SIGMAS.len()];
        for (_, level) in self.levels.iter().enumerate().filter(|(l, _)| of(*l)) {
            sums.iter_mut().zip(level).for_each(|(sum, cell)| *sum += cell);
        }
        sums
    }

    /// The weight of each γ, whatever the spread.
    fn weights(&self, of: impl Fn(usize) -> bool, prior: bool) -> Vec<f64> {
        let sums = self.sums(of);
        let most = sums.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let rows = sums.chunks(SIGMAS.len()).map(|row| row.iter().map(|sum| (sum - most).exp()).sum::<f64>());
        let before = |gamma: f64| if prior { (-0.5 * ((gamma - TYPICAL) / PRIOR_SD).powi(2)).exp() } else { 1.0 };
        GRID.0.iter().zip(rows).map(|(gamma, weight)| weight * before(*gamma)).collect()
    }
}

fn mean_gamma(weights: &[f64]) -> f64 {
    let total: f64 = weights.iter().sum();
    let sum: f64 = GRID.0.iter().zip(weights).map(|(gamma, weight)| gamma * weight).sum();
    // Answers that contradict each other beyond all measure leave no weight anywhere.
    if total > 0.0 { sum / total } else { TYPICAL }
}

/// The code whose light is nearest to `light`, 0…1, in code space; 0…255.
fn code_of(light: f64, gamma: f64) -> u8 {
    (light.clamp(0.0, 1.0).powf(gamma.recip()) * 255.0).round() as u8
}
