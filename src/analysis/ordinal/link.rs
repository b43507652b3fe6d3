//! Cumulative links: the distribution F in P(Y ≤ j) = F(θ_j − xβ), and the derivatives of a category's log-probability
//! log(F(upper) − F(lower)) with respect to its two bounds.

use std::f64::consts::FRAC_1_SQRT_2;

use statrs::function::erf::{erfc, erfc_inv};

use crate::text::names::named;

named! {
    /// The link of a cumulative model.
    #[derive(Default)]
    Link, LinkError {
        /// Proportional odds: F is the logistic distribution.
        #[default]
        Logit = "logit",
        /// F is the standard normal distribution.
        Probit = "probit",
    }
}

/// The log-probability of a category between an upper bound a and a lower bound b, and its derivatives. If the
/// probability is not above 0, `log_p` is −∞ or NaN, and the other fields are meaningless.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cell {
    pub log_p: f64,
    pub a: f64,
    pub b: f64,
    pub aa: f64,
    pub ab: f64,
    pub bb: f64,
}

/// A category whose bounds are shifted together many times. With the logit link, e^(θ − xβ − σu) is a product, so the
/// exponentials of the bounds are computed only once for all values of u.
#[derive(Clone, Copy, Debug)]
pub(super) struct Category {
    /// The bounds a and b, or e^(−a) and e^b with the logit link.
    upper: f64,
    lower: f64,
    /// The contributions of the category's width with the logit link: log(1 − e^(b − a)) and 1 / (e^(a − b) − 1).
    log_width: f64,
    q: f64,
}

/// The effect of shifting both bounds by t: the derivatives of g(t) = log(F(a + t) − F(b + t)) at t = 0, and the
/// derivatives of the first two with respect to each bound.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shift {
    pub log_p: f64,
    /// ∂g/∂a and ∂g/∂b; their sum is g′.
    pub a: f64,
    pub b: f64,
    pub g1: f64,
    pub g2: f64,
    pub g3: f64,
    pub g1_a: f64,
    pub g1_b: f64,
    pub g2_a: f64,
    pub g2_b: f64,
}

impl Link {
    /// Returns the distribution function F at `x`.
    pub fn cdf(self, x: f64) -> f64 {
        match self {
            Self::Logit => 1.0 / (1.0 + (-x).exp()),
            Self::Probit => 0.5 * erfc(-x * FRAC_1_SQRT_2),
        }
    }

    /// Returns F(a) − F(b) for a ≥ b, computed in the tail where the terms do not cancel.
    pub fn between(self, a: f64, b: f64) -> f64 {
        if b > 0.0 { self.cdf(-b) - self.cdf(-a) } else { self.cdf(a) - self.cdf(b) }
    }

    /// Returns the quantile function, the inverse of F, for 0 < `p` < 1.
    pub fn quantile(self, p: f64) -> f64 {
        match self {
            Self::Logit => (p / (1.0 - p)).ln(),
            Self::Probit => -std::f64::consts::SQRT_2 * erfc_inv(2.0 * p),
        }
    }

    /// Returns the density F′ at `x`.
    pub fn density(self, x: f64) -> f64 {
        match self {
            Self::Logit => {
                let tail = (-x.abs()).exp();
                tail / ((1.0 + tail) * (1.0 + tail))
            }
            Self::Probit => normal_density(x),
        }
    }

    /// Returns the probability that one latent rating exceeds another whose location is lower by `difference`. For the
    /// logit link, it is the distribution function of the difference between two logistic variables.
    pub fn superiority(self, difference: f64) -> f64 {
        match self {
            Self::Logit if difference.abs() < 1e-4 => 0.5 + difference / 6.0,
            // For large differences, e^−|δ| has no overflow.
            Self::Logit => {
                let (size, small) = (difference.abs(), (-difference.abs()).exp());
                let above = (1.0 - small - size * small) / (1.0 - small).powi(2);
                let above = if size.is_finite() { above } else { 1.0 };
                if difference > 0.0 { above } else { 1.0 - above }
            }
            Self::Probit => self.cdf(difference * FRAC_1_SQRT_2),
        }
    }

