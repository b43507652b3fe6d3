//! Whether readings can come from a display, and what is wrong with those that cannot.

use super::readings::{LevelMean, Reading, Readings};
use crate::display::channel::Channel;

/// Levels that a channel needs at least, 0 and 1 among them.
pub const LEAST_LEVELS: usize = 5;

/// Why no profile can be made from readings.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReadingFault {
    /// A level above 1 that could be an 8-bit code.
    #[error("level {0} looks like a code of 0…255; expected a level of 0…1, the code divided by 255 ({relative:.4})", relative = .0 / 255.0)]
    LevelIsCode(f64),
    /// A level that is not an encoded value.
    #[error("level {0} is outside 0…1; expected the code divided by the largest code")]
    Level(f64),
    /// Not a luminance.
    #[error("luminance {0} is not a luminance; expected cd/m², 0 or more")]
    Luminance(f64),
    /// Light that does not rise between two levels of a channel, which may have been misread.
    #[error("{channel}: {message}")]
    Misread {
        /// The channel.
        channel: Channel,
        /// The lower level and the higher one.
        levels: [f64; 2],
        /// What is wrong; what is expected.
        message: String,
    },
    /// Something is missing, or wrong with all of them.
    #[error("{0}")]
    Set(String),
}

/// A fault of readings, and which of them has it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{fault}")]
pub struct Fault {
    /// Index of the reading, from 0; `None` for a fault of the set.
    pub index: Option<usize>,
    /// What is wrong.
    pub fault: ReadingFault,
}

impl Readings {
    /// Checks readings, given in the order in which they were taken.
    ///
    /// # Errors
    /// Every fault of single readings; where there are none, every fault of the set.
    pub fn new(readings: Vec<Reading>) -> Result<Self, Vec<Fault>> {
        let faults = each(&readings);
        if !faults.is_empty() {
            return Err(faults);
        }
        let set = Self::unchecked(readings);
        let faults = together(&set);
        if faults.is_empty() { Ok(set) } else { Err(faults) }
    }
}

/// A fall that noise could make: share of the reading, steps of the photometer, share of the most light.
const FALL: (f64, f64, f64) = (0.05, 3.0, 5e-5);
/// A rise that noise could not hide, ln.
const CLEAR_RISE: f64 = 0.1;
/// Share of the rise that the levels below promise, under which the light has stopped rising.
const STOPPED: f64 = 0.3;
/// How much lighter the dimmer channel is when the two are exchanged.
const EXCHANGED: f64 = 1.05;

/// Faults of single readings.
fn each(readings: &[Reading]) -> Vec<Fault> {
    let codes = readings.iter().all(|one| (0.0..=255.0).contains(&one.level) && one.level.fract() == 0.0);
    let of = |one: &Reading| {
        let level = match one.level {
            level if (0.0..=1.0).contains(&level) => None,
            level if codes => Some(ReadingFault::LevelIsCode(level)),
            level => Some(ReadingFault::Level(level)),
        };
        let light = one.luminance_cd_m2;
        let light = (!(light.is_finite() && light >= 0.0)).then_some(ReadingFault::Luminance(light));
        level.into_iter().chain(light)
    };
    let mut faults: Vec<Fault> = (readings.iter().enumerate())
        .flat_map(|(index, one)| of(one).map(move |fault| Fault { index: Some(index), fault }))
        .collect();
    if readings.is_empty() {
        faults.push(Fault {
            index: None,
            fault: ReadingFault::Set(format!(
                "there are no readings; expected red, green and blue, or gray, at {LEAST_LEVELS} levels or more"
            )),
        });
    } else if readings.iter().all(|one| one.luminance_cd_m2 == 0.0) {
        faults.push(Fault {
            index: None,
            fault: ReadingFault::Set(
                "every reading is 0 cd/m²; expected light: is the photometer on the screen, and its cap off?"
                    .to_owned(),
            ),
        });
    }
    faults
}

/// Faults that only the readings together show.
fn together(readings: &Readings) -> Vec<Fault> {
    let mut faults: Vec<ReadingFault> = channels(readings.channels()).into_iter().collect();
    let before = faults.len();
    if !readings.all().iter().any(|one| one.level == 0.0) {
        faults.push(set("no reading at level 0; expected the black of the screen, which every curve starts from"));
    }
    for channel in readings.channels() {
        faults.extend(levels(*channel, &readings.means(*channel)));
    }
    if faults.len() == before {
        for channel in readings.channels() {
            faults.extend(curve(readings, *channel));
        }
        // A faulty white says nothing about the order of the channels.
        if faults.len() == before {
            faults.extend(order(readings));
        }
    }
    faults.into_iter().map(|fault| Fault { index: None, fault }).collect()
}

fn set(message: impl Into<String>) -> ReadingFault {
    ReadingFault::Set(message.into())
}

fn channels(read: &[Channel]) -> Option<ReadingFault> {
    let expected = "expected red, green and blue, or gray, each from level 0 to 1";
    match *read {
        _ if read.contains(&Channel::Gray) => None,
        [only] => Some(set(format!(
            "single channel: only {only} was read, which says nothing about the other two; {expected}"
        ))),
        [first, second] => {
            let missing = Channel::ALL.into_iter().find(|channel| !read.contains(channel))?;
            Some(set(format!("channel {missing} is missing: only {first} and {second} were read; {expected}")))
        }
        _ => None,
    }
}

