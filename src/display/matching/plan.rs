//! What is to be matched: channels, levels, method, how often.

use super::Channel;

/// Time of one answer of the staircase, seconds: the empty screen before each picture ([`GAP_S`]), 1 to 1.5 s for a
/// comparison near threshold, and an allowance for looking twice.
pub const ANSWER_S: f64 = 2.5;
/// Time of one adjustment with the slider, seconds: about ten steps at a few a second, there and back, then a look.
pub const ADJUSTMENT_S: f64 = 10.0;
/// Empty screen between two pictures, seconds, so that the afterimage of one does not lie over the next. Part of
/// [`ANSWER_S`] and [`ADJUSTMENT_S`].
pub const GAP_S: f64 = 0.4;

/// Rows of a period that still blend from where people can sit.
const PERIODS: std::ops::RangeInclusive<u32> = 2..=8;
/// Most trials of one channel, to keep a slip of the finger from planning a day's work.
const MOST_TRIALS: u32 = 2000;

/// How the observer answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Brighter or darker; the next patch follows from the answers so far.
    Staircase,
    /// The observer moves the patch's code from a random start until the border vanishes.
    Adjustment,
}

impl Method {
    /// Time of one trial, seconds.
    #[must_use]
    pub fn trial_s(self) -> f64 {
        match self {
            Method::Staircase => ANSWER_S,
            Method::Adjustment => ADJUSTMENT_S,
        }
    }
}

/// One light to be matched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// Rows of a period that have the high code.
    pub lit: u32,
    /// Rows of a period, 2…8.
    pub period: u32,
    /// Light share of the low rows, 0…1: 0 is code 0, any other the code matched to it so far.
    pub lo: f64,
    /// Light share of the high rows, 0…1: 1 is code 255, any other the code matched to it so far.
    pub hi: f64,
    /// Trials for each channel.
    pub trials: u32,
}

impl Level {
    /// `lit` of `period` rows at full light, the others dark.
    #[must_use]
    pub fn of_full(lit: u32, period: u32, trials: u32) -> Self {
        Self { lit, period, lo: 0.0, hi: 1.0, trials }
    }

    /// The mean light of the field: what the patch is to be matched to, 0…1.
    #[must_use]
    pub fn share(&self) -> f64 {
        self.lo + (self.hi - self.lo) * f64::from(self.lit) / f64::from(self.period)
    }

    fn check(&self) -> Result<(), PlanError> {
        let rows = PERIODS.contains(&self.period) && (1..self.period).contains(&self.lit);
        if rows && self.lo >= 0.0 && self.lo < self.hi && self.hi <= 1.0 {
            return Ok(());
        }
        Err(PlanError::Level { lit: self.lit, period: self.period, lo: self.lo, hi: self.hi })
    }
}

/// Which halftones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pattern {
    /// One row of four, and half of the rows: the most to learn from a match.
    Quarters,
    /// Half of the rows only: they blend from half as far away; the same spread takes four times as many trials.
    Halves,
}

/// How many trials.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// A third of the standard: a first look.
    Quick,
    /// Three channels in five minutes.
    Standard,
    /// Twice the standard.
    Thorough,
}

/// What is to be matched.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Each once.
    pub channels: Vec<Channel>,
    /// Each channel is matched at all of them.
    pub levels: Vec<Level>,
    /// How the observer answers.
    pub method: Method,
    /// Thickness of a row, 1 or 2 pixels; 2 for interlaced pictures and panels that invert from row to row.
    pub row_px: u32,
    /// Trials a channel in which the patch is plainly brighter or darker, to see whether the observer looks. Staircase
    /// only.
    pub catches: u32,
}

