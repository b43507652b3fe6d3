//! In an image: wherever bands are, and whichever way they run.

use std::f64::consts::PI;

use rayon::prelude::*;
use rustfft::{FftPlanner, num_complex::Complex64};

use super::{
    Border, VisionError,
    band::{Band, Polarity, Pool, Visibility, unmasked},
    eye::{ADAPTATION_DEG, Channel, Eye},
    line::smooth,
    ridge::{Field, Ridge},
};

/// Frequencies of a channel that are computed, times its own: beyond, it passes less than a hundredth.
const REACH: f64 = 6.0;
/// Highest frequency of the mean light, cycles a degree.
const MEAN_TOP: f64 = 2.0;
/// Places in a degree at which channels mask each other.
const MASK_PER_DEG: f64 = 16.0;
/// Least pixels on a side.
const LEAST: usize = 16;

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

/// What is seen in an image.
#[derive(Clone, Debug, Default)]
pub struct PictureView {
    /// Of every channel, at every place of its lines, the strongest first.
    pub bands: Vec<Band>,
    /// Of the strongest place, over all channels.
    pub visibility: Visibility,
    /// How much band there is: strength times length over the area judged, for every channel, added up over channels
    /// as visibility is; per degree.
    pub density: f64,
    /// Strength of bright and of dark bands at every pixel, over all channels.
    pub map: BandMap,
}

/// Lines of bands, drawn one pixel wide.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BandMap {
    /// Bright bands.
    pub bright: Vec<f64>,
    /// Dark bands.
    pub dark: Vec<f64>,
}

