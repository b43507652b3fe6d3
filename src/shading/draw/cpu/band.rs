//! A band of rows: which triangles cover which of its pixels, and their light.

use pulp::{Arch, Simd, WithSimd};

use super::{
    lanes::{Lanes, MOST_LANES, Mask},
    outline::{Outline, ROWS},
    plane::Planes,
    prepared::Prepared,
};

/// A few neighbouring pixels of a row, of which the first `count` are wanted.
#[derive(Clone, Copy)]
pub(super) struct Chunk<S: Simd> {
    /// How far each is from the row's first pixel.
    pub steps: Lanes<S>,
    /// The same for the first of them.
    pub first: u32,
    pub count: u32,
    /// Which are wanted and belong to the row.
    pub wanted: Mask<S>,
}

/// A shader: the light along a row of pixels of a triangle.
pub(super) trait Rows<const C: usize>: Sync {
    /// What is constant along the row.
    type Row: Copy;

    /// The row of `triangle` whose first pixel is in column `x` of row `y`.
    fn row<S: Simd>(&self, simd: S, triangle: u32, x: u32, y: u32) -> Self::Row;

    /// The light of a few of its pixels; whatever it likes for those not wanted.
    fn light<S: Simd>(&self, row: &Self::Row, chunk: Chunk<S>) -> [Lanes<S>; C];
}

/// Memory that one thread reuses from band to band.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    /// Light, channel by channel, row by row.
    pub light: [Vec<f32>; 3],
    depth: Vec<f64>,
    /// One bit a pixel: whether any triangle has it.
    covered: Vec<u64>,
    /// Columns of every row of every triangle, in the order in which they are drawn.
    spans: Vec<(u32, u32)>,
}

/// Which rows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Band {
    pub first: u32,
    pub end: u32,
}

impl Band {
    /// Those of them that a triangle may have.
    #[inline(always)]
    fn rows(self, outline: &Outline) -> (u32, u32) {
        let first = if outline.first > self.first { outline.first } else { self.first };
        (first, if outline.end < self.end { outline.end } else { self.end })
    }
}

/// A band to be painted, and the triangles that reach into it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Work<'a> {
    pub prepared: &'a Prepared<'a>,
    pub band: Band,
    pub triangles: &'a [u32],
    /// The vectors to do it with.
    pub arch: Arch,
}

impl Scratch {
    /// Finds the spans of `triangles` in `band`, and fills `C` channels with the background.
    ///
    /// Returns whether any pixel is covered twice: if not, nothing is hidden and depth need not be looked at.
    #[inline(always)]
    fn begin<const C: usize>(&mut self, work: Work<'_>) -> bool {
        let Work { prepared, band, triangles, .. } = work;
        let width = prepared.width();
        let pixels = (band.end - band.first) as usize * width as usize;
        for (light, background) in self.light.iter_mut().zip(prepared.background).take(C) {
            light.clear();
            light.resize(pixels + MOST_LANES, background);
        }
        let words = width.div_ceil(64) as usize;
        self.covered.clear();
        self.covered.resize((band.end - band.first) as usize * words, 0);
        self.spans.clear();
        let mut twice = 0;
        for &triangle in triangles {
            let outline = &prepared.outlines[triangle as usize];
            let (first, end) = band.rows(outline);
            for block in (first..end).step_by(ROWS) {
                let (left, right) = outline.spans(block, width);
                for (i, row) in (block..end).take(ROWS).enumerate() {
                    let bits = &mut self.covered[(row - band.first) as usize * words..][..words];
                    twice |= cover(bits, left[i], right[i]);
                    self.spans.push((left[i], right[i]));
                }
            }
        }
        if twice != 0 {
            self.depth.clear();
            self.depth.resize(pixels + MOST_LANES, f64::INFINITY);
        }
        twice != 0
    }
}

