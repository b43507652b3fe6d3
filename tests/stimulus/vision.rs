//! The vision model: what must hold for differences and ramps, with the numbers of another implementation (NumPy and
//! SciPy, the formulas of `docs/models.md`), and its symmetries.

use machband::{
    light::Depth,
    stimulus::{MachBand, Stimulus, ViewingConditions, Visible},
    vision::{ContrastSpectrum, DifferenceMap, Eye, Judge, RampBands},
};

/// Luminance of white without a black, so that contrasts are those of the numbers.
fn viewing(window_deg: f64) -> ViewingConditions {
    ViewingConditions { black_cd_m2: 0.0, ..ViewingConditions::new(window_deg) }
}

/// A ramp of `width` degrees from a quarter to three quarters in a window of 10°.
fn ramp(width: f64, depth: Depth) -> MachBand {
    MachBand { width: width / 10.0, depth, color: "gray".parse().unwrap(), ..MachBand::default() }
}

fn bands_of(ramps: &[MachBand], size: Option<u32>) -> Vec<RampBands> {
    let stimuli: Vec<Stimulus> = ramps.iter().cloned().map(Stimulus::MachBand).collect();
    let found = viewing(10.0).visible(&stimuli.iter().collect::<Vec<_>>(), size).unwrap();
    let bands = |visible| if let Visible::Ramp(bands) = visible { bands } else { panic!("{visible:?}") };
    found.into_iter().map(bands).collect()
}

/// Values with equal ratios between neighbors.
fn scan(from: f64, to: f64, steps: i32) -> Vec<f64> {
    (0..=steps).map(|k| from * (to / from).powf(f64::from(k) / f64::from(steps))).collect()
}

const DEPTHS: [Depth; 5] = [Depth::Finite(1), Depth::Finite(2), Depth::Finite(3), Depth::Finite(4), Depth::Infinite];

/// The bright and the dark band, from the other implementation.
#[test]
fn ramps_have_the_bands_of_another_implementation() {
    let expected = [
        (1, 0.2, [1.124, 1.279]),
        (1, 0.5, [2.662, 3.655]),
        (1, 1.0, [3.261, 5.519]),
        (1, 2.0, [2.700, 5.918]),
        (1, 4.0, [1.743, 4.329]),
        (1, 8.0, [1.018, 2.687]),
        (3, 0.5, [0.437, 0.560]),
        (3, 1.0, [0.612, 0.935]),
        (3, 2.0, [0.649, 1.254]),
        (3, 4.0, [0.394, 1.012]),
        (3, 8.0, [0.183, 0.514]),
    ];
    let ramps: Vec<MachBand> = expected.iter().map(|(n, width, _)| ramp(*width, Depth::Finite(*n))).collect();
    for ((n, width, wanted), found) in expected.iter().zip(bands_of(&ramps, None)) {
        for (found, wanted) in [found.bright, found.dark].iter().zip(wanted) {
            assert!((found / wanted - 1.0).abs() < 0.01, "n = {n}, {width}°: {found}, expected {wanted}");
        }
    }
}

