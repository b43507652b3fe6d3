//! Floor 1: a model of vision, which predicts whether people detect a picture, where they see bright and dark bands in
//! it, and how visible the bands are.
//!
//! The model of bands stands in the tradition of Morrone and Burr (1988, Proc. R. Soc. B 235:221; Ross, Morrone & Burr
//! 1989, Vis. Res. 29:699): the eye sees a line where the even response of a channel outweighs the odd response. At a
//! sharp step, no channel's even response does, so there is no band. At the end of a ramp, it does, so there is a band.
//! It is an illusion if the light itself only rises or only falls there; otherwise it is a line of the picture.
//!
//! ```text
//! light → channels (log-Gabor, thirds of octaves): even, odd → even beyond the nearby odd → sensitivity / mean light
//!       → smoothed along and across the band → pooled over channels
//! ```
//!
//! The unit is measured: a band of visibility 1 has the response of a thin line at its detection threshold. The source
//! of every constant is cited where it is defined. [`Line`] is for stimuli that vary in one direction, and
//! [`LuminanceImage`] is for images; the two agree.

mod band;
mod blur;
mod channel;
mod detection;
mod error;
mod eye;
pub mod fft;
mod image;
mod line;
mod picture;
mod sensitivity;
mod spectrum;

pub use band::{Band, BandMap, Criterion, Polarity, Visibility, vertex};
pub use detection::{ContrastSpectrum, detection};
pub use error::VisionError;
pub use eye::{Border, Eye, luminance, luminances};
pub use image::LuminanceImage;
pub use line::{Line, LinePrediction};
pub use picture::PicturePrediction;
pub use sensitivity::Sensitivity;
