//! Tests the published models of Mach bands: ODOG against another implementation, and known properties of each model.
//!
//! Checks that the blue-noise mask matches its generator, follows the void-and-cluster method, and has a blue-noise
//! spectrum.
//!
//! Checks that the ordinal models recover known effects.

use std::{f64::consts::TAU, fs, path::Path};

use machband::{
    analysis::Random,
    light::dither::{MASK_SIZE, mask},
    vision::Sensitivity,
};
use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng, SeedableRng},
};
use tools::{
    baselines::{Baseline, Beyond, LateralInhibition, Mark, Odog, SecondDerivativeRatio, all},
    blue_noise::{MASK_SEED, void_and_cluster},
    coverage::{coverage, recover},
    python,
    thresholds::{CSF, NAMES, People, unit},
};

/// Samples per degree of the profiles in these tests.
const PX_PER_DEG: f64 = 120.0;

/// A profile of `length_deg` degrees; `value` gives the light for each position in degrees from the middle.
fn profile(length_deg: f64, value: impl Fn(f64) -> f64) -> Vec<f64> {
    let count = (length_deg * PX_PER_DEG) as i32;
    (0..count).map(|i| value((f64::from(i) - f64::from(count - 1) / 2.0) / PX_PER_DEG)).collect()
}

/// A ramp from `low` to `high`, `width_deg` wide, with a continuity depth of 1, 2 or 3; 0 degrees is a step.
fn ramp(depth: u32, width_deg: f64, low: f64, high: f64) -> Vec<f64> {
    profile(10.0, |x| {
        let u = if width_deg > 0.0 { (x / width_deg + 0.5).clamp(0.0, 1.0) } else { f64::from(u8::from(x > 0.0)) };
        let i = match depth {
            1 => u,
            2 => u * u * (3.0 - 2.0 * u),
            _ => u * u * u * (10.0 + u * (6.0 * u - 15.0)),
        };
        low + (high - low) * i
    })
}

fn strongest(marks: &[Mark], bright: bool) -> f64 {
    marks.iter().filter(|mark| mark.bright == bright).map(|mark| mark.strength).fold(0.0, f64::max)
}

/// The strength of the bright band that a model predicts for a ramp; 0 if there is none.
fn bright(model: &dyn Baseline, depth: u32, width_deg: f64) -> f64 {
    strongest(&model.marks(&ramp(depth, width_deg, 0.25, 0.75), PX_PER_DEG), true)
}

/// The image of the golden file: a rotated ramp with a square on it.
fn golden_picture() -> Vec<f32> {
    let off = |i: usize| (i as f64 - 31.5) / 16.0;
    let (sin, cos) = 20f64.to_radians().sin_cos();
    let light = |(y, x): (usize, usize)| {
        let in_square = (40..46).contains(&y) && (12..18).contains(&x);
        let u = (off(x) * cos - off(y) * sin + 0.5).clamp(0.0, 1.0);
        if in_square { 0.9 } else { (0.25 + 0.5 * u) as f32 }
    };
    (0..64).flat_map(|y| (0..64).map(move |x| (y, x))).map(light).collect()
}

#[test]
fn odog_agrees_with_multyscale() {
    let path = format!("{}/tests/golden/odog.csv", env!("CARGO_MANIFEST_DIR"));
    let mut reader =
        csv::ReaderBuilder::new().comment(Some(b'#')).has_headers(false).from_path(path).expect("the golden file");
    let expected: Vec<f64> = reader
        .records()
        .flat_map(|row| row.unwrap().iter().map(|value| value.parse().unwrap()).collect::<Vec<f64>>())
        .collect();
    assert_eq!(expected.len(), 64 * 64);
    let found = Odog::default().respond(&golden_picture(), 64, 64, 16.0);
    let (low, high) = expected.iter().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
    assert!(high - low > 20.0);
    for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
        let error = (f64::from(*found) - expected).abs();
        assert!(error <= 1e-4 * (high - low), "pixel {i}: {found}, not {expected}");
    }
}

