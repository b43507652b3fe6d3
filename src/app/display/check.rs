//! The check: rows beside the uniform code that a profile says has their light. A border shows where it is wrong.

use eframe::egui::{self, Key, TextureHandle};

use super::{ToolGo, picture::wide_picture, signed, tool};
use crate::{
    app::{Monitor, pixels, theme},
    display::{
        DisplayProfile,
        matching::{Channel, CheckField, check::CHECKED},
    },
    light::CodeImage,
};

/// Side of a field and of the patch in it, physical pixels; both whole periods of rows and of pairs.
const FIELD_PX: u32 = 176;
const PATCH_PX: u32 = 88;
/// How wrong the fields for comparison are.
const ERROR: f64 = 0.2;

/// The page.
pub struct CheckScreen {
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

impl CheckScreen {
    /// For a screen of this profile.
    pub fn new(profile: DisplayProfile) -> Self {
        Self { profile, pairs: false, made: None }
    }

    /// Draws the page.
    pub fn show(&mut self, ui: &mut egui::Ui, _: &Monitor) -> ToolGo {
        let mut back = false;
        self.make(ui.ctx());
        tool(ui, "Check the gamma", &mut back, |ui| {
            ui.label("Sit so far back, or half close your eyes, that the rows blend. Where the profile is right, the squares in the first three fields vanish.");
            ui.label(format!(
                "The last two fields show what wrong looks like: a gamma {ERROR} too low, and {ERROR} too high."
            ));
            ui.add(egui::Label::new(theme::quiet(format!("{}.", self.profile.sentence()))).wrap());
            ui.checkbox(&mut self.pairs, "Pairs of rows (interlaced pictures, row inversion)");
            ui.add_space(8.0);
            for strip in self.made.iter().flat_map(|(_, strips)| strips) {
                ui.strong(capital(strip.channel));
                // As many beside each other as there is room for.
                let side = FIELD_PX as f32 / ui.ctx().pixels_per_point();
                let gap = ui.spacing().item_spacing.x;
                let beside = ((ui.available_width() + gap) / (side + gap)).floor().max(1.0) as usize;
                for fields in strip.fields.chunks(beside) {
                    ui.horizontal(|ui| fields.iter().for_each(|field| show_field(ui, strip.channel, field)));
                }
                ui.add_space(8.0);
            }
        });
        if back || ui.input(|input| input.key_pressed(Key::Escape)) { ToolGo::Back } else { ToolGo::Stay }
    }

    fn make(&mut self, ctx: &egui::Context) {
        let row_px = if self.pairs { 2 } else { 1 };
        if self.made.as_ref().is_some_and(|(made, _)| *made == row_px) {
            return;
        }
        let strip = |channel: Channel| {
            let field = |text: String, image: &CodeImage| {
                let texture = pixels::texture_of(ctx, &format!("check {channel} {text}"), image);
                (text, texture)
            };
            let drawn = |(lit, period): (u32, u32), error: f64| {
                CheckField::new(&self.profile.transfers, channel, [lit, period], row_px, error)
                    .picture(FIELD_PX, FIELD_PX, PATCH_PX)
            };
            let right = CHECKED.map(|rows| field(format!("{} of {} rows", rows.0, rows.1), &drawn(rows, 0.0)));
            let wrong = [-ERROR, ERROR]
                .map(|error| field(format!("wrong by {}", signed(&format!("{error:+}"))), &drawn(CHECKED[0], error)));
            Strip { channel, fields: right.into_iter().chain(wrong).collect() }
        };
        let strips = [Channel::Gray, Channel::Red, Channel::Green, Channel::Blue].map(strip);
        self.made = Some((row_px, strips.into()));
    }
}

fn show_field(ui: &mut egui::Ui, channel: Channel, (text, texture): &(String, TextureHandle)) {
    ui.vertical(|ui| {
        wide_picture(ui, texture, [FIELD_PX; 2], &format!("{channel}, {text}"));
        ui.label(theme::quiet(text));
    });
}

/// The channel's name with which a line begins.
pub fn capital(channel: Channel) -> &'static str {
    match channel {
        Channel::Red => "Red",
        Channel::Green => "Green",
        Channel::Blue => "Blue",
        Channel::Gray => "Gray",
    }
}
