//! Floor 0: light as numbers. No files, no windows, nothing of this crate below it.
//!
//! In this crate's comments Bangay is *Methods of Reducing the Visibility of Mach Bands during
//! Gouraud Shading*, Shoaff is *Color, Illumination Models, and Shading*.
//!
//! Values called *linear* are relative luminances, proportional to physical light, 0 (none) to 1
//! (the display's most). Values called *encoded* are what a display is driven with, 0…1, before
//! rounding. *Codes* are the rounded integers. [`quantize`] is the only way from light to codes.

pub mod depth;
pub mod gamma;
pub mod image;
pub mod interpolation;
pub mod quantize;

pub use depth::{Depth, DepthError};
pub use gamma::{Transfer, TransferError, TransferTable};
pub use image::{CodeImage, LinearImage, Samples};
pub use interpolation::Interpolation;
pub use quantize::{Bits, Quantizer};
