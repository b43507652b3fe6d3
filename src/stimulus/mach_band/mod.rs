//! The Mach-band stimulus of Bangay §3.1: two plateaus of luminance and the ramp between them, turned
//! about the centre.

mod lookup;
mod passage;

use serde::{Deserialize, Serialize};

use super::color::{self, StimulusColor};
use super::fast;
use super::orientation::Grid;
use super::parameter::{Parameter, ParameterError, ParameterValue};
use crate::light::interpolation::TANH_K;
use crate::light::{Bits, CodeImage, Depth, Interpolation, LinearImage, Quantizer, Samples};
use passage::Passage;
pub use passage::{RampSpace, RampSpaceError};

/// A square window of side 1 with a ramp across its middle. Light, not codes: L = low + (high −
/// low)·I_n(u), u = x/width + ½, x the distance from the centre line, positive on the brighter
/// side.
///
/// The plateaus light low·`color` and high·`color_high`; the ramp is the straight line between them in `space`, I_n(u) of
/// the way along.
///
/// Fields left out of a file have their defaults, those of Bangay. The last two are left out of a file where they say
/// nothing, so that it is the same file as before there were two colors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MachBand {
    /// Proportion w of the window's side that the ramp fills, 0…1; 0 is a step.
    pub width: f64,
    /// Continuity depth n of the ramp, 1…32 or inf.
    pub depth: Depth,
    /// Steepness k of the ramp of infinite depth, above 0, at most 100; finite depths do not use
    /// it.
    pub tanh_k: f64,
    /// Orientation θ in degrees, counter-clockwise, to 1e-9°: 0 brightens to the right, 90 upwards.
    pub orientation_deg: f64,
    /// Relative luminance of the darker plateau, 0…1.
    pub low: f64,
    /// Relative luminance of the brighter plateau, `low`…1. Equal to `low`, in one color, it is a
    /// uniform field: a catch trial.
    pub high: f64,
    /// Weights of red, green and blue.
    pub color: StimulusColor,
    /// Weights on the brighter plateau, if not those of `color`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub color_high: Option<StimulusColor>,
    /// The space in which the ramp goes straight from plateau to plateau.
    #[serde(skip_serializing_if = "RampSpace::is_default")]
    pub space: RampSpace,
}

impl Default for MachBand {
    fn default() -> Self {
        Self {
            width: 0.4,
            depth: Depth::Finite(1),
            tanh_k: TANH_K,
            orientation_deg: 0.0,
            low: 0.25,
            high: 0.75,
            color: StimulusColor::YELLOW,
            color_high: None,
            space: RampSpace::Rgb,
        }
    }
}

