//! The color of a stimulus: how much of its luminance goes to red, green and blue.

use std::fmt;
use std::str::FromStr;

use crate::light::color::{
    Chromaticity, Lab, Luv, OutOfGamut, Primaries, XyY, in_gamut, lab_from_xyz, luv_from_xyz, xyy_from_xyz,
    xyz_from_lab, xyz_from_luv, xyz_from_xyy,
};
use crate::light::color_models::{
    Cmyk, Hls, Hsv, cmy_from_cmyk, cmy_from_rgb, cmyk_from_cmy, hls_from_rgb, hsv_from_rgb, rgb_from_cmy, rgb_from_hls,
    rgb_from_hsv, wrapped_deg,
};
use crate::light::names::serde_as_text;

/// Weights of red, green and blue, linear in light, each 0…1 and not all 0. A pixel of relative
/// luminance L lights L times these.
///
/// Written in one of these ways, all of which say the same three weights:
///
/// - a name: `yellow`, `gray` (also `grey`, `white`), `red`, `green`, `blue`, `cyan`, `magenta`, the corners of the
///   screen's RGB cube;
/// - `R,G,B`, the weights themselves;
/// - `hsv:H,S,V`, `hls:H,L,S`, `cmy:C,M,Y` or `cmyk:C,M,Y,K`, the models of Shoaff §2.2.5–2.2.7 over these *linear*
///   weights, not over code values: H in degrees, the others 0…1;
/// - `xyY:x,y,Y`, CIE chromaticity and luminance, `lab:L,a,b` or `luv:L,u,v`, CIE 1976, relative to the white of a screen
///   with the primaries of sRGB; L 0…100.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StimulusColor {
    rgb: [f64; 3],
}

/// The colors that have a name. The first of equal ones is the one that is written.
const NAMED: [(&str, [f64; 3]); 9] = [
    ("yellow", [1.0, 1.0, 0.0]),
    ("gray", [1.0, 1.0, 1.0]),
    ("grey", [1.0, 1.0, 1.0]),
    ("white", [1.0, 1.0, 1.0]),
    ("red", [1.0, 0.0, 0.0]),
    ("green", [0.0, 1.0, 0.0]),
    ("blue", [0.0, 0.0, 1.0]),
    ("cyan", [0.0, 1.0, 1.0]),
    ("magenta", [1.0, 0.0, 1.0]),
];

/// What the parameter `color` means, of every kind.
pub(super) const MEANING: &str = "How much of the luminance goes to red, green and blue, linear in light";

/// What a color's text may be, for messages.
pub(super) const EXPECTED: &str = "yellow, gray, red, green, blue, cyan, magenta, three numbers R,G,B from 0 to 1, not \
                                   all 0, linear in light, or hsv:H,S,V, hls:H,L,S, cmy:C,M,Y, cmyk:C,M,Y,K, \
                                   xyY:x,y,Y, lab:L,a,b or luv:L,u,v";

/// A text or triple that is no color.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("color {color} {}; expected {EXPECTED}", self.problem())]
pub struct ColorError {
    /// What was given.
    color: String,
    fault: Fault,
}

#[derive(Clone, Debug, PartialEq)]
enum Fault {
    Unknown,
    Number { name: &'static str, value: f64, range: &'static str },
    Dark,
    OutOfGamut(OutOfGamut),
}

impl ColorError {
    /// What is wrong: a verb and what follows.
    #[must_use]
    pub fn problem(&self) -> String {
        match &self.fault {
            Fault::Unknown => "is not known".to_owned(),
            Fault::Number { name, value, range } => format!("has {name} = {value}, outside {range}"),
            Fault::Dark => "has no light in it".to_owned(),
            Fault::OutOfGamut(by_how_much) => format!("is outside the gamut of sRGB: {by_how_much}"),
        }
    }
}

fn within_unit(name: &'static str, value: f64) -> Result<f64, Fault> {
    // −0 is within the range; it must not be written.
    if (0.0..=1.0).contains(&value) { Ok(value + 0.0) } else { Err(Fault::Number { name, value, range: "0…1" }) }
}

fn from_rgb([r, g, b]: [f64; 3]) -> Result<StimulusColor, Fault> {
    let rgb = [within_unit("R", r)?, within_unit("G", g)?, within_unit("B", b)?];
    if rgb == [0.0; 3] { Err(Fault::Dark) } else { Ok(StimulusColor { rgb }) }
}

