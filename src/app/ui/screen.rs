//! The monitor that shows the window, and what the user types about the screen.

use std::path::Path;

use eframe::egui;

use super::fields::number;
use crate::{
    display::{DisplayProfile, Monitor, Screen, Viewing},
    store::{profile, settings::ScreenFields},
};

impl Monitor {
    /// Returns the monitor that shows the window now; without a window, as in tests, a monitor of the size of the page.
    pub fn current(ctx: &egui::Context, frame: &eframe::Frame) -> Self {
        let Some(monitor) = frame.winit_window().and_then(|window| window.current_monitor()) else {
            let (width_px, height_px) = window_px(ctx);
            return Self {
                name: None,
                width_px,
                height_px,
                refresh_hz: None,
                scale: f64::from(ctx.pixels_per_point()),
            };
        };
        Self {
            name: monitor.name(),
            width_px: monitor.size().width,
            height_px: monitor.size().height,
            refresh_hz: monitor.refresh_rate_millihertz().map(|mhz| f64::from(mhz) / 1000.0),
            scale: monitor.scale_factor(),
        }
    }
}

/// Returns the width and height of the window's content in physical pixels.
pub fn window_px(ctx: &egui::Context) -> (u32, u32) {
    let size = ctx.content_rect().size() * ctx.pixels_per_point();
    (size.x.round() as u32, size.y.round() as u32)
}

impl ScreenFields {
    /// Reads the display profile; sRGB if no path is given.
    ///
    /// # Errors
    /// The errors in the file, one per line.
    pub fn profile(&self) -> Result<DisplayProfile, String> {
        match self.profile.trim() {
            "" => Ok(DisplayProfile::default()),
            path => profile::open(Path::new(path)).map_err(|error| error.to_string()),
        }
    }

    /// Returns the geometry of this screen.
    ///
    /// # Errors
    /// A length is impossible, or is not a number.
    pub fn viewing(&self, monitor: &Monitor) -> Result<Viewing, String> {
        let width_cm = self.width_cm(monitor).unwrap_or(f64::NAN);
        let screen = Screen::new(monitor.width_px, monitor.height_px, width_cm)?;
        Viewing::new(screen, number(&self.distance_cm).unwrap_or(f64::NAN))
    }

    /// Returns whether the screen's width is assumed rather than measured or typed.
    pub fn width_is_assumed(&self) -> bool {
        self.screen_width_cm.trim().is_empty()
    }

    /// Returns the screen's width; `None` if what was typed is not a number.
    pub fn width_cm(&self, monitor: &Monitor) -> Option<f64> {
        if self.width_is_assumed() { Some(monitor.assumed_width_cm()) } else { number(&self.screen_width_cm) }
    }
}
