//! `machband check`

use super::UsageError;

/// Check definitions, result files, display profiles, observers and images; every fault is named.
///
/// A display profile that is old, or dated in the future, is not a fault; a warning on stderr says so.
#[derive(clap::Args)]
#[command(after_help = "Example: machband check my-study.toml results/quick/data/*.csv")]
pub(super) struct Arguments {
    /// Files, or names of built-in definitions.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<String>,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let mut faults = Vec::new();
    for file in &arguments.files {
        if file.is_empty() {
            return Err(UsageError("a file name is empty; expected a path".to_owned()).into());
        }
        match crate::store::check::check(file) {
            Ok(found) => {
                if let Some(profile) = &found.profile {
                    super::warn(file, profile);
                }
                super::say(&format!("{file}: {}", found.sentence))?;
            }
            Err(error) => faults.push(error.to_string()),
        }
    }
    if faults.is_empty() { Ok(()) } else { Err(anyhow::anyhow!(faults.join("\n"))) }
}
