//! Color: CIE spaces and the transformations of RGB, compared with other implementations and with their own inverses; a
//! stimulus's color as text; ramps between two colors.

use super::{common::golden, ramp::band};
use machband::light::Depth;
use machband::light::color::*;
use machband::stimulus::{MachBand, RampSpace, StimulusColor};
use proptest::prelude::*;

fn three(row: &[f64], at: usize) -> [f64; 3] {
    row[at..at + 3].try_into().unwrap()
}

fn near(a: &[f64], b: &[f64], within: f64) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= within)
}

fn assert_near(actual: &[f64], expected: &[f64], within: f64, what: &str) {
    assert!(near(actual, expected, within), "{what}: {actual:?}, not {expected:?}");
}

/// The first component is the hue. It is an angle, so 359.999 is near 0.
fn near_by_hue(a: [f64; 3], b: [f64; 3], within: f64) -> bool {
    let apart = wrapped_deg(a[0] - b[0]);
    (0.0..360.0).contains(&a[0]) && apart.min(360.0 - apart) <= 1e4 * within && near(&a[1..], &b[1..], within)
}

#[test]
fn hsv_and_hls_agree_with_colorsys() {
    let rows = golden("color_models.csv");
    assert_eq!(rows.len(), 73);
    for (_, row) in rows {
        let rgb = three(&row, 0);
        let hsv = hsv_from_rgb(rgb);
        assert!(near_by_hue(hsv, three(&row, 3), 1e-14), "{rgb:?}: {hsv:?}");
        assert_near(&rgb_from_hsv(hsv), &rgb, 1e-14, "HSV");
        assert_near(&rgb_from_hls(three(&row, 6)), &rgb, 1e-12, "HLS");
        assert_eq!(hue(rgb).is_none(), hsv[1] == 0.0, "{rgb:?}: a gray has no hue");
    }
    // The formula as printed in Shoaff, 1 − …/(2 − max + min), would give a saturation of 0.25/1.75 here.
    assert_eq!(rgb_from_hls([0.0, 0.875, 1.0]), [1.0, 0.75, 0.75]);
}

/// IEC 61966-2-1 prints the matrix with four digits.
#[test]
fn cie_spaces_agree_with_colour_science_and_the_standard() {
    let printed = [[0.4124, 0.2126, 0.0193], [0.3576, 0.7152, 0.1192], [0.1805, 0.0722, 0.9505]];
    for (rgb, xyz) in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].into_iter().zip(printed) {
        assert_near(&xyz_from_rgb(rgb), &xyz, 5.1e-5, "sRGB");
    }
    let rows = golden("color_cie.csv");
    assert_eq!(rows.len(), 76);
    for (_, row) in rows {
        let rgb = three(&row, 0);
        let what = format!("{rgb:?}");
        let xyz = xyz_from_rgb(rgb);
        assert_near(&xyz, &row[3..6], 1e-14, &what);
        assert_near(&rgb_from_xyz(xyz), &rgb, 1e-14, &what);
        if rgb != [0.0; 3] {
            assert_near(&xyz_from_xyy([row[6], row[7], row[4]]), &xyz, 1e-13, &what);
        }
        assert_near(&lab_from_xyz(xyz), &row[8..11], 1e-11, &what);
        assert_near(&xyz_from_lab(lab_from_xyz(xyz)), &xyz, 1e-14, &what);
        assert_near(&xyz_from_luv([row[8], row[11], row[12]]), &xyz, 1e-13, &what);
    }
}

// The color of a stimulus.

fn color(text: &str) -> StimulusColor {
    text.parse().unwrap_or_else(|error| panic!("{error}"))
}

fn color_of([r, g, b]: [f64; 3]) -> StimulusColor {
    color(&format!("{r},{g},{b}"))
}

