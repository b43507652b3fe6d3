//! Floor 2: what is shown. A specification, validated, becomes light, and with a quantizer codes.

pub mod color;
mod fast;
pub mod mach_band;
mod orientation;
pub mod parameter;
mod staircase;

use serde::{Deserialize, Serialize};

use crate::light::{CodeImage, LinearImage, Quantizer};

pub use color::{ColorError, StimulusColor};
pub use mach_band::{MachBand, Ramp};
pub use parameter::{Parameter, ParameterError, ParameterValue};

/// Every kind of stimulus, by the name that files and commands use.
pub const KINDS: &[&str] = &[MachBand::KIND];

/// A stimulus of one of the known [`KINDS`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Stimulus {
    /// Two plateaus and the ramp between them, Bangay §3.1.
    MachBand(MachBand),
}

impl Stimulus {
    /// The name of this kind, one of [`KINDS`].
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Stimulus::MachBand(_) => MachBand::KIND,
        }
    }

    /// The stimulus of kind `kind` with every parameter at its default; `None` if there is no such
    /// kind.
    #[must_use]
    pub fn default_of(kind: &str) -> Option<Stimulus> {
        match kind {
            MachBand::KIND => Some(Stimulus::MachBand(MachBand::default())),
            _ => None,
        }
    }

    /// Every parameter that can be set, in the order in which files list them.
    #[must_use]
    pub fn parameters(&self) -> &'static [Parameter] {
        match self {
            Stimulus::MachBand(_) => MachBand::PARAMETERS,
        }
    }

    /// Sets the parameter `name`. Only its own range is checked here; what must hold between
    /// parameters, in [`Stimulus::validate`].
    ///
    /// # Errors
    /// When there is no such parameter, or it cannot have this value; the stimulus is then as
    /// before.
    pub fn set(&mut self, name: &str, value: &ParameterValue) -> Result<(), ParameterError> {
        match self {
            Stimulus::MachBand(band) => band.set(name, value),
        }
    }

    /// The value of the parameter `name`; `None` if there is no such parameter.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<ParameterValue> {
        match self {
            Stimulus::MachBand(band) => band.get(name),
        }
    }

    /// The light of a uniform field of relative luminance `level` in the colour of this stimulus.
    #[must_use]
    pub fn field_light(&self, level: f64) -> [f32; 3] {
        match self {
            Stimulus::MachBand(band) => band.color.rgb().map(|weight| (weight * level) as f32),
        }
    }

    /// Whether this can be shown.
    ///
    /// # Errors
    /// Every fault found.
    pub fn validate(&self) -> Result<(), Vec<ParameterError>> {
        match self {
            Stimulus::MachBand(band) => band.validate(),
        }
    }

    /// The light of a window of `size` × `size` pixels: the reference.
    #[must_use]
    pub fn linear(&self, size: u32) -> LinearImage {
        match self {
            Stimulus::MachBand(band) => band.linear(size),
        }
    }

    /// The codes of a window of `size` × `size` pixels: those of [`Stimulus::linear`], quantised,
    /// whichever way is faster.
    #[must_use]
    pub fn codes(&self, size: u32, quantizer: &Quantizer) -> CodeImage {
        match self {
            Stimulus::MachBand(band) => band.codes(size, quantizer),
        }
    }

    /// [`Stimulus::codes`] at 8 bits, into memory that is already there: red green blue, row by row
    /// from the top.
    ///
    /// # Panics
    /// When `codes` is not 3 · `size`² bytes long, or `quantizer` is not one of 8 bits.
    pub fn codes_into(&self, size: u32, quantizer: &Quantizer, codes: &mut [u8]) {
        match self {
            Stimulus::MachBand(band) => band.codes_into(size, quantizer, codes),
        }
    }
}