/// In its middle row, a tall image of a profile has the same response as the profile itself: bands at the same
/// positions and with the same strengths. The two computations share no filter: one is sampled in two dimensions, the
/// other is exact in one.
#[test]
fn odog_responds_alike_to_a_profile_and_its_image() {
    let (width, px_per_deg) = (161, 16.0);
    let model = Odog { finest_deg: 0.1875, sizes: 3, beyond: Beyond::Nearest, ..Odog::default() };
    let light: Vec<f64> = (0..width).map(|i| 0.25 + 0.5 * (f64::from(i - 80) / 24.0 + 0.5).clamp(0.0, 1.0)).collect();
    let row: Vec<f32> = light.iter().map(|value| *value as f32).collect();
    let picture = row.repeat(width as usize);
    let response = model.respond(&picture, width as usize, width as usize, px_per_deg);
    let middle = &response[80 * width as usize..][..width as usize];
    let peak = (81..160).max_by(|a, b| middle[*a as usize].total_cmp(&middle[*b as usize])).unwrap();
    let over = f64::from(middle[peak as usize] - middle[160]);
    let marks = model.marks(&light, px_per_deg);
    let band = marks.iter().find(|mark| mark.bright).expect("a bright band");
    assert!((band.at_deg - f64::from(peak - 80) / px_per_deg).abs() <= 1.0 / px_per_deg, "{band:?}, peak at {peak}");
    assert!((band.strength / over - 1.0).abs() < 0.01, "{} in the profile, {over} in the picture", band.strength);
}

/// Each orientation is divided by its own root mean square, so contrast cancels out.
#[test]
fn odog_does_not_depend_on_contrast() {
    let size = 48;
    let model = Odog { beyond: Beyond::Nearest, ..Odog::default() };
    let light: Vec<f32> = (0..size * size).map(|i| if (i % size) * 3 + (i / size) > 80 { 0.8 } else { 0.3 }).collect();
    let faint: Vec<f32> = light.iter().map(|value| 0.5 + 0.1 * value).collect();
    let (response, of_faint) = (model.respond(&light, size, size, 16.0), model.respond(&faint, size, size, 16.0));
    assert!(response.iter().any(|value| *value > 2.0));
    for (i, (a, b)) in response.iter().zip(&of_faint).enumerate() {
        assert!((a - b).abs() < 1e-3, "pixel {i}: {a}, {b} at a tenth of the contrast");
    }
}

#[test]
fn invalid_images_have_no_response() {
    let model = Odog::default();
    assert!(model.respond(&[0.5; 11], 4, 3, 16.0).is_empty());
    assert!(model.respond(&[], 0, 0, 16.0).is_empty());
    assert!(model.respond(&[f32::NAN; 12], 4, 3, 16.0).is_empty());
    assert!(model.respond(&[0.5; 12], 4, 3, 0.0).is_empty());
    assert_eq!(model.respond(&[0.5; 12], 4, 3, 16.0), vec![0.0; 12]);
    for model in all() {
        for light in [vec![], vec![0.3, 0.4], vec![0.3, f64::NAN, 0.4, 0.5]] {
            assert!(model.marks(&light, PX_PER_DEG).is_empty(), "{}", model.name());
        }
        assert!(model.marks(&ramp(1, 1.0, 0.25, 0.75), f64::NAN).is_empty(), "{}", model.name());
        assert!(model.marks(&ramp(1, 1.0, 0.25, 0.75), 1e12).is_empty(), "{}", model.name());
    }
}

/// Every model predicts a dark band at the foot of a ramp and a bright band at its top, within half its width.
#[test]
fn a_ramp_has_a_dark_and_a_bright_band() {
    for model in all() {
        for (width_deg, falling) in [(0.5, false), (1.5, false), (1.5, true)] {
            let mut light = ramp(1, width_deg, 0.25, 0.75);
            if falling {
                light.reverse();
            }
            let marks = model.marks(&light, PX_PER_DEG);
            let [first, second] = marks[..] else { panic!("{} sees {marks:?}", model.name()) };
            assert!(first.bright == falling && second.bright != falling, "{}: {marks:?}", model.name());
            for (mark, end) in [(first, -width_deg / 2.0), (second, width_deg / 2.0)] {
                assert!((mark.at_deg - end).abs() < width_deg / 2.0, "{} at {width_deg}°: {mark:?}", model.name());
            }
        }
    }
}