const WIDTH: Parameter = Parameter {
    name: "width",
    unit: "1",
    description: "Proportion of the window that the ramp fills; 0 is a step",
    expected: "the proportion of the window that the ramp fills",
    levels_hint: &["0", "0.05", "0.1", "0.2", "0.4", "0.8"],
};
const DEPTH: Parameter = Parameter {
    name: "depth",
    unit: "1",
    description: "Continuity depth n of the ramp: n − 1 derivatives vanish at its ends; inf is a scaled tanh",
    expected: "a whole number from 1 to 32, or inf",
    levels_hint: &["1", "2", "3", "4", "inf"],
};
const TANH: Parameter = Parameter {
    name: "tanh_k",
    unit: "1",
    description: "Steepness k of the ramp of infinite depth; 5 as printed, 10 without a visible step at its ends",
    expected: "a steepness above 0 and at most 100, such as 5",
    levels_hint: &["5", "10"],
};
const ORIENTATION: Parameter = Parameter {
    name: "orientation_deg",
    unit: "°",
    description: "Orientation, counter-clockwise: 0 brightens to the right, 90 upwards",
    expected: "an angle in degrees, such as 45",
    levels_hint: &["0", "45", "90", "135"],
};
const LOW: Parameter = Parameter {
    name: "low",
    unit: "1",
    description: "Relative luminance of the darker plateau",
    expected: "the relative luminance of the darker plateau",
    levels_hint: &["0.25"],
};
const HIGH: Parameter = Parameter {
    name: "high",
    unit: "1",
    description: "Relative luminance of the brighter plateau",
    expected: "the relative luminance of the brighter plateau, at least low's",
    levels_hint: &["0.75"],
};
const COLOR: Parameter = Parameter {
    name: "color",
    unit: "",
    description: "How much of the luminance goes to red, green and blue, linear in light",
    expected: color::EXPECTED,
    levels_hint: &["yellow", "gray"],
};
/// The value of `color_high` that stands for `color`'s.
const SAME: &str = "same";
const COLOR_HIGH: Parameter = Parameter {
    name: "color_high",
    unit: "",
    description: "The color of the brighter plateau; same is the darker one's",
    expected: "same, or a color as for color, such as red, 1,0.5,0 or hsv:30,1,1",
    levels_hint: &["same", "gray"],
};
const SPACE: Parameter = Parameter {
    name: "space",
    unit: "",
    description: "The space in which the ramp goes straight from plateau to plateau; rgb is linear light",
    expected: "rgb, hsv or lab",
    levels_hint: &["rgb", "hsv", "lab"],
};

/// Checks one number against its own range. `accept` is false for NaN.
fn in_range(parameter: &Parameter, value: f64, accept: bool, problem: &str) -> Result<f64, ParameterError> {
    if accept {
        Ok(value)
    } else if value.is_finite() {
        Err(parameter.error(value, problem))
    } else {
        Err(parameter.error(value, "is not a finite number"))
    }
}

fn proportion(parameter: &Parameter, value: f64) -> Result<f64, ParameterError> {
    in_range(parameter, value, (0.0..=1.0).contains(&value), "is outside 0…1")
}

fn steepness(value: f64) -> Result<f64, ParameterError> {
    in_range(&TANH, value, value > 0.0 && value <= 100.0, "is no steepness that a ramp can have")
}

fn orientation(value: f64) -> Result<f64, ParameterError> {
    in_range(&ORIENTATION, value, value.is_finite(), "is not an angle")
}

fn depth(value: &ParameterValue) -> Result<Depth, ParameterError> {
    match value {
        ParameterValue::Text(text) => text.parse().map_err(|_| DEPTH.error(format!("{text:?}"), "is not a depth")),
        ParameterValue::Number(n) if n.fract() != 0.0 => Err(DEPTH.error(n, "is not a whole number")),
        // A whole number or ±∞: `as` keeps it in u32's range, outside the depths where it was
        // outside.
        ParameterValue::Number(n) => Depth::finite(*n as u32).map_err(|_| DEPTH.error(n, "is outside 1…32")),
    }
}

fn parsed_color(parameter: &Parameter, value: &ParameterValue) -> Result<StimulusColor, ParameterError> {
    let text = value.to_string();
    text.parse().map_err(|fault: color::ColorError| parameter.error(format!("{text:?}"), fault.problem()))
}

fn number(parameter: &Parameter, value: &ParameterValue) -> Result<f64, ParameterError> {
    match value {
        ParameterValue::Number(number) => Ok(*number),
        ParameterValue::Text(text) => Err(parameter.error(format!("{text:?}"), "is not a number")),
    }
}

impl MachBand {
    /// This kind's name in files and commands.
    pub const KIND: &'static str = "mach-band";

    /// Every parameter, in the order of the fields.
    pub const PARAMETERS: &'static [Parameter] =
        &[WIDTH, DEPTH, TANH, ORIENTATION, LOW, HIGH, COLOR, COLOR_HIGH, SPACE];

