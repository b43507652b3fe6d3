//! Converts light to codes; the only place that knows how many codes there are. Rounding goes to the nearest code in
//! encoded space; dither chooses between the two codes that enclose a value in linear light.

use std::sync::Arc;

use rayon::prelude::*;

use super::dither::{Dither, Levels, Thresholds};
use super::image::{CodeImage, LinearImage, Samples};
use super::transfer::{Transfer, Transfers};
use crate::{system::checkpoint, text::names::named};

named! {
    /// Number of bits in a code.
    Bits, BitsError {
        /// Codes 0…255.
        Eight = "8",
        /// Codes 0…65535.
        Sixteen = "16",
    }
}

impl Bits {
    /// The code of full light.
    pub const fn max_code(self) -> u16 {
        match self {
            Bits::Eight => u8::MAX as u16,
            Bits::Sixteen => u16::MAX,
        }
    }
}

/// Returns the code of the relative luminance `linear`: round(encoded · largest code), clamped. NaN gets code 0.
///
/// This is the definition. [`ChannelQuantizer::code`] gives the same code for every f32 but is faster.
pub fn reference_code(transfer: &Transfer, bits: Bits, linear: f32) -> u16 {
    let scaled = transfer.encoded_from_linear(f64::from(linear)) * f64::from(bits.max_code());
    // encoded_from_linear clamps and `round` leaves a whole number, so the cast is exact; `as` turns NaN into 0.
    scaled.round() as u16
}

/// The number of low bits of an f32 that the first lookup ignores; the exponent and 7 bits of the mantissa remain.
const BUCKET_SHIFT: u32 = 16;

/// Converts light to codes for one channel of a display and one code size, prepared for many pixels.
#[derive(Clone, Debug)]
pub struct ChannelQuantizer {
    transfer: Transfer,
    bits: Bits,
    /// `thresholds[c]` is the smallest f32 with a code of at least c. Never decreases with c.
    thresholds: Vec<f32>,
    /// The code of the smallest f32 in every bucket, including the bucket that starts at 1.
    bucket_codes: Vec<u16>,
    /// The light of every code, for dither.
    levels: Levels,
}

impl ChannelQuantizer {
    /// Makes a quantizer for a channel that `transfer` describes. This takes about 0.1 ms for 8 bits and 7 ms for 16
    /// bits, so reuse the quantizer.
    pub fn new(transfer: &Transfer, bits: Bits) -> Self {
        let max = bits.max_code();
        let thresholds: Vec<f32> = (0..=max).map(|code| find_threshold(transfer, bits, code)).collect();
        let bucket_codes = (0..=1f32.to_bits() >> BUCKET_SHIFT)
            .map(|bucket| reference_code(transfer, bits, f32::from_bits(bucket << BUCKET_SHIFT)))
            .collect();
        Self { transfer: transfer.clone(), bits, thresholds, bucket_codes, levels: Levels::new(transfer, max) }
    }

    /// Returns the code nearest, in encoded space, to the relative luminance `linear`: 0 for values below 0 and for
    /// NaN, and the largest code for values above 1.
    #[inline]
    pub fn code(&self, linear: f32) -> u16 {
        if linear >= 1.0 {
            return self.bits.max_code();
        }
        if linear <= 0.0 || linear.is_nan() {
            return 0;
        }
        let bucket = (linear.to_bits() >> BUCKET_SHIFT) as usize;
        let (first, last) = (self.bucket_codes[bucket], self.bucket_codes[bucket + 1]);
        let inside = &self.thresholds[usize::from(first) + 1..=usize::from(last)];
        first + inside.partition_point(|&threshold| threshold <= linear) as u16
    }

    /// Returns the relative luminance that `code` produces. Codes above the largest produce full light.
    pub fn linear(&self, code: u16) -> f64 {
        self.transfer.linear_from_encoded(f64::from(code) / f64::from(self.bits.max_code()))
    }

    /// Returns the smallest relative luminance whose code is at least `code`; 0 for code 0.
    ///
    /// # Panics
    /// Panics if `code` is above the largest code.
    pub fn threshold(&self, code: u16) -> f32 {
        self.thresholds[usize::from(code)]
    }

    /// Uses `threshold` to choose one of the two codes that enclose `linear`.
    fn decide(&self, linear: f32, threshold: f64) -> u16 {
        self.levels.decide(linear, threshold, self.code(linear))
    }
}

/// Converts light to codes for one display and one code size, prepared for many pixels: a [`ChannelQuantizer`] for each
/// of red, green and blue.
#[derive(Clone, Debug)]
pub struct Quantizer {
    bits: Bits,
    /// Alike channels share one.
    channels: [Arc<ChannelQuantizer>; 3],
}

