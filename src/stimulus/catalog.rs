//! Every named stimulus, once. Commands take their `--kind` from here, the gallery its list, the tests their cases.

use super::{
    kinds::{KINDS, Stimulus},
    mach_band::MachBand,
    parameter::ParameterValue,
};

/// A stimulus as the catalog lists it.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// Name in files and commands.
    pub kind: &'static str,
    /// Name for people.
    pub title: &'static str,
    /// What there is to see, and who described it.
    pub about: &'static str,
    /// Parameter sets worth looking at, beside the defaults: names and values.
    pub variants: &'static [&'static [(&'static str, &'static str)]],
}

impl Entry {
    /// The entry with its defaults.
    #[must_use]
    pub fn default_stimulus(&self) -> Stimulus {
        Stimulus::default_of(self.kind).unwrap_or(MachBand::default().into())
    }

    /// The defaults, and then every variant.
    #[must_use]
    pub fn stimuli(&self) -> Vec<Stimulus> {
        let variant = |settings: &&[(&str, &str)]| {
            let mut stimulus = self.default_stimulus();
            for (name, text) in settings.iter() {
                let value: ParameterValue = text.parse().unwrap_or_else(|never| match never {});
                // A test sets every variant and looks at every error.
                let _ = stimulus.set(name, &value);
            }
            stimulus
        };
        std::iter::once(self.default_stimulus()).chain(self.variants.iter().map(variant)).collect()
    }
}

/// The catalog, in the order in which people should meet it.
#[must_use]
pub fn all() -> &'static [Entry] {
    &ENTRIES
}

/// The entry of a kind.
#[must_use]
pub fn entry(kind: &str) -> Option<&'static Entry> {
    ENTRIES.iter().find(|entry| entry.kind == kind)
}

static ENTRIES: [Entry; KINDS.len()] = [
    Entry {
        kind: "mach-band",
        title: "Mach band",
        about: "A ramp between two uniform areas: a bright line where it meets the bright area and a dark one where it meets the dark area, neither of them in the image. Mach 1865; Bangay §3.1.",
        variants: &[
            &[("width", "0.1"), ("depth", "3"), ("orientation_deg", "33")],
            &[("width", "0.8"), ("depth", "inf"), ("color", "gray"), ("orientation_deg", "90")],
        ],
    },
    Entry {
        kind: "chevreul",
        title: "Chevreul staircase",
        about: "Uniform bands that look scalloped: brighter at the edge toward the darker neighbor, darker at the other. Chevreul 1839.",
        variants: &[
            &[("steps", "9"), ("orientation_deg", "30")],
            &[("steps", "3"), ("color", "yellow"), ("orientation_deg", "90")],
        ],
    },
    Entry {
        kind: "cornsweet",
        title: "Craik–O'Brien–Cornsweet edge",
        about: "Two areas of the same luminance; the edge between them makes one look brighter. Cover the edge with a finger. Cornsweet 1970.",
        variants: &[
            &[("exponent", "2.75"), ("orientation_deg", "45")],
            &[("width", "0.4"), ("low", "0.3"), ("high", "0.7")],
        ],
    },
    Entry {
        kind: "vasarely",
        title: "Vasarely's nested squares",
        about: "Squares of graded luminance whose corners make bright diagonals that are not there. Vasarely; Bangay fig. 1 j.",
        variants: &[
            &[("squares", "24"), ("orientation_deg", "20")],
            &[("squares", "6"), ("low", "0.9"), ("high", "0.9")],
        ],
    },
    Entry {
        kind: "kanizsa",
        title: "Kanizsa triangle",
        about: "Three notched discs: a triangle seems to lie on them, brighter than the ground. Kanizsa 1955.",
        variants: &[
            &[("side", "0.4"), ("radius", "0.1"), ("orientation_deg", "30")],
            &[("radius", "0.25"), ("color", "yellow")],
        ],
    },
    Entry {
        kind: "shaded-mesh",
        title: "Shaded mesh",
        about: "A faceted surface that pretends to be smooth: Gouraud shading makes a Mach band of every edge; other shaders bend the light so that it does not. Gouraud 1971; Bangay §4.",
        variants: &[
            &[("shader", "patch"), ("color", "yellow")],
            &[("shader", "exact"), ("mesh", "torus"), ("vertices", "200"), ("boundary", "0.33")],
        ],
    },
    Entry {
        kind: "shaded-cylinder",
        title: "Shaded cylinder",
        about: "A faceted cylinder under flat, Gouraud or Phong shading: where Chevreul's scallops and Mach's bands come from in computer graphics. Bangay fig. 1 c, f.",
        variants: &[&[("shading", "flat"), ("orientation_deg", "15")], &[("shading", "phong"), ("facets", "12")]],
    },
];
