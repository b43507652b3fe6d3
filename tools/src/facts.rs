//! Known facts about Mach bands, and which of them each model reproduces: the table of `docs/models.md`.
//!
//! The profiles run from ¼ to ¾ of white over 10° at 128 samples per degree, and are constant beyond their ends.

use rayon::prelude::*;
use statrs::function::erf::erf;

use machband::{
    light::{Depth, Interpolation},
    vision::{Band, Border, Eye, Line, Polarity},
};
use tools::baselines::{self, Baseline, Mark};

const PX_PER_DEG: f64 = 128.0;
const LENGTH_DEG: f64 = 10.0;
/// Widths of Bangay's ramps in a window of 10°.
const BANGAY: [f64; 6] = [0.2, 0.5, 1.0, 2.0, 4.0, 8.0];
/// The widths where bands are strongest.
const STRONGEST: [f64; 5] = [0.1, 0.2, 0.4, 0.8, 1.6];
/// A response below this fraction of the largest counts as none.
const NO_RESPONSE: f64 = 0.01;

/// The model of this library.
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
        let mark = |band: Band| Mark {
            at_deg: band.at_deg,
            bright: band.polarity == Polarity::Bright,
            strength: band.strength,
        };
        view.bands.into_iter().map(mark).collect()
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

/// Returns widths from `from` to `to` degrees, each larger than the last by about `ratio`.
fn widths(from: f64, to: f64, ratio: f64) -> Vec<f64> {
    let steps = ((to / from).ln() / ratio.ln()).ceil().max(1.0) as i32;
    (0..=steps).map(|k| from * (to / from).powf(f64::from(k) / f64::from(steps))).collect()
}

/// A model, with its responses to linear ramps.
struct TestedModel<'a> {
    model: &'a (dyn Baseline + Sync),
    /// The same model, ignoring the area near the ends of a profile.
    inside: &'a (dyn Baseline + Sync),
    /// Widths from 0.02° to 6.4°, 2 % apart, with the strength for linear ramps.
    by_width: Vec<(f64, f64)>,
    largest: f64,
}

