//! Published models of Mach bands, for comparison with ours on the same facts.
//!
//! The input of each model is a one-dimensional profile of linear light. The output is the bands that it predicts, in a
//! unit of its own. Only the order and the ratios of strengths within a model are meaningful; never compare strengths
//! between models.
//!
//! In all models, a band is an extremum of the response **where the light itself has none**: the crest of a grating is
//! bright, but it is not a Mach band.

mod dog;
mod odog;
mod profile;
mod ratio;

pub use dog::LateralInhibition;
pub use odog::{Beyond, Odog, OdogFilters};
pub use profile::{Baseline, Mark};
pub use ratio::SecondDerivativeRatio;

/// Every model in this module, with its published constants.
#[must_use]
pub fn all() -> Vec<Box<dyn Baseline + Send + Sync>> {
    vec![Box::new(LateralInhibition::default()), Box::new(Odog::default()), Box::new(SecondDerivativeRatio::default())]
}
