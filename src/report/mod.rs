//! Floor 5: from files to what a reader of a study sees.
//!
//! [`Study`] is what was read, [`analyse`](crate::analysis::analyse) makes results of it; [`tables`], [`figures`] and
//! [`html`] show them, and [`write_all`] writes everything into a folder.

pub(crate) mod document;
pub mod figures;
mod output;
pub mod prediction;
pub mod skins;
pub mod study;
pub mod tables;

pub use output::{Extent, Written, write_all};
pub use skins::html;
pub use study::{Repetition, Study};
