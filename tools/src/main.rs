//! Tables for the documentation, timings and long runs: `cargo run --release -p tools -- COMMAND`.

mod calibration;
mod efficiency;
mod facts;
mod peers;
mod sessions;
mod shaders;

use std::{
    error::Error,
    fs::File,
    io::BufWriter,
    path::{Path, PathBuf},
};

use clap::Parser;
use clap_complete::Shell;
use machband::{app, cli};
use tools::blue_noise::{MASK_SEED, to_bytes, void_and_cluster};

/// Print tables for the documentation, and run timings and long sessions.
#[derive(Parser)]
enum Tool {
    /// Print the tables whose ranges docs/shaders.md gives: how far each shader is from the smooth surface.
    Residuals,
    /// Print the table of docs/shading.md: the slope jumps that each shader leaves, relative to Gouraud's.
    Creases,
    /// Print the table of docs/models.md: what the model says about ramps, edges and kinks, and how far it depends on each
    /// constant.
    Facts,
    /// Print the tables of docs/models.md that compare the detection model with measured thresholds of people.
    Thresholds {
        /// Also fit the parameters, from round numbers; takes minutes.
        #[arg(long)]
        fit: bool,
        /// Also print the error of each stimulus.
        #[arg(long)]
        verbose: bool,
    },
    /// Print the tables of docs/tasks.md: how many trials each adaptive method needs.
    Efficiency,
    /// Print the table of docs/statistics.md: type I errors and coverage in the studies that
    /// scripts/calibration_studies.py wrote.
    Calibration {
        /// Folder with the studies.
        folder: PathBuf,
        /// Designs to analyze; all by default.
        designs: Vec<String>,
        /// Number of studies of each design to analyze.
        #[arg(long, default_value_t = 1000)]
        studies: usize,
        /// Number of simulated studies that calibrate each analysis.
        #[arg(long, default_value_t = 199)]
        draws: u32,
    },
    /// Run a session of 20,000 trials through the real store and print time and memory per thousand trials.
    LongSession {
        /// Where to write the session [default: the system's temporary folder].
        folder: Option<PathBuf>,
    },
    /// Write the first half of an interrupted session with a corrected response, for scripts/validate_exports.sh.
    SampleStudy {
        /// Where to write the results.
        results: PathBuf,
    },
    /// Write man pages, completions for shells and the icon, for scripts/deb.sh.
    Package {
        /// Where to write them.
        folder: PathBuf,
    },
    /// Open a window that only clears itself, to compare frame times with.
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

fn main() -> Result<(), Box<dyn Error>> {
    match Tool::parse() {
        Tool::Residuals => shaders::residuals(),
        Tool::Creases => shaders::creases(),
        Tool::Efficiency => {
            efficiency::print();
            Ok(())
        }
        Tool::Facts => facts::run(),
        Tool::Thresholds { fit, verbose } => tools::thresholds::run(fit, verbose),
        Tool::Calibration { folder, designs, studies, draws } => calibration::run(&folder, &designs, studies, draws),
        Tool::LongSession { folder } => sessions::long(&folder.unwrap_or_else(std::env::temp_dir)),
        Tool::SampleStudy { results } => sessions::sample(&results),
        Tool::Package { folder } => write_package(&folder),
        Tool::BareWindow { frames } => peers::bare_window(frames),
        Tool::BlueNoise { file } => {
            std::fs::write(&file, to_bytes(&void_and_cluster(machband::light::dither::MASK_SIZE, MASK_SEED)))?;
            println!("{}", file.display());
            Ok(())
        }
    }
}

/// Writes `man1/`, `completions/` and `machband.png` into a folder.
fn write_package(folder: &Path) -> Result<(), Box<dyn Error>> {
    let (man, completions) = (folder.join("man1"), folder.join("completions"));
    std::fs::create_dir_all(&man)?;
    std::fs::create_dir_all(&completions)?;
    clap_mangen::generate_to(cli::definition(), &man)?;
    for shell in [Shell::Bash, Shell::Fish, Shell::Zsh] {
        clap_complete::generate_to(shell, &mut cli::definition(), "machband", &completions)?;
    }
    let icon = app::icon();
    let mut encoder =
        png::Encoder::new(BufWriter::new(File::create(folder.join("machband.png"))?), icon.width, icon.height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.write_header()?.write_image_data(&icon.rgba)?;
    Ok(())
}
