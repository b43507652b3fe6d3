//! The Mach-band stimulus: its symmetries, its plateaus, its parameters, and the agreement of its codes with its light.

use super::transfers;
use machband::light::{Bits, Depth, Quantizer, Transfer, Transfers};
use machband::stimulus::{MachBand, ParameterValue, RampSpace, Stimulus, StimulusColor, catalog};
use proptest::prelude::*;

fn quantizers() -> Vec<Quantizer> {
    let alike = transfers().into_iter().map(|transfer| Quantizer::new(&transfer.into(), Bits::Eight));
    let dark_toe = Transfer::gog(2.2, 1.05, -0.05).unwrap();
    // Red and green, whose equal weights make yellow, have different transfer functions.
    let differing = Transfers::new([Transfer::Gamma(2.0), Transfer::Gamma(2.2), Transfer::Srgb]);
    alike.chain([Quantizer::new(&dark_toe.into(), Bits::Eight), Quantizer::new(&differing, Bits::Eight)]).collect()
}

/// Checks that the codes equal the quantized light.
fn assert_codes_are_right(stimulus: &Stimulus, size: u32, quantizer: &Quantizer) {
    let codes = stimulus.codes(size, quantizer);
    let plain = quantizer.quantize(&stimulus.linear(size));
    assert!(codes == plain, "{stimulus:?}, size {size}, {:?}", quantizer.codes([0.5; 3]));
}

fn depth() -> impl Strategy<Value = Depth> {
    prop_oneof![8 => (1u8..=32).prop_map(Depth::Finite), 2 => Just(Depth::Infinite)]
}

fn width() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), Just(1.0), 0.0..=1.0f64, (-30.0..0.0f64).prop_map(f64::exp)]
}

fn steepness() -> impl Strategy<Value = f64> {
    prop_oneof![0.01..100.0f64, (-6.0..0.0f64).prop_map(f64::exp)]
}

fn orientation() -> impl Strategy<Value = f64> {
    prop_oneof![
        -720.0..720.0f64,
        (-16..16i32).prop_map(|eighths| f64::from(eighths) * 45.0),
        (-16..16i32, -20.0..1.0f64).prop_map(|(eighths, off)| f64::from(eighths) * 45.0 + off.exp()),
        (-20..20i32, 1..20i32).prop_map(|(rise, run)| f64::from(rise).atan2(run.into()).to_degrees()),
    ]
}

fn luminances() -> impl Strategy<Value = (f64, f64)> {
    let sorted = |(a, b): (f64, f64)| (a.min(b), a.max(b));
    prop_oneof![
        Just((0.25, 0.75)),
        Just((0.0, 1.0)),
        (0.0..=1.0f64, 0.0..=1.0f64).prop_map(sorted),
        // A few codes apart, one code apart, or none.
        (0.0..=1.0f64, -20.0..-3.0f64).prop_map(|(low, span)| (low, (low + span.exp()).min(1.0))),
        // On the threshold of a code, or a rounding error away from it.
        (1u16..255, 1u16..255, -2..=2i32)
            .prop_map(|(a, b, off)| {
                let quantizer = Quantizer::new(&Transfer::Linear.into(), Bits::Eight);
                let low = f64::from(quantizer.channel(0).threshold(a.min(b)));
                let high = f64::from(quantizer.channel(0).threshold(a.max(b)));
                (low + f64::from(off) * f64::EPSILON, high + f64::from(off) * 1e-9)
            })
            .prop_map(sorted),
    ]
}

fn color() -> impl Strategy<Value = StimulusColor> {
    prop_oneof![
        Just(StimulusColor::YELLOW),
        Just(StimulusColor::GRAY),
        Just("red".parse().unwrap()),
        Just("cyan".parse().unwrap()),
        (0.0..=1.0f64, 0.0..=1.0f64, 0.001..=1.0f64).prop_map(|(r, g, b)| format!("{r},{g},{b}").parse().unwrap()),
        (0.001..=1.0f64).prop_map(|r| format!("0,{r},{r}").parse().unwrap()),
    ]
}

prop_compose! {
    pub fn band()(
        width in width(), depth in depth(), tanh_k in steepness(), orientation_deg in orientation(),
        (low, high) in luminances(), color in color(), color_high in prop::option::of(color()),
        space in prop::sample::select(RampSpace::ALL),
    ) -> MachBand {
        MachBand { width, depth, tanh_k, orientation_deg, low, high, color, color_high, space, rounding: 0.0, nulling: 0.0 }
    }
}

