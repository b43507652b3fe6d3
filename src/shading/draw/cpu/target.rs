//! Where the light of a band goes.

use pulp::{Arch, Simd, WithSimd};

use super::{channels::Channels, encoder::Encoder};

/// A picture in the making: its samples are written row by row, three or four a pixel.
pub(super) trait Target: Sync {
    type Sample: Send;
    /// Samples a pixel.
    const SAMPLES: usize;

    /// Pixels of one light in the channels that are `lit`, and darkness in the others.
    fn gray(&self, light: &[f32], lit: [bool; 3], samples: &mut [Self::Sample]);

    /// Pixels of red, green and blue light.
    fn color(&self, light: [&[f32]; 3], samples: &mut [Self::Sample]);
}

/// Linear light, red green blue.
pub(super) struct Linear;

impl Target for Linear {
    type Sample = f32;
    const SAMPLES: usize = 3;

    #[inline(always)]
    fn gray(&self, light: &[f32], lit: [bool; 3], samples: &mut [f32]) {
        let [r, g, b] = lit.map(|lit| if lit { 1.0 } else { 0.0 });
        for (pixel, light) in samples.as_chunks_mut::<3>().0.iter_mut().zip(light) {
            *pixel = [light * r, light * g, light * b];
        }
    }

    #[inline(always)]
    fn color(&self, [r, g, b]: [&[f32]; 3], samples: &mut [f32]) {
        for (pixel, ((r, g), b)) in samples.as_chunks_mut::<3>().0.iter_mut().zip(r.iter().zip(g).zip(b)) {
            *pixel = [*r, *g, *b];
        }
    }
}

impl Target for Encoder {
    type Sample = u8;
    const SAMPLES: usize = 4;

    #[inline(always)]
    fn gray(&self, light: &[f32], lit: [bool; 3], samples: &mut [u8]) {
        self.encode_gray(light, lit, samples.as_chunks_mut().0);
    }

    #[inline(always)]
    fn color(&self, light: [&[f32]; 3], samples: &mut [u8]) {
        self.encode_color(light, samples.as_chunks_mut().0);
    }
}

/// Writes as many pixels of `light` as `samples` has room for.
pub(super) fn finish<T: Target>(
    arch: Arch,
    target: &T,
    light: [&[f32]; 3],
    channels: Channels,
    samples: &mut [T::Sample],
) {
    arch.dispatch(Finish { target, light, channels, samples });
}

struct Finish<'a, T: Target> {
    target: &'a T,
    light: [&'a [f32]; 3],
    channels: Channels,
    samples: &'a mut [T::Sample],
}

impl<T: Target> WithSimd for Finish<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let count = self.samples.len() / T::SAMPLES;
        match self.channels {
            Channels::Gray(lit) => self.target.gray(&self.light[0][..count], lit, self.samples),
            Channels::Color => {
                let [r, g, b] = self.light;
                self.target.color([&r[..count], &g[..count], &b[..count]], self.samples);
            }
        }
    }
}
