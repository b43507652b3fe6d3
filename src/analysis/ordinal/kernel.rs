//! The inner loops of a mixed model: one subject's observations at one value of the random effect.
//!
//! With the logit link, e^(θ − xβ − σu) is a product: a subject's exponentials are taken once for all nodes and all steps
//! to the mode, and logarithms are taken of products.

use super::{
    clm::category_bounds,
    link::{Link, Shift, normal_shift},
};

/// Equal ratings of a subject in one design row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Observation {
    /// Row of the design matrix.
    pub row: usize,
    pub category: usize,
    pub count: f64,
}

/// What the width of each category adds with the logit link: log(1 − e^(b − a)) and 1 / (e^(a − b) − 1).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Width {
    log: f64,
    q: f64,
}

/// The widths of all categories.
pub(super) fn widths(thresholds: &[f64]) -> Vec<Width> {
    (0..=thresholds.len())
        .map(|category| {
            let (a, b) = category_bounds(thresholds, category);
            let narrow = -(b - a).exp_m1();
            Width { log: narrow.ln(), q: (1.0 - narrow) / narrow }
        })
        .collect()
}

/// Thresholds, σ and, for every design row, xβ.
pub(super) struct Point<'a> {
    pub link: Link,
    pub thresholds: &'a [f64],
    pub sigma: f64,
    pub location: &'a [f64],
    pub widths: &'a [Width],
}

/// One subject at a point.
#[derive(Debug, Default)]
pub(super) struct Subject {
    /// At u = 0: the bounds a and b of each observation's category; with the logit link e^(−a) and e^b, 0 at the ends of
    /// the scale.
    upper: Vec<f64>,
    lower: Vec<f64>,
    count: Vec<f64>,
    /// The part of the log-likelihood that u does not change.
    constant: f64,
}

/// Sums over a subject's observations of the derivatives of the log-probability by a shift, each times the count.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ShiftSums {
    pub log_p: f64,
    pub g1: f64,
    pub g2: f64,
    pub g3: f64,
}

impl Subject {
    /// Takes the bounds of a subject's observations.
    pub fn set(&mut self, point: &Point, observations: &[Observation]) {
        self.upper.clear();
        self.lower.clear();
        self.count.clear();
        self.constant = 0.0;
        for observation in observations {
            let (a, b) = category_bounds(point.thresholds, observation.category);
            let location = point.location[observation.row];
            let (a, b) = (a - location, b - location);
            match point.link {
                Link::Logit => {
                    self.upper.push((-a).exp());
                    self.lower.push(b.exp());
                    self.constant += observation.count * point.widths[observation.category].log;
                }
                Link::Probit => {
                    self.upper.push(a);
                    self.lower.push(b);
                }
            }
            self.count.push(observation.count);
        }
    }

    fn bounds(&self) -> impl Iterator<Item = (f64, f64, f64)> + '_ {
        self.upper.iter().zip(&self.lower).zip(&self.count).map(|((upper, lower), count)| (*upper, *lower, *count))
    }

    /// Sums of all derivatives at u; leaves those of every observation in `shifts`, without what the width of its category
    /// adds ([`Self::width`]).
    pub fn at(&self, point: &Point, u: f64, shifts: &mut Vec<Shift>) -> ShiftSums {
        shifts.clear();
        let by = point.sigma * u;
        let (up, down) = (by.exp(), (-by).exp());
        let mut sums = ShiftSums { log_p: self.constant, ..ShiftSums::default() };
        let mut log_p = LogProduct::default();
        for (upper, lower, count) in self.bounds() {
            let shift = match point.link {
                Link::Logit => {
                    let odds = Odds::new(upper * up, lower * down);
                    log_p.add(odds.p, count);
                    odds.shift()
                }
                Link::Probit => {
                    let shift = normal_shift(upper - by, lower - by);
                    sums.log_p += count * shift.log_p;
                    shift
                }
            };
            sums.g1 += count * (shift.a + shift.b);
            sums.g2 += count * shift.g2;
            sums.g3 += count * shift.g3;
            shifts.push(shift);
        }
        sums.log_p += log_p.finish();
        sums
    }

    /// What the width of an observation's category adds to ∂g/∂a and takes from ∂g/∂b, whatever u is.
    pub fn width(point: &Point, observation: &Observation) -> f64 {
        match point.link {
            Link::Logit => point.widths[observation.category].q,
            Link::Probit => 0.0,
        }
    }
}

/// A category of the logistic distribution from e^(−a) and e^b.
#[derive(Clone, Copy)]
struct Odds {
    /// F(−a).
    above: f64,
    /// F(b).
    below: f64,
    /// F(a) F(−b): the probability but for the width of the category.
    p: f64,
}

impl Odds {
    #[inline]
    fn new(upper: f64, lower: f64) -> Self {
        let p = 1.0 / ((1.0 + upper) * (1.0 + lower));
        Self { above: upper * (1.0 + lower) * p, below: lower * (1.0 + upper) * p, p }
    }

    fn shift(self) -> Shift {
        let (fa, fb) = (self.above * (1.0 - self.above), self.below * (1.0 - self.below));
        let (slope_a, slope_b) = (fa * (2.0 * self.above - 1.0), fb * (1.0 - 2.0 * self.below));
        Shift {
            log_p: 0.0,
            a: self.above,
            b: -self.below,
            g2: -fa - fb,
            g3: -slope_a - slope_b,
            g1_a: -fa,
            g1_b: -fb,
            g2_a: -slope_a,
            g2_b: -slope_b,
        }
    }
}

/// Σ count log p, with few logarithms.
struct LogProduct {
    product: f64,
    sum: f64,
}

impl Default for LogProduct {
    fn default() -> Self {
        Self { product: 1.0, sum: 0.0 }
    }
}

impl LogProduct {
    #[inline]
    fn add(&mut self, p: f64, count: f64) {
        if count > 2.0 || p < 1e-50 {
            self.sum += count * p.ln();
            return;
        }
        // The counts are whole numbers: 1 or 2.
        self.product *= if count > 1.0 { p * p } else { p };
        if self.product < 1e-150 {
            self.sum += self.product.ln();
            self.product = 1.0;
        }
    }

    fn finish(self) -> f64 {
        self.sum + self.product.ln()
    }
}
