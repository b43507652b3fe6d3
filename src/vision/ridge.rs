//! Ridges of the energy in two dimensions, to a part of a sample.

use rustfft::num_complex::Complex64;

use super::{
    band::{FALL_PERIODS, Polarity, strength},
    eye::Channel,
    picture::{Clear, Grid},
};

/// A place of a band.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ridge {
    /// Pixels from the image's upper left corner.
    pub(super) at: [f64; 2],
    /// Unit vector across the band, to the right and down.
    pub(super) across: [f64; 2],
    /// How much of the band's length this place stands for, pixels.
    pub(super) length_px: f64,
    pub(super) polarity: Polarity,
    pub(super) strength: f64,
    /// Of even and odd response together.
    pub(super) energy: f64,
    pub(super) frequency: f64,
}

/// A channel's responses.
pub(super) struct Field<'a> {
    /// In its real part.
    pub(super) even: &'a Grid,
    /// To the right, and down.
    pub(super) odd: &'a Grid,
    pub(super) channel: Channel,
    pub(super) px_per_deg: f64,
    /// How far from an edge places are.
    pub(super) clear: &'a Clear,
    /// Pixels to an edge from which on bands are judged.
    pub(super) margin: f64,
    /// Pixels to an edge from which on the response is looked at.
    pub(super) beside: f64,
}

/// A value, its slope and its curvature, in steps of the grid.
struct Local {
    value: f64,
    slope: [f64; 2],
    /// xx, xy, yy.
    curvature: [f64; 3],
}

impl Local {
    fn of(near: [[f64; 3]; 3]) -> Local {
        let [a, b, c] = near;
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

    /// Unit vector of the strongest curvature.
    fn across(&self) -> [f64; 2] {
        let [xx, xy, yy] = self.curvature;
        let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
        let one = [angle.cos(), angle.sin()];
        let other = [-one[1], one[0]];
        if self.curvature_along(one).abs() >= self.curvature_along(other).abs() { one } else { other }
    }
}

impl Field<'_> {
    /// The ridges that are judged; `mean` is the mean light.
    pub(super) fn ridges(&self, mean: &Grid) -> Vec<Ridge> {
        let Grid { columns, rows, step, middle, .. } = *self.even;
        let energy: Vec<f64> = self
            .even
            .values
            .iter()
            .zip(&self.odd.values)
            .map(|(even, odd)| even.re * even.re + odd.norm_sqr())
            .collect();
        let mut ridges = Vec::new();
        for row in 0..rows {
            // The grid begins at the image's middle and goes on round its edges.
            let y = place(row, rows, step[1], middle[1]);
            for column in 0..columns {
                let x = place(column, columns, step[0], middle[0]);
                if self.clear.from(x, y) >= self.margin
                    && let Some(ridge) = self.ridge(&energy, mean, [column, row], [x, y])
                {
                    ridges.push(ridge);
                }
            }
        }
        ridges
    }

    fn ridge(&self, energy: &[f64], mean: &Grid, [column, row]: [usize; 2], at: [f64; 2]) -> Option<Ridge> {
        let Grid { columns, rows, step, .. } = *self.even;
        let index = |x: usize, y: usize| y % rows * columns + x % columns;
        let near = |value: &dyn Fn(usize) -> f64| {
            [0, 1, 2].map(|y| [0, 1, 2].map(|x| value(index(column + columns + x - 1, row + rows + y - 1))))
        };
        let here = index(column, row);
        let even_here = self.even.values[here].re;
        // What is nearer to an edge than to a line need not be looked at closely.
        if even_here * even_here < 0.1 * energy[here] {
            return None;
        }
        let even = Local::of(near(&|i| self.even.values[i].re));
        let across = even.across();
        let power = Local::of(near(&|i| energy[i]));
        let curve = power.curvature_along(across);
        let shift = -power.slope_along(across) / curve;
        // The peak is in this cell of the grid (Steger 1998, IEEE Trans. PAMI 20:113).
        if curve >= 0.0 || across.iter().any(|part| (part * shift).abs() > 0.5) {
            return None;
        }
        let [right, down] = [
            Local::of(near(&|i| self.odd.values[i].re)).moved(across, shift),
            Local::of(near(&|i| self.odd.values[i].im)).moved(across, shift),
        ];
        let response = Complex64::new(even.moved(across, shift), right.hypot(down));
        let least = |toward: f64| {
            self.lowest(energy, [column as f64, row as f64], at, across.map(|part| part * toward), shift * toward)
        };
        let lowest = least(1.0).max(least(-1.0)).sqrt();
        let moved = [at[0] + across[0] * shift * step[0], at[1] + across[1] * shift * step[1]];
        let strength = strength(response, lowest, mean.at(moved[0], moved[1]).re);
        let polarity = if response.re > 0.0 { Polarity::Bright } else { Polarity::Dark };
        // A line crosses cells in steps of one along its steeper axis.
        let length_px = step[0] / across[0].abs().max(across[1].abs());
        (strength > 0.0).then_some(Ridge {
            at: moved,
            across,
            length_px,
            polarity,
            strength,
            energy: response.norm(),
            frequency: self.channel.frequency,
        })
    }

    /// The least energy on one side, from a place of the grid and of the image on, as far as no edge is near; none at
    /// all is as good as no fall.
    fn lowest(&self, energy: &[f64], [x, y]: [f64; 2], at: [f64; 2], across: [f64; 2], shift: f64) -> f64 {
        let Grid { columns, rows, step, .. } = *self.even;
        let far = FALL_PERIODS / self.channel.frequency * self.px_per_deg / step[0];
        let far = far.min(columns.min(rows) as f64 / 2.0);
        let mut least = f64::MAX;
        let mut along = 1.0;
        while along <= far {
            let by = across.map(|part| part * (shift + along));
            if self.clear.from(at[0] + by[0] * step[0], at[1] + by[1] * step[1]) < self.beside {
                break;
            }
            let x = (x + by[0]).rem_euclid(columns as f64);
            let y = (y + by[1]).rem_euclid(rows as f64);
            let (x0, y0) = (x as usize % columns, y as usize % rows);
            let (x1, y1) = ((x0 + 1) % columns, (y0 + 1) % rows);
            let (right, down) = (x - x.floor(), y - y.floor());
            let value = |x: usize, y: usize| energy[y * columns + x];
            let upper = value(x0, y0) * (1.0 - right) + value(x1, y0) * right;
            let lower = value(x0, y1) * (1.0 - right) + value(x1, y1) * right;
            least = least.min(upper * (1.0 - down) + lower * down);
            along += 1.0;
        }
        least
    }
}

fn place(index: usize, n: usize, step: f64, middle: f64) -> f64 {
    let index = if index < n.div_ceil(2) { index as f64 } else { index as f64 - n as f64 };
    middle + (index + 0.5) * step
}
