//! I_n and its integral over several pixels at once.

use pulp::Simd;

use super::lanes::{Lanes, MOST_LANES};
use crate::{
    light::{Depth, Interpolation},
    shading::boundary::Blend,
};

/// A function on 0…1, within 5e-7.
#[derive(Clone, Debug)]
pub(super) enum Curve {
    /// v^power·(c₀ + c₁v + c₂v²), power 1…4.
    Polynomial { power: u8, c: [f32; 3] },
    /// Straight lines between values at equal distances.
    Table(Box<[f32; ENTRIES]>),
}

/// Pieces of a table: enough for n = 32, whose slope changes the fastest.
const PIECES: usize = 4096;

/// One more for the far end, and one behind it.
const ENTRIES: usize = PIECES + 2;

impl Curve {
    /// I_n as [`Blend`] has it.
    pub fn blend(depth: Depth) -> Curve {
        match depth {
            Depth::Finite(1) => Curve::Polynomial { power: 1, c: [1.0, 0.0, 0.0] },
            Depth::Finite(2) => Curve::Polynomial { power: 2, c: [3.0, -2.0, 0.0] },
            Depth::Finite(3) => Curve::Polynomial { power: 3, c: [10.0, -15.0, 6.0] },
            _ => {
                let blend = Blend::new(depth);
                Curve::table(|v| blend.value(v))
            }
        }
    }

    /// ∫₀ᵛ I_n, which is Ψ_n(1−v) of [`Blend::rest`].
    pub fn rest(depth: Depth) -> Curve {
        match depth {
            Depth::Finite(1) => Curve::Polynomial { power: 2, c: [0.5, 0.0, 0.0] },
            Depth::Finite(2) => Curve::Polynomial { power: 3, c: [1.0, -0.5, 0.0] },
            Depth::Finite(3) => Curve::Polynomial { power: 4, c: [2.5, -3.0, 1.0] },
            _ => {
                let blend = Blend::new(depth);
                Curve::table(|v| blend.rest(1.0 - v))
            }
        }
    }

    fn table(of: impl Fn(f64) -> f64) -> Curve {
        let mut table = Box::new([0.0; ENTRIES]);
        for (i, value) in table.iter_mut().enumerate() {
            *value = of((i as f64 / PIECES as f64).min(1.0)) as f32;
        }
        Curve::Table(table)
    }

    /// Its value at `v` within 0…1.
    #[inline(always)]
    pub fn value<S: Simd>(&self, v: Lanes<S>) -> Lanes<S> {
        match self {
            Curve::Polynomial { power, c } => {
                let square = v * v;
                let lead = match power {
                    1 => v,
                    2 => square,
                    3 => square * v,
                    _ => square * square,
                };
                lead * (square * c[2] + v * c[1] + c[0])
            }
            Curve::Table(table) => {
                let mut at = [0.0; MOST_LANES];
                (v * PIECES as f32).store(&mut at);
                look_up(table, &mut at);
                Lanes::load(v.simd(), &at)
            }
        }
    }
}

/// Not inlined: most depths are polynomials, whose code is the better without this amid it.
#[cold]
#[inline(never)]
fn look_up(table: &[f32; ENTRIES], at: &mut [f32; MOST_LANES]) {
    for at in at {
        // Casts from f32 saturate, and take NaN for 0.
        let i = (*at as usize).min(PIECES);
        *at = table[i] + (table[i + 1] - table[i]) * (*at - i as f32);
    }
}

/// I_n as printed: for n = ∞ it jumps at both ends.
#[derive(Clone, Debug)]
pub(super) struct Step {
    inside: Curve,
    jumps: bool,
}

impl Step {
    pub fn new(depth: Depth) -> Step {
        let step = Interpolation::new(depth);
        let jumps = depth == Depth::Infinite;
        // Just before the jump at 1.
        let inside = if jumps { Curve::table(|u| step.value(u.min(1.0 - 1e-12))) } else { Curve::blend(depth) };
        Step { inside, jumps }
    }

    /// Its value anywhere.
    #[inline(always)]
    pub fn value<S: Simd>(&self, u: Lanes<S>) -> Lanes<S> {
        let (zero, one) = (u.all(0.0), u.all(1.0));
        let inside = self.inside.value(u.max(zero).min(one));
        if !self.jumps {
            return inside;
        }
        u.below(zero).select(zero, u.below(one).select(inside, one))
    }
}