/// A step has no band, the bands weaken with n at every width, each lies at its end of the ramp, and nothing jumps: what
/// a band gains from width to width, which are 3 % apart, changes by less than 6 %. Ramps are as narrow as three pixels.
#[test]
fn bands_change_smoothly_with_the_width_and_weaken_with_depth() {
    let step = &bands_of(&[ramp(0.0, Depth::Finite(1))], None)[0];
    assert!(step.bright <= 0.02 && step.dark <= 0.02, "{step:?}");
    for width in [1.0, 9.999] {
        let uniform = &bands_of(&[MachBand { high: 0.25, ..ramp(width, Depth::Finite(1)) }], None)[0];
        assert_eq!([uniform.bright, uniform.dark], [0.0; 2]);
    }
    let widths = scan(0.03, 8.0, 200);
    let found = DEPTHS.map(|depth| bands_of(&widths.iter().map(|width| ramp(*width, depth)).collect::<Vec<_>>(), None));
    for (i, width) in widths.iter().enumerate() {
        for (lower, higher) in found[..4].windows(2).map(|pair| (&pair[0][i], &pair[1][i])) {
            assert!(higher.bright < lower.bright && higher.dark < lower.dark, "{width}°: {lower:?} {higher:?}");
        }
        for (depth, of) in DEPTHS.iter().zip(&found) {
            let [bright, dark] = of[i].at_deg;
            let is_inside = |at: f64| *width < 0.15 || (0.0 < at && at < 0.75 * width);
            assert!(is_inside(bright) && is_inside(-dark), "{:?}", of[i]);
            if let Some([before, now, after]) = i.checked_sub(1).and_then(|i| of.get(i..i + 3)?.first_chunk()) {
                let jump = |of: fn(&RampBands) -> f64| (of(before) * of(after) / of(now).powi(2)).ln().abs();
                let jump = jump(|bands| bands.bright).max(jump(|bands| bands.dark));
                assert!(jump < 0.06, "n = {depth}, {width}°: {before:?} {now:?} {after:?}");
            }
        }
    }
}

/// Position within a pixel, orientation, and pixels per degree change little; a falling ramp has the bands of a rising
/// one.
#[test]
fn bands_do_not_depend_on_how_a_ramp_is_drawn() {
    let reference = &bands_of(&[ramp(0.8, Depth::Finite(1))], None)[0];
    let sizes = [320, 512, 700, 2048, 5000];
    for size in sizes {
        let found = &bands_of(&[ramp(0.8, Depth::Finite(1))], Some(size))[0];
        assert!((found.bright / reference.bright - 1.0).abs() < 0.03, "{size} px: {found:?} {reference:?}");
        assert!((found.dark / reference.dark - 1.0).abs() < 0.03, "{size} px: {found:?} {reference:?}");
    }
    let turned: Vec<MachBand> =
        (0..=36).map(|k| MachBand { orientation_deg: 5.0 * f64::from(k), ..ramp(0.8, Depth::Finite(1)) }).collect();
    let turned = bands_of(&turned, None);
    for pair in turned.windows(2) {
        assert!((pair[1].bright / pair[0].bright - 1.0).abs() < 0.03, "{pair:?}");
    }
    assert_eq!(turned[0].bright, turned[18].bright);
    assert!((turned[0].bright / reference.bright - 1.0).abs() < 1e-9 && turned[9].bright < turned[0].bright);
    // A ramp that is not at a pixel's border.
    let light = |shift: f64| -> Vec<f64> {
        (0..1000).map(|i| 25.0 + 50.0 * ((f64::from(i) + 0.5 + shift - 500.0) / 64.0 + 0.5).clamp(0.0, 1.0)).collect()
    };
    let judge = Judge::of_lines(1000, 80.0, 0.0, Eye::adapted_to(50.0)).unwrap();
    let shifts = (0..8).map(|k| RampBands::of(&judge, &light(f64::from(k) / 8.0)).unwrap().bright);
    let shifts: Vec<f64> = shifts.collect();
    assert!(shifts.iter().all(|bright| (bright / shifts[0] - 1.0).abs() < 0.03), "{shifts:?}");
    // A falling ramp.
    let (rising, falling) = (light(0.3), light(0.3).into_iter().rev().collect::<Vec<f64>>());
    let [rising, falling] = [rising, falling].map(|light| RampBands::of(&judge, &light).unwrap());
    assert!((falling.bright / rising.bright - 1.0).abs() < 1e-3 && (falling.dark / rising.dark - 1.0).abs() < 1e-3);
    assert!((falling.at_deg[0] + rising.at_deg[0]).abs() < 0.05, "{falling:?} {rising:?}");
}