impl Picture<'_> {
    /// What `eye` sees of it.
    ///
    /// # Errors
    /// [`VisionError`] for an image smaller than 16 × 16 pixels or than three periods of the finest channel, for light
    /// that is negative or no number, and for all black.
    pub fn see(&self, eye: &Eye) -> Result<PictureView, VisionError> {
        self.check()?;
        let spectrum = Spectrum::new(self, eye);
        let clear = Clear::new(self);
        let side = self.width.min(self.height) as f64 / self.px_per_deg;
        // A channel without room between its margins sees nothing.
        let channels: Vec<Channel> = Channel::all()
            .filter(|channel| 2.0 * Border::Cut.margin_deg(channel.frequency) < side)
            .filter(|channel| is_sampled(*channel, self.px_per_deg))
            .collect();
        if channels.is_empty() {
            let least = least_side(self.px_per_deg);
            return Err(VisionError::TooSmall { width: self.width, height: self.height, least });
        }
        let mean = spectrum.mean();
        let seen: Vec<(Vec<Ridge>, Coarse)> = channels
            .par_iter()
            // The finest first: they take longest.
            .rev()
            .map(|channel| self.ridges(*channel, &spectrum, &mean, &clear))
            .collect();
        Ok(self.view(&unmask(seen), &clear))
    }

    fn check(&self) -> Result<(), VisionError> {
        if !(self.px_per_deg.is_finite() && self.px_per_deg > 0.0) {
            return Err(VisionError::Sampling(self.px_per_deg));
        }
        if self.width.min(self.height) < LEAST {
            return Err(VisionError::TooSmall { width: self.width, height: self.height, least: LEAST });
        }
        let found = self.mask.map_or(self.light.len(), |mask| mask.len().min(self.light.len()));
        super::check(self.light.iter().copied(), self.width, self.height, found)
    }

    /// A channel's ridges, and its energy for those that it masks.
    fn ridges(&self, channel: Channel, spectrum: &Spectrum, mean: &Grid, clear: &Clear) -> (Vec<Ridge>, Coarse) {
        let [even, odd] = spectrum.respond(channel);
        let px = |deg: f64| deg * self.px_per_deg;
        let field = Field {
            even: &even,
            odd: &odd,
            channel,
            px_per_deg: self.px_per_deg,
            clear,
            margin: px(Border::Cut.margin_deg(channel.frequency)),
            beside: px(Border::Cut.beside_deg(channel.frequency)),
        };
        (field.ridges(mean), Coarse::new(self, &field))
    }

    fn view(&self, seen: &[Vec<Ridge>], clear: &Clear) -> PictureView {
        let mut pool = Pool::default();
        let mut density = Pool::default();
        let area = clear.area() / (self.px_per_deg * self.px_per_deg);
        let mut map = BandMap { bright: vec![0.0; self.light.len()], dark: vec![0.0; self.light.len()] };
        let mut bands = Vec::new();
        for ridges in seen {
            let mut amount = Visibility::default();
            let strongest = Visibility {
                bright: self.strongest(ridges, Polarity::Bright),
                dark: self.strongest(ridges, Polarity::Dark),
            };
            for ridge in ridges {
                let length = ridge.length_px / self.px_per_deg;
                amount.bright += ridge.strength * length / area;
                self.draw(ridge, &mut map);
                bands.push(self.band(ridge));
            }
            pool.add(strongest);
            density.add(amount);
        }
        for value in map.bright.iter_mut().chain(&mut map.dark) {
            *value = value.cbrt();
        }
        bands.sort_by(|a: &Band, b| b.strength.total_cmp(&a.strength));
        PictureView { bands, visibility: pool.visibility(), density: density.visibility().bright, map }
    }

    /// What a period's length of a channel's bands exceeds: a single place, where lines cross or end, is none.
    fn strongest(&self, ridges: &[Ridge], polarity: Polarity) -> f64 {
        let mut places: Vec<(f64, f64)> = ridges
            .iter()
            .filter(|ridge| ridge.polarity == polarity)
            .map(|ridge| (ridge.strength, ridge.length_px / self.px_per_deg * ridge.frequency))
            .collect();
        places.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut periods = 0.0;
        let long_enough = places.iter().find(|(_, length)| {
            periods += length;
            periods >= 1.0
        });
        long_enough.map_or(0.0, |(strength, _)| *strength)
    }

    fn band(&self, ridge: &Ridge) -> Band {
        let at_deg = [
            (ridge.at[0] - self.width as f64 / 2.0) / self.px_per_deg,
            (self.height as f64 / 2.0 - ridge.at[1]) / self.px_per_deg,
        ];
        let [x, y] = ridge.across;
        let orientation_deg = (-y).atan2(x).to_degrees().rem_euclid(180.0);
        let Ridge { polarity, strength, frequency, .. } = *ridge;
        Band { at_deg, orientation_deg, polarity, strength, frequency }
    }

    /// A stroke as long as the ridge's step, so that lines of coarse channels have no holes.
    fn draw(&self, ridge: &Ridge, map: &mut BandMap) {
        let map = match ridge.polarity {
            Polarity::Bright => &mut map.bright,
            Polarity::Dark => &mut map.dark,
        };
        let steps = ridge.length_px.ceil().max(1.0) as usize;
        let mut last = usize::MAX;
        for step in 0..steps {
            let along = ((step as f64 + 0.5) / steps as f64 - 0.5) * ridge.length_px;
            let x = (ridge.at[0] - along * ridge.across[1]).floor();
            let y = (ridge.at[1] + along * ridge.across[0]).floor();
            if x < 0.0 || y < 0.0 || x >= self.width as f64 || y >= self.height as f64 {
                continue;
            }
            let pixel = y as usize * self.width + x as usize;
            if pixel != last {
                map[pixel] += ridge.strength.powi(3);
                last = pixel;
            }
        }
    }
}

/// Energy at a few places.
struct Coarse {
    values: Vec<f64>,
    columns: usize,
    /// Pixels from one to the next.
    step: f64,
    /// Of the image, pixels.
    size: [usize; 2],
}

impl Coarse {
    fn new(picture: &Picture, field: &Field) -> Coarse {
        let step = (picture.px_per_deg / MASK_PER_DEG).max(1.0);
        let count = |side: usize| (side as f64 / step).ceil() as usize + 1;
        let (columns, rows) = (count(picture.width), count(picture.height));
        // About the middle, so that an image that is turned is masked as before.
        let place = |i: usize, n: usize, side: usize| side as f64 / 2.0 + (i as f64 - (n - 1) as f64 / 2.0) * step;
        let energy = |i: usize| {
            let (x, y) = (place(i % columns, columns, picture.width), place(i / columns, rows, picture.height));
            (field.even.at(x, y).re.powi(2) + field.odd.at(x, y).norm_sqr()).sqrt()
        };
        Coarse {
            values: (0..columns * rows).map(energy).collect(),
            columns,
            step,
            size: [picture.width, picture.height],
        }
    }

