//! A profile in the frequency domain, where every filter of these models is a product.

use std::f64::consts::PI;
use std::sync::Arc;

use rustfft::Fft;
use rustfft::num_complex::Complex;

use machband::vision::fft::{self, smooth};

/// A one-dimensional profile, extended at both ends by its end values, ready to be filtered.
pub struct Spectrum {
    values: Vec<Complex<f64>>,
    inverse: Arc<dyn Fft<f64>>,
    /// The number of samples in the profile, and of extension samples before them.
    len: usize,
    before: usize,
    px_per_deg: f64,
}

impl Spectrum {
    /// The spectrum of `light`, with `px_per_deg` samples per degree, for filters that extend `reach_deg` degrees.
    ///
    /// The extended profile is treated as periodic: it jumps from its end to its beginning. The extension is so long that
    /// this jump does not affect any filter inside the profile.
    pub fn new(light: &[f64], px_per_deg: f64, reach_deg: f64) -> Self {
        let before = (reach_deg * px_per_deg).ceil().max(1.0) as usize;
        let size = smooth(light.len() + 2 * before);
        let at = |i: usize| light[i.saturating_sub(before).min(light.len() - 1)];
        // Half of the extra samples extend the end, and half the beginning.
        let mut values: Vec<_> = (0..size).map(|i| Complex::new(at(i), 0.0)).collect();
        fft::forward(size).process(&mut values);
        Self { values, inverse: fft::inverse(size), len: light.len(), before, px_per_deg }
    }

    /// Applies two filters at once. `transfer(f)` is their transfer function at f cycles per degree, for both signs of f.
    /// Both filters are real, so the first result can be the real part and the second the imaginary part.
    pub fn filtered(&self, transfer: impl Fn(f64) -> [Complex<f64>; 2]) -> [Vec<f64>; 2] {
        let size = self.values.len();
        let step = self.px_per_deg / size as f64;
        let mut values: Vec<_> = (0..size)
            .map(|i| {
                // The Nyquist frequency has no sign, so an odd filter has no response there.
                let signed = if 2 * i > size { i as f64 - size as f64 } else { i as f64 };
                let [a, b] = transfer(signed * step);
                (a + b * Complex::i()) * self.values[i]
            })
            .collect();
        self.inverse.process(&mut values);
        let inside = &values[self.before..self.before + self.len];
        let scale = 1.0 / size as f64;
        [inside.iter().map(|v| v.re * scale).collect(), inside.iter().map(|v| v.im * scale).collect()]
    }
}

/// The transfer function at `f` cycles per degree of a Gaussian with standard deviation `sigma_deg` degrees and area 1.
pub fn gaussian(sigma_deg: f64, f: f64) -> f64 {
    let turn = 2.0 * PI * sigma_deg * f;
    (-0.5 * turn * turn).exp()
}
