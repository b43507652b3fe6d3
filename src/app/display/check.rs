//! Checks a profile: it shows uniform squares in fields of rows that should have the same mean luminance. A visible
//! border means that the profile is wrong.

use std::path::PathBuf;

use eframe::egui::{self, TextureHandle};

use super::tool::Tool;
use crate::{
    app::ui::{Monitor, Step, hint, paragraph, pixels, secondary, signed, tool_page, work::Kept},
    display::{
        Channel, DisplayProfile, Viewing,
        matching::{CHECKED, Rows},
    },
};

/// Side of a field and side of the patch in it, physical pixels. Both are whole numbers of periods, for single rows and
/// for pairs.
const FIELD_PX: u32 = 176;
const PATCH_PX: u32 = 88;
/// Error of gamma in the comparison fields.
const ERROR: f64 = 0.2;

/// The fields of a channel: a description and a picture of each.
type Fields = Vec<(String, TextureHandle)>;

pub struct CheckPage {
    profile: DisplayProfile,
    pairs: bool,
    /// The fields of each channel, by the thickness of the rows.
    made: Kept<u32, [(Channel, Fields); 4]>,
}

impl CheckPage {
    /// Creates a check of this profile.
    pub fn new(profile: DisplayProfile) -> Self {
        Self { profile, pairs: false, made: Kept::default() }
    }
}

/// Makes the fields of each channel.
fn made(ctx: &egui::Context, profile: &DisplayProfile, row_px: u32) -> [(Channel, Fields); 4] {
    [Channel::Gray, Channel::Red, Channel::Green, Channel::Blue].map(|channel| {
        let field = |text: String, (lit, period): (u32, u32), error: f64| {
            let rows = Rows { lit, period, row_px };
            let patch = rows.check_patch(&profile.transfers, channel, error);
            let image = rows.picture(channel, patch, [FIELD_PX; 2], PATCH_PX);
            let texture = pixels::texture(ctx, &format!("check {channel} {text}"), &image);
            (text, texture)
        };
        let right = CHECKED.map(|rows| field(format!("{} of {} rows", rows.0, rows.1), rows, 0.0));
        let wrong =
            [-ERROR, ERROR].map(|error| field(format!("off by {}", signed(&format!("{error:+}"))), CHECKED[0], error));
        (channel, right.into_iter().chain(wrong).collect())
    })
}

impl Tool for CheckPage {
    fn show(&mut self, ui: &mut egui::Ui, _: &Monitor, _: Option<&Viewing>) -> Step<PathBuf> {
        let row_px = if self.pairs { 2 } else { 1 };
        let made = self.made.get(row_px, || made(ui.ctx(), &self.profile, row_px));
        Step::back_if(tool_page(ui, "Check the gamma", |ui| {
            paragraph(
                ui,
                "Sit far enough away that the rows blend, or squint. If the profile is correct, the squares in the \
                    first three fields vanish.",
            );
            paragraph(
                ui,
                format!(
                    "For comparison, the last two fields show incorrect profiles: gamma {ERROR} too low and {ERROR} \
                        too high."
                ),
            );
            hint(ui, format!("{}.", self.profile.sentence()));
            ui.checkbox(&mut self.pairs, "Pairs of rows (interlaced pictures, row inversion)");
            ui.add_space(8.0);
            for (channel, fields) in made {
                ui.strong(channel.capitalized());
                // Puts as many fields on a line as fit.
                let side = FIELD_PX as f32 / ui.ctx().pixels_per_point();
                let gap = ui.spacing().item_spacing.x;
                let in_line = ((ui.available_width() + gap) / (side + gap)).floor().max(1.0) as usize;
                for line in fields.chunks(in_line) {
                    ui.horizontal(|ui| {
                        for (text, texture) in line {
                            ui.vertical(|ui| {
                                pixels::picture(ui, texture, &format!("{channel}, {text}"));
                                ui.label(secondary(text));
                            });
                        }
                    });
                }
                ui.add_space(8.0);
            }
        }))
    }
}
