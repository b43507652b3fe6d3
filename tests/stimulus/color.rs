//! Color: primaries, CIE spaces and the rearrangements of RGB against other implementations and against themselves; a
//! stimulus' color as text; ramps between two colors.

use super::draw::Draw as _;
use machband::light::color::{
    Chromaticity, Lab, Luv, OutOfGamut, Primaries, PrimariesError, XyY, in_gamut, lab_from_xyz, luv_from_xyz,
    xyy_from_xyz, xyz_from_lab, xyz_from_luv, xyz_from_xyy,
};
use machband::light::color_models::{
    Hls, Hsv, cmy_from_cmyk, cmy_from_rgb, cmyk_from_cmy, hls_from_rgb, hsv_from_rgb, rgb_from_cmy, rgb_from_hls,
    rgb_from_hsv, wrapped_deg,
};
use machband::light::{Bits, Depth, Quantizer, Transfer, Transfers};
use machband::stimulus::RampSpace;
use machband::stimulus::{MachBand, ParameterValue, StimulusColor};
use proptest::prelude::*;

/// Rows of a golden file: the text in the first column, if it is one, and the numbers.
fn golden(file: &str) -> Vec<(String, Vec<f64>)> {
    let path = format!("{}/tests/golden/{file}", env!("CARGO_MANIFEST_DIR"));
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(path).unwrap();
    let rows = reader.records().map(|row| {
        let row = row.unwrap();
        let named = row[0].parse::<f64>().is_err();
        let numbers = row.iter().skip(usize::from(named)).map(|field| field.parse().unwrap()).collect();
        (if named { row[0].to_owned() } else { String::new() }, numbers)
    });
    rows.collect()
}

fn three(row: &[f64], at: usize) -> [f64; 3] {
    row[at..at + 3].try_into().unwrap()
}

fn assert_near(actual: &[f64], expected: &[f64], within: f64, what: &str) {
    assert_eq!(actual.len(), expected.len());
    for (a, e) in actual.iter().zip(expected) {
        assert!((a - e).abs() <= within, "{what}: {actual:?}, not {expected:?}");
    }
}

/// A hue is an angle: 359.999 is near 0.
fn assert_hue(actual: Option<f64>, expected: f64, saturation: f64, what: &str) {
    match actual {
        None => assert!(saturation == 0.0, "{what}: no hue, not {expected}"),
        Some(hue) => {
            assert!(saturation > 0.0, "{what}: hue {hue} at no saturation");
            assert!((0.0..360.0).contains(&hue), "{what}: hue {hue}");
            let apart = wrapped_deg(hue - expected);
            assert!(apart.min(360.0 - apart) < 1e-10, "{what}: hue {hue}, not {expected}");
        }
    }
}

#[test]
fn hsv_and_hls_agree_with_colorsys() {
    let rows = golden("color_models.csv");
    assert_eq!(rows.len(), 73);
    for (_, row) in rows {
        let rgb = three(&row, 0);
        let what = format!("{rgb:?}");
        let (hsv, hls) = (hsv_from_rgb(rgb), hls_from_rgb(rgb));
        assert_hue(hsv.hue, row[3], row[4], &what);
        assert_near(&[hsv.saturation, hsv.value], &row[4..6], 1e-14, &what);
        assert_hue(hls.hue, row[6], row[8], &what);
        assert_near(&[hls.lightness, hls.saturation], &row[7..9], 1e-13, &what);
    }
}

/// What Shoaff prints, 1 − …/(2 − max + min), would give 0.25/1.75 here.
#[test]
fn the_upper_half_of_hls_is_repaired() {
    let hls = hls_from_rgb([1.0, 0.75, 0.75]);
    assert_eq!(hls, Hls { hue: Some(0.0), lightness: 0.875, saturation: 1.0 });
}