/// There is no Mach band where the light itself has an extremum, nor where it does not change.
#[test]
fn gratings_and_fields_have_no_bands() {
    let cases = [
        profile(10.0, |_| 0.4),
        // Whole periods from crest to crest, so that the ends are smooth.
        profile(10.0, |x| 0.5 + 0.25 * (std::f64::consts::TAU * 0.6 * x).cos()),
    ];
    for model in all() {
        for light in &cases {
            let marks = model.marks(light, PX_PER_DEG);
            // The outermost period ends in a plateau. This is a sine edge, which may have bands.
            let inside: Vec<_> = marks.iter().filter(|mark| mark.at_deg.abs() < 3.0).collect();
            assert!(inside.is_empty(), "{}: {inside:?}", model.name());
        }
    }
}

/// Difference-of-Gaussians models respond most strongly to a step, where people see no band.
#[test]
fn lateral_inhibition_and_odog_are_largest_at_a_step() {
    let models: [&dyn Baseline; 2] = [&LateralInhibition::default(), &Odog::default()];
    for model in models {
        let step = bright(model, 1, 0.0);
        let ramps = [0.2, 0.5, 1.0, 2.0, 4.0].map(|width| bright(model, 1, width));
        assert!(step > ramps[0], "{}: {step} at a step, {ramps:?}", model.name());
        assert!(ramps.is_sorted_by(|a, b| a > b), "{}: {ramps:?}", model.name());
    }
}

/// The step response of a balanced difference of Gaussians is Φ(x/σc) − Φ(x/σs): its maximum has a closed form.
#[test]
fn lateral_inhibition_at_a_step_has_the_textbook_value() {
    let model = LateralInhibition::default();
    let width = LateralInhibition::WIDTH_ARCMIN / 60.0;
    // The response is largest where the two Gaussians are equal, at half the width of the excitatory part.
    let light = profile(4.0, |x| if x > 0.0 { 0.75 } else { 0.25 });
    let marks = model.marks(&light, PX_PER_DEG);
    let band = marks.iter().find(|mark| mark.bright).expect("a bright band");
    assert!((band.at_deg - width / 2.0).abs() < 0.3 / PX_PER_DEG, "{band:?}");
    let z = width / 2.0 / model.center_deg;
    let (inner, outer) = (normal(z), normal(z / model.surround));
    let expected = 0.5 * (inner - outer) / (0.25 + 0.5 * outer);
    assert!((band.strength / expected - 1.0).abs() < 0.02, "{}, not {expected}", band.strength);
}

