//! What the preflight finds about the screen, the window and the stimulus, as plain sentences, and the questions that
//! it asks.

use std::collections::BTreeSet;

use super::request::{Prepared, Request, room, stimulus_side_px};
use crate::{
    app::ui::{Monitor, platform::Platform, today},
    display::{
        DisplayProfile, Screen, Viewing,
        frames::{FrameTimes, Refresh},
    },
    experiment::Protocol,
    store::{
        check::missing_fonts,
        profile,
        sidecar::{Geometry, PreflightNote, Sitting},
    },
};

/// Number of positions across an image at which its light is compared with the light of the field.
const SAMPLES: u32 = 64;

/// Compares the display profile and the size of the stimulus with those of the previous sitting; `None` if that is not
/// known.
fn same_as_before(before: &Sitting, display: &DisplayProfile, now_px: u32) -> Option<PreflightNote> {
    let (used, size_px) = (before.display.as_ref()?, before.viewing.as_ref()?.stimulus_px);
    let same = used.sha256 == profile::hash(display) && size_px == now_px;
    let other = format!(
        "The previous sitting used the display profile {} and a stimulus of {size_px} pixels. Go back and restore them, \
            unless you intend to change them.",
        used.profile["name"]
    );
    let alike = "The display profile and the stimulus size are the same as in the previous sitting.";
    Some(either("same_as_before", same, [alike, &other]))
}

fn note(check: &str, ok: bool, sentence: impl Into<String>) -> PreflightNote {
    PreflightNote { check: check.to_owned(), ok, sentence: sentence.into() }
}

/// Returns a note with the sentence for a passed or for a failed check.
fn either(check: &str, ok: bool, [passed, failed]: [&str; 2]) -> PreflightNote {
    note(check, ok, if ok { passed } else { failed })
}

/// Returns all findings except the steps of light, which do not change, and the values that the session needs, or why it
/// cannot run. `before` is the previous sitting, if there was one. `scale` is in physical pixels per point.
pub fn all(
    request: &Request,
    before: Option<&Sitting>,
    monitor: &Monitor,
    platform: &Platform,
    frames: &FrameTimes,
    window: (u32, u32),
    scale: f64,
) -> (Vec<PreflightNote>, Result<Prepared, String>) {
    let name = monitor.name.as_ref().map_or_else(|| "(no name)".to_owned(), |name| format!("{name:?}"));
    let [width, height] = [monitor.width_px, monitor.height_px];
    let told_scale = format!("The system's scale is {scale}. Stimuli are still drawn in physical pixels.");
    let reported = monitor.refresh_hz;
    let refresh = match reported {
        Some(hz) => format!("The system reports {hz:.3} Hz."),
        None => "The system does not report a refresh rate. The measured frame interval is used instead.".to_owned(),
    };
    let frame_interval = frame_interval(frames);
    let steady = if frame_interval.ok { frames.intervals_us() } else { &[] };
    let refresh_found = Refresh::known(reported, steady);
    let mut notes = vec![
        note("monitor", true, format!("Monitor {name}, {width} × {height} pixels.")),
        full_screen(request.windowed, window, window == (width, height)),
        note("scale", true, told_scale),
        note("refresh", reported.is_some(), refresh),
        frame_interval,
    ];
    notes.extend(path_to_the_screen(platform));
    notes.extend(display_profile(&request.display, monitor, platform));
    let geometry = geometry(request, monitor, window, scale, &mut notes);
    let prepared = geometry.map(|geometry| Prepared { geometry, refresh: refresh_found });
    if let (Some(before), Ok(now)) = (before, &prepared) {
        notes.extend(same_as_before(before, &request.display, now.geometry.stimulus_px));
    }
    (notes, prepared)
}

fn full_screen(windowed: bool, (width, height): (u32, u32), whole: bool) -> PreflightNote {
    let sentence = match (windowed, whole) {
        (true, _) => format!(
            "The session runs in a window of {width} × {height} pixels, as requested. Other things on the screen may be distracting."
        ),
        (false, true) => "The window fills the whole screen.".to_owned(),
        (false, false) => {
            format!("The window has {width} × {height} pixels; the window system did not make it full screen.")
        }
    };
    note("full_screen", whole || windowed, sentence)
}

