//! The eye that looks at a picture: its contrast sensitivity, and how a reference masks a difference; and how a rater turns
//! what the model computes into ratings.

use crate::light::LinearImage;

/// Luminance at which the shape of the filter is defined, cd/m²: that of ModelFest.
const STANDARD_CD_M2: f64 = 30.0;
/// Luminance above which more light makes hardly finer detail visible, cd/m².
const BRIGHT_CD_M2: f64 = 200.0;
/// The oblique effect begins above this frequency, cycles per degree (Watson & Ahumada 2005, J. Vision 5(9):6).
const OBLIQUE_ABOVE: f64 = 3.48;
/// Its frequency constant, cycles per degree (same source).
const OBLIQUE_SCALE: f64 = 13.57;

/// The detection model of an average observer: a filter, a fall-off with eccentricity, and pooling over space. The form
/// follows Watson & Ahumada 2005 (J. Vision 5(9):6).
///
/// Every value is fitted to thresholds of people; `cargo run --release -p tools -- thresholds --fit` repeats the fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensitivity {
    /// Gain of the filter at 1 cycle per degree, before pooling over space and without the fall toward fine detail.
    pub gain: f64,
    /// Frequency that scales the fall toward fine detail, cycles per degree, at 30 cd/m².
    pub fine_cpd: f64,
    /// Exponent of that fall.
    pub fine_power: f64,
    /// Exponent of the fall toward coarse structure.
    pub coarse_power: f64,
    /// Exponent with which responses are pooled over space.
    pub pooling: f64,
    /// Eccentricity that scales the fall-off of sensitivity, degrees.
    pub fovea_deg: f64,
    /// Exponent of that fall-off.
    pub fovea_power: f64,
    /// Exponent of the effect that more light, up to 200 cd/m², makes finer detail visible.
    pub bright_power: f64,
}

impl Default for Sensitivity {
    fn default() -> Self {
        Self {
            gain: 329.5,
            fine_cpd: 0.388,
            fine_power: 0.5471,
            coarse_power: 1.836,
            pooling: 2.287,
            fovea_deg: 0.1696,
            fovea_power: 0.2977,
            bright_power: 0.1294,
        }
    }
}

impl Sensitivity {
    /// Returns the gain of the filter for a horizontal or vertical grating of `frequency` cycles per degree, on a field
    /// of `luminance` cd/m². This is a response per unit of contrast; the threshold also depends on the grating's area.
    pub fn at(&self, frequency: f64, luminance: f64) -> f64 {
        let bright = |luminance: f64| luminance / (luminance + BRIGHT_CD_M2);
        let finest = self.fine_cpd * (bright(luminance) / bright(STANDARD_CD_M2)).powf(self.bright_power);
        let fine = 1.0 / (frequency / finest).powf(self.fine_power).cosh();
        self.gain * fine * frequency.powf(self.coarse_power)
    }

    /// Returns the highest gain at any frequency, for a field of `luminance` cd/m².
    pub fn peak(&self, luminance: f64) -> f64 {
        // Sixteen steps per octave from 1/16 to 64 cycles per degree.
        (-64..=96).map(|step| self.at((f64::from(step) / 16.0).exp2(), luminance)).fold(0.0, f64::max)
    }

    /// Returns the factor for an oblique grating. `across` is the unit vector across its bars.
    pub fn oblique(frequency: f64, across: [f64; 2]) -> f64 {
        1.0 - Self::obliqueness(frequency) * (2.0 * across[0] * across[1]).powi(2)
    }

    /// Returns the share of the gain that a grating loses at 45°.
    pub(super) fn obliqueness(frequency: f64) -> f64 {
        -(-(frequency - OBLIQUE_ABOVE).max(0.0) / OBLIQUE_SCALE).exp_m1()
    }

    /// Returns the factor for a place at `deg` degrees from the center of gaze.
    pub fn eccentric(&self, deg: f64) -> f64 {
        (1.0 + (deg / self.fovea_deg).powi(2)).powf(-0.5 * self.fovea_power)
    }
}

/// The eye of an average observer, adapted to a screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eye {
    /// Mean luminance of the field, cd/m²; above 0.
    pub luminance: f64,
    /// Contrast sensitivity.
    pub sensitivity: Sensitivity,
    pub masking: Masking,
}

/// To what a difference is relative, and how a reference masks it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Masking {
    /// σ of the Gaussian window in which the eye averages light, degrees: it adapts to the light nearby.
    pub adaptation_deg: f64,
    /// σ of a band's Gaussian, given as a ratio of frequencies.
    pub ratio: f64,
    /// The reference's response at which it masks a band to 1/√2.
    pub half: f64,
}

impl Default for Masking {
    /// The bands have 1.5 octaves at half height, close to the median of cells in V1 (1.4 in De Valois, Albrecht &
    /// Thorell 1982, Vis. Res. 22:545). `half` is the peak response to ModelFest's Gabor of 4 cycles per degree at its
    /// measured threshold, which `cargo run --release -p tools -- thresholds` derives.
    fn default() -> Self {
        Self { adaptation_deg: 0.5, ratio: 0.65, half: 1.816 }
    }
}

impl Eye {
    /// Creates an average eye that is adapted to `luminance` cd/m².
    pub fn adapted_to(luminance: f64) -> Self {
        Self { luminance, sensitivity: Sensitivity::default(), masking: Masking::default() }
    }
}

/// The luminance of full red, green and blue of sRGB, relative to white (IEC 61966-2-1).
pub const SRGB_WEIGHTS: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// Returns the luminance of a linear sRGB color, 1 for white.
pub fn luminance(light: [f32; 3]) -> f64 {
    weighted(&light, SRGB_WEIGHTS)
}

/// Returns the luminance of each pixel of an image, 1 for white; `weights` are those of full red, green and blue.
pub fn luminances(image: &LinearImage, weights: [f64; 3]) -> Vec<f64> {
    image.data.chunks_exact(3).map(|pixel| weighted(pixel, weights)).collect()
}

fn weighted(light: &[f32], weights: [f64; 3]) -> f64 {
    light.iter().zip(weights).map(|(light, weight)| f64::from(*light) * weight).sum()
}

/// Thresholds between the ratings 0 to 3. A rating is above k if ln of what is rated plus logistic noise exceeds the
/// logarithm of threshold k. What is rated, such as a band, is in times threshold.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Criterion {
    /// The values at which half of the ratings are above 0, 1 and 2. They are positive and increasing.
    pub thresholds: [f64; 3],
    /// Scale of the logistic noise, in units of the logarithm; above 0.
    pub spread: f64,
}

impl Criterion {
    /// Returns the probabilities of the ratings 0…3 for this value, which is at least 0. At 0 there is nothing to see.
    pub fn probabilities(&self, value: f64) -> [f64; 4] {
        let above = self.thresholds.map(|threshold| self.above(value, threshold));
        [1.0 - above[0], above[0] - above[1], above[1] - above[2], above[2]]
    }

    /// Returns the mean rating, 0…3, for this value.
    pub fn mean(&self, value: f64) -> f64 {
        self.thresholds.iter().map(|threshold| self.above(value, *threshold)).sum()
    }

    fn above(&self, value: f64, threshold: f64) -> f64 {
        // (v/t)^(1/s) / (1 + (v/t)^(1/s)) is the logistic function of (ln v − ln t)/s, and it is 0 if there is nothing.
        let odds = (value.max(0.0) / threshold).powf(1.0 / self.spread);
        if odds.is_finite() { odds / (1.0 + odds) } else { 1.0 }
    }
}
