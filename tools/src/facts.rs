//! Known facts about Mach bands, and which of them each model reproduces: the table of `docs/predict.md`.
//!
//! The profiles run from ¼ to ¾ of white over 10° at 128 samples per degree, and are constant beyond their ends.

use statrs::function::erf::erf;

use machband::{
    light::{Depth, Interpolation},
    vision::{Border, Eye, Line, Polarity},
};
use tools::baselines::{self, Baseline, Mark};

const PX_PER_DEG: f64 = 128.0;
const LENGTH_DEG: f64 = 10.0;
/// Widths of the ramps, in degrees.
const WIDTHS: [f64; 10] = [0.01, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8, 1.6, 3.2, 6.4];
/// The widths of Bangay's ramps in a window of 10°.
const BANGAY: [f64; 6] = [0.2, 0.5, 1.0, 2.0, 4.0, 8.0];
/// The widths where bands are strongest.
const STRONGEST: [f64; 5] = [0.1, 0.2, 0.4, 0.8, 1.6];
/// A response below this fraction of the largest counts as none.
const NO_RESPONSE: f64 = 0.01;

/// The model of this library, with its channels summed.
struct LocalEnergy {
    border: Border,
}

impl Baseline for LocalEnergy {
    fn name(&self) -> &'static str {
        "local energy (ours)"
    }

    fn marks(&self, light: &[f64], px_per_deg: f64) -> Vec<Mark> {
        let line = Line { light, px_per_deg, border: self.border };
        let Ok(view) = line.predict(&Eye::default()) else { return Vec::new() };
        let first = |polarity| view.bands.iter().find(move |band| band.polarity == polarity);
        let mark = |polarity, strength| {
            let at_deg = first(polarity)?.at_deg[0];
            Some(Mark { at_deg, bright: polarity == Polarity::Bright, strength })
        };
        let both = [(Polarity::Bright, view.visibility.bright), (Polarity::Dark, view.visibility.dark)];
        both.into_iter().filter(|(_, strength)| *strength > 0.0).filter_map(|(p, strength)| mark(p, strength)).collect()
    }
}

/// A ramp: width in degrees, depth, contrast (½ for ¼ to ¾).
#[derive(Clone, Copy)]
struct Ramp {
    width: f64,
    depth: Depth,
    contrast: f64,
}

impl Ramp {
    fn new(width: f64, depth: u8) -> Ramp {
        Ramp { width, depth: Depth::Finite(depth), contrast: 0.5 }
    }

    fn light(&self) -> Vec<f64> {
        let step = Interpolation::new(self.depth);
        let rise = |x: f64| {
            if self.width > 0.0 {
                step.value((x / self.width + 0.5).clamp(0.0, 1.0))
            } else {
                f64::from(u8::from(x >= 0.0))
            }
        };
        profile(|x| 0.5 + self.contrast * (rise(x) - 0.5))
    }
}

fn profile(light: impl Fn(f64) -> f64) -> Vec<f64> {
    let samples = (LENGTH_DEG * PX_PER_DEG) as usize;
    (0..samples).map(|i| light((i as f64 + 0.5) / PX_PER_DEG - LENGTH_DEG / 2.0)).collect()
}

/// A model's result for a fact: the numbers as text, and whether they satisfy the bound.
type Answer = (String, bool);

/// A model, with its responses to linear ramps.
struct TestedModel<'a> {
    model: &'a dyn Baseline,
    /// The same model, ignoring the area near the ends of a profile.
    inside: &'a dyn Baseline,
    /// Strengths for linear ramps of [`WIDTHS`].
    by_width: Vec<f64>,
    largest: f64,
}

