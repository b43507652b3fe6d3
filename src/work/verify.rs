//! Whether recorded sessions are correct and unchanged.

use std::path::PathBuf;

use serde::Serialize;

use super::{Found, Watcher};
use crate::{
    report::document::numbers::count,
    store::{
        FileErrors,
        ratings::Listed,
        recorded::{self, Renderer, Verified},
    },
};

/// Verify that the rows and pictures of recorded sessions are correct and that no file was changed.
///
/// Checks every row against the definition and the seed in the sidecar, re-renders every picture that was shown and
/// compares its hash, and compares every file with the hash recorded at the end of the session. Prints one line per
/// session to stdout and every error to stderr; if there are errors, the exit status is 1.
#[derive(Clone, Debug, PartialEq, Eq, clap::Args, Serialize)]
#[command(after_help = "Example: machband verify results/bangay2003")]
pub struct Verify {
    /// Results folder, or the folder of one experiment.
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
}

impl Verify {
    /// Verifies every session, and returns a sentence about each, and all errors. The watcher learns the number of
    /// sessions.
    ///
    /// # Errors
    /// The folder cannot be read, it contains no sessions, or the watcher ended it.
    pub fn verify(&self, watcher: &dyn Watcher) -> anyhow::Result<Found> {
        let listed = Listed::sessions(&self.folder);
        // If the rows of every session were deleted, their sidecars still exist.
        let mut errors = [listed.errors.clone(), listed.unexpected(&listed.datasets)].concat();
        if listed.files.is_empty() && errors.is_empty() {
            return Err(listed.nothing(&self.folder).into());
        }
        let (mut found, mut renderer) = (Found::default(), Renderer::default());
        for (csv, done) in listed.files.iter().zip(1..) {
            let verified = recorded::verify(csv, &mut renderer);
            found.add(csv, sentence(&verified), watcher)?;
            watcher.progress(done, listed.files.len() as u64);
            if !verified.errors.is_empty() {
                found.wrong.insert(csv.clone());
            }
            errors.extend(verified.errors);
        }
        listed.warnings.iter().for_each(|warning| watcher.warn(&warning.to_string()));
        found.errors = errors.into_iter().map(|error| FileErrors(vec![error]).into()).collect();
        Ok(found)
    }
}

/// Summarizes the findings about one session.
fn sentence(found: &Verified) -> String {
    let Verified { rows, rated: (rated, planned), pictures, sealed, accepted, errors, notes } = found;
    let mut parts = vec![
        // A session that could not be read has no plan.
        if *planned == 0 && !errors.is_empty() {
            "could not be read".to_owned()
        } else {
            format!(
                "{}, {rated} of {planned} trials answered, {} rendered again",
                count(*rows as u64, "row"),
                count(*pictures as u64, "picture")
            )
        },
        if !errors.is_empty() {
            count(errors.len() as u64, "error")
        } else if *sealed {
            format!("unchanged since {}", if *accepted { "changes were accepted" } else { "it was recorded" })
        } else {
            "no errors".to_owned()
        },
    ];
    parts.extend(notes.iter().cloned());
    parts.join("; ")
}
