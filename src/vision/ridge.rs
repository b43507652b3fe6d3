//! Finds the ridges of the energy in two dimensions, with subsample accuracy.

use rustfft::num_complex::Complex64;

use super::{
    band::{COUNTS_BELOW, COUNTS_FULLY_BELOW, FALL_PERIODS, ODD_SHARE, Polarity, VEIL, strength},
    eye::{Border, Channel},
    image::{Distances, Field},
    spectrum::Responses,
};

/// The energy of a response that is a hundredth of what is just visible on black. Anything below this is rounding
/// error.
const FAINTEST: f64 = (0.01 * VEIL) * (0.01 * VEIL);

/// A place on a band.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ridge {
    /// Position `[x, y]` in pixels from the image's upper left corner.
    pub(super) at: [f64; 2],
    /// Unit vector across the band: `[right, down]`.
    pub(super) across: [f64; 2],
    /// Length of the band that this place represents, pixels.
    pub(super) length_px: f64,
    pub(super) polarity: Polarity,
    pub(super) strength: f64,
    /// Amplitude of the even and odd responses together.
    pub(super) energy: f64,
    pub(super) frequency: f64,
}

/// The data for the search for a channel's ridges.
pub(super) struct Search<'a> {
    pub(super) responses: &'a Responses,
    pub(super) channel: Channel,
    pub(super) px_per_deg: f64,
    /// Mean light to which the eye is adapted.
    pub(super) mean: &'a Field,
    /// Distances from areas where bands do not count.
    pub(super) distances: &'a Distances,
}

/// Returns the value at the index `here` and its eight neighbors in an array with rows of `columns` values.
fn near<T: Copy>(values: &[T], here: usize, columns: usize) -> [[T; 3]; 3] {
    [here - columns, here, here + columns].map(|middle| {
        let row = &values[middle - 1..middle + 2];
        [row[0], row[1], row[2]]
    })
}

/// A value, its slope and its curvature, per grid step.
struct Local {
    value: f64,
    slope: [f64; 2],
    /// Second derivatives: xx, xy and yy.
    curvature: [f64; 3],
}

impl Local {
    /// Estimates the slope and the curvature from a value and its eight neighbors.
    fn of([a, b, c]: [[f64; 3]; 3]) -> Local {
        Local {
            value: b[1],
            slope: [(b[2] - b[0]) / 2.0, (c[1] - a[1]) / 2.0],
            curvature: [b[0] - 2.0 * b[1] + b[2], (c[2] - c[0] - a[2] + a[0]) / 4.0, a[1] - 2.0 * b[1] + c[1]],
        }
    }

    fn slope_along(&self, [x, y]: [f64; 2]) -> f64 {
        self.slope[0] * x + self.slope[1] * y
    }

    fn curvature_along(&self, [x, y]: [f64; 2]) -> f64 {
        let [xx, xy, yy] = self.curvature;
        xx * x * x + 2.0 * xy * x * y + yy * y * y
    }

    fn moved(&self, direction: [f64; 2], by: f64) -> f64 {
        self.value + by * self.slope_along(direction) + by * by / 2.0 * self.curvature_along(direction)
    }

    /// Returns the unit vector in the direction of the strongest curvature: at half the angle of (xx − yy, 2·xy), or
    /// perpendicular to it.
    fn across(&self) -> [f64; 2] {
        let [xx, xy, yy] = self.curvature;
        let length = ((xx - yy).powi(2) + (2.0 * xy).powi(2)).sqrt();
        if length <= 0.0 {
            return [1.0, 0.0];
        }
        let cosine = (xx - yy) / length;
        let half = [((1.0 + cosine) / 2.0).max(0.0).sqrt(), ((1.0 - cosine) / 2.0).max(0.0).sqrt().copysign(xy)];
        if xx + yy >= 0.0 { half } else { [-half[1], half[0]] }
    }
}