    /// Sets the parameter `name`, checking its own range only.
    ///
    /// # Errors
    /// When there is no such parameter, or it cannot have this value.
    pub fn set(&mut self, name: &str, value: &ParameterValue) -> Result<(), ParameterError> {
        match name {
            "width" => self.width = proportion(&WIDTH, number(&WIDTH, value)?)?,
            "depth" => self.depth = depth(value)?,
            "tanh_k" => self.tanh_k = steepness(number(&TANH, value)?)?,
            "orientation_deg" => self.orientation_deg = orientation(number(&ORIENTATION, value)?)?,
            "low" => self.low = proportion(&LOW, number(&LOW, value)?)?,
            "high" => self.high = proportion(&HIGH, number(&HIGH, value)?)?,
            "color" => self.color = parsed_color(&COLOR, value)?,
            "color_high" => {
                let same = value.to_string().trim() == SAME;
                self.color_high = if same { None } else { Some(parsed_color(&COLOR_HIGH, value)?) };
            }
            "space" => {
                let space = value.to_string();
                self.space = space.parse().map_err(|_| SPACE.error(format!("{space:?}"), "is not known"))?;
            }
            _ => return Err(ParameterError::unknown(name, value, Self::KIND, Self::PARAMETERS)),
        }
        Ok(())
    }

    /// The value of the parameter `name`; `None` if there is no such parameter.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<ParameterValue> {
        Some(match name {
            "width" => self.width.into(),
            "depth" => match self.depth {
                Depth::Finite(n) => f64::from(n).into(),
                Depth::Infinite => self.depth.to_string().as_str().into(),
            },
            "tanh_k" => self.tanh_k.into(),
            "orientation_deg" => self.orientation_deg.into(),
            "low" => self.low.into(),
            "high" => self.high.into(),
            "color" => self.color.to_string().as_str().into(),
            "color_high" => self.color_high.map_or(SAME.into(), |color| color.to_string().as_str().into()),
            "space" => self.space.to_string().as_str().into(),
            _ => return None,
        })
    }

    /// Whether every parameter is within its range, and low is not above high.
    ///
    /// # Errors
    /// Every fault found, in the order of the fields.
    pub fn validate(&self) -> Result<(), Vec<ParameterError>> {
        let checks = [
            proportion(&WIDTH, self.width).err(),
            (!self.depth.is_valid()).then(|| DEPTH.error(self.depth, "is outside 1…32")),
            steepness(self.tanh_k).err(),
            orientation(self.orientation_deg).err(),
            proportion(&LOW, self.low).err(),
            proportion(&HIGH, self.high).err(),
            (self.low > self.high).then(|| HIGH.error(self.high, format!("is below low, which is {}", self.low))),
        ];
        let faults: Vec<ParameterError> = checks.into_iter().flatten().collect();
        if faults.is_empty() { Ok(()) } else { Err(faults) }
    }

    /// The profile across the ramp, ready to be evaluated many times: how far it has come from low to high, whatever the
    /// colors and the space.
    #[must_use]
    pub fn ramp(&self) -> Ramp {
        Ramp {
            interpolation: Interpolation::with_k(self.depth, self.tanh_k),
            width: self.width,
            low: self.low,
            high: self.high,
        }
    }

    /// Relative luminance at `x` window sides from the centre line, positive on the brighter side;
    /// −½…½ is the window at 0°.
    ///
    /// In one color, straight in RGB or HSV, it is low + (high − low)·I_n(u). Otherwise it is the luminance Y of
    /// [`MachBand::light_at`], by the primaries of sRGB, over that of `color` at its full: still low on the darker plateau,
    /// and on the brighter one high in units of another color, so possibly below low or above 1.
    #[must_use]
    pub fn luminance_at(&self, x: f64) -> f64 {
        Passage::new(self).luminance_at(&self.ramp(), x, self.color)
    }

    /// The light asked at `x` window sides from the centre line, positive on the brighter side: red,
    /// green and blue, 0…1. What [`MachBand::linear`] puts into every pixel.
    #[must_use]
    pub fn light_at(&self, x: f64) -> [f32; 3] {
        Passage::new(self).light_at(&self.ramp(), x)
    }

    /// The light of a window of `size` × `size` pixels, each taken at its centre. The reference:
    /// every pixel on its own, in f64, rounded once to f32.
    #[must_use]
    pub fn linear(&self, size: u32) -> LinearImage {
        let (grid, ramp, passage) = (Grid::new(size, self.orientation_deg), self.ramp(), Passage::new(self));
        LinearImage::from_fn(size, size, |ix, iy| passage.light_at(&ramp, grid.across(ix, iy)))
    }

    /// The codes of a window of `size` × `size` pixels: exactly those of [`MachBand::linear`],
    /// quantised. At 8 bits and in one color, straight in RGB or HSV, this is a fast path that costs
    /// little more than writing the memory.
    #[must_use]
    pub fn codes(&self, size: u32, quantizer: &Quantizer) -> CodeImage {
        match quantizer.bits() {
            Bits::Eight => {
                let mut codes = vec![0; size as usize * size as usize * 3];
                self.codes_into(size, quantizer, &mut codes);
                CodeImage { width: size, height: size, samples: Samples::Eight(codes) }
            }
            Bits::Sixteen => quantizer.quantize(&self.linear(size)),
        }
    }

    /// [`MachBand::codes`] at 8 bits, into memory that is already there: red green blue, row by row
    /// from the top.
    ///
    /// # Panics
    /// When `codes` is not 3 · `size`² bytes long, or `quantizer` is not one of 8 bits.
    pub fn codes_into(&self, size: u32, quantizer: &Quantizer, codes: &mut [u8]) {
        assert_eq!(codes.len(), size as usize * size as usize * 3, "3 bytes a pixel, {size} × {size} pixels");
        assert_eq!(quantizer.bits(), Bits::Eight, "bytes hold 8-bit codes");
        match Passage::new(self) {
            Passage::OneColor { .. } => fast::render(self, size, quantizer, codes),
            Passage::Between(between) => lookup::render(self, &between, size, quantizer, codes),
        }
    }
}

