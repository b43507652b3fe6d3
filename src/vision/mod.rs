//! Floor 1: a model of vision: where an image has bright and dark bands, and how visible they are.
//!
//! A model of local energy, as Morrone and Burr's (1988, Proc. R. Soc. B 235:221; Ross, Morrone & Burr 1989, Vis. Res.
//! 29:699): the eye looks for lines and edges where the energy of an even and an odd response, in quadrature, is
//! highest; the phase says which of both it is. At a sharp step the phase is that of an edge in every channel: no band.
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
mod border;
mod eye;
mod fault;
pub mod fft;
mod line;
mod picture;
mod rating;

pub use band::{Band, Polarity, Visibility, pooled, vertex};
pub use border::Border;
pub use eye::{Channel, Eye, luminance, luminances};
pub use fault::VisionError;
pub use line::{Line, LineView};
pub use picture::{BandMap, Picture, PictureView};
pub use rating::Criterion;
