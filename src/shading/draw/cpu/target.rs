//! Where the light of a band goes.

use super::encoder::Encoder;
use crate::shading::channels::Channels;

/// A picture in the making: its samples are written row by row, three or four a pixel.
pub(super) trait Target: Sync {
    type Sample: Send;
    /// Samples a pixel.
    const SAMPLES: usize;

    /// Writes pixels: where one channel stands for others, `light` has it first.
    fn write(&self, light: [&[f32]; 3], channels: Channels, samples: &mut [Self::Sample]);
}

/// Linear light, red green blue.
pub(super) struct Linear;

impl Target for Linear {
    type Sample = f32;
    const SAMPLES: usize = 3;

    #[inline(always)]
    fn write(&self, [r, g, b]: [&[f32]; 3], channels: Channels, samples: &mut [f32]) {
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
}

impl Target for Encoder {
    type Sample = u8;
    const SAMPLES: usize = 4;

    #[inline(always)]
    fn write(&self, light: [&[f32]; 3], channels: Channels, samples: &mut [u8]) {
        let pixels = samples.as_chunks_mut().0;
        match channels {
            Channels::Gray(lit) => self.encode_gray(light[0], lit, pixels),
            Channels::Color => self.encode_color(light, pixels),
        }
    }
}
