//! What the system says of the screen, in plain sentences.

use jiff::civil::Date;

use crate::{
    app::ui::{Monitor, platform::Platform},
    display::DisplayProfile,
    experiment::{Condition, Protocol},
    store::sidecar::PreflightNote,
};

/// A check by name, whether it is as it should be, and a sentence.
pub type Found = (&'static str, bool, String);

/// For the sidecar.
pub fn note((check, ok, sentence): Found) -> PreflightNote {
    PreflightNote { check: check.to_owned(), ok, sentence }
}

/// Whether codes reach the screen as they are.
pub fn path_to_the_screen(platform: &Platform) -> Vec<Found> {
    let mut found = Vec::new();
    let system = platform.window_system;
    found.push(match platform.composited {
        Some(true) => (
            "compositor",
            false,
            format!("{system} with a compositor: it shows pictures a frame or more later; onsets are late by that."),
        ),
        Some(false) => ("compositor", true, format!("{system} without a compositor.")),
        None => {
            ("compositor", false, format!("Whether a compositor stands before the screen, {system} does not tell."))
        }
    });
    match platform.ramps_straight {
        Some(true) => {
            found.push(("color_ramps", true, "The graphics card passes the codes on as they are.".to_owned()));
        }
        Some(false) => found.push((
            "color_ramps",
            false,
            "The graphics card bends the codes by its gamma ramps: a night light, or a calibration that was loaded. Switch it off, or measure the screen with it.".to_owned(),
        )),
        None => {}
    }
    match (platform.resampled, platform.mode_px, platform.own_px) {
        (Some(true), Some([w, h]), _) => found.push((
            "resolution",
            false,
            format!("The system scales the picture to {w} × {h} pixels: stimuli are not shown pixel for pixel. Set the scale to 100 %."),
        )),
        (_, Some([w, h]), Some([own_w, own_h])) if [w, h] != [own_w, own_h] => found.push((
            "resolution",
            false,
            format!("The screen is driven with {w} × {h} pixels and has {own_w} × {own_h}: it scales the picture itself. Choose its own resolution."),
        )),
        (Some(false), Some([w, h]), _) => {
            found.push(("resolution", true, format!("The screen is driven pixel for pixel, {w} × {h}.")));
        }
        _ => {}
    }
    if platform.hdr == Some(false) {
        found.push(("hdr", true, format!("{system} has no high dynamic range.")));
    }
    match platform.variable_refresh {
        Some(true) => found.push(("variable_refresh", false, "The screen can vary its refresh.".to_owned())),
        Some(false) => found.push(("variable_refresh", true, "The screen's refresh is fixed.".to_owned())),
        None => {}
    }
    found
}

/// Whether the profile is of this screen and still good.
pub fn profile(display: &DisplayProfile, monitor: &Monitor, platform: &Platform, today: Date) -> Vec<Found> {
    let mut found =
        vec![("display_profile", display.measured.is_some(), format!("Display profile: {}.", display.sentence()))];
    if display.measured.is_some()
        && let Some(doubt) = display.doubt(today)
    {
        found.push(("profile_age", false, doubt));
    }
    if let Some([width, height]) = display.native_px {
        let here = platform.own_px.unwrap_or([monitor.width_px, monitor.height_px]);
        let same = here == [width, height];
        found.push((
            "right_monitor",
            same,
            if same {
                format!("The profile's screen has {width} × {height} pixels, and so has this one.")
            } else {
                format!(
                    "The profile is of a screen of {width} × {height} pixels, and this one has {} × {}: is it another?",
                    here[0], here[1]
                )
            },
        ));
    }
    found
}

/// The largest step of any channel's light, in time, between the even field and any picture: what an eye must bear.
pub fn light_steps(protocol: &Protocol, conditions: &[Condition]) -> Found {
    let field = protocol.stimulus.field_light(protocol.recovery.level);
    let largest = conditions
        .iter()
        .flat_map(|condition| condition.stimulus.profile(SAMPLES))
        .flat_map(|light| [0, 1, 2].map(|channel| (light[channel] - field[channel]).abs()))
        .fold(0.0, f32::max);
    let percent = 100.0 * largest;
    (
        "light_steps",
        percent < 95.0,
        format!(
            "Between field and picture no place changes by more than {percent:.0} % of the screen's range{}",
            if percent < 95.0 {
                ", and nothing flickers."
            } else {
                ", as the definition has it: not for people whom sudden light makes ill."
            }
        ),
    )
}

/// Places across a picture at which its light is looked at.
const SAMPLES: u32 = 64;
