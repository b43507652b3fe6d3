//! `machband run`

use std::path::PathBuf;

use crate::{
    app::{self, Launch, Request},
    experiment::Identity,
    store::{
        StoreError,
        dataset::{SessionPaths, free_participant},
        definition, profile,
        session::{Changes, SessionStore},
    },
    system::{check_clock, found},
    text::number::whole,
};

/// Open the window and start a session.
#[derive(clap::Args)]
#[command(after_help = "Example: machband run bangay2003 --participant S001 --session 1 --seed 7")]
pub(super) struct Arguments {
    /// Built-in definition or path to a .toml file.
    experiment: PathBuf,
    /// Participant ID [default: the next unused one of P001, P002, …].
    #[arg(long, value_name = "ID", value_parser = Identity::check_subject)]
    participant: Option<String>,
    /// Session ID.
    #[arg(long, value_name = "ID", default_value = "1", value_parser = Identity::check_session)]
    session: String,
    /// Seed of the trial order [default: a new random seed].
    #[arg(long, value_name = "N", value_parser = whole(0..=u64::MAX))]
    seed: Option<u64>,
    /// Folder for the results.
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,
    /// Display profile [default: sRGB].
    #[arg(long, value_name = "PROFILE.toml")]
    display: Option<PathBuf>,
    /// Use a window instead of the full screen.
    #[arg(long)]
    windowed: bool,
    /// File with the window's settings, such as the size of its text.
    #[arg(long, value_name = "FILE.toml")]
    config: Option<PathBuf>,
    /// Resume an interrupted session.
    #[arg(long, requires = "participant")]
    resume: bool,
    /// Resume a session whose files were changed after they were sealed; its sidecar records the change.
    #[arg(long, requires = "resume")]
    accept_changes: bool,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    check_clock()?;
    let protocol = definition::open(&arguments.experiment)?;
    let participant = match &arguments.participant {
        Some(participant) => participant.clone(),
        None => free_participant(&arguments.results, &protocol)?,
    };
    let identity = Identity::new(&participant, &arguments.session).map_err(anyhow::Error::msg)?;
    // Problems that would otherwise surface only after the preflight are reported before a window opens.
    let csv = SessionPaths::new(&arguments.results, &protocol, &identity).csv;
    let changes = if arguments.accept_changes { Changes::Accept } else { Changes::Refuse };
    if arguments.resume {
        if SessionStore::is_finished(&arguments.results, &protocol, &identity, arguments.seed, changes)? {
            return super::print_line(&format!("{}: the session is already complete", csv.display()));
        }
    } else if found(&csv).map_err(|error| StoreError::io(&csv, "access", error))?.is_some() {
        return Err(StoreError::Exists(csv).into());
    }
    let display = arguments.display.as_deref().map(profile::open).transpose()?.unwrap_or_default();
    let request = Request {
        distance_cm: protocol.viewing.distance_cm,
        screen_width_cm: None,
        protocol,
        identity,
        seed: arguments.seed,
        results: arguments.results.clone(),
        display,
        resume: arguments.resume,
        changes,
        windowed: arguments.windowed,
    };
    app::open(Launch { request: Some(request), settings: arguments.config.clone() })?;
    Ok(())
}
