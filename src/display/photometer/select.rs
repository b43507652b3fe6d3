//! Which model: the simplest that the readings do not speak against.
//!
//! What a model has more than another must earn its place by an F test at [`LEVEL`]. Sharing one shape among the channels
//! halves the error of γ; an offset that is free where there is none would make it four times as large (6 levels, one
//! reading each).

use statrs::distribution::{ContinuousCDF as _, FisherSnedecor};

use super::{
    fit::Fit,
    model::{Black, Model},
    sample::{Point, Sample},
    shape::Family,
};

/// Probability of freeing an offset where there is none.
const LEVEL: f64 = 1e-3;
/// Probability of giving each channel a γ of its own where they share one; it costs little.
const LEVEL_OWN_GAMMA: f64 = 1e-4;
/// Probability of giving each channel an offset or a black of its own where they share one; it costs much.
const LEVEL_OWN: f64 = 2e-5;
/// Variance, relative to the assumed one, below which nothing is left to explain.
const NOTHING_LEFT: f64 = 0.05;

/// Whether `rich` explains more than chance of what `simple` leaves.
fn earns(simple: &Fit, rich: &Fit, level: f64) -> bool {
    let more = rich.parameters.len().saturating_sub(simple.parameters.len()).max(1) as f64;
    let freedom = rich.freedom();
    if freedom < 1.0 {
        return false;
    }
    let left = (rich.deviance / freedom).max(NOTHING_LEFT);
    let f = (simple.deviance - rich.deviance) / more / left;
    is_rare(f, more, freedom, level)
}

fn is_rare(f: f64, more: f64, freedom: f64, level: f64) -> bool {
    f > 0.0 && FisherSnedecor::new(more, freedom).is_ok_and(|distribution| distribution.sf(f) < level)
}

/// The fits of the three families.
#[derive(Clone, Debug)]
pub(super) struct Families {
    pub srgb: Fit,
    pub gamma: Fit,
    pub gog: Fit,
}

impl Families {
    pub fn new(sample: &Sample) -> Self {
        let black = black(sample);
        Self {
            srgb: Fit::new(Model { family: Family::Srgb, pooled: true, black }, sample),
            gamma: pooled_or_not(Model { family: Family::Gamma, pooled: true, black }, sample),
            gog: gog(black, sample),
        }
    }

    /// The simplest that suffices.
    pub fn best(&self) -> &Fit {
        let simple = if earns(&self.srgb, &self.gamma, LEVEL)
            || self.gamma.deviance < self.srgb.deviance && earns(&self.srgb, &self.gog, LEVEL)
        {
            &self.gamma
        } else {
            &self.srgb
        };
        let same_size = self.gog.parameters.len() <= simple.parameters.len() && self.gog.deviance < simple.deviance;
        if same_size || earns(simple, &self.gog, LEVEL) { &self.gog } else { simple }
    }

    pub fn of(&self, family: Family) -> &Fit {
        match family {
            Family::Srgb => &self.srgb,
            Family::Gamma => &self.gamma,
            Family::Gog => &self.gog,
            Family::Table => self.best(),
        }
    }
}

/// Whether the channels agree on black, by their readings of it alone.
fn black(sample: &Sample) -> Black {
    let dark: Vec<&Point> = sample.points.iter().filter(|point| point.v == 0.0).collect();
    let mean = |of: &dyn Fn(&Point) -> bool| {
        let (sum, weight) = (dark.iter().filter(|point| of(point)))
            .fold((0.0, 0.0), |(sum, weight), point| (sum + point.y / point.sd.powi(2), weight + point.sd.powi(-2)));
        (sum / weight, weight)
    };
    let all = mean(&|_| true).0;
    let own: Vec<(f64, f64)> = (0..sample.width()).map(|channel| mean(&|point| point.channel == channel)).collect();
    if own.len() < 2 || own.iter().any(|(_, weight)| *weight == 0.0) {
        return Black::Common;
    }
    let more = own.len() as f64 - 1.0;
    // What a light of one channel explains, against the noise that all readings show.
    let f = own.iter().map(|(mean, weight)| weight * (mean - all).powi(2)).sum::<f64>() / more;
    let freedom = (sample.points.len() as f64 - 2.0 * own.len() as f64).max(1.0);
    if is_rare(f, more, freedom, LEVEL_OWN) { Black::Own } else { Black::Common }
}

fn pooled_or_not(model: Model, sample: &Sample) -> Fit {
    let pooled = Fit::new(model, sample);
    if sample.width() < 2 {
        return pooled;
    }
    let own = Fit::new(Model { pooled: false, ..model }, sample);
    let level = if model.family == Family::Gamma { LEVEL_OWN_GAMMA } else { LEVEL_OWN };
    if earns(&pooled, &own, level) { own } else { pooled }
}

/// Gain, offset and gamma: black by itself only where it is not the offset's own light.
fn gog(black: Black, sample: &Sample) -> Fit {
    let free = pooled_or_not(Model { family: Family::Gog, pooled: true, black }, sample);
    let own = match black {
        Black::Own | Black::OwnOffset => Black::OwnOffset,
        Black::Common | Black::Offset => Black::Offset,
    };
    let offset = Fit::new(Model { black: own, ..free.model }, sample);
    if earns(&offset, &free, LEVEL) { free } else { offset }
}
