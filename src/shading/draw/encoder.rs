//! Encodes many light values at once as 8-bit codes, with the same result as [`ChannelQuantizer::code`] for every f32,
//! and writes out the light of a band.

use crate::{
    light::{Bits, ChannelQuantizer, Transfer},
    shading::number::Channels,
};

/// A transfer function prepared for the rasterizer's pixels.
///
/// The codes are exactly the codes of [`ChannelQuantizer::code`]. The upper bits of an f32 index a table, which gives
/// the code of the smallest number with these upper bits and the one threshold that may follow it; the lower bits
/// decide.
#[derive(Clone, Debug)]
pub struct Encoder {
    quantizer: ChannelQuantizer,
    table: Option<Table>,
}

/// Entries per table: enough for sRGB and exponents around 2.
const ENTRIES: usize = 1 << 13;

/// The position of the lowest bit of an f32's exponent.
const EXPONENT: u32 = f32::MANTISSA_DIGITS - 1;

/// The number of lower bits of an f32 that are not part of the index, which consists of the exponent and 8 bits of the
/// mantissa.
const LOWER: u32 = 15;

#[derive(Clone, Debug)]
struct Table {
    /// The upper half of an entry holds the code; the lower half holds 2¹⁶ minus the threshold's lower bits, or 0.
    /// Adding a number's lower bits carries into the code if they reach the threshold.
    entries: Box<[u32; ENTRIES]>,
    /// The light at which the table begins; its code is 0.
    least: f32,
}

impl Encoder {
    /// Makes an encoder for a display that `transfer` describes. This takes about 0.2 ms, so reuse the encoder.
    pub fn new(transfer: &Transfer) -> Encoder {
        let quantizer = ChannelQuantizer::new(transfer, Bits::Eight);
        Encoder { table: Table::new(&quantizer), quantizer }
    }

    /// Writes opaque RGBA codes, row by row. If one channel stands for several, it is the first in `light`.
    #[inline(always)]
    pub(super) fn write(&self, light: [&[f32]; 3], channels: Channels, samples: &mut [u8]) {
        let pixels = samples.as_chunks_mut().0;
        match channels {
            Channels::Gray(lit) => self.encode_gray(light[0], lit, pixels),
            Channels::Color => self.encode_color(light, pixels),
        }
    }

    /// Writes opaque RGBA codes with gray light in the channels that are `lit` and 0 in the others.
    #[inline(always)]
    fn encode_gray(&self, light: &[f32], lit: [bool; 3], pixels: &mut [[u8; 4]]) {
        let spread = u32::from_le_bytes([u8::from(lit[0]), u8::from(lit[1]), u8::from(lit[2]), 0]);
        let mut codes = [0; BLOCK];
        for (light, pixels) in light.chunks(BLOCK).zip(pixels.chunks_mut(BLOCK)) {
            self.codes(light, &mut codes);
            for (pixel, code) in pixels.iter_mut().zip(&codes) {
                *pixel = ((code * spread) | OPAQUE).to_le_bytes();
            }
        }
    }

    /// Writes opaque RGBA codes of red, green and blue light.
    #[inline(always)]
    fn encode_color(&self, [r, g, b]: [&[f32]; 3], pixels: &mut [[u8; 4]]) {
        let (mut red, mut green, mut blue) = ([0; BLOCK], [0; BLOCK], [0; BLOCK]);
        let light = r.chunks(BLOCK).zip(g.chunks(BLOCK)).zip(b.chunks(BLOCK));
        for (((r, g), b), pixels) in light.zip(pixels.chunks_mut(BLOCK)) {
            self.codes(r, &mut red);
            self.codes(g, &mut green);
            self.codes(b, &mut blue);
            for (pixel, ((r, g), b)) in pixels.iter_mut().zip(red.iter().zip(&green).zip(&blue)) {
                *pixel = (r | g << 8 | b << 16 | OPAQUE).to_le_bytes();
            }
        }
    }

    /// Encodes up to a block of light values.
    #[inline(always)]
    fn codes(&self, light: &[f32], codes: &mut [u32; BLOCK]) {
        let Some(table) = &self.table else {
            for (code, light) in codes.iter_mut().zip(light) {
                *code = u32::from(self.quantizer.code(*light));
            }
            return;
        };
        // Three passes over data in the nearest cache: vectorized, one by one, vectorized. A gather load takes 0.24
        // instead of 0.35 ns per pixel but would need unsafe code.
        for (code, light) in codes.iter_mut().zip(light) {
            *code = (table.bits(*light) >> LOWER) - (table.least.to_bits() >> LOWER);
        }
        for code in &mut codes[..light.len()] {
            // The index is always in range; the remainder avoids a bounds check.
            *code = table.entries[*code as usize % ENTRIES];
        }
        for (code, light) in codes.iter_mut().zip(light) {
            *code = (*code + (table.bits(*light) & LOWER_BITS)) >> 16;
        }
    }
}

/// The number of pixels that are encoded at once.
const BLOCK: usize = 512;

const OPAQUE: u32 = 0xff << 24;

impl Table {
    /// Makes the table of `quantizer`; `None` if two thresholds share an entry or if the table would need too many
    /// entries.
    fn new(quantizer: &ChannelQuantizer) -> Option<Table> {
        // A power of two below the first threshold.
        let first = quantizer.threshold(1).to_bits() >> EXPONENT;
        let least = f32::from_bits(first.checked_sub(1).filter(|e| *e > 0)? << EXPONENT);
        let (base, last) = (least.to_bits() >> LOWER, 1f32.to_bits() >> LOWER);
        let mut entries = Box::new([u32::from(u8::MAX) << 16; ENTRIES]);
        if (last - base) as usize >= ENTRIES {
            return None;
        }
        for (entry, upper) in entries.iter_mut().zip(base..=last) {
            let smallest = upper << LOWER;
            let (low, high) = [smallest, smallest | LOWER_BITS].map(|bits| quantizer.code(f32::from_bits(bits))).into();
            let rest = match high - low {
                0 => 0,
                1 => (1 << 16) - (quantizer.threshold(high).to_bits() & LOWER_BITS),
                _ => return None,
            };
            *entry = (u32::from(low) << 16) + rest;
        }
        Some(Table { entries, least })
    }

    /// Returns the bits of `light`, clamped to the range of the table.
    #[inline(always)]
    fn bits(&self, light: f32) -> u32 {
        // NaN also becomes `least`.
        let light = if light > self.least { light } else { self.least };
        (if light < 1.0 { light } else { 1.0 }).to_bits()
    }
}

const LOWER_BITS: u32 = (1 << LOWER) - 1;

/// Writes linear light as red, green and blue, as [`Encoder::write`] writes codes.
#[inline(always)]
pub(super) fn write_linear([r, g, b]: [&[f32]; 3], channels: Channels, samples: &mut [f32]) {
    let pixels = samples.as_chunks_mut::<3>().0;
    match channels {
        Channels::Gray(lit) => {
            let lit = lit.map(|lit| if lit { 1.0 } else { 0.0 });
            for (pixel, light) in pixels.iter_mut().zip(r) {
                *pixel = lit.map(|lit| light * lit);
            }
        }
        Channels::Color => {
            for (pixel, ((r, g), b)) in pixels.iter_mut().zip(r.iter().zip(g).zip(b)) {
                *pixel = [*r, *g, *b];
            }
        }
    }
}