fn hue(degrees: f64) -> Result<Option<f64>, Fault> {
    if degrees.is_finite() {
        Ok(Some(degrees))
    } else {
        Err(Fault::Number { name: "H", value: degrees, range: "the angles in degrees" })
    }
}

fn lightness(value: f64) -> Result<f64, Fault> {
    if (0.0..=100.0).contains(&value) { Ok(value) } else { Err(Fault::Number { name: "L", value, range: "0…100" }) }
}

/// Closer than this to 0 or 1 a weight is meant to be it: the white point's own xyY is white.
const ROUNDING: f64 = 1e-12;
const WHITE: [f64; 3] = Primaries::SRGB.white_xyz();

fn from_xyz(xyz: [f64; 3]) -> Result<StimulusColor, Fault> {
    let rgb = in_gamut(Primaries::SRGB.rgb_from_xyz(xyz)).map_err(Fault::OutOfGamut)?;
    from_rgb(rgb.map(|weight| if (weight - weight.round()).abs() < ROUNDING { weight.round() } else { weight }))
}

fn from_xyy([x, y, luminance]: [f64; 3]) -> Result<StimulusColor, Fault> {
    let chromaticity = Chromaticity::new(x, y).map_err(|_| {
        if (0.0..=1.0).contains(&x) {
            Fault::Number { name: "y", value: y, range: "0…1−x, 0 excluded" }
        } else {
            Fault::Number { name: "x", value: x, range: "0…1" }
        }
    })?;
    from_xyz(xyz_from_xyy(XyY { chromaticity, luminance: within_unit("Y", luminance)? }))
}

fn parsed(text: &str) -> Result<StimulusColor, Fault> {
    if let Some((_, rgb)) = NAMED.iter().find(|(name, _)| *name == text) {
        return Ok(StimulusColor { rgb: *rgb });
    }
    let Some((model, list)) = text.split_once(':') else { return from_rgb(numbers(text)?) };
    let inks =
        |inks: [f64; 3]| Ok([within_unit("C", inks[0])?, within_unit("M", inks[1])?, within_unit("Y", inks[2])?]);
    match model {
        "hsv" => {
            let [h, s, v] = numbers(list)?;
            from_rgb(rgb_from_hsv(Hsv { hue: hue(h)?, saturation: within_unit("S", s)?, value: within_unit("V", v)? }))
        }
        "hls" => {
            let [h, l, s] = numbers(list)?;
            let (lightness, saturation) = (within_unit("L", l)?, within_unit("S", s)?);
            from_rgb(rgb_from_hls(Hls { hue: hue(h)?, lightness, saturation }))
        }
        "cmy" => from_rgb(rgb_from_cmy(inks(numbers(list)?)?)),
        "cmyk" => {
            let [c, m, y, k] = numbers(list)?;
            let ([cyan, magenta, yellow], black) = (inks([c, m, y])?, within_unit("K", k)?);
            from_rgb(rgb_from_cmy(cmy_from_cmyk(Cmyk { cyan, magenta, yellow, black })))
        }
        "xyY" => from_xyy(numbers(list)?),
        "lab" => {
            let [l, a, b] = numbers(list)?;
            from_xyz(xyz_from_lab(Lab { lightness: lightness(l)?, a, b }, WHITE))
        }
        "luv" => {
            let [l, u, v] = numbers(list)?;
            from_xyz(xyz_from_luv(Luv { lightness: lightness(l)?, u, v }, WHITE))
        }
        _ => Err(Fault::Unknown),
    }
}

fn numbers<const N: usize>(text: &str) -> Result<[f64; N], Fault> {
    let numbers: Vec<f64> =
        text.split(',').map(|number| number.trim().parse()).collect::<Result<_, _>>().map_err(|_| Fault::Unknown)?;
    numbers.try_into().map_err(|_| Fault::Unknown)
}

impl StimulusColor {
    /// Equal quantities of red and green: Bangay §3.1.
    pub const YELLOW: StimulusColor = StimulusColor { rgb: [1.0, 1.0, 0.0] };
    /// The display's white, dimmed.
    pub const GRAY: StimulusColor = StimulusColor { rgb: [1.0, 1.0, 1.0] };