#[test]
fn grays_have_no_hue() {
    for level in [0.0, 0.25, 1.0] {
        assert_eq!(hsv_from_rgb([level; 3]), Hsv { hue: None, saturation: 0.0, value: level });
        assert_eq!(hls_from_rgb([level; 3]), Hls { hue: None, lightness: level, saturation: 0.0 });
    }
    assert_eq!(rgb_from_hsv(Hsv { hue: None, saturation: 0.7, value: 0.5 }), [0.5; 3]);
    assert_eq!(xyy_from_xyz([0.0; 3]), None);
}

/// M of XYZ = M·RGB, by rows.
fn matrix(primaries: &Primaries) -> [[f64; 3]; 3] {
    let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|rgb| primaries.xyz_from_rgb(rgb));
    [0, 1, 2].map(|row| columns.map(|column| column[row]))
}

#[test]
fn matrices_agree_with_colour_science() {
    let rows = golden("color_primaries.csv");
    assert_eq!(rows.len(), 7);
    for (name, row) in rows {
        let at = |i: usize| Chromaticity::new(row[i], row[i + 1]).unwrap();
        let chromaticities = [at(0), at(2), at(4)];
        let primaries = Primaries::from_white(chromaticities, at(6)).unwrap();
        assert_near(matrix(&primaries).as_flattened(), &row[8..17], 1e-14, &name);
        assert_near(&primaries.white_xyz(), &at(6).xyz_at(1.0), 1e-14, &name);
        // The same from the luminances, in cd/m².
        let measured = matrix(&primaries)[1].map(|luminance| 80.0 * luminance);
        let absolute = Primaries::from_luminances(chromaticities, measured).unwrap();
        assert_near(&absolute.white_xyz(), &at(6).xyz_at(80.0), 1e-11, &name);
        let there = absolute.xyz_from_rgb([0.2, 0.3, 0.9]);
        assert_near(&absolute.rgb_from_xyz(there), &[0.2, 0.3, 0.9], 1e-14, &name);
        if name == "sRGB" {
            assert_eq!(primaries, Primaries::SRGB);
        }
    }
}

/// IEC 61966-2-1 prints the matrix with four digits.
#[test]
fn srgb_is_the_standards_matrix() {
    let printed = [0.4124, 0.3576, 0.1805, 0.2126, 0.7152, 0.0722, 0.0193, 0.1192, 0.9505];
    assert_near(matrix(&Primaries::SRGB).as_flattened(), &printed, 5.1e-5, "sRGB");
}

#[test]
fn cie_spaces_agree_with_colour_science() {
    let rows = golden("color_cie.csv");
    assert_eq!(rows.len(), 76);
    let srgb = Primaries::SRGB;
    let white = srgb.white_xyz();
    for (_, row) in rows {
        let (rgb, expected) = (three(&row, 0), three(&row, 3));
        let what = format!("{rgb:?}");
        let xyz = srgb.xyz_from_rgb(rgb);
        assert_near(&xyz, &expected, 1e-14, &what);
        match xyy_from_xyz(xyz) {
            Some(XyY { chromaticity, luminance }) => {
                assert_near(&[chromaticity.x(), chromaticity.y(), luminance], &[row[6], row[7], row[4]], 1e-13, &what);
            }
            None => assert_eq!(rgb, [0.0; 3]),
        }
        let Lab { lightness, a, b } = lab_from_xyz(xyz, white);
        assert_near(&[lightness, a, b], &row[8..11], 1e-11, &what);
        let Luv { lightness, u, v } = luv_from_xyz(xyz, white);
        assert_near(&[lightness, u, v], &[row[8], row[11], row[12]], 1e-11, &what);
    }
}

