//! Every kind of stimulus as one type, and the catalog: the single source of named stimuli for commands, the gallery
//! and the tests.

use serde::{Deserialize, Serialize};

use super::{
    color::StimulusColor,
    drawing::{Area, Line},
    figures::{Kanizsa, Vasarely},
    mach_band::MachBand,
    parameter::{Parameter, ParameterError, ParameterValue},
    picture::Picture,
    profiles::{Chevreul, Cornsweet, Cylinder},
    shaded_mesh::ShadedMesh,
};
use crate::light::{CodeImage, LinearImage, Quantizer};
use crate::text::names::expected_one_of;

macro_rules! stimuli {
    ($($(#[$meta:meta])* $name:ident: $title:literal, $has_bands:literal, $about:literal;)*) => {
        /// Every kind of stimulus, by the name that files and commands use.
        pub const KINDS: &[&str] = &[$($name::KIND,)*];

        /// A stimulus of one of the known [`KINDS`].
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[serde(tag = "kind", rename_all = "kebab-case")]
        pub enum Stimulus {
            $($(#[$meta])* $name($name),)*
            /// One of a study's own pictures. It has no defaults, so it is none of the [`KINDS`].
            Image(Picture),
        }

        static ENTRIES: [Entry; KINDS.len()] =
            [$(Entry {
                kind: $name::KIND,
                title: $title,
                about: $about,
                has_bands: $has_bands,
                parameters: $name::PARAMETERS,
                default: || $name::default().into(),
            },)*];

        $(impl From<$name> for Stimulus {
            fn from(stimulus: $name) -> Self {
                Self::$name(stimulus)
            }
        })*

        impl Stimulus {
            /// Returns the name of this kind, one of [`KINDS`].
            pub fn kind(&self) -> &'static str {
                match self {
                    $(Self::$name(_) => $name::KIND,)*
                    Self::Image(_) => Picture::KIND,
                }
            }

            /// Sets the parameter `name`. This checks only the range of the parameter itself; [`Stimulus::validate`]
            /// checks the parameters against each other.
            ///
            /// # Errors
            /// Returns an error, and leaves the stimulus unchanged, if there is no such parameter or it cannot have
            /// this value.
            pub fn set(&mut self, name: &str, value: &ParameterValue) -> Result<(), ParameterError> {
                match self {
                    $(Self::$name(stimulus) => stimulus.set(name, value),)*
                    Self::Image(picture) => picture.set(name, value),
                }
            }

            /// Returns the value of the parameter `name`, or `None` if there is no such parameter.
            pub fn get(&self, name: &str) -> Option<ParameterValue> {
                match self {
                    $(Self::$name(stimulus) => stimulus.get(name),)*
                    Self::Image(picture) => picture.get(name),
                }
            }

            /// Checks whether this stimulus can be shown.
            ///
            /// # Errors
            /// Returns every error found.
            pub fn validate(&self) -> Result<(), Vec<ParameterError>> {
                match self {
                    $(Self::$name(stimulus) => stimulus.validate(),)*
                    // Every picture that was read can be shown.
                    Self::Image(_) => Ok(()),
                }
            }

            fn color(&self) -> StimulusColor {
                match self {
                    $(Self::$name(stimulus) => stimulus.color,)*
                    Self::Image(_) => StimulusColor::GRAY,
                }
            }
        }
    };
}

stimuli! {
    /// Two plateaus and the ramp between them, Bangay §3.1.
    MachBand: "Mach band", true,
        "A ramp between two uniform areas: a bright line appears where it meets the bright area and a dark one where \
        it meets the dark area, although neither is in the image. Mach 1865; Bangay §3.1.";
    /// Uniform steps.
    Chevreul: "Chevreul staircase", false,
        "Uniform bands that look scalloped: each looks brighter next to its darker neighbor and darker next to its \
        brighter neighbor. Chevreul 1839.";
    /// Two areas of equal luminance with an edge between them.
    Cornsweet: "Craik–O'Brien–Cornsweet edge", false,
        "Two areas of the same luminance; the edge between them makes one look brighter. Cover the edge with a finger \
        to see that they are equal. Cornsweet 1970.";
    /// Nested squares.
    Vasarely: "Vasarely's nested squares", false,
        "Squares of graded luminance whose corners appear to form bright diagonals. Vasarely; Bangay fig. 1 j.";
    /// A triangle suggested only by its corners.
    Kanizsa: "Kanizsa triangle", false,
        "Three notched discs: a triangle seems to lie on top of them, brighter than the background. Kanizsa 1955.";
    /// A mesh drawn by one of the shaders.
    ShadedMesh: "Shaded mesh", true,
        "A faceted surface that is shaded to look smooth: Gouraud shading produces Mach bands at the edges; other \
        shaders change the luminance there to avoid them. Gouraud 1971; Bangay §4.";
    /// A faceted cylinder with flat, Gouraud or Phong shading.
    #[serde(rename = "shaded-cylinder")]
    Cylinder: "Shaded cylinder", true,
        "A faceted cylinder under flat, Gouraud or Phong shading: the source of Chevreul's scallops and Mach bands in \
        computer graphics. Bangay fig. 1 c, f.";
}

impl Default for Stimulus {
    fn default() -> Self {
        Self::MachBand(MachBand::default())
    }
}

impl From<Picture> for Stimulus {
    fn from(picture: Picture) -> Self {
        Self::Image(picture)
    }
}

impl Stimulus {
    /// Calls `of` with what the window shows.
    fn drawn<R>(&self, of: impl Fn(&dyn Area) -> R) -> R {
        match self {
            Self::MachBand(band) => of(&Line(band.orientation_deg, band.ramp())),
            Self::Chevreul(chevreul) => of(&Line(chevreul.orientation_deg, chevreul)),
            Self::Cornsweet(cornsweet) => of(&Line(cornsweet.orientation_deg, cornsweet)),
            Self::Cylinder(cylinder) => of(&Line(cylinder.orientation_deg, cylinder)),
            Self::Vasarely(vasarely) => of(vasarely),
            Self::Kanizsa(kanizsa) => of(kanizsa),
            Self::ShadedMesh(mesh) => of(mesh),
            Self::Image(picture) => of(picture),
        }
    }

    /// Makes a stimulus of the kind `kind` from the texts of some of its parameters; the others have their defaults.
    ///
    /// # Errors
    /// Returns every error: a kind that is not known, parameters that the kind does not have, and invalid values.
    pub fn with_parameters<'a>(
        kind: &str,
        given: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Result<Stimulus, Vec<ParameterError>> {
        let unknown =
            || ParameterError::new("kind", format!("{kind:?}"), "is not known", &expected_one_of(kind, KINDS));
        let mut stimulus = Stimulus::default_of(kind).ok_or_else(|| vec![unknown()])?;
        let set =
            |(name, text): (&str, &'a str)| stimulus.set(name, &text.parse().unwrap_or_else(|e| match e {})).err();
        let mut errors: Vec<ParameterError> = given.into_iter().filter_map(set).collect();
        if errors.is_empty() {
            errors.extend(stimulus.validate().err().into_iter().flatten());
        }
        if errors.is_empty() { Ok(stimulus) } else { Err(errors) }
    }

    /// Returns a text that is the same for equal stimuli only.
    pub fn key(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }

    /// Returns whether the stimulus varies only along its orientation.
    pub fn is_line(&self) -> bool {
        matches!(self, Self::MachBand(_) | Self::Chevreul(_) | Self::Cornsweet(_) | Self::Cylinder(_))
    }

    /// Returns the light of a window of `size` × `size` pixels.
    pub fn linear(&self, size: u32) -> LinearImage {
        self.drawn(|area| area.linear(size))
    }

    /// Returns the codes of a window of `size` × `size` pixels. They equal the quantized light of [`Stimulus::linear`].
    pub fn codes(&self, size: u32, quantizer: &Quantizer) -> CodeImage {
        self.drawn(|area| area.codes(size, quantizer))
    }

    /// Returns whether everything that is needed to draw the stimulus is known: of a study's own picture, the pixels.
    pub fn is_drawable(&self) -> bool {
        if let Self::Image(picture) = self { picture.is_read() } else { true }
    }

    /// Returns the side of the window in pixels, if the stimulus has a size of its own.
    pub fn side(&self) -> Option<u32> {
        if let Self::Image(picture) = self { picture.side() } else { None }
    }

    /// Returns the requested light at the centers of a row of `size` pixels through the center of the window, along the
    /// orientation.
    pub fn profile(&self, size: u32) -> Vec<[f32; 3]> {
        self.drawn(|area| area.profile(size))
    }

    /// Returns the light of a uniform field of relative luminance `level` in the color of this stimulus.
    pub fn field_light(&self, level: f64) -> [f32; 3] {
        self.color().light(level).map(|light| light as f32)
    }

    /// Returns the channel with the most light: 0 for red, 1 for green, 2 for blue. In a tie, the first one wins.
    pub fn strongest_channel(&self) -> usize {
        let weights = match self {
            // The brighter plateau decides if it has its own color.
            Self::MachBand(MachBand { color_high: Some(color), .. }) => color.rgb(),
            _ => self.color().rgb(),
        };
        (1..3).fold(0, |best, channel| if weights[channel] > weights[best] { channel } else { best })
    }

    /// Returns every parameter that can be set, in the order in which files list them.
    pub fn parameters(&self) -> &'static [Parameter] {
        parameters(self.kind())
    }

    /// Returns the stimulus of the kind `kind` with every parameter at its default, or `None` if there is no such kind.
    pub fn default_of(kind: &str) -> Option<Stimulus> {
        entry(kind).map(Entry::default_stimulus)
    }
}

/// A stimulus as the catalog lists it.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// Name in files and commands.
    pub kind: &'static str,
    /// Name shown to users.
    pub title: &'static str,
    /// What it shows, and who first described it.
    pub about: &'static str,
    /// Whether this kind can have Mach bands, which arise where a ramp of luminance begins or ends.
    pub has_bands: bool,
    /// Every parameter, in the order in which files list them.
    pub parameters: &'static [Parameter],
    default: fn() -> Stimulus,
}

impl Entry {
    /// Returns the stimulus with all parameters at their defaults.
    pub fn default_stimulus(&self) -> Stimulus {
        (self.default)()
    }
}

/// Returns the parameters of the kind `kind`, in the order in which files list them; none if there is no such kind.
pub fn parameters(kind: &str) -> &'static [Parameter] {
    if kind == Picture::KIND { Picture::PARAMETERS } else { entry(kind).map_or(&[], |entry| entry.parameters) }
}

/// True if some kind of stimulus has a parameter with exactly this name that is a direction.
pub fn is_direction(name: &str) -> bool {
    ENTRIES.iter().flat_map(|entry| entry.parameters).any(|parameter| parameter.name == name && parameter.is_direction)
}

/// Returns every entry, in a good order for a first tour.
pub fn all() -> &'static [Entry] {
    &ENTRIES
}

/// Returns the entry for a kind, or `None` if there is no such kind.
pub fn entry(kind: &str) -> Option<&'static Entry> {
    ENTRIES.iter().find(|entry| entry.kind == kind)
}
