//! What Home asks, and what is wrong with it, field by field.

use std::path::{Path, PathBuf};

use crate::{
    app::{
        session::{Request, stimulus_side_px},
        ui::{Monitor, ScreenFields, number},
    },
    display::{DisplayProfile, Screen, Viewing},
    experiment::{Identity, Protocol, Schedule},
    store::{dataset::free_participant, definition, session::SessionStore},
};

/// The form's texts as typed.
#[derive(Clone, Debug, PartialEq)]
pub struct Form {
    /// Built-in name or path.
    pub experiment: String,
    /// Identifier.
    pub participant: String,
    /// Identifier.
    pub session: String,
    /// The screen and the distance from it.
    pub screen: ScreenFields,
    /// The experiment without color, for someone with a color deficiency.
    pub gray: bool,
    /// Folder.
    pub results: String,
}

/// What is wrong beside each field.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Faults {
    /// See [`Form`].
    pub experiment: Option<String>,
    /// See [`Form`].
    pub participant: Option<String>,
    /// See [`Form`].
    pub session: Option<String>,
    /// See [`Form`].
    pub distance: Option<String>,
    /// See [`Form`].
    pub screen_width: Option<String>,
    /// See [`Form`].
    pub profile: Option<String>,
    /// See [`Form`].
    pub results: Option<String>,
}

impl Faults {
    fn any(&self) -> bool {
        [
            &self.experiment,
            &self.participant,
            &self.session,
            &self.distance,
            &self.screen_width,
            &self.profile,
            &self.results,
        ]
        .iter()
        .any(|fault| fault.is_some())
    }
}

/// A form looked through.
#[derive(Debug)]
pub struct Checked {
    /// The definition, if it is one.
    pub protocol: Option<Protocol>,
    /// The profile, sRGB if none is named.
    pub display: Option<DisplayProfile>,
    /// What is wrong.
    pub faults: Faults,
    /// This participant and session have an unfinished file: Start means resume.
    pub resume: bool,
    /// Side of the stimulus on this screen in physical pixels, and pixels per degree.
    pub stimulus_px: Option<(u32, f64)>,
    request: Option<Request>,
}

impl Default for Form {
    fn default() -> Self {
        Self {
            experiment: definition::BUILT_IN[0].name.to_owned(),
            participant: String::new(),
            session: "1".to_owned(),
            screen: ScreenFields::default(),
            gray: false,
            results: "results".to_owned(),
        }
    }
}

impl Form {
    /// Fills in what follows from the definition and is still empty.
    pub fn suggest(&mut self, monitor: &Monitor) {
        if self.screen.screen_width_cm.is_empty() {
            self.screen.screen_width_cm = format!("{:.1}", monitor.assumed_width_cm());
        }
        let Ok(protocol) = self.protocol() else { return };
        if self.screen.distance_cm.is_empty() {
            self.screen.distance_cm = protocol.viewing.distance_cm.to_string();
        }
        if self.participant.is_empty() {
            self.participant = free_participant(Path::new(&self.results), &protocol);
        }
    }

    /// Looks every field through.
    pub fn check(&self, monitor: &Monitor) -> Checked {
        let mut faults = Faults::default();
        let protocol = self.protocol().map_err(|error| faults.experiment = Some(error)).ok();
        let display = self.screen.profile().map_err(|error| faults.profile = Some(error)).ok();
        faults.participant = Identity::check_subject(&self.participant).err().map(|error| error.to_string());
        faults.session = Identity::check_session(&self.session).err().map(|error| error.to_string());
        let identity = Identity::new(&self.participant, &self.session).ok();
        let results = PathBuf::from(self.results.trim());
        faults.results = results_fault(&results);
        let mut resume = false;
        if let (Some(protocol), Some(identity)) = (&protocol, &identity) {
            match SessionStore::exists(&results, protocol, identity) {
                Some(true) => {
                    faults.session = Some(format!(
                        "{} has finished session {}; expected another session or participant",
                        identity.subject(),
                        identity.session()
                    ));
                }
                unfinished => resume = unfinished.is_some(),
            }
            if let Err(error) = Schedule::new(protocol, identity, 1) {
                faults.experiment = Some(error.to_string());
            }
        }
        let stimulus_px = self.geometry(monitor, protocol.as_ref(), &mut faults);
        let request = match (&protocol, &display, identity) {
            (Some(protocol), Some(display), Some(identity)) if !faults.any() => Some(Request {
                protocol: protocol.clone(),
                identity,
                seed: None,
                results,
                display: display.clone(),
                distance_cm: number(&self.screen.distance_cm).unwrap_or(protocol.viewing.distance_cm),
                screen_width_cm: number(&self.screen.screen_width_cm)
                    .filter(|_| !self.screen.width_is_assumed(monitor)),
                resume,
                windowed: false,
            }),
            _ => None,
        };
        Checked { protocol, display, faults, resume, stimulus_px, request }
    }

    /// The definition, in gray where that is wished and it has a colour.
    fn protocol(&self) -> Result<Protocol, String> {
        let protocol = definition::open(&self.experiment).map_err(|error| error.to_string())?;
        Ok(match protocol.in_gray() {
            Some(gray) if self.gray => gray,
            _ => protocol,
        })
    }

    fn geometry(&self, monitor: &Monitor, protocol: Option<&Protocol>, faults: &mut Faults) -> Option<(u32, f64)> {
        let cm = |text: &str, what: &str| number(text).ok_or(format!("{text:?} is no number; expected {what} in cm"));
        let width = cm(&self.screen.screen_width_cm, "the width of the visible screen")
            .and_then(|cm| Screen::new(monitor.width_px, monitor.height_px, cm).map_err(|error| error.to_string()))
            .map_err(|fault| faults.screen_width = Some(fault));
        let distance = cm(&self.screen.distance_cm, "the distance from eye to screen")
            .map_err(|fault| faults.distance = Some(fault));
        let viewing = Viewing::new(width.ok()?, distance.ok()?)
            .map_err(|error| faults.distance = Some(error.to_string()))
            .ok()?;
        let side = stimulus_side_px(&viewing, protocol?.viewing.window_deg);
        let least = monitor.width_px.min(monitor.height_px);
        if side > least {
            faults.distance = Some(format!(
                "the stimulus of {}° would need {side} pixels of {least}; expected a shorter distance or a larger screen",
                protocol?.viewing.window_deg
            ));
        }
        Some((side, viewing.px_per_degree()))
    }
}

impl Checked {
    /// The session to run, where nothing is wrong.
    pub fn request(&self) -> Option<&Request> {
        self.request.as_ref()
    }
}

/// Why results cannot go there, as far as it can be told without writing.
fn results_fault(results: &Path) -> Option<String> {
    if results.as_os_str().is_empty() {
        return Some("the folder is empty; expected a path".to_owned());
    }
    let existing = results.ancestors().find(|folder| folder.exists());
    let metadata = existing.and_then(|folder| folder.metadata().ok());
    match metadata {
        Some(metadata) if !metadata.is_dir() => {
            Some(format!("{} is a file; expected a folder", existing.unwrap_or(results).display()))
        }
        Some(metadata) if metadata.permissions().readonly() => Some(format!(
            "{} is read-only; expected a folder that can be written",
            existing.unwrap_or(results).display()
        )),
        _ => None,
    }
}
