//! A channel, and the rule that tells bands from edges and from lines.

use std::f64::consts::LN_2;

use rayon::prelude::*;
use rustfft::num_complex::Complex64;

use super::{
    band::BandMap,
    blur::{Blur, Interpolation},
    eye::Eye,
    image::Grid,
};
use crate::system::checkpoint;

/// A channel: a filter whose gain is a Gaussian of the logarithm of frequency (log-Gabor; Field 1987, J. Opt. Soc. Am.
/// A 4:2379).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FrequencyChannel {
    /// Preferred frequency, cycles per degree.
    pub(super) frequency: f64,
}

/// σ of a channel's Gaussian, given as a ratio of frequencies. 0.65 is a bandwidth of 1.5 octaves at half height, close
/// to the median of cells in V1 (1.4 in De Valois, Albrecht & Thorell 1982, Vis. Res. 22:545).
const RATIO: f64 = 0.65;
/// Frequency of the lowest channel, cycles per degree: half its period is 8°.
const MIN_FREQUENCY: f64 = 0.0625;
/// Channels per octave. The bands of neighboring channels overlap so far that more channels change nothing.
const PER_OCTAVE: u32 = 3;
/// Number of channels. They span seven octaves; the highest is 8 cycles per degree, above which the bands of even the
/// narrowest visible ramps are weak.
const CHANNELS: u32 = 22;
/// Samples per period of a channel's responses.
pub(super) const SAMPLES_PER_PERIOD: f64 = 12.0;
/// Samples per period of what is blurred.
const BLURRED_PER_PERIOD: f64 = 4.0;

/// The even response must exceed this multiple of the odd response nearby: otherwise, the place belongs to an edge.
const ODD_SHARE: f64 = 1.2;
/// From this multiple on, the even response counts in full.
const FULL_SHARE: f64 = 1.56;
/// σ of the neighborhood whose odd response counts, periods of the channel.
const NEARBY_PERIODS: f64 = 0.8;
/// The exponent with which the odd response is pooled over the neighborhood. With 8, the largest value dominates.
const NEARBY_POWER: i32 = 8;
/// The Gaussian is cut off at this many σ. After the root, it still reaches a tenth there.
const NEARBY_REACH: f64 = 6.0;
/// The part of the even response an octave below that limits the response: a band is seen at more than one scale.
const COARSE_SHARE: f64 = 0.8;
/// The light counts as monotone across a place from the second share on, and as a line of its own up to the first.
/// The share is the length of the mean slope, divided by the mean length of the slopes: 1 if the light only rises or only
/// falls, and 0 at a symmetric line.
const MONOTONE: [f64; 2] = [0.6, 0.9];
/// σ of the blur of the light whose slope is taken, periods of the channel.
pub(super) const SLOPE_PERIODS: f64 = 0.2;
/// σ of the final blur, along the band and across it, periods of the channel.
const BAND_PERIODS: f64 = 0.5;
/// Where a Gaussian is cut off otherwise, σ.
const REACH: f64 = 4.0;
/// Visibility per unit of a channel's response, such that a thin line at its threshold has a visibility of 1:
/// `cargo run --release -p tools -- thresholds`.
const UNIT: f64 = 3.357;
/// Contrast gain control: at this odd response nearby, in units of visibility, a response is halved. It is what keeps a
/// tenfold contrast from making bands ten times as visible (Wallis & Georgeson 2012).
const HALVED_AT: f64 = 120.0;
/// Stray light relative to white: light reflected by the screen or scattered in the eye. Without it, bands on black
/// would be infinitely strong.
const VEIL: f64 = 0.01;
/// Exponent for pooling over channels.
const POOLING: i32 = 2;
impl FrequencyChannel {
    /// Returns all channels, starting with the coarsest.
    pub(super) fn all() -> impl DoubleEndedIterator<Item = FrequencyChannel> {
        (0..CHANNELS).map(|k| FrequencyChannel {
            frequency: MIN_FREQUENCY * (LN_2 * f64::from(k) / f64::from(PER_OCTAVE)).exp(),
        })
    }

