//! The color of a stimulus: the weights of red, green and blue.

use std::fmt;
use std::str::FromStr;

use crate::{
    light::{
        Transfer,
        color::{
            cmy_from_rgb, rgb_from_cmyk, rgb_from_hls, rgb_from_hsv, rgb_from_xyz, xyz_from_lab, xyz_from_luv,
            xyz_from_xyy,
        },
    },
    text::names::serde_as_text,
};

/// Weights of red, green and blue in linear light, each 0…1 and not all 0. A pixel of relative luminance L emits L
/// times these weights.
///
/// A color is written in one of these ways:
///
/// - a name: `yellow`, `gray` (also `white`), `red`, `green`, `blue`, `cyan` or `magenta`, the corners of the
///   screen's RGB cube;
/// - `R,G,B`, the weights themselves;
/// - `#RRGGBB`, a color of sRGB in hexadecimal codes, whose light is the weights;
/// - `hsv:H,S,V`, `hls:H,L,S`, `cmy:C,M,Y` or `cmyk:C,M,Y,K`, the models of Shoaff §2.2.5–2.2.7, applied to these
///   *linear* weights and not to code values; H is in degrees, all others are 0…1;
/// - `xyY:x,y,Y`, CIE chromaticity and luminance, or `lab:L,a,b` or `luv:L,u,v`, CIE 1976, all relative to the white
///   of a screen with sRGB primaries; L is 0…100.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StimulusColor {
    rgb: [f64; 3],
}

/// The colors that have names. If a color has several, the first is written.
const NAMED: [(&str, [f64; 3]); 8] = [
    ("yellow", [1.0, 1.0, 0.0]),
    ("gray", [1.0, 1.0, 1.0]),
    ("white", [1.0, 1.0, 1.0]),
    ("red", [1.0, 0.0, 0.0]),
    ("green", [0.0, 1.0, 0.0]),
    ("blue", [0.0, 0.0, 1.0]),
    ("cyan", [0.0, 1.0, 1.0]),
    ("magenta", [1.0, 0.0, 1.0]),
];

/// The description of the parameter `color`, the same for every kind.
pub(super) const MEANING: &str = "Weights of red, green and blue in linear light";

/// The strings that are valid colors, for error messages.
pub(super) const EXPECTED: &str = "yellow, gray, red, green, blue, cyan, magenta, three numbers R,G,B from 0 to 1, not \
                                   all 0, linear in light, #RRGGBB of sRGB, or hsv:H,S,V, hls:H,L,S, cmy:C,M,Y, cmyk:C,M,Y,K, \
                                   xyY:x,y,Y, lab:L,a,b or luv:L,u,v";

/// The error for a string that is not a color.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("color {color:?} {problem}; expected {EXPECTED}")]
pub struct ColorError {
    color: String,
    /// The problem, as a phrase that begins with a verb.
    pub problem: String,
}

/// The range of a quantity: its name in messages, its minimum and its maximum.
type Range = (&'static str, f64, f64);

const UNIT: Range = ("0…1", 0.0, 1.0);
const PERCENT: Range = ("0…100", 0.0, 100.0);
const DEGREES: Range = ("the finite angles", f64::MIN, f64::MAX);
const ANY: Range = ("the finite numbers", f64::MIN, f64::MAX);

fn outside(name: &str, value: f64, range: &str) -> String {
    format!("has {name} = {value}, outside {range}")
}

/// Reads the numbers of a color from `text` and checks that each is within its range.
fn quantities<const N: usize>(text: &str, names: [(&str, Range); N]) -> Result<[f64; N], String> {
    let unknown = || "is not known".to_owned();
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|number| number.trim().parse()).collect();
    let numbers: [f64; N] = numbers.map_err(|_| unknown())?.try_into().map_err(|_| unknown())?;
    for (value, (name, (range, least, most))) in numbers.iter().zip(names) {
        if !(least..=most).contains(value) {
            return Err(outside(name, *value, range));
        }
    }
    Ok(numbers)
}

fn from_rgb(rgb: [f64; 3]) -> Result<StimulusColor, String> {
    for (value, name) in rgb.iter().zip(["R", "G", "B"]) {
        if !(0.0..=1.0).contains(value) {
            return Err(outside(name, *value, "0…1"));
        }
    }
    // Adding 0 turns −0 into 0.
    if rgb == [0.0; 3] { Err("has no light in it".to_owned()) } else { Ok(StimulusColor { rgb: rgb.map(|v| v + 0.0) }) }
}

/// Light that is outside the gamut by at most this much counts as lying on its edge.
const OUTSIDE: f64 = 1e-9;
/// A weight closer than this to 0 or 1 counts as 0 or 1, so that the xyY of the white point is white.
const ROUNDING: f64 = 1e-12;