    /// Returns the log-probability of the category between the bounds and its derivatives up to the second order.
    pub fn cell(self, a: f64, b: f64) -> Cell {
        match self {
            Self::Logit => {
                // F(a) − F(b) = F(a) F(−b) (1 − e^(b − a)) avoids cancellation and separates the two bounds.
                // Both tails from one exponential: this is computed for every rating in every step of a fit.
                let tails = |x: f64| {
                    let tail = (-x.abs()).exp();
                    let most = 1.0 / (1.0 + tail);
                    if x >= 0.0 { [most, tail * most] } else { [tail * most, most] }
                };
                let ([below_a, above_a], [below_b, above_b]) = (tails(a), tails(b));
                let narrow = -(b - a).exp_m1();
                let p = below_a * above_b * narrow;
                // In the far tails, log F(x) is x.
                let log_p = if p > 1e-290 { p.ln() } else { a.min(0.0) - b.max(0.0) + narrow.ln() };
                let q = (1.0 - narrow) / narrow;
                let ab = q * (1.0 + q);
                let (aa, bb) = (-below_a * above_a - ab, -below_b * above_b - ab);
                Cell { log_p, a: above_a + q, b: -below_b - q, aa, ab, bb }
            }
            Self::Probit => {
                let p = normal_between(a, b);
                let (fa, fb) = (normal_density(a) / p, normal_density(b) / p);
                Cell {
                    log_p: p.ln(),
                    a: fa,
                    b: -fb,
                    aa: -times(a, fa) - fa * fa,
                    ab: fa * fb,
                    bb: times(b, fb) - fb * fb,
                }
            }
        }
    }

    /// Creates the category between the bounds a and b, for [`Link::shift`].
    pub(super) fn category(self, a: f64, b: f64) -> Category {
        match self {
            Self::Logit => {
                let narrow = -(b - a).exp_m1();
                Category { upper: (-a).exp(), lower: b.exp(), log_width: narrow.ln(), q: (1.0 - narrow) / narrow }
            }
            Self::Probit => Category { upper: a, lower: b, log_width: 0.0, q: 0.0 },
        }
    }

    /// Returns the derivatives after both bounds are lowered by `by`. `up` is e^`by`.
    #[inline]
    pub(super) fn shift(self, category: &Category, by: f64, up: f64) -> Shift {
        match self {
            Self::Logit => {
                let (upper, lower) = (category.upper * up, category.lower / up);
                // F(a) F(−b), F(−a) and F(b).
                let p = 1.0 / ((1.0 + upper) * (1.0 + lower));
                let (above, below) = (upper * (1.0 + lower) * p, lower * (1.0 + upper) * p);
                let (fa, fb) = (above * (1.0 - above), below * (1.0 - below));
                let (slope_a, slope_b) = (fa * (2.0 * above - 1.0), fb * (1.0 - 2.0 * below));
                Shift {
                    log_p: p.ln() + category.log_width,
                    a: above + category.q,
                    b: -below - category.q,
                    g1: above - below,
                    g2: -fa - fb,
                    g3: -slope_a - slope_b,
                    g1_a: -fa,
                    g1_b: -fb,
                    g2_a: -slope_a,
                    g2_b: -slope_b,
                }
            }
            Self::Probit => {
                let (a, b) = (category.upper - by, category.lower - by);
                let cell = self.cell(a, b);
                // The density divided by p, then its first and second derivatives divided by p.
                let (fa, fb) = (cell.a, -cell.b);
                let (fa1, fb1) = (-times(a, fa), -times(b, fb));
                let (fa2, fb2) = (-times(a, fa1) - fa, -times(b, fb1) - fb);
                let aaa = fa2 - 3.0 * fa1 * fa + 2.0 * fa * fa * fa;
                let aab = fa1 * fb - 2.0 * fa * fa * fb;
                let abb = fa * fb1 + 2.0 * fa * fb * fb;
                let bbb = -fb2 - 3.0 * fb * fb1 - 2.0 * fb * fb * fb;
                let (g2_a, g2_b) = (aaa + 2.0 * aab + abb, aab + 2.0 * abb + bbb);
                let (g1_a, g1_b) = (cell.aa + cell.ab, cell.ab + cell.bb);
                Shift {
                    log_p: cell.log_p,
                    a: cell.a,
                    b: cell.b,
                    g1: cell.a + cell.b,
                    g2: g1_a + g1_b,
                    g3: g2_a + g2_b,
                    g1_a,
                    g1_b,
                    g2_a,
                    g2_b,
                }
            }
        }
    }
}

fn normal_density(x: f64) -> f64 {
    const INV_SQRT_2PI: f64 = 0.398_942_280_401_432_7;
    INV_SQRT_2PI * (-0.5 * x * x).exp()
}

/// Returns Φ(a) − Φ(b), computed in the tail where the terms do not cancel.
fn normal_between(a: f64, b: f64) -> f64 {
    let (near, far) = if a + b > 0.0 { (b, a) } else { (-a, -b) };
    0.5 * (erfc(near * FRAC_1_SQRT_2) - erfc(far * FRAC_1_SQRT_2))
}

/// Returns the product, or 0 if the bound is infinite.
fn times(bound: f64, density: f64) -> f64 {
    if bound.is_finite() { bound * density } else { 0.0 }
}
