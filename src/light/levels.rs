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

/// How many steps between levels are looked at on either side of one, ...
const NEAR: usize = 3;
/// ... and how many of them must be alike. Colors that are only few are not evenly spaced.
const ALIKE: usize = 3;

/// Returns, for each level of a channel, how far the values that were rounded to it reach below and above it: half of the
/// step to the next level that occurs, if the steps there are even, as after posterizing or stretching the contrast, and
/// otherwise half a level. Steps are what most often lies between neighboring pixels: flat areas of a few colors have
/// none. Also returns whether most changes are larger than steps.
pub fn reaches(channel: &[f64], width: usize) -> (Vec<[f64; 2]>, bool) {
    let levels = distinct(channel.iter().map(|level| *level as u32));
    let mut place = vec![0; 1 << 16];
    levels.iter().enumerate().for_each(|(i, level)| place[*level as usize] = i);
    let beside = channel.chunks_exact(width).flat_map(|row| row.iter().zip(&row[1..]));
    let beside = beside.chain(channel.iter().zip(channel.iter().skip(width)));
    let changes: Vec<[u16; 2]> =
        beside.filter(|(a, b)| a != b).map(|(a, b)| [a.min(*b) as u16, a.max(*b) as u16]).collect();
    let is_most = |of: &dyn Fn([usize; 2]) -> bool| {
        2 * changes.iter().filter(|change| of(change.map(usize::from))).count() > changes.len()
    };
    let apart: Vec<u32> = levels.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let has_steps = is_most(&|[low, high]| place[high] - place[low] == 1);
    let half = |i: usize| {
        let near = &apart[i.saturating_sub(NEAR)..apart.len().min(i + NEAR + 1)];
        // It is like itself.
        let alike = near.iter().filter(|other| other.abs_diff(apart[i]) <= 1).count() - 1;
        0.5 * if has_steps && alike >= ALIKE { f64::from(apart[i]) } else { 1.0 }
    };
    let halves: Vec<f64> = (0..apart.len()).map(half).collect();
    let mut reaches = vec![[0.5; 2]; 1 << 16];
    for (i, level) in levels.iter().enumerate() {
        // The lowest and the highest level reach as far to either side.
        let [below, above] = [i.checked_sub(1).and_then(|below| halves.get(below)), halves.get(i)];
        reaches[*level as usize] = [below.or(above), above.or(below)].map(|half| half.copied().unwrap_or(0.5));
    }
    let is_edges = is_most(&|[low, high]| (high - low) as f64 > reaches[low][1] + reaches[high][0]);
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