/// Sets the bits from `left` to before `right`; returns those that were set before.
#[inline(always)]
fn cover(bits: &mut [u64], left: u32, right: u32) -> u64 {
    if left >= right {
        return 0;
    }
    let (first, last) = ((left / 64) as usize, ((right - 1) / 64) as usize);
    let (from, to) = (u64::MAX << (left % 64), u64::MAX >> (63 - (right - 1) % 64));
    if first == last {
        let twice = bits[first] & from & to;
        bits[first] |= from & to;
        return twice;
    }
    let mut twice = (bits[first] & from) | (bits[last] & to);
    bits[first] |= from;
    bits[last] |= to;
    for word in &mut bits[first + 1..last] {
        twice |= *word;
        *word = u64::MAX;
    }
    twice
}

/// Draws the triangles of a band: their light comes to lie in `scratch.light`.
pub(super) fn paint<const C: usize, R: Rows<C>>(shader: &R, work: Work<'_>, scratch: &mut Scratch) {
    work.arch.dispatch(Paint { shader, work, scratch });
}

struct Paint<'a, const C: usize, R> {
    shader: &'a R,
    work: Work<'a>,
    scratch: &'a mut Scratch,
}

impl<const C: usize, R: Rows<C>> WithSimd for Paint<'_, C, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Paint { shader, work, scratch } = self;
        let Work { prepared, band, triangles, .. } = work;
        let width = prepared.width() as usize;
        let overlap = scratch.begin::<C>(work);
        let Scratch { light: [a, b, c], depth, spans, .. } = scratch;
        let planes = [&mut a[..], &mut b[..], &mut c[..]];
        let mut spans = spans.iter();
        for &triangle in triangles {
            // Zeros, not nothing: a compiler may compute with what is not there, and what lies in its place can be slow.
            let depths = if overlap { prepared.depths(triangle) } else { Planes::ZERO };
            let (first, end) = band.rows(&prepared.outlines[triangle as usize]);
            for y in first..end {
                let Some(&(left, right)) = spans.next() else { return };
                if left >= right {
                    continue;
                }
                let row = shader.row(simd, triangle, left, y);
                let from = (y - band.first) as usize * width + left as usize;
                let mut first = 0;
                while first < right - left {
                    let rest = right - left - first;
                    let at = from + first as usize;
                    let count = if rest < S::F32_LANES as u32 { rest } else { S::F32_LANES as u32 };
                    let steps = Lanes::steps(simd) + first as f32;
                    let wanted = if overlap {
                        let nearer = nearer(depths.precise(left + first, y), count, &mut depth[at..]);
                        Lanes::load(simd, &nearer).below(Lanes::splat(simd, 0.0))
                    } else {
                        steps.below(Lanes::splat(simd, (right - left) as f32))
                    };
                    // Hidden pixels are not even shaded.
                    if !overlap || wanted.any(wanted) {
                        let values: [Lanes<S>; C] = shader.light(&row, Chunk { steps, first, count, wanted });
                        for c in 0..C {
                            let pixels = &mut planes[c][at..at + S::F32_LANES];
                            wanted.select(values[c], Lanes::load(simd, pixels)).store(pixels);
                        }
                    }
                    first += S::F32_LANES as u32;
                }
            }
        }
    }
}

/// −1 for each of `count` pixels at which the triangle is nearer than what was drawn before, 0 for others. Its depths
/// along the row are `at`, `at + step` …
#[inline(always)]
fn nearer((at, step): (f64, f64), count: u32, depth: &mut [f64]) -> [f32; MOST_LANES] {
    let mut nearer = [0.0; MOST_LANES];
    let Some(depth) = depth.first_chunk_mut::<MOST_LANES>() else { return nearer };
    for i in 0..MOST_LANES {
        let own = at + step * i as f64;
        let is = own < depth[i] && (i as u32) < count;
        depth[i] = if is { own } else { depth[i] };
        nearer[i] = if is { -1.0 } else { 0.0 };
    }
    nearer
}
