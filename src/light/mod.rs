//! Floor 0: light as numbers. No files, no windows, nothing of this crate below it.
//!
//! In this crate's comments Bangay is *Methods of Reducing the Visibility of Mach Bands during
//! Gouraud Shading*, Shoaff is *Color, Illumination Models, and Shading*.
//!
//! Values called *linear* are relative luminances, proportional to physical light, 0 (none) to 1
//! (the display's most). Values called *encoded* are what a display is driven with, 0…1, before
//! rounding. *Codes* are the rounded integers. [`quantize`] is the only way from light to a display's
//! codes; [`halftone`], to those of a device with few.

pub mod blue_noise;
pub mod color;
pub mod color_models;
pub mod depth;
pub mod dither;
pub mod gamma;
pub mod halftone;
pub mod image;
pub mod interpolation;
pub mod matrix;
pub(crate) mod names;
pub mod normal;
pub mod palette;
pub mod quantize;
pub mod shuffle;
pub mod transfers;

pub use depth::{Depth, DepthError};
pub use dither::{Dither, DitherError, Thresholds};
pub use gamma::{Gog, Transfer, TransferError, TransferTable};
pub use halftone::{Halftone, HalftoneError};
pub use image::{CodeImage, LinearImage, Samples};
pub use interpolation::Interpolation;
pub use matrix::{DitherMatrix, DitherMatrixError};
pub use quantize::{Bits, ChannelQuantizer, Quantizer};
pub use transfers::Transfers;