/// Contrast raises the bands without jumps, and a larger n has weaker ones up to the highest contrast; opposite lines
/// change them without jumps.
#[test]
fn bands_change_smoothly_with_contrast_and_nulling() {
    let contrasts = scan(0.02, 0.96, 100);
    for width in [1.0, 4.0, 9.0] {
        let found = [1, 2, 3].map(|n| {
            let of = |contrast: &f64| MachBand {
                low: 0.5 - 0.5 * contrast,
                high: 0.5 + 0.5 * contrast,
                ..ramp(width, Depth::Finite(n))
            };
            bands_of(&contrasts.iter().map(of).collect::<Vec<_>>(), None)
        });
        for pair in found.iter().flat_map(|of| of.windows(2)) {
            let (bright, dark) = (pair[1].bright / pair[0].bright, pair[1].dark / pair[0].dark);
            assert!((0.97..1.1).contains(&bright) && dark > 0.97, "{width}°: {pair:?}");
        }
        for i in 0..contrasts.len() {
            let [one, two, three] = [0, 1, 2].map(|n| &found[n][i]);
            let is_weaker = |a: &RampBands, b: &RampBands| b.bright < a.bright && b.dark < a.dark;
            assert!(
                is_weaker(one, two) && is_weaker(two, three),
                "{width}°, {}: {one:?} {two:?} {three:?}",
                contrasts[i]
            );
        }
    }
    let opposite: Vec<MachBand> =
        (-500..300).map(|k| MachBand { nulling: 0.001 * f64::from(k), ..ramp(4.0, Depth::Finite(1)) }).collect();
    let found = bands_of(&opposite, None);
    let none = &found[500];
    for pair in found.windows(2) {
        assert!((pair[1].bright - pair[0].bright).abs() < 0.03 * none.bright, "{pair:?}");
        assert!((pair[1].dark - pair[0].dark).abs() < 0.03 * none.dark, "{pair:?}");
    }
    assert!(found[..500].windows(2).all(|pair| pair[1].bright < pair[0].bright), "brighter lines are brighter bands");
}

const SIDE: usize = 181;
const PX_PER_DEG: f64 = 36.2;

/// Two pictures without any symmetry, in cd/m².
fn pictures() -> [Vec<f64>; 2] {
    let wave = |i: usize, k: f64| {
        let (x, y) = ((i % SIDE) as f64, (i / SIDE) as f64);
        40.0 + 12.0 * (0.11 * x * k).sin()
            + 8.0 * (0.07 * y + 0.02 * x).cos()
            + if x > 90.0 && y > 40.0 { 6.0 * k } else { 0.0 }
    };
    [1.0, 1.2].map(|k| (0..SIDE * SIDE).map(|i| wave(i, k)).collect())
}

fn judge() -> Judge {
    Judge::of_pictures([SIDE; 2], PX_PER_DEG, Eye::adapted_to(40.0)).unwrap()
}

fn map(shown: &[f64], reference: &[f64]) -> DifferenceMap {
    judge().difference(shown, reference, None).unwrap().map()
}

#[test]
fn the_map_turns_with_the_pictures_and_equal_pictures_have_no_difference() {
    let [a, b] = pictures();
    let own = map(&a, &b);
    assert!(own.largest() > 1.0);
    assert_eq!(map(&a, &a).largest(), 0.0);
    let turns: [fn(usize, usize) -> usize; 3] =
        [|x, y| y * SIDE + SIDE - 1 - x, |x, y| x * SIDE + y, |x, y| (SIDE - 1 - x) * SIDE + y];
    for turn in turns {
        let turned = |of: &[f64]| -> Vec<f64> { (0..SIDE * SIDE).map(|i| of[turn(i % SIDE, i / SIDE)]).collect() };
        let (found, wanted) = (map(&turned(&a), &turned(&b)), turned(&own.times));
        let worst = found.times.iter().zip(&wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-9 * own.largest(), "{worst}");
    }
    let peaks = own.peaks(10, 15.0);
    assert_eq!(peaks[0].times_threshold, own.largest());
    assert_eq!(own.times[peaks[0].y * SIDE + peaks[0].x], own.largest());
    assert!(peaks.windows(2).all(|pair| pair[0].times_threshold >= pair[1].times_threshold));
    assert_eq!(own.enlarged(), own.times);
}

