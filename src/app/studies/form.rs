//! The form on the start page and the errors in its fields.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use super::grid::Cell;
use crate::{
    app::{
        display::CheckedScreen,
        session::Request,
        ui::{Field, Monitor, ScreenFields, full, number},
    },
    display::DisplayProfile,
    experiment::{Identity, Protocol, Schedule},
    report::names::capitalized,
    store::{
        StoreError,
        dataset::free_participant,
        definition,
        session::{Changes, SessionStore},
    },
    system::{found, may_write},
};

/// Width of the column of labels, points.
pub const LABELS: f32 = 152.0;

/// The values of the fields, as typed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SessionForm {
    /// Name of a built-in definition, or path of a file.
    pub experiment: String,
    /// Participant ID and session ID.
    pub cell: Cell,
    /// Fields for the screen and the viewing distance.
    pub screen: ScreenFields,
    /// Path of the results folder.
    pub results: String,
}

/// The labels of the fields, to which errors belong.
pub const EXPERIMENT: &str = "Experiment";
pub const PARTICIPANT: &str = "Participant";
pub const SESSION: &str = "Session";
pub const RESULTS: &str = "Results folder";

/// The result of checking a form for a monitor.
#[derive(Debug)]
pub struct Checked {
    /// The definition, if it is valid.
    pub protocol: Option<Protocol>,
    /// What the fields for the screen say.
    pub screen: CheckedScreen,
    /// What is wrong in the other fields.
    errors: BTreeMap<&'static str, String>,
    /// Whether this session is unfinished, so that Start resumes it.
    pub resume: bool,
    /// The session to run, if there are no errors.
    pub request: Option<Request>,
}

impl Checked {
    /// Creates the control for a field, with its error.
    pub fn field(&self, part: &'static str) -> Field<'_> {
        Field::new(part).column(LABELS).error(self.error(part))
    }

    /// Returns the error of a field; empty if there is none.
    pub fn error(&self, part: &str) -> &str {
        self.errors.get(part).map_or("", String::as_str)
    }
}

impl SessionForm {
    /// Returns the full path of the results folder; empty if none is given.
    pub fn results(&self) -> PathBuf {
        full(Path::new(self.results.trim()))
    }

    pub fn check(&self, monitor: &Monitor) -> Checked {
        let mut errors = BTreeMap::new();
        let protocol = self.protocol().map_err(|error| errors.insert(EXPERIMENT, error)).ok();
        let screen = CheckedScreen::new(&self.screen, monitor, protocol.as_ref());
        if let Err(error) = Identity::check_session(&self.cell.session) {
            errors.insert(SESSION, capitalized(&error));
        }
        let identity = Identity::new(&self.cell.subject, &self.cell.session).ok();
        let results = self.results();
        if let Some(error) = results_error(&results) {
            errors.insert(RESULTS, error);
        }
        let mut resume = false;
        let free = protocol.as_ref().map(|protocol| free_participant(&results, protocol));
        if let Some(Err(error)) = &free {
            errors.entry(RESULTS).or_insert_with(|| error.to_string());
        }
        // Why none could be suggested is said at another field.
        let is_missing = self.cell.subject.is_empty() && !matches!(free, Some(Ok(_)));
        if let Some(error) = Identity::check_subject(&self.cell.subject).err().filter(|_| !is_missing) {
            errors.insert(PARTICIPANT, capitalized(&error));
        }
        if let (Some(protocol), Some(identity)) = (&protocol, &identity) {
            match SessionStore::is_finished(&results, protocol, identity, None, Changes::Refuse) {
                Ok(true) => {
                    let (subject, session) = (identity.subject(), identity.session());
                    let error = format!(
                        "{subject} has already completed session {session}. Enter another session or participant."
                    );
                    errors.insert(SESSION, error);
                }
                Ok(false) => resume = true,
                Err(StoreError::NothingToResume(_)) => {}
                Err(error) => drop(errors.insert(SESSION, error.to_string())),
            }
            if let Err(error) = Schedule::new(protocol, identity, 1) {
                errors.insert(EXPERIMENT, error.to_string());
            }
        }
        let is_right = errors.is_empty() && screen.is_right();
        let request = match (&protocol, &screen.profile, identity) {
            (Some(protocol), Ok(display), Some(identity)) if is_right => {
                Some(self.request(protocol, identity, display, resume))
            }
            _ => None,
        };
        Checked { protocol, screen, errors, resume, request }
    }

    /// Returns the request for a session with the screen and the results folder of this form.
    pub fn request(&self, protocol: &Protocol, identity: Identity, display: &DisplayProfile, resume: bool) -> Request {
        Request {
            protocol: protocol.clone(),
            identity,
            seed: None,
            results: self.results(),
            display: display.clone(),
            distance_cm: number(&self.screen.distance_cm).unwrap_or(protocol.viewing.distance_cm),
            screen_width_cm: number(&self.screen.screen_width_cm),
            resume,
            changes: Changes::Refuse,
            windowed: false,
        }
    }

    /// Reads the definition.
    pub fn protocol(&self) -> Result<Protocol, String> {
        definition::open(&self.experiment).map_err(|error| error.to_string())
    }
}

/// Returns the reason why results cannot be saved in this folder; `None` if no reason can be found without writing to
/// it.
fn results_error(results: &Path) -> Option<String> {
    if results.as_os_str().is_empty() {
        return Some("Enter the path of a folder.".to_owned());
    }
    let mut folders = results.ancestors().map(|folder| (folder, found(folder)));
    let (existing, metadata) = match folders.find(|(_, found)| !matches!(found, Ok(None)))? {
        (existing, Ok(metadata)) => (existing, metadata?),
        (folder, Err(error)) => return Some(format!("{} cannot be read: {error}.", folder.display())),
    };
    if !metadata.is_dir() {
        return Some(format!("{} is a file. Enter the path of a folder.", existing.display()));
    }
    (!may_write(existing)).then(|| format!("You may not write to {}. Choose another folder.", existing.display()))
}