impl TestedModel<'_> {
    fn of<'a>(model: &'a dyn Baseline, inside: &'a dyn Baseline) -> TestedModel<'a> {
        let by_width: Vec<f64> =
            WIDTHS.iter().map(|width| strength(model, &Ramp::new(*width, 1).light(), 1.0)).collect();
        let largest = by_width.iter().copied().fold(0.0, f64::max);
        TestedModel { model, inside, by_width, largest }
    }

    fn strength(&self, light: &[f64]) -> f64 {
        strength(self.model, light, 1.0)
    }

    fn share(&self, light: &[f64], most: f64) -> Answer {
        let share = self.strength(light) / self.largest;
        (format!("{share:.3}"), share <= most)
    }

    fn narrow(&self) -> Answer {
        let share = self.by_width[0].max(self.by_width[1]) / self.largest;
        (format!("{share:.3}"), share <= 0.1)
    }

    fn optimum(&self) -> Answer {
        let (best, _) = self.by_width.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).unwrap_or((0, &0.0));
        let rises = self.by_width[..=best].windows(2).all(|pair| pair[1] >= pair[0]);
        let falls = self.by_width[best..].windows(2).all(|pair| pair[1] <= pair[0]);
        // A flat curve has no optimum.
        let ends = self.by_width[0].max(self.by_width[WIDTHS.len() - 1]) / self.largest;
        (
            format!("{}°, ends {ends:.2}", WIDTHS[best]),
            rises && falls && best > 0 && best + 1 < WIDTHS.len() && ends < 0.9,
        )
    }

    fn depths(&self) -> Answer {
        let mut met = true;
        let rows = [0.4, 1.0].map(|width| {
            let of = [1, 2, 3, 4].map(|depth| self.strength(&Ramp::new(width, depth).light()) / self.largest);
            met &= of.windows(2).all(|pair| pair[1] < pair[0] || pair[0] <= NO_RESPONSE && pair[1] <= NO_RESPONSE);
            of.map(|share| format!("{share:.2}")).join(" ")
        });
        (rows.join("; "), met)
    }

    fn infinite_depth(&self) -> Answer {
        let of = |depth| {
            [0.4, 1.0].map(|width| self.strength(&Ramp { depth, ..Ramp::new(width, 1) }.light()) / self.largest)
        };
        let (third, endless) = (of(Depth::Finite(3)), of(Depth::Infinite));
        let text = endless.map(|share| format!("{share:.2}")).join(", ");
        (text, endless.iter().zip(third).all(|(endless, third)| *endless <= third + NO_RESPONSE))
    }

    fn doubled(&self, widths: &[f64]) -> Answer {
        let pairs = conditions(widths).map(|ramp| [1.0, 2.0].map(|size| strength(self.model, &ramp.light(), size)));
        ranks_agree(pairs.collect(), 0.95)
    }

    fn contrast(&self) -> Answer {
        let strength = |ramp: Ramp| [0.2, 0.8].map(|contrast| self.strength(&Ramp { contrast, ..ramp }.light()));
        ranks_agree(conditions(&BANGAY).map(strength).collect(), 0.95)
    }

    fn no_bands(&self, lights: impl Iterator<Item = Vec<f64>>) -> Answer {
        let middle = |mark: &Mark| mark.at_deg.abs() <= LENGTH_DEG / 4.0;
        let strongest = |light: Vec<f64>| {
            let marks = self.inside.marks(&light, PX_PER_DEG);
            marks.iter().filter(|mark| middle(mark)).map(|mark| mark.strength).fold(0.0, f64::max)
        };
        let most = lights.map(strongest).fold(0.0, f64::max) / self.largest;
        (format!("{most:.3}"), most <= NO_RESPONSE)
    }

    fn ends(&self) -> Answer {
        let mut farthest: f64 = 0.0;
        let mut right = true;
        for width in [0.2, 0.4, 0.8, 1.6] {
            let marks = self.model.marks(&Ramp::new(width, 1).light(), PX_PER_DEG);
            for (bright, end) in [(true, width / 2.0), (false, -width / 2.0)] {
                let strongest =
                    marks.iter().filter(|mark| mark.bright == bright).max_by(|a, b| a.strength.total_cmp(&b.strength));
                match strongest {
                    Some(mark) => farthest = farthest.max((mark.at_deg - end).abs() / width),
                    None => right = false,
                }
            }
        }
        (format!("{farthest:.2}"), right && farthest <= 0.5)
    }
}

