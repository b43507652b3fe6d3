//! Measures gamma without a photometer: the observer matches a patch to a field of rows by eye.
//!
//! In a field of whole-pixel rows, k of every m rows are lit with the largest code, and the others are dark. Once the
//! rows blend, the field has k/m of the full light, whatever the display's transfer function is. A uniform patch of
//! code c inside the field vanishes if it has the same light. Such matches determine γ in L(c) ∝ (c/255)^γ, Shoaff
//! §2.1.1. Ambient light falls equally on the field and the patch and cancels.
//!
//! **Rows, not columns.** Along a row, the driver (on a CRT, the beam) has to follow every change within one pixel, and
//! a red, green or blue stripe blurs into the next. From row to row, each pixel has the time of a whole line to settle.
//! Two things can still go wrong, and pairs of rows ([`Rows::row_px`] = 2) avoid both. An interlaced picture shows the
//! even rows in one half-frame and the odd rows in the next, so single rows flicker. A panel that inverts its drive
//! polarity from row to row shows the lit rows of a period of 2 with one polarity only, which makes them flicker and
//! shifts their light.
//!
//! **Which rows.** If the field has the share p of full light, a match with the relative precision ε determines γ to
//! within γ·ε/|ln p|: lighting one row of four is twice as precise as lighting one row of two.
//!
//! [`Matching`] presents the matches, [`estimate()`] derives γ from them, and [`Rows::check_patch`] shows whether a
//! profile is right. This module has no clock, no file, and no source of randomness: the seed is an argument.

mod estimate;
mod procedure;
mod rows;

pub use estimate::{ChannelGamma, GammaError, estimate, transfers};
pub use procedure::{GAP_S, Match, MatchSettings, Matching};
pub use rows::{CHECKED, Rows};
