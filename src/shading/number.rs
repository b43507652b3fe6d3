//! The numbers that shaders compute with: one pixel in f64, or several neighboring pixels at once in f32; for one
//! channel or three.

use std::ops::{Add, BitAnd, Div, Mul, Sub};

use glam::DVec3;

/// A constant of a triangle, in the same precision as the pixels.
pub trait Constant: Copy + Send + Sync {
    /// Rounds `value` to this precision.
    fn of(value: f64) -> Self;
}

impl Constant for f64 {
    #[inline(always)]
    fn of(value: f64) -> f64 {
        value
    }
}

impl Constant for f32 {
    #[inline(always)]
    fn of(value: f64) -> f32 {
        value as f32
    }
}

/// A number for each of several pixels, or for a single pixel.
///
/// Functions of numbers are always inlined, because the machine's vector type is known only where the loop over the
/// pixels is.
pub trait Number: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> {
    /// A value that is the same for all pixels.
    type Constant: Constant;
    /// A condition that is true or false for each pixel.
    type Mask: Copy + BitAnd<Output = Self::Mask>;

    /// Returns `value` for every pixel of this number.
    fn all(self, value: Self::Constant) -> Self;

    /// Returns the smaller of two numbers, pixel by pixel.
    fn min(self, other: Self) -> Self;

    /// Returns the larger of two numbers, pixel by pixel.
    fn max(self, other: Self) -> Self;

    /// Returns the square root, pixel by pixel.
    fn sqrt(self) -> Self;

    /// True where this is below `other`; false for NaN.
    fn below(self, other: Self) -> Self::Mask;

    /// True where this is below or equal to `other`; false for NaN.
    fn at_most(self, other: Self) -> Self::Mask;

    /// True if `mask` is true for any pixel.
    fn any(mask: Self::Mask) -> bool;

    /// Returns `yes` where the mask is true and `no` elsewhere.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;

    /// Calls `of` with each pixel's numbers in f64, for functions that have no vector version.
    fn each<const I: usize, const O: usize>(inputs: [Self; I], of: impl Fn([f64; I]) -> [f64; O]) -> [Self; O];

    /// Returns `value` for every pixel of this number.
    #[inline(always)]
    fn of(self, value: f64) -> Self {
        self.all(Self::Constant::of(value))
    }

    /// Multiplies this by a constant.
    #[inline(always)]
    fn times(self, factor: Self::Constant) -> Self {
        self * self.all(factor)
    }

    /// Clamps this to `low`…`high`.
    #[inline(always)]
    fn within(self, low: f64, high: f64) -> Self {
        self.max(self.of(low)).min(self.of(high))
    }
}

impl Number for f64 {
    type Constant = f64;
    type Mask = bool;

    #[inline]
    fn all(self, value: f64) -> f64 {
        value
    }

    fn min(self, other: f64) -> f64 {
        f64::min(self, other)
    }

    fn max(self, other: f64) -> f64 {
        f64::max(self, other)
    }

    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }

    fn below(self, other: f64) -> bool {
        self < other
    }

    fn at_most(self, other: f64) -> bool {
        self <= other
    }

    fn any(mask: bool) -> bool {
        mask
    }

    fn select(mask: bool, yes: f64, no: f64) -> f64 {
        if mask { yes } else { no }
    }

    fn each<const I: usize, const O: usize>(inputs: [f64; I], of: impl Fn([f64; I]) -> [f64; O]) -> [f64; O] {
        of(inputs)
    }
}

/// Returns Σ w_k·values_k.
#[inline(always)]
pub fn weighted<N: Number, const C: usize>(w: [N; 3], values: &[[N::Constant; C]; 3]) -> [N; C] {
    let mut sum = [w[0]; C];
    for c in 0..C {
        sum[c] = w[0].times(values[0][c]) + w[1].times(values[1][c]) + w[2].times(values[2][c]);
    }
    sum
}

/// Returns `to + amount · of`, channel by channel.
#[inline(always)]
pub fn plus<N: Number, const C: usize>(to: [N; C], amount: N, of: &[N::Constant; C]) -> [N; C] {
    let mut sum = to;
    for c in 0..C {
        sum[c] = to[c] + amount.times(of[c]);
    }
    sum
}

/// Returns `yes` where the mask is true and `no` elsewhere, channel by channel.
#[inline(always)]
pub fn select<N: Number, const C: usize>(mask: N::Mask, yes: [N; C], no: [N; C]) -> [N; C] {
    let mut chosen = no;
    for c in 0..C {
        chosen[c] = N::select(mask, yes[c], no[c]);
    }
    chosen
}

/// Returns the scalar product.
#[inline(always)]
pub fn dot<N: Number>(a: [N; 3], b: [N; 3]) -> N {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Returns the unit vector along `v` (zero if `v` is zero) and the length of `v`.
#[inline(always)]
pub fn unit<N: Number>(v: [N; 3]) -> ([N; 3], N) {
    let length = dot(v, v).sqrt();
    let per_length = length.of(1.0) / length.max(length.of(1e-30));
    ([v[0] * per_length, v[1] * per_length, v[2] * per_length], length)
}

/// Returns a vector that is the same for all pixels; `like` determines the number of pixels.
#[inline(always)]
pub fn all<N: Number>(like: N, v: &[N::Constant; 3]) -> [N; 3] {
    [like.all(v[0]), like.all(v[1]), like.all(v[2])]
}

/// Returns x^`exponent`, computed by squaring; `exponent` must be at least 1.
#[inline(always)]
pub fn power<N: Number>(x: N, exponent: u32) -> N {
    let (mut result, mut square, mut rest) = (x, x, exponent - 1);
    while rest > 0 {
        if rest & 1 == 1 {
            result = result * square;
        }
        square = square * square;
        rest >>= 1;
    }
    result
}

/// Which channels are shaded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channels {
    /// Red, green and blue.
    Color,
    /// One channel stands for all channels that have any light; the others are dark. This applies to gray and yellow
    /// images, for example.
    Gray([bool; 3]),
}

impl Channels {
    /// Returns the channels that must be shaded for a picture made of `lights`.
    pub fn of(lights: impl Iterator<Item = DVec3> + Clone) -> Channels {
        let lit = lights.clone().fold([false; 3], |lit, light| {
            let [r, g, b] = light.to_array().map(|l| l != 0.0);
            [lit[0] | r, lit[1] | g, lit[2] | b]
        });
        let first = Channels::Gray(lit).first();
        let mut lights = lights;
        if lights.all(|light| (0..3).all(|c| !lit[c] || light[c] == light[first])) {
            Channels::Gray(lit)
        } else {
            Channels::Color
        }
    }

    /// Returns the first channel that is shaded.
    fn first(self) -> usize {
        match self {
            Channels::Color => 0,
            Channels::Gray(lit) => lit.iter().position(|lit| *lit).unwrap_or(0),
        }
    }

    /// Returns the `C` channels of `light` that are shaded.
    pub fn pick<T: Constant, const C: usize>(self, light: DVec3) -> [T; C] {
        let (light, first) = (light.to_array(), self.first());
        std::array::from_fn(|c| T::of(light[(first + c) % 3]))
    }
}
