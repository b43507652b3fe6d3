//! From a comparison to the two pictures: computed when something has changed, and then kept.

use std::{borrow::Cow, rc::Rc, time::Instant};

use eframe::{
    egui::{self, TextureHandle, TextureId},
    egui_wgpu::RenderState,
};

use super::{
    card::{Card, CardPicture},
    comparison::{Comparison, MeshChoice, Side},
};
use crate::{
    app::pixels,
    light::{CodeImage, Samples, Transfer},
    shading::{
        Frame, Surface,
        raster::{Encoder, Prepared, Rasterizer},
    },
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
    Here(CodeImage, TextureHandle),
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
                pictures.sides[i] = painters.draw(ctx, &pictures.frame, side, &compared.transfer);
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
        let sides = compared.sides.map(|side| painters.draw(ctx, &frame, &side, &compared.transfer));
        let by = painters.by();
        Pictures { compared: compared.clone(), version: model.version, size, by, edition: 0, frame, frame_ms, sides }
    }

    /// What they show.
    pub fn compared(&self) -> &Comparison {
        &self.compared
    }
}

impl Picture {
    /// What egui knows it by.
    pub fn id(&self) -> TextureId {
        match &self.image {
            Image::Here(_, texture) => texture.id(),
            Image::OnCard(picture) => picture.id(),
        }
    }

    /// Its codes; `None` where the card does not give them back.
    pub fn codes(&self) -> Option<Cow<'_, CodeImage>> {
        match &self.image {
            Image::Here(codes, _) => Some(Cow::Borrowed(codes)),
            Image::OnCard(picture) => picture.codes().map(Cow::Owned),
        }
    }
}

/// Who draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DrawnBy {
    /// The rasteriser.
    Cpu,
    /// The graphics card.
    Card,
}

/// The two that can draw.
pub struct Painters {
    rasterizer: Rasterizer,
    encoder: Option<(Transfer, Encoder)>,
    card: Result<Card, String>,
    /// Who is to draw, if both can.
    pub wanted: DrawnBy,
}

impl Painters {
    /// The machine's threads, and the window's graphics card if it has one. A card that is a program is no faster: the
    /// rasteriser goes first.
    pub fn new(state: Option<&RenderState>) -> Painters {
        let card = match state {
            Some(state) => Card::new(state).map_err(|error| error.to_string()),
            None => Err("no graphics adapter".to_owned()),
        };
        let fast = card.as_ref().is_ok_and(|card| !card.is_software());
        Painters {
            rasterizer: Rasterizer::new(std::thread::available_parallelism().map_or(1, std::num::NonZero::get)),
            encoder: None,
            card,
            wanted: if fast { DrawnBy::Card } else { DrawnBy::Cpu },
        }
    }

    /// Who draws.
    pub fn by(&self) -> DrawnBy {
        if self.card.is_ok() { self.wanted } else { DrawnBy::Cpu }
    }

    /// The card's name, or why it does not draw.
    pub fn card_name(&self) -> Result<String, &str> {
        self.card.as_ref().map(Card::name).map_err(String::as_str)
    }

    /// Who draws, by name.
    pub fn drawn_by(&self) -> String {
        match (self.by(), &self.card) {
            (DrawnBy::Card, Ok(card)) => card.name(),
            _ => "CPU".to_owned(),
        }
    }

    /// Who draws, and why.
    pub fn sentence(&self) -> String {
        match &self.card {
            Err(reason) => format!("Shown by the CPU: {reason}."),
            Ok(_) => {
                format!("Shown by {}.", if self.by() == DrawnBy::Cpu { "the CPU".to_owned() } else { self.drawn_by() })
            }
        }
    }

    fn draw(&mut self, ctx: &egui::Context, frame: &Frame, side: &Side, transfer: &Transfer) -> Picture {
        let shown = side.frame(frame, transfer);
        let transfer = side.transfer(transfer);
        if self.by() == DrawnBy::Card
            && let Ok(card) = &mut self.card
        {
            match card.draw(&shown, &side.shade, &transfer) {
                Ok((picture, ms)) => return Picture { image: Image::OnCard(picture), ms },
                // From here on the rasteriser draws, and the page says why.
                Err(fault) => self.card = Err(fault.to_string()),
            }
        }
        let begun = Instant::now();
        let prepared = Prepared::new(&shown, &side.shade);
        let mut rgba = vec![0; 4 * frame.width as usize * frame.height as usize];
        self.rasterizer.draw_codes(&prepared, encoder(&mut self.encoder, &transfer), &mut rgba);
        let ms = ms_since(begun);
        let codes = rgba.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
        let codes = CodeImage { width: frame.width, height: frame.height, samples: Samples::Eight(codes) };
        let texture = pixels::texture_of(ctx, "demo", &codes);
        Picture { image: Image::Here(codes, texture), ms }
    }
}

/// The encoder for `transfer`, made anew only when it is another.
fn encoder<'a>(kept: &'a mut Option<(Transfer, Encoder)>, transfer: &Transfer) -> &'a Encoder {
    if kept.as_ref().is_some_and(|(known, _)| known != transfer) {
        *kept = None;
    }
    &kept.get_or_insert_with(|| (transfer.clone(), Encoder::new(transfer))).1
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
