//! How a screen is matched by eye.

use std::{
    path::Path,
    time::{SystemTime, UNIX_EPOCH},
};

use eframe::egui;

use super::{findings::MatchFindings, pictures::MatchRun};
use crate::{
    app::{
        display::calibrate::Method,
        ui::{Field, paragraph},
    },
    display::{
        Channel, Viewing,
        matching::{MatchSettings, Matching, Pattern},
    },
    experiment::session_seed,
    store::matches::MatchFile,
};

/// Periods per degree from which rows of full contrast blend: near the limit of sight, 50 to 60.
const BLEND_PER_DEG: f64 = 40.0;

/// The settings.
#[derive(Default)]
pub struct ByEye(MatchSettings);

impl ByEye {
    fn settings(&self, channels: &[Channel]) -> MatchSettings {
        MatchSettings { channels: channels.to_vec(), ..self.0.clone() }
    }
}

impl Method for ByEye {
    type Findings = MatchFindings;
    type Run = MatchRun;

    const BEGIN: &'static str = "Begin";
    const FORMAT: &'static str = "CSV as this page writes it.";
    const INTRODUCTION: &'static str = "Without a photometer: half of the rows at full light and half dark make a known light, and so does one row of four. Adjust a square until it vanishes in such a field. From several matches follows gamma.";
    const ITEMS: &'static str = "matches";
    const TITLE: &'static str = "Gamma by eye";

    fn fields(&mut self, ui: &mut egui::Ui, viewing: Option<&Viewing>) {
        let settings = &mut self.0;
        Field::new("Lit rows").radio(
            ui,
            &mut settings.pattern,
            &[(Pattern::Quarter, "one of four"), (Pattern::Half, "half: they blend from nearer, but are less precise")],
        );
        Field::new("Matches of each channel").slider(ui, &mut settings.matches, 2..=20, 1.0);
        let mut pairs = settings.row_px == 2;
        ui.checkbox(&mut pairs, "Pairs of rows (interlaced pictures, row inversion)");
        settings.row_px = if pairs { 2 } else { 1 };
        paragraph(ui, distance_sentence(viewing, settings.rows().period_px()));
        paragraph(
            ui,
            "Arrow right and left make the square lighter and darker, page up and down in large steps. Go past the match on both sides and come back to the middle; Enter accepts. Backspace takes the last match back.",
        );
        paragraph(
            ui,
            "Dim the room, and let no lamp shine on the screen. The fields can be colored and full of fine rows, and may seem to shimmer: do not do this if you are sensitive to patterns.",
        );
    }

    fn extent(&self, channels: &[Channel]) -> Result<(usize, f64), String> {
        let settings = self.settings(channels);
        Matching::new(&settings, 0, Vec::new()).map_err(|error| format!("{error}."))?;
        Ok((settings.total(), settings.duration_s()))
    }

    fn begin(&self, channels: &[Channel], path: &Path) -> Result<MatchRun, String> {
        let (file, done) = if path.exists() {
            MatchFile::resume(path).map_err(|error| error.to_string())?
        } else {
            let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |time| time.as_nanos() as u64);
            (MatchFile::create(path, session_seed(now)).map_err(|error| error.to_string())?, Vec::new())
        };
        let matching = Matching::new(&self.settings(channels), file.seed(), done)
            .map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(MatchRun::new(matching, file))
    }
}

/// From where rows of this period blend.
fn distance_sentence(viewing: Option<&Viewing>, period_px: u32) -> String {
    let otherwise = "From nearer, half close your eyes or take off your glasses until you see no rows.";
    let Some(viewing) = viewing else {
        return format!("Sit so far back that the rows, {period_px} pixels from one to the next, blend. {otherwise}");
    };
    let per_deg = viewing.px_per_degree() / f64::from(period_px.max(1));
    let needed_cm = viewing.distance_cm() * BLEND_PER_DEG / per_deg;
    let counted =
        format!("From {:.0} cm, a degree has {per_deg:.0} periods of {period_px} pixels", viewing.distance_cm());
    if per_deg >= BLEND_PER_DEG {
        return format!("{counted}: the rows blend.");
    }
    format!("{counted}, and you may see the rows; they blend from {needed_cm:.0} cm on. {otherwise}")
}
