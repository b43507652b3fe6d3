//! The check: rows beside the uniform code that should have their light. A visible border means the profile is wrong.

use eframe::egui::{self, TextureHandle};

use super::signs::signed;
use crate::{
    app::ui::{Step, hint, paragraph, pixels, quiet, tool_page},
    display::{
        Channel, DisplayProfile,
        matching::{CHECKED, CheckField, Rows},
    },
};

/// Side of a field and of the patch in it, physical pixels; both whole periods of rows and of pairs.
const FIELD_PX: u32 = 176;
const PATCH_PX: u32 = 88;
/// How wrong the fields for comparison are.
const ERROR: f64 = 0.2;

/// The page.
pub struct CheckPage {
    profile: DisplayProfile,
    pairs: bool,
    /// Made of rows of this thickness.
    made: Option<(u32, Vec<Strip>)>,
}

/// The fields of a channel.
struct Strip {
    channel: Channel,
    /// Each with what it shows.
    fields: Vec<(String, TextureHandle)>,
}

impl CheckPage {
    /// For a screen of this profile.
    pub fn new(profile: DisplayProfile) -> Self {
        Self { profile, pairs: false, made: None }
    }

    /// Draws the page.
    pub fn show(&mut self, ui: &mut egui::Ui) -> Step {
        self.make(ui.ctx());
        let (back, ()) = tool_page(ui, "Check the gamma", |ui| {
            paragraph(
                ui,
                "Sit so far back, or half close your eyes, that the rows blend. Where the profile is right, the squares in the first three fields vanish.",
            );
            paragraph(
                ui,
                format!(
                    "The last two fields are examples of a wrong profile: a gamma {ERROR} too low, and {ERROR} too high."
                ),
            );
            hint(ui, format!("{}.", self.profile.sentence()));
            ui.checkbox(&mut self.pairs, "Pairs of rows (interlaced pictures, row inversion)");
            ui.add_space(8.0);
            for strip in self.made.iter().flat_map(|(_, strips)| strips) {
                ui.strong(strip.channel.capitalized());
                // As many side by side as there is room for.
                let side = FIELD_PX as f32 / ui.ctx().pixels_per_point();
                let gap = ui.spacing().item_spacing.x;
                let beside = ((ui.available_width() + gap) / (side + gap)).floor().max(1.0) as usize;
                for fields in strip.fields.chunks(beside) {
                    ui.horizontal(|ui| fields.iter().for_each(|field| show_field(ui, strip.channel, field)));
                }
                ui.add_space(8.0);
            }
        });
        Step::back_if(back)
    }

    fn make(&mut self, ctx: &egui::Context) {
        let row_px = if self.pairs { 2 } else { 1 };
        if self.made.as_ref().is_some_and(|(made, _)| *made == row_px) {
            return;
        }
        let strip = |channel: Channel| {
            let field = |text: String, (lit, period): (u32, u32), error: f64| {
                let rows = Rows { lit, period, row_px };
                let image = CheckField::new(&self.profile.transfers, channel, rows, error).picture(FIELD_PX, PATCH_PX);
                let texture = pixels::texture_of(ctx, &format!("check {channel} {text}"), &image);
                (text, texture)
            };
            let right = CHECKED.map(|rows| field(format!("{} of {} rows", rows.0, rows.1), rows, 0.0));
            let wrong = [-ERROR, ERROR]
                .map(|error| field(format!("wrong by {}", signed(&format!("{error:+}"))), CHECKED[0], error));
            Strip { channel, fields: right.into_iter().chain(wrong).collect() }
        };
        let strips = [Channel::Gray, Channel::Red, Channel::Green, Channel::Blue].map(strip);
        self.made = Some((row_px, strips.into()));
    }
}

fn show_field(ui: &mut egui::Ui, channel: Channel, (text, texture): &(String, TextureHandle)) {
    ui.vertical(|ui| {
        pixels::picture(ui, texture, &format!("{channel}, {text}"));
        ui.label(quiet(text));
    });
}
