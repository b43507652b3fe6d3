//! Which channels of the screen light a patch.

use std::fmt;
use std::str::FromStr;

/// The channels that are lit in a patch; the others are at 0.
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
    /// All channels, in the order in which tables list them.
    pub const ALL: [Self; 4] = [Self::Red, Self::Green, Self::Blue, Self::Gray];

    /// The name within a sentence, at the beginning of a line, and in a file.
    fn names(self) -> [&'static str; 3] {
        match self {
            Self::Red => ["red", "Red", "r"],
            Self::Green => ["green", "Green", "g"],
            Self::Blue => ["blue", "Blue", "b"],
            Self::Gray => ["gray", "Gray", "gray"],
        }
    }

    /// Returns red, green, blue or gray.
    pub fn name(self) -> &'static str {
        self.names()[0]
    }

    /// Returns Red, Green, Blue or Gray.
    pub fn capitalized(self) -> &'static str {
        self.names()[1]
    }

    /// Returns r, g, b or gray, as written in files.
    pub fn key(self) -> &'static str {
        self.names()[2]
    }

    /// Checks that a profile can be made from measurements of these channels.
    ///
    /// # Errors
    /// Returns an error if `channels` contains neither gray nor all of red, green and blue, or if it contains a channel
    /// twice.
    pub fn check_for_profile(channels: &[Self]) -> Result<(), String> {
        let [red, green, blue, gray] = Self::ALL.map(|one| channels.iter().filter(|channel| **channel == one).count());
        let enough = (gray == 1 || red + green + blue == 3) && [red, green, blue, gray].iter().all(|count| *count < 2);
        let message = "a profile cannot be made from these channels; expected red, green, and blue, or gray, each once";
        if enough { Ok(()) } else { Err(message.to_owned()) }
    }

    /// Returns the pixel with `code` in this channel (in all three for gray) and 0 in the others.
    pub fn rgb(self, code: u8) -> [u8; 3] {
        match self {
            Self::Red => [code, 0, 0],
            Self::Green => [0, code, 0],
            Self::Blue => [0, 0, code],
            Self::Gray => [code; 3],
        }
    }
}

impl fmt::Display for Channel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Channel {
    type Err = String;

    /// Accepts r, g, b, gray, red, green and blue, in upper or lower case.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let lower = text.trim().to_ascii_lowercase();
        let is_named = |channel: &Self| channel.names().contains(&lower.as_str());
        Self::ALL
            .into_iter()
            .find(is_named)
            .ok_or_else(|| format!("channel {text:?} is not known; expected r, g, b or gray"))
    }
}
