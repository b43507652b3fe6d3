//! The session that is to be run, and what the preflight settles about it.

use std::path::PathBuf;

use super::frames::KnownRefresh;
use crate::{
    display::{DisplayProfile, Viewing},
    experiment::{Identity, Protocol},
};

/// A session that is to be run, with everything checked that can be checked before the screen is known.
#[derive(Clone, Debug)]
pub struct Request {
    /// The definition.
    pub protocol: Protocol,
    /// Whose session.
    pub identity: Identity,
    /// Seed of the order; `None` for a fresh one, or on resume the one it had.
    pub seed: Option<u64>,
    /// Results folder.
    pub results: PathBuf,
    /// What is known of the screen.
    pub display: DisplayProfile,
    /// Eye to screen, cm.
    pub distance_cm: f64,
    /// Width of the screen in cm; `None` to assume 96 pixels an inch.
    pub screen_width_cm: Option<f64>,
    /// Resume an interrupted session.
    pub resume: bool,
    /// In a window instead of the full screen.
    pub windowed: bool,
}

/// Side of a stimulus in whole physical pixels, at least one.
pub fn stimulus_side_px(viewing: &Viewing, window_deg: f64) -> u32 {
    viewing.px_from_deg(window_deg).round().clamp(1.0, f64::from(u32::MAX)) as u32
}

/// What the preflight settled.
pub struct Prepared {
    /// Screen and distance.
    pub viewing: Viewing,
    /// Side of the stimulus in physical pixels.
    pub size_px: u32,
    /// Against what frames are judged.
    pub refresh: KnownRefresh,
    /// The window in physical pixels.
    pub window: (u32, u32),
}
