//! What becomes of the blocks of a document.

pub mod html;
