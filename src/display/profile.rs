//! What is known of a screen: how codes become light, and how large it is.

use crate::light::gamma::Transfer;

/// A display profile. Without a measurement it is an assumption, and says so.
#[derive(Clone, Debug, PartialEq)]
pub struct DisplayProfile {
    /// For people.
    pub name: String,
    /// Encoded value to linear light, the same for every channel.
    pub transfer: Transfer,
    /// When, with what and by whom it was measured; `None` for an assumption.
    pub measured: Option<String>,
    /// Width of the visible screen in cm, where known.
    pub screen_width_cm: Option<f64>,
}

impl Default for DisplayProfile {
    /// sRGB, assumed.
    fn default() -> Self {
        Self { name: "sRGB".to_owned(), transfer: Transfer::Srgb, measured: None, screen_width_cm: None }
    }
}

impl DisplayProfile {
    /// The profile in one sentence.
    pub fn sentence(&self) -> String {
        match &self.measured {
            Some(measured) => format!("{} ({}), measured {measured}", self.name, self.transfer),
            None => format!("{} ({}), assumed: this screen was not measured", self.name, self.transfer),
        }
    }
}
