//! An image, values on grids over it, and how far its places are from where bands do not count.

/// An image in linear light.
#[derive(Clone, Copy, Debug)]
pub struct Picture<'a> {
    /// Luminance, 1 for white, row by row from the upper left corner.
    pub light: &'a [f64],
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Pixels in a degree.
    pub px_per_deg: f64,
    /// Where bands count, as long as the light: without it everywhere.
    pub mask: Option<&'a [bool]>,
}

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

/// Distances in pixels.
pub(super) struct Clear {
    distances: Vec<f64>,
    width: usize,
    height: usize,
}

impl Clear {
    pub(super) fn new(picture: &Picture) -> Clear {
        let (width, height) = (picture.width, picture.height);
        let edge = |x: usize, y: usize| {
            let across = (x + 1).min(width - x).min(y + 1).min(height - y);
            across as f64 - 0.5
        };
        let mut distances: Vec<f64> = (0..width * height).map(|i| edge(i % width, i / width)).collect();
        if let Some(mask) = picture.mask {
            for (distance, to_mask) in distances.iter_mut().zip(to_mask(mask, width, height)) {
                *distance = distance.min(to_mask);
            }
        }
        Clear { distances, width, height }
    }

    /// At a place, pixels; 0 outside.
    pub(super) fn from(&self, [x, y]: [f64; 2]) -> f64 {
        if x < 0.0 || y < 0.0 || x >= self.width as f64 || y >= self.height as f64 {
            return 0.0;
        }
        self.distances[y as usize * self.width + x as usize]
    }

    /// Pixels that count.
    pub(super) fn area(&self) -> f64 {
        self.distances.iter().filter(|distance| **distance > 0.0).count().max(1) as f64
    }
}

/// Distance of every pixel from the nearest that does not count, pixels: along columns, and then along rows over the
/// lower envelope of parabolas (Felzenszwalb & Huttenlocher 2012, Theory of Computing 8:415).
fn to_mask(mask: &[bool], width: usize, height: usize) -> Vec<f64> {
    let far = (width + height) as f64;
    let mut squares = vec![0.0; mask.len()];
    for x in 0..width {
        let mut distance = far;
        for y in 0..height {
            distance = if mask[y * width + x] { distance + 1.0 } else { 0.0 };
            squares[y * width + x] = distance;
        }
        distance = far;
        for y in (0..height).rev() {
            distance = if mask[y * width + x] { distance + 1.0 } else { 0.0 };
            let both: f64 = distance.min(squares[y * width + x]);
            squares[y * width + x] = both * both;
        }
    }
    let mut row = vec![0.0; width];
    for squares in squares.chunks_exact_mut(width) {
        row.copy_from_slice(squares);
        envelope(&row, squares);
    }
    squares.iter().map(|square: &f64| square.sqrt()).collect()
}

fn envelope(row: &[f64], lowest: &mut [f64]) {
    let mut apexes: Vec<(usize, f64)> = Vec::with_capacity(row.len());
    for (x, value) in row.iter().enumerate() {
        let meets = |apex: usize| {
            let square = |x: usize| (x * x) as f64;
            (value + square(x) - row[apex] - square(apex)) / (2 * (x - apex)) as f64
        };
        while let Some((apex, from)) = apexes.last().copied() {
            if meets(apex) > from {
                break;
            }
            apexes.pop();
        }
        let from = apexes.last().map_or(f64::NEG_INFINITY, |(apex, _)| meets(*apex));
        apexes.push((x, from));
    }
    let mut k = 0;
    for (x, lowest) in lowest.iter_mut().enumerate() {
        while apexes.get(k + 1).is_some_and(|(_, from)| *from < x as f64) {
            k += 1;
        }
        let apex = apexes[k].0;
        let away = x as f64 - apex as f64;
        *lowest = away * away + row[apex];
    }
}
