//! The remembered settings while the window is open: read at the start, applied to the window, and written after a
//! change.

use std::path::PathBuf;

use eframe::egui::{Context, ThemePreference};

use crate::{
    app::ui::complain,
    report::terminal::message,
    store::settings::{Settings, SettingsFile, ThemeChoice},
};

/// Changes are written once there have been no more of them for this time, seconds.
const SETTLED_S: f64 = 1.0;

/// The settings and their file.
#[derive(Default)]
pub struct Memory {
    pub settings: Settings,
    /// `None` if nothing is remembered.
    file: Option<SettingsFile>,
    /// Why the settings are not remembered, if a file was requested.
    pub problem: Option<String>,
    /// The settings in the last frame, and when they last changed.
    last: Option<(Settings, f64)>,
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
        let theme = match self.settings.theme {
            _ if is_session => ThemePreference::Dark,
            ThemeChoice::System => ThemePreference::System,
            ThemeChoice::Light => ThemePreference::Light,
            ThemeChoice::Dark => ThemePreference::Dark,
        };
        if ctx.options(|options| options.theme_preference) != theme {
            ctx.set_theme(theme);
        }
        match &self.last {
            Some((last, _)) if last.zoom == self.settings.zoom => self.settings.zoom = ctx.zoom_factor(),
            _ => ctx.set_zoom_factor(self.settings.zoom),
        }
    }

    /// Writes the settings if they have changed and then stayed the same for a while.
    pub fn save(&mut self, ctx: &Context) {
        let now = ctx.input(|input| input.time);
        let changed_s = match &self.last {
            Some((last, changed_s)) if *last == self.settings => *changed_s,
            _ => {
                ctx.request_repaint_after_secs(SETTLED_S as f32);
                self.last = Some((self.settings.clone(), now));
                now
            }
        };
        if now - changed_s >= SETTLED_S {
            if let Some(problem) = self.save_now() {
                complain(ctx, problem);
            }
            // Settings that cannot be saved are tried again with the next change, and when the window closes.
            self.last = Some((self.settings.clone(), f64::INFINITY));
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
