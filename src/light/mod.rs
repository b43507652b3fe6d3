//! Floor 0: light as numbers. This module touches no files and no windows, and uses only words from the basement.
//!
//! In this crate's comments, Bangay is *Methods of Reducing the Visibility of Mach Bands during Gouraud Shading*, and
//! Shoaff is *Color, Illumination Models, and Shading*.
//!
//! Values called *linear* are relative luminances: proportional to physical light, from 0 (none) to 1 (the display's
//! maximum). Values called *encoded* are the signals that drive a display, 0…1, before rounding. *Codes* are the
//! rounded integers. Only [`quantize`] converts light to a display's codes; [`dither`] does so for devices with few
//! codes.

pub mod color;
pub mod dither;
pub mod image;
pub mod interpolation;
pub mod palette;
pub mod quantize;
pub mod transfer;

pub use dither::{Dither, DitherMatrix, DitherMatrixError, Thresholds};
pub use image::{CodeImage, Levels, LinearImage, Samples, reaches};
pub use interpolation::{Depth, DepthError, TANH_K};
pub use quantize::{Bits, ChannelQuantizer, Quantizer};
pub use transfer::{Gog, Transfer, TransferTable, Transfers};
