//! The tables of a display's calibration.

use super::document::{Shown, TableOf, TextTable};
use crate::display::photometer::{Calibration, Family, FittedChannel};

/// Returns the fitted models, channel by channel, and how well each predicts levels that were left out.
pub fn tables(calibration: &Calibration) -> [TextTable; 2] {
    let models = &calibration.models;
    let channels = models.iter().flat_map(|model| model.channels.iter().map(|channel| (model.family, channel)));
    let channels: Vec<(Family, &FittedChannel)> = channels.collect();
    let fits = TableOf::new("Fitted models", &channels)
        .text("model", |(family, _)| family.name())
        .text("channel", |(_, own)| own.channel.name())
        .number("gamma", |(_, own)| {
            let se = own.gamma_se.map_or_else(String::new, |se| format!(" ± {se:.4}"));
            known(own.curve.gamma(), &|gamma| format!("{gamma:.4}{se}"))
        })
        .number("gain", |(_, own)| known(own.curve.gain_and_offset().map(|both| both.0), &|gain| format!("{gain:.4}")))
        .number("offset", |(_, own)| {
            // Adding 0 turns −0 into 0.
            let text = |offset: f64| format!("{:+.4}", (1e4 * offset).round() / 1e4 + 0.0);
            known(own.curve.gain_and_offset().map(|both| both.1), &text)
        })
        .number("R²", |(_, own)| decimals(own.r_squared, 6))
        .number("largest codes", |(_, own)| decimals(own.largest_codes, 2));
    let validation = TableOf::new("Leave-one-level-out error", models)
        .text("model", |model| model.family.name())
        .number("rms codes", |model| decimals(model.validation.rms_codes, 2));
    [fits.into(), validation.into()]
}

/// Formats a number with this many decimals.
fn decimals(number: f64, decimals: usize) -> Shown {
    Shown::new(number, format!("{number:.decimals$}"))
}

/// Formats a number if it is known.
fn known(value: Option<f64>, text: &dyn Fn(f64) -> String) -> Shown {
    Shown::new(value, value.map_or_else(|| "—".to_owned(), text))
}
