//! From readings of a photometer to how a display turns codes into light.
//!
//! [`Readings`] are checked, [`Calibration`] fits them. Three families of curves ([`Family`]) are fitted by weighted least
//! squares, a photometer's noise being about proportional to what it reads; a table follows what no curve does.
//!
//! # How well γ can be known
//! One reading a level of red, green, blue and gray, noise 1 %. The least standard error of γ that statistics allow
//! (Cramér and Rao) at 6, 9, 17 and 33 levels is 0.005, 0.004, 0.003 and 0.002 for a power, where the channels share it;
//! with an offset that is free too, 0.022, 0.013, 0.008 and 0.005, since γ and offset explain much of the same. So an
//! offset is taken only where the readings ask for it. Of simulated displays with such an offset (γ 2.2, offset ±0.02
//! and ±0.05 of the gain, black 0.3 of 115 cd/m²), γ is within ±0.02 in 47…80 % at 6 levels, 81…98 % at 9, 96…99 % at 17
//! and 99…100 % at 33; the transfer functions are within half a code in 54…68, 89…97, 97…99 and 100 %. A power, or an
//! offset that itself makes the black, is within both from 6 levels on. Four readings a level halve each error.

mod additivity;
mod bend;
mod calibration;
mod checks;
mod fault;
mod fit;
mod model;
mod noise;
mod note;
mod plan;
mod reading;
mod readings;
mod response;
mod sample;
mod select;
mod shape;
mod validation;

pub use additivity::{ADDITIVE_PERCENT, Additivity, Sum};
pub use calibration::{Calibration, FittedChannel, FittedModel};
pub use fault::{LEAST_LEVELS, ReadingFault};
pub use noise::Noise;
pub use note::Note;
pub use plan::{Drift, GENERATOR, Patch, Plan, PlanError, PlanSettings};
pub use reading::{Channel, LevelMean, Reading, UnknownChannel};
pub use readings::{Fault, Readings};
pub use response::Response;
pub use shape::{Curve, Family, Shape};
pub use validation::CrossValidation;
