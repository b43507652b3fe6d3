//! Values on a grid over an image.

/// Numbers on a grid: `columns` in a row, the first at `first` of the image, pixels, and `step` pixels from one to the
/// next, across and down. Laid about the image's middle, so that an image that is turned or mirrored has the same.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    pub(super) columns: usize,
    pub(super) rows: usize,
    pub(super) first: [f64; 2],
    pub(super) step: [f64; 2],
}

impl Grid {
    /// The place of a value, pixels.
    pub(super) fn place(&self, column: usize, row: usize) -> [f64; 2] {
        [self.first[0] + column as f64 * self.step[0], self.first[1] + row as f64 * self.step[1]]
    }

    /// Where between the values a place of the image is, counted in them.
    fn index(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [(x - self.first[0]) / self.step[0], (y - self.first[1]) / self.step[1]]
    }

    /// One of `values` at a place of the image, pixels.
    fn at(&self, values: &[f64], place: [f64; 2]) -> f64 {
        self.between(values, self.index(place))
    }

    /// Of the four values around, in proportion; beyond the grid that of its edge.
    pub(super) fn between(&self, values: &[f64], [x, y]: [f64; 2]) -> f64 {
        self.mixed(values, Neighbors::of(x, self.columns), Neighbors::of(y, self.rows))
    }

    fn mixed(&self, values: &[f64], across: Neighbors, down: Neighbors) -> f64 {
        let row = |y: usize| {
            let row = &values[y * self.columns..][..self.columns];
            row[across.first] + (row[across.second] - row[across.first]) * across.part
        };
        let upper = row(down.first);
        upper + (row(down.second) - upper) * down.part
    }

    /// `values` at the places of another grid.
    pub(super) fn resampled(&self, values: &[f64], to: &Grid) -> Vec<f64> {
        let across: Vec<Neighbors> =
            (0..to.columns).map(|column| Neighbors::of(self.index(to.place(column, 0))[0], self.columns)).collect();
        let row = |row: usize| {
            let down = Neighbors::of(self.index(to.place(0, row))[1], self.rows);
            across.iter().map(move |across| self.mixed(values, *across, down))
        };
        (0..to.rows).flat_map(row).collect()
    }
}

/// One number at every place of a grid.
pub(super) struct Field {
    pub(super) grid: Grid,
    pub(super) values: Vec<f64>,
}

impl Field {
    /// At a place of the image, pixels.
    pub(super) fn at(&self, place: [f64; 2]) -> f64 {
        self.grid.at(&self.values, place)
    }
}

/// Two values next to each other, and how far it is from the first toward the second.
#[derive(Clone, Copy)]
struct Neighbors {
    first: usize,
    second: usize,
    part: f64,
}

impl Neighbors {
    /// Those around the place `at` of `n`.
    fn of(at: f64, n: usize) -> Neighbors {
        let at = at.clamp(0.0, (n - 1) as f64);
        // A cast cuts off the fraction.
        let first = at as usize;
        Neighbors { first, second: (first + 1).min(n - 1), part: at - first as f64 }
    }
}
