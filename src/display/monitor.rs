//! A monitor, as the window system describes it.

use serde::{Deserialize, Serialize};

/// What is known about a monitor.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Monitor {
    /// The system's name for the monitor.
    pub name: Option<String>,
    /// Width in physical pixels.
    pub width_px: u32,
    /// Height in physical pixels.
    pub height_px: u32,
    /// Refresh rate in hertz, if the system reports it.
    pub refresh_hz: Option<f64>,
    /// Physical pixels per logical point of the system.
    pub scale: f64,
}

impl Monitor {
    /// Returns the name and size, for a list to choose from.
    pub fn title(&self) -> String {
        let size = format!("{} × {} pixels", self.width_px, self.height_px);
        match &self.name {
            Some(name) => format!("{name}, {size}"),
            None => size,
        }
    }

    /// Says what [`Monitor::assumed_width_cm`] assumes.
    pub fn assumption(&self) -> String {
        let per_inch = self.assumed_per_inch();
        let scaled =
            if self.scale == 1.0 { String::new() } else { format!(", from the system's scale of {}", self.scale) };
        format!("Assumed ({per_inch} pixels per inch{scaled}); measure it before an actual study")
    }

    /// Returns the pixels per inch that systems assume for unknown screens.
    pub fn assumed_per_inch(&self) -> f64 {
        (96.0 * self.scale).round()
    }

    /// Returns the width in cm with as many pixels per inch.
    pub fn assumed_width_cm(&self) -> f64 {
        f64::from(self.width_px) / self.scale.max(0.1) / 96.0 * 2.54
    }
}
