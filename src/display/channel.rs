//! What carries the light of a patch.

use std::fmt;
use std::str::FromStr;

/// The channels of which a patch is lit; the others are at 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Channel {
    /// Red alone.
    Red,
    /// Green alone.
    Green,
    /// Blue alone.
    Blue,
    /// All three at the same level.
    Gray,
}

impl Channel {
    /// All of them, in the order of tables.
    pub const ALL: [Self; 4] = [Self::Red, Self::Green, Self::Blue, Self::Gray];

    /// The name in words: red, green, blue, gray.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Red => "red",
            Self::Green => "green",
            Self::Blue => "blue",
            Self::Gray => "gray",
        }
    }

    /// The name at the beginning of a line.
    #[must_use]
    pub fn capitalized(self) -> &'static str {
        match self {
            Self::Red => "Red",
            Self::Green => "Green",
            Self::Blue => "Blue",
            Self::Gray => "Gray",
        }
    }

    /// The name in a file: r, g, b, gray.
    #[must_use]
    pub fn key(self) -> &'static str {
        match self {
            Self::Red => "r",
            Self::Green => "g",
            Self::Blue => "b",
            Self::Gray => "gray",
        }
    }

    /// The pixel that has `code` in this channel and 0 in the others.
    #[must_use]
    pub fn rgb(self, code: u8) -> [u8; 3] {
        match self {
            Self::Red => [code, 0, 0],
            Self::Green => [0, code, 0],
            Self::Blue => [0, 0, code],
            Self::Gray => [code; 3],
        }
    }

    /// Red 0, green 1, blue 2; `None` for gray.
    #[must_use]
    pub fn index(self) -> Option<usize> {
        match self {
            Self::Red => Some(0),
            Self::Green => Some(1),
            Self::Blue => Some(2),
            Self::Gray => None,
        }
    }
}

impl fmt::Display for Channel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A text that names no channel.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("channel {0:?} is not known; expected r, g, b or gray")]
pub struct UnknownChannel(pub String);

impl FromStr for Channel {
    type Err = UnknownChannel;

    /// Reads r, g, b, gray; red, green, blue and grey too, in any case.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text.trim().to_ascii_lowercase().as_str() {
            "r" | "red" => Ok(Self::Red),
            "g" | "green" => Ok(Self::Green),
            "b" | "blue" => Ok(Self::Blue),
            "gray" | "grey" => Ok(Self::Gray),
            _ => Err(UnknownChannel(text.to_owned())),
        }
    }
}
