//! What becomes of the blocks of a document: a page, or text on a terminal. The window's skin is in `app/analysis`.

mod html;
mod terminal;

pub use html::html;
pub use terminal::terminal;
