//! How much crease each side leaves: computed while nothing is being dragged, since it takes longer than a frame.

use eframe::egui::{self, TextureHandle};

use super::{
    comparison::{Comparison, Side},
    render::Pictures,
};
use crate::{
    app::{pixels, theme},
    light::{Bits, CodeImage, Quantizer, Transfer},
    shading::{Creases, Frame, Reference, crease},
};
use glam::DVec3;

/// The creases of both sides, and Gouraud's.
pub struct Metric {
    edition: u64,
    gouraud: Creases,
    sides: [Creases; 2],
    pictures: Option<[(CodeImage, TextureHandle); 2]>,
}

impl Metric {
    /// Those of `pictures`; `before` where they are still the same.
    pub fn refreshed(before: Option<Metric>, pictures: &Pictures) -> Metric {
        if let Some(before) = before.filter(|before| before.edition == pictures.edition) {
            return before;
        }
        let (frame, compared) = (&pictures.frame, pictures.compared());
        let sides = compared.sides.map(|side| creases(frame, &side, &compared.transfer));
        Metric { edition: pictures.edition, gouraud: Creases::of_gouraud(frame), sides, pictures: None }
    }

    /// The creases drawn, all to one scale: what Gouraud's shader has at the 95th percentile is lightest.
    pub fn pictures(&mut self, ctx: &egui::Context, frame: &Frame) -> &[(CodeImage, TextureHandle); 2] {
        let Metric { gouraud, sides, pictures, .. } = self;
        pictures.get_or_insert_with(|| {
            let quantizer = Quantizer::new(&Transfer::Srgb, Bits::Eight);
            [0, 1].map(|i| {
                let codes = quantizer.quantize(&crease::picture(frame, &sides[i], gouraud.p95));
                let texture = pixels::texture_of(ctx, "creases", &codes);
                (codes, texture)
            })
        })
    }

    /// The creases drawn, if they were asked for.
    pub fn drawn(&self) -> Option<&[(CodeImage, TextureHandle); 2]> {
        self.pictures.as_ref()
    }

    /// The numbers, of these sides; `stale` while a drag goes on.
    pub fn show(&self, ui: &mut egui::Ui, compared: &Comparison, stale: bool) {
        let color = |color| if stale { theme::QUIET } else { color };
        ui.spacing_mut().interact_size.y = 14.0;
        egui::Grid::new("creases").num_columns(4).spacing([12.0, 2.0]).show(ui, |ui| {
            for head in ["creases, light per pixel", "rms", "p95", "× Gouraud"] {
                ui.label(theme::quiet(head));
            }
            ui.end_row();
            for ((side, creases), own) in compared.sides.iter().zip(&self.sides).zip(super::canvas::COLORS) {
                let over = creases.over(&self.gouraud).map_or_else(|| "—".to_owned(), |over| format!("{over:.4}"));
                for text in [side.title(), format!("{:.2e}", creases.rms), format!("{:.2e}", creases.p95), over] {
                    ui.label(egui::RichText::new(text).small().color(color(own)));
                }
                ui.end_row();
            }
        });
    }
}

fn creases(frame: &Frame, side: &Side, transfer: &Transfer) -> Creases {
    let shaded = side.frame(frame, transfer);
    let reference = Reference::new(&shaded, &side.shade);
    Creases::of_field(frame, |triangle, w| emitted(reference.light(triangle, w), side, transfer))
}

/// The light that a display sends for what a side computes: its codes' light, where it computes codes.
pub fn emitted(value: DVec3, side: &Side, transfer: &Transfer) -> DVec3 {
    if side.is_naive() {
        DVec3::from_array(value.to_array().map(|code| transfer.linear_from_encoded(code)))
    } else {
        value
    }
}
