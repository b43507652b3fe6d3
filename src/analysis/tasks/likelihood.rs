//! Binomial and beta-binomial likelihoods of answers.

use super::model::{Estimate, Model, Point};

/// Returns the logarithm of the beta-binomial likelihood of these points for F at each of them, without the binomial
/// coefficients and the term of [`ln_total`], for 1/ν = `step`; 0 is the binomial distribution. The probability is
/// Π(ψ + j/ν)·Π(1 − ψ + j/ν)/Π(1 + j/ν), over the correct answers, the others, and all.
pub(super) fn ln_likelihood(
    points: &[Point],
    sigmoids: impl IntoIterator<Item = f64>,
    [guess, lapse]: [f64; 2],
    step: f64,
) -> f64 {
    let mut product = Product { factor: 1.0, ln: 0.0 };
    for (point, sigmoid) in points.iter().zip(sigmoids) {
        let chance = guess + (1.0 - guess - lapse) * sigmoid;
        product.multiply(chance, step, point.correct);
        product.multiply(1.0 - chance, step, point.total - point.correct);
    }
    product.ln + product.factor.ln()
}

/// Returns the logarithm of the denominators of the beta-binomial probabilities, with a negative sign.
pub(super) fn ln_total(points: &[Point], step: f64) -> f64 {
    let mut product = Product { factor: 1.0, ln: 0.0 };
    points.iter().for_each(|point| product.multiply(1.0, step, point.total));
    -(product.ln + product.factor.ln())
}

/// Returns the logarithm of the binomial likelihood of these points, without the coefficients.
pub(super) fn ln_binomial(model: &Model, points: &[Point], at: &Estimate) -> f64 {
    ln_likelihood(points, model.sigmoids(points, at.threshold, at.width), [at.guess, at.lapse], 0.0)
}

/// Returns 1/ν for η; 0 where the beta-binomial distribution is binomial in floating point, as in psignifit.
pub(super) fn step_of(eta: f64) -> f64 {
    let square = eta * eta;
    if square <= 1e-9 { 0.0 } else { square / (1.0 - square) }
}

/// A product whose logarithm is wanted. Few logarithms are computed.
struct Product {
    /// A part of the product, above 1e-140 after each multiplication that leaves it above 0.
    factor: f64,
    /// The logarithm of the rest.
    ln: f64,
}

impl Product {
    /// Multiplies with start·(start + step)·…, `count` factors. Beyond the first 16, their logarithms are summed by the
    /// formula of Euler and Maclaurin.
    fn multiply(&mut self, start: f64, step: f64, count: u32) {
        let direct = count.min(16);
        let mut next = start;
        for _ in 0..direct {
            self.factor *= next;
            next += step;
        }
        if self.factor < 1e-140 {
            self.ln += self.factor.ln();
            self.factor = 1.0;
        }
        let rest = f64::from(count - direct);
        if rest > 0.0 && step == 0.0 {
            self.ln += rest * start.ln();
        } else if rest > 0.0 {
            let end = next + rest * step;
            let (ln, ln_end) = (next.ln(), end.ln());
            let integral = (end * ln_end - next * ln) / step - rest;
            self.ln += integral - (ln_end - ln) / 2.0 + step / 12.0 * (1.0 / end - 1.0 / next);
        }
    }
}