/// Generates a Mach band or any other kind that varies in one direction.
fn line() -> impl Strategy<Value = Stimulus> {
    let other = (1..catalog::all().len(), 0..3usize, orientation()).prop_map(|(entry, variant, degrees)| {
        let mut stimulus = crate::stimuli(catalog::all()[entry].kind)[variant].clone();
        // A mesh has no orientation.
        let _ = stimulus.set("orientation_deg", &degrees.into());
        stimulus
    });
    prop_oneof![5 => band().prop_map(Stimulus::from), 1 => other.prop_filter("a line", Stimulus::is_line)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn codes_match_the_light(
        stimulus in line(),
        size in prop_oneof![1u32..140, Just(255), Just(256)],
        (transfer, gamma) in (0usize..8, 0.1..10.0f64),
    ) {
        prop_assert_eq!(stimulus.validate(), Ok(()));
        let quantizer = match transfer {
            7 => Quantizer::new(&Transfer::gamma(gamma).unwrap().into(), Bits::Eight),
            other => quantizers().swap_remove(other),
        };
        assert_codes_are_right(&stimulus, size, &quantizer);
    }

    #[test]
    fn half_a_turn_is_a_point_mirror(band in band(), size in 1u32..40, millidegrees in -400_000..400_000i32) {
        let orientation_deg = f64::from(millidegrees) / 1000.0;
        let [image, turned] = [0.0, 180.0].map(|more| {
            Stimulus::from(MachBand { orientation_deg: orientation_deg + more, ..band.clone() }).linear(size)
        });
        prop_assert!(turned.data.chunks(3).rev().flatten().eq(&image.data));
    }
}

/// If cosine and sine differed in their last digit, the diagonal of a step would no longer be a line.
#[test]
fn a_step_through_pixel_centers_is_halfway_there() {
    for (eighths, on_line) in [
        (0, (|x, _| x == 20) as fn(u32, u32) -> bool),
        (1, |x, y| x == y),
        (2, |_, y| y == 20),
        (3, |x, y| x + y == 40),
    ] {
        for turns in [-360.0, -180.0, 0.0, 180.0, 360.0, 3600.0] {
            let orientation_deg = f64::from(eighths) * 45.0 + turns;
            let image = Stimulus::from(MachBand { width: 0.0, orientation_deg, ..MachBand::default() }).linear(41);
            for (x, y) in (0..41).flat_map(|y| (0..41).map(move |x| (x, y))) {
                let half_way = image.pixel(x, y)[0] == 0.5;
                assert_eq!(half_way, on_line(x, y), "{orientation_deg}°: ({x}, {y})");
            }
        }
    }
}

/// Lines of either sign are as high as their amplitude; beyond the plateaus, too, in every space.
#[test]
fn the_lines_of_nulling_are_as_high_as_their_amplitude() {
    for space in RampSpace::ALL.iter().copied() {
        for nulling in [-0.5, -0.3, -0.02, 0.05, 0.3] {
            let band = MachBand { nulling, space, color: StimulusColor::GRAY, ..MachBand::default() };
            assert_eq!(band.validate(), Ok(()));
            let ends = [-0.2, 0.2].map(|x| band.ramp().luminance_at(x));
            let expected = [0.25 + 0.5 * nulling, 0.75 - 0.5 * nulling];
            assert!((0..2).all(|i| (ends[i] - expected[i]).abs() < 1e-12), "{nulling}: {ends:?}");
            let [dark, bright] = [-0.2, 0.2].map(|x| band.ramp().light_at(x)[1]);
            let is_beyond = [dark < 0.25, bright > 0.75];
            assert_eq!(is_beyond, [nulling < 0.0; 2], "{space} {nulling}: {dark} {bright}");
        }
    }
}

#[test]
fn every_error_is_reported_in_one_sentence() {
    let band = MachBand { width: 1.5, orientation_deg: f64::NAN, low: 0.8, high: 0.2, ..MachBand::default() };
    let errors: Vec<String> = band.validate().unwrap_err().iter().map(ToString::to_string).collect();
    assert_eq!(
        errors,
        [
            "width 1.5 is outside 0…1; expected the proportion of the window that the ramp fills",
            "orientation_deg NaN is not a finite number; expected an angle in degrees, such as 45",
            "high 0.2 is below low, which is 0.8; expected the relative luminance of the brighter plateau, not below low",
        ]
    );
    let beyond = |nulling: f64| MachBand { nulling, high: 0.9, ..MachBand::default() }.validate();
    let error = "nulling -0.2 draws lines beyond the light 0…1; expected the amplitude of an opposite profile, from -1 to 1, with lines within the range of light";
    assert_eq!((beyond(-0.2).unwrap_err()[0].to_string(), beyond(-0.15)), (error.to_owned(), Ok(())));
    let equal = MachBand { low: 0.5, high: 0.5, ..MachBand::default() };
    assert_eq!((MachBand::default().validate(), equal.validate()), (Ok(()), Ok(())));
}

#[test]
fn parameters_are_set_and_read_by_name() {
    let mut stimulus = Stimulus::default_of("mach-band").unwrap();
    assert_eq!((stimulus.kind(), Stimulus::default_of("nothing")), ("mach-band", None));
    let read = |stimulus: &Stimulus| {
        let parameters = stimulus.parameters().iter();
        parameters.map(|p| format!("{}={}", p.name, stimulus.get(p.name).unwrap())).collect::<Vec<_>>().join(" ")
    };
    let defaults = "width=0.4 depth=1 tanh_k=5 orientation_deg=0 low=0.25 high=0.75 color=yellow color_high=same space=rgb rounding=0 nulling=0";
    assert_eq!(read(&stimulus), defaults);
    // Every suggested level can be set and reads back as it was written.
    for parameter in stimulus.parameters() {
        for level in parameter.levels_hint {
            let value: ParameterValue = level.parse().unwrap();
            stimulus.set(parameter.name, &value).unwrap();
            assert_eq!(stimulus.get(parameter.name).unwrap(), value);
            assert_eq!(value.to_string(), *level);
        }
    }
    assert_eq!(stimulus.get("wdith"), None);
}