/// The normal cumulative distribution at `z`, by Simpson's rule.
fn normal(z: f64) -> f64 {
    let density = |x: f64| (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt();
    let h = z / 200.0;
    let inner = |i: i32| if i % 2 == 0 { 2.0 } else { 4.0 } * density(f64::from(i) * h);
    0.5 + h / 3.0 * (density(0.0) + density(z) + (1..200).map(inner).sum::<f64>())
}

/// The strength is the same for one shape at any size and contrast, 0 at a step, and falls with continuity depth.
#[test]
fn the_ratio_depends_only_on_shape() {
    let model = SecondDerivativeRatio::default();
    let one = bright(&model, 1, 1.0);
    for width in [0.25, 0.5, 2.0] {
        let other = bright(&model, 1, width);
        assert!((other / one - 1.0).abs() < 2e-3, "{other} at {width}°, {one} at 1°");
    }
    for (low, high) in [(0.4, 0.6), (0.1, 0.9)] {
        let other = strongest(&model.marks(&ramp(1, 1.0, low, high), PX_PER_DEG), true);
        assert!((other / one - 1.0).abs() < 1e-9, "{other} from {low} to {high}, {one}");
    }
    assert_eq!(bright(&model, 1, 0.0), 0.0);
    let depths = [1, 2, 3].map(|depth| bright(&model, depth, 1.0));
    assert!(depths.is_sorted_by(|a, b| a > b) && depths[2] > 0.0, "{depths:?}");
}

/// A blurred edge has the ratio √(α₂/2) at any blur. This is below the criterion, so there is no band.
#[test]
fn the_ratio_of_a_blurred_edge_is_known() {
    let seeing = SecondDerivativeRatio { criterion: 0.0, ..SecondDerivativeRatio::default() };
    for power in [1.25, 1.5, 1.75] {
        let model = SecondDerivativeRatio { first_power: power - 1.0, second_power: power, ..seeing };
        for blur in [0.1, 0.3] {
            let light =
                profile(10.0, |x| 0.25 + 0.5 * if x < 0.0 { 1.0 - normal(-x / blur) } else { normal(x / blur) });
            let ratio = strongest(&model.marks(&light, PX_PER_DEG), true);
            let expected = SecondDerivativeRatio::of_blurred_edge(power);
            assert!((ratio / expected - 1.0).abs() < 5e-4, "{ratio}, not {expected}: α₂ = {power}, blur {blur}");
            let marks = SecondDerivativeRatio::default().marks(&light, PX_PER_DEG);
            assert!(power != 1.5 || marks.is_empty(), "{marks:?}");
        }
    }
}

#[test]
fn the_committed_mask_matches_the_generator() {
    let made = void_and_cluster(MASK_SIZE, MASK_SEED);
    assert!(mask() == made, "run `cargo run -p tools -- blue-noise`");
    assert!(void_and_cluster(MASK_SIZE, MASK_SEED + 1) != made);
}

/// Ulichney's three phases as published, with a plain f64 filter based on `exp`. At every rank, the next pixel of the
/// mask is the tightest cluster, the largest void, or, in phase III, the tightest cluster of dark pixels.
#[test]
fn the_mask_follows_void_and_cluster() {
    let n = MASK_SIZE as usize;
    let filter: Vec<f64> = (0..n * n)
        .map(|i| {
            let [dx, dy] = [i % n, i / n].map(|d| d.min(n - d) as f64);
            (-(dx * dx + dy * dy) / (2.0 * 1.5 * 1.5)).exp()
        })
        .collect();
    let add = |energy: &mut [f64], place: usize, sign: f64| {
        for (i, energy) in energy.iter_mut().enumerate() {
            *energy += sign * filter[(i % n).abs_diff(place % n) + (i / n).abs_diff(place / n) * n];
        }
    };
    let ranks = mask();
    let mut places = vec![0; n * n];
    for (place, &rank) in ranks.iter().enumerate() {
        places[usize::from(rank)] = place;
    }
    // Apart from rounding, no pixel whose rank is in `among` may be more crowded than the pixel of rank `chosen`.
    let most_crowded = |energy: &[f64], chosen: usize, among: std::ops::Range<usize>| {
        let most = among.map(|rank| energy[places[rank]]).fold(f64::MIN, f64::max);
        assert!(energy[places[chosen]] >= most - 1e-9, "rank {chosen}: {} and {most}", energy[places[chosen]]);
    };
    let ones = n * n / 10;
    let mut lit = vec![0.0; n * n];
    places[..ones].iter().for_each(|&place| add(&mut lit, place, 1.0));
    let prototype = lit.clone();
    for rank in (0..ones).rev() {
        most_crowded(&lit, rank, 0..rank + 1);
        add(&mut lit, places[rank], -1.0);
    }
    let mut lit = prototype;
    for (rank, &place) in places.iter().enumerate().take(n * n / 2).skip(ones) {
        let least: Vec<f64> = lit.iter().map(|energy| -energy).collect();
        most_crowded(&least, rank, rank..n * n);
        add(&mut lit, place, 1.0);
    }
    let mut dark = vec![0.0; n * n];
    places[n * n / 2..].iter().for_each(|&place| add(&mut dark, place, 1.0));
    for (rank, &place) in places.iter().enumerate().skip(n * n / 2) {
        most_crowded(&dark, rank, rank..n * n);
        add(&mut dark, place, -1.0);
    }
}

/// Mean power of `values`, a square with `n` values per side, over the frequencies `inner` < |k| ≤ `outer` in cycles
/// per side, relative to white noise of the same variance.
fn relative_power(values: &[f64], n: usize, inner: f64, outer: f64) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64;
    let reach = outer.ceil() as i32;
    let (mut power, mut count) = (0.0, 0);
    for ky in 0..=reach {
        for kx in -reach..=reach {
            let k = f64::from(kx).hypot(f64::from(ky));
            if k <= inner || k > outer {
                continue;
            }
            let (mut re, mut im) = (0.0, 0.0);
            for (i, value) in values.iter().enumerate() {
                let turns = f64::from(kx) * (i % n) as f64 + f64::from(ky) * (i / n) as f64;
                let (sin, cos) = (TAU * turns / n as f64).sin_cos();
                re += (value - mean) * cos;
                im += (value - mean) * sin;
            }
            power += re * re + im * im;
            count += 1;
        }
    }
    power / f64::from(count) / (variance * values.len() as f64)
}