    /// Returns the channel an octave below.
    pub(super) fn octave_below(self) -> FrequencyChannel {
        FrequencyChannel { frequency: 0.5 * self.frequency }
    }

    /// Returns the share of a grating's amplitude that the channel passes, 0…1. `ratio` is the logarithm of the
    /// grating's frequency divided by the channel's frequency.
    #[must_use]
    pub(super) fn passes_log(self, ratio: f64) -> f64 {
        (-0.5 * (ratio / RATIO.ln()).powi(2)).exp()
    }
}

/// A channel's responses to the light on a grid, in units of the light.
pub(super) struct Fields {
    pub(super) grid: Grid,
    /// Even response of the channel in the real part, and of the channel an octave below in the imaginary part.
    pub(super) even: Vec<Complex64>,
    /// Odd response: the rightward part in the real component, and the downward part in the imaginary component.
    pub(super) odd: Vec<Complex64>,
    /// The even response of straight structure: its length is that of the even response across a straight line or edge
    /// and 0 at a round spot; its angle is twice that of the direction across the line.
    pub(super) straight: Vec<Complex64>,
    /// Slope of the blurred light: right and down. Its unit does not matter.
    pub(super) slope: Vec<Complex64>,
}

/// A channel's answer: bright bands are positive, dark bands negative.
pub(super) struct Answer {
    pub(super) grid: Grid,
    /// Lines that are not in the light.
    pub(super) bands: Vec<f64>,
    /// Lines that are.
    pub(super) lines: Vec<f64>,
}