fn frame_interval(frames: &FrameTimes) -> PreflightNote {
    let (Some(median), Some(slow)) = (frames.quantile(0.5), frames.quantile(0.99)) else {
        return note("frame_interval", false, "No frames could be measured.");
    };
    let steady = slow <= 1.5 * median;
    let sentence = format!(
        "The median frame interval is {:.1} ms ({:.1} Hz); 99 % are at most {:.1} ms.{}",
        median * 1e3,
        1.0 / median,
        slow * 1e3,
        if steady { "" } else { " The intervals are not steady: close other programs." }
    );
    note("frame_interval", steady, sentence)
}

/// Checks whether codes reach the screen unchanged.
fn path_to_the_screen(platform: &Platform) -> Vec<PreflightNote> {
    let system = platform.window_system;
    let (ok, composited) = match platform.composited {
        Some(true) => (false, "uses a compositor: images appear one or more frames late, delaying all onsets equally."),
        Some(false) => (true, "uses no compositor."),
        None => (false, "does not report whether it uses a compositor."),
    };
    let mut notes = vec![note("compositor", ok, format!("{system} {composited}"))];
    let ramps = [
        "The graphics card does not change the codes.",
        "The graphics card's gamma ramps change the codes, because of a night light or a loaded calibration. Switch it \
            off, or measure the screen while it is on.",
    ];
    notes.extend(platform.ramps_straight.map(|straight| either("color_ramps", straight, ramps)));
    let resolution = match (platform.resampled, platform.mode_px, platform.own_px) {
        (Some(true), Some([w, h]), _) => Some((
            false,
            format!(
                "The system scales the image to {w} × {h} pixels, so stimuli are not shown pixel for pixel. Set the \
                    scale to 100 %."
            ),
        )),
        (_, Some([w, h]), Some([own_w, own_h])) if [w, h] != [own_w, own_h] => Some((
            false,
            format!(
                "The screen receives {w} × {h} pixels, but its native resolution is {own_w} × {own_h}, so it scales \
                    the image. Select the native resolution."
            ),
        )),
        (Some(false), Some([w, h]), _) => Some((true, format!("Images are shown pixel for pixel, {w} × {h}."))),
        _ => None,
    };
    notes.extend(resolution.map(|(ok, sentence)| note("resolution", ok, sentence)));
    notes
}

/// Checks whether the profile is for this screen and still valid.
fn display_profile(display: &DisplayProfile, monitor: &Monitor, platform: &Platform) -> Vec<PreflightNote> {
    let is_measured = display.measured.is_some();
    let mut notes = vec![note("display_profile", is_measured, format!("Display profile: {}.", display.sentence()))];
    notes.extend(display.warning(today()).map(|warning| note("profile_age", false, warning)));
    if let Some([width, height]) = display.native_px {
        let here = platform.own_px.unwrap_or([monitor.width_px, monitor.height_px]);
        let same = format!("The profile is for a screen of {width} × {height} pixels, the same as this one.");
        let other = format!(
            "The profile is for a screen of {width} × {height} pixels; this one has {} × {}. Is this a different screen?",
            here[0], here[1]
        );
        notes.push(either("right_monitor", here == [width, height], [&same, &other]));
    }
    notes
}

