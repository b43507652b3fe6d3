//! A profile in the frequency domain, where every filter of these models is a product.

use std::f64::consts::PI;
use std::sync::Arc;

use rustfft::Fft;
use rustfft::num_complex::Complex;

use machband::vision::fft::{self, smooth};

/// A profile of one dimension, continued beyond both ends by its end values, ready to be filtered.
pub struct Spectrum {
    values: Vec<Complex<f64>>,
    inverse: Arc<dyn Fft<f64>>,
    /// Samples of the profile, and the continued ones before them.
    len: usize,
    before: usize,
    px_per_deg: f64,
}

impl Spectrum {
    /// The spectrum of `light`, `px_per_deg` samples a degree, for filters that reach `reach_deg` degrees.
    ///
    /// The continued profile is taken as periodic: from its end it jumps to its beginning. The continuation is
    /// so long that no filter sees that jump from within the profile.
    pub fn new(light: &[f64], px_per_deg: f64, reach_deg: f64) -> Self {
        let before = (reach_deg * px_per_deg).ceil().max(1.0) as usize;
        let size = smooth(light.len() + 2 * before);
        let at = |i: usize| light[i.saturating_sub(before).min(light.len() - 1)];
        // Half of the extra samples continue the end, half the beginning before the first.
        let mut values: Vec<_> = (0..size).map(|i| Complex::new(at(i), 0.0)).collect();
        fft::forward(size).process(&mut values);
        Self { values, inverse: fft::inverse(size), len: light.len(), before, px_per_deg }
    }

    /// Two filters at once. `transfer(f)` is what they do to a frequency of f cycles a degree, f of both signs;
    /// both filters are real, so the first may come out as the real part and the second as the imaginary one.
    pub fn filtered(&self, transfer: impl Fn(f64) -> [Complex<f64>; 2]) -> [Vec<f64>; 2] {
        let size = self.values.len();
        let step = self.px_per_deg / size as f64;
        let mut values: Vec<_> = (0..size)
            .map(|i| {
                // Nyquist's frequency has no sign: an odd filter has nothing there.
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

/// What a Gaussian of standard deviation `sigma_deg` degrees and area 1 leaves of `f` cycles a degree.
pub fn gaussian(sigma_deg: f64, f: f64) -> f64 {
    let turn = 2.0 * PI * sigma_deg * f;
    (-0.5 * turn * turn).exp()
}