    /// Of the four places around this one, pixels, in proportion.
    fn at(&self, at: [f64; 2]) -> f64 {
        let rows = self.values.len() / self.columns;
        let index = |at: f64, n: usize, side: usize| {
            let i = ((at - side as f64 / 2.0) / self.step + (n - 1) as f64 / 2.0).clamp(0.0, (n - 1) as f64);
            let whole = (i as usize).min(n.saturating_sub(2));
            (whole, (whole + 1).min(n - 1), i - whole as f64)
        };
        let (x0, x1, right) = index(at[0], self.columns, self.size[0]);
        let (y0, y1, down) = index(at[1], rows, self.size[1]);
        let value = |x: usize, y: usize| self.values[y * self.columns + x];
        let upper = value(x0, y0) * (1.0 - right) + value(x1, y0) * right;
        let lower = value(x0, y1) * (1.0 - right) + value(x1, y1) * right;
        upper * (1.0 - down) + lower * down
    }
}

/// Takes from every ridge what finer channels mask; the finest come first.
fn unmask(seen: Vec<(Vec<Ridge>, Coarse)>) -> Vec<Vec<Ridge>> {
    let mut finer: Option<Coarse> = None;
    let mut left = Vec::with_capacity(seen.len());
    for (mut ridges, coarse) in seen {
        if let Some(finer) = &finer {
            for ridge in &mut ridges {
                ridge.strength *= unmasked(ridge.energy, finer.at(ridge.at));
            }
            ridges.retain(|ridge| ridge.strength > 0.0);
        }
        left.push(ridges);
        finer = Some(match finer {
            Some(mut finer) => {
                finer.values.iter_mut().zip(&coarse.values).for_each(|(most, value)| *most = most.max(*value));
                finer
            }
            None => coarse,
        });
    }
    left
}

/// Whether an image of this sampling has the channel's frequency.
fn is_sampled(channel: Channel, px_per_deg: f64) -> bool {
    channel.frequency < px_per_deg / 2.0
}

/// Pixels that a side needs for the finest channel to have room between its margins.
fn least_side(px_per_deg: f64) -> usize {
    let finest = Channel::all().filter(|channel| is_sampled(*channel, px_per_deg)).last();
    let margins = finest.map_or(0.0, |channel| 2.0 * Border::Cut.margin_deg(channel.frequency) * px_per_deg);
    (margins.floor() as usize + 1).max(LEAST)
}

/// Values on a grid that is laid about the image's middle, so that an image that is turned or mirrored has the same.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    pub(super) values: Vec<Complex64>,
    pub(super) columns: usize,
    pub(super) rows: usize,
    /// Pixels from one value to the next, across and down.
    pub(super) step: [f64; 2],
    /// Where the image's middle is, pixels.
    pub(super) middle: [f64; 2],
}

impl Grid {
    /// With the values of which these are the transform.
    fn transformed(mut self, mut transformed: Vec<Complex64>) -> Grid {
        transform(&mut transformed, self.columns, self.rows, true);
        self.values = transformed;
        self
    }

    /// At a place of the image, pixels: between four values.
    pub(super) fn at(&self, x: f64, y: f64) -> Complex64 {
        let place = |x: f64, middle: f64, step: f64, n: usize| {
            let i = (x - middle) / step - 0.5 + n as f64;
            let whole = i.floor();
            (whole as usize % n, (whole as usize + 1) % n, i - whole)
        };
        let (x0, x1, right) = place(x, self.middle[0], self.step[0], self.columns);
        let (y0, y1, down) = place(y, self.middle[1], self.step[1], self.rows);
        let value = |x: usize, y: usize| self.values[y * self.columns + x];
        let upper = value(x0, y0) * (1.0 - right) + value(x1, y0) * right;
        let lower = value(x0, y1) * (1.0 - right) + value(x1, y1) * right;
        upper * (1.0 - down) + lower * down
    }
}

