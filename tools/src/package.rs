//! What a package for a desktop contains besides the program.

use std::{error::Error, fs::File, io::BufWriter, path::Path};

use clap_complete::Shell;
use machband::{app, cli};

/// Writes `man1/`, `completions/` and `machband.png` into a folder.
pub fn write(folder: &Path) -> Result<(), Box<dyn Error>> {
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