/// On a uniform field, a difference is detection: nothing masks it.
#[test]
fn a_difference_from_a_uniform_field_is_detection() {
    for frequency in [1.0, 2.0, 4.0, 8.0] {
        for contrast in [1e-6, 1e-3] {
            let gabor = |i: usize| {
                let (x, y) = ((i % SIDE) as f64 / PX_PER_DEG - 2.486, (i / SIDE) as f64 / PX_PER_DEG - 2.486);
                let wave = (std::f64::consts::TAU * frequency * x).sin() * (-(x * x + y * y) / 0.18).exp();
                40.0 * (1.0 + contrast * wave)
            };
            let light: Vec<f64> = (0..SIDE * SIDE).map(gabor).collect();
            let uniform = vec![40.0; SIDE * SIDE];
            let center = judge().difference(&light, &uniform, None).unwrap().center();
            let spectrum = ContrastSpectrum::new(&light, [SIDE; 2], PX_PER_DEG).unwrap();
            let detected = spectrum.detection(&Eye::adapted_to(40.0));
            assert!((center / detected - 1.0).abs() < 1e-6, "{frequency} c/°: {center} {detected}");
        }
    }
}

/// A line, of `light(x)` at `x` degrees from its middle, against another.
fn line(px_per_deg: f64, half_deg: f64, mean: f64, light: impl Fn(f64) -> f64, reference: impl Fn(f64) -> f64) -> f64 {
    let n = (2.0 * half_deg * px_per_deg) as usize;
    let judge = Judge::of_lines(n, px_per_deg, 0.0, Eye::adapted_to(mean)).unwrap();
    let drawn = |of: &dyn Fn(f64) -> f64| -> Vec<f64> {
        (0..n).map(|i| of((i as f64 + 0.5) / px_per_deg - half_deg)).collect()
    };
    judge.difference(&drawn(&light), &drawn(&reference), None).unwrap().map().largest()
}

/// An isolated kink converges to a visibility of its own, in proportion to its slope, against ever wider roundings (of I₁
/// in the slope); the numbers are those of the other implementation.
#[test]
fn a_kink_has_a_visibility_of_its_own() {
    const SLOPE: f64 = 0.001;
    let kink = |reach: f64| {
        // The integral of a slope that rises within the reach.
        let rounded = move |x: f64| {
            let t = ((x / reach + 1.0) / 2.0).max(0.0);
            if t < 1.0 { reach * t * t } else { x }
        };
        let light = |x: f64| 50.0 * (1.0 + SLOPE * x.max(0.0));
        line(48.0, 14.0, 50.0, light, move |x| 50.0 * (1.0 + SLOPE * rounded(x))) / SLOPE
    };
    for (reach, wanted) in [(0.5, 7.10), (1.0, 9.69), (2.0, 11.66), (4.0, 12.99), (8.0, 13.84)] {
        let found = kink(reach);
        assert!((found / wanted - 1.0).abs() < 0.01, "{reach}°: {found}, expected {wanted}");
    }
}

/// The threshold of a step, from the other implementation: the relative difference in luminance of an edge 8° long.
#[test]
fn a_step_needs_more_contrast_in_dim_light() {
    for (low, wanted) in [(1.0, 0.02764), (10.0, 0.01827), (100.0, 0.01280), (1000.0, 0.01082)] {
        const STEP: f64 = 1e-3;
        let times = line(64.0, 8.0, low, |x| if x > 0.0 { low * (1.0 + STEP) } else { low }, |_| low);
        assert!((STEP / times / wanted - 1.0).abs() < 0.02, "{low} cd/m²: {}, expected {wanted}", STEP / times);
    }
}