#[test]
fn the_mask_has_a_blue_noise_spectrum() {
    let n = MASK_SIZE as usize;
    let ranks: Vec<f64> = mask().iter().map(|&rank| f64::from(rank)).collect();
    let low = relative_power(&ranks, n, 0.0, 8.0);
    let high = relative_power(&ranks, n, 24.0, 30.0);
    println!("mask: power relative to white noise: {low:.4} below 8 cycles per side, {high:.2} at 24…30");
    assert!(low < 0.03 && high > 1.0, "{low} {high}");
    // The patterns that the mask produces, below 0.35 of their principal frequency √p·64.
    for (p, bound) in [(1.0 / 16.0, 0.1), (0.125, 0.1), (0.25, 0.1), (0.5, 0.1), (0.875, 0.1)] {
        let pattern: Vec<f64> = ranks.iter().map(|&rank| f64::from(u8::from(rank < p * 4096.0))).collect();
        let below = 0.35 * f64::min(p, 1.0 - p).sqrt() * 64.0;
        let low = relative_power(&pattern, n, 0.0, below);
        println!("pattern of {p}: power below {below:.1} cycles per side: {low:.4} of white noise");
        assert!(low < bound, "p {p}: {low}");
    }
    // For white noise, the measure is about 1.
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let white: Vec<f64> = ranks.iter().map(|_| f64::from(rng.next_u32())).collect();
    let white = relative_power(&white, n, 0.0, 8.0);
    assert!((0.7..1.3).contains(&white), "{white}");
}

/// `tools coverage` runs the full number of studies.
#[test]
fn a_few_studies_recover_their_effects() {
    for random in [Random::None, Random::Subject] {
        let found = recover(random, 12, 3).unwrap();
        let covered = coverage(&found.coefficients);
        assert!((0.88..0.995).contains(&covered), "{random:?}: {covered}");
        assert!(found.false_alarms <= 4, "{random:?}: {} of 12", found.false_alarms);
        assert_eq!((found.coefficients.len(), found.sd.is_some()), (12, random == Random::Subject));
        for parameter in found.coefficients.iter().chain(&found.sd) {
            let (bias, se) = (parameter.mean(|estimate, _| estimate) - parameter.truth, parameter.mean(|_, se| se));
            assert!(bias.abs() < 4.0 * se / 12f64.sqrt(), "{random:?}, {}: {bias}, se {se}", parameter.name);
        }
    }
}

/// The parameters in the code are those that the fit ends at: a further step would change none of them by more than 2 %,
/// and the bounds that `docs/models.md` states hold.
#[test]
fn the_detection_model_is_fitted_to_the_thresholds_of_people() {
    let people = People::read().unwrap();
    let held = Sensitivity::default();
    let errors = people.errors(&held);
    assert!(people.rms(&errors, &["modelfest"]) <= 0.06, "ModelFest");
    assert!(people.rms(&errors, &CSF) <= 0.12, "contrast sensitivity");
    assert!(people.rms(&errors, &["edges"]) <= 0.05, "edges without noise");
    for (edge, (error, _)) in people.edges.iter().zip(people.edges(&held)) {
        assert!(error.abs() <= 0.2, "{} noise, {}°: {error}", edge.noise, edge.width_deg);
    }
    let (leave_one_out, step) = people.linearized(&held);
    assert!(leave_one_out <= 0.08, "leave-one-out: {leave_one_out}");
    for (name, step) in NAMES.iter().zip(step) {
        assert!(step.abs() <= 0.02, "{name} would change by {:.2} %", 100.0 * step);
    }
    let unit = unit(&people, &held).unwrap();
    assert!((unit - 1.0).abs() <= 0.02, "a line at its threshold has a visibility of {unit}");
}

/// The parameters of the Python functions are those of the requests. `UPDATE_DOCS=1` writes them.
#[test]
fn python_functions_have_the_parameters_of_the_requests() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../python/machband");
    let now = |file: &str| fs::read_to_string(folder.join(file)).unwrap_or_default();
    for (file, expected) in python::files(now) {
        if std::env::var_os("UPDATE_DOCS").is_some() {
            fs::write(folder.join(file), &expected).unwrap();
        }
        assert!(now(file) == expected, "{file} is out of date: UPDATE_DOCS=1 cargo test -p tools python");
    }
}
