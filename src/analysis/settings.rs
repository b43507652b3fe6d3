//! Settings of a value: the method of adjustment, and ratings on a continuous scale.

use serde::Serialize;

use crate::statistics::mean_and_sd;

/// The settings of a person in a condition.
#[derive(Clone, Debug, PartialEq, Serialize)]
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
