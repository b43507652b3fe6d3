//! From a comparison to the two pictures: computed when something has changed, and then kept.

use std::{rc::Rc, time::Instant};

use eframe::egui::{self, TextureHandle};

use super::comparison::{Comparison, MeshChoice, Side};
use crate::{
    app::pixels,
    light::{Bits, CodeImage, Quantizer, Samples, Transfer},
    shading::{Frame, Reference, Surface},
};

/// The surface shown: the last that could be made.
pub struct Model {
    choice: MeshChoice,
    surface: Rc<Surface>,
    /// Counts the surfaces, to know one from another.
    version: u64,
}

impl Model {
    /// The surface of `choice`.
    ///
    /// # Errors
    /// In words, what is wrong with it.
    pub fn new(choice: &MeshChoice) -> Result<Model, String> {
        Ok(Model { choice: choice.clone(), surface: Rc::new(Surface::new(choice.mesh()?)), version: 0 })
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
    pub fn surface(&self) -> &Rc<Surface> {
        &self.surface
    }
}

/// Both pictures of a comparison at a size.
pub struct Pictures {
    compared: Comparison,
    version: u64,
    size: [u32; 2],
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
    /// Its codes.
    pub codes: CodeImage,
    /// The same on the graphics card.
    pub texture: TextureHandle,
    /// How long it took, ms.
    pub ms: f64,
}

impl Pictures {
    /// The pictures of `compared`; those of `before` where they are the same still.
    pub fn refreshed(
        ctx: &egui::Context,
        before: Option<Pictures>,
        model: &Model,
        compared: &Comparison,
        size: [u32; 2],
    ) -> Pictures {
        let [width, height] = size;
        let Some(before) = before else { return Pictures::new(ctx, model, compared, size) };
        if before.version != model.version || before.size != size || !before.compared.same_frame(compared) {
            return Pictures { edition: before.edition + 1, ..Pictures::new(ctx, model, compared, [width, height]) };
        }
        let mut pictures = before;
        for (i, side) in compared.sides.iter().enumerate() {
            if pictures.compared.sides[i] != *side {
                pictures.sides[i] = Picture::new(ctx, &pictures.frame, side, &compared.transfer);
                pictures.edition += 1;
            }
        }
        pictures.compared = compared.clone();
        pictures
    }

    fn new(ctx: &egui::Context, model: &Model, compared: &Comparison, size: [u32; 2]) -> Pictures {
        let begun = Instant::now();
        let frame = compared.frame(model.surface(), size[0], size[1]);
        let frame_ms = ms_since(begun);
        let sides = compared.sides.map(|side| Picture::new(ctx, &frame, &side, &compared.transfer));
        Pictures { compared: compared.clone(), version: model.version, size, edition: 0, frame, frame_ms, sides }
    }

    /// What they show.
    pub fn compared(&self) -> &Comparison {
        &self.compared
    }
}

impl Picture {
    fn new(ctx: &egui::Context, frame: &Frame, side: &Side, transfer: &Transfer) -> Picture {
        let begun = Instant::now();
        let codes = on_cpu(frame, side, transfer);
        let ms = ms_since(begun);
        let texture = pixels::texture_of(ctx, "demo", &codes);
        Picture { codes, texture, ms }
    }
}

/// One side of a frame as codes, made by the CPU.
pub fn on_cpu(frame: &Frame, side: &Side, transfer: &Transfer) -> CodeImage {
    let frame = side.frame(frame, transfer);
    let quantizer = Quantizer::new(&side.transfer(transfer), Bits::Eight);
    quantizer.quantize(&Reference::new(&frame, &side.shade).image())
}

/// The part of two pictures of one size on either side of the divider, its column given: what the split view shows.
pub fn split(left: &CodeImage, right: &CodeImage, column: u32) -> CodeImage {
    combine(left, right, |x, left, right| if x < column { left } else { right })
}

/// How far two pictures are apart, in codes, times `factor`.
pub fn difference(left: &CodeImage, right: &CodeImage, factor: u8) -> CodeImage {
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
