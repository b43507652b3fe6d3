//! What the tools of the Display pages have in common.

use std::path::PathBuf;

use eframe::egui::{Color32, Context, Ui};

use crate::{
    app::ui::{Monitor, Step},
    display::{DisplayProfile, Viewing},
};

/// A page that measures or checks the screen.
pub trait Tool {
    /// Draws the page. `viewing` is the geometry of the screen, if it is known. `Next` leaves the page with the path of a
    /// profile that was written.
    fn show(&mut self, ui: &mut Ui, monitor: &Monitor, viewing: Option<&Viewing>) -> Step<PathBuf>;

    /// Returns the background color while the screen is measured, which then shows nothing else; `None` for a page.
    fn ground(&self) -> Option<Color32> {
        None
    }

    /// Pauses the measurement; that of frames ends.
    fn pause(&mut self, _: &Context) {}

    /// Begins with what is known about the screen.
    fn open(&mut self, _: DisplayProfile) {}
}