/// The image's spectrum.
struct Spectrum {
    /// Of the light, for its mean.
    light: Vec<Complex64>,
    /// As the eye is sensitive to it.
    seen: Vec<Complex64>,
    columns: usize,
    rows: usize,
    px_per_deg: f64,
    middle: [f64; 2],
}

impl Spectrum {
    fn new(picture: &Picture, eye: &Eye) -> Spectrum {
        let side = picture.width.min(picture.height);
        // Half a period of the coarsest channel, which has room twice in the shorter side.
        let beyond = (side / 4).max(8);
        let (columns, rows) = (smooth(picture.width + beyond), smooth(picture.height + beyond));
        let mut light = periodic(picture, columns, rows);
        transform(&mut light, columns, rows, false);
        let middle = [picture.width as f64 / 2.0, picture.height as f64 / 2.0];
        let px_per_deg = picture.px_per_deg;
        let mut spectrum = Spectrum { light, seen: Vec::new(), columns, rows, px_per_deg, middle };
        spectrum.seen = spectrum.light.clone();
        let frequencies = [spectrum.frequencies(columns, columns), spectrum.frequencies(rows, rows)];
        let [across, down] = frequencies.each_ref().map(|f| f.iter().map(|f| sinc(f / px_per_deg)).collect::<Vec<_>>());
        spectrum.seen.par_chunks_mut(columns).enumerate().for_each(|(row, values)| {
            for (column, value) in values.iter_mut().enumerate() {
                let f = frequencies[0][column].hypot(frequencies[1][row]);
                // Pixels are squares.
                *value *= if f > 0.0 { eye.sensitivity(f) * across[column] * down[row] } else { 0.0 };
            }
        });
        spectrum
    }

    /// Cycles a degree of `n` places of a transform of which this has `whole`, the highest left out.
    fn frequencies(&self, n: usize, whole: usize) -> Vec<f64> {
        let cycles = |k: usize| if 2 * k < n { k as f64 } else { k as f64 - n as f64 };
        (0..n).map(|k| cycles(k) * self.px_per_deg / whole as f64).collect()
    }

    /// A grid for frequencies up to `top`, still without its values.
    fn grid(&self, top: f64) -> Grid {
        let fit = |n: usize| smooth(((2.0 * top * n as f64 / self.px_per_deg).ceil() as usize).max(8)).min(n);
        let (columns, rows) = (fit(self.columns), fit(self.rows));
        let step = [self.columns as f64 / columns as f64, self.rows as f64 / rows as f64];
        Grid { values: Vec::new(), columns, rows, step, middle: self.middle }
    }

    /// For every place of the grid's transform: its index, the index of the same frequency here, the frequency to the
    /// right and down, and what moves the grid's first place to the image's middle.
    fn each(&self, grid: &Grid, mut each: impl FnMut(usize, usize, [f64; 2], Complex64)) {
        let axis = |n: usize, whole: usize, middle: f64, step: f64| -> Vec<(usize, usize, f64, Complex64)> {
            let frequencies = self.frequencies(n, whole);
            // From the middle of the first pixel.
            let shift = (middle + step / 2.0 - 0.5) / self.px_per_deg;
            let place = |k: usize| if 2 * k < n { k } else { whole - (n - k) };
            (0..n)
                .filter(|k| 2 * k != n)
                .map(|k| (k, place(k), frequencies[k], Complex64::cis(2.0 * PI * frequencies[k] * shift)))
                .collect()
        };
        let across = axis(grid.columns, self.columns, self.middle[0], grid.step[0]);
        let down = axis(grid.rows, self.rows, self.middle[1], grid.step[1]);
        for (to_row, row, fy, turn) in &down {
            for (to_column, column, fx, turned) in &across {
                each(to_row * grid.columns + to_column, row * self.columns + column, [*fx, *fy], turn * turned);
            }
        }
    }

