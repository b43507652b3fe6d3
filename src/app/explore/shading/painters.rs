//! Who draws the pictures: the rasteriser, or the graphics card.

use std::{sync::Arc, time::Instant};

use eframe::{
    egui::{self, Color32, ColorImage},
    egui_wgpu::RenderState,
};

use super::{
    card::Card,
    comparison::{Comparison, Side},
    render::Picture,
};
use crate::{
    app::pixels::Canvas,
    light::Transfer,
    shading::{
        Frame, Shade,
        raster::{Encoder, Prepared, Rasterizer},
    },
};

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
    /// What the rasteriser's pictures are shown on, left and right.
    canvases: [Canvas; 2],
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
            canvases: Default::default(),
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

    /// Draws one side of a frame: left for `which` 0, right for 1.
    pub fn draw(
        &mut self,
        ctx: &egui::Context,
        which: usize,
        frame: &Frame,
        side: &Side,
        transfer: &Transfer,
    ) -> Picture {
        let shown = side.frame(frame, transfer);
        let transfer = side.transfer(transfer);
        if self.by() == DrawnBy::Card
            && let Ok(card) = &mut self.card
        {
            match card.draw(&shown, &side.shade, &transfer) {
                Ok((picture, ms)) => return Picture::on_card(picture, ms),
                // From here on the rasteriser draws, and the page says why.
                Err(fault) => self.card = Err(fault.to_string()),
            }
        }
        let (pixels, ms) = self.draw_here(&shown, &side.shade, &transfer);
        let pixels = Arc::new(pixels);
        let texture = self.canvases[which].put(ctx, "demo", pixels.clone());
        Picture::here(pixels, texture, ms)
    }

    fn draw_here(&mut self, frame: &Frame, shade: &Shade, transfer: &Transfer) -> (ColorImage, f64) {
        let encoder = encoder(&mut self.encoder, transfer);
        let begun = Instant::now();
        let prepared = Prepared::new(frame, shade);
        let mut pixels = ColorImage::filled([frame.width as usize, frame.height as usize], Color32::BLACK);
        self.rasterizer.draw_codes(&prepared, encoder, bytemuck::cast_slice_mut(&mut pixels.pixels));
        (pixels, begun.elapsed().as_secs_f64() * 1e3)
    }

    /// How long each that can draw takes for each side, the median of several, in words.
    pub fn time(&mut self, frame: &Frame, compared: &Comparison) -> Vec<String> {
        let sides = compared
            .sides
            .map(|side| (side.frame(frame, &compared.transfer), side.shade, side.transfer(&compared.transfer)));
        let here =
            sides.each_ref().map(|(frame, shade, transfer)| median(|| Some(self.draw_here(frame, shade, transfer).1)));
        let mut rows = vec![("CPU".to_owned(), here)];
        if let Ok(card) = &mut self.card {
            let there = sides
                .each_ref()
                .map(|(frame, shade, transfer)| median(|| card.draw(frame, shade, transfer).ok().map(|(_, ms)| ms)));
            rows.push((card.name(), there));
        }
        let megapixels = f64::from(frame.width) * f64::from(frame.height) / 1e6;
        rows.iter()
            .map(|(name, [left, right])| {
                format!("{name}: left {left:.2} ms, right {right:.2} ms for {megapixels:.2} Mpix, constants and upload included.")
            })
            .collect()
    }
}

/// Times that a picture is drawn to be timed.
const TIMED: usize = 9;

/// The median of several times; NaN where one fails.
fn median(mut time: impl FnMut() -> Option<f64>) -> f64 {
    let mut times: Vec<f64> = (0..TIMED).map(|_| time().unwrap_or(f64::NAN)).collect();
    times.sort_by(f64::total_cmp);
    times[TIMED / 2]
}

/// The encoder for `transfer`, made anew only when it is another.
fn encoder<'a>(kept: &'a mut Option<(Transfer, Encoder)>, transfer: &Transfer) -> &'a Encoder {
    if kept.as_ref().is_some_and(|(known, _)| known != transfer) {
        *kept = None;
    }
    &kept.get_or_insert_with(|| (transfer.clone(), Encoder::new(transfer))).1
}
