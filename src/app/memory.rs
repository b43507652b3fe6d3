//! The remembered settings while the window is open: read at the start, applied to the window, and written after a
//! change.

use std::path::{Path, PathBuf};

use eframe::egui::{Context, ThemePreference};

use crate::{
    app::ui::{complain, full},
    report::terminal::message,
    store::settings::{Settings, SettingsFile, ThemeChoice},
};

/// The settings and their file.
#[derive(Default)]
pub struct Memory {
    pub settings: Settings,
    /// `None` if nothing is remembered.
    file: Option<SettingsFile>,
    /// Why the settings are not remembered, if a file was requested.
    pub problem: Option<String>,
    /// The settings that were written last, or were tried to be.
    last: Option<Settings>,
    /// The zoom of the last frame.
    zoom: Option<f32>,
}

impl Memory {
    /// Reads the settings. A file that cannot be read is reported and left as it is.
    pub fn open(ctx: &Context, path: Option<PathBuf>) -> Self {
        match path.map(|path| SettingsFile::open(&path)) {
            None => Self::default(),
            Some(Ok((file, settings))) => Self { settings, file: Some(file), ..Self::default() },
            Some(Err(errors)) => {
                errors.0.iter().for_each(|error| message("warning", &format!("{error}; ignored")));
                let problem = format!(
                    "{errors}\nThe default settings are used, and changes are not remembered until you correct or \
                        remove this file."
                );
                complain(ctx, &problem);
                Self { problem: Some(problem), ..Self::default() }
            }
        }
    }

    /// Applies the theme and the zoom to the window; the zoom may also have been changed with its keys. Sessions are
    /// dark in every theme.
    pub fn apply(&mut self, ctx: &Context, is_session: bool) {
        if !ctx.text_edit_focused() {
            // A relative path would lead elsewhere when the program starts in another folder.
            for path in [&mut self.settings.results, &mut self.settings.screen.profile] {
                *path = full(Path::new(path.trim())).display().to_string();
            }
        }
        let theme = match self.settings.theme {
            _ if is_session => ThemePreference::Dark,
            ThemeChoice::System => ThemePreference::System,
            ThemeChoice::Light => ThemePreference::Light,
            ThemeChoice::Dark => ThemePreference::Dark,
        };
        if ctx.options(|options| options.theme_preference) != theme {
            ctx.set_theme(theme);
        }
        match self.zoom {
            Some(zoom) if zoom == self.settings.zoom => self.settings.zoom = ctx.zoom_factor(),
            _ => ctx.set_zoom_factor(self.settings.zoom),
        }
        self.zoom = Some(self.settings.zoom);
    }

    /// Writes the settings if they have changed, except while a value is being typed. Settings that cannot be saved are
    /// tried again with the next change, and when the window closes.
    pub fn save(&mut self, ctx: &Context) {
        if ctx.text_edit_focused() || self.last.as_ref() == Some(&self.settings) {
            return;
        }
        self.last = Some(self.settings.clone());
        if let Some(problem) = self.save_now() {
            complain(ctx, problem);
        }
    }

    /// Writes the settings if they have changed; returns why that is not possible.
    pub fn save_now(&mut self) -> Option<&str> {
        let error = self.file.as_mut()?.save(&self.settings).err()?;
        message("warning", &error.to_string());
        self.problem = Some(format!("The settings cannot be saved. {error}"));
        self.problem.as_deref()
    }
}
