//! Which channels of the screen light a patch.

use crate::text::names::named;

named! {
    /// The channels that are lit in a patch; the others are at 0.
    #[derive(PartialOrd, Ord)]
    Channel, UnknownChannel {
        /// Red alone.
        Red = "red",
        /// Green alone.
        Green = "green",
        /// Blue alone.
        Blue = "blue",
        /// All three at the same level.
        Gray = "gray",
    }
}

impl Channel {
    /// Returns r, g, b or gray, as written in files.
    pub fn key(self) -> &'static str {
        if self == Self::Gray { self.name() } else { &self.name()[..1] }
    }

    /// Checks that a profile can be made from measurements of these channels.
    ///
    /// # Errors
    /// Returns an error if `channels` contains neither gray nor all of red, green and blue, or if it contains a channel
    /// twice.
    pub fn check_for_profile(channels: &[Self]) -> Result<(), String> {
        let count = |one: Self| channels.iter().filter(|channel| **channel == one).count();
        let enough = count(Self::Gray) == 1 || Self::ALL[..3].iter().all(|channel| count(*channel) == 1);
        let message = "a profile cannot be made from these channels; expected red, green, and blue, or gray, each once";
        if enough && Self::ALL.iter().all(|channel| count(*channel) < 2) { Ok(()) } else { Err(message.to_owned()) }
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
