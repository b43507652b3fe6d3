//! The requested session, and the values that the preflight determines.

use std::path::PathBuf;

use crate::{
    display::{DisplayProfile, Viewing, frames::KnownRefresh},
    experiment::{Identity, Protocol},
    store::session::Changes,
};

/// Height of the slider with its distance from the lower edge of the window, points.
const SLIDER_ROOM: f32 = 92.0;

/// A requested session. Everything that can be checked without knowing the screen has been checked.
#[derive(Clone, Debug)]
pub struct Request {
    pub protocol: Protocol,
    /// The participant and the session.
    pub identity: Identity,
    /// Seed of the trial order; `None` for a new seed or, when resuming, the recorded one.
    pub seed: Option<u64>,
    /// The results folder.
    pub results: PathBuf,
    /// What is known about the screen.
    pub display: DisplayProfile,
    /// Viewing distance, cm.
    pub distance_cm: f64,
    /// Width of the screen in cm; `None` to assume what the system does.
    pub screen_width_cm: Option<f64>,
    /// Whether to resume an interrupted session.
    pub resume: bool,
    /// True if a session whose files were changed may be resumed.
    pub changes: Changes,
    /// Whether to run in a window instead of full screen.
    pub windowed: bool,
}

/// Returns the side of a stimulus in whole physical pixels, at least one.
pub fn stimulus_side_px(viewing: &Viewing, protocol: &Protocol) -> u32 {
    let planned = viewing.px_from_deg(protocol.viewing.window_deg).round().clamp(1.0, f64::from(u32::MAX)) as u32;
    protocol.stimulus.side().unwrap_or(planned)
}

/// The values determined by the preflight.
pub struct Prepared {
    /// The viewing geometry: screen and distance.
    pub viewing: Viewing,
    /// Side of the stimulus in physical pixels.
    pub size_px: u32,
    /// The refresh against which frames are judged.
    pub refresh: KnownRefresh,
    /// Width and height of the window in physical pixels.
    pub window: (u32, u32),
}

/// Returns the width and height that all stimuli of `side` physical pixels need at the center of the window. A slider is
/// always shown, and it lies below them.
pub fn needed_px(protocol: &Protocol, side: u32, px_per_point: f64) -> [u32; 2] {
    let [wide, high] = protocol.task.layout().size_px(side);
    let strip = if has_slider(protocol) { (2.0 * f64::from(SLIDER_ROOM) * px_per_point).ceil() as u32 } else { 0 };
    [wide, high + strip]
}

/// Returns whether answers are given on a slider.
pub fn has_slider(protocol: &Protocol) -> bool {
    protocol.task.dial().is_some_and(|dial| dial.parameter.is_none())
}
