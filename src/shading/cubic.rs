//! Fields whose slope is continuous over triangles on the screen. The file is one of those that programmers copy.

#[path = "../../shaders/ordinates.rs"]
mod ordinates;

pub use ordinates::*;
