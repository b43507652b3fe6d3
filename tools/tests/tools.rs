//! Checks that the blue-noise mask matches its generator, follows the void-and-cluster method, and has a blue-noise
//! spectrum.
//!
//! Checks that the ordinal models recover known effects.

use std::{f64::consts::TAU, fs, path::Path};

use machband::{
    analysis::Random,
    light::dither::{MASK_SIZE, mask},
    vision::{Masking, Sensitivity},
};
use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng, SeedableRng},
};
use tools::{
    blue_noise::{MASK_SEED, void_and_cluster},
    coverage::{coverage, recover},
    python,
    thresholds::{CSF, NAMES, People, octaves, unit},
};

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
/// and the model is as near to people as `docs/models.md` states.
#[test]
fn the_detection_model_is_fitted_to_the_thresholds_of_people() {
    let people = People::read().unwrap();
    let held = Sensitivity::default();
    let errors = people.errors(&held);
    assert!(people.rms(&errors, &["modelfest"]) <= 0.055, "ModelFest");
    assert!(people.rms(&errors, &CSF) <= 0.12, "contrast sensitivity");
    assert!(people.rms(&errors, &["edges"]) <= 0.03, "edges without noise");
    for (cpd, bias, _) in octaves(&people, &errors) {
        assert!(bias.abs() <= 0.08, "{cpd} cycles per degree: {bias}");
    }
    let edges: Vec<f64> = people.edges(&held, &Masking::default()).into_iter().map(|(error, _)| error).collect();
    let rms = (edges.iter().map(|error| error * error).sum::<f64>() / edges.len() as f64).sqrt();
    assert!(rms <= 0.12 && edges.iter().all(|error| error.abs() <= 0.35), "edges: {edges:?}");
    let (leave_one_out, step) = people.linearized(&held);
    assert!(leave_one_out <= 0.062, "leave-one-out: {leave_one_out}");
    for (name, step) in NAMES.iter().zip(step) {
        assert!(step.abs() <= 0.02, "{name} would change by {:.2} %", 100.0 * step);
    }
    let unit = unit(&held).unwrap();
    assert!((unit / Masking::default().half - 1.0).abs() <= 0.003, "masking is 1/√2 at a response of {unit}");
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