    /// The color of the weights `rgb`.
    ///
    /// # Errors
    /// When one is not within 0…1, or all are 0.
    pub fn new(rgb: [f64; 3]) -> Result<Self, ColorError> {
        let [r, g, b] = rgb;
        from_rgb(rgb).map_err(|fault| ColorError { color: format!("{r},{g},{b}"), fault })
    }

    /// Weights of red, green and blue, 0…1, linear in light.
    #[must_use]
    pub const fn rgb(self) -> [f64; 3] {
        self.rgb
    }

    /// This color in every model, to three decimals; a gray, which has no hue, with hue 0.
    #[must_use]
    pub fn in_models(self) -> Vec<String> {
        let Cmyk { cyan, magenta, yellow, black } = cmyk_from_cmy(cmy_from_rgb(self.rgb));
        let hls = hls_from_rgb(self.rgb);
        let xyz = Primaries::SRGB.xyz_from_rgb(self.rgb);
        let (lab, luv) = (lab_from_xyz(xyz, WHITE), luv_from_xyz(xyz, WHITE));
        let others = [
            ("hls", vec![hls.hue.unwrap_or(0.0), hls.lightness, hls.saturation]),
            ("cmy", cmy_from_rgb(self.rgb).to_vec()),
            ("cmyk", vec![cyan, magenta, yellow, black]),
            ("lab", vec![lab.lightness, lab.a, lab.b]),
            ("luv", vec![luv.lightness, luv.u, luv.v]),
        ];
        let rgb = written("", &self.rgb, 1e3);
        let [hsv, xyy] = [self.hsv().unwrap_or([0.0, 0.0, self.rgb[0]]), self.xyy().unwrap_or_default()];
        let first = [rgb, written("hsv:", &hsv, 1e3), written("xyY:", &xyy, 1e3)];
        first.into_iter().chain(others.iter().map(|(model, parts)| written(&format!("{model}:"), parts, 1e3))).collect()
    }

    /// Hue, saturation and value; `None` for a gray.
    fn hsv(self) -> Option<[f64; 3]> {
        let Hsv { hue, saturation, value } = hsv_from_rgb(self.rgb);
        Some([hue?, saturation, value])
    }

    fn xyy(self) -> Option<[f64; 3]> {
        let xyy = xyy_from_xyz(Primaries::SRGB.xyz_from_rgb(self.rgb))?;
        Some([xyy.chromaticity.x(), xyy.chromaticity.y(), xyy.luminance])
    }

    /// The texts that this color may have come from: as `hsv:` and as `xyY:`, with more and more decimals.
    fn candidates(self) -> impl Iterator<Item = String> {
        DECIMALS.into_iter().flat_map(move |scale| {
            let hsv = self.hsv().map(|[h, s, v]| written("hsv:", &[wrapped_deg(rounded(h, scale)), s, v], scale));
            hsv.into_iter().chain(self.xyy().map(|xyy| written("xyY:", &xyy, scale)))
        })
    }
}

/// 10 to the number of decimals with which a color is tried as `hsv:` or `xyY:`: more than people write.
const DECIMALS: [f64; 7] = [1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6];

/// The multiple of 1/`scale` nearest to `number`.
fn rounded(number: f64, scale: f64) -> f64 {
    (number * scale).round() / scale + 0.0
}

/// The numbers of a color in a model, each a multiple of 1/`scale`.
fn written(model: &str, numbers: &[f64], scale: f64) -> String {
    let numbers: Vec<String> = numbers.iter().map(|number| rounded(*number, scale).to_string()).collect();
    format!("{model}{}", numbers.join(","))
}

impl fmt::Display for StimulusColor {
    /// The shortest text that reads back as exactly this color: a name if it has one, else the shortest of `R,G,B`,
    /// `hsv:H,S,V` and `xyY:x,y,Y`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some((name, _)) = NAMED.iter().find(|(_, rgb)| *rgb == self.rgb) {
            return f.write_str(name);
        }
        let [r, g, b] = self.rgb;
        let mut shortest = format!("{r},{g},{b}");
        for text in self.candidates() {
            if text.len() < shortest.len() && parsed(&text).as_ref() == Ok(self) {
                shortest = text;
            }
        }
        f.write_str(&shortest)
    }
}

impl FromStr for StimulusColor {
    type Err = ColorError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let text = text.trim();
        parsed(text).map_err(|fault| ColorError { color: format!("{text:?}"), fault })
    }
}

serde_as_text!(StimulusColor);
