//! How visible the bands of an experiment's conditions are to the model of vision.

use rayon::prelude::*;

use super::Condition;
use crate::{
    stimulus::Sight,
    vision::{Visibility, VisionError},
};

/// Of each condition, shown with `px` pixels on a side; [`Sight::px`] where none are given.
///
/// # Errors
/// [`VisionError`] of a condition that cannot be seen, such as one that is all black.
pub fn visibilities(conditions: &[Condition], sight: &Sight, px: Option<u32>) -> Result<Vec<Visibility>, VisionError> {
    let see = |condition: &Condition| {
        let stimulus = &condition.stimulus;
        Ok(sight.see(stimulus, px.unwrap_or_else(|| Sight::px(stimulus)))?.visibility())
    };
    // Pictures keep all threads busy one by one, and need memory.
    if conditions.iter().any(|condition| !condition.stimulus.is_line()) {
        return conditions.iter().map(see).collect();
    }
    conditions.par_iter().map(see).collect()
}
