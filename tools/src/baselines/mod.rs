//! Published models of Mach bands, to be held against ours on the same facts.
//!
//! Each sees a picture of one dimension: a profile of linear light. Each answers with the bands it
//! predicts, in a unit of its own; only order and ratios of one model's strengths mean anything, never
//! one model's against another's.
//!
//! A band, in all of them, is an extremum of what the model makes of the light **where the light itself has
//! none**: the crest of a grating is bright, but it is no Mach band.

mod bands;
mod dog;
mod model;
mod odog;
mod picture;
mod ratio;
mod spectrum;

pub use dog::LateralInhibition;
pub use model::{Baseline, Mark};
pub use odog::{Beyond, Odog, OdogFilters};
pub use ratio::SecondDerivativeRatio;

/// Every model here with its published constants.
#[must_use]
pub fn all() -> Vec<Box<dyn Baseline + Send + Sync>> {
    vec![Box::new(LateralInhibition::default()), Box::new(Odog::default()), Box::new(SecondDerivativeRatio::default())]
}