/// Light of a pixel of relative luminance `luminance`.
#[inline]
pub(super) fn light(weights: [f64; 3], luminance: f64) -> [f32; 3] {
    weights.map(|weight| (weight * luminance) as f32)
}

/// Luminance as a function of the position across the ramp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ramp {
    pub(super) interpolation: Interpolation,
    pub(super) width: f64,
    pub(super) low: f64,
    pub(super) high: f64,
}

impl Ramp {
    /// Relative luminance at `x` window sides from the centre line, positive on the brighter side.
    ///
    /// A ramp of width 0 is the limit of narrow ones: low before the line, high after it, and
    /// half-way on it.
    #[must_use]
    #[inline]
    pub fn luminance_at(&self, x: f64) -> f64 {
        self.luminance_at_u(self.u(x))
    }

    /// I_n at `x` window sides from the centre line: how much of the way from plateau to plateau, 0…1.
    #[must_use]
    #[inline]
    pub fn part_at(&self, x: f64) -> f64 {
        self.interpolation.value(self.u(x))
    }

    #[inline]
    fn u(&self, x: f64) -> f64 {
        // x/0 is ±∞ off the line, which the interpolation takes to 0 and 1; only 0/0 needs a word.
        if x == 0.0 { 0.5 } else { x / self.width + 0.5 }
    }

    /// Relative luminance at the position u across the ramp, 0 where it begins and 1 where it ends.
    #[must_use]
    #[inline]
    pub fn luminance_at_u(&self, u: f64) -> f64 {
        let part = self.interpolation.value(u);
        if part >= 1.0 {
            // low + (high − low) can miss high by a rounding.
            self.high
        } else {
            (self.low + (self.high - self.low) * part).min(self.high)
        }
    }
}