#[test]
fn degenerate_primaries_are_refused() {
    let at = |x, y| Chromaticity::new(x, y).unwrap();
    for (x, y) in [(0.3, 0.0), (-0.1, 0.5), (0.6, 0.5), (f64::NAN, 0.3), (0.3, f64::NAN), (0.3, f64::INFINITY)] {
        assert!(matches!(Chromaticity::new(x, y), Err(PrimariesError::Chromaticity { .. })), "{x} {y}");
    }
    let [r, g, b] = [at(0.64, 0.33), at(0.30, 0.60), at(0.15, 0.06)];
    let line = [at(0.2, 0.2), at(0.3, 0.3), at(0.4, 0.4)];
    assert_eq!(Primaries::from_white(line, Chromaticity::D65), Err(PrimariesError::Collinear));
    assert_eq!(Primaries::from_luminances(line, [0.2, 0.7, 0.1]), Err(PrimariesError::Collinear));
    assert_eq!(Primaries::from_luminances([r, r, b], [0.2, 0.7, 0.1]), Err(PrimariesError::Collinear));
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = Primaries::from_luminances([r, g, b], [0.2, bad, 0.1]).unwrap_err();
        assert!(matches!(error, PrimariesError::Luminance { channel: "green", .. }), "{error}");
    }
    let error = Primaries::from_white([r, g, b], at(0.7, 0.25)).unwrap_err();
    assert!(error.to_string().starts_with("the white point (0.7, 0.25) needs green at a luminance of -0."), "{error}");
    // On an edge of the triangle one primary is not needed at all.
    assert!(Primaries::from_white([r, g, b], at(0.47, 0.465)).is_err());
}

#[test]
fn out_of_gamut_says_by_how_much() {
    assert_eq!(in_gamut([0.0, 1.0 + 1e-10, 0.5]), Ok([0.0, 1.0, 0.5]));
    let error = in_gamut([-0.25, 1.5, 0.5]).unwrap_err();
    assert_eq!(error, OutOfGamut { rgb: [-0.25, 1.5, 0.5] });
    assert_eq!(error.excess(), [-0.25, 0.5, 0.0]);
    assert_eq!(error.to_string(), "red would be -0.2500, 0.2500 below 0, green would be 1.5000, 0.5000 above 1");
    assert_eq!(in_gamut([0.0, 0.0, 1.0 + 2e-6]).unwrap_err().to_string(), "blue would be 2.0e-6 above 1");
    assert!(in_gamut([f64::NAN, 0.0, 0.0]).unwrap_err().to_string().contains("NaN"));
}

fn unit() -> impl Strategy<Value = f64> {
    prop_oneof![4 => 0.0..=1.0f64, 1 => Just(0.0), 1 => Just(1.0), 1 => Just(0.5), 1 => 0.0..1e-6f64]
}

prop_compose! {
    fn rgb()(r in unit(), g in unit(), b in unit()) -> [f64; 3] { [r, g, b] }
}

prop_compose! {
    fn primaries()(
        x in prop::array::uniform3(0.01..0.9f64), part in prop::array::uniform3(0.02..0.98f64),
        luminances in prop::array::uniform3(0.01..200.0f64),
    ) -> ([Chromaticity; 3], [f64; 3]) {
        ([0, 1, 2].map(|i| Chromaticity::new(x[i], part[i] * (1.0 - x[i])).unwrap()), luminances)
    }
}

