//! Shading: the same surface in the same light, drawn by two renderers side by side.
//!
//! | file | contents |
//! |---|---|
//! | `comparison` | the comparison |
//! | `pictures` | drawing, only if something has changed; visible differences of both sides; light along a line |
//! | `canvas` | the image and dragging on it; keys to its colors |
//! | `controls` | the panel of controls |
//! | `page` | the complete page, and its export |

mod canvas;
mod comparison;
mod controls;
mod page;
mod pictures;

pub use comparison::{Comparison, MeshChoice, title};
pub(crate) use page::ShadingPage;