/// Why there is nothing to run.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// None, or one twice.
    #[error("the channels are {0:?}; expected at least one of red, green, blue and gray, each once")]
    Channels(Vec<Channel>),
    /// No trials, or far too many.
    #[error("the plan has {0} trials a channel; expected 1…2000")]
    Trials(u32),
    /// Rows that make no halftone.
    #[error(
        "{lit} of {period} rows between light {lo} and {hi} is no halftone; expected a period of 2…8 rows, at least one lit and one not, and 0 ≤ low < high ≤ 1"
    )]
    Level {
        /// Rows lit.
        lit: u32,
        /// Rows of a period.
        period: u32,
        /// Light share of the low rows.
        lo: f64,
        /// Light share of the high rows.
        hi: f64,
    },
    /// Rows of a thickness that does not blend.
    #[error("rows of {0} pixels; expected 1 or 2")]
    RowPx(u32),
}

impl Plan {
    /// The usual plan. Most trials are at the low levels, which tell most about γ; the others show whether one γ holds
    /// everywhere.
    #[must_use]
    pub fn new(channels: &[Channel], method: Method, pattern: Pattern, effort: Effort) -> Self {
        // Quick, standard, thorough, for each level.
        let trials = |staircase: [u32; 3], adjustment: [u32; 3]| {
            let of_method = if method == Method::Staircase { staircase } else { adjustment };
            of_method[effort as usize]
        };
        let half = |lo: f64, hi: f64, trials: u32| Level { lit: 1, period: 2, lo, hi, trials };
        let levels = match pattern {
            Pattern::Quarters => vec![
                Level::of_full(1, 4, trials([6, 16, 32], [2, 4, 8])),
                Level { hi: 0.25, ..Level::of_full(1, 4, trials([5, 17, 34], [1, 4, 8])) },
                half(0.0, 1.0, trials([1, 4, 8], [1, 1, 2])),
                half(0.5, 1.0, trials([1, 1, 2], [0, 1, 2])),
            ],
            Pattern::Halves => vec![
                half(0.0, 1.0, trials([4, 13, 26], [2, 3, 6])),
                half(0.0, 0.5, trials([4, 13, 26], [1, 3, 6])),
                half(0.0, 0.25, trials([4, 11, 22], [1, 3, 6])),
                half(0.5, 1.0, trials([1, 1, 2], [0, 1, 2])),
            ],
        };
        let catches = trials([1, 2, 4], [0, 0, 0]);
        Self { channels: channels.to_vec(), levels, method, row_px: 1, catches }
    }

    /// Trials of one channel, the catch trials included.
    #[must_use]
    pub fn trials_per_channel(&self) -> u32 {
        let catches = if self.method == Method::Staircase { self.catches } else { 0 };
        self.levels.iter().fold(catches, |sum, level| sum.saturating_add(level.trials))
    }

    /// Trials in all.
    #[must_use]
    pub fn trials(&self) -> u32 {
        self.trials_per_channel().saturating_mul(self.channels.len() as u32)
    }

    /// Time of all trials by [`Method::trial_s`], seconds.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        f64::from(self.trials()) * self.method.trial_s()
    }

    /// The longest period in pixels: what has to blend.
    #[must_use]
    pub fn longest_period_px(&self) -> u32 {
        let rows = self.levels.iter().filter(|level| level.trials > 0).map(|level| level.period).max();
        rows.unwrap_or(0) * self.row_px
    }

    /// Whether it can be run.
    ///
    /// # Errors
    /// The first thing that cannot be.
    pub fn validate(&self) -> Result<(), PlanError> {
        let twice = self.channels.iter().enumerate().any(|(i, channel)| self.channels[..i].contains(channel));
        if self.channels.is_empty() || twice {
            return Err(PlanError::Channels(self.channels.clone()));
        }
        self.levels.iter().try_for_each(Level::check)?;
        if !(1..=2).contains(&self.row_px) {
            return Err(PlanError::RowPx(self.row_px));
        }
        let trials = self.trials_per_channel();
        if self.levels.iter().all(|level| level.trials == 0) || trials > MOST_TRIALS {
            return Err(PlanError::Trials(trials));
        }
        Ok(())
    }
}