    /// Even and odd response by the monogenic signal (Felsberg & Sommer 2001, IEEE Trans. Signal Process. 49:3136):
    /// its odd part, to the right and down, is the response of the quadrature pair that is turned across the local
    /// structure, so that all orientations are seen alike and none has to be sampled.
    fn respond(&self, channel: Channel) -> [Grid; 2] {
        let grid = self.grid(REACH * channel.frequency);
        let mut even = vec![Complex64::default(); grid.columns * grid.rows];
        let mut odd = even.clone();
        let scale = 1.0 / (self.columns * self.rows) as f64;
        self.each(&grid, |to, from, [fx, fy], shift| {
            let f = (fx * fx + fy * fy).sqrt();
            if f > 0.0 {
                let value = self.seen[from] * shift * (channel.passes(f) * scale);
                even[to] = value;
                odd[to] = value * Complex64::new(fy / f, -fx / f);
            }
        });
        [even, odd].map(|values| grid.clone().transformed(values))
    }

    /// Mean light, for which the eye is set.
    fn mean(&self) -> Grid {
        let grid = self.grid(MEAN_TOP);
        let mut mean = vec![Complex64::default(); grid.columns * grid.rows];
        let scale = 1.0 / (self.columns * self.rows) as f64;
        self.each(&grid, |to, from, [fx, fy], shift| {
            let passes = (-2.0 * (PI * ADAPTATION_DEG).powi(2) * (fx * fx + fy * fy)).exp();
            mean[to] = self.light[from] * shift * (passes * scale);
        });
        grid.transformed(mean)
    }
}

fn sinc(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) }
}

/// The image, and beyond it what its edges promise, turned about them, faded from one side to the other: light and slope
/// go on, where a mere copy of the last pixels would bend every oblique ramp.
fn periodic(picture: &Picture, columns: usize, rows: usize) -> Vec<Complex64> {
    let (width, height) = (picture.width, picture.height);
    let mut values = vec![Complex64::default(); columns * rows];
    for (y, row) in picture.light.chunks_exact(width).enumerate() {
        let to = &mut values[y * columns..][..columns];
        for (value, light) in to.iter_mut().zip(row) {
            value.re = *light;
        }
        for k in 0..columns - width {
            to[width + k].re = beyond(k, columns - width, width, |x| row[x]);
        }
    }
    for x in 0..columns {
        for k in 0..rows - height {
            values[(height + k) * columns + x].re = beyond(k, rows - height, height, |y| values[y * columns + x].re);
        }
    }
    values
}

/// The value `k` of `gap` between the end of `n` values and their beginning.
fn beyond(k: usize, gap: usize, n: usize, value: impl Fn(usize) -> f64) -> f64 {
    let t = (k + 1) as f64 / (gap + 1) as f64;
    let fade = t * t * (3.0 - 2.0 * t);
    let after = 2.0 * value(n - 1) - value((n - 1).saturating_sub(k + 1));
    let before = 2.0 * value(0) - value((gap - k).min(n - 1));
    after + (before - after) * fade
}

/// Fourier transform in two dimensions, without a factor.
fn transform(values: &mut [Complex64], columns: usize, rows: usize, inverse: bool) {
    let mut planner = FftPlanner::new();
    let mut plan = |n| if inverse { planner.plan_fft_inverse(n) } else { planner.plan_fft_forward(n) };
    plan(columns).process(values);
    let mut turned = vec![Complex64::default(); values.len()];
    transpose(values, &mut turned, columns, rows);
    plan(rows).process(&mut turned);
    transpose(&turned, values, rows, columns);
}

/// In tiles that stay in the processor's cache.
fn transpose(from: &[Complex64], to: &mut [Complex64], columns: usize, rows: usize) {
    const TILE: usize = 16;
    for top in (0..rows).step_by(TILE) {
        for left in (0..columns).step_by(TILE) {
            for y in top..(top + TILE).min(rows) {
                for x in left..(left + TILE).min(columns) {
                    to[x * rows + y] = from[y * columns + x];
                }
            }
        }
    }
}

/// How far every pixel is from where bands do not count.
pub(super) struct Clear {
    distances: Vec<f64>,
    width: usize,
    height: usize,
}

impl Clear {
    fn new(picture: &Picture) -> Clear {
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
    pub(super) fn from(&self, x: f64, y: f64) -> f64 {
        if x < 0.0 || y < 0.0 || x >= self.width as f64 || y >= self.height as f64 {
            return 0.0;
        }
        self.distances[y as usize * self.width + x as usize]
    }

    /// Pixels that count.
    fn area(&self) -> f64 {
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
