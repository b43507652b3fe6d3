//! Shading: the same surface in the same light, drawn by two renderers side by side.
//!
//! | file | what |
//! |---|---|
//! | `comparison` | what is compared; comparisons by name |
//! | `pictures` | drawing: on the graphics card, on the processor, and only what has changed |
//! | `measures` | creases and predicted bands of both sides; light along a line |
//! | `canvas` | the picture and what can be dragged on it |
//! | `controls`, `export` | the panel |
//! | `page` | all of it together |

mod canvas;
mod comparison;
mod controls;
mod export;
mod measures;
mod page;
mod pictures;

pub use comparison::{Comparison, MeshChoice, title};
pub(crate) use page::ShadingPage;