impl Fields {
    /// Returns the answer of `channel` in the eye `eye`. `mean` is the mean light at a place, and `weight`, 0…1, is how
    /// far bands count there; both are given a place of the grid.
    pub(super) fn answer(
        self,
        channel: FrequencyChannel,
        px_per_deg: f64,
        eye: &Eye,
        mean: impl Fn([f64; 2]) -> f64,
        weight: impl Fn([f64; 2]) -> f64,
    ) -> Answer {
        let Fields { grid, even, odd, straight, slope } = self;
        let sensitivity = UNIT * eye.sensitivity.at(channel.frequency, eye.luminance);
        let orientation = |of: fn(Complex64) -> f64| -> Vec<f64> {
            let orientations = odd.iter().zip(&even).zip(&straight);
            orientations.map(|((odd, even), straight)| of(odd * odd + straight * even.re)).collect()
        };
        let orientations = [orientation(|o| o.re), orientation(|o| o.im)];
        let per_period = grid.step.map(|step| px_per_deg / (step * channel.frequency));
        let stride = (per_period[0].max(per_period[1]) / BLURRED_PER_PERIOD).floor().max(1.0) as usize;
        let blur = Blur::new(&grid, stride);
        let blurred = |values: &[f64], periods: f64| blur.blur(values, per_period.map(|n| n * periods), REACH);
        let context = {
            let powers: Vec<f64> = odd.iter().map(|odd| odd.norm_sqr().powi(NEARBY_POWER / 2)).collect();
            drop(odd);
            let nearby = blur.blur(&powers, per_period.map(|n| n * NEARBY_PERIODS), NEARBY_REACH);
            let part: [fn(&Complex64) -> f64; 3] = [|slope| slope.re, |slope| slope.im, |slope| length(*slope)];
            let slopes = part.map(|part| blurred(&slope.iter().map(part).collect::<Vec<_>>(), NEARBY_PERIODS));
            drop(slope);
            let monotone = (0..nearby.len()).map(|i| {
                let [right, down, total] = slopes.each_ref().map(|part| part[i]);
                let share = if total > 0.0 { right.hypot(down) / total } else { 1.0 };
                ((share - MONOTONE[0]) / (MONOTONE[1] - MONOTONE[0])).clamp(0.0, 1.0)
            });
            let nearby: Vec<f64> = nearby.iter().map(|power| power.powf(1.0 / f64::from(NEARBY_POWER))).collect();
            let places = (0..blur.grid.rows).flat_map(|row| (0..blur.grid.columns).map(move |column| (column, row)));
            let mean = |(column, row)| mean(blur.grid.place(column, row)).max(0.0);
            let gain: Vec<f64> = places.map(|place| sensitivity / (mean(place) + VEIL)).collect();
            [nearby, monotone.collect(), gain]
        };
        let enlarged = Interpolation::new(&blur.grid, &grid);
        let mut buffer = Vec::new();
        let mut row_of = |values: &[f64], row: usize| {
            let mut to = vec![0.0; grid.columns];
            enlarged.row(values, row, &mut buffer, &mut to);
            to
        };
        let [nearby, monotone, gain] = &context;
        let mut above: Vec<f64>;
        let mut nearby_here = Vec::new();
        let mut below = row_of(nearby, 0);
        let mut parts = [0; 3].map(|_| vec![0.0; even.len()]);
        for row in 0..grid.rows {
            above = std::mem::replace(&mut nearby_here, below);
            below = if row + 1 < grid.rows { row_of(nearby, row + 1) } else { Vec::new() };
            let (monotone, gain) = (row_of(monotone, row), row_of(gain, row));
            for column in 0..grid.columns {
                let i = row * grid.columns + column;
                let here = Local { even: even[i], straight: straight[i], nearby: nearby_here[column] };
                let split = |local: Local| local.split(monotone[column].clamp(0.0, 1.0), gain[column]);
                let local = |i: usize, nearby: f64| Local { even: even[i], straight: straight[i], nearby };
                let mut sum = split(here);
                if here.may_matter() {
                    let mut add = |before: Local, after: Local| {
                        let [first, last] = [-1.0, 1.0].map(|side| split(here.between(&before, &after, side / 3.0)));
                        let middle = split(here);
                        (0..3).for_each(|k| sum[k] += (first[k] + last[k] - 2.0 * middle[k]) / 3.0);
                    };
                    if 0 < column && column + 1 < grid.columns {
                        add(local(i - 1, nearby_here[column - 1]), local(i + 1, nearby_here[column + 1]));
                    }
                    if 0 < row && row + 1 < grid.rows {
                        add(local(i - grid.columns, above[column]), local(i + grid.columns, below[column]));
                    }
                }
                (0..3).for_each(|k| parts[k][i] = sum[k]);
            }
        }
        let [right, up, lines] = parts.map(|part| blurred(&part, BAND_PERIODS));
        let reduced = Interpolation::new(&grid, &blur.grid);
        let mut directions = [0; 2].map(|_| vec![0.0; blur.grid.columns]);
        let mut answer = Answer { grid: blur.grid.clone(), bands: right, lines };
        for row in 0..blur.grid.rows {
            for (values, to) in orientations.iter().zip(&mut directions) {
                reduced.row(values, row, &mut buffer, to);
            }
            for (column, (cosine, sine)) in directions[0].iter().zip(&directions[1]).enumerate() {
                let i = row * blur.grid.columns + column;
                let direction = unit(Complex64::new(*cosine, *sine));
                let weight = weight(blur.grid.place(column, row));
                answer.bands[i] = (answer.bands[i] * direction.re + up[i] * direction.im) * weight;
                answer.lines[i] *= weight;
            }
        }
        answer
    }
}

/// Returns the unit vector in the same direction, or 0 for 0.
fn unit(value: Complex64) -> Complex64 {
    let length = length(value);
    if length > 0.0 { value / length } else { value }
}

/// Returns the length; faster than the library's, which also serves the smallest and the largest numbers.
fn length(value: Complex64) -> f64 {
    value.norm_sqr().sqrt()
}

