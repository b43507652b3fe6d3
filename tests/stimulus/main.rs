//! Tests of light, screen, eye and stimulus: the numbers behind every picture.

#[path = "../common/mod.rs"]
mod common;

mod calibrate;
mod dither;
mod images;
mod light;
mod ramp;
mod timing;
mod vision;

use machband::{
    light::{Transfer, TransferTable},
    stimulus::Stimulus,
};

/// Returns transfer functions of several kinds, with exponents below and above 1.
fn transfers() -> Vec<Transfer> {
    let table = TransferTable::new(vec![0.0, 0.1, 0.35, 0.8, 1.0], vec![0.0, 0.004, 0.11, 0.55, 1.0]).unwrap();
    [Transfer::Linear, Transfer::Srgb, Transfer::Gamma(2.2), Transfer::Gamma(0.45), Transfer::Table(table)].into()
}

/// Returns the stimulus of a kind with its defaults, and two with other parameters.
fn stimuli(kind: &str) -> [Stimulus; 3] {
    let variants: [&[(&str, &str)]; 2] = match kind {
        "mach-band" => [
            &[("width", "0.1"), ("depth", "3"), ("orientation_deg", "33")],
            &[("width", "0.8"), ("depth", "inf"), ("color", "gray"), ("orientation_deg", "90")],
        ],
        "chevreul" => [
            &[("steps", "9"), ("orientation_deg", "30")],
            &[("steps", "3"), ("color", "yellow"), ("orientation_deg", "90")],
        ],
        "cornsweet" => {
            [&[("exponent", "2.75"), ("orientation_deg", "45")], &[("width", "0.4"), ("low", "0.3"), ("high", "0.7")]]
        }
        "vasarely" => {
            [&[("squares", "24"), ("orientation_deg", "20")], &[("squares", "6"), ("low", "0.9"), ("high", "0.9")]]
        }
        "kanizsa" => [
            &[("side", "0.4"), ("radius", "0.1"), ("orientation_deg", "30")],
            &[("radius", "0.25"), ("color", "yellow")],
        ],
        "shaded-mesh" => [
            &[("shader", "patch"), ("color", "yellow")],
            &[("shader", "fixed"), ("mesh", "torus"), ("vertices", "200"), ("boundary", "0.33")],
        ],
        "shaded-cylinder" => {
            [&[("shading", "flat"), ("orientation_deg", "15")], &[("shading", "phong"), ("facets", "12")]]
        }
        _ => unreachable!("{kind} has no variants"),
    };
    let variant = |settings: &[(&str, &str)]| {
        let mut stimulus = Stimulus::default_of(kind).unwrap();
        settings.iter().for_each(|(name, text)| stimulus.set(name, &text.parse().unwrap()).unwrap());
        stimulus
    };
    [variant(&[]), variant(variants[0]), variant(variants[1])]
}
