//! `machband check` and `machband verify`

use std::path::PathBuf;

use super::{Bar, print_line};
use crate::{
    report::{document::numbers::count, terminal::message},
    store::{self, image::MAX_PIXELS, verify},
    work::{Watcher as _, outdated},
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
                let outdated = found.profile.as_ref().and_then(|profile| outdated(file, profile));
                outdated.iter().for_each(|warning| message("warning", warning));
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

pub(super) fn verify(arguments: &VerifyArguments) -> anyhow::Result<()> {
    let bar = Bar::new("sessions");
    let (mut printed, mut done) = (Ok(()), 0);
    let found = verify::data_sets(&arguments.folder, |csv, found, all| {
        printed = bar.above(|| print_line(&format!("{}: {}", csv.display(), sentence(found))));
        done += 1;
        bar.progress(done, all as u64);
        printed.is_ok()
    })?;
    bar.clear();
    printed?;
    found.left.iter().try_for_each(|path| {
        print_line(&format!("note: {}: was left by a killed program; it can be deleted", path.display()))
    })?;
    let errors: Vec<String> = found.errors.iter().map(ToString::to_string).collect();
    if errors.is_empty() {
        print_line(&format!("{} verified; no errors", count(found.sessions as u64, "session")))
    } else {
        Err(anyhow::anyhow!(errors.join("\n")))
    }
}

/// Summarizes the findings about one session.
#[must_use]
pub fn sentence(found: &verify::Verified) -> String {
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
