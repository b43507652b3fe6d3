//! Writes the blue-noise mask that dither uses, as it is committed: `cargo run --example blue_noise_mask`.
//! Another file can be named, `… -- FILE`.

use std::path::PathBuf;

use machband::light::blue_noise::{MASK_SEED, MASK_SIZE, to_bytes, void_and_cluster};

fn main() -> std::io::Result<()> {
    let committed = || concat!(env!("CARGO_MANIFEST_DIR"), "/src/light/blue_noise_64.bin").into();
    let path: PathBuf = std::env::args_os().nth(1).map_or_else(committed, PathBuf::from);
    std::fs::write(&path, to_bytes(&void_and_cluster(MASK_SIZE, MASK_SEED)))?;
    println!("{MASK_SIZE} × {MASK_SIZE} ranks, seed {MASK_SEED}: {}", path.display());
    Ok(())
}
