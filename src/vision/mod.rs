//! Floor 1: a model of vision, which predicts where people see bright and dark bands in an image, and how visible they
//! are.
//!
//! This is a local-energy model in the tradition of Morrone and Burr (1988, Proc. R. Soc. B 235:221; Ross, Morrone &
//! Burr 1989, Vis. Res. 29:699). The eye finds lines and edges at the peaks of the energy of an even and an odd
//! response in quadrature, and the phase at the peak tells lines from edges. At a sharp step, every channel has the
//! phase of an edge, so there is no band. At the end of a ramp, the phase is the phase of a line, so there is a band.
//!
//! ```text
//! light → sensitivity (optics, neurons) → channels (log-Gabor, quarter octaves): even, odd
//!       → energy peaks that stand out on both sides → (even − odd share) / mean light → pooled over channels
//! ```
//!
//! Strengths are contrast times sensitivity: at a strength of 1, a grating of that contrast would be just visible. The
//! source of every constant is cited where it is defined. [`Line`] is for stimuli that vary in one direction, and
//! [`LuminanceImage`] is for images; the two agree.

mod band;
mod error;
mod eye;
pub mod fft;
mod image;
mod line;
mod picture;
mod ridge;
mod spectrum;

pub use band::{Band, Criterion, Polarity, Visibility, pooled, vertex};
pub use error::VisionError;
pub use eye::{Border, Eye, luminance, luminances};
pub use image::LuminanceImage;
pub use line::{Line, LinePrediction};
pub use picture::{BandMap, PicturePrediction};
