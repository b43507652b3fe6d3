//! The form that saves a profile.

use std::path::{Path, PathBuf};

use eframe::egui;

use crate::{
    app::ui::{Field, fault, primary, section, today},
    display::{DisplayProfile, Measurement},
    store::profile,
};

/// A profile that was written.
pub struct SavedProfile {
    /// Where it is.
    pub path: PathBuf,
    /// In the place of another.
    pub replaced: bool,
}

/// Name, person, instrument and file of a profile.
pub struct ProfileForm {
    name: String,
    by: String,
    with: String,
    path: String,
    fault: Option<String>,
}

impl ProfileForm {
    /// For a screen of this name, measured `with` something.
    pub fn new(name: &str, known: &DisplayProfile, with: String) -> Self {
        let by = known.measured.clone().and_then(|measured| measured.by).unwrap_or_default();
        let path = format!("calibration/{}.toml", file_name(name));
        Self { name: name.to_owned(), by, with, path, fault: None }
    }

    /// Draws the fields and the button; gives the profile once it is written.
    pub fn show(&mut self, ui: &mut egui::Ui, found: &DisplayProfile) -> Option<SavedProfile> {
        section(ui, "Profile");
        for (label, value) in [
            ("Name of the screen", &mut self.name),
            ("Measured by", &mut self.by),
            ("Measured with", &mut self.with),
            ("Save as", &mut self.path),
        ] {
            Field::new(label).width(340.0).text(ui, value);
        }
        let usable = !self.path.trim().is_empty() && !self.name.trim().is_empty();
        let exists = Path::new(self.path.trim()).exists();
        let text = if exists { "Replace the profile" } else { "Save the profile" };
        let saved = primary(ui, text, usable, "and use it").then(|| self.write(self.filled(found)));
        if let Some(Err(message)) = &saved {
            self.fault = Some(message.clone());
        }
        if let Some(message) = &self.fault {
            fault(ui, message);
        }
        saved?.ok()
    }

    /// What was found, with what is typed about it.
    pub fn filled(&self, found: &DisplayProfile) -> DisplayProfile {
        let some = |text: &str| Some(text.trim().to_owned()).filter(|text| !text.is_empty());
        let measured = Measurement { on: Some(today()), by: some(&self.by), with: some(&self.with) };
        DisplayProfile { name: self.name.trim().to_owned(), measured: Some(measured), ..found.clone() }
    }

    fn write(&self, profile: DisplayProfile) -> Result<SavedProfile, String> {
        let path = PathBuf::from(self.path.trim());
        if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("toml")) {
            return Err(format!("{}: is not the name of a profile; expected one that ends in .toml", path.display()));
        }
        if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
            std::fs::create_dir_all(folder).map_err(|error| {
                format!("{}: cannot be made: {error}; expected a place that can be written", folder.display())
            })?;
        }
        let replaced = path.exists();
        profile::write(&path, &profile).map_err(|error| error.to_string())?;
        Ok(SavedProfile { path, replaced })
    }
}

/// A name as part of a file's name.
pub fn file_name(name: &str) -> String {
    let letter = |c: char| if c.is_alphanumeric() || c == '-' { c } else { '_' };
    let name: String = name.trim().chars().map(letter).collect();
    if name.is_empty() { "screen".to_owned() } else { name }
}
