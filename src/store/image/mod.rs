//! PNG images. Stimuli are written with their recipe and can be verified against it; any other image can be read as
//! light.

mod picture;
mod read;
mod write;

pub use picture::{ASSUMED, MAX_PIXELS, Picture, listed, parse_picture, read_picture};
pub(super) use read::recipe_text;
pub use read::{verify, verify_content};
pub use write::{describe, hash, recipe_png, write_codes, write_recipe};
