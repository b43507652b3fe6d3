//! One stimulus as an image.

use std::path::Path;

use serde::Serialize;

use super::{Drawn, Encoding, Image, RequestError, Watcher};
use crate::{
    light::{Bits, Dither, Transfer, dither::Screen, palette::Reduction},
    stimulus::recipe::{Finish, Recipe},
    store::{Writer, image::write_recipe},
};

/// A stimulus, and how its image is made.
#[derive(Clone, Debug, PartialEq, clap::Args, Serialize)]
pub struct Render {
    #[command(flatten)]
    #[serde(flatten)]
    pub drawn: Drawn,
    #[command(flatten)]
    #[serde(flatten)]
    pub image: Image,
    /// Reduce the image to a palette, given as the method (popularity or median-cut) and the maximum number of
    /// colors, such as median-cut:16.
    #[arg(long, value_name = "METHOD:N")]
    pub palette: Option<Reduction>,
    /// Draw each pixel as a cell of dots, for devices with few codes such as printers; given as the matrix and the bits
    /// per channel, such as clustered3:1.
    #[arg(long, value_name = "MATRIX:BITS", conflicts_with = "palette")]
    pub halftone: Option<Screen>,
}

impl Render {
    /// Writes the image, and the luminance profile through the center, to the files that are wanted.
    ///
    /// # Errors
    /// A value is impossible, or a file cannot be written.
    pub fn render(
        &self,
        out: Option<&Path>,
        profile: Option<&Path>,
        writer: &Writer,
        watcher: &dyn Watcher,
    ) -> anyhow::Result<()> {
        let changed = [("palette", self.palette.is_some()), ("halftone", self.halftone.is_some())];
        if let (None, Some((field, _))) = (out, changed.iter().find(|(_, is_given)| *is_given)) {
            let message = "changes only the image; expected a file for the image";
            return Err(RequestError::value(field, message).into());
        }
        if self.palette.is_some() && self.image.bits == Bits::Sixteen {
            let message = "a palette has 8 bits per channel; expected 8 bits";
            return Err(RequestError::new("palette", message).into());
        }
        if self.halftone.is_some() && (self.image.bits, self.image.dither) != (Bits::Eight, Dither::None) {
            let message = "a halftone has its own bits, and its dots replace dither; expected 8 bits and no dither";
            return Err(RequestError::new("halftone", message).into());
        }
        let recipe = Recipe {
            finish: self.palette.map(Finish::Palette).or(self.halftone.map(Finish::Halftone)),
            ..self.image.recipe(self.drawn.stimulus()?, watcher)?
        };
        let quantizer = recipe.quantizer();
        if let Some(out) = out {
            write_recipe(writer, out, &recipe, &quantizer)?;
        }
        if let Some(profile) = profile {
            writer.write(profile, &recipe.profile(&quantizer).csv())?;
        }
        Ok(())
    }
}

/// Returns the command that writes the image of a recipe. A measured table has no short text form, so the command names a
/// file `PROFILE.toml` in its place.
pub fn command(recipe: &Recipe) -> String {
    let Recipe { stimulus, size, transfers, bits, dither, seed, .. } = recipe;
    let is_default = transfers.has_table() || transfers.uniform() == Some(&Transfer::Srgb);
    let encoding = Encoding {
        transfer: (!is_default).then(|| transfers.clone()),
        display: transfers.has_table().then(|| "PROFILE.toml".into()),
    };
    let seed = if *dither == Dither::Random { *seed } else { 1 };
    let image = Image { size: *size, encoding, bits: *bits, dither: *dither, seed };
    let request = Render { drawn: Drawn::of(stimulus), image, palette: None, halftone: None };
    super::command("stimulus", &request, &["--out", "stimulus.png"])
}
