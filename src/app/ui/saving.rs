//! The path of a file, the button that writes it, and its question before it replaces one.

use std::path::{Path, PathBuf};

use eframe::egui::{Button, Context, Response, Ui, Vec2};

use super::{fields::Field, status::say, text, theme::ink};
use crate::store::{StoreError, Writer};

/// Returns the ending of a path, which chooses the format of the file.
///
/// # Errors
/// If the ending is not among `known`, all in lowercase.
fn ending(path: &Path, known: &[&'static str]) -> Result<&'static str, StoreError> {
    let is_ending = |ending: &&&str| path.extension().is_some_and(|typed| typed.eq_ignore_ascii_case(**ending));
    known.iter().find(is_ending).copied().ok_or_else(|| StoreError::Protected {
        path: path.to_owned(),
        what: format!("end the name in .{}, which chooses the format", known.join(" or .")),
    })
}

/// Returns the message after a file was written, with its full path.
pub fn saved(path: &Path) -> String {
    format!("Saved to {}", full(path).display())
}

/// Returns the full path, by which the file is found again from any folder.
pub fn full(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}

/// Opens a file or folder with the desktop's own program; returns the error, if any.
pub fn open(path: &Path) -> Option<String> {
    let error = open::that_detached(path).err()?;
    Some(format!("{} cannot be opened: {error}", full(path).display()))
}

/// The path of a file to write, the outcome of the last click on its button, and whether another click replaces the file.
#[derive(Clone, Default)]
pub struct Saving {
    /// The path as typed.
    pub typed: String,
    outcome: Option<Result<String, String>>,
    /// The path that already exists. Another click replaces it.
    asked: Option<PathBuf>,
}

impl Saving {
    /// Begins with this path.
    pub fn to(path: impl Into<String>) -> Self {
        Self { typed: path.into(), ..Self::default() }
    }

    pub fn path(&self) -> PathBuf {
        self.typed.trim().into()
    }

    /// Forgets the outcome, because another file would be written now.
    pub fn forget(&mut self) {
        (self.outcome, self.asked) = (None, None);
    }

    /// Draws the field for the path.
    pub fn field(&mut self, ui: &mut Ui, field: Field<'_>) -> Response {
        let field = field.text(ui, &mut self.typed);
        if field.changed() {
            self.forget();
        }
        field
    }

    /// Draws the button; when it is clicked, returns the writer to use. `inputs` are files that are never replaced.
    pub fn button(&mut self, ui: &mut Ui, caption: &str, enabled: bool, inputs: &[PathBuf]) -> Option<Writer> {
        let replaces = self.asked.as_ref() == Some(&self.path());
        // It keeps its place when its text changes.
        let button = Button::new(if replaces { "Replace" } else { caption }).min_size(Vec2::new(84.0, 0.0));
        let clicked = ui.add_enabled(enabled, button).clicked();
        clicked.then(|| {
            self.forget();
            Writer::new(inputs.to_vec(), replaces)
        })
    }

    /// Draws the button that writes a file, whose ending must be among `known`. `write` gets its path and its ending.
    pub fn export(
        &mut self,
        ui: &mut Ui,
        caption: &str,
        known: &[&'static str],
        write: impl FnOnce(&Writer, &Path, &str) -> Result<(), StoreError>,
    ) {
        let Some(writer) = self.button(ui, caption, true, &[]) else { return };
        let path = self.path();
        let written = ending(&path, known).and_then(|ending| write(&writer, &path, ending));
        self.finish(&path, written.map(|()| saved(&path)));
    }

    /// Stores the outcome: what was done, or why not.
    pub fn finish(&mut self, path: &Path, outcome: Result<String, StoreError>) {
        self.asked = matches!(outcome, Err(StoreError::Occupied(_))).then(|| path.to_owned());
        self.outcome = Some(outcome.map_err(|error| match error {
            StoreError::Occupied(file) if file == path => {
                "This file already exists. Replace it, or type another name.".to_owned()
            }
            StoreError::Occupied(file) => {
                let file = file.file_name().unwrap_or_default().display();
                format!("The folder has files from before, such as {file}. Replace them, or type another name.")
            }
            error => error.to_string(),
        }));
    }

    /// Tells the outcome: an error here, where it has room before there is one, anything else in the status line.
    pub fn show(&mut self, ui: &mut Ui) {
        let error = self.told(ui.ctx()).unwrap_or_default();
        text::two_lines(ui, error, ink(ui).bad, 2);
    }

    /// Tells in the status line what was done; returns the error, if there is one instead.
    pub fn told(&mut self, ctx: &Context) -> Option<&str> {
        if let Some(done) = self.outcome.take_if(|outcome| outcome.is_ok()).and_then(Result::ok) {
            say(ctx, done);
        }
        self.outcome.as_ref()?.as_ref().err().map(String::as_str)
    }
}
