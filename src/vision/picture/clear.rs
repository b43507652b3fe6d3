//! How far every place of an image is from where bands do not count.

use super::image::Picture;

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
