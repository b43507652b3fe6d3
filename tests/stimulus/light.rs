//! Interpolation, transfer functions, the conversion of light to codes, and color, compared with other implementations and
//! with their defining properties: CIE spaces, the transformations of RGB, a stimulus's color as text, and ramps between
//! two colors.

use machband::light::color::*;
use machband::light::quantize::reference_code;
use machband::light::{Bits, Depth, Quantizer, TANH_K, Transfer};
use machband::stimulus::{MachBand, RampSpace, StimulusColor};
use proptest::prelude::*;

use super::{common::golden, ramp::band, transfers};

fn depths() -> impl Iterator<Item = u8> {
    1..=Depth::MAX_FINITE
}

#[test]
fn interpolation_agrees_with_other_implementations() {
    let golden = golden("interpolation.csv");
    assert_eq!(golden.len(), 112);
    for (depth, row) in golden {
        // The depth is either a number or inf, which Rust also parses as a number.
        let (depth, u, expected) = match row[..] {
            [n, u, expected] if n.is_finite() => (Depth::Finite(n as u8), u, expected),
            [.., u, expected] => (Depth::Infinite, u, expected),
            _ => panic!("{depth} {row:?}"),
        };
        let value = depth.interpolation(u, TANH_K);
        // The lower half has no cancellation, so its relative error is small, no matter how small the value is.
        let within = if u <= 0.5 { 1e-12 * expected } else { 1e-12 };
        assert!((value - expected).abs() <= within, "n={depth} u={u}: {value}, not {expected}");
    }
}

/// At the ends, n − 1 derivatives vanish and the n-th does not: I_n(h) behaves like hⁿ with the coefficient C(2n−1, n).
#[test]
fn derivatives_vanish_up_to_the_depth_and_then_jump() {
    for n in depths() {
        let i = |u: f64| Depth::Finite(n).interpolation(u, TANH_K);
        let h = 1e-6;
        let order = (i(2.0 * h) / i(h)).log2();
        assert!((order - f64::from(n)).abs() < 1e-4, "n={n}: the foot has order {order}");
        let leading: f64 = (1..=i32::from(n)).map(|k| f64::from(i32::from(n) - 1 + k) / f64::from(k)).product();
        let jump = i(h) / h.powi(n.into());
        assert!((jump / leading - 1.0).abs() < 1e-4, "n={n}: the n-th derivative jumps by {jump}·n!, not {leading}·n!");
        // The shoulder mirrors the foot. 1 − I is representable only to 1e-16, so h is as large as the order requires.
        let h = 10f64.powf(-8.0 / f64::from(n)).min(0.01);
        let shoulder = 1.0 - i(1.0 - h);
        assert!((shoulder - i(h)).abs() < 2e-16, "n={n}");
        assert_eq!((i(-1e-300), i(0.0), i(1.0), i(7.0)), (0.0, 0.0, 1.0, 1.0));
    }
}

proptest! {
    #[test]
    fn interpolation_never_falls(n in 1u8..=32, k in 0.01..100.0f64, a in -0.1..1.1f64, step in 1e-12..0.1f64) {
        for depth in [Depth::Finite(n), Depth::Infinite] {
            prop_assert!(depth.interpolation(a + step, k) >= depth.interpolation(a, k));
        }
    }
}

#[test]
fn transfer_functions_have_their_published_values() {
    // Computed from the formulas of the standards in mpmath 1.3.0 with 40 digits.
    let srgb = Transfer::Srgb;
    assert!((srgb.linear_from_encoded(0.5) - 0.214_041_140_482_232_55).abs() < 1e-15);
    assert!((srgb.linear_from_encoded(0.04) - 0.04 / 12.92).abs() < 1e-17);
    assert!((Transfer::Gamma(2.2).encoded_from_linear(0.25) - 0.532_520_544_719_981_3).abs() < 1e-15);
    for transfer in transfers() {
        assert_eq!((transfer.linear_from_encoded(0.0), transfer.linear_from_encoded(1.0)), (0.0, 1.0));
        assert_eq!((transfer.encoded_from_linear(-3.0), transfer.encoded_from_linear(9.0)), (0.0, 1.0));
        assert!(transfer.encoded_from_linear(f64::NAN).is_nan());
    }
}

