//! I_n(u), the profile of a ramp from 0 to 1: Bangay eq. 1. In the scanned paper, the labels of the equation's rows are
//! off by one; here, n = 1 is the linear ramp.
//!
//! For every whole n ≥ 1, I_n is the regularized incomplete beta function I_u(n, n),
//! `(2n−1)·C(2n−2, n−1)·∫₀ᵘ s^(n−1)(1−s)^(n−1) ds`: n = 1 is `u`, n = 2 is `3u²−2u³`, n = 3 is
//! `10u³−15u⁴+6u⁵`.
//!
//! The terms in powers of u alternate in sign and cancel (at n = 32 no digit of an f64 survives). This module therefore
//! uses, on 0 ≤ u ≤ ½, `I_n(u) = uⁿ · Σ_{k<n} C(n−1+k, k)·(1−u)^k`, the probability of n successes before n failures,
//! in which every term is positive. The upper half follows from I_n(u) = 1 − I_n(1−u). The relative error is then a few
//! n·ε everywhere.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Continuity depth n of Bangay eq. 1: n − 1 derivatives of the interpolation vanish at both ends of
/// the ramp.
///
/// Commands and files write it as `1` … `32` or `inf`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Depth {
    /// A polynomial of degree 2n − 1, n from 1 (linear) to [`Depth::MAX_FINITE`].
    Finite(u8),
    /// Bangay's n = ∞, a scaled tanh. It is not the limit of the finite depths, which is a step.
    Infinite,
}

impl Depth {
    /// The largest finite depth that is evaluated to within 1e-12.
    pub const MAX_FINITE: u8 = 32;
}

/// The error for a value that is not a [`Depth`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("depth {depth} {problem}; expected a whole number from 1 to 32, or inf")]
pub struct DepthError {
    depth: String,
    /// The problem, as a phrase that begins with a verb.
    pub problem: &'static str,
}

impl fmt::Display for Depth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Depth::Finite(n) => n.fmt(f),
            Depth::Infinite => "inf".fmt(f),
        }
    }
}

impl FromStr for Depth {
    type Err = DepthError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let text = text.trim();
        match (text, text.parse::<i128>()) {
            ("inf", _) => Ok(Depth::Infinite),
            (_, Ok(n)) if (1..=Self::MAX_FINITE.into()).contains(&n) => Ok(Depth::Finite(n as u8)),
            (_, Ok(_)) => Err(DepthError { depth: text.to_owned(), problem: "is outside 1…32" }),
            _ => Err(DepthError { depth: format!("{text:?}"), problem: "is not a whole number" }),
        }
    }
}

impl Serialize for Depth {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Depth::Finite(n) => serializer.serialize_u8(*n),
            Depth::Infinite => serializer.serialize_str("inf"),
        }
    }
}

impl<'de> Deserialize<'de> for Depth {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged, expecting = "expected a whole number from 1 to 32, or inf")]
        enum Written {
            Number(f64),
            Text(String),
        }

        match Written::deserialize(deserializer)? {
            // TOML has a float called inf; it can only mean one depth.
            Written::Number(n) if n == f64::INFINITY => Ok(Depth::Infinite),
            Written::Number(n) => n.to_string().parse(),
            Written::Text(text) => text.parse(),
        }
        .map_err(serde::de::Error::custom)
    }
}

/// Steepness k of the infinite depth as Bangay prints it, `(1 + tanh(5(u − ½)))/2`.
///
/// The curve does not reach the plateaus: I_∞(0) = 1/(1+e⁵) ≈ 0.00669, a step of up to 0.84 8-bit codes on a ramp from
/// ¼ to ¾. With k = 10, `(1 + tanh(5(2u−1)))/2`, the residual is 4.54e-5, "below the quantization error", as Bangay's
/// text says.
pub const TANH_K: f64 = 5.0;

impl Depth {
    /// Returns I_n at `u`, the position across the ramp: 0 for u < 0 (the lower plateau), 1 for u ≥ 1 (the upper
    /// plateau). The value is within 1e-12 of exact for every depth, and I_n(u) + I_n(1−u) = 1 in between.
    ///
    /// The infinite depth has the steepness `k` (> 0), by default [`TANH_K`], which a finite one ignores. It jumps at both
    /// ends, from 0 to 1/(1+e^k) at u = 0 and back to 1 at u = 1.
    #[inline]
    pub fn interpolation(self, u: f64, k: f64) -> f64 {
        if u >= 1.0 {
            1.0
        } else if u > 0.5 {
            // 1 − u is exact here, so using the symmetry costs no precision.
            1.0 - self.lower_half(1.0 - u, k)
        } else if u >= 0.0 {
            self.lower_half(u, k)
        } else {
            0.0
        }
    }

    /// I_n on 0…½.
    #[inline]
    fn lower_half(self, u: f64, k: f64) -> f64 {
        match self {
            Self::Finite(n) => {
                let (mut term, mut sum) = (1.0, 1.0);
                // C(n−1+k, k)·(1−u)^k from the term before it.
                for k in 1..n {
                    term *= (1.0 - u) * (f64::from(n - 1 + k) / f64::from(k));
                    sum += term;
                }
                power(u, usize::from(n)) * sum
            }
            // (1 + tanh(k(u−½)))/2, in a form that does not cancel below u = ½.
            Self::Infinite => 1.0 / (1.0 + (2.0 * k * (0.5 - u)).exp()),
        }
    }
}

/// x^n by squaring. The precision of `f64::powi` is unspecified; this gives the same result on every machine.
#[inline]
pub(crate) fn power(x: f64, n: usize) -> f64 {
    let (mut result, mut square, mut n) = (1.0, x, n);
    while n > 0 {
        if n & 1 == 1 {
            result *= square;
        }
        square *= square;
        n >>= 1;
    }
    result
}
