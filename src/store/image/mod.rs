//! PNG images. Stimuli are written with their recipe and can be verified against it; any other image can be read as
//! light.

mod picture;
mod read;
mod write;

pub use picture::{MAX_PIXELS, Origin, Picture, listed, parse_picture, pixels, read_picture};
pub(super) use read::recipe_text;
pub use read::{ReadBack, read, verify, verify_content};
pub(super) use write::recipe_png;
pub use write::{describe, hash, write_codes, write_halftone, write_recipe, write_reduced, write_shaded};