/// What decides at one place.
#[derive(Clone, Copy)]
struct Local {
    /// Even response of the channel, and an octave below.
    even: Complex64,
    /// Even response of straight structure.
    straight: Complex64,
    /// Odd response of the neighborhood.
    nearby: f64,
}

impl Local {
    /// Whether the response can be above 0 here or between here and a neighbor.
    fn may_matter(&self) -> bool {
        1.5 * self.even.re.abs() > ODD_SHARE * self.nearby
    }

    /// Interpolates at `at`, −½…½, on the parabola through two neighbors and this place.
    fn between(&self, before: &Local, after: &Local, at: f64) -> Local {
        let [half, square] = [0.5 * at, 0.5 * at * at];
        Local {
            even: self.even + (after.even - before.even) * half + (after.even + before.even - self.even * 2.0) * square,
            straight: self.straight
                + (after.straight - before.straight) * half
                + (after.straight + before.straight - self.straight * 2.0) * square,
            nearby: self.nearby
                + (after.nearby - before.nearby) * half
                + (after.nearby + before.nearby - self.nearby * 2.0) * square,
        }
    }

    /// Splits the response into that of a band, which is not in the light, and that of a line, which is. `monotone`,
    /// 0…1, tells whether the light only rises or falls. The band is a vector whose angle is twice that of the
    /// direction across it; a bright line is positive.
    fn split(&self, monotone: f64, gain: f64) -> [f64; 3] {
        let (size, nearby) = (self.even.re.abs(), self.nearby.max(0.0));
        if size <= ODD_SHARE * nearby {
            return [0.0; 3];
        }
        let straight = length(self.straight);
        let beyond =
            |response: f64| ((response - ODD_SHARE * nearby) / (1.0 - ODD_SHARE / FULL_SHARE)).clamp(0.0, size);
        let controlled = gain / (1.0 + gain * nearby / HALVED_AT);
        let line = controlled * (1.0 - monotone) * beyond(size);
        let coarse = COARSE_SHARE * self.even.im * self.even.re.signum();
        let band = controlled * monotone * beyond(size.min(straight).min(coarse));
        let share = if band > 0.0 { band / straight } else { 0.0 };
        [share * self.straight.re, share * self.straight.im, line.copysign(self.even.re)]
    }
}

/// Pools the answers of all channels, each on its own grid, at the places of the grid `to`. Returns the map of bands and
/// the map of lines.
pub(super) fn pooled(answers: &[Answer], to: &Grid) -> [BandMap; 2] {
    let interpolations: Vec<Interpolation> =
        answers.iter().map(|answer| Interpolation::new(&answer.grid, to)).collect();
    let of: [fn(&Answer) -> &[f64]; 2] = [|answer| &answer.bands, |answer| &answer.lines];
    of.map(|of| {
        let mut map = BandMap { bright: vec![0.0; to.columns * to.rows], dark: vec![0.0; to.columns * to.rows] };
        let rows = map.bright.par_chunks_mut(to.columns).zip(map.dark.par_chunks_mut(to.columns));
        rows.enumerate().for_each_init(
            || (Vec::new(), vec![0.0; to.columns]),
            |(buffer, values), (row, (bright, dark))| {
                checkpoint();
                for (interpolation, answer) in interpolations.iter().zip(answers) {
                    interpolation.row(of(answer), row, buffer, values);
                    for ((value, bright), dark) in values.iter().zip(&mut *bright).zip(&mut *dark) {
                        *(if *value > 0.0 { bright } else { dark }) += value.abs().powi(POOLING);
                    }
                }
                bright.iter_mut().chain(dark).for_each(|sum| *sum = visibility(*sum));
            },
        );
        map
    })
}

/// Returns the visibility for the sum of all channels' answers, each to the power of [`POOLING`].
fn visibility(sum: f64) -> f64 {
    (sum / f64::from(PER_OCTAVE)).powf(1.0 / f64::from(POOLING))
}
