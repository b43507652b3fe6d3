//! The requested session, and the values that the preflight determines.

use std::path::PathBuf;

use crate::{
    display::{DisplayProfile, Viewing, frames::KnownRefresh},
    experiment::{Identity, Protocol, task::Layout},
    store::{session::Changes, sidecar::Geometry},
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
    /// The screen, the distance, and the sizes of the stimulus and of the window.
    pub geometry: Geometry,
    /// The refresh against which frames are judged.
    pub refresh: KnownRefresh,
}

/// Says how much room all stimuli of `side` physical pixels need at the center of `place`, which is the window or the
/// screen and has `size` pixels. A slider is always shown, and it lies below them.
///
/// # Errors
/// The same sentence, if there is not enough room.
pub fn room(
    protocol: &Protocol,
    side: u32,
    px_per_point: f64,
    place: &str,
    [width, height]: [u32; 2],
) -> Result<String, String> {
    let (deg, layout) = (protocol.viewing.window_deg, protocol.task.layout());
    let [wide, mut high] = layout.size_px(side);
    let stimuli = match layout {
        Layout::Places(count) => format!("The {count} stimuli of {deg}° side by side need"),
        _ if has_slider(protocol) => {
            high += (2.0 * f64::from(SLIDER_ROOM) * px_per_point).ceil() as u32;
            format!("The {deg}° stimulus with its slider needs")
        }
        Layout::Single | Layout::Intervals { .. } => format!("The {deg}° stimulus needs"),
    };
    let sentence = format!("{stimuli} {wide} × {high} pixels, and the {place} has {width} × {height}.");
    if wide <= width && high <= height { Ok(sentence) } else { Err(sentence) }
}

/// Returns whether answers are given on a slider.
pub fn has_slider(protocol: &Protocol) -> bool {
    protocol.task.dial().is_some_and(|dial| dial.parameter.is_none())
}