#[test]
fn transfer_functions_are_inverses_and_rise() {
    for transfer in transfers() {
        let (mut last_linear, mut last_encoded) = (-1.0, -1.0);
        for i in 0..=65_536 {
            let at = f64::from(i) / 65_536.0;
            let linear = transfer.linear_from_encoded(at);
            assert!((transfer.encoded_from_linear(linear) - at).abs() < 1e-14, "{transfer} {at}");
            let encoded = transfer.encoded_from_linear(at);
            assert!((transfer.linear_from_encoded(encoded) - at).abs() < 1e-14, "{transfer} {at}");
            assert!(linear > last_linear && encoded > last_encoded, "{transfer} {at}");
            (last_linear, last_encoded) = (linear, encoded);
        }
    }
    // With the constants in the standard, the two parts of the curve do not quite meet. Across the gap, the encoded
    // value stays constant.
    let knee: f64 = 0.04045 / 12.92;
    let across = [knee.next_down(), knee, knee.next_up(), knee + 1e-9, knee + 2e-9, knee + 1e-8];
    let encoded = across.map(|linear| Transfer::Srgb.encoded_from_linear(linear));
    assert!(encoded.is_sorted(), "{encoded:?}");
}

#[test]
fn transfers_are_read_and_errors_are_explained() {
    for text in ["srgb", "linear", "gamma:2.2", "gamma:1"] {
        assert_eq!(text.parse::<Transfer>().unwrap().to_string(), text);
    }
    for (texts, expected) in [
        ("rec709|srgb:|linear:1", "expected srgb, linear, gamma:G such as gamma:2.2, or gog:"),
        ("gamma:0|gamma:-1|gamma:nan|gamma:inf|gamma:|gamma:11|gamma:2,2", "outside 0.1…10"),
        ("gog:2.2|gog:2.2,1|gog:2.2,1,0,0|gog:a,b,c|gog:2.2,1,-2", "expected"),
    ] {
        for text in texts.split('|') {
            let message = text.parse::<Transfer>().unwrap_err().to_string();
            assert!(message.contains(expected), "{text}: {message}");
        }
    }
}

#[test]
fn gain_offset_and_gamma_are_inverse_and_reach_both_ends() {
    for (gamma, gain, offset) in [(2.2, 1.0, 0.0), (2.4, 1.1, -0.1), (1.8, 0.9, 0.1), (2.2, 0.5, -0.02)] {
        let transfer = Transfer::gog(gamma, gain, offset).unwrap();
        assert_eq!(transfer.to_string().parse::<Transfer>().unwrap(), transfer);
        assert_eq!([0.0, 1.0].map(|v| transfer.linear_from_encoded(v)), [0.0, 1.0]);
        assert_eq!([0.0, 1.0].map(|l| transfer.encoded_from_linear(l)), [0.0, 1.0]);
        // By hand: (g·V + o)^γ minus its value at 0, divided by its range.
        let raw = |v: f64| (gain * v + offset).max(0.0).powf(gamma);
        let mut last = (0.0, 0.0);
        for i in 1..1000 {
            let v = f64::from(i) / 1000.0;
            let linear = transfer.linear_from_encoded(v);
            assert!((linear - (raw(v) - raw(0.0)) / (raw(1.0) - raw(0.0))).abs() < 1e-12);
            let encoded = transfer.encoded_from_linear(linear);
            assert!(linear >= last.0 && encoded >= last.1, "{transfer} {v}");
            assert!(linear == 0.0 && encoded == 0.0 || (encoded - v).abs() < 1e-9, "{transfer} {v}: {encoded}");
            last = (linear, encoded);
        }
    }
    // Without an offset, it is a plain gamma, regardless of the gain.
    let plain = Transfer::gog(2.2, 0.7, 0.0).unwrap();
    assert!((plain.linear_from_encoded(0.3) - Transfer::Gamma(2.2).linear_from_encoded(0.3)).abs() < 1e-15);
    for (gamma, gain, offset) in [(0.0, 1.0, 0.0), (2.2, 0.0, 0.0), (2.2, 0.1, -0.2), (2.2, f64::NAN, 0.0)] {
        assert!(Transfer::gog(gamma, gain, offset).is_err(), "{gamma} {gain} {offset}");
    }
}

