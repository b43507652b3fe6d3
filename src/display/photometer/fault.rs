//! What can be wrong with readings.

use super::reading::Channel;

/// Levels that a channel needs at least, 0 and 1 among them.
pub const LEAST_LEVELS: usize = 5;

/// Why no profile can be made from readings.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReadingFault {
    /// A level above 1, and none that could not be an 8-bit code.
    #[error("level {0} looks like a code of 0…255; expected a level of 0…1, the code divided by 255 ({relative:.4})", relative = .0 / 255.0)]
    LevelIsCode(f64),
    /// A level that is no encoded value.
    #[error("level {0} is outside 0…1; expected the code divided by the largest code")]
    Level(f64),
    /// A luminance that is none.
    #[error("luminance {0} is no luminance; expected cd/m², 0 or more")]
    Luminance(f64),
    /// Nothing at all.
    #[error("there are no readings; expected red, green and blue, or gray, at {LEAST_LEVELS} levels or more")]
    Empty,
    /// The photometer saw nothing.
    #[error("every reading is 0 cd/m²; expected light: is the photometer on the screen, and its cap off?")]
    Dark,
    /// One of red, green and blue, and no gray.
    #[error(
        "single channel: only {0} was read, which says nothing of the other two; expected red, green and blue, or gray, each from level 0 to 1"
    )]
    SingleChannel(Channel),
    /// Two of red, green and blue, and no gray.
    #[error(
        "channel {missing} is missing: only {first} and {second} were read; expected red, green and blue, or gray, each from level 0 to 1"
    )]
    MissingChannel {
        /// The channel without readings.
        missing: Channel,
        /// A channel with readings.
        first: Channel,
        /// The other one.
        second: Channel,
    },
    /// Too few points for a curve.
    #[error(
        "{channel}: too few levels: {levels}; expected {LEAST_LEVELS} or more (9 are good, 17 better), 0 and 1 among them"
    )]
    TooFewLevels {
        /// The channel.
        channel: Channel,
        /// How many different levels it has.
        levels: usize,
    },
    /// No reading of black.
    #[error("no reading at level 0; expected the black of the screen, which every curve starts from")]
    NoBlack,
    /// No reading of the most light.
    #[error("{channel}: no reading at level 1 (the highest is {highest}); expected the channel's most light")]
    NoWhite {
        /// The channel.
        channel: Channel,
        /// Its highest level.
        highest: f64,
    },
    /// Less light at a higher level.
    #[error(
        "{channel}: not monotone: level {upper} gives {upper_cd_m2} cd/m², less than the {lower_cd_m2} cd/m² of level {lower}; expected more light at every higher level: measure both again"
    )]
    NotMonotone {
        /// The channel.
        channel: Channel,
        /// The lower level.
        lower: f64,
        /// Its light.
        lower_cd_m2: f64,
        /// The higher level.
        upper: f64,
        /// Its light, less.
        upper_cd_m2: f64,
    },
    /// No more light at the highest levels.
    #[error(
        "{channel}: saturated: the light stops rising at level {level}, {level_cd_m2} cd/m² there and {white_cd_m2} cd/m² at level 1; expected it to rise up to level 1: lower the screen's contrast, turn off dynamic contrast, or set the photometer to a wider range"
    )]
    Saturated {
        /// The channel.
        channel: Channel,
        /// The lowest level as light as level 1.
        level: f64,
        /// Its light.
        level_cd_m2: f64,
        /// The light at level 1.
        white_cd_m2: f64,
    },
    /// No light at any level.
    #[error("{channel}: level 1 gives {white_cd_m2} cd/m², no more than black ({black_cd_m2} cd/m²); expected light")]
    NoLight {
        /// The channel.
        channel: Channel,
        /// Its light at level 1.
        white_cd_m2: f64,
        /// Black.
        black_cd_m2: f64,
    },
    /// Luminances that belong to other channels.
    #[error(
        "swapped channels: level 1 gives {}; expected more light in gray than in green, in green than in red, in red than in blue, as on every screen{}",
        luminances(.white_cd_m2), question(.exchanged)
    )]
    Swapped {
        /// The light at level 1 of each channel, from the one that should have most.
        white_cd_m2: Vec<(Channel, f64)>,
        /// The two channels whose exchange explains it, where two do.
        exchanged: Option<(Channel, Channel)>,
    },
}

fn luminances(white_cd_m2: &[(Channel, f64)]) -> String {
    let each: Vec<String> = white_cd_m2.iter().map(|(channel, light)| format!("{channel} {light}")).collect();
    format!("{} cd/m²", each.join(", "))
}

fn question(exchanged: &Option<(Channel, Channel)>) -> String {
    exchanged.map_or_else(String::new, |(one, other)| format!(": are {one} and {other} exchanged?"))
}
