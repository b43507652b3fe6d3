//! Tables for the documentation, timings and long runs: `cargo run --release -p tools -- COMMAND`.

mod bands;
mod bare_window;
mod creases;
mod facts;
mod long_session;
mod sample_study;
mod times;

use std::path::PathBuf;

use clap::Parser;
use tools::blue_noise::{MASK_SEED, to_bytes, void_and_cluster};

/// Tables, timings and long runs of machband.
#[derive(Parser)]
enum Tool {
    /// How visible the vision model finds the bands that each shader leaves: the table of docs/shaders.md.
    Bands {
        /// Use the scene of the shading page instead of a matt surface lit from the eye.
        #[arg(long)]
        default_scene: bool,
    },
    /// How much of Gouraud's creases each shader leaves: the table of creases in the documentation.
    Creases,
    /// Which known facts about Mach bands each model reproduces: the table of docs/models.md.
    Facts,
    /// How long ODOG takes, for benches/odog_peers.py; writes the response, float32 row by row, to FILE.
    Odog {
        /// Pixels a side.
        #[arg(default_value_t = 512)]
        size: usize,
        /// Pixels a degree.
        #[arg(default_value_t = 32.0)]
        px_per_deg: f64,
        file: Option<PathBuf>,
    },
    /// How long the vision model takes for a picture, for benches/odog_peers.py.
    Picture {
        /// Pixels a side.
        #[arg(default_value_t = 512)]
        size: usize,
        /// Pixels a degree.
        #[arg(default_value_t = 32.0)]
        px_per_deg: f64,
    },
    /// A session of 20,000 trials through the real store: time and memory per thousand trials.
    LongSession {
        /// Where to write the session [default: the system's temporary folder].
        folder: Option<PathBuf>,
    },
    /// The first half of an interrupted session with a corrected response, for scripts/validate_exports.sh.
    SampleStudy {
        /// Where to write the results.
        results: PathBuf,
    },
    /// A window that only clears itself, for benches/frames_peers.py.
    BareWindow {
        /// Frames to count.
        #[arg(default_value_t = 300)]
        frames: usize,
    },
    /// Write the blue-noise mask that dithering uses.
    BlueNoise {
        #[arg(default_value = concat!(env!("CARGO_MANIFEST_DIR"), "/../src/light/blue_noise_64.bin"))]
        file: PathBuf,
    },
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    match Tool::parse() {
        Tool::Bands { default_scene } => bands::run(default_scene),
        Tool::Creases => creases::run(),
        Tool::Facts => {
            facts::run();
            Ok(())
        }
        Tool::Odog { size, px_per_deg, file } => times::odog(size, px_per_deg, file.as_deref()),
        Tool::Picture { size, px_per_deg } => times::picture(size, px_per_deg),
        Tool::LongSession { folder } => long_session::run(&folder.unwrap_or_else(std::env::temp_dir)),
        Tool::SampleStudy { results } => sample_study::run(&results),
        Tool::BareWindow { frames } => bare_window::run(frames),
        Tool::BlueNoise { file } => {
            std::fs::write(&file, to_bytes(&void_and_cluster(machband::light::blue_noise::MASK_SIZE, MASK_SEED)))?;
            println!("{}", file.display());
            Ok(())
        }
    }
}
