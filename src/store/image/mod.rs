//! Images (PNG): stimuli written with the recipe that made them and proved from it, and any other image as light.

mod decode;
mod encode;
mod prove;

pub use decode::{parse_light, read_light};
pub use encode::{describe, write_codes, write_halftone, write_recipe, write_reduced, write_shaded};
pub(super) use prove::recipe_text;
pub use prove::{ReadBack, prove, prove_content, read};
