//! The answers of one person in one condition. Signal detection: how well targets are told from catch trials, and how
//! readily an observer says yes. Settings of a value: the method of adjustment, and ratings on a continuous scale.

use crate::{experiment::task::Curve, statistics::mean_and_sd};

/// The answers of a person to targets and to catch trials.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Answers {
    /// Targets answered yes.
    pub hits: u32,
    /// Targets answered no.
    pub misses: u32,
    /// Catch trials answered yes.
    pub false_alarms: u32,
    /// Catch trials answered no.
    pub correct_rejections: u32,
}

/// Sensitivity and criterion under the equal-variance model, with the log-linear correction, which adds ½ to each count
/// (Hautus 1995, Behav. Res. Methods 27, 46), so that shares of 0 and 1 stay finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detection {
    /// d′ = z(H) − z(F): the distance between targets and catch trials, in standard deviations of the noise.
    pub d_prime: f64,
    /// c = −(z(H) + z(F))/2: above 0 if the observer says yes less readily than an unbiased one.
    pub criterion: f64,
}

impl Answers {
    /// Returns sensitivity and criterion; `None` without targets or without catch trials.
    pub fn detection(&self) -> Option<Detection> {
        let [targets, catches] = [self.hits + self.misses, self.false_alarms + self.correct_rejections];
        if targets == 0 || catches == 0 {
            return None;
        }
        let share = |yes: u32, all: u32| (f64::from(yes) + 0.5) / (f64::from(all) + 1.0);
        let h = Curve::Normal.inverse(share(self.hits, targets));
        let f = Curve::Normal.inverse(share(self.false_alarms, catches));
        Some(Detection { d_prime: h - f, criterion: -0.5 * (h + f) })
    }
}

/// The settings of a person in a condition.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The mean.
    pub mean: f64,
    /// The standard deviation between settings; `None` for a single one.
    pub sd: Option<f64>,
    /// The number of settings.
    pub n: usize,
    /// The mean of those that began above, minus the mean of those that began below; `None` without both.
    pub direction: Option<f64>,
}

impl Settings {
    /// Summarizes settings, each with whether it began above; `None` if there are none. The values are on the scale to
    /// summarize on: logarithms, if ratios matter.
    pub fn of(settings: &[(f64, Option<bool>)]) -> Option<Self> {
        let values: Vec<f64> = settings.iter().map(|(value, _)| *value).collect();
        let from = |above: bool| {
            let own: Vec<f64> =
                settings.iter().filter(|(_, from)| *from == Some(above)).map(|(value, _)| *value).collect();
            (!own.is_empty()).then(|| mean_and_sd(&own).0)
        };
        let (mean, sd) = mean_and_sd(&values);
        let direction = from(true).zip(from(false)).map(|(above, below)| above - below);
        let sd = (values.len() > 1).then_some(sd);
        (!values.is_empty()).then_some(Self { mean, sd, n: values.len(), direction })
    }
}
