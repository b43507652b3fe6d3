//! `machband check` and `machband verify`

use std::{
    collections::{BTreeMap, BTreeSet},
    path::{Path, PathBuf},
};

use indicatif::ProgressBar;

use super::{print_line, progress_style, warn};
use crate::{
    report::{document::numbers::count, terminal::message},
    store::{self, dataset::REGISTER, image::MAX_PIXELS, ratings, register::Register, verify},
    system::entries,
};

/// Check definitions, result files, display profiles, readings, observers and images, and report every error.
///
/// For a display profile that is old or dated in the future, and for texts that this computer has no font for, prints a
/// warning to stderr; this is not an error.
#[derive(clap::Args)]
#[command(after_help = "Example: machband check my-study.toml results/quick/data/*.csv")]
pub(super) struct CheckArguments {
    /// Files, or names of built-in definitions.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Also check images of more than 4096 × 4096 pixels, which needs more time and memory.
    #[arg(long)]
    large: bool,
}

pub(super) fn check(arguments: &CheckArguments) -> anyhow::Result<()> {
    let pixels = if arguments.large { u64::MAX } else { MAX_PIXELS };
    let mut errors = Vec::new();
    for file in &arguments.files {
        match store::check::check_large(file, pixels) {
            Ok(found) => {
                if let Some(profile) = &found.profile {
                    warn(file, profile);
                }
                if let Some(warning) = &found.warning {
                    message("warning", &format!("{}: {warning}", file.display()));
                }
                print_line(&format!("{}: {}", file.display(), found.sentence))?;
            }
            Err(error) => errors.push(error.to_string()),
        }
    }
    if errors.is_empty() { Ok(()) } else { Err(anyhow::anyhow!(errors.join("\n"))) }
}

/// Verify that the rows and pictures of recorded sessions are correct and that no file was changed.
///
/// Checks every row against the definition and the seed in the sidecar, re-renders every picture that was shown and
/// compares its hash, and compares every file with the hash recorded at the end of the session. Prints one line per
/// session to stdout and every error to stderr; if there are errors, the exit status is 1.
#[derive(clap::Args)]
#[command(after_help = "Example: machband verify results/bangay2003")]
pub(super) struct VerifyArguments {
    /// Results folder, or the folder of one experiment.
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

/// Maximum number of errors that are kept until all sessions are verified.
const MAX_ERRORS: usize = 1000;

pub(super) fn verify(arguments: &VerifyArguments) -> anyhow::Result<()> {
    let registers = registers(&arguments.folder);
    // If every session was deleted, the register still lists them.
    let files = ratings::data_files(&arguments.folder).or_else(|error| match registers.is_empty() {
        true => Err(error),
        false => Ok(Vec::new()),
    })?;
    let bar = ProgressBar::new(files.len() as u64).with_style(progress_style("sessions"));
    let mut renderer = verify::Renderer::default();
    let (mut errors, mut further) = (Vec::new(), 0);
    let mut folders: BTreeSet<PathBuf> =
        files.iter().filter_map(|csv| Some(csv.parent()?.parent()?.to_owned())).collect();
    folders.extend(registers);
    let mut listed = BTreeMap::new();
    for folder in &folders {
        let register = Register::read(folder).unwrap_or_else(|error| {
            errors.push(error.to_string());
            Register::default()
        });
        errors.extend(register.missing(folder).iter().map(ToString::to_string));
        errors.extend(verify::unexpected_files(folder).iter().map(ToString::to_string));
        for path in verify::temporary_files(folder) {
            print_line(&format!("note: {}: was left by a killed program; it can be deleted", path.display()))?;
        }
        listed.insert(folder, register);
    }
    let unlisted = Register::default();
    for csv in &files {
        let folder = csv.parent().and_then(Path::parent).map(Path::to_owned).unwrap_or_default();
        let found = verify::session(csv, &mut renderer, listed.get(&folder).unwrap_or(&unlisted));
        bar.suspend(|| print_line(&format!("{}: {}", csv.display(), sentence(&found))))?;
        bar.inc(1);
        for error in &found.errors {
            if errors.len() < MAX_ERRORS { errors.push(error.to_string()) } else { further += 1 }
        }
    }
    bar.finish_and_clear();
    if further > 0 {
        errors.push(format!("{}: further errors: {further}; expected none", arguments.folder.display()));
    }
    if errors.is_empty() {
        print_line(&format!("{} verified; no errors", count(files.len() as u64, "session")))
    } else {
        Err(anyhow::anyhow!(errors.join("\n")))
    }
}

/// Returns the data sets that have a register: the folder itself, or the folders in it.
fn registers(folder: &Path) -> Vec<PathBuf> {
    let folders = std::iter::once(folder.to_owned()).chain(entries(folder).unwrap_or_default());
    folders.filter(|folder| folder.join(REGISTER).is_file()).collect()
}

fn sentence(found: &verify::Verified) -> String {
    let verify::Verified { rows, rated: (rated, planned), pictures, sealed, errors, notes } = found;
    let mut parts = vec![
        format!(
            "{}, {rated} of {planned} trials rated, {} rendered again",
            count(*rows as u64, "row"),
            count(*pictures as u64, "picture")
        ),
        if !errors.is_empty() {
            count(errors.len() as u64, "error")
        } else if *sealed {
            "unchanged since it was recorded".to_owned()
        } else {
            "no errors".to_owned()
        },
    ];
    parts.extend(notes.iter().cloned());
    parts.join("; ")
}
