//! Images: light, and the codes that represent it. Rows run from top to bottom, and pixels from left to right; red,
//! green and blue are interleaved.

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
pub fn shares(at: u32, to: u32, from: u32) -> Vec<(u32, f64)> {
    let scale = f64::from(from) / f64::from(to);
    // A triangle as wide as two pixels of the coarser row.
    let (center, reach) = ((f64::from(at) + 0.5) * scale - 0.5, scale.max(1.0));
    let range = (center - reach).floor() as i64..=(center + reach).ceil() as i64;
    let weight = |pixel: i64| {
        let weight = 1.0 - (pixel as f64 - center).abs() / reach;
        (weight > 0.0).then_some((pixel.clamp(0, i64::from(from) - 1) as u32, weight))
    };
    let all: Vec<(u32, f64)> = range.filter_map(weight).collect();
    let sum: f64 = all.iter().map(|(_, weight)| weight).sum();
    all.into_iter().map(|(pixel, weight)| (pixel, weight / sum)).collect()
}
