//! What a reader of a calibration should know.

use super::{additivity::ADDITIVE_PERCENT, calibration::Calibration, plan::Drift, reading::Channel, shape::Family};

/// Uncertainty of γ (standard error) above which more readings are advised.
const GAMMA_SE: f64 = 0.01;
/// Noise above which readings are unsteady.
const UNSTEADY: f64 = 0.03;
/// Change of white that asks for a longer warm-up, percent.
const DRIFT_PERCENT: f64 = 2.0;

/// A remark; the profile can be used.
#[derive(Clone, Debug, PartialEq)]
pub enum Note {
    /// Channels that were not read take gray's curve.
    AsGray(Vec<Channel>),
    /// Gray is not the sum of the channels: percent at white.
    NotAdditive(f64),
    /// The channels differ at level 0.
    BlackDiffers,
    /// White changed, percent.
    Drift(Drift),
    /// γ is not known well: its standard error.
    UncertainGamma(f64),
    /// Readings are noisy: relative.
    Noisy(f64),
    /// No curve fits: the table is bent.
    Bent,
}

impl std::fmt::Display for Note {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::AsGray(channels) => {
                let names: Vec<&str> = channels.iter().map(|channel| channel.name()).collect();
                write!(f, "{} not read: taken to have gray's curve", names.join(", "))
            }
            Self::NotAdditive(percent) => write!(
                f,
                "channels not additive: white has {percent:+.1} % of red + green + blue; colors other than grays will be off (limit {ADDITIVE_PERCENT} %)"
            ),
            Self::BlackDiffers => f.write_str(
                "black differs between channels, though level 0 is the same patch in all: the screen, the room or the photometer changed meanwhile",
            ),
            Self::Drift(drift) => write!(
                f,
                "white changed by {:+.1} % during the measurement: let the screen warm up for half an hour",
                drift.percent
            ),
            Self::UncertainGamma(se) => write!(
                f,
                "gamma is known to ±{:.3} (95 %) only: more levels, or several readings a level, make it better",
                1.96 * se
            ),
            Self::Noisy(relative) => {
                write!(f, "readings scatter by {:.1} %: a steadier photometer, or several readings a level, are advised", 100.0 * relative)
            }
            Self::Bent => f.write_str("no curve fits the readings within their noise: the table follows them"),
        }
    }
}

pub(super) fn all(calibration: &Calibration, own_black: bool) -> Vec<Note> {
    let mut notes = Vec::new();
    let unread: Vec<Channel> = [Channel::Red, Channel::Green, Channel::Blue]
        .into_iter()
        .filter(|channel| !calibration.readings.has(*channel))
        .collect();
    if !unread.is_empty() {
        notes.push(Note::AsGray(unread));
    }
    if let Some(additivity) = calibration.additivity.as_ref().filter(|additivity| !additivity.holds()) {
        notes.extend(additivity.sums.last().map(|white| Note::NotAdditive(white.deviation_percent())));
    }
    if own_black {
        notes.push(Note::BlackDiffers);
    }
    notes.extend(calibration.drift.filter(|drift| drift.percent.abs() > DRIFT_PERCENT).map(Note::Drift));
    if calibration.chosen == Family::Table {
        notes.push(Note::Bent);
    }
    let errors = calibration.model(calibration.chosen).channels.iter().filter_map(|channel| channel.gamma_se);
    let largest = errors.fold(0.0, f64::max);
    if largest > GAMMA_SE {
        notes.push(Note::UncertainGamma(largest));
    }
    if calibration.noise.relative > UNSTEADY {
        notes.push(Note::Noisy(calibration.noise.relative));
    }
    notes
}
