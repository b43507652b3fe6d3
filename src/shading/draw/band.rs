//! A band of rows: the triangles that cover its pixels, and their light.

use pulp::{Arch, Simd, WithSimd};

use super::lanes::{Lanes, MAX_LANES};
use crate::shading::{
    frame::{Frame, Outline, Planes, coverage},
    number::Number as _,
    shaders::ShaderKernel,
};

/// The weights of a triangle's corners, followed by its light in up to three channels.
pub(super) type Corners = Planes<6>;

/// Buffers that are reused from band to band.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    /// Light, channel by channel, row by row.
    pub light: [Vec<f32>; 3],
    depth: Vec<f64>,
    /// One bit per pixel, set if any triangle covers it.
    covered: Vec<u64>,
    /// The columns that each triangle covers in each row, in drawing order.
    spans: Vec<(u32, u32)>,
}

/// A band to be drawn.
#[derive(Clone, Copy, Debug)]
pub(super) struct Band<'a> {
    pub frame: &'a Frame,
    /// The outline of every triangle.
    pub outlines: &'a [Option<Outline>],
    pub corners: &'a [Corners],
    /// The triangles that overlap the band, in the order of the frame.
    pub triangles: &'a [u32],
    /// The first row; `end` is the row after the last.
    pub first: u32,
    pub end: u32,
    pub background: [f32; 3],
}

impl Band<'_> {
    /// Returns a triangle's outline and the rows of the band that it may cover, as the first row and the row after the
    /// last.
    #[inline(always)]
    fn rows(&self, triangle: u32) -> Option<(&Outline, u32, u32)> {
        let outline = self.outlines[triangle as usize].as_ref()?;
        Some((outline, outline.first.max(self.first), outline.end.min(self.end)))
    }

    /// Finds the spans of the triangles, and fills `C` channels of the rows that they leave open with the background.
    ///
    /// Returns true if any pixel is covered twice. If none is, nothing is hidden, and depths need not be compared.
    #[inline(always)]
    fn begin<const C: usize>(&self, scratch: &mut Scratch) -> bool {
        let width = self.frame.width;
        let (rows, words) = ((self.end - self.first) as usize, width.div_ceil(64) as usize);
        let pixels = rows * width as usize + MAX_LANES;
        scratch.covered.clear();
        scratch.covered.resize(rows * words, 0);
        scratch.spans.clear();
        let mut twice = 0;
        for &triangle in self.triangles {
            let Some((outline, first, end)) = self.rows(triangle) else { continue };
            outline.each_span(
                first..end,
                width,
                #[inline(always)]
                |row, span| {
                    let bits = &mut scratch.covered[(row - self.first) as usize * words..][..words];
                    twice |= cover(bits, span);
                    scratch.spans.push(span);
                },
            );
        }
        for (light, background) in scratch.light.iter_mut().zip(self.background).take(C) {
            light.resize(pixels, background);
            for (row, bits) in light.chunks_exact_mut(width as usize).zip(scratch.covered.chunks_exact(words)) {
                if bits.iter().map(|bits| bits.count_ones()).sum::<u32>() < width {
                    row.fill(background);
                }
            }
        }
        if twice != 0 {
            scratch.depth.clear();
            scratch.depth.resize(pixels, f64::INFINITY);
        }
        twice != 0
    }

    /// Draws the triangles with `shader` into `scratch.light`.
    pub fn paint<const C: usize, R: ShaderKernel<f32, C>>(&self, shader: &R, scratch: &mut Scratch, arch: Arch) {
        arch.dispatch(Paint { shader, band: self, scratch });
    }
}

/// Sets the bits from `left` up to, but not including, `right`. Returns the bits that were already set.
#[inline(always)]
fn cover(bits: &mut [u64], (left, right): (u32, u32)) -> u64 {
    if left >= right {
        return 0;
    }
    let (first, last) = ((left / 64) as usize, ((right - 1) / 64) as usize);
    let mut twice = 0;
    for (word, bits) in (first..).zip(&mut bits[first..=last]) {
        let from = if word == first { u64::MAX << (left % 64) } else { u64::MAX };
        let to = if word == last { u64::MAX >> (63 - (right - 1) % 64) } else { u64::MAX };
        twice |= *bits & from & to;
        *bits |= from & to;
    }
    twice
}

