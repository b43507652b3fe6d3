//! Several neighbouring pixels at once, with ordinary operators over [`pulp`]'s vectors.
//!
//! No operation here is fused or approximate: every machine computes the same bits, whatever the width of its vectors.

use std::ops::{Add, Div, Mul, Sub};

use pulp::Simd;

/// The most pixels that any machine takes at once.
pub(super) const MOST_LANES: usize = 16;

/// 0, 1, 2 …: what each lane is away from the first.
const STEPS: [f32; MOST_LANES] = {
    let mut steps = [0.0; MOST_LANES];
    let mut i = 0;
    while i < MOST_LANES {
        steps[i] = i as f32;
        i += 1;
    }
    steps
};

/// A number for each of several pixels.
#[derive(Clone, Copy)]
pub(super) struct Lanes<S: Simd> {
    simd: S,
    v: S::f32s,
}

/// A yes or no for each of several pixels.
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

    /// 0, 1, 2 …
    #[inline(always)]
    pub fn steps(simd: S) -> Self {
        Lanes { simd, v: bytemuck::cast_slice::<f32, S::f32s>(&Aligned::STEPS.0)[0] }
    }

    /// The first lanes of `slice`, which holds at least as many.
    #[inline(always)]
    pub fn load(simd: S, slice: &[f32]) -> Self {
        Lanes { simd, v: bytemuck::pod_read_unaligned(bytemuck::cast_slice(&slice[..S::F32_LANES])) }
    }

    /// Writes all lanes to the start of `slice`, which holds at least as many.
    #[inline(always)]
    pub fn store(self, slice: &mut [f32]) {
        slice[..S::F32_LANES].copy_from_slice(bytemuck::cast_slice(&[self.v]));
    }

    #[inline(always)]
    pub fn simd(self) -> S {
        self.simd
    }

    /// This number for every lane.
    #[inline(always)]
    pub fn all(self, value: f32) -> Self {
        Self::splat(self.simd, value)
    }

    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        Lanes { v: self.simd.min_f32s(self.v, other.v), ..self }
    }

    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        Lanes { v: self.simd.max_f32s(self.v, other.v), ..self }
    }

    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Lanes { v: self.simd.sqrt_f32s(self.v), ..self }
    }

    /// Where this is below `other`; nowhere for NaN.
    #[inline(always)]
    pub fn below(self, other: Self) -> Mask<S> {
        Mask { simd: self.simd, m: self.simd.less_than_f32s(self.v, other.v) }
    }
}

/// [`STEPS`], where vectors may be.
#[repr(align(64))]
struct Aligned([f32; MOST_LANES]);

impl Aligned {
    const STEPS: &'static Aligned = &Aligned(STEPS);
}

impl<S: Simd> Mask<S> {
    /// Whether any is a yes that is also one in `wanted`.
    #[inline(always)]
    pub fn any(self, wanted: Self) -> bool {
        // Masks are lanes of all ones on some machines and bits on others.
        let both = self.simd.and_m32s(self.m, wanted.m);
        bytemuck::bytes_of(&both) != &[0; size_of::<f32>() * MOST_LANES][..size_of::<S::m32s>()]
    }

    /// `yes` where this says so, `no` elsewhere.
    #[inline(always)]
    pub fn select(self, yes: Lanes<S>, no: Lanes<S>) -> Lanes<S> {
        Lanes { v: self.simd.select_f32s(self.m, yes.v, no.v), ..yes }
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

        impl<S: Simd> $trait<f32> for Lanes<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: f32) -> Self {
                Lanes { v: self.simd.$simd(self.v, self.simd.splat_f32s(other)), ..self }
            }
        }
    };
}

operator!(Add, add, add_f32s);
operator!(Sub, sub, sub_f32s);
operator!(Mul, mul, mul_f32s);
operator!(Div, div, div_f32s);

/// An array of what `of` makes of 0, 1 …: like [`std::array::from_fn`], but always inlined, as code for a machine's
/// vectors must be.
#[inline(always)]
pub(super) fn each<S: Simd, const N: usize>(simd: S, of: impl Fn(usize) -> Lanes<S>) -> [Lanes<S>; N] {
    let mut array = [Lanes::splat(simd, 0.0); N];
    let mut i = 0;
    while i < N {
        array[i] = of(i);
        i += 1;
    }
    array
}

/// `to` and `term` together, number by number.
#[inline(always)]
pub(super) fn add<S: Simd, const N: usize>(to: [Lanes<S>; N], term: impl Fn(usize) -> Lanes<S>) -> [Lanes<S>; N] {
    let mut sum = to;
    for (i, sum) in sum.iter_mut().enumerate() {
        *sum = *sum + term(i);
    }
    sum
}