impl TestedModel<'_> {
    fn of<'a>(model: &'a (dyn Baseline + Sync), inside: &'a (dyn Baseline + Sync)) -> TestedModel<'a> {
        let of = |width: f64| (width, strength(model, &Ramp::new(width, 1).light(), 1.0));
        let by_width: Vec<(f64, f64)> = widths(0.02, 6.4, 1.02).into_par_iter().map(of).collect();
        let largest = by_width.iter().map(|(_, strength)| *strength).fold(0.0, f64::max);
        TestedModel { model, inside, by_width, largest }
    }

    /// The largest strength for these profiles, relative to the largest of linear ramps.
    fn most(&self, lights: Vec<Vec<f64>>) -> f64 {
        lights.into_par_iter().map(|light| self.strength(&light)).reduce(|| 0.0, f64::max) / self.largest
    }

    fn strength(&self, light: &[f64]) -> f64 {
        strength(self.model, light, 1.0)
    }

    fn step(&self) -> Answer {
        let step = |k: i32| {
            let at = 0.1 * f64::from(k % 5) / PX_PER_DEG;
            profile(|x| 0.5 + 0.02 * f64::from(k / 5 + 1) * (x - at).signum())
        };
        let most = self.most((0..100).map(step).collect());
        (format!("{most:.3}"), most <= 0.01)
    }

    fn narrow(&self) -> Answer {
        let most = self.most(widths(0.002, 0.02, 1.1).into_iter().map(|width| Ramp::new(width, 1).light()).collect());
        (format!("{most:.3}"), most <= 0.1)
    }

    fn optimum(&self) -> Answer {
        let of: Vec<f64> = self.by_width.iter().map(|(_, strength)| strength / self.largest).collect();
        let best = (0..of.len()).max_by(|a, b| of[*a].total_cmp(&of[*b])).unwrap_or(0);
        // How far the curve falls below an earlier value on its way to the best width, from either side.
        let departure = |values: &mut dyn Iterator<Item = f64>| {
            let (mut most, mut fall) = (0.0, 0.0);
            for value in values {
                most = f64::max(most, value);
                fall = f64::max(fall, most - value);
            }
            fall
        };
        let wrong = departure(&mut of[..=best].iter().copied()).max(departure(&mut of[best..].iter().rev().copied()));
        let ends = of[0].max(of[of.len() - 1]);
        (
            format!("{:.2}°, ends {ends:.2}, departures {wrong:.3}", self.by_width[best].0),
            wrong <= 0.03 && best > 0 && best + 1 < of.len() && ends < 0.9,
        )
    }

    /// The relative strengths of ramps of these depths, for widths from 0.1° to 4°, 2 % apart.
    fn by_depth<const N: usize>(&self, depths: [Depth; N]) -> Vec<[f64; N]> {
        let of = |width: f64| {
            depths.map(|depth| self.strength(&Ramp { depth, ..Ramp::new(width, 1) }.light()) / self.largest)
        };
        widths(0.1, 4.0, 1.02).into_par_iter().map(of).collect()
    }

    fn depths(&self) -> Answer {
        let all = self.by_depth([1, 2, 3, 4].map(Depth::Finite));
        let most = all.iter().flat_map(|of| of.windows(2)).map(|pair| pair[1] - pair[0]).fold(f64::MIN, f64::max);
        let means = [0, 1, 2, 3].map(|k| all.iter().map(|of| of[k]).sum::<f64>() / all.len() as f64);
        (
            format!("means {}, largest rise {:.3}", means.map(|mean| format!("{mean:.2}")).join(" "), most.max(0.0)),
            most <= 0.001 && means.windows(2).all(|pair| pair[1] < pair[0]),
        )
    }

    fn infinite_depth(&self) -> Answer {
        let all = self.by_depth([Depth::Finite(3), Depth::Infinite]);
        let most = all.iter().map(|[third, endless]| endless - third).fold(f64::MIN, f64::max);
        (format!("largest rise {:.3}", most.max(0.0)), most <= 0.001)
    }

    fn smooth(&self) -> Answer {
        let of = |width: f64| [1, 2, 3, 4].map(|depth| self.strength(&Ramp::new(width, depth).light()) / self.largest);
        let all: Vec<[f64; 4]> = widths(0.125, 6.4, 1.01).into_par_iter().map(of).collect();
        let changes = all.windows(2).flat_map(|pair| [0, 1, 2, 3].map(|k| (pair[1][k] - pair[0][k]).abs()));
        let most = changes.fold(0.0, f64::max);
        (format!("{most:.3}"), most <= 0.03)
    }

    fn trapezoids(&self) -> Answer {
        // One period of 8° shows two ramps; at a share of 1, the plateaus are gone.
        let share = |k: i32| 0.02 * f64::from(k);
        let light = |share: f64| {
            profile(|x| {
                let phase = (x / 8.0).rem_euclid(1.0);
                let (ramp, phase) = (0.5 * share, if phase < 0.5 { phase } else { 1.0 - phase });
                let rise = (phase - (0.25 - 0.5 * ramp)) / ramp;
                0.25 + 0.5 * rise.clamp(0.0, 1.0)
            })
        };
        let of: Vec<f64> = (20..=50)
            .into_par_iter()
            .map(|k| {
                let marks = self.inside.marks(&light(share(k)), PX_PER_DEG);
                marks.iter().filter(|mark| mark.at_deg.abs() < 3.0).map(|mark| mark.strength).fold(0.0, f64::max)
                    / self.largest
            })
            .collect();
        let most = of.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::MIN, f64::max);
        (
            format!("{:.2} {:.2} {:.2}, largest rise {:.3}", of[0], of[15], of[30], most.max(0.0)),
            most <= 0.03 && of[30] < of[0],
        )
    }

    /// A bar beside the bright band of a ramp, brighter or darker than the plateau.
    fn bar_beside(&self) -> Answer {
        let ramp = Ramp::new(0.4, 1);
        let with_bar = |gap: f64, width: f64, contrast: f64| {
            let mut light = ramp.light();
            for (i, light) in light.iter_mut().enumerate() {
                let x = (i as f64 + 0.5) / PX_PER_DEG - LENGTH_DEG / 2.0 - 0.2;
                if x >= gap && x < gap + width {
                    *light *= 1.0 + contrast;
                }
            }
            let marks = self.model.marks(&light, PX_PER_DEG);
            let near = marks.iter().filter(|mark| mark.bright && (mark.at_deg - 0.2).abs() < 0.15);
            near.map(|mark| mark.strength).fold(0.0, f64::max)
        };
        let alone = with_bar(9.0, 0.1, 0.0);
        let each = [0.1, 0.2, 0.4, 0.8].map(|gap| {
            let all = [0.05, 0.1, 0.2].into_iter().flat_map(|width| [-0.2, 0.2].map(|contrast| (width, contrast)));
            let all: Vec<f64> = all.map(|(width, contrast)| with_bar(gap, width, contrast) / alone).collect();
            [all.iter().copied().fold(f64::MAX, f64::min), all.iter().copied().fold(0.0, f64::max)]
        });
        let text = each.map(|[least, most]| format!("{least:.2}…{most:.2}")).join(", ");
        (text, each.iter().all(|[least, most]| *most < 1.0 && most - least < 0.2) && each[0][1] < each[3][0])
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
        let lights: Vec<Vec<f64>> = lights.collect();
        let most = lights.into_par_iter().map(strongest).reduce(|| 0.0, f64::max) / self.largest;
        (format!("{most:.3}"), most <= NO_RESPONSE)
    }

    fn ends(&self) -> Answer {
        let mut farthest: f64 = 0.0;
        let mut right = true;
        for width in widths(0.2, 2.0, 1.05) {
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

const FACTS: [Fact; 16] = [
    ("a step has no band (at most 0.01; 20 contrasts, 5 positions within a pixel)", |model| model.step()),
    ("ramps of 0.002…0.02° have almost none (at most 0.10; widths 10 % apart)", |model| model.narrow()),
    ("one width in between gives the strongest band (widths 2 % apart; departures at most 0.03)", |model| {
        model.optimum()
    }),
    ("strength falls with n = 1, 2, 3, 4 at every width of 0.1…4° (2 % apart)", |model| model.depths()),
    ("n = ∞ is no stronger than n = 3 at any of these widths", |model| model.infinite_depth()),
    ("1 % of width changes strength by at most 0.03 (n = 1…4, 0.125…6.4°)", |model| model.smooth()),
    (
        "trapezoidal gratings: strength never rises from ramps of 40 % of the half period to a triangle (2 % apart)",
        |model| model.trapezoids(),
    ),
    (
        "a bar beside a band weakens it, alike for both signs and all widths, the more the nearer (gaps of 0.1, 0.2, 0.4, 0.8°)",
        |model| model.bar_beside(),
    ),
    ("doubling all sizes preserves the rank order of ramps of 0.2…8° (ρ ≥ 0.95)", |model| model.doubled(&BANGAY)),
    (
        "doubling all sizes preserves the rank order of ramps of 0.1…1.6°, where bands are strongest (ρ ≥ 0.95)",
        |model| model.doubled(&STRONGEST),
    ),
    ("the rank order is the same at contrasts of 20 % and 80 % (ρ ≥ 0.95)", |model| model.contrast()),
    ("a uniform field has no bands", |model| model.no_bands(std::iter::once(profile(|_| 0.5)))),
    ("gratings of 0.25…4 c/° have no bands (33 frequencies, 8 phases)", |model| {
        let all = widths(0.25, 4.0, 1.09).into_iter().flat_map(|f| (0..8).map(move |k| (f, f64::from(k) / 8.0)));
        model.no_bands(all.map(|(f, phase)| profile(|x| 0.5 + 0.25 * (std::f64::consts::TAU * (f * x + phase)).sin())))
    }),
    ("blurred edges (σ 0.05…1°, 5 % apart) have no bands", |model| {
        model.no_bands(
            widths(0.05, 1.0, 1.05).into_iter().map(|s: f64| profile(|x| 0.5 + 0.25 * erf(x / s / 2f64.sqrt()))),
        )
    }),
    ("bars of +10 %, 0.01…1° wide (5 % apart), have no bands: they are lines", |model| {
        model.no_bands(
            widths(0.01, 1.0, 1.05).into_iter().map(|w: f64| profile(|x| if x.abs() < 0.5 * w { 0.55 } else { 0.5 })),
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
