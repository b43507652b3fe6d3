//! Codes of fewer bits in files of more, such as the 10 bits of a camera in 16.

use super::{CodeImage, Samples};

/// So many bits of coincidence are not believed.
const BEYOND_CHANCE: u32 = 20;

/// The levels that the codes of a picture can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Levels {
    /// The number of bits that differ from level to level.
    pub bits: u32,
    /// The number of bits of a code.
    pub of: u32,
    form: Form,
}

/// How a level is written with more bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    /// The highest level becomes the highest code.
    Scaled,
    /// The same, but the bits of the level are repeated.
    Repeated,
    /// Zeros follow.
    Shifted,
}

impl Levels {
    /// Returns the fewest levels that all codes of a picture have. They are of `known` bits if that is possible;
    /// otherwise, it must be unlikely that codes only happen to be among fewer levels.
    pub fn of(image: &CodeImage, known: u32) -> Levels {
        let of = image.bits();
        let codes = match &image.samples {
            Samples::Eight(codes) => distinct(codes.iter().map(|code| u32::from(*code))),
            Samples::Sixteen(codes) => distinct(codes.iter().map(|code| u32::from(*code))),
        };
        let is_known = |bits: &u32| known == *bits || codes.len() as u32 * (of - bits) >= BEYOND_CHANCE;
        let bits = std::iter::once(known).chain(1..of).filter(|bits| (1..of).contains(bits)).filter(is_known);
        let all =
            bits.flat_map(|bits| [Form::Scaled, Form::Repeated, Form::Shifted].map(|form| Levels { bits, of, form }));
        let fits = |levels: &Levels| codes.iter().all(|code| levels.code(levels.level(*code)) == *code);
        all.into_iter().find(fits).unwrap_or(Levels { bits: of, of, form: Form::Scaled })
    }

    /// Returns the level of a code: 0, 1, 2, …
    pub fn level(self, code: u32) -> u32 {
        match self.form {
            Form::Scaled => (f64::from(code) * full(self.bits) / full(self.of)).round() as u32,
            Form::Repeated | Form::Shifted => code >> (self.of - self.bits),
        }
    }

    /// Returns the code of a level.
    fn code(self, level: u32) -> u32 {
        let shifted = level << (self.of - self.bits);
        match self.form {
            Form::Scaled => (f64::from(level) * full(self.of) / full(self.bits)).round() as u32,
            Form::Shifted => shifted,
            Form::Repeated => (0..self.of).step_by(self.bits as usize).fold(0, |code, by| code | shifted >> by),
        }
    }

    /// Returns the encoded value of a level, which may lie between two levels: 0…1.
    pub fn encoded(self, level: f64) -> f64 {
        match self.form {
            Form::Scaled | Form::Repeated => level / full(self.bits),
            Form::Shifted => level * f64::from(1 << (self.of - self.bits)) / full(self.of),
        }
    }
}

/// How many steps are looked at on either side of one, ...
const NEAR: usize = 3;
/// ... and how many of them must be alike. Colors that are only few are not evenly spaced.
const ALIKE: usize = 3;
/// A step leads from a level to the nearest one to which at least one in so many changes leads as to the most frequent one, ...
const FREQUENT: usize = 4;
/// ... if these are at least one in so many of all changes from it.
const MANY: usize = 3;

/// Returns, for each level of a channel, how far the values that were rounded to it reach below and above it: half of the
/// step from it, if the steps there are even, as after posterizing or stretching the contrast, and otherwise half a level.
/// Steps are what most often lies between neighboring pixels, so that text over a ramp does not hide its steps, and flat
/// areas of a few colors are none. Also returns whether most changes are larger than steps.
pub fn reaches(channel: &[f64], width: usize) -> (Vec<[f64; 2]>, bool) {
    let beside = channel.chunks_exact(width).flat_map(|row| row.iter().zip(&row[1..]));
    let beside = beside.chain(channel.iter().zip(channel.iter().skip(width))).filter(|(a, b)| a != b);
    let mut changes: Vec<[u16; 2]> = beside.map(|(a, b)| [a.min(*b) as u16, a.max(*b) as u16]).collect();
    changes.sort_unstable();
    let counts = || changes.chunk_by(PartialEq::eq).map(|alike| (alike[0].map(usize::from), alike.len()));
    // The changes to levels below and above each level: all of them, those to the most frequent one, and the nearest one.
    let (mut all, mut most) = (vec![[0; 2]; 1 << 16], vec![[0; 2]; 1 << 16]);
    for ([low, high], count) in counts() {
        for (level, side) in [(low, 1), (high, 0)] {
            all[level][side] += count;
            most[level][side] = count.max(most[level][side]);
        }
    }
    let mut next = vec![[None; 2]; 1 << 16];
    for ([low, high], count) in counts() {
        if FREQUENT * count >= most[low][1].max(most[high][0]) {
            let is_step = MANY * count >= all[low][1].max(all[high][0]);
            next[low][1].get_or_insert(is_step.then_some(high));
            next[high][0] = Some(is_step.then_some(low));
        }
    }
    let step = |from: usize, side: usize| {
        next[from][side].flatten().filter(|to: &usize| next[*to][1 - side] == Some(Some(from)))
    };
    let mut reaches = vec![[0.5; 2]; 1 << 16];
    for first in (0..1 << 16).filter(|level| step(*level, 0).is_none() && step(*level, 1).is_some()) {
        let levels: Vec<usize> = std::iter::successors(Some(first), |level| step(*level, 1)).collect();
        let apart: Vec<usize> = levels.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let half = |i: usize| {
            let near = &apart[i.saturating_sub(NEAR)..apart.len().min(i + NEAR + 1)];
            // It is like itself.
            let alike = near.iter().filter(|other| other.abs_diff(apart[i]) <= 1).count() - 1;
            0.5 * if alike >= ALIKE { apart[i] as f64 } else { 1.0 }
        };
        for (i, level) in levels.iter().enumerate() {
            let [below, above] = [i.checked_sub(1), (i < apart.len()).then_some(i)].map(|gap| gap.map(half));
            // The lowest and the highest level reach as far to either side.
            let [lowest, highest] = [below.or(above), above.or(below)];
            reaches[*level] = [lowest.unwrap_or(0.5), highest.unwrap_or(0.5)];
        }
    }
    let is_edge = |[low, high]: &[usize; 2]| (high - low) as f64 > reaches[*low][1] + reaches[*high][0];
    let edges = changes.iter().filter(|change| is_edge(&change.map(usize::from))).count();
    let is_edges = 2 * edges > changes.len();
    (reaches, is_edges)
}

/// Returns the highest code of so many bits.
fn full(bits: u32) -> f64 {
    f64::from((1 << bits) - 1)
}

/// Returns the different codes of a picture.
fn distinct(codes: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut occurs = vec![false; 1 << 16];
    codes.for_each(|code| occurs[code as usize] = true);
    (0..).zip(occurs).filter_map(|(code, occurs)| occurs.then_some(code)).collect()
}
