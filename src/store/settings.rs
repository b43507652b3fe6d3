//! What the window remembers from one start to the next: one TOML file in the platform's folder for configuration.
//! It never holds data about participants.

use std::{
    io::Error,
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize};

use super::{
    FileErrors, StoreError,
    error::io,
    file::{ABANDONED, exists, folder_of, make_folder, read_text, remove_temporary, write_file},
    toml,
};

/// Maximum number of remembered experiments, and of remembered analyses.
const MAX_RECENT: usize = 8;

/// The theme of the window. Sessions are dark in every theme.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ThemeChoice {
    /// The system's theme; dark if the system does not say.
    #[default]
    System,
    Light,
    Dark,
}

/// The remembered settings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    pub theme: ThemeChoice,
    /// Factor by which text and controls are enlarged, 0.2…5.
    pub zoom: f32,
    /// Whether sessions fill the screen.
    pub full_screen: bool,
    /// The results folder.
    pub results: String,
    /// The study chosen last: its name if it is built in, or the path of its definition; empty for the first one.
    pub study: String,
    pub screen: ScreenFields,
    pub recent: Recent,
}

/// The screen, as typed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ScreenFields {
    /// Name and size of the monitor. The width is remembered only for the same monitor.
    pub monitor: String,
    /// Width of the visible screen, cm; empty to assume what the system does.
    pub screen_width_cm: String,
    /// Viewing distance, cm; empty to use the distance that a definition plans.
    pub distance_cm: String,
    /// Path of the display profile; empty for sRGB.
    pub profile: String,
}

/// Files that were used recently, the latest first.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Recent {
    /// Paths of definitions.
    pub experiments: Vec<String>,
    /// Paths of analyzed files and folders.
    pub analyses: Vec<String>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            theme: ThemeChoice::default(),
            zoom: 1.0,
            full_screen: true,
            results: "results".to_owned(),
            study: String::new(),
            screen: ScreenFields::default(),
            recent: Recent::default(),
        }
    }
}

/// Puts an entry at the front of a list of recent files.
pub fn remember(recent: &mut Vec<String>, entry: &str) {
    if recent.first().is_none_or(|first| first != entry) {
        recent.retain(|other| other != entry);
        recent.insert(0, entry.to_owned());
        recent.truncate(MAX_RECENT);
    }
}

/// The file with the settings.
#[derive(Clone, Debug)]
pub struct SettingsFile {
    path: PathBuf,
    /// What is in the file.
    written: Settings,
}

impl SettingsFile {
    /// Reads the settings. A file that does not exist yet has the default settings.
    ///
    /// # Errors
    /// The file cannot be read, or is not a file of settings; it must then not be written, because that would destroy
    /// what its owner wrote.
    pub fn open(path: &Path) -> Result<(Self, Settings), FileErrors> {
        let is_there = exists(path).map_err(|error| FileErrors(error.errors(path)))?;
        let settings =
            if is_there { parse(&path.display().to_string(), &read_text(path)?)? } else { Settings::default() };
        Ok((Self { path: path.to_owned(), written: settings.clone() }, settings))
    }

    /// Writes the settings if they differ from the file's.
    ///
    /// # Errors
    /// I/O errors.
    pub fn save(&mut self, settings: &Settings) -> Result<(), StoreError> {
        if self.written == *settings {
            return Ok(());
        }
        make_folder(folder_of(&self.path))?;
        let text = ::toml::to_string(settings).map_err(|error| io(&self.path, "encode")(Error::other(error)))?;
        write_file(&self.path, format!("{HEADER}{text}").as_bytes())?;
        remove_temporary(folder_of(&self.path), |name| self.path.file_name().is_some_and(|own| own == name), ABANDONED);
        self.written = settings.clone();
        Ok(())
    }
}

const HEADER: &str =
    "# What machband's window remembers. machband rewrites this file; remove it to start over.\nschema = 1\n";

fn parse(file: &str, text: &str) -> Result<Settings, FileErrors> {
    let (settings, mut document) = toml::read::<Settings>(file, text)?;
    document.check_range("zoom", &[settings.zoom.into()], 0.2..=5.0);
    document.finish(settings)
}
