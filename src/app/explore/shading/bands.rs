//! The bands that the model of vision predicts on both sides: computed beside the window's loop while nothing is being
//! dragged.

use std::sync::Arc;

use eframe::egui::{self, RichText, TextureHandle};

use super::{
    comparison::{Comparison, Side},
    render::Pictures,
};
use crate::{
    app::{
        explore::predicted::{self, Drawing, number},
        pixels,
        work::Latest,
    },
    light::CodeImage,
    shading::{Shade, Shader, Surface},
    stimulus::Sight,
    vision::{PictureView, VisionError, luminances},
};

/// Longest shorter side of the picture that is predicted from, pixels: more would not change what is seen much, and take
/// longer.
const MOST_PX: u32 = 512;
/// What the shorter side of the picture is taken to be, degrees.
pub const SHORTER_SIDE_DEG: f64 = 10.0;

/// What is predicted of both sides.
pub struct Seen {
    sides: [Numbers; 2],
    /// Visibility under Gouraud's shader.
    gouraud: f64,
    /// Strength that is lightest and darkest in both pictures.
    pub most: f64,
    pictures: [CodeImage; 2],
}

/// What is predicted of a side.
#[derive(Clone, Copy)]
struct Numbers {
    bright: f64,
    dark: f64,
    density: f64,
}

/// The prediction for the pictures that are shown.
#[derive(Default)]
pub struct Bands {
    latest: Latest<u64, Seen>,
    textures: Option<(u64, [TextureHandle; 2])>,
}

impl Bands {
    /// Sees that the bands of `pictures` are predicted.
    pub fn want(&mut self, ctx: &egui::Context, pictures: &Pictures, surface: &Arc<Surface>) {
        self.latest.want(ctx, pictures.edition, || {
            let (compared, surface) = (pictures.compared().clone(), surface.clone());
            let size = [pictures.frame.width, pictures.frame.height];
            move || compute(&compared, &surface, size).map_err(|error| error.to_string())
        });
    }

    /// What is predicted of these pictures, if it is known already.
    pub fn seen(&self, edition: u64) -> Option<&Seen> {
        self.latest.get(&edition)?.as_ref().ok()
    }

    /// The maps, if they are there already.
    pub fn textures(&mut self, ctx: &egui::Context, edition: u64) -> Option<&[TextureHandle; 2]> {
        let Some(Ok(seen)) = self.latest.get(&edition) else { return None };
        if self.textures.as_ref().is_none_or(|(of, _)| *of != edition) {
            let texture = |codes| pixels::texture_of(ctx, "predicted bands", codes);
            self.textures = Some((edition, seen.pictures.each_ref().map(texture)));
        }
        self.textures.as_ref().map(|(_, textures)| textures)
    }

    /// The maps' codes, if they are there already.
    pub fn codes(&self, edition: u64) -> Option<&[CodeImage; 2]> {
        self.seen(edition).map(|seen| &seen.pictures)
    }

    /// Why there is nothing yet, or never; `None` where there is something.
    pub fn lack(&self, edition: u64) -> Option<String> {
        match self.latest.get(&edition) {
            None => Some("Predicting…".to_owned()),
            Some(Err(fault)) => Some(format!("No prediction: {fault}.")),
            Some(Ok(_)) => None,
        }
    }

    /// The numbers of side `which`: visibility, and how it compares with Gouraud's.
    pub fn cells(&self, ui: &mut egui::Ui, which: usize, edition: u64) {
        let color = super::canvas::COLORS[which];
        let label = |ui: &mut egui::Ui, text: &str| ui.label(RichText::new(text).small().color(color));
        match self.latest.get(&edition) {
            Some(Ok(seen)) => {
                let side = seen.sides[which];
                let about = format!(
                    "bright {}, dark {}; density {:.2} per degree",
                    number(side.bright),
                    number(side.dark),
                    side.density
                );
                label(ui, &number(side.visibility())).on_hover_text(&about);
                let over = (seen.gouraud > 0.0).then(|| format!("{:.2}", side.visibility() / seen.gouraud));
                label(ui, over.as_deref().unwrap_or("—"));
            }
            other => {
                let (text, about) = match other {
                    Some(Err(fault)) => ("—", fault.as_str()),
                    _ => ("…", "Predicting…"),
                };
                label(ui, text).on_hover_text(about);
                label(ui, text);
            }
        }
    }
}

impl Numbers {
    fn visibility(&self) -> f64 {
        self.bright.max(self.dark)
    }
}

/// The size on which pictures of `size` pixels are predicted: of the same shape, and not too large.
#[must_use]
pub fn predicted_size(size: [u32; 2]) -> [u32; 2] {
    let shorter = size[0].min(size[1]).max(1);
    if shorter <= MOST_PX {
        return size;
    }
    size.map(|side| (f64::from(side) * f64::from(MOST_PX) / f64::from(shorter)).round() as u32)
}

fn compute(compared: &Comparison, surface: &Surface, size: [u32; 2]) -> Result<Seen, VisionError> {
    let [width, height] = predicted_size(size);
    let frame = compared.frame(surface, width, height);
    let sight = Sight::new(SHORTER_SIDE_DEG * f64::from(width) / f64::from(width.min(height)));
    let see = |side: &Side| -> Result<(PictureView, Vec<f64>), VisionError> {
        let image = side.emitted(&frame, &compared.transfer);
        Ok((sight.see_surface(&frame, &image)?, luminances(&image)))
    };
    let [left, right] = &compared.sides;
    let sides = [see(left)?, see(right)?];
    let gouraud = Side::new(Shade::new(Shader::Gouraud));
    // One of both is Gouraud's as a rule.
    let gouraud = match compared.sides.iter().position(|side| *side == gouraud) {
        Some(which) => sides[which].0.visibility.max(),
        None => see(&gouraud)?.0.visibility.max(),
    };
    let most = sides.iter().map(|(view, _)| predicted::strongest(&view.map)).fold(0.0, f64::max);
    let pictures = sides.each_ref().map(|(view, light)| {
        let drawing = Drawing { map: &view.map, light, size: [width as usize, height as usize], most };
        drawing.codes(size[0], size[1])
    });
    let numbers = sides.map(|(view, _)| Numbers {
        bright: view.visibility.bright,
        dark: view.visibility.dark,
        density: view.density,
    });
    Ok(Seen { sides: numbers, gouraud, most, pictures })
}