fn levels(channel: Channel, means: &[LevelMean]) -> Vec<ReadingFault> {
    let mut faults = Vec::new();
    if means.len() < LEAST_LEVELS {
        faults.push(set(format!(
            "{channel}: too few levels: {}; expected {LEAST_LEVELS} or more (9 are good, 17 better), 0 and 1 among them",
            means.len()
        )));
    }
    if let Some(LevelMean { level, .. }) = means.last().filter(|last| last.level != 1.0) {
        faults.push(set(format!(
            "{channel}: no reading at level 1 (the highest is {level}); expected the channel's most light"
        )));
    }
    faults
}

/// Rising all the way, up to the top.
fn curve(readings: &Readings, channel: Channel) -> Vec<ReadingFault> {
    let means = readings.means(channel);
    let Some(white) = means.last().copied() else { return Vec::new() };
    let black_cd_m2 = readings.black_cd_m2();
    let white_cd_m2 = white.luminance_cd_m2;
    let (share, steps, of_most) = FALL;
    let still = steps * readings.resolution_cd_m2() + of_most * readings.largest_cd_m2();
    if white_cd_m2 <= black_cd_m2 * (1.0 + share) + still {
        return vec![set(format!(
            "{channel}: level 1 gives {white_cd_m2} cd/m², no more than black ({black_cd_m2} cd/m²); expected light"
        ))];
    }
    let falls =
        means.windows(2).filter(|pair| pair[1].luminance_cd_m2 < pair[0].luminance_cd_m2 * (1.0 - share) - still);
    let falls = falls.map(|pair| {
        let [(lower, lower_cd_m2), (upper, upper_cd_m2)] = [pair[0], pair[1]].map(|at| (at.level, at.luminance_cd_m2));
        let message = format!(
            "not monotone: level {upper} gives {upper_cd_m2} cd/m², less than the {lower_cd_m2} cd/m² of level {lower}; expected more light at every higher level: measure both again"
        );
        ReadingFault::Misread { channel, levels: [lower, upper], message }
    });
    let falls: Vec<ReadingFault> = falls.collect();
    if falls.is_empty() {
        saturated(channel, &means, black_cd_m2, readings.resolution_cd_m2()).into_iter().collect()
    } else {
        falls
    }
}

/// The lowest level from which on the light has stopped rising, where there is one.
fn saturated(channel: Channel, means: &[LevelMean], black_cd_m2: f64, resolution: f64) -> Option<ReadingFault> {
    let (white, below) = means.split_last()?;
    let light = |at: &LevelMean| at.luminance_cd_m2 - black_cd_m2;
    let stopped = |at: &&LevelMean| {
        let Some(half) = means.iter().rfind(|one| one.level <= at.level * 0.6 && light(one) > 0.0 && one.level > 0.0)
        else {
            return false;
        };
        // The exponent on the way up to this level, at least that of a linear display.
        let exponent = ((light(at) / light(half)).ln() / (at.level / half.level).ln()).clamp(1.0, 3.0);
        let promised = exponent * (1.0 / at.level).ln();
        // Equal to the last digit, though a step would show.
        let same = white.luminance_cd_m2 == at.luminance_cd_m2 && promised * light(at) > 5.0 * resolution;
        same || promised >= CLEAR_RISE && (light(white) / light(at)).ln() < STOPPED * promised
    };
    // A flat top alone is saturation: above the level that is found, all are.
    let upper: Vec<&LevelMean> =
        below.iter().rev().filter(|one| one.level > 0.0).take_while(|one| light(one) > 0.0).collect();
    let level = upper.into_iter().find(stopped)?;
    let lowest = below.iter().find(|one| (light(white) / light(one)).ln() < STOPPED * CLEAR_RISE).unwrap_or(level);
    let message = format!(
        "saturated: the light stops rising at level {}, {} cd/m² there and {} cd/m² at level 1; expected it to rise up to level 1: lower the screen's contrast, turn off dynamic contrast, or set the photometer to a wider range",
        lowest.level, lowest.luminance_cd_m2, white.luminance_cd_m2
    );
    Some(ReadingFault::Misread { channel, levels: [lowest.level, 1.0], message })
}

/// Luminances of the channels at level 1: gray above green above red above blue.
fn order(readings: &Readings) -> Option<ReadingFault> {
    let falling = [Channel::Gray, Channel::Green, Channel::Red, Channel::Blue];
    let white_cd_m2: Vec<(Channel, f64)> = (falling.into_iter())
        .filter_map(|channel| Some((channel, readings.means(channel).last()?.luminance_cd_m2)))
        .collect();
    if !white_cd_m2.windows(2).any(|pair| pair[1].1 > pair[0].1 * EXCHANGED) {
        return None;
    }
    let mut sorted = white_cd_m2.clone();
    sorted.sort_by(|a, b| b.1.total_cmp(&a.1));
    let moved: Vec<Channel> =
        white_cd_m2.iter().zip(&sorted).filter(|(called, is)| called.0 != is.0).map(|(called, _)| called.0).collect();
    let question = match moved[..] {
        [one, other] => format!(": are {one} and {other} exchanged?"),
        _ => String::new(),
    };
    let each: Vec<String> = white_cd_m2.iter().map(|(channel, light)| format!("{channel} {light}")).collect();
    Some(set(format!(
        "swapped channels: level 1 gives {} cd/m²; expected more light in gray than in green, in green than in red, in red than in blue, as on every screen{question}",
        each.join(", ")
    )))
}
