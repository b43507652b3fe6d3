//! The tables of a display's calibration.

use super::document::{Shown, TextTable};
use crate::display::photometer::{Calibration, Family, FittedChannel};

/// Returns the fitted models, channel by channel, and how well each predicts levels that were left out.
pub fn tables(calibration: &Calibration) -> [TextTable; 2] {
    let models = calibration.models.iter();
    let channels = models.clone().flat_map(|model| model.channels.iter().map(|channel| cells(model.family, channel)));
    let fits = TextTable {
        caption: "fitted models".to_owned(),
        header: ["model", "channel", "gamma", "gain", "offset", "R²", "largest codes"].map(str::to_owned).into(),
        texts: 2,
        rows: channels.collect(),
    };
    let validated = models.map(|model| vec![model.family.name().into(), decimals(model.validation.rms_codes, 2)]);
    let validation = TextTable {
        caption: "leave-one-level-out error".to_owned(),
        header: ["model", "rms codes"].map(str::to_owned).into(),
        texts: 1,
        rows: validated.collect(),
    };
    [fits, validation]
}

/// Formats a number with this many decimals.
fn decimals(number: f64, decimals: usize) -> Shown {
    Shown::new(number, format!("{number:.decimals$}"))
}

/// Formats a number if it is known.
fn known(value: Option<f64>, text: &dyn Fn(f64) -> String) -> Shown {
    Shown::new(value, value.map_or_else(|| "—".to_owned(), text))
}

fn cells(family: Family, channel: &FittedChannel) -> Vec<Shown> {
    let se = channel.gamma_se.map_or_else(String::new, |se| format!(" ± {se:.4}"));
    let (gain, offset) = channel.curve.gain_and_offset().unzip();
    vec![
        family.name().into(),
        channel.channel.name().into(),
        known(channel.curve.gamma(), &|gamma| format!("{gamma:.4}{se}")),
        known(gain, &|gain| format!("{gain:.4}")),
        // Adding 0 turns −0 into 0.
        known(offset, &|offset| format!("{:+.4}", (1e4 * offset).round() / 1e4 + 0.0)),
        decimals(channel.r_squared, 6),
        decimals(channel.largest_codes, 2),
    ]
}
