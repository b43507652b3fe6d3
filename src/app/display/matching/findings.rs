//! What the matches say: γ with its interval.

use std::path::Path;

use eframe::egui;
use egui_plot::{Corner, Legend, Line, PlotPoints, Points};

use crate::{
    app::{
        display::calibrate::{Findings, series},
        ui::{describe, note, still_plot, table},
    },
    display::{
        Channel, DisplayProfile,
        matching::{ChannelGamma, GammaError, estimate, transfers},
    },
    store::matches,
};

/// γ of each channel.
pub struct MatchFindings {
    channels: Vec<(Channel, Result<ChannelGamma, GammaError>)>,
    matches: usize,
}

impl MatchFindings {
    fn found(&self) -> impl Iterator<Item = &ChannelGamma> {
        self.channels.iter().filter_map(|(_, found)| found.as_ref().ok())
    }
}

impl Findings for MatchFindings {
    fn read(path: &Path) -> Result<Self, String> {
        let matches = matches::open(path).map_err(|faults| faults.to_string())?;
        Ok(Self { channels: estimate(&matches), matches: matches.len() })
    }

    fn summary(&mut self, ui: &mut egui::Ui) {
        for (channel, found) in &self.channels {
            let name = channel.capitalized();
            match found {
                Ok(found) => {
                    let [low, high] = found.interval;
                    let matches = found.matches;
                    ui.label(format!(
                        "{name}: gamma {:.2}, 95 % interval {low:.2} to {high:.2}, from {matches} matches.",
                        found.gamma
                    ));
                    found.warning().iter().for_each(|warning| note(ui, warning));
                }
                Err(error) => note(ui, format!("{name}: no gamma: {error}.")),
            }
        }
    }

    fn details(&self, ui: &mut egui::Ui) {
        let plot = still_plot("matching").height(260.0).x_axis_label("code").y_axis_label("light, of full light");
        let shown = plot.legend(Legend::default().position(Corner::LeftTop)).show(ui, |plot| {
            for found in self.found() {
                let ((color, marker), name) = (series(found.channel), found.channel.name());
                let curve: PlotPoints<'_> =
                    (0..=255).map(f64::from).map(|code| [code, (code / 255.0).powf(found.gamma)]).collect();
                plot.line(Line::new(name, curve).color(color).width(1.5));
                plot.points(Points::new(name, vec![[found.code, found.share]]).shape(marker).radius(4.5).color(color));
                let ends = [-1.0, 1.0].map(|side| [found.code + side * found.code_sd, found.share]);
                plot.line(Line::new(name, ends.to_vec()).color(color).width(3.0));
            }
        });
        describe(&shown.response, "Plot of the matches and of gamma");
        let rows = self.found().map(|found| {
            let [code, sd] = [found.code, found.code_sd].map(|value| format!("{value:.1}"));
            [found.channel.to_string(), format!("{:.2}", found.share), code, sd, found.matches.to_string()]
        });
        table(ui, "matches", ["channel", "light of the field", "matched code", "SD", "matches"], rows);
    }

    fn profile(&self, known: &DisplayProfile) -> Option<DisplayProfile> {
        transfers(&self.channels).map(|transfers| DisplayProfile { transfers, ..known.clone() })
    }

    fn instrument(&self) -> String {
        format!("matching by eye, {} matches", self.matches)
    }
}
