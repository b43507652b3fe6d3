//! The blue-noise mask: ranks without pattern and without slow undulation.
//!
//! R. Ulichney, *The void-and-cluster method for dither array generation*, Proc. SPIE 1913 (1993). `cargo run -p tools --
//! blue-noise` writes the mask beside this file anew, and a test there compares the two byte for byte.

/// Pixels a side of the mask.
pub const MASK_SIZE: u32 = 64;

/// The mask's ranks, 16 bits each, lower byte first.
const MASK_BYTES: &[u8; 2 * MASK_SIZE as usize * MASK_SIZE as usize] = include_bytes!("blue_noise_64.bin");

/// The ranks of the committed mask, each of 0…[`MASK_SIZE`]²−1 once, row by row from the top left.
#[must_use]
pub fn mask() -> Vec<u16> {
    MASK_BYTES.chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect()
}