impl Quantizer {
    /// Makes a quantizer for a display that `transfers` describes. This takes about 0.1 ms for 8 bits and 7 ms for 16
    /// bits, and three times as long if the channels differ, so reuse the quantizer.
    pub fn new(transfers: &Transfers, bits: Bits) -> Self {
        let made = |transfer: &Transfer| Arc::new(ChannelQuantizer::new(transfer, bits));
        let channels = match transfers.uniform() {
            Some(all) => {
                let one = made(all);
                [one.clone(), one.clone(), one]
            }
            None => transfers.channels().each_ref().map(made),
        };
        Self { bits, channels }
    }

    /// Returns the number of bits in a code.
    pub fn bits(&self) -> Bits {
        self.bits
    }

    /// Returns the quantizer of red (0), green (1) or blue (2).
    ///
    /// # Panics
    /// Panics if `channel` is above 2.
    #[inline]
    pub fn channel(&self, channel: usize) -> &ChannelQuantizer {
        &self.channels[channel]
    }

    /// Returns [`ChannelQuantizer::code`] for each channel.
    #[inline]
    pub fn codes(&self, linear: [f32; 3]) -> [u16; 3] {
        std::array::from_fn(|channel| self.channels[channel].code(linear[channel]))
    }

    /// Returns [`ChannelQuantizer::linear`] for each channel.
    pub fn linear(&self, codes: [u16; 3]) -> [f64; 3] {
        std::array::from_fn(|channel| self.channels[channel].linear(codes[channel]))
    }

    /// Returns the codes of a whole image, without dither.
    pub fn quantize(&self, image: &LinearImage) -> CodeImage {
        self.quantize_with(image, Dither::None, 0)
    }

    /// Returns the codes of a whole image. Each is one of the two codes that enclose its value, chosen by `dither` so
    /// that the mean light is right; without dither, it is the nearest.
    ///
    /// The red, green and blue of a pixel share a threshold. [`dither`](super::dither) lists the properties of every
    /// kind. Only [`Dither::Random`] has a seed.
    pub fn quantize_with(&self, image: &LinearImage, dither: Dither, seed: u64) -> CodeImage {
        let samples = match self.bits {
            // An 8-bit code fits: the largest is 255.
            Bits::Eight => Samples::Eight(self.in_threads(image, (dither, seed), |code| code as u8)),
            Bits::Sixteen => Samples::Sixteen(self.in_threads(image, (dither, seed), |code| code)),
        };
        CodeImage { width: image.width, height: image.height, samples }
    }

    fn in_threads<T: Clone + Default + Send>(
        &self,
        image: &LinearImage,
        (dither, seed): (Dither, u64),
        sample: impl Fn(u16) -> T + Sync,
    ) -> Vec<T> {
        /// Rows per block: a multiple of the tile height of a random dither.
        const ROWS: usize = 16;
        let width = 3 * image.width.max(1) as usize;
        let mut samples = vec![T::default(); image.data.len() / 3 * 3];
        let blocks = samples.par_chunks_mut(ROWS * width).zip(image.data.par_chunks(ROWS * width)).enumerate();
        blocks.for_each_init(
            || Thresholds::new(dither, seed, image.width),
            |thresholds, (block, (samples, light))| {
                checkpoint();
                for (row, (samples, light)) in samples.chunks_mut(width).zip(light.chunks(width)).enumerate() {
                    let pixels = samples.as_chunks_mut().0.iter_mut().zip(light.as_chunks().0);
                    match thresholds {
                        None => pixels.for_each(|(codes, light)| *codes = self.codes(*light).map(&sample)),
                        // An image's sides are u32.
                        Some(thresholds) => pixels.zip(thresholds.row((ROWS * block + row) as u32)).for_each(
                            |((codes, light), threshold)| {
                                let decide = |channel: usize| self.channels[channel].decide(light[channel], *threshold);
                                *codes = [0, 1, 2].map(|channel| sample(decide(channel)));
                            },
                        ),
                    }
                }
            },
        );
        samples
    }
}

/// The smallest f32 in 0…1 whose [`reference_code`] is at least `code`.
///
/// Non-negative floats are ordered like their bits, so this is a search over whole numbers, near the threshold that the
/// inverse transfer function gives.
fn find_threshold(transfer: &Transfer, bits: Bits, code: u16) -> f32 {
    if code == 0 {
        return 0.0;
    }
    let reached = |at: u32| reference_code(transfer, bits, f32::from_bits(at)) >= code;
    let half_way = (f64::from(code) - 0.5) / f64::from(bits.max_code());
    let guess = (transfer.linear_from_encoded(half_way) as f32).to_bits();
    // `low` does not reach the code (0 has code 0), and `high` does (1 has the largest code); they are nearly always
    // close to the guess.
    let whole = (0, 1f32.to_bits());
    let near = (guess.saturating_sub(8), (guess + 8).min(whole.1));
    let (mut low, mut high) = if !reached(near.0) && reached(near.1) { near } else { whole };
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        if reached(middle) { high = middle } else { low = middle }
    }
    f32::from_bits(high)
}