fn near(a: [f64; 3], b: [f64; 3], within: f64) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() <= within)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn models_of_rgb_come_back(rgb in rgb()) {
        prop_assert!(near(rgb_from_hsv(hsv_from_rgb(rgb)), rgb, 1e-14));
        prop_assert!(near(rgb_from_hls(hls_from_rgb(rgb)), rgb, 1e-14));
        prop_assert!(near(rgb_from_cmy(cmy_from_rgb(rgb)), rgb, 1e-15));
        let cmyk = cmyk_from_cmy(cmy_from_rgb(rgb));
        prop_assert!(cmyk.cyan.min(cmyk.magenta).min(cmyk.yellow) == 0.0);
        prop_assert!(near(rgb_from_cmy(cmy_from_cmyk(cmyk)), rgb, 1e-15));
        let (hsv, hls) = (hsv_from_rgb(rgb), hls_from_rgb(rgb));
        prop_assert!((0.0..=1.0).contains(&hsv.saturation) && (0.0..=1.0).contains(&hls.saturation));
        prop_assert_eq!(hsv.hue.is_none(), hsv.saturation == 0.0);
        prop_assert_eq!(hls.hue.is_none(), hls.saturation == 0.0);
    }

    #[test]
    fn hsv_and_hls_come_back_from_the_other_side(h in 0.0..360.0f64, s in 0.01..=1.0f64, v in 0.01..=1.0f64) {
        let hsv = hsv_from_rgb(rgb_from_hsv(Hsv { hue: Some(h), saturation: s, value: v }));
        prop_assert!(near([hsv.hue.unwrap(), hsv.saturation, hsv.value], [h, s, v], 1e-9));
        let lightness = v.min(0.99);
        let hls = hls_from_rgb(rgb_from_hls(Hls { hue: Some(h), lightness, saturation: s }));
        prop_assert!(near([hls.hue.unwrap(), hls.lightness, hls.saturation], [h, lightness, s], 1e-9));
        let turned = rgb_from_hsv(Hsv { hue: Some(h - 720.0), saturation: s, value: v });
        let plain = rgb_from_hsv(Hsv { hue: Some(h), saturation: s, value: v });
        prop_assert!(near(turned, plain, 1e-12));
    }

    #[test]
    fn cie_spaces_come_back(rgb in rgb()) {
        let srgb = Primaries::SRGB;
        let (xyz, white) = (srgb.xyz_from_rgb(rgb), srgb.white_xyz());
        prop_assert!(near(srgb.rgb_from_xyz(xyz), rgb, 1e-14));
        prop_assert!(near(xyz_from_lab(lab_from_xyz(xyz, white), white), xyz, 1e-14));
        prop_assert!(near(xyz_from_luv(luv_from_xyz(xyz, white), white), xyz, 1e-12));
        if let Some(xyy) = xyy_from_xyz(xyz) {
            prop_assert!(near(xyz_from_xyy(xyy), xyz, 1e-14));
        }
        let lab = lab_from_xyz(xyz, white);
        prop_assert!((0.0..=100.0 + 1e-12).contains(&lab.lightness));
    }

    #[test]
    fn any_triangle_comes_back((chromaticities, luminances) in primaries(), rgb in rgb()) {
        if let Ok(primaries) = Primaries::from_luminances(chromaticities, luminances) {
            let xyz = primaries.xyz_from_rgb(rgb);
            // Nearly flat triangles lose digits.
            let [r, g, b] = chromaticities;
            let area = ((g.x() - r.x()) * (b.y() - r.y()) - (b.x() - r.x()) * (g.y() - r.y())).abs();
            let spread = luminances.iter().fold(0.0, |most: f64, l| most.max(*l))
                / luminances.iter().fold(f64::INFINITY, |least: f64, l| least.min(*l));
            prop_assert!(near(primaries.rgb_from_xyz(xyz), rgb, 1e-12 * spread / area));
        }
    }
}

// A stimulus' color.

