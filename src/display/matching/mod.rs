//! Gamma without a photometer: a patch is matched by eye to a field of rows.
//!
//! A field of whole-pixel rows, k of every m lit with the largest code and the others dark, has k/m of the full light:
//! which is known without the display's transfer function, once the rows blend. A uniform patch of code c inside the
//! field vanishes if it has the same light. Such matches determine γ, L(c) ∝ (c/255)^γ, Shoaff §2.1.1. Ambient light
//! falls equally on field and patch and cancels.
//!
//! **Rows, not columns.** Along a row the driver (and on a tube the beam) has to follow every change within one pixel, and
//! a red, green or blue stripe blurs into the next; from row to row, each pixel has a line's time to settle. Two things
//! can still go wrong, and pairs of rows ([`Rows::row_px`] = 2) avoid both: an interlaced picture shows the even rows in
//! one half-frame and the odd rows in the next, so that single rows flicker; and a panel whose drive inverts its polarity
//! from row to row shows the lit rows of a period of 2 with one polarity only, which flickers and shifts their light.
//!
//! **Which rows.** A match with the relative precision ε determines γ to within γ·ε/|ln p| for a light share p: one row
//! of four is twice as precise as one row of two.
//!
//! [`Matching`] presents the matches, [`estimate()`] derives γ from them, [`Rows::check_patch`] shows whether a profile is
//! right. There is no clock, no file, and no source of randomness here: the seed is an argument.

mod estimate;
mod procedure;
mod rows;

pub use estimate::{ChannelGamma, GammaError, estimate, transfers};
pub use procedure::{GAP_S, Match, MatchSettings, Matching};
pub use rows::{CHECKED, Rows};
