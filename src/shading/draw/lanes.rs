//! Computes several neighboring pixels at once, in [`pulp`]'s vectors.
//!
//! No operation here is fused or approximate: every machine computes the same bits, regardless of its vector width.

use std::ops::{Add, BitAnd, Div, Mul, Sub};

use pulp::Simd;

use crate::shading::number::Number;

/// The largest number of pixels that any machine processes at once.
pub(super) const MAX_LANES: usize = 16;

/// A number for each of several pixels.
#[derive(Clone, Copy)]
pub(super) struct Lanes<S: Simd> {
    simd: S,
    v: S::f32s,
}

/// A condition that is true or false for each of several pixels.
#[derive(Clone, Copy)]
pub(super) struct Mask<S: Simd> {
    simd: S,
    m: S::m32s,
}

impl<S: Simd> Lanes<S> {
    #[inline(always)]
    pub fn splat(simd: S, value: f32) -> Self {
        Lanes { simd, v: simd.splat_f32s(value) }
    }

    /// Returns 0, 1, 2 …: the distance of each pixel from the first.
    #[inline(always)]
    pub fn steps(simd: S) -> Self {
        let mut steps = [0.0; MAX_LANES];
        for (i, step) in steps.iter_mut().enumerate() {
            *step = i as f32;
        }
        Lanes::load(simd, &steps)
    }

    /// Reads all lanes from the start of `slice`, which must be long enough.
    #[inline(always)]
    pub fn load(simd: S, slice: &[f32]) -> Self {
        Lanes { simd, v: bytemuck::pod_read_unaligned(bytemuck::cast_slice(&slice[..S::F32_LANES])) }
    }

    /// Writes all lanes to the start of `slice`, which must be long enough.
    #[inline(always)]
    pub fn store(self, slice: &mut [f32]) {
        slice[..S::F32_LANES].copy_from_slice(bytemuck::cast_slice(&[self.v]));
    }

    /// Returns `self · step + at`.
    #[inline(always)]
    pub fn along(self, step: f32, at: f32) -> Self {
        self.times(step) + self.all(at)
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident, $simd:ident) => {
        impl<S: Simd> $trait for Lanes<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Lanes { v: self.simd.$simd(self.v, other.v), ..self }
            }
        }
    };
}

operator!(Add, add, add_f32s);
operator!(Sub, sub, sub_f32s);
operator!(Mul, mul, mul_f32s);
operator!(Div, div, div_f32s);

impl<S: Simd> BitAnd for Mask<S> {
    type Output = Self;

    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Mask { m: self.simd.and_m32s(self.m, other.m), ..self }
    }
}

impl<S: Simd> Number for Lanes<S> {
    type Constant = f32;
    type Mask = Mask<S>;

    #[inline(always)]
    fn all(self, value: f32) -> Self {
        Self::splat(self.simd, value)
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Lanes { v: self.simd.min_f32s(self.v, other.v), ..self }
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Lanes { v: self.simd.max_f32s(self.v, other.v), ..self }
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Lanes { v: self.simd.sqrt_f32s(self.v), ..self }
    }

    #[inline(always)]
    fn below(self, other: Self) -> Mask<S> {
        Mask { simd: self.simd, m: self.simd.less_than_f32s(self.v, other.v) }
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> Mask<S> {
        Mask { simd: self.simd, m: self.simd.less_than_or_equal_f32s(self.v, other.v) }
    }

    #[inline(always)]
    fn any(mask: Mask<S>) -> bool {
        // On some machines, a mask is a lane of ones or zeros per pixel; on others, a bit per pixel.
        bytemuck::bytes_of(&mask.m) != &[0; size_of::<f32>() * MAX_LANES][..size_of::<S::m32s>()]
    }

    #[inline(always)]
    fn select(mask: Mask<S>, yes: Self, no: Self) -> Self {
        Lanes { v: mask.simd.select_f32s(mask.m, yes.v, no.v), ..yes }
    }

    #[inline(always)]
    fn each<const I: usize, const O: usize>(inputs: [Self; I], of: impl Fn([f64; I]) -> [f64; O]) -> [Self; O] {
        let mut numbers = [[0.0; MAX_LANES]; I];
        for (numbers, input) in numbers.iter_mut().zip(inputs) {
            input.store(numbers);
        }
        let mut results = [[0.0; MAX_LANES]; O];
        for lane in 0..S::F32_LANES {
            for (results, result) in results.iter_mut().zip(of(numbers.map(|numbers| f64::from(numbers[lane])))) {
                results[lane] = result as f32;
            }
        }
        let mut lanes = [inputs[0]; O];
        for (lanes, results) in lanes.iter_mut().zip(&results) {
            *lanes = Lanes::load(inputs[0].simd, results);
        }
        lanes
    }
}