fn color(text: &str) -> StimulusColor {
    text.parse().unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn colors_are_read_in_every_model() {
    for (text, rgb, written) in [
        ("yellow", [1.0, 1.0, 0.0], "yellow"),
        ("gray", [1.0; 3], "gray"),
        ("grey", [1.0; 3], "gray"),
        ("white", [1.0; 3], "gray"),
        ("red", [1.0, 0.0, 0.0], "red"),
        ("green", [0.0, 1.0, 0.0], "green"),
        ("blue", [0.0, 0.0, 1.0], "blue"),
        ("cyan", [0.0, 1.0, 1.0], "cyan"),
        ("magenta", [1.0, 0.0, 1.0], "magenta"),
        (" 1, 0.5 ,0 ", [1.0, 0.5, 0.0], "1,0.5,0"),
        ("-0,1,1", [0.0, 1.0, 1.0], "cyan"),
        ("hsv:60,1,1", [1.0, 1.0, 0.0], "yellow"),
        ("hsv: 30, 1, 1", [1.0, 0.5, 0.0], "1,0.5,0"),
        ("hsv:420,1,0.5", [0.5, 0.5, 0.0], "0.5,0.5,0"),
        ("hsv:-120,1,1", [0.0, 0.0, 1.0], "blue"),
        ("hsv:77,0,1", [1.0; 3], "gray"),
        ("xyY:0.3127,0.3290,1", [1.0; 3], "gray"),
        ("hls:60,0.5,1", [1.0, 1.0, 0.0], "yellow"),
        ("hls:240,0.25,1", [0.0, 0.0, 0.5], "0,0,0.5"),
        ("cmy:0,0.5,1", [1.0, 0.5, 0.0], "1,0.5,0"),
        ("cmyk:0,0.25,0.5,0.25", [0.75, 0.5, 0.25], "0.75,0.5,0.25"),
        ("lab:100,0,0", [1.0; 3], "gray"),
        ("luv:100,0,0", [1.0; 3], "gray"),
    ] {
        assert_eq!(color(text).rgb(), rgb, "{text}");
        assert_eq!(color(text).to_string(), written, "{text}");
    }
    // Shoaff's own formula by hand: 20° is a third of the way from red to yellow.
    assert_near(&color("hsv:20,0.5,0.8").rgb(), &[0.8, 0.8 * (1.0 - 0.5 * (2.0 / 3.0)), 0.4], 1e-15, "hsv");
    // The reference: colour-science's inverse matrix, 0.21263900587151 the luminance of red.
    assert_near(&color("xyY:0.64,0.33,0.106319502935755").rgb(), &[0.5, 0.0, 0.0], 1e-11, "xyY");
}

#[test]
fn colors_are_written_as_they_were_asked_where_that_is_short() {
    for text in ["hsv:20,0.5,0.8", "hsv:210.5,0.35,0.9", "xyY:0.35,0.4,0.5", "xyY:0.3,0.31,0.25", "0.9,0.45,0.1"] {
        assert_eq!(color(text).to_string(), text);
    }
}

#[test]
fn what_is_no_color_says_why() {
    let problem = |text: &str| text.parse::<StimulusColor>().unwrap_err().to_string();
    for text in [
        "pink",
        "Yellow",
        "",
        "1",
        "1,1",
        "1,1,1,1",
        "hsv:1,1",
        "hsv:a,1,1",
        "cmyk:0,0,0",
        "xyz:50,0,0",
        "hsv",
        "1;1;0",
        "xyy:0.3,0.3,1",
    ] {
        assert!(problem(text).starts_with(&format!("color {text:?} is not known; expected yellow, gray")), "{text}");
    }
    for (text, expected) in [
        ("0,0,0", "has no light in it"),
        ("hsv:60,1,0", "has no light in it"),
        ("xyY:0.3,0.3,0", "has no light in it"),
        ("1,1,2", "has B = 2, outside 0…1"),
        ("-0.1,1,1", "has R = -0.1, outside 0…1"),
        ("1,nan,1", "has G = NaN, outside 0…1"),
        ("hsv:60,1.5,1", "has S = 1.5, outside 0…1"),
        ("hsv:60,1,-1", "has V = -1, outside 0…1"),
        ("hsv:inf,1,1", "has H = inf, outside the angles in degrees"),
        ("xyY:0.3,0,1", "has y = 0, outside 0…1−x, 0 excluded"),
        ("xyY:1.3,0.1,1", "has x = 1.3, outside 0…1"),
        ("xyY:0.3,0.3,1.2", "has Y = 1.2, outside 0…1"),
        ("hls:60,1.5,1", "has L = 1.5, outside 0…1"),
        ("cmy:0,0,2", "has Y = 2, outside 0…1"),
        ("cmyk:0.5,0,0,0.75", "has R = -0.25, outside 0…1"),
        ("lab:101,0,0", "has L = 101, outside 0…100"),
        ("luv:50,200,0", "is outside the gamut of sRGB"),
        ("luv:0,0,0", "has no light in it"),
        ("xyY:0.64,0.33,0.5", "is outside the gamut of sRGB: red would be 2.3514, 1.3514 above 1"),
    ] {
        assert!(problem(text).contains(expected), "{text}: {}", problem(text));
    }
    // A saturated green that only a laser makes.
    let green = problem("xyY:0.17,0.797,0.5");
    assert!(
        green.contains("red would be -0.") && green.contains("below 0") && green.contains("blue would be -"),
        "{green}"
    );
    assert_eq!(StimulusColor::new([0.0, 0.0, 1.5]).unwrap_err().problem(), "has B = 1.5, outside 0…1");
}

#[test]
fn a_color_is_written_in_every_model() {
    let expected = [
        "1,0.5,0",
        "hsv:30,1,1",
        "xyY:0.477,0.46,0.57",
        "hls:30,0.5,1",
        "cmy:0,0.5,1",
        "cmyk:0,0.5,1,0",
        "lab:80.192,12.187,82.463",
        "luv:80.192,56.543,82.071",
    ];
    assert_eq!(color("1,0.5,0").in_models(), expected);
    // To the three decimals that are shown, all say the same color; a gray too, which has no hue.
    for named in ["hsv:20,0.5,0.8", "0.2,0.4,0.1", "0.5,0.5,0.5"] {
        for text in color(named).in_models() {
            assert_near(&color(&text).rgb(), &color(named).rgb(), 2e-2, &text);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1500))]

    #[test]
    fn a_color_reads_back_as_itself(
        rgb in prop_oneof![
            rgb(),
            (0u8..=20, 0u8..=20, 0u8..=20).prop_map(|(r, g, b)| [r, g, b].map(|part| f64::from(part) / 20.0)),
        ],
    ) {
        prop_assume!(rgb != [0.0; 3]);
        let color = StimulusColor::new(rgb).unwrap();
        let text = color.to_string();
        prop_assert_eq!(text.parse::<StimulusColor>().unwrap(), color);
        let [r, g, b] = rgb;
        let plain = format!("{r},{g},{b}");
        let named = text.bytes().all(|byte| byte.is_ascii_lowercase());
        prop_assert!(named || text.len() <= plain.len(), "{}", text);
        let json = serde_json::to_string(&color).unwrap();
        prop_assert_eq!(serde_json::from_str::<StimulusColor>(&json).unwrap(), color);
    }

    #[test]
    fn what_hsv_asks_is_written_no_longer_than_it_was(h in 0u16..360, s in 1u8..=20, v in 1u8..=20) {
        let text = format!("hsv:{h},{},{}", f64::from(s) / 20.0, f64::from(v) / 20.0);
        let color = color(&text);
        prop_assert!(color.to_string().len() <= text.len(), "{} {}", text, color);
        prop_assert_eq!(color.to_string().parse::<StimulusColor>().unwrap(), color);
    }
}

