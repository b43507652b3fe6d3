//! What a sitting showed: how its stimuli became codes, and the hash of each picture, by which a new rendering can be
//! compared with it.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::{
    experiment::{Condition, Protocol},
    light::{Bits, CodeImage, Dither, Samples, Transfer, Transfers},
    stimulus::recipe::Recipe,
    store::hash::sha256,
};

/// Side of the pictures of a session that had no screen, pixels.
const SIZE_WITHOUT_SCREEN: u32 = 256;

/// The pictures of a sitting.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pictures {
    /// How light became codes. Its stimulus is the definition's, before the factors are set.
    pub recipe: Recipe,
    /// [`hash`] of the picture of each condition, by the condition's number: from 1, as the factors are crossed, the
    /// last one fastest.
    pub sha256: BTreeMap<usize, String>,
}

impl Pictures {
    /// Pictures for a screen: `size` pixels a side, 8 bits, no dither. None is hashed yet.
    #[must_use]
    pub fn new(protocol: &Protocol, size: u32, transfers: &Transfers, display_sha256: Option<String>) -> Self {
        let recipe = Recipe {
            stimulus: protocol.stimulus.clone(),
            size,
            transfers: transfers.clone(),
            bits: Bits::Eight,
            dither: Dither::None,
            seed: 0,
            display_sha256,
        };
        Self { recipe, sha256: BTreeMap::new() }
    }

    /// Pictures of a session without a screen: 256 pixels a side, sRGB. None is hashed yet.
    #[must_use]
    pub fn without_screen(protocol: &Protocol) -> Self {
        Self::new(protocol, SIZE_WITHOUT_SCREEN, &Transfer::Srgb.into(), None)
    }

    /// The hash of every condition's picture, in their order.
    #[must_use]
    pub fn hashes(&self, conditions: &[Condition]) -> Vec<String> {
        let quantizer = self.recipe.quantizer();
        conditions.par_iter().map(|condition| hash(&self.recipe_of(condition).codes(&quantizer))).collect()
    }

    /// How the picture of a condition is made.
    #[must_use]
    pub fn recipe_of(&self, condition: &Condition) -> Recipe {
        Recipe { stimulus: condition.stimulus.clone(), ..self.recipe.clone() }
    }
}

/// SHA-256 of the codes of an image, row by row from the top left, red green blue, in lower-case hexadecimal; 16-bit
/// codes with their high byte first.
#[must_use]
pub fn hash(image: &CodeImage) -> String {
    match &image.samples {
        Samples::Eight(codes) => sha256(codes),
        Samples::Sixteen(codes) => sha256(&codes.iter().flat_map(|code| code.to_be_bytes()).collect::<Vec<_>>()),
    }
}