#[test]
fn colors_are_read_in_every_model() {
    for (text, rgb, written) in [
        ("yellow", [1.0, 1.0, 0.0], "yellow"),
        ("white", [1.0; 3], "gray"),
        ("magenta", [1.0, 0.0, 1.0], "magenta"),
        (" 1, 0.5 ,0 ", [1.0, 0.5, 0.0], "1,0.5,0"),
        ("-0,1,1", [0.0, 1.0, 1.0], "cyan"),
        ("hsv: 30, 1, 1", [1.0, 0.5, 0.0], "1,0.5,0"),
        ("hsv:420,1,0.5", [0.5, 0.5, 0.0], "0.5,0.5,0"),
        ("hsv:-120,1,1", [0.0, 0.0, 1.0], "blue"),
        ("hsv:77,0,1", [1.0; 3], "gray"),
        ("xyY:0.3127,0.3290,1", [1.0; 3], "gray"),
        ("hls:60,0.5,1", [1.0, 1.0, 0.0], "yellow"),
        ("cmy:0,0.5,1", [1.0, 0.5, 0.0], "1,0.5,0"),
        ("cmyk:0,0.25,0.5,0.25", [0.75, 0.5, 0.25], "0.75,0.5,0.25"),
        ("lab:100,0,0", [1.0; 3], "gray"),
        ("luv:100,0,0", [1.0; 3], "gray"),
    ] {
        assert_eq!(color(text).rgb(), rgb, "{text}");
        assert_eq!(color(text).to_string(), written, "{text}");
    }
    // Shoaff's formula, computed by hand: 20° is a third of the way from red to yellow.
    assert_near(&color("hsv:20,0.5,0.8").rgb(), &[0.8, 0.8 * (1.0 - 0.5 * (2.0 / 3.0)), 0.4], 1e-15, "hsv");
    // The reference is the inverse matrix of colour-science; the luminance of red is 0.21263900587151.
    assert_near(&color("xyY:0.64,0.33,0.106319502935755").rgb(), &[0.5, 0.0, 0.0], 1e-11, "xyY");
}

#[test]
fn invalid_texts_are_explained() {
    let problem = |text: &str| text.parse::<StimulusColor>().unwrap_err().to_string();
    let unknown = "pink|Yellow||1|1,1|1,1,1,1|hsv:1,1|hsv:a,1,1|cmyk:0,0,0|xyz:50,0,0|hsv|1;1;0|xyy:0.3,0.3,1";
    for text in unknown.split('|') {
        assert!(problem(text).starts_with(&format!("color {text:?} is not known; expected yellow, gray")), "{text}");
    }
    for (text, expected) in [
        ("0,0,0", "has no light in it"),
        ("xyY:0.3,0,1", "has y = 0, outside 0…1−x, 0 excluded"),
        ("luv:50,200,0", "is outside the gamut of sRGB"),
        ("xyY:0.64,0.33,0.5", "is outside the gamut of sRGB: red would be 2.3514"),
    ] {
        assert!(problem(text).contains(expected), "{text}: {}", problem(text));
    }
}

// Ramps between two colors.

fn ramp(color_low: [f64; 3], color_high: [f64; 3], low: f64, high: f64, space: RampSpace) -> MachBand {
    MachBand {
        width: 1.0,
        low,
        high,
        color: color_of(color_low),
        color_high: Some(color_of(color_high)),
        space,
        ..MachBand::default()
    }
}

#[test]
fn ramps_agree_with_other_implementations() {
    let rows = golden("color_ramps.csv");
    assert_eq!(rows.len(), 80);
    for (space, row) in rows {
        let band = ramp(three(&row, 0), three(&row, 3), row[6], row[7], space.parse().unwrap());
        let light = band.ramp().light_at(row[8] - 0.5);
        // The tolerance covers the rounding to f32.
        assert_near(&light, &row[9..12], 7e-8, &format!("{space} {row:?}"));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn every_ramp_is_within_the_gamut_and_ends_at_its_plateaus(band in band(), x in -0.5..=0.5f64) {
        prop_assert_eq!(band.validate(), Ok(()));
        prop_assert!(band.ramp().light_at(x).iter().all(|light| (0.0..=1.0).contains(light)));
        let plateau = |color: StimulusColor, level: f64| color.rgb().map(|weight| weight * level);
        let color_high = band.color_high.unwrap_or(band.color);
        let end = band.width / 2.0 + 1e-9;
        // Equal plateaus of one color are uniform in every space.
        if color_high == band.color && band.low == band.high {
            prop_assert_eq!(band.ramp().light_at(x), plateau(band.color, band.low));
        }
        prop_assert_eq!(band.ramp().light_at(-end), plateau(band.color, band.low));
        prop_assert_eq!(band.ramp().light_at(end), plateau(color_high, band.high));
        // Just inside a ramp of finite depth, the light does not jump.
        if band.width > 0.1 && band.depth != Depth::Infinite {
            for end in [-0.5, 0.5] {
                let (out, inside) = (band.ramp().light_at(band.width * end * 1.000_000_1), band.ramp().light_at(band.width * end * 0.999_999_9));
                prop_assert!(out.iter().zip(inside).all(|(a, b)| (a - b).abs() < 1e-4), "{:?} {:?}", out, inside);
            }
        }
    }
}