// Ramps between two colors.

fn ramp(color_low: [f64; 3], color_high: [f64; 3], low: f64, high: f64, space: RampSpace) -> MachBand {
    MachBand {
        width: 1.0,
        low,
        high,
        color: StimulusColor::new(color_low).unwrap(),
        color_high: Some(StimulusColor::new(color_high).unwrap()),
        space,
        ..MachBand::default()
    }
}

/// Shoaff §2.2.9.
#[test]
fn half_way_from_red_to_green() {
    let at = |space| ramp([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 1.0, 1.0, space).ramp().light_at(0.0);
    assert_eq!(at(RampSpace::Rgb), [0.5, 0.5, 0.0]);
    assert_eq!(at(RampSpace::Hsv), [1.0, 1.0, 0.0]);
}

#[test]
fn ramps_agree_with_other_implementations() {
    let rows = golden("color_ramps.csv");
    assert_eq!(rows.len(), 80);
    for (space, row) in rows {
        let band = ramp(three(&row, 0), three(&row, 3), row[6], row[7], space.parse().unwrap());
        let light = band.ramp().light_at(row[8] - 0.5);
        // The rounding to f32.
        assert_near(&light, &row[9..12], 7e-8, &format!("{space} {row:?}"));
    }
}

/// The hue goes the short way round, up where both are as long; a gray and black have no hue of their own.
#[test]
fn hues_take_the_shorter_arc() {
    let at = |from: &str, to: &str, low: f64, x: f64| {
        let (from, to) = (color(from).rgb(), color(to).rgb());
        ramp(from, to, low, 1.0, RampSpace::Hsv).ramp().light_at(x)
    };
    assert_near(&at("hsv:350,1,1", "hsv:30,1,1", 1.0, 0.0), &color("hsv:10,1,1").rgb(), 1e-6, "over 0");
    assert_near(&at("hsv:30,1,1", "hsv:350,1,1", 1.0, 0.25), &color("hsv:0,1,1").rgb(), 1e-6, "over 0, down");
    assert_near(&at("red", "cyan", 1.0, 0.0), &color("hsv:90,1,1").rgb(), 1e-6, "half a turn");
    assert_near(&at("cyan", "red", 1.0, 0.0), &color("hsv:270,1,1").rgb(), 1e-6, "half a turn");
    assert_near(&at("gray", "blue", 1.0, 0.0), &color("hsv:240,0.5,1").rgb(), 1e-6, "from gray");
    assert_near(&at("blue", "gray", 1.0, 0.0), &color("hsv:240,0.5,1").rgb(), 1e-6, "to gray");
    assert_near(&at("gray", "gray", 0.5, 0.0), &[0.75; 3], 1e-6, "gray");
    // From black: black blue, not black gray.
    assert_near(&at("blue", "red", 0.0, 0.0), &color("hsv:300,1,0.5").rgb(), 1e-6, "from black");
}

fn quantizers() -> [Quantizer; 2] {
    let differing = Transfers::new([Transfer::Gamma(2.0), Transfer::Gamma(0.45), Transfer::Srgb]);
    [Transfer::Srgb.into(), differing].map(|transfers| Quantizer::new(transfers, Bits::Eight))
}

fn space() -> impl Strategy<Value = RampSpace> {
    prop_oneof![Just(RampSpace::Rgb), Just(RampSpace::Hsv), Just(RampSpace::Lab)]
}

fn some_color() -> impl Strategy<Value = StimulusColor> {
    prop_oneof![
        Just(StimulusColor::YELLOW),
        Just(StimulusColor::GRAY),
        Just(color("red")),
        Just(color("cyan")),
        rgb().prop_filter_map("dark", |rgb| StimulusColor::new(rgb).ok()),
    ]
}

prop_compose! {
    fn two_colors()(
        width in prop_oneof![Just(0.0), Just(1.0), 0.0..=1.0f64],
        depth in prop_oneof![Just(Depth::Infinite), (1..=5u32).prop_map(|n| Depth::finite(n).unwrap())],
        orientation_deg in prop_oneof![Just(0.0), Just(90.0), Just(270.0), Just(45.0), 0.0..360.0f64],
        a in unit(), b in unit(), color in some_color(), color_high in prop::option::of(some_color()), space in space(),
    ) -> MachBand {
        let (low, high) = (a.min(b), a.max(b));
        MachBand { width, depth, orientation_deg, low, high, color, color_high, space, ..MachBand::default() }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn every_ramp_is_within_the_gamut_and_ends_at_its_plateaus(band in two_colors(), x in -0.5..=0.5f64) {
        prop_assert_eq!(band.validate(), Ok(()));
        prop_assert!(band.ramp().light_at(x).iter().all(|light| (0.0..=1.0).contains(light)));
        let plateau = |color: StimulusColor, level: f64| color.rgb().map(|weight| weight * level);
        let color_high = band.color_high.unwrap_or(band.color);
        let end = band.width / 2.0 + 1e-9;
        prop_assert_eq!(band.ramp().light_at(-end), plateau(band.color, band.low));
        prop_assert_eq!(band.ramp().light_at(end), plateau(color_high, band.high));
        // Just inside the ramp of finite depth, nothing jumps.
        if band.width > 0.1 && band.depth != Depth::Infinite {
            for end in [-0.5, 0.5] {
                let (out, inside) = (band.ramp().light_at(band.width * end * 1.000_000_1), band.ramp().light_at(band.width * end * 0.999_999_9));
                prop_assert!(out.iter().zip(inside).all(|(a, b)| (a - b).abs() < 1e-4), "{:?} {:?}", out, inside);
            }
        }
    }

    #[test]
    fn codes_are_those_of_the_light(band in two_colors(), size in prop_oneof![8 => 1u32..80, 1 => 256..300u32]) {
        let linear = band.linear(size);
        for quantizer in quantizers() {
            let codes = band.codes(size, &quantizer);
            prop_assert!(codes == quantizer.quantize(&linear));
        }
        if band.orientation_deg == 0.0 {
            for ix in 0..size {
                let x = (2.0 * f64::from(ix) + 1.0 - f64::from(size)) / (2.0 * f64::from(size));
                prop_assert_eq!(linear.pixel(ix, 0), band.ramp().light_at(x).map(|light| light as f32));
            }
        }
    }

    /// One color, straight in RGB or HSV, is what it was before there were two.
    #[test]
    fn one_color_is_as_it_was(mut band in two_colors(), x in -0.5..=0.5f64, named in any::<bool>()) {
        band.color_high = named.then_some(band.color);
        if band.space != RampSpace::Lab {
            let luminance = band.ramp().luminance_at(x);
            prop_assert_eq!(band.ramp().light_at(x), band.color.rgb().map(|weight| weight * luminance));
        }
    }
}

#[test]
fn a_catch_trial_is_uniform_in_every_space() {
    for space in [RampSpace::Rgb, RampSpace::Hsv, RampSpace::Lab] {
        let band = MachBand { low: 0.3, high: 0.3, color: color("hsv:20,0.5,0.8"), space, ..MachBand::default() };
        let image = band.linear(40);
        assert!(image.data.chunks(3).all(|pixel| pixel == &image.data[..3]), "{space}");
    }
}

#[test]
fn colors_and_space_are_parameters() {
    let mut band = MachBand::default();
    let set = |band: &mut MachBand, name: &str, text: &str| band.set(name, &text.parse::<ParameterValue>().unwrap());
    let get = |band: &MachBand, name: &str| band.get(name).unwrap().to_string();
    assert_eq!((get(&band, "color_high"), get(&band, "space")), ("same".to_owned(), "rgb".to_owned()));
    set(&mut band, "color", "hsv:0,1,1").unwrap();
    set(&mut band, "color_high", "hsv:120,1,1").unwrap();
    set(&mut band, "space", "hsv").unwrap();
    assert_eq!(
        (get(&band, "color"), get(&band, "color_high"), get(&band, "space")),
        ("red".into(), "green".into(), "hsv".into())
    );
    let json = serde_json::to_string(&band).unwrap();
    assert!(json.ends_with(r#""color":"red","color_high":"green","space":"hsv"}"#), "{json}");
    assert_eq!(serde_json::from_str::<MachBand>(&json).unwrap(), band);
    let before = band.clone();
    let error = set(&mut band, "color", "xyY:0.17,0.797,0.5").unwrap_err().to_string();
    assert!(error.starts_with("color \"xyY:0.17,0.797,0.5\" is outside the gamut of sRGB: red would be -"), "{error}");
    let error = set(&mut band, "color_high", "pink").unwrap_err().to_string();
    assert!(error.starts_with("color_high \"pink\" is not known; expected same"), "{error}");
    let error = set(&mut band, "space", "hls").unwrap_err().to_string();
    assert_eq!(error, "space \"hls\" is not known; expected rgb, hsv or lab");
    assert_eq!(band, before);
    set(&mut band, "color_high", "same").unwrap();
    assert_eq!(band.color_high, None);
}

/// A definition's hash is made of this: what has no second color is written as it always was.
#[test]
fn defaults_are_written_as_before() {
    let json = serde_json::to_string(&MachBand::default()).unwrap();
    let before =
        r#"{"width":0.4,"depth":1,"tanh_k":5.0,"orientation_deg":0.0,"low":0.25,"high":0.75,"color":"yellow"}"#;
    assert_eq!(json, before);
    assert_eq!(serde_json::from_str::<MachBand>(before).unwrap(), MachBand::default());
    assert!(serde_json::from_str::<MachBand>(r#"{"space":"hls"}"#).is_err());
    assert!(serde_json::from_str::<MachBand>(r#"{"colour_high":"red"}"#).is_err());
}
