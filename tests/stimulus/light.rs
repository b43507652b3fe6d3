//! Interpolation, transfer functions and the conversion of light to codes, compared with other implementations and with
//! their defining properties.

use machband::light::quantize::reference_code;
use machband::light::{Bits, Depth, Quantizer, TANH_K, Transfer};
use proptest::prelude::*;

use super::{common::golden, transfers};

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
            [n, u, expected] if n.is_finite() => (Depth::finite(n as u32).unwrap(), u, expected),
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
    use machband::display::geometry::{Screen, Viewing, distance_cm, width_cm_from_card};
    let viewing = Viewing::new(Screen::new(1920, 1080, 53.1).unwrap(), 50.0).unwrap();
    let px = viewing.px_from_deg(10.0);
    assert!((viewing.cm_from_deg(10.0) - 8.748_866_352_592_4).abs() < 1e-12);
    assert!((distance_cm(10.0, 8.748_866_352_592_4) - 50.0).abs() < 1e-12);
    assert!((px - 8.748_866_352_592_4 * 1920.0 / 53.1).abs() < 1e-9);
    assert!((viewing.deg_from_px(px) - 10.0).abs() < 1e-12);
    assert!((viewing.px_from_deg(0.001) / 0.001 / viewing.px_per_degree() - 1.0).abs() < 1e-9);
    assert!(Viewing::new(viewing.screen(), f64::NAN).is_err());
    let message = Screen::new(1920, 1080, 0.0).unwrap_err().to_string();
    assert_eq!(message, "screen width 0 is outside 5…500 cm; expected the width of the lit part of the screen");
    assert!((width_cm_from_card(428.0, 1920).unwrap() - 38.4).abs() < 1e-12);
    assert!(width_cm_from_card(0.0, 1920).is_err());
}