impl Search<'_> {
    /// Returns the ridges outside the margins.
    pub(super) fn ridges(&self) -> Vec<Ridge> {
        let grid = &self.responses.grid;
        let margin = Border::Cut.margin_deg(self.channel.frequency) * self.px_per_deg;
        let mut ridges = Vec::new();
        for row in 1..grid.rows.saturating_sub(1) {
            for column in 1..grid.columns.saturating_sub(1) {
                let here = row * grid.columns + column;
                let even = self.responses.even[here];
                let energy = self.responses.energy[here];
                // Skip features closer to an edge than to a line, and invisible ones.
                if even * even >= 0.1 * energy
                    && energy > FAINTEST
                    && self.distances.distance_at(grid.place(column, row)) >= margin
                {
                    ridges.extend(self.ridge(column, row));
                }
            }
        }
        ridges
    }

    fn ridge(&self, column: usize, row: usize) -> Option<Ridge> {
        let Responses { grid, even, odd, energy } = self.responses;
        let here = row * grid.columns + column;
        let even = Local::of(near(even, here, grid.columns));
        let across = even.across();
        let power = Local::of(near(energy, here, grid.columns));
        let curve = power.curvature_along(across);
        let shift = -power.slope_along(across) / curve;
        // The peak must lie in this cell of the grid (Steger 1998, IEEE Trans. PAMI 20:113).
        if !(curve < 0.0 && across.iter().all(|part| (part * shift).abs() <= 0.5)) {
            return None;
        }
        let odd = near(odd, here, grid.columns);
        let right = Local::of(odd.map(|row| row.map(|value| value.re))).moved(across, shift);
        let down = Local::of(odd.map(|row| row.map(|value| value.im))).moved(across, shift);
        let response = Complex64::new(even.moved(across, shift), (right * right + down * down).sqrt());
        if response.re.abs() <= ODD_SHARE * response.im {
            return None;
        }
        let height = response.norm_sqr().sqrt();
        let from = [column as f64, row as f64];
        let least = |toward: f64| self.lowest(from, across.map(|part| part * toward), shift * toward, height).sqrt();
        let before = least(-1.0);
        if before > COUNTS_BELOW * height {
            return None;
        }
        let lowest = before.max(least(1.0));
        let at = [0, 1].map(|axis| grid.first[axis] + (from[axis] + across[axis] * shift) * grid.step[axis]);
        let strength = strength(response, lowest, self.mean.at(at));
        let polarity = if response.re > 0.0 { Polarity::Bright } else { Polarity::Dark };
        // An oblique line has peaks in more cells per unit of length.
        let length_px = grid.step[0] * across[0].abs().max(across[1].abs());
        let frequency = self.channel.frequency;
        (strength > 0.0).then_some(Ridge { at, across, length_px, polarity, strength, energy: height, frequency })
    }

    /// Returns the minimum of the energy on one side of a peak, starting at a grid position and stopping near a border.
    /// If there is no room to search, the energy counts as not falling. The search also stops when the energy has
    /// fallen enough for a peak of height `peak` to count in full; a further fall would not matter.
    fn lowest(&self, from: [f64; 2], across: [f64; 2], shift: f64, peak: f64) -> f64 {
        let Responses { grid, energy, .. } = self.responses;
        let far = FALL_PERIODS / self.channel.frequency * self.px_per_deg / grid.step[0];
        let far = far.min(grid.columns.min(grid.rows) as f64 / 2.0);
        let unusable = Border::Cut.unusable_deg(self.channel.frequency) * self.px_per_deg;
        let enough = (COUNTS_FULLY_BELOW * peak).powi(2);
        let mut least = f64::MAX;
        let mut along = 1.0;
        while along <= far && least > enough {
            let index = [0, 1].map(|axis| from[axis] + across[axis] * (shift + along));
            let place = [0, 1].map(|axis| grid.first[axis] + index[axis] * grid.step[axis]);
            if self.distances.distance_at(place) < unusable {
                break;
            }
            least = least.min(grid.between(energy, index));
            along += 1.0;
        }
        least
    }
}
