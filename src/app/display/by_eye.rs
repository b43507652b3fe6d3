//! Gamma by eye: estimates γ, with its interval, from matches.

use std::path::Path;

use eframe::egui;

use super::{
    calibrate::{About, Findings, LABELS, Method, Run, SLIDER},
    match_run::MatchRun,
};
use crate::{
    app::{
        session::fresh_seed,
        ui::{Field, paragraph},
    },
    display::{
        Channel, DisplayProfile, Viewing,
        matching::{ChannelGamma, MatchSettings, Matching, estimate, transfers},
    },
    report::names::capitalized,
    store::matches::{self, MatchFile},
};

/// Periods per degree above which rows of full contrast blend. The limit of visual acuity is about 50 to 60.
const BLEND_PER_DEG: f64 = 40.0;

/// The settings of the method.
#[derive(Default)]
pub struct ByEye(MatchSettings);

impl ByEye {
    fn settings(&self, channels: &[Channel]) -> MatchSettings {
        MatchSettings { channels: channels.to_vec(), ..self.0.clone() }
    }
}

impl Method for ByEye {
    fn about(&self) -> About {
        About {
            title: "Gamma by eye",
            purpose: "No photometer needed: match a square to a field of rows in each channel. This takes about five minutes.",
            introduction: "This needs no photometer. If one of every four rows in a field is lit, the field emits a quarter \
                of the full light, whatever the screen's gamma. Adjust the square in the field until it vanishes. Gamma is \
                estimated from several such matches.",
            items: "matches",
            format: Some("A CSV file that this page has written can be used again."),
        }
    }

    fn fields(&mut self, ui: &mut egui::Ui, viewing: Option<&Viewing>) {
        let settings = &mut self.0;
        let periods =
            [(4, "one of four"), (2, "one of two: rows blend at shorter distances; matches are less precise")];
        Field::new("Lit rows").column(LABELS).radio(ui, &mut settings.rows.period, &periods);
        let matches = Field::new("Matches per channel").column(LABELS).width(SLIDER);
        matches.slider(ui, &mut settings.matches, 2..=20, 1.0);
        let mut pairs = settings.rows.row_px == 2;
        Field::new("").column(LABELS).show(ui, |ui, _| {
            ui.checkbox(&mut pairs, "Pairs of rows (interlaced pictures, row inversion)");
        });
        settings.rows.row_px = if pairs { 2 } else { 1 };
        paragraph(ui, distance_sentence(viewing, settings.rows.period_px()));
        paragraph(
            ui,
            "The left and right arrow keys make the square darker and lighter; Page Up and Page Down take large \
                steps. Go past the match on both sides and return to the middle. Press Enter to accept the match, or \
                Backspace to undo the last one.",
        );
        paragraph(
            ui,
            "Dim the room, and keep direct light off the screen. The fields consist of fine rows, may be colored, and \
                may seem to shimmer. Do not do this if you are sensitive to patterns.",
        );
    }

    fn estimate(&self, channels: &[Channel]) -> Result<(usize, f64), String> {
        let planned = Matching::new(&self.settings(channels), 0, Vec::new()).map_err(|error| format!("{error}."))?;
        Ok((planned.total(), planned.remaining_s()))
    }

    fn begin(&self, channels: &[Channel], path: &Path) -> Result<Box<dyn Run>, String> {
        let (file, done) = MatchFile::begin(path, fresh_seed()).map_err(|error| error.to_string())?;
        let matching = Matching::new(&self.settings(channels), file.seed, done)
            .map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(Box::new(MatchRun::new(matching, file)))
    }

    fn read(&self, file: &Path, known: &DisplayProfile) -> Result<Findings, String> {
        let matches = matches::open(file).map_err(|errors| errors.to_string())?;
        let (channels, mut told) = (estimate(&matches), Vec::new());
        for (channel, found) in &channels {
            let name = capitalized(channel.name());
            match found {
                Ok(ChannelGamma { gamma, interval: [low, high], matches }) => {
                    let interval = format!("95 % interval {low:.2} to {high:.2}, from {matches} matches");
                    told.push((format!("{name}: gamma {gamma:.2}, {interval}."), false));
                }
                Err(error) => told.push((format!("{name}: gamma cannot be estimated: {error}."), true)),
            }
            let warning = found.as_ref().ok().and_then(ChannelGamma::warning);
            told.extend(warning.map(|warning| (format!("{name}: {warning}"), true)));
        }
        Ok(Findings {
            told,
            profile: transfers(&channels).map(|transfers| DisplayProfile { transfers, ..known.clone() }),
            instrument: format!("matching by eye, {} matches", matches.len()),
            ..Findings::default()
        })
    }
}

/// Says at what distance rows with this period blend.
fn distance_sentence(viewing: Option<&Viewing>, period_px: u32) -> String {
    let distance = viewing.map_or_else(
        || "far enough away".to_owned(),
        |viewing| {
            let per_deg = viewing.px_per_degree() / f64::from(period_px.max(1));
            format!("at least {:.0} cm away", viewing.distance_cm * BLEND_PER_DEG / per_deg)
        },
    );
    format!(
        "Sit {distance}, so that the rows, which repeat every {period_px} pixels, blend. If you sit closer, squint or take \
            off your glasses until you cannot see the rows."
    )
}