/// Compares the quantizer with the formula that defines it, on both sides of every threshold and over the whole range.
#[test]
fn the_quantizer_matches_the_formula() {
    for transfer in transfers().into_iter().chain([Transfer::Gamma(10.0), Transfer::Gamma(0.1)]) {
        for (bits, around, stride) in [(Bits::Eight, 300u32, 4_001), (Bits::Sixteen, 2, 40_009)] {
            let quantizer = Quantizer::new(&transfer.clone().into(), bits);
            let agree = |v: f32| {
                let plain = reference_code(&transfer, bits, v);
                assert_eq!(quantizer.channel(0).code(v), plain, "{transfer} {bits} bits, {v:e} = {:#x}", v.to_bits());
            };
            for code in 1..=bits.max_code() {
                // Below γ = 0.2 and above 5, neighboring codes may share one f32 value.
                let light = quantizer.channel(0).linear(code) as f32;
                let is_extreme = matches!(transfer, Transfer::Gamma(gamma) if !(0.2..5.0).contains(&gamma));
                assert!(is_extreme || quantizer.channel(0).code(light) == code, "{transfer} {bits} bits, {code}");
                let threshold = quantizer.channel(0).threshold(code);
                assert!(threshold >= quantizer.channel(0).threshold(code - 1));
                assert!(reference_code(&transfer, bits, threshold) >= code);
                assert!(reference_code(&transfer, bits, threshold.next_down()) < code);
                let at = threshold.to_bits();
                (at.saturating_sub(around)..=at + around).for_each(|at| agree(f32::from_bits(at)));
            }
            (0..1.5f32.to_bits()).step_by(stride).for_each(|at| agree(f32::from_bits(at)));
            for v in [-1.0, -0.0, 0.0, 1.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
                agree(v);
            }
            assert_eq!((quantizer.channel(0).code(f32::NAN), quantizer.channel(0).threshold(0)), (0, 0.0));
        }
    }
}

/// Compares with sizes and angles computed by hand: a 10° window at 50 cm on a screen with 1920 pixels over 53.1 cm.
#[test]
fn size_angle_and_distance_determine_each_other() {
    use machband::display::geometry::{Screen, Viewing, width_cm_from_card};
    let viewing = Viewing::new(Screen::new(1920, 1080, 53.1).unwrap(), 50.0).unwrap();
    let px = viewing.px_from_deg(10.0);
    assert!((viewing.cm_from_deg(10.0) - 8.748_866_352_592_4).abs() < 1e-12);
    assert!((px - 8.748_866_352_592_4 * 1920.0 / 53.1).abs() < 1e-9);
    assert!((viewing.deg_from_px(px) - 10.0).abs() < 1e-12);
    assert!((viewing.px_from_deg(0.001) / 0.001 / viewing.px_per_degree() - 1.0).abs() < 1e-9);
    assert!(Viewing::new(viewing.screen(), f64::NAN).is_err());
    let message = Screen::new(1920, 1080, 0.0).unwrap_err().to_string();
    assert_eq!(message, "screen width 0 is outside 5…500 cm; expected the width of the lit part of the screen");
    assert!((width_cm_from_card(428.0, 1920).unwrap() - 38.4).abs() < 1e-12);
    assert!(width_cm_from_card(0.0, 1920).is_err());
}

// Color.

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
