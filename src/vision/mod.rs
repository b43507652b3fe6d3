//! Floor 1: a model of vision, which predicts whether people can tell one picture from another.
//!
//! It needs no rule for what a band is. Its unit is people's threshold: at 1, people tell the two pictures apart in 84 %
//! of choices between them.
//!
//! ```text
//! difference and reference, relative to the light to which the eye adapts → contrast sensitivity
//!   → bands of an octave: each is masked by the reference's response in the same band → sum
//!   → pooled over space, for a gaze at each place
//! ```
//!
//! [`Judge`] compares pictures, or lines that vary in one direction; [`RampBands`] compares a ramp with the nearest
//! smooth edge; [`ContrastSpectrum`] compares a picture with a uniform field. [`Sensitivity`] was fitted to people's thresholds,
//! and the sources of all other constants are cited where they are defined. See `docs/models.md`.

mod detection;
mod error;
mod eye;
mod grid;
mod judge;
mod transforms;

pub use detection::ContrastSpectrum;
pub use error::{MAX_DEG, VisionError, check_extent};
pub use eye::{Criterion, Eye, Masking, SRGB_WEIGHTS, Sensitivity, luminance, luminances};
pub use judge::{Difference, DifferenceMap, Judge, Place, RampBands};
pub use transforms::{next_fast_length, unrounded};
