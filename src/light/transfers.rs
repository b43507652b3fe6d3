//! The transfer functions of red, green and blue together.

use std::fmt;
use std::str::FromStr;

use super::gamma::{Transfer, TransferError};

/// What a display makes of the codes of its three channels. Written as one [`Transfer`] where they are alike, else as
/// three joined by `/`: `gamma:2.2/gamma:2.1/gamma:2.3`.
#[derive(Clone, Debug, PartialEq)]
pub struct Transfers([Transfer; 3]);

impl Transfers {
    /// Red, green, blue.
    #[must_use]
    pub fn new(channels: [Transfer; 3]) -> Self {
        Self(channels)
    }

    /// Red, green, blue.
    #[must_use]
    pub fn channels(&self) -> &[Transfer; 3] {
        &self.0
    }

    /// The one transfer function of all channels; `None` where they differ.
    #[must_use]
    pub fn uniform(&self) -> Option<&Transfer> {
        let [red, green, blue] = &self.0;
        (red == green && green == blue).then_some(red)
    }

    /// Whether a channel is a measured table, which has no short text.
    #[must_use]
    pub fn has_table(&self) -> bool {
        self.0.iter().any(|transfer| matches!(transfer, Transfer::Table(_)))
    }

    /// [`Transfer::encoded_from_linear`] of each channel.
    #[must_use]
    pub fn encoded_from_linear(&self, linear: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|channel| self.0[channel].encoded_from_linear(linear[channel]))
    }

    /// [`Transfer::linear_from_encoded`] of each channel.
    #[must_use]
    pub fn linear_from_encoded(&self, encoded: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|channel| self.0[channel].linear_from_encoded(encoded[channel]))
    }
}

impl From<Transfer> for Transfers {
    fn from(transfer: Transfer) -> Self {
        Self([transfer.clone(), transfer.clone(), transfer])
    }
}

impl From<&Transfer> for Transfers {
    fn from(transfer: &Transfer) -> Self {
        transfer.clone().into()
    }
}

impl From<&Transfers> for Transfers {
    fn from(transfers: &Transfers) -> Self {
        transfers.clone()
    }
}

impl fmt::Display for Transfers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.uniform() {
            Some(transfer) => transfer.fmt(f),
            None => write!(f, "{}/{}/{}", self.0[0], self.0[1], self.0[2]),
        }
    }
}

impl FromStr for Transfers {
    type Err = TransferError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let parts: Vec<&str> = text.split('/').collect();
        match parts[..] {
            [one] => Ok(one.parse::<Transfer>()?.into()),
            [red, green, blue] => Ok(Self([red.parse()?, green.parse()?, blue.parse()?])),
            _ => Err(TransferError::Channels(text.to_owned(), parts.len())),
        }
    }
}
