//! Images: light, and the codes that represent it. Rows run from top to bottom, and pixels from left to right; red,
//! green and blue are interleaved. Codes may have fewer bits than their file, such as the 10 bits of a camera in 16.

use rayon::prelude::*;

use super::Transfers;
use crate::system::checkpoint;

/// An image of relative luminances, 0…1, proportional to light.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearImage {
    /// Pixels per row.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// Red, green and blue of every pixel, row by row from the top left; `3 · width · height`
    /// values.
    pub data: Vec<f32>,
}

impl LinearImage {
    /// Makes a black image of `width` × `height` pixels.
    pub fn new(width: u32, height: u32) -> Self {
        Self { width, height, data: vec![0.0; samples(width, height)] }
    }

    /// Makes the image whose pixel in column x and row y is `light(x, y)`; `light` is called row by row.
    pub fn from_fn(width: u32, height: u32, mut light: impl FnMut(u32, u32) -> [f32; 3]) -> Self {
        let mut data = Vec::with_capacity(samples(width, height));
        for y in 0..height {
            checkpoint();
            for x in 0..width {
                data.extend(light(x, y));
            }
        }
        Self { width, height, data }
    }

    /// Returns the red, green and blue light in column `x` and row `y`, both counted from 0 at the top left.
    ///
    /// # Panics
    /// Panics if the pixel is outside the image.
    pub fn pixel(&self, x: u32, y: u32) -> [f32; 3] {
        let i = sample_index(self.width, self.height, x, y);
        [self.data[i], self.data[i + 1], self.data[i + 2]]
    }
}

/// An image of codes, ready for a file or a texture. Made by [`Quantizer::quantize`](super::Quantizer::quantize).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CodeImage {
    /// Pixels per row.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// The codes, in the order of [`LinearImage::data`].
    pub samples: Samples,
}

/// Codes of 8 or 16 bits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Samples {
    /// 8-bit codes, 0…255.
    Eight(Vec<u8>),
    /// 16-bit codes, 0…65535.
    Sixteen(Vec<u16>),
}

impl CodeImage {
    /// Returns the number of bits of a code: 8 or 16.
    pub fn bits(&self) -> u32 {
        match self.samples {
            Samples::Eight(_) => 8,
            Samples::Sixteen(_) => 16,
        }
    }

    /// Returns the 8-bit codes, with red, green and blue interleaved; `None` if this image has 16 bits.
    pub fn bytes(&self) -> Option<&[u8]> {
        match &self.samples {
            Samples::Eight(codes) => Some(codes),
            Samples::Sixteen(_) => None,
        }
    }

    /// Returns the light that a screen with these transfer functions emits.
    pub fn light(&self, transfers: &Transfers) -> LinearImage {
        let full = f64::from((1 << self.bits()) - 1);
        LinearImage::from_fn(self.width, self.height, |x, y| {
            let encoded = self.pixel(x, y).map(|code| f64::from(code) / full);
            transfers.linear_from_encoded(encoded).map(|light| light as f32)
        })
    }

    /// Returns the red, green and blue codes in column `x` and row `y`, both counted from 0 at the top left.
    ///
    /// # Panics
    /// Panics if the pixel is outside the image.
    pub fn pixel(&self, x: u32, y: u32) -> [u16; 3] {
        let i = sample_index(self.width, self.height, x, y);
        match &self.samples {
            Samples::Eight(codes) => [codes[i].into(), codes[i + 1].into(), codes[i + 2].into()],
            Samples::Sixteen(codes) => [codes[i], codes[i + 1], codes[i + 2]],
        }
    }
}

/// Returns the number of samples in an image.
fn samples(width: u32, height: u32) -> usize {
    width as usize * height as usize * 3
}

/// Returns the index of a pixel's red sample.
fn sample_index(width: u32, height: u32, x: u32, y: u32) -> usize {
    assert!(x < width && y < height, "pixel ({x}, {y}) is outside the {width} × {height} image");
    (y as usize * width as usize + x as usize) * 3
}

