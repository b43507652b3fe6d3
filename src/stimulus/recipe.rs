//! A stimulus and everything that determines how its light is turned into codes. An image file contains its recipe, so
//! its bytes can be verified by rendering it again.

use serde::{Deserialize, Serialize};

use super::{catalog::Stimulus, drawing::place};
use crate::{
    light::{Bits, CodeImage, Dither, LinearImage, Quantizer, Transfers, dither::Screen, palette::Reduction},
    text::{Cell, Column, Table},
};

/// Largest side of an image, pixels.
pub const MAX_SIZE: u32 = 16_384;

/// The complete description of an image. Equal recipes give equal codes on every machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recipe {
    pub stimulus: Stimulus,
    /// Side of the square image in pixels, 1…[`MAX_SIZE`].
    pub size: u32,
    /// The display's transfer functions.
    #[serde(rename = "transfer")]
    pub transfers: Transfers,
    /// Bits per channel.
    pub bits: Bits,
    /// How a value between two codes is assigned to one of them.
    pub dither: Dither,
    /// Seed of a random dither; ignored by all other dithers.
    pub seed: u64,
    /// SHA-256 of the display profile that the transfer functions come from; `None` if they were assumed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub display_sha256: Option<String>,
    /// What becomes of the codes in a file; `None` if they are written as they are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub finish: Option<Finish>,
}

/// What can become of the codes of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Finish {
    /// They are reduced to a palette.
    Palette(Reduction),
    /// Each pixel is drawn as a cell of dots, for a device with few codes.
    Halftone(Screen),
}

impl Recipe {
    /// Returns the requested light.
    pub fn linear(&self) -> LinearImage {
        self.stimulus.linear(self.size)
    }

    /// Returns the side of the image in its file, pixels.
    pub fn side(&self) -> u32 {
        let cell = if let Some(Finish::Halftone(screen)) = self.finish { screen.matrix.size() } else { 1 };
        self.size.saturating_mul(cell)
    }

    /// Creates a quantizer for the recipe's display. It can be reused for further images.
    pub fn quantizer(&self) -> Quantizer {
        Quantizer::new(&self.transfers, self.bits)
    }

    /// Returns the codes. `quantizer` must have the transfer functions and the bits of this recipe.
    pub fn codes(&self, quantizer: &Quantizer) -> CodeImage {
        match self.dither {
            Dither::None => self.stimulus.codes(self.size, quantizer),
            dither => quantizer.quantize_with(&self.linear(), dither, self.seed),
        }
    }

    /// Returns the luminance profile at the centers of the pixels, along a line through the center in the direction of the
    /// orientation, dithered like a row of pixels. `quantizer` is as for [`Recipe::codes`].
    pub fn profile(&self, quantizer: &Quantizer) -> Table {
        const LIGHT: &str = "relative luminance, linear light";
        let (stimulus, size) = (&self.stimulus, self.size);
        let strongest = stimulus.strongest_channel();
        let light = stimulus.profile(size);
        let row = LinearImage::from_fn(size, 1, |i, _| light[i as usize]);
        let codes = quantizer.quantize_with(&row, self.dither, self.seed);
        let column = |name: &str, unit: &str, description: &str, cell: &dyn Fn(u32) -> Cell| Column {
            cells: (0..size).map(cell).collect(),
            ..Column::new(name, unit, description)
        };
        let code = |channel: usize, i: u32| codes.pixel(i, 0)[channel];
        let emitted = |i| quantizer.channel(strongest).linear(code(strongest, i));
        Table {
            columns: vec![
                column(
                    "x",
                    "proportion of the stimulus window",
                    "Distance from the center along the orientation.",
                    &|i| place(i, size).into(),
                ),
                column("linear", LIGHT, "Requested light of the strongest channel.", &|i| {
                    f64::from(light[i as usize][strongest]).into()
                }),
                column("code_r", "", "Code of red.", &|i| code(0, i).into()),
                column("code_g", "", "Code of green.", &|i| code(1, i).into()),
                column("code_b", "", "Code of blue.", &|i| code(2, i).into()),
                column("emitted", LIGHT, "Light that the strongest channel's code emits.", &|i| emitted(i).into()),
            ],
        }
    }
}