/// The strength of the strongest mark when the profile is `size` times as large.
fn strength(model: &dyn Baseline, light: &[f64], size: f64) -> f64 {
    model.marks(light, PX_PER_DEG / size).iter().map(|mark| mark.strength).fold(0.0, f64::max)
}

fn conditions(widths: &[f64]) -> impl Iterator<Item = Ramp> {
    let depths = [1, 2, 3, 4].map(Depth::Finite).into_iter().chain([Depth::Infinite]);
    widths.iter().flat_map(move |width| depths.clone().map(|depth| Ramp { depth, ..Ramp::new(*width, 1) }))
}

fn ranks_agree(pairs: Vec<[f64; 2]>, least: f64) -> Answer {
    let of = |i: usize| pairs.iter().map(|pair| pair[i]).collect::<Vec<_>>();
    match machband::report::prediction::rank_correlation(&of(0), &of(1)) {
        Some(rho) => (format!("{rho:.3}"), rho >= least),
        None => ("—".to_owned(), false),
    }
}

/// A fact with its bound, and the function that tests it on a model.
type Fact = (&'static str, fn(&TestedModel) -> Answer);

const FACTS: [Fact; 12] = [
    ("a step has no band (at most 0.01)", |model| model.share(&Ramp::new(0.0, 1).light(), 0.01)),
    ("very narrow ramps (≤ 0.02°) have almost none (at most 0.10)", |model| model.narrow()),
    ("one width in between gives the strongest band", |model| model.optimum()),
    ("strength falls with n = 1, 2, 3, 4 (at 0.4°; at 1°)", |model| model.depths()),
    ("n = ∞ is no stronger than n = 3 (at 0.4°, at 1°)", |model| model.infinite_depth()),
    ("doubling all sizes preserves the rank order of ramps of 0.2…8° (ρ ≥ 0.95)", |model| model.doubled(&BANGAY)),
    (
        "doubling all sizes preserves the rank order of ramps of 0.1…1.6°, where bands are strongest (ρ ≥ 0.95)",
        |model| model.doubled(&STRONGEST),
    ),
    ("the rank order is the same at contrasts of 20 % and 80 % (ρ ≥ 0.95)", |model| model.contrast()),
    ("a uniform field has no bands", |model| model.no_bands(std::iter::once(profile(|_| 0.5)))),
    ("gratings of 0.25…4 c/° have no bands", |model| {
        model.no_bands(
            [0.25, 0.5, 1.0, 2.0, 4.0]
                .into_iter()
                .map(|f: f64| profile(|x| 0.5 + 0.25 * (std::f64::consts::TAU * f * x).sin())),
        )
    }),
    ("blurred edges (σ 0.05…1°) have no bands", |model| {
        model.no_bands(
            [0.05, 0.1, 0.2, 0.5, 1.0].into_iter().map(|s: f64| profile(|x| 0.5 + 0.25 * erf(x / s / 2f64.sqrt()))),
        )
    }),
    ("bright band at the top of the ramp, dark band at the bottom (distance from the end, in widths)", |model| {
        model.ends()
    }),
];

pub fn run() {
    let baselines = baselines::all();
    let (ours, inside) = (LocalEnergy { border: Border::Continues }, LocalEnergy { border: Border::Cut });
    let models: Vec<TestedModel> = std::iter::once(TestedModel::of(&ours, &inside))
        .chain(baselines.iter().map(|model| TestedModel::of(model.as_ref(), model.as_ref())))
        .collect();
    println!("| fact | {} |", models.iter().map(|model| model.model.name()).collect::<Vec<_>>().join(" | "));
    println!("|---|{}", "---|".repeat(models.len()));
    for (fact, ask) in FACTS {
        let cells = models.iter().map(|model| {
            let (text, met) = ask(model);
            format!("{} {text}", if met { "yes:" } else { "**no**:" })
        });
        println!("| {fact} | {} |", cells.collect::<Vec<_>>().join(" | "));
    }
}
