//! Known effects, found again: how often 95 % intervals cover the truth over simulated studies of the design of
//! bangay2003. Takes seconds in a release build:
//!
//!     cargo test --release --test ordinal_recovery -- --ignored --nocapture

use machband::analysis::{
    Model, ModelSpec, Random,
    counts::{Counts, CountsBuilder},
    fit,
    terms::Terms,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

const WIDTHS: [(&str, f64); 6] =
    [("0.02", 0.0), ("0.05", 0.3), ("0.1", 0.7), ("0.2", 0.9), ("0.4", 0.4), ("0.8", -0.5)];
const DEPTHS: [(&str, f64); 5] = [("1", 0.0), ("2", -1.0), ("3", -1.6), ("4", -2.0), ("inf", -2.6)];
const ORIENTATIONS: [(&str, f64); 4] = [("0", 0.0), ("45", -0.2), ("90", 0.0), ("135", -0.2)];
const THRESHOLDS: [f64; 3] = [-2.2, -0.7, 0.8];

/// One study: every subject rates every condition twice.
fn study(subjects: usize, sd: f64, rng: &mut ChaCha8Rng) -> Counts {
    let mut builder = CountsBuilder::new(&["width", "depth", "orientation_deg"]).with_categories(&["0", "1", "2", "3"]);
    for subject in 0..subjects {
        let intercept = sd * rng.sample::<f64, _>(StandardNormal);
        for (width, w) in WIDTHS {
            for (depth, d) in DEPTHS {
                for (orientation, o) in ORIENTATIONS {
                    for _ in 0..2 {
                        let p: f64 = rng.random();
                        let latent = intercept + w + d + o + (p / (1.0 - p)).ln();
                        let rating = THRESHOLDS.iter().filter(|threshold| latent > **threshold).count();
                        let values = [width, depth, orientation];
                        builder.add(&format!("S{subject:03}"), &values, &rating.to_string(), 1).unwrap();
                    }
                }
            }
        }
    }
    builder.finish()
}

fn truth(name: &str) -> f64 {
    let factors = [("width", &WIDTHS[..]), ("depth", &DEPTHS[..]), ("orientation_deg", &ORIENTATIONS[..])];
    let found = factors.iter().find_map(|(factor, levels)| {
        let level = name.strip_prefix(factor)?;
        levels.iter().find(|(text, _)| *text == level).map(|(_, effect)| *effect)
    });
    found.unwrap()
}

/// Intervals that cover, and all.
#[derive(Default)]
struct Coverage {
    covered: [usize; 3],
    all: [usize; 3],
    sds: Vec<f64>,
    errors: f64,
}

impl Coverage {
    fn count(&mut self, kind: usize, estimate: f64, se: f64, truth: f64) {
        self.covered[kind] += usize::from((estimate - truth).abs() <= 1.959_963_985 * se);
        self.all[kind] += 1;
    }

    fn add(&mut self, model: &Model, sd: f64) {
        assert!(model.converged() && model.gradient < 1e-6);
        for coefficient in &model.coefficients {
            self.count(0, coefficient.estimate, coefficient.se.unwrap(), truth(&coefficient.name));
            self.errors += coefficient.estimate - truth(&coefficient.name);
        }
        for (threshold, truth) in model.thresholds.iter().zip(THRESHOLDS) {
            self.count(1, threshold.estimate, threshold.se.unwrap(), truth);
        }
        if let Some(random) = &model.random {
            self.sds.push(random.sd);
            self.count(2, random.sd, random.se.unwrap_or(0.0), sd);
        }
    }

    fn rate(&self, kind: usize) -> f64 {
        self.covered[kind] as f64 / self.all[kind] as f64
    }
}

fn recover(studies: usize, subjects: usize, sd: f64, random: Random, nodes: usize, seed: u64) -> Coverage {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let terms = Terms::factors(&["width", "depth", "orientation_deg"]);
    let spec = ModelSpec { random, quadrature: nodes, ..ModelSpec::new(terms) };
    let mut coverage = Coverage::default();
    for _ in 0..studies {
        coverage.add(&fit(&study(subjects, sd, &mut rng), &spec).unwrap(), sd);
    }
    println!(
        "{random:?}, sd {sd}, {nodes} nodes, {studies} studies of {subjects}: effects {:.4} of {}, thresholds {:.3}, sd {:.3}; mean error {:.4}, mean sd {:.3}",
        coverage.rate(0),
        coverage.all[0],
        coverage.rate(1),
        coverage.rate(2),
        coverage.errors / coverage.all[0] as f64,
        coverage.sds.iter().sum::<f64>() / coverage.sds.len().max(1) as f64,
    );
    coverage
}

#[test]
#[ignore = "seconds of simulation: figures for the report"]
fn intervals_cover_true_effects_as_often_as_they_say() {
    for coverage in [
        recover(200, 8, 0.0, Random::None, 1, 1),
        recover(200, 8, 0.6, Random::Subject, 1, 2),
        recover(200, 8, 0.6, Random::Subject, 10, 2),
    ] {
        assert!((0.93..0.97).contains(&coverage.rate(0)), "{}", coverage.rate(0));
    }
    // Leaving out the subjects' variance where there is some biases the effects towards 0.
    recover(200, 8, 0.6, Random::None, 1, 2);
}

/// The same with few studies, for every run of the tests.
#[test]
fn a_few_studies_recover_their_effects() {
    let coverage = recover(12, 8, 0.6, Random::Subject, 1, 3);
    assert!((0.88..0.995).contains(&coverage.rate(0)), "{}", coverage.rate(0));
    assert!((coverage.errors / coverage.all[0] as f64).abs() < 0.05);
}
