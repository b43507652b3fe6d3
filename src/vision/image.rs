//! An image, grids of values laid over it, and the distances of its pixels from areas where bands do not count.

/// An image in linear light.
#[derive(Clone, Copy, Debug)]
pub struct LuminanceImage<'a> {
    /// Luminance, 1 for white, row by row, starting at the upper left corner.
    pub light: &'a [f64],
    pub width: usize,
    pub height: usize,
    /// Pixels per degree.
    pub px_per_deg: f64,
    /// True for the pixels where bands count; has the same length as `light`. Without a mask, bands count everywhere.
    pub mask: Option<&'a [bool]>,
}

/// A grid of `columns` × `rows` places on an image. The first place is at the position `first`, and neighbors are
/// `step` apart, both in pixels. The grid is centered on the image, so that a rotated or mirrored image has the same
/// grid.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    pub(super) columns: usize,
    pub(super) rows: usize,
    pub(super) first: [f64; 2],
    pub(super) step: [f64; 2],
}

impl Grid {
    /// Returns the position of a grid value in the image, pixels.
    pub(super) fn place(&self, column: usize, row: usize) -> [f64; 2] {
        [self.first[0] + column as f64 * self.step[0], self.first[1] + row as f64 * self.step[1]]
    }
}

/// Returns the indices of the two of `n` values around the position `at`, and the distance of `at` from the first of
/// them.
fn neighbors(at: f64, n: usize) -> (usize, usize, f64) {
    let at = at.clamp(0.0, (n - 1) as f64);
    // The cast truncates the fraction.
    let first = at as usize;
    (first, (first + 1).min(n - 1), at - first as f64)
}

/// A grid with a value at each of its places.
pub(super) struct GridValues {
    pub(super) grid: Grid,
    pub(super) values: Vec<f64>,
}

impl GridValues {
    /// Interpolates linearly between the four values around a position in the image, pixels. Beyond the grid, the values at
    /// its edge continue.
    pub(super) fn at(&self, place: [f64; 2]) -> f64 {
        let Grid { columns, rows, first, step } = &self.grid;
        let at = |axis: usize, n: usize| neighbors((place[axis] - first[axis]) / step[axis], n);
        let (across, down) = (at(0, *columns), at(1, *rows));
        let row = |y: usize| {
            let row = &self.values[y * columns..][..*columns];
            row[across.0] + (row[across.1] - row[across.0]) * across.2
        };
        let upper = row(down.0);
        upper + (row(down.1) - upper) * down.2
    }
}

/// The distance of each pixel from areas where bands do not count, in pixels.
pub(super) struct Distances {
    values: Vec<f64>,
    width: usize,
    height: usize,
}

impl Distances {
    pub(super) fn new(picture: &LuminanceImage) -> Distances {
        let (width, height) = (picture.width, picture.height);
        let to_mask = picture.mask.map(|mask| to_mask(mask, width, height));
        let value = |i: usize| {
            let (x, y) = (i % width, i / width);
            let to_edge = (x + 1).min(width - x).min(y + 1).min(height - y) as f64 - 0.5;
            to_mask.as_ref().map_or(to_edge, |to_mask| to_edge.min(to_mask[i]))
        };
        Distances { values: (0..width * height).map(value).collect(), width, height }
    }

    /// Returns the distance at a position in pixels, or 0 outside the image.
    pub(super) fn distance_at(&self, [x, y]: [f64; 2]) -> f64 {
        if x < 0.0 || y < 0.0 || x > self.width as f64 || y > self.height as f64 {
            return 0.0;
        }
        // The mean of the nearest pixels, so that a mirrored image has the same distances.
        let near = |at: f64, side: usize| [at.ceil() - 1.0, at.floor()].map(|i| (i.max(0.0) as usize).min(side - 1));
        let ([left, right], [top, bottom]) = (near(x, self.width), near(y, self.height));
        let at = |x: usize, y: usize| self.values[y * self.width + x];
        0.25 * (at(left, top) + at(right, top) + at(left, bottom) + at(right, bottom))
    }

    /// Returns the number of pixels where bands count, at least 1.
    pub(super) fn area(&self) -> f64 {
        self.values.iter().filter(|distance| **distance > 0.0).count().max(1) as f64
    }
}

/// Returns the distance of each pixel from the nearest pixel that does not count, in pixels. It is computed first along
/// the columns, and then along the rows as the lower envelope of parabolas (Felzenszwalb & Huttenlocher 2012, Theory of
/// Computing 8:415).
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