fn from_xyz(xyz: [f64; 3]) -> Result<StimulusColor, String> {
    let rgb = rgb_from_xyz(xyz);
    let beyond = rgb.iter().zip(["red", "green", "blue"]);
    let beyond: Vec<String> = beyond
        .filter(|(value, _)| !(-OUTSIDE..=1.0 + OUTSIDE).contains(*value))
        .map(|(value, name)| format!("{name} would be {value:.6}"))
        .collect();
    if !beyond.is_empty() {
        return Err(format!("is outside the gamut of sRGB: {}", beyond.join(", ")));
    }
    let rgb = rgb.map(|value| value.clamp(0.0, 1.0));
    from_rgb(rgb.map(|weight| if (weight - weight.round()).abs() < ROUNDING { weight.round() } else { weight }))
}

/// Returns the light of a color of sRGB, whose codes are six hexadecimal digits.
fn from_hex(digits: &str) -> Option<[f64; 3]> {
    let is_color = digits.len() == 6 && digits.bytes().all(|digit| digit.is_ascii_hexdigit());
    let codes = u32::from_str_radix(digits, 16).ok().filter(|_| is_color)?.to_be_bytes();
    Some([codes[1], codes[2], codes[3]].map(|code| Transfer::Srgb.linear_from_encoded(f64::from(code) / 255.0)))
}

fn parsed(text: &str) -> Result<StimulusColor, String> {
    if let Some((_, rgb)) = NAMED.iter().find(|(name, _)| *name == text) {
        return Ok(StimulusColor { rgb: *rgb });
    }
    if let Some(hex) = text.strip_prefix('#') {
        return from_rgb(from_hex(hex).ok_or_else(|| "is not known".to_owned())?);
    }
    let Some((model, list)) = text.split_once(':') else {
        return from_rgb(quantities(text, [("R", UNIT), ("G", UNIT), ("B", UNIT)])?);
    };
    match model {
        "hsv" => from_rgb(rgb_from_hsv(quantities(list, [("H", DEGREES), ("S", UNIT), ("V", UNIT)])?)),
        "hls" => from_rgb(rgb_from_hls(quantities(list, [("H", DEGREES), ("L", UNIT), ("S", UNIT)])?)),
        "cmy" => from_rgb(cmy_from_rgb(quantities(list, [("C", UNIT), ("M", UNIT), ("Y", UNIT)])?)),
        "cmyk" => from_rgb(rgb_from_cmyk(quantities(list, [("C", UNIT), ("M", UNIT), ("Y", UNIT), ("K", UNIT)])?)),
        "xyY" => {
            let [x, y, luminance] = quantities(list, [("x", UNIT), ("y", UNIT), ("Y", UNIT)])?;
            // Rounding may put a chromaticity slightly off the line x + y = 1.
            if y > 0.0 && x + y <= 1.0 + OUTSIDE {
                from_xyz(xyz_from_xyy([x, y, luminance]))
            } else {
                Err(outside("y", y, "0…1−x, 0 excluded"))
            }
        }
        "lab" => from_xyz(xyz_from_lab(quantities(list, [("L", PERCENT), ("a", ANY), ("b", ANY)])?)),
        "luv" => from_xyz(xyz_from_luv(quantities(list, [("L", PERCENT), ("u", ANY), ("v", ANY)])?)),
        _ => Err("is not known".to_owned()),
    }
}

impl StimulusColor {
    /// Equal amounts of red and green: Bangay §3.1.
    pub const YELLOW: StimulusColor = StimulusColor { rgb: [1.0, 1.0, 0.0] };
    /// The display's white, dimmed.
    pub const GRAY: StimulusColor = StimulusColor { rgb: [1.0, 1.0, 1.0] };

    /// Returns the weights of red, green and blue in linear light, 0…1.
    pub const fn rgb(self) -> [f64; 3] {
        self.rgb
    }

    /// Returns the light of this color at the relative luminance `luminance`.
    pub(super) fn light(self, luminance: f64) -> [f64; 3] {
        self.rgb.map(|weight| weight * luminance)
    }
}

impl fmt::Display for StimulusColor {
    /// Writes its name, if it has one, or else `R,G,B`, which reads back as exactly this color.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [r, g, b] = self.rgb;
        match NAMED.iter().find(|(_, rgb)| *rgb == self.rgb) {
            Some((name, _)) => f.write_str(name),
            None => write!(f, "{r},{g},{b}"),
        }
    }
}

impl FromStr for StimulusColor {
    type Err = ColorError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let text = text.trim();
        parsed(text).map_err(|problem| ColorError { color: text.to_owned(), problem })
    }
}

serde_as_text!(StimulusColor);
