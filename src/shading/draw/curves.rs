//! Encodes 16 light values at once as 8-bit codes, on machines with AVX-512, whose registers can hold the coefficients
//! of a curve.

use std::arch::x86_64::__m512;

use nalgebra::{DMatrix, DVector};
use pulp::{cast, x86::V4};

use crate::light::ChannelQuantizer;

/// A polynomial for each half of an octave of light. It gives the code before rounding.
///
/// Where the polynomial is near the middle between two codes, the quantizer decides; elsewhere, rounding gives its code
/// exactly.
#[derive(Clone, Debug)]
pub(super) struct Curves {
    simd: V4,
    /// The coefficients of equal power of all segments. A segment's place is the lowest bits of an f32's exponent and
    /// the highest bit of its mantissa.
    coefficients: [[f32; SEGMENTS]; DEGREE + 1],
    /// The light at which the first segment begins; its code is 0.
    least: f32,
}

/// The number of segments: as many numbers as two registers hold.
const SEGMENTS: usize = 32;

const DEGREE: usize = 4;

/// The number of lower bits of an f32 that say where in its segment it lies.
const LOWER: u32 = 22;

/// The distance from the middle between two codes within which the quantizer decides.
const NEAR: f32 = 1.0 / 1024.0;

impl Curves {
    /// The number of light values that are encoded at once.
    pub const LANES: usize = 16;

    /// Makes the curves of `quantizer`, whose codes begin above `least`, a power of two; `None` if this machine lacks
    /// AVX-512, or if the curves do not give the quantizer's codes.
    pub fn new(quantizer: &ChannelQuantizer, least: f32) -> Option<Curves> {
        let simd = V4::try_new()?;
        let (first, last) = (least.to_bits() >> LOWER, 1f32.to_bits() >> LOWER);
        if (last - first) as usize >= SEGMENTS {
            return None;
        }
        let mut curves = Curves { simd, coefficients: [[0.0; SEGMENTS]; DEGREE + 1], least };
        // At 1, the largest code.
        curves.coefficients[0][last as usize % SEGMENTS] = u8::MAX.into();
        for segment in first..last {
            let fitted = fit(quantizer, segment)?;
            for (of_power, coefficient) in curves.coefficients.iter_mut().zip(fitted) {
                of_power[segment as usize % SEGMENTS] = coefficient;
            }
        }
        Some(curves)
    }

    /// Encodes light values; `exact` decides where rounding does not. The rest after the last 16 values is left out.
    #[inline(always)]
    pub fn codes(&self, light: &[f32], codes: &mut [u32], exact: impl Fn(f32) -> u32) {
        let avx = self.simd.avx512f;
        let (least, one) = (avx._mm512_set1_ps(self.least), avx._mm512_set1_ps(1.0));
        let (middle, near) = (avx._mm512_set1_ps(MIDDLE), avx._mm512_set1_ps(0.5 - NEAR));
        let lower = avx._mm512_castps_si512(avx._mm512_set1_ps(f32::from_bits((1 << LOWER) - 1)));
        let halves: [[__m512; 2]; DEGREE + 1] = cast(self.coefficients);
        let (light, _) = light.as_chunks::<{ Curves::LANES }>();
        for (light, codes) in light.iter().zip(codes.as_chunks_mut::<{ Curves::LANES }>().0) {
            // NaN becomes `least`.
            let clamped = avx._mm512_min_ps(avx._mm512_max_ps(cast(*light), least), one);
            let bits = avx._mm512_castps_si512(clamped);
            let segment = avx._mm512_srli_epi32::<LOWER>(bits);
            let place = avx._mm512_or_si512(avx._mm512_and_si512(bits, lower), avx._mm512_castps_si512(one));
            let place = avx._mm512_sub_ps(avx._mm512_castsi512_ps(place), middle);
            let mut sum = avx._mm512_permutex2var_ps(halves[DEGREE][0], segment, halves[DEGREE][1]);
            for power in (0..DEGREE).rev() {
                let coefficient = avx._mm512_permutex2var_ps(halves[power][0], segment, halves[power][1]);
                sum = avx._mm512_fmadd_ps(sum, place, coefficient);
            }
            let rounded = avx._mm512_cvtps_epi32(sum);
            *codes = cast(rounded);
            let off = avx._mm512_abs_ps(avx._mm512_sub_ps(sum, avx._mm512_cvtepi32_ps(rounded)));
            let mut undecided = avx._mm512_cmplt_ps_mask(near, off);
            while undecided != 0 {
                let lane = undecided.trailing_zeros() as usize;
                codes[lane] = exact(light[lane]);
                undecided &= undecided - 1;
            }
        }
    }
}

/// Places in a segment go from 1 to 1.5; polynomials are about their middle.
const MIDDLE: f32 = 1.25;

/// Returns the coefficients for a segment, the constant first, fitted to the thresholds in and beside it; `None` if they
/// do not give the quantizer's codes.
fn fit(quantizer: &ChannelQuantizer, segment: u32) -> Option<[f32; DEGREE + 1]> {
    let (begin, end) = (f32::from_bits(segment << LOWER), f32::from_bits((segment + 1) << LOWER));
    let code = |light: f32| u32::from(quantizer.code(light));
    let (before, last) = (code(begin), code(end.next_down()));
    let mut fitted = [0.0; DEGREE + 1];
    fitted[0] = before as f32;
    let inside = before + 1..last + 1;
    if !inside.is_empty() {
        // At least as many thresholds as coefficients, if need be from beside the segment.
        let (mut first, mut last) = (before as u16 + 1, last as u16);
        while usize::from(last - first) < DEGREE {
            (first, last) = ((first - 1).max(1), (last + 1).min(u8::MAX.into()));
        }
        let used: Vec<u16> = (first..=last).collect();
        let place = |code: u16| {
            let share = (f64::from(quantizer.threshold(code)) - f64::from(begin)) / f64::from(end - begin);
            1.0 + share / 2.0 - f64::from(MIDDLE)
        };
        let powers = DMatrix::from_fn(used.len(), DEGREE + 1, |row, power| place(used[row]).powi(power as i32));
        let middles = DVector::from_fn(used.len(), |row, _| f64::from(used[row]) - 0.5);
        let solved = powers.svd(true, true).solve(&middles, 0.0).ok()?;
        for (to, from) in fitted.iter_mut().zip(solved.iter()) {
            *to = *from as f32;
        }
    }
    let value = |light: f32| {
        let place = f32::from_bits(light.to_bits() & ((1 << LOWER) - 1) | 1f32.to_bits()) - MIDDLE;
        fitted.iter().rev().fold(0.0, |sum, coefficient| sum * place + coefficient)
    };
    // The curve rises and passes near the middle between two codes at every threshold, so it gives the quantizer's codes
    // between them too.
    let is_near = |code: u32| {
        let threshold = quantizer.threshold(code as u16);
        [threshold, threshold.next_down()].iter().all(|light| (value(*light) - code as f32 + 0.5).abs() < NEAR / 2.0)
    };
    let is_right = |light: f32| (value(light) - code(light) as f32).abs() < 0.5 + NEAR / 2.0;
    let samples = (0..=64).map(|i| value(begin + (end.next_down() - begin) * (i as f32 / 64.0)));
    let rises = samples.clone().zip(samples.skip(1)).all(|(a, b)| a <= b);
    (rises && is_right(begin) && is_right(end.next_down()) && inside.clone().all(is_near)).then_some(fitted)
}
