//! A stimulus and everything that decides how its light becomes codes: what an image file keeps, so that its bytes can
//! be proved by rendering again.

use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error as _};

use super::catalog::Stimulus;
use crate::light::{
    Bits, CodeImage, Dither, LinearImage, Quantizer, Transfer, TransferError, TransferTable, Transfers,
};

/// Largest side of an image, pixels.
pub const SIZE_MAX: u32 = 16_384;

/// An image, described completely. Equal recipes give equal codes, on every machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recipe {
    /// What is shown.
    pub stimulus: Stimulus,
    /// Side of the square image in pixels, 1…[`SIZE_MAX`].
    pub size: u32,
    /// The display's transfer functions.
    #[serde(rename = "transfer", serialize_with = "write_transfers", deserialize_with = "read_transfers")]
    pub transfers: Transfers,
    /// Bits a channel.
    pub bits: Bits,
    /// How values between two codes are decided.
    pub dither: Dither,
    /// Seed of a random dither; without meaning for the others.
    pub seed: u64,
    /// SHA-256 of the display profile that the transfer functions are from; `None` where they were assumed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub display_sha256: Option<String>,
}

impl Recipe {
    /// The light that is asked.
    #[must_use]
    pub fn linear(&self) -> LinearImage {
        self.stimulus.linear(self.size)
    }

    /// A quantizer for the recipe's display, to be kept for further images.
    #[must_use]
    pub fn quantizer(&self) -> Quantizer {
        Quantizer::new(&self.transfers, self.bits)
    }

    /// The codes, with a quantizer of the same transfer function and bits.
    #[must_use]
    pub fn codes(&self, quantizer: &Quantizer) -> CodeImage {
        match &self.dither {
            Dither::None => self.stimulus.codes(self.size, quantizer),
            dither => quantizer.quantize_with(&self.linear(), &dither.with_seed(self.seed)),
        }
    }

    /// The command that writes this image; a measured table is a file that the command names as `PROFILE.toml`.
    #[must_use]
    pub fn command(&self) -> String {
        let mut command = format!("machband stimulus --kind {}", self.stimulus.kind());
        let default = Stimulus::default_of(self.stimulus.kind());
        for parameter in self.stimulus.parameters() {
            let value = self.stimulus.get(parameter.name);
            if let Some(value) = value
                && default.as_ref().and_then(|default| default.get(parameter.name)).as_ref() != Some(&value)
            {
                let option = parameter.option();
                command += &format!(" --{option}={value}");
            }
        }
        command += &format!(" --size {}", self.size);
        if self.transfers.has_table() {
            command += " --display PROFILE.toml";
        } else if self.transfers.uniform() != Some(&Transfer::Srgb) {
            command += &format!(" --transfer {}", self.transfers);
        }
        if self.bits != Bits::Eight {
            command += &format!(" --bits {}", self.bits);
        }
        if self.dither != Dither::None {
            command += &format!(" --dither {}", self.dither);
        }
        if matches!(self.dither, Dither::Random { .. }) {
            command += &format!(" --seed {}", self.seed);
        }
        command + " --out stimulus.png"
    }
}

/// A transfer function in a file: its text, or the points of a table.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum TransferForm {
    Text(String),
    Table { encoded: Vec<f64>, linear: Vec<f64> },
}

impl TransferForm {
    fn of(transfer: &Transfer) -> Self {
        match transfer {
            Transfer::Table(table) => {
                Self::Table { encoded: table.encoded().to_vec(), linear: table.linear().to_vec() }
            }
            other => Self::Text(other.to_string()),
        }
    }

    fn transfer(self) -> Result<Transfer, TransferError> {
        match self {
            Self::Text(text) => text.parse(),
            Self::Table { encoded, linear } => TransferTable::new(encoded, linear).map(Transfer::Table),
        }
    }
}

/// The transfer functions of a display in a file: one where the channels are alike, else three.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum TransfersForm {
    Alike(TransferForm),
    Each([TransferForm; 3]),
}

fn write_transfers<S: Serializer>(transfers: &Transfers, serializer: S) -> Result<S::Ok, S::Error> {
    match transfers.uniform() {
        Some(transfer) => TransfersForm::Alike(TransferForm::of(transfer)),
        None => TransfersForm::Each(transfers.channels().each_ref().map(TransferForm::of)),
    }
    .serialize(serializer)
}

fn read_transfers<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Transfers, D::Error> {
    match TransfersForm::deserialize(deserializer)? {
        TransfersForm::Alike(form) => form.transfer().map(Transfers::from),
        TransfersForm::Each([red, green, blue]) => {
            red.transfer().and_then(|red| Ok(Transfers::new([red, green.transfer()?, blue.transfer()?])))
        }
    }
    .map_err(D::Error::custom)
}
