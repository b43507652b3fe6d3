//! From a comparison to the two pictures: computed when something has changed, and then kept.

use std::{sync::Arc, time::Instant};

use eframe::egui::{self, ColorImage, TextureHandle, TextureId};

use super::{
    card::CardPicture,
    comparison::{Comparison, MeshChoice},
    painters::{DrawnBy, Painters},
};
use crate::{
    app::pixels,
    light::{CodeImage, Samples},
    shading::{Frame, Surface},
};

/// The surface shown: the last that could be made.
pub struct Model {
    choice: MeshChoice,
    surface: Arc<Surface>,
    /// Counts the surfaces, to know one from another.
    version: u64,
}

impl Model {
    /// The surface of `choice`.
    ///
    /// # Errors
    /// In words, what is wrong with it.
    pub fn new(choice: &MeshChoice) -> Result<Model, String> {
        Ok(Model { choice: choice.clone(), surface: Arc::new(Surface::new(choice.mesh()?)), version: 0 })
    }

    /// Follows what is chosen. A mesh that cannot be made leaves the one before.
    pub fn follow(&mut self, choice: &MeshChoice) -> Result<(), String> {
        if self.choice == *choice { Ok(()) } else { self.load(choice) }
    }

    /// Makes the surface anew, whether or not it is another.
    pub fn load(&mut self, choice: &MeshChoice) -> Result<(), String> {
        let next = Model::new(choice)?;
        *self = Model { version: self.version + 1, ..next };
        Ok(())
    }

    /// The surface.
    pub fn surface(&self) -> &Arc<Surface> {
        &self.surface
    }
}

/// Both pictures of a comparison at a size.
pub struct Pictures {
    compared: Comparison,
    version: u64,
    size: [u32; 2],
    by: DrawnBy,
    /// Counts the changes of any picture.
    pub edition: u64,
    /// What both shade.
    pub frame: Frame,
    /// How long the frame took, ms: vertices turned and lit.
    pub frame_ms: f64,
    /// Left and right.
    pub sides: [Picture; 2],
}

/// One side's picture.
pub struct Picture {
    image: Image,
    /// How long it took, ms.
    pub ms: f64,
}

/// Where a picture is.
enum Image {
    Here(Arc<ColorImage>, TextureHandle),
    OnCard(CardPicture),
}

impl Pictures {
    /// The pictures of `compared`; those of `before` where they are the same still.
    pub fn refreshed(
        ctx: &egui::Context,
        before: Option<Pictures>,
        painters: &mut Painters,
        model: &Model,
        compared: &Comparison,
        size: [u32; 2],
    ) -> Pictures {
        let Some(mut pictures) = before else { return Pictures::new(ctx, painters, model, compared, size) };
        let same_model = pictures.version == model.version && pictures.size == size && pictures.by == painters.by();
        if !same_model || !pictures.compared.same_frame(compared) {
            let edition = pictures.edition + 1;
            // The card's memory first.
            drop(pictures);
            return Pictures { edition, ..Pictures::new(ctx, painters, model, compared, size) };
        }
        for (i, side) in compared.sides.iter().enumerate() {
            if pictures.compared.sides[i] != *side {
                pictures.sides[i] = painters.draw(ctx, i, &pictures.frame, side, &compared.transfer);
                pictures.edition += 1;
            }
        }
        pictures.compared = compared.clone();
        pictures
    }

    fn new(
        ctx: &egui::Context,
        painters: &mut Painters,
        model: &Model,
        compared: &Comparison,
        size: [u32; 2],
    ) -> Pictures {
        let begun = Instant::now();
        let frame = compared.frame(model.surface(), size[0], size[1]);
        let frame_ms = ms_since(begun);
        let sides = [0, 1].map(|i| painters.draw(ctx, i, &frame, &compared.sides[i], &compared.transfer));
        let by = painters.by();
        Pictures { compared: compared.clone(), version: model.version, size, by, edition: 0, frame, frame_ms, sides }
    }

    /// What they show.
    pub fn compared(&self) -> &Comparison {
        &self.compared
    }
}

impl Picture {
    /// One that took `ms` milliseconds, in memory and as a texture.
    pub fn here(pixels: Arc<ColorImage>, texture: TextureHandle, ms: f64) -> Picture {
        Picture { image: Image::Here(pixels, texture), ms }
    }

    /// One that took `ms` milliseconds, on the card.
    pub fn on_card(picture: CardPicture, ms: f64) -> Picture {
        Picture { image: Image::OnCard(picture), ms }
    }

    /// What egui knows it by.
    pub fn id(&self) -> TextureId {
        match &self.image {
            Image::Here(_, texture) => texture.id(),
            Image::OnCard(picture) => picture.id(),
        }
    }

    /// Its codes; `None` where the card does not give them back.
    pub fn codes(&self) -> Option<CodeImage> {
        match &self.image {
            Image::Here(pixels, _) => {
                let [width, height] = pixels.size.map(|side| side as u32);
                let codes = pixels.pixels.iter().flat_map(|pixel| [pixel.r(), pixel.g(), pixel.b()]).collect();
                Some(CodeImage { width, height, samples: Samples::Eight(codes) })
            }
            Image::OnCard(picture) => picture.codes(),
        }
    }
}

/// The difference view, and what it was made from.
pub struct Difference {
    edition: u64,
    factor: u8,
    /// Its codes.
    pub codes: CodeImage,
    /// The same on the screen.
    pub texture: TextureHandle,
}

impl Difference {
    /// That of `pictures`; `before` where it is the same still. `None` where the card does not give pictures back.
    pub fn refreshed(
        ctx: &egui::Context,
        before: Option<Difference>,
        pictures: &Pictures,
        factor: u8,
    ) -> Option<Difference> {
        if let Some(before) = before.filter(|d| d.edition == pictures.edition && d.factor == factor) {
            return Some(before);
        }
        let [left, right] = &pictures.sides;
        let codes = difference(&left.codes()?, &right.codes()?, factor);
        let texture = pixels::texture_of(ctx, "difference", &codes);
        Some(Difference { edition: pictures.edition, factor, codes, texture })
    }
}

/// The part of two pictures of one size on either side of the divider, its column given: what the split view shows.
pub fn split(left: &CodeImage, right: &CodeImage, column: u32) -> CodeImage {
    combine(left, right, |x, left, right| if x < column { left } else { right })
}

/// How far two pictures are apart, in codes, times `factor`.
fn difference(left: &CodeImage, right: &CodeImage, factor: u8) -> CodeImage {
    combine(left, right, |_, left, right| left.abs_diff(right).saturating_mul(factor))
}

fn combine(left: &CodeImage, right: &CodeImage, code: impl Fn(u32, u8, u8) -> u8) -> CodeImage {
    let (a, b) = (left.bytes().unwrap_or_default(), right.bytes().unwrap_or_default());
    let row = left.width.max(1) as usize * 3;
    let codes = a.iter().zip(b).enumerate().map(|(i, (a, b))| code((i % row / 3) as u32, *a, *b)).collect();
    CodeImage { width: left.width, height: left.height, samples: Samples::Eight(codes) }
}

fn ms_since(begun: Instant) -> f64 {
    begun.elapsed().as_secs_f64() * 1e3
}
