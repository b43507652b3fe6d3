//! A stimulus and everything that decides how its light becomes codes: what an image file keeps, so that its bytes can
//! be proved by rendering again.

use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error as _};

use super::Stimulus;
use crate::light::{Bits, CodeImage, Dither, LinearImage, Quantizer, Transfer, TransferTable};

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
    /// The display's transfer function.
    #[serde(serialize_with = "write_transfer", deserialize_with = "read_transfer")]
    pub transfer: Transfer,
    /// Bits a channel.
    #[serde(serialize_with = "write_text", deserialize_with = "read_text")]
    pub bits: Bits,
    /// How values between two codes are decided.
    #[serde(serialize_with = "write_text", deserialize_with = "read_text")]
    pub dither: Dither,
    /// Seed of a random dither; without meaning for the others.
    pub seed: u64,
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
        Quantizer::new(&self.transfer, self.bits)
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
        match &self.transfer {
            Transfer::Srgb => {}
            Transfer::Table(_) => command += " --display PROFILE.toml",
            other => command += &format!(" --transfer {other}"),
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

fn write_transfer<S: Serializer>(transfer: &Transfer, serializer: S) -> Result<S::Ok, S::Error> {
    match transfer {
        Transfer::Table(table) => {
            TransferForm::Table { encoded: table.encoded().to_vec(), linear: table.linear().to_vec() }
        }
        other => TransferForm::Text(other.to_string()),
    }
    .serialize(serializer)
}

fn read_transfer<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Transfer, D::Error> {
    match TransferForm::deserialize(deserializer)? {
        TransferForm::Text(text) => text.parse().map_err(D::Error::custom),
        TransferForm::Table { encoded, linear } => {
            TransferTable::new(encoded, linear).map(Transfer::Table).map_err(D::Error::custom)
        }
    }
}

fn write_text<T: std::fmt::Display, S: Serializer>(value: &T, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(value)
}

fn read_text<'de, T, D>(deserializer: D) -> Result<T, D::Error>
where
    T: std::str::FromStr<Err: std::fmt::Display>,
    D: Deserializer<'de>,
{
    String::deserialize(deserializer)?.parse().map_err(D::Error::custom)
}
