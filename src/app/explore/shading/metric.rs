//! How much crease each side leaves: computed while nothing is being dragged, since it takes longer than a frame.

use eframe::egui::{self, TextureHandle};

use super::{comparison::Side, render::Pictures};
use crate::{
    app::{pixels, theme},
    light::{Bits, CodeImage, Quantizer, Transfer},
    shading::{Creases, Frame, Reference, crease},
};

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

    /// The numbers of side `which`: rms, 95th percentile, and how it compares with Gouraud's; `stale` while a drag goes on.
    pub fn cells(&self, ui: &mut egui::Ui, which: usize, stale: bool) {
        let color = if stale { theme::QUIET } else { super::canvas::COLORS[which] };
        let creases = &self.sides[which];
        let over = creases.over(&self.gouraud).map_or_else(|| "—".to_owned(), |over| format!("{over:.4}"));
        for text in [format!("{:.2e}", creases.rms), format!("{:.2e}", creases.p95), over] {
            ui.label(egui::RichText::new(text).small().color(color));
        }
    }
}

fn creases(frame: &Frame, side: &Side, transfer: &Transfer) -> Creases {
    let shaded = side.frame(frame, transfer);
    let reference = Reference::new(&shaded, &side.shade);
    Creases::of_field(frame, |triangle, w| side.light(reference.light(triangle, w), transfer))
}
