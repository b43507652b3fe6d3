//! Floor 1: a model of vision, which predicts where people see bright and dark bands in an image, and how visible they
//! are.
//!
//! A model of local energy, like that of Morrone and Burr (1988, Proc. R. Soc. B 235:221; Ross, Morrone & Burr 1989,
//! Vis. Res. 29:699): the eye finds lines and edges where the energy of an even and an odd response, in quadrature, is
//! highest; the phase decides between the two. At a sharp step the phase is that of an edge in every channel: no band.
//! At the end of a ramp it is that of a line: a band.
//!
//! ```text
//! light → sensitivity (optics, neurons) → channels (log-Gabor, quarter octaves): even, odd
//!       → peaks of the energy that stand out on both sides → even beyond odd, over the mean light → over channels
//! ```
//!
//! Strengths are contrast times sensitivity: at 1 a grating of that contrast would be just visible. Every constant has its
//! source where it is defined. [`Line`] is for stimuli that vary in one direction, [`Picture`] for images; they agree.

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
pub use image::Picture;
pub use line::{Line, LinePrediction};
pub use picture::{BandMap, PicturePrediction};
