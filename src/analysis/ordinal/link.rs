//! Cumulative links: the distribution F of P(Y ≤ j) = F(θ_j − xβ), and the derivatives of a category's log-probability
//! log(F(upper) − F(lower)) by its two bounds.

use std::f64::consts::FRAC_1_SQRT_2;

use statrs::function::erf::{erfc, erfc_inv};

use crate::light::names::named;

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

/// The log-probability of a category between two bounds, a above b, and its derivatives. Without a probability above
/// 0, `log_p` is −∞ or NaN and nothing else means anything.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Cell {
    pub log_p: f64,
    pub a: f64,
    pub b: f64,
    pub aa: f64,
    pub ab: f64,
    pub bb: f64,
}

/// What a shift of both bounds by t does: derivatives of g(t) = log(F(a + t) − F(b + t)) at 0, and how the first two
/// change with each bound.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Shift {
    pub log_p: f64,
    /// ∂g/∂a and ∂g/∂b, whose sum is g′.
    pub a: f64,
    pub b: f64,
    pub g2: f64,
    pub g3: f64,
    pub g1_a: f64,
    pub g1_b: f64,
    pub g2_a: f64,
    pub g2_b: f64,
}

impl Link {
    /// The distribution function F.
    pub fn cdf(self, x: f64) -> f64 {
        match self {
            Self::Logit => 1.0 / (1.0 + (-x).exp()),
            Self::Probit => 0.5 * erfc(-x * FRAC_1_SQRT_2),
        }
    }

    /// The quantile function, the inverse of F, for 0 < p < 1.
    pub fn quantile(self, p: f64) -> f64 {
        match self {
            Self::Logit => (p / (1.0 - p)).ln(),
            Self::Probit => -std::f64::consts::SQRT_2 * erfc_inv(2.0 * p),
        }
    }

    /// The density F′.
    pub fn density(self, x: f64) -> f64 {
        match self {
            Self::Logit => {
                let tail = (-x.abs()).exp();
                tail / ((1.0 + tail) * (1.0 + tail))
            }
            Self::Probit => normal_density(x),
        }
    }

    /// Log-probability and its derivatives to the second order.
    pub(super) fn cell(self, a: f64, b: f64) -> Cell {
        match self {
            Self::Logit => {
                let logit = Logistic::new(a, b);
                let r = logit.q * (1.0 + logit.q);
                Cell {
                    log_p: logit.log_p,
                    a: logit.a.above + logit.q,
                    b: -logit.b.below - logit.q,
                    aa: -logit.a.density() - r,
                    ab: r,
                    bb: -logit.b.density() - r,
                }
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
}

/// The logistic distribution at a point: below it, and above it.
#[derive(Clone, Copy)]
struct Tails {
    below: f64,
    above: f64,
}

impl Tails {
    #[inline]
    fn new(x: f64) -> Self {
        let tail = (-x.abs()).exp();
        let most = 1.0 / (1.0 + tail);
        let least = tail * most;
        if x >= 0.0 { Self { below: most, above: least } } else { Self { below: least, above: most } }
    }

    fn density(self) -> f64 {
        self.below * self.above
    }
}

/// F(a) − F(b) = F(a) F(−b) (1 − e^(b − a)) for the logistic distribution: no cancellation, and the bounds enter apart.
struct Logistic {
    a: Tails,
    b: Tails,
    log_p: f64,
    /// 1 / (e^(a − b) − 1): what the width of the category adds.
    q: f64,
}

impl Logistic {
    #[inline]
    fn new(a: f64, b: f64) -> Self {
        let (upper, lower) = (Tails::new(a), Tails::new(b));
        let narrow = -(b - a).exp_m1();
        let p = upper.below * lower.above * narrow;
        let log_p = if p > 1e-290 { p.ln() } else { log_below(a) + log_below(-b) + narrow.ln() };
        Self { a: upper, b: lower, log_p, q: (1.0 - narrow) / narrow }
    }
}

/// log F(x) of the logistic distribution.
fn log_below(x: f64) -> f64 {
    if x >= 0.0 { -(-x).exp().ln_1p() } else { x - x.exp().ln_1p() }
}

fn normal_density(x: f64) -> f64 {
    const INV_SQRT_2PI: f64 = 0.398_942_280_401_432_7;
    INV_SQRT_2PI * (-0.5 * x * x).exp()
}

/// Φ(a) − Φ(b), taken in the tail where it does not cancel.
fn normal_between(a: f64, b: f64) -> f64 {
    let (near, far) = if a + b > 0.0 { (b, a) } else { (-a, -b) };
    0.5 * (erfc(near * FRAC_1_SQRT_2) - erfc(far * FRAC_1_SQRT_2))
}

/// The product, 0 where the bound is infinite.
fn times(bound: f64, density: f64) -> f64 {
    if bound.is_finite() { bound * density } else { 0.0 }
}

/// [`Shift`] with the probit link.
pub(super) fn normal_shift(a: f64, b: f64) -> Shift {
    let p = normal_between(a, b);
    let (fa, fb) = (normal_density(a) / p, normal_density(b) / p);
    // First and second derivatives of the density, over p.
    let (fa1, fb1) = (-times(a, fa), -times(b, fb));
    let (fa2, fb2) = (-times(a, fa1) - fa, -times(b, fb1) - fb);
    let (aa, ab, bb) = (fa1 - fa * fa, fa * fb, -fb1 - fb * fb);
    let aaa = fa2 - 3.0 * fa1 * fa + 2.0 * fa * fa * fa;
    let aab = fa1 * fb - 2.0 * fa * fa * fb;
    let abb = fa * fb1 + 2.0 * fa * fb * fb;
    let bbb = -fb2 - 3.0 * fb * fb1 - 2.0 * fb * fb * fb;
    let (g2_a, g2_b) = (aaa + 2.0 * aab + abb, aab + 2.0 * abb + bbb);
    Shift {
        log_p: p.ln(),
        a: fa,
        b: -fb,
        g2: aa + 2.0 * ab + bb,
        g3: g2_a + g2_b,
        g1_a: aa + ab,
        g1_b: ab + bb,
        g2_a,
        g2_b,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: f64, expected: f64, what: &str) {
        assert!((found - expected).abs() < 2e-5 * (1.0 + expected.abs()), "{what}: {found}, expected {expected}");
    }

    #[test]
    fn far_tails_keep_their_digits() {
        // pnorm(-10) - pnorm(-11), R 4.2.2.
        close(Link::Probit.cell(11.0, 10.0).log_p, 7.619_661_958_203_077e-24_f64.ln(), "probit");
        // log(F(800) − F(799)) = −799 + log(1 − 1/e) for the logistic distribution.
        let expected = -799.0 + (1.0 - (-1.0_f64).exp()).ln();
        close(Link::Logit.cell(800.0, 799.0).log_p, expected, "logit");
        for p in [1e-12, 0.2, 0.5, 0.975] {
            for link in [Link::Logit, Link::Probit] {
                assert!((link.cdf(link.quantile(p)) / p - 1.0).abs() < 1e-9, "{link} {p}");
            }
        }
    }
}