/// Returns the pixels of a row of `from` pixels, with their shares, that make up pixel `at` of a row of `to` pixels: the mean
/// of the area that it covers, or, if there are fewer, an interpolation between the centers of two.
pub fn shares(at: usize, to: usize, from: usize) -> Vec<(usize, f64)> {
    let scale = from as f64 / to as f64;
    // A triangle as wide as two pixels of the coarser row.
    let (center, reach) = ((at as f64 + 0.5) * scale - 0.5, scale.max(1.0));
    let range = (center - reach).floor() as i64..=(center + reach).ceil() as i64;
    let weight = |pixel: i64| {
        let weight = 1.0 - (pixel as f64 - center).abs() / reach;
        (weight > 0.0).then_some((pixel.clamp(0, from as i64 - 1) as usize, weight))
    };
    let all: Vec<(usize, f64)> = range.filter_map(weight).collect();
    let sum: f64 = all.iter().map(|(_, weight)| weight).sum();
    all.into_iter().map(|(pixel, weight)| (pixel, weight / sum)).collect()
}

/// Resamples a picture with `N` numbers at each pixel from one size `[across, down]` to another. `shares` is called for each
/// pixel of a row or a column, as [`shares`] is.
pub fn resampled<const N: usize>(
    from: [usize; 2],
    to: [usize; 2],
    shares: impl Fn(usize, usize, usize) -> Vec<(usize, f64)>,
    at: impl Fn(usize, usize) -> [f64; N] + Sync,
) -> Vec<[f64; N]> {
    let [columns, rows] = [0, 1].map(|axis| (0..to[axis]).map(|i| shares(i, to[axis], from[axis])).collect::<Vec<_>>());
    let add = |sum: &mut [f64; N], by: f64, value: [f64; N]| {
        sum.iter_mut().zip(value).for_each(|(sum, value)| *sum += by * value);
    };
    let of_row = |down: &Vec<(usize, f64)>| -> Vec<[f64; N]> {
        checkpoint();
        let mut sums = vec![[0.0; N]; from[0]];
        for (row, by) in down {
            sums.iter_mut().enumerate().for_each(|(column, sum)| add(sum, *by, at(column, *row)));
        }
        let pixel = |across: &Vec<(usize, f64)>| {
            let mut sum = [0.0; N];
            across.iter().for_each(|(column, by)| add(&mut sum, *by, sums[*column]));
            sum
        };
        columns.iter().map(pixel).collect()
    };
    rows.par_iter().flat_map_iter(of_row).collect()
}

/// So many bits of coincidence are not believed.
const BEYOND_CHANCE: u32 = 20;

/// The levels that the codes of a picture can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Levels {
    /// The number of bits that differ from level to level.
    pub bits: u32,
    /// The number of bits of a code.
    pub of: u32,
    form: Form,
}

/// How a level is written with more bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    /// The highest level becomes the highest code.
    Scaled,
    /// The same, but the bits of the level are repeated.
    Repeated,
    /// Zeros follow.
    Shifted,
}

impl Levels {
    /// Returns the fewest levels that all codes of a picture have. They are of `known` bits if that is possible;
    /// otherwise, it must be unlikely that codes only happen to be among fewer levels.
    pub fn of(image: &CodeImage, known: u32) -> Levels {
        let of = image.bits();
        let codes = match &image.samples {
            Samples::Eight(codes) => distinct(codes.iter().map(|code| u32::from(*code))),
            Samples::Sixteen(codes) => distinct(codes.iter().map(|code| u32::from(*code))),
        };
        let is_known = |bits: &u32| known == *bits || codes.len() as u32 * (of - bits) >= BEYOND_CHANCE;
        let bits = std::iter::once(known).chain(1..of).filter(|bits| (1..of).contains(bits)).filter(is_known);
        let all =
            bits.flat_map(|bits| [Form::Scaled, Form::Repeated, Form::Shifted].map(|form| Levels { bits, of, form }));
        let fits = |levels: &Levels| codes.iter().all(|code| levels.code(levels.level(*code)) == *code);
        all.into_iter().find(fits).unwrap_or(Levels { bits: of, of, form: Form::Scaled })
    }

