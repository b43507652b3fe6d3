//! Derives from photometer readings how a display turns codes into light.
//!
//! [`Readings`] are checked, and [`Calibration`] fits them: sRGB, a power, gain–offset–gamma and a monotone table. The one
//! that best predicts levels left out is used.
//!
//! A photometer's noise is about proportional to what it reads. With one reading per level of red, green, blue and gray
//! and 1 % of noise, γ of a power has an uncertainty of 0.005, 0.004, 0.003 and 0.002 (standard error at 6, 9, 17 and
//! 33 levels) where the channels share it, and with a free offset to 0.022, 0.013, 0.008 and 0.005: γ and offset
//! explain much of the same.

mod calibration;
mod checks;
mod fit;
mod patches;
mod readings;
mod table;

pub use calibration::{Calibration, FittedChannel, FittedModel, Validation};
pub use checks::{About, Fault, LEAST_LEVELS, Sum, additivity, drift_percent, largest};
pub use fit::{Curve, Family};
pub use patches::{Patch, PatchSettings, patches};
pub use readings::{LevelMean, Reading, Readings, is_same_level};
