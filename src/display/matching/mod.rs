//! Gamma without a photometer: visual nulling against a halftone of rows.
//!
//! A field of whole-pixel rows, k of every m lit with code `hi` and the others with code `lo`, gives the mean light
//! k/m·L(hi) + (1 − k/m)·L(lo): a light that is known without knowing the display's transfer function, once the rows
//! blend. A uniform patch of code c inside the field vanishes where L(c) is that light. From several such matches
//! follows γ, L(c) ∝ (c/255)^γ, Shoaff §2.1.1. What the room adds to the screen falls on field and patch alike and
//! drops out.
//!
//! **Rows, not columns.** Along a row the driver (and on a tube the beam) has to follow every change within one pixel, and
//! a red, green or blue stripe beside another blurs into it; from row to row, each pixel has a line's time to settle.
//! Two things can still go wrong, and [`Plan::row_px`] = 2 (pairs of rows) avoids both: an interlaced picture shows the
//! even rows in one half-frame and the odd rows in the next, so that single rows flicker; and a panel whose drive
//! inverts its polarity from row to row shows the lit rows of a period of 2 with one polarity only, which flickers and
//! shifts their light.
//!
//! **Levels.** A match at light share p tells γ to within γ·ε/|ln p| where the match itself is good to a relative ε: low
//! shares tell most, and shares near 1 next to nothing. Levels may be nested, with `lo` or `hi` a code that was matched
//! before, which reaches low light with few rows to a period.
//!
//! [`Nulling`] runs the trials, [`estimate()`] makes γ of them, [`picture()`] draws them. No clock, no file and no source of
//! chance in here: a seed is given.

pub mod belief;
pub mod check;
pub mod estimate;
pub mod fit;
pub mod observation;
pub mod picture;
pub mod plan;
pub mod procedure;
pub mod simulated;

pub use check::CheckField;
pub use estimate::{ChannelEstimate, Doubt, Estimates, estimate};
pub use fit::{FitError, GammaFit, GogFit, MatchedLevel, Spread};
pub use observation::{Judgement, NullingStimulus, Observation, RowField};
pub use picture::picture;
pub use plan::{Effort, Level, Method, Pattern, Plan, PlanError};

pub use super::channel::Channel;
pub use procedure::{Nulling, Progress};
pub use simulated::{SimulatedDisplay, SimulatedObserver};