    /// Returns the level of a code: 0, 1, 2, …
    pub fn level(self, code: u32) -> u32 {
        match self.form {
            Form::Scaled => (f64::from(code) * full(self.bits) / full(self.of)).round() as u32,
            Form::Repeated | Form::Shifted => code >> (self.of - self.bits),
        }
    }

    /// Returns the code of a level.
    fn code(self, level: u32) -> u32 {
        let shifted = level << (self.of - self.bits);
        match self.form {
            Form::Scaled => (f64::from(level) * full(self.of) / full(self.bits)).round() as u32,
            Form::Shifted => shifted,
            Form::Repeated => (0..self.of).step_by(self.bits as usize).fold(0, |code, by| code | shifted >> by),
        }
    }

    /// Returns the encoded value of a level, which may lie between two levels: 0…1.
    pub fn encoded(self, level: f64) -> f64 {
        match self.form {
            Form::Scaled | Form::Repeated => level / full(self.bits),
            Form::Shifted => level * f64::from(1 << (self.of - self.bits)) / full(self.of),
        }
    }
}

/// How many steps between levels are looked at on either side of one, ...
const NEAR: usize = 3;
/// ... and how many of them must be alike. Colors that are only few are not evenly spaced.
const ALIKE: usize = 3;

/// Returns, for each level of a channel, how far the values that were rounded to it reach below and above it: half of the
/// step to the next level that occurs, if the steps there are even, as after posterizing or stretching the contrast, and
/// otherwise half a level. Steps are what most often lies between neighboring pixels: flat areas of a few colors have
/// none. Also returns whether most changes are larger than steps.
pub fn reaches(channel: &[f64], width: usize) -> (Vec<[f64; 2]>, bool) {
    let levels = distinct(channel.iter().map(|level| *level as u32));
    let mut place = vec![0; 1 << 16];
    levels.iter().enumerate().for_each(|(i, level)| place[*level as usize] = i);
    let beside = channel.chunks_exact(width).flat_map(|row| row.iter().zip(&row[1..]));
    let beside = beside.chain(channel.iter().zip(channel.iter().skip(width)));
    let changes: Vec<[u16; 2]> =
        beside.filter(|(a, b)| a != b).map(|(a, b)| [a.min(*b) as u16, a.max(*b) as u16]).collect();
    let is_most = |of: &dyn Fn([usize; 2]) -> bool| {
        2 * changes.iter().filter(|change| of(change.map(usize::from))).count() > changes.len()
    };
    let apart: Vec<u32> = levels.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let has_steps = is_most(&|[low, high]| place[high] - place[low] == 1);
    let half = |i: usize| {
        let near = &apart[i.saturating_sub(NEAR)..apart.len().min(i + NEAR + 1)];
        // It is like itself.
        let alike = near.iter().filter(|other| other.abs_diff(apart[i]) <= 1).count() - 1;
        0.5 * if has_steps && alike >= ALIKE { f64::from(apart[i]) } else { 1.0 }
    };
    let halves: Vec<f64> = (0..apart.len()).map(half).collect();
    let mut reaches = vec![[0.5; 2]; 1 << 16];
    for (i, level) in levels.iter().enumerate() {
        // The lowest and the highest level reach as far to either side.
        let [below, above] = [i.checked_sub(1).and_then(|below| halves.get(below)), halves.get(i)];
        reaches[*level as usize] = [below.or(above), above.or(below)].map(|half| half.copied().unwrap_or(0.5));
    }
    let is_edges = is_most(&|[low, high]| (high - low) as f64 > reaches[low][1] + reaches[high][0]);
    (reaches, is_edges)
}

/// Returns the highest code of so many bits.
fn full(bits: u32) -> f64 {
    f64::from((1 << bits) - 1)
}

/// Returns the different codes of a picture.
fn distinct(codes: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut occurs = vec![false; 1 << 16];
    codes.for_each(|code| occurs[code as usize] = true);
    (0..).zip(occurs).filter_map(|(code, occurs)| occurs.then_some(code)).collect()
}
