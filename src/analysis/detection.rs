//! Signal detection: how well targets are told from catch trials, and how readily an observer says yes.

use serde::Serialize;

use crate::experiment::task::Curve;

/// The answers of a person to targets and to catch trials.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
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
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
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