/// Returns the viewing geometry, or why the stimulus cannot be shown.
fn geometry(
    request: &Request,
    monitor: &Monitor,
    window: (u32, u32),
    px_per_point: f64,
    notes: &mut Vec<PreflightNote>,
) -> Result<Geometry, String> {
    let known_cm = request.screen_width_cm.or(request.display.screen_width_cm);
    let width_cm = known_cm.unwrap_or_else(|| monitor.assumed_width_cm());
    let viewing = Screen::new(monitor.width_px, monitor.height_px, width_cm)
        .and_then(|screen| Viewing::new(screen, request.distance_cm));
    let viewing = match viewing {
        Ok(viewing) => viewing,
        Err(error) => {
            let sentence = format!("{error}.");
            notes.push(note("geometry", false, &sentence));
            return Err(sentence);
        }
    };
    let origin = match known_cm {
        Some(cm) => format!("The screen is {cm:.1} cm wide."),
        None => format!("The screen's width is unknown; {width_cm:.1} cm is assumed. Measure it before a study."),
    };
    let (distance, per_degree) = (request.distance_cm, viewing.px_per_degree());
    let sentence = format!("{origin} At {distance} cm, one degree is {per_degree:.1} pixels.");
    notes.push(note("physical_size", known_cm.is_some(), sentence));
    let deg = request.protocol.viewing.window_deg;
    let size_px = stimulus_side_px(&viewing, &request.protocol);
    notes.extend(viewing.coarseness(deg).map(|sentence| note("coarse", false, sentence)));
    let room = room(&request.protocol, size_px, px_per_point, "window", window.into());
    let room = room.map_err(|error| error + " Sit closer, or use a larger screen.");
    notes.push(note("stimulus_fits", room.is_ok(), room.as_ref().unwrap_or_else(|error| error)));
    room.map(|_| Geometry {
        distance_cm: distance,
        screen_width_cm: width_cm,
        screen_width_measured: known_cm.is_some(),
        pixels_per_degree: per_degree,
        stimulus_px: size_px,
        stimulus_deg: viewing.deg_from_px(f64::from(size_px)),
        window_px: window.into(),
        windowed: request.windowed,
    })
}

/// Reports the characters of the participant's texts that no font has; `None` if every character has one. They would be
/// shown as boxes.
pub fn fonts(missing: &BTreeSet<char>) -> Option<PreflightNote> {
    let sentence = missing_fonts(missing)?;
    Some(note("fonts", false, format!("{sentence} Install a font for them, and start again.")))
}

/// Reports the largest change over time in the light of any channel, between the uniform field and any stimulus.
/// Participants must tolerate it.
pub fn light_steps(protocol: &Protocol) -> PreflightNote {
    let field = protocol.stimulus.field_light(protocol.recovery.level);
    let lights = protocol.conditions().iter().flat_map(|condition| condition.stimulus.profile(SAMPLES));
    let steps = lights.flat_map(|light| [0, 1, 2].map(|channel| (light[channel] - field[channel]).abs()));
    let percent = 100.0 * steps.fold(0.0, f32::max);
    let range = format!(
        "Between the uniform field and the stimulus, no pixel changes by more than {percent:.0} % of the screen's range."
    );
    let gentle = format!("{range} Nothing flickers.");
    let sudden = format!(
        "{range} The definition requires this; it is not suitable for people who cannot tolerate sudden changes in light."
    );
    either("light_steps", percent < 95.0, [&gentle, &sudden])
}

/// A question that no system can answer and the person at the screen must: its name, a statement to confirm by looking at
/// the screen or its menu, and whether it was confirmed. None of them blocks a session.
pub type Question = (&'static str, &'static str, bool);

/// Returns the questions about this screen.
pub fn questions(display: &DisplayProfile) -> Vec<Question> {
    let measured = (
        "right_monitor_asked",
        "This is the screen on which the profile was measured, with the same brightness, contrast, and color settings.",
        false,
    );
    let always = [
        (
            "monitor_settings_asked",
            "What changes images or their timing is off in the screen's menu: high dynamic range (HDR), variable refresh \
                (FreeSync, G-Sync), dynamic contrast, local dimming, automatic brightness, eye comfort.",
            false,
        ),
        (
            "luminance_limit_asked",
            "The screen does not dim large bright areas, as OLED screens do: a white window has the same luminance \
                at every size.",
            false,
        ),
        (
            "other_programs_asked",
            "Nothing else on this computer changes or covers the screen: no night light, color correction, video, \
                notification or screen sharing.",
            false,
        ),
    ];
    display.measured.is_some().then_some(measured).into_iter().chain(always).collect()
}

/// Returns the answer to a question, for the sidecar.
pub fn answer((check, statement, confirmed): &Question) -> PreflightNote {
    let answer = if *confirmed { "Confirmed at the screen" } else { "Not confirmed" };
    note(check, *confirmed, format!("{answer}: {statement}"))
}
