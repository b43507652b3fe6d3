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
    #[must_use]
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
    #[must_use]
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
    #[must_use]
    pub fn encoded(self, level: f64) -> f64 {
        match self.form {
            Form::Scaled | Form::Repeated => level / full(self.bits),
            Form::Shifted => level * f64::from(1 << (self.of - self.bits)) / full(self.of),
        }
    }
}

/// How many distances between levels are looked at on either side of one, ...
const NEAR: usize = 3;
/// ... and how many of them must be alike, so that it counts as a step. Colors that are only few are not evenly spaced.
const ALIKE: usize = 3;

/// Returns, for each level of a channel, how far the values that were rounded to it reach below and above it: half the
/// distance to the next level that occurs, if levels are skipped evenly there, as after posterizing or stretching the
/// contrast, and otherwise half a level. Flat areas of a few colors are not steps: where they meet, levels mostly change by
/// more than one.
#[must_use]
pub fn reaches(channel: &[f64], width: usize) -> Vec<[f64; 2]> {
    let mut reaches = vec![[0.5; 2]; 1 << 16];
    let levels = distinct(channel.iter().map(|level| *level as u32));
    let mut ranks = vec![0_usize; 1 << 16];
    levels.iter().enumerate().for_each(|(rank, level)| ranks[*level as usize] = rank);
    let beside = [1, width].into_iter().flat_map(|by| channel.iter().zip(channel.iter().skip(by)));
    let changes = beside.map(|(a, b)| ranks[*a as usize].abs_diff(ranks[*b as usize])).filter(|change| *change > 0);
    let (by_one, all) = changes.fold((0, 0), |(by_one, all), change| (by_one + usize::from(change == 1), all + 1));
    if 2 * by_one < all {
        return reaches;
    }
    let apart: Vec<u32> = levels.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let half = |i: usize| {
        let near = &apart[i.saturating_sub(NEAR)..apart.len().min(i + NEAR + 1)];
        // It is like itself.
        let alike = near.iter().filter(|other| other.abs_diff(apart[i]) <= 1).count() - 1;
        0.5 * f64::from(if alike >= ALIKE { apart[i] } else { 1 })
    };
    for (i, level) in levels.iter().enumerate() {
        let [below, above] = [i.checked_sub(1), (i < apart.len()).then_some(i)].map(|gap| gap.map(half));
        // The lowest and the highest level reach as far to either side.
        let [lowest, highest] = [below.or(above), above.or(below)];
        reaches[*level as usize] = [lowest.unwrap_or(0.5), highest.unwrap_or(0.5)];
    }
    reaches
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