struct Paint<'a, const C: usize, R> {
    shader: &'a R,
    band: &'a Band<'a>,
    scratch: &'a mut Scratch,
}

impl<const C: usize, R: ShaderKernel<f32, C>> WithSimd for Paint<'_, C, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Paint { shader, band, scratch } = self;
        let width = band.frame.width as usize;
        let overlap = band.begin::<C>(scratch);
        let Scratch { light: [a, b, c], depth, spans, .. } = scratch;
        let planes = [&mut a[..], &mut b[..], &mut c[..]];
        let mut spans = spans.iter();
        for &triangle in band.triangles {
            let Some((_, first, end)) = band.rows(triangle) else { continue };
            // Zeros, not uninitialized memory: the compiler may compute with the unused values, and unusual values can
            // be slow.
            let depths = if overlap { coverage::depths(band.frame, triangle as usize) } else { Planes::ZERO };
            let corners = band.corners[triangle as usize];
            let step = corners.at(0, 0).1.map(|step| step as f32);
            for y in first..end {
                let Some(&(left, right)) = spans.next() else { return };
                if left >= right {
                    continue;
                }
                let at = corners.at(left, y).0.map(|value| value as f32);
                let from = (y - band.first) as usize * width + left as usize;
                let mut first = 0;
                while first < right - left {
                    let rest = right - left - first;
                    let pixel = from + first as usize;
                    let count = if rest < S::F32_LANES as u32 { rest } else { S::F32_LANES as u32 };
                    let steps = Lanes::steps(simd) + Lanes::splat(simd, first as f32);
                    let wanted = if overlap {
                        let nearer = nearer(depths.at(left + first, y), count, &mut depth[pixel..]);
                        Lanes::load(simd, &nearer).below(Lanes::splat(simd, 0.0))
                    } else {
                        steps.below(Lanes::splat(simd, (right - left) as f32))
                    };
                    // Hidden pixels are not shaded.
                    if !overlap || Lanes::any(wanted) {
                        let (mut w, mut gouraud) = ([steps; 3], [steps; C]);
                        for k in 0..3 {
                            w[k] = steps.along(step[k], at[k]);
                        }
                        for c in 0..C {
                            gouraud[c] = steps.along(step[3 + c], at[3 + c]);
                        }
                        let values: [Lanes<S>; C] = shader.light(triangle as usize, w, gouraud);
                        for c in 0..C {
                            let pixels = &mut planes[c][pixel..pixel + S::F32_LANES];
                            // All lanes of most vectors are inside.
                            let all = !overlap && rest >= S::F32_LANES as u32;
                            let values = if all {
                                values[c]
                            } else {
                                Lanes::select(wanted, values[c], Lanes::load(simd, pixels))
                            };
                            values.store(pixels);
                        }
                    }
                    first += S::F32_LANES as u32;
                }
            }
        }
    }
}

/// Returns −1 for each of the first `count` pixels at which the triangle is nearer than anything drawn before, and 0
/// for all others; updates `depth`. The triangle's depths along the row are `at`, `at + step` …
#[inline(always)]
fn nearer(([at], [step]): ([f64; 1], [f64; 1]), count: u32, depth: &mut [f64]) -> [f32; MAX_LANES] {
    let mut nearer = [0.0; MAX_LANES];
    let Some(depth) = depth.first_chunk_mut::<MAX_LANES>() else { return nearer };
    for i in 0..MAX_LANES {
        let own = at + step * i as f64;
        let is = own < depth[i] && (i as u32) < count;
        depth[i] = if is { own } else { depth[i] };
        nearer[i] = if is { -1.0 } else { 0.0 };
    }
    nearer
}
