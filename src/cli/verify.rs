//! `machband verify`

use std::{collections::BTreeSet, path::PathBuf};

use indicatif::ProgressBar;

use super::progress_style;
use crate::store::{ratings, verify};

/// Prove recorded sessions: rows, pictures, and that nothing was changed since.
///
/// Every row is held against the definition and the seed in the sidecar, every picture that was shown is rendered again
/// and its hash compared, and the hashes that a session left at its end tell whether a file was changed since. One line
/// a session on stdout, what is wrong on stderr; exit status 1 where anything is.
#[derive(clap::Args)]
#[command(after_help = "Example: machband verify results/bangay2003")]
pub(super) struct Arguments {
    /// Results folder, or that of one experiment.
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let files = ratings::data_files(&arguments.folder)?;
    let bar = ProgressBar::new(files.len() as u64).with_style(progress_style("sessions"));
    let mut renderer = verify::Renderer::default();
    let (mut faults, mut sentences) = (Vec::new(), Vec::new());
    for csv in &files {
        let found = verify::session(csv, &mut renderer);
        bar.inc(1);
        sentences.push(format!("{}: {}", csv.display(), sentence(&found)));
        faults.extend(found.faults.iter().map(ToString::to_string));
    }
    bar.finish_and_clear();
    for sentence in &sentences {
        super::say(sentence)?;
    }
    let folders: BTreeSet<_> = files.iter().filter_map(|csv| csv.parent()?.parent()).collect();
    for folder in folders {
        faults.extend(verify::leftovers(folder).iter().map(ToString::to_string));
    }
    if faults.is_empty() {
        super::say(&format!("{} sessions: nothing is wrong", files.len()))
    } else {
        Err(anyhow::anyhow!(faults.join("\n")))
    }
}

fn sentence(found: &verify::Verified) -> String {
    let verify::Verified { rows, rated: (rated, planned), pictures, sealed, faults, notes } = found;
    let mut parts = vec![
        format!("{rows} rows, {rated} of {planned} trials rated, {pictures} pictures rendered again"),
        if !faults.is_empty() {
            format!("{} FAULTS", faults.len())
        } else if *sealed {
            "as it was recorded".to_owned()
        } else {
            "no fault".to_owned()
        },
    ];
    parts.extend(notes.iter().cloned());
    parts.join("; ")
}
