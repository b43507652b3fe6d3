//! Floor 5: from files to what a reader of a study sees.
//!
//! [`Study`] is what was read, [`analyse`](crate::analysis::analyse) makes results of it; [`tables`], [`figures`] and
//! [`html`] show them, and [`write_all`] writes everything into a folder.
//! [`intervals`] draws how evenly frames came.

pub mod figures;
pub mod html;
pub mod intervals;
mod output;
pub mod prediction;
mod study;
pub mod tables;

pub use html::Repetition;
pub use output::{Extent, Written, write_all};
pub use study::Study;
