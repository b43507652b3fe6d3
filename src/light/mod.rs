//! Floor 0: light as numbers. No files, no windows; it uses no other module of this crate.
//!
//! In this crate's comments Bangay is *Methods of Reducing the Visibility of Mach Bands during
//! Gouraud Shading*, Shoaff is *Color, Illumination Models, and Shading*.
//!
//! Values called *linear* are relative luminances, proportional to physical light, 0 (none) to 1
//! (the display's most). Values called *encoded* are what a display is driven with, 0…1, before
//! rounding. *Codes* are the rounded integers. [`quantize`] is the only way from light to a display's
//! codes; [`halftone`], to those of a device with few.

pub mod color;
pub mod dither;
pub mod halftone;
pub mod image;
pub mod interpolation;
pub(crate) mod names;
pub mod palette;
pub mod quantize;
pub mod random;
pub mod transfer;

pub use dither::{Dither, DitherError, DitherMatrix, DitherMatrixError, Thresholds};
pub use halftone::Halftone;
pub use image::{CodeImage, LinearImage, Samples};
pub use interpolation::{Depth, DepthError, Interpolation};
pub use quantize::{Bits, ChannelQuantizer, Quantizer};
pub use transfer::{Gog, Transfer, TransferError, TransferTable, Transfers};
