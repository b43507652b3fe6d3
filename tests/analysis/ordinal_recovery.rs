//! Known effects of simulated studies of the design of bangay2003, found again.

use machband::analysis::{
    ModelSpec, Random,
    counts::{Counts, MeasuredBuilder},
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
    let mut builder =
        MeasuredBuilder::new(&["width", "depth", "orientation_deg"]).with_categories(&["0", "1", "2", "3"]);
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
                        builder.add_counts(&format!("S{subject:03}"), &values, &rating.to_string(), 1).unwrap();
                    }
                }
            }
        }
    }
    builder.finish().counts
}

fn truth(name: &str) -> f64 {
    let factors = [("width", &WIDTHS[..]), ("depth", &DEPTHS[..]), ("orientation_deg", &ORIENTATIONS[..])];
    let found = factors.iter().find_map(|(factor, levels)| {
        let level = name.strip_prefix(factor)?;
        levels.iter().find(|(text, _)| *text == level).map(|(_, effect)| *effect)
    });
    found.unwrap()
}

/// Over a few studies, 95 % intervals of the effects cover the truth about as often as they say, and the estimates are
/// not biased.
#[test]
fn a_few_studies_recover_their_effects() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let terms = Terms::factors(&["width", "depth", "orientation_deg"]);
    let spec = ModelSpec { random: Random::Subject, ..ModelSpec::new(terms) };
    let (mut covered, mut all, mut errors) = (0.0, 0.0, 0.0);
    for _ in 0..12 {
        let model = fit(&study(8, 0.6, &mut rng), &spec).unwrap();
        assert!(model.converged() && model.gradient < 1e-6);
        for coefficient in &model.coefficients {
            let error = coefficient.estimate - truth(&coefficient.name);
            covered += f64::from(u8::from(error.abs() <= 1.959_963_985 * coefficient.se.unwrap()));
            errors += error;
            all += 1.0;
        }
    }
    assert!((0.88..0.995).contains(&(covered / all)), "{covered} of {all}");
    assert!((errors / all).abs() < 0.05, "{errors} over {all}");
}
