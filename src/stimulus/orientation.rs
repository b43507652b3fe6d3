//! Where a pixel lies across a stimulus, exactly as symmetric as the picture should be.

use std::f64::consts::FRAC_1_SQRT_2;

/// Steps of orientation in one degree. Finer than any picture can show (1e-9° moves the corner of a
/// window 10000 pixels wide by 1e-7 pixels), and coarse enough that θ and θ + 180, both rounded to
/// f64, are the same step half a turn apart.
const STEPS_PER_DEG: f64 = 1e9;
const QUARTER: i64 = 90_000_000_000;

/// cos θ and sin θ of `degrees`, to 1e-9°.
///
/// θ + 180° is exactly the negative of θ, 90° − θ its swap; multiples of 90° and 45° are exact.
pub(super) fn cos_sin(degrees: f64) -> (f64, f64) {
    let steps = ((degrees % 360.0) * STEPS_PER_DEG).round() as i64;
    let (quarters, rest) = (steps.div_euclid(QUARTER), steps.rem_euclid(QUARTER));
    let (cos, sin) = first_quarter(rest);
    match quarters.rem_euclid(4) {
        0 => (cos, sin),
        1 => (-sin, cos),
        2 => (-cos, -sin),
        _ => (sin, -cos),
    }
}

/// For 0 ≤ `steps` < [`QUARTER`].
fn first_quarter(steps: i64) -> (f64, f64) {
    if steps == 0 {
        (1.0, 0.0)
    } else if 2 * steps == QUARTER {
        (FRAC_1_SQRT_2, FRAC_1_SQRT_2)
    } else if 2 * steps < QUARTER {
        let (sin, cos) = (steps as f64 / STEPS_PER_DEG).to_radians().sin_cos();
        (cos, sin)
    } else {
        let (cos, sin) = first_quarter(QUARTER - steps);
        (sin, cos)
    }
}

/// The pixel centers of a square window, and the direction across its ramp.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    /// Pixels a side, at least 1.
    pub size: u32,
    pub cos: f64,
    pub sin: f64,
}

impl Grid {
    pub fn new(size: u32, orientation_deg: f64) -> Self {
        let (cos, sin) = cos_sin(orientation_deg);
        Self { size, cos, sin }
    }

    /// Whether edges of this orientation run along the pixels.
    pub fn is_along_pixels(&self) -> bool {
        self.cos == 0.0 || self.sin == 0.0
    }

    /// x of Bangay §3.1, in window sides: (p − center)·(cos θ, sin θ), p the center of the pixel in
    /// column `ix` and row `iy`.
    ///
    /// The pixel opposite through the center has exactly −x.
    #[inline]
    pub fn across(&self, ix: u32, iy: u32) -> f64 {
        let n = i64::from(self.size);
        let scale = (2 * n) as f64;
        let right = (2 * i64::from(ix) + 1 - n) as f64 / scale;
        // Rows count downwards, y upwards.
        let up = (n - 1 - 2 * i64::from(iy)) as f64 / scale;
        right * self.cos + up * self.sin
    }
}

/// Where pixel `i` of a row of `size` has its center, in window sides from the window's center.
#[must_use]
pub fn place(i: u32, size: u32) -> f64 {
    (2.0 * f64::from(i) + 1.0 - f64::from(size)) / (2.0 * f64::from(size))
}

/// Light of a pixel of relative luminance `luminance`.
pub(super) fn light(weights: [f64; 3], luminance: f64) -> [f32; 3] {
    weights.map(|weight| (weight * luminance) as f32)
}
