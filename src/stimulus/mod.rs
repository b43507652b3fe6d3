//! Floor 2: what is shown. A specification, validated, becomes light, and with a quantizer codes.
//!
//! [`catalog`] lists every kind: the one place that commands, the gallery and the tests take them from.

pub mod catalog;
mod chevreul;
pub mod color;
mod cornsweet;
mod coverage;
mod cylinder;
mod fast;
mod kanizsa;
mod kind;
pub mod mach_band;
mod orientation;
pub mod parameter;
pub mod recipe;
mod shaded_mesh;
mod shot;
mod sight;
mod staircase;
mod vasarely;
mod window;

use serde::{Deserialize, Serialize};

use crate::light::{Bits, CodeImage, LinearImage, Quantizer, Samples};

pub use chevreul::Chevreul;
pub use color::{ColorError, StimulusColor};
pub use cornsweet::Cornsweet;
pub use cylinder::{Cylinder, Shading};
pub use kanizsa::Kanizsa;
pub use mach_band::{MachBand, Ramp, RampSpace};
pub use parameter::{Parameter, ParameterError, ParameterValue};
pub use shaded_mesh::{ShadedMesh, Triple};
pub use shot::{Renderer, Shot, describe_scene};
pub use sight::{Sight, View};
pub use vasarely::Vasarely;

macro_rules! stimuli {
    ($($(#[$meta:meta])* $name:ident,)*) => {
        /// Every kind of stimulus, by the name that files and commands use.
        pub const KINDS: &[&str] = &[$($name::KIND,)*];

        /// A stimulus of one of the known [`KINDS`].
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[serde(tag = "kind", rename_all = "kebab-case")]
        pub enum Stimulus {
            $($(#[$meta])* $name($name),)*
        }

        impl Stimulus {
            /// The name of this kind, one of [`KINDS`].
            #[must_use]
            pub fn kind(&self) -> &'static str {
                match self {
                    $(Self::$name(_) => $name::KIND,)*
                }
            }

            /// The stimulus of kind `kind` with every parameter at its default; `None` if there is no such kind.
            #[must_use]
            pub fn default_of(kind: &str) -> Option<Stimulus> {
                $(if kind == $name::KIND {
                    return Some(Self::$name($name::default()));
                })*
                None
            }

            /// Every parameter that can be set, in the order in which files list them.
            #[must_use]
            pub fn parameters(&self) -> &'static [Parameter] {
                match self {
                    $(Self::$name(_) => $name::PARAMETERS,)*
                }
            }

            /// Sets the parameter `name`, checking its own range only; [`Stimulus::validate`] checks the parameters
            /// against each other.
            ///
            /// # Errors
            /// When there is no such parameter, or it cannot have this value; the stimulus is then as before.
            pub fn set(&mut self, name: &str, value: &ParameterValue) -> Result<(), ParameterError> {
                match self {
                    $(Self::$name(stimulus) => stimulus.set(name, value),)*
                }
            }

            /// The value of the parameter `name`; `None` if there is no such parameter.
            #[must_use]
            pub fn get(&self, name: &str) -> Option<ParameterValue> {
                match self {
                    $(Self::$name(stimulus) => stimulus.get(name),)*
                }
            }

            /// Whether this can be shown.
            ///
            /// # Errors
            /// Every fault found.
            pub fn validate(&self) -> Result<(), Vec<ParameterError>> {
                match self {
                    $(Self::$name(stimulus) => stimulus.validate(),)*
                }
            }

            /// The light of a uniform field of relative luminance `level` in the colour of this stimulus.
            #[must_use]
            pub fn field_light(&self, level: f64) -> [f32; 3] {
                match self {
                    $(Self::$name(stimulus) => window::light(stimulus.color.rgb(), level),)*
                }
            }

            /// The light asked `x` window sides from the centre, along the orientation.
            #[must_use]
            pub fn light_at(&self, x: f64) -> [f32; 3] {
                match self {
                    $(Self::$name(stimulus) => stimulus.light_at(x),)*
                }
            }

            /// The light of a window of `size` × `size` pixels: the reference.
            #[must_use]
            pub fn linear(&self, size: u32) -> LinearImage {
                match self {
                    $(Self::$name(stimulus) => stimulus.linear(size),)*
                }
            }
        }
    };
}

stimuli! {
    /// Two plateaus and the ramp between them, Bangay §3.1.
    MachBand,
    /// Uniform steps.
    Chevreul,
    /// Equal areas with an edge between them.
    Cornsweet,
    /// Nested squares.
    Vasarely,
    /// A triangle of which only the corners are hinted at.
    Kanizsa,
    /// A mesh under one of the shaders.
    ShadedMesh,
    /// A faceted cylinder under flat, Gouraud or Phong shading.
    #[serde(rename = "shaded-cylinder")]
    Cylinder,
}

impl Stimulus {
    /// The light asked at the pixel centres of a row of `size` through the centre of the window, along the orientation.
    #[must_use]
    pub fn profile(&self, size: u32) -> Vec<[f32; 3]> {
        match self {
            // Its mesh is made once for all places.
            Self::ShadedMesh(mesh) => mesh.profile(size),
            other => (0..size).map(|i| other.light_at(Self::place(i, size))).collect(),
        }
    }

    /// Where pixel `i` of a row of `size` has its centre, in window sides from the window's.
    #[must_use]
    pub fn place(i: u32, size: u32) -> f64 {
        (2.0 * f64::from(i) + 1.0 - f64::from(size)) / (2.0 * f64::from(size))
    }

    /// The codes of a window of `size` × `size` pixels: those of [`Stimulus::linear`], quantised, whichever way is
    /// faster.
    #[must_use]
    pub fn codes(&self, size: u32, quantizer: &Quantizer) -> CodeImage {
        match self {
            Self::MachBand(band) => band.codes(size, quantizer),
            other => quantizer.quantize(&other.linear(size)),
        }
    }

    /// [`Stimulus::codes`] at 8 bits, into memory that is already there: red green blue, row by row from the top.
    ///
    /// # Panics
    /// When `codes` is not 3 · `size`² bytes long, or `quantizer` is not one of 8 bits.
    pub fn codes_into(&self, size: u32, quantizer: &Quantizer, codes: &mut [u8]) {
        assert_eq!(quantizer.bits(), Bits::Eight, "bytes hold 8-bit codes");
        match self {
            Self::MachBand(band) => band.codes_into(size, quantizer, codes),
            other => {
                if let Samples::Eight(made) = quantizer.quantize(&other.linear(size)).samples {
                    codes.copy_from_slice(&made);
                }
            }
        }
    }

    /// The channel that gets the most light: 0 red, 1 green, 2 blue; the first of equals.
    #[must_use]
    pub fn strongest_channel(&self) -> usize {
        let mut weights = self.field_light(1.0);
        if let Self::MachBand(MachBand { color_high: Some(color), .. }) = self {
            // The brighter plateau decides where it has a colour of its own.
            weights = window::light(color.rgb(), 1.0);
        }
        (1..3).fold(0, |best, channel| if weights[channel] > weights[best] { channel } else { best })
    }
}
