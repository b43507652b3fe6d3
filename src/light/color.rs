//! Which light a screen's primaries make: RGB to CIE XYZ and back, xyY, CIELAB and CIELUV. Shoaff §2.2.3, §2.2.4.
//!
//! RGB here is linear in light, each 0…1 on a screen. XYZ is in the units of its luminance Y. Lab and Luv are CIE 1976,
//! as CIE 15:2004 gives them, with its exact constants; the white point is an argument.
//!
//! Every function's name says its direction. The models that only rearrange RGB are in
//! [`color_models`](super::color_models).

use std::fmt;

type Matrix = [[f64; 3]; 3];

/// A point of the CIE 1931 chromaticity diagram: x = X/(X+Y+Z), y = Y/(X+Y+Z). Shoaff §2.2.3.
///
/// Within the triangle of X, Y and Z without its base: x ≥ 0, y > 0, x + y ≤ 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chromaticity {
    x: f64,
    y: f64,
}

/// How far outside its triangle a chromaticity may be: a few roundings.
const ROUNDING: f64 = 1e-9;

impl Chromaticity {
    /// CIE standard illuminant D65 for the 2° observer, to the four digits of IEC 61966-2-1 and ITU-R BT.709.
    pub const D65: Chromaticity = Chromaticity { x: 0.3127, y: 0.3290 };

    /// The chromaticity (`x`, `y`).
    ///
    /// # Errors
    /// When no light has it: x below 0, y not above 0, x + y above 1, or one that is not a number.
    pub const fn new(x: f64, y: f64) -> Result<Chromaticity, PrimariesError> {
        // False for NaN.
        if x >= 0.0 && y > 0.0 && x + y <= 1.0 + ROUNDING {
            Ok(Chromaticity { x, y })
        } else {
            Err(PrimariesError::Chromaticity { x, y })
        }
    }

    /// x, 0…1.
    #[must_use]
    pub const fn x(self) -> f64 {
        self.x
    }

    /// y, above 0, at most 1.
    #[must_use]
    pub const fn y(self) -> f64 {
        self.y
    }

    /// X, Y and Z of this chromaticity at the luminance `luminance`: X = Y·x/y, Z = Y·(1−x−y)/y. Shoaff §2.2.3.
    #[must_use]
    pub const fn xyz_at(self, luminance: f64) -> [f64; 3] {
        let total = luminance / self.y;
        [self.x * total, luminance, (1.0 - self.x - self.y) * total]
    }
}

/// A color as chromaticity and luminance, CIE xyY.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct XyY {
    /// Which color.
    pub chromaticity: Chromaticity,
    /// How much of it, the Y of XYZ, in its units.
    pub luminance: f64,
}

/// X, Y and Z. Shoaff §2.2.3.
#[must_use]
pub const fn xyz_from_xyy(color: XyY) -> [f64; 3] {
    color.chromaticity.xyz_at(color.luminance)
}

/// xyY, or `None` where there is no chromaticity: for black, which has none, and for X, Y and Z that no light has.
/// Shoaff §2.2.3.
#[must_use]
pub fn xyy_from_xyz([x, y, z]: [f64; 3]) -> Option<XyY> {
    let total = x + y + z;
    let chromaticity = Chromaticity::new(x / total, y / total).ok()?;
    (y > 0.0).then_some(XyY { chromaticity, luminance: y })
}

/// Three lights that a screen mixes, and how much of each is its full.
///
/// XYZ = M·RGB, the columns of M the primaries' XYZ: C_i·(x_i, y_i, 1 − x_i − y_i) with C_i = Y_i/y_i. Shoaff §2.2.4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Primaries {
    xyz_from_rgb: Matrix,
    rgb_from_xyz: Matrix,
}

/// Why something is no set of primaries.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PrimariesError {
    /// A chromaticity that no light has.
    #[error("chromaticity ({x}, {y}) is no light's; expected x ≥ 0, y > 0 and x + y ≤ 1, such as 0.64, 0.33")]
    Chromaticity {
        /// The x given.
        x: f64,
        /// The y given.
        y: f64,
    },
    /// A primary without light.
    #[error("the luminance of {channel} is {luminance}; expected one above 0, of the primary at its full")]
    Luminance {
        /// `red`, `green` or `blue`.
        channel: &'static str,
        /// The luminance given.
        luminance: f64,
    },
    /// Three chromaticities on one line.
    #[error("the three primaries lie on one line of the chromaticity diagram; expected a triangle")]
    Collinear,
    /// A white that a mixture cannot reach.
    #[error(
        "the white point ({x}, {y}) needs {channel} at a luminance of {luminance}; expected it inside the primaries' triangle"
    )]
    White {
        /// x of the white point.
        x: f64,
        /// y of the white point.
        y: f64,
        /// `red`, `green` or `blue`.
        channel: &'static str,
        /// What the white needs of it, relative to the white's own luminance.
        luminance: f64,
    },
}

/// The channels' names.
const CHANNELS: [&str; 3] = ["red", "green", "blue"];

/// Twice the area below which a triangle in the chromaticity diagram is a line. sRGB's is 0.22.
const SMALLEST_TRIANGLE: f64 = 1e-9;

impl Primaries {
    /// sRGB and Rec. 709: the primaries of ITU-R BT.709-6 and IEC 61966-2-1, white D65.
    ///
    /// Computed from the chromaticities. The matrix that IEC 61966-2-1 prints is this one rounded to four digits.
    pub const SRGB: Primaries = match Primaries::from_white(
        [Chromaticity { x: 0.64, y: 0.33 }, Chromaticity { x: 0.30, y: 0.60 }, Chromaticity { x: 0.15, y: 0.06 }],
        Chromaticity::D65,
    ) {
        Ok(primaries) => primaries,
        Err(_) => panic!("the standard's primaries are a triangle around its white"),
    };

    /// The primaries of the `chromaticities` of red, green and blue, which have the `luminances` at their full; both as
    /// measured. XYZ is in the units of `luminances`.
    ///
    /// # Errors
    /// When a luminance is not above 0 and finite, or the three lie on one line.
    pub const fn from_luminances(
        chromaticities: [Chromaticity; 3],
        luminances: [f64; 3],
    ) -> Result<Primaries, PrimariesError> {
        let mut channel = 0;
        while channel < 3 {
            let luminance = luminances[channel];
            if !(luminance > 0.0 && luminance < f64::INFINITY) {
                return Err(PrimariesError::Luminance { channel: CHANNELS[channel], luminance });
            }
            channel += 1;
        }
        let xyz_from_rgb = columns(chromaticities, luminances);
        match (twice_area(chromaticities), inverse(&xyz_from_rgb)) {
            (area, Some(rgb_from_xyz)) if area > SMALLEST_TRIANGLE => Ok(Primaries { xyz_from_rgb, rgb_from_xyz }),
            _ => Err(PrimariesError::Collinear),
        }
    }

    /// The primaries of the `chromaticities` of red, green and blue of which equal quantities make the `white` point. XYZ is
    /// relative: white has Y = 1.
    ///
    /// # Errors
    /// When the three lie on one line, or `white` is not inside their triangle.
    pub const fn from_white(
        chromaticities: [Chromaticity; 3],
        white: Chromaticity,
    ) -> Result<Primaries, PrimariesError> {
        if twice_area(chromaticities) <= SMALLEST_TRIANGLE {
            return Err(PrimariesError::Collinear);
        }
        let Some(unit) = inverse(&columns(chromaticities, [1.0; 3])) else {
            return Err(PrimariesError::Collinear);
        };
        // How much of each primary, in luminance, the white of luminance 1 is made of.
        let luminances = product(&unit, white.xyz_at(1.0));
        let mut channel = 0;
        while channel < 3 {
            let luminance = luminances[channel];
            if luminance <= ROUNDING {
                let (x, y) = (white.x, white.y);
                return Err(PrimariesError::White { x, y, channel: CHANNELS[channel], luminance });
            }
            channel += 1;
        }
        Primaries::from_luminances(chromaticities, luminances)
    }

    /// X, Y and Z of the screen's white.
    #[must_use]
    pub const fn white_xyz(&self) -> [f64; 3] {
        product(&self.xyz_from_rgb, [1.0; 3])
    }

    /// X, Y and Z of the light `rgb`. Shoaff §2.2.4.
    #[must_use]
    pub const fn xyz_from_rgb(&self, rgb: [f64; 3]) -> [f64; 3] {
        product(&self.xyz_from_rgb, rgb)
    }

    /// The RGB that makes `xyz`, outside 0…1 if this screen cannot show it; [`in_gamut`] decides. Shoaff §2.2.4.
    ///
    /// Between screens: `b.rgb_from_xyz(a.xyz_from_rgb(rgb))` is Shoaff's M₂⁻¹·M₁.
    #[must_use]
    pub const fn rgb_from_xyz(&self, xyz: [f64; 3]) -> [f64; 3] {
        product(&self.rgb_from_xyz, xyz)
    }
}

/// The XYZ of the three primaries as columns.
const fn columns(chromaticities: [Chromaticity; 3], luminances: [f64; 3]) -> Matrix {
    let [r, g, b] = [
        chromaticities[0].xyz_at(luminances[0]),
        chromaticities[1].xyz_at(luminances[1]),
        chromaticities[2].xyz_at(luminances[2]),
    ];
    [[r[0], g[0], b[0]], [r[1], g[1], b[1]], [r[2], g[2], b[2]]]
}

/// Twice the area of the triangle that three chromaticities span.
const fn twice_area([r, g, b]: [Chromaticity; 3]) -> f64 {
    ((g.x - r.x) * (b.y - r.y) - (b.x - r.x) * (g.y - r.y)).abs()
}

const fn product(m: &Matrix, [a, b, c]: [f64; 3]) -> [f64; 3] {
    [
        m[0][0] * a + m[0][1] * b + m[0][2] * c,
        m[1][0] * a + m[1][1] * b + m[1][2] * c,
        m[2][0] * a + m[2][1] * b + m[2][2] * c,
    ]
}

/// The inverse, by the adjugate; `None` if its numbers overflow or vanish.
const fn inverse(m: &Matrix) -> Option<Matrix> {
    let mut adjugate = [[0.0; 3]; 3];
    let mut i = 0;
    while i < 3 {
        let mut j = 0;
        while j < 3 {
            let ([p, q], [s, t]) = ([(j + 1) % 3, (j + 2) % 3], [(i + 1) % 3, (i + 2) % 3]);
            adjugate[i][j] = m[p][s] * m[q][t] - m[p][t] * m[q][s];
            j += 1;
        }
        i += 1;
    }
    let determinant = m[0][0] * adjugate[0][0] + m[0][1] * adjugate[1][0] + m[0][2] * adjugate[2][0];
    if !determinant.is_normal() {
        return None;
    }
    let mut i = 0;
    while i < 9 {
        adjugate[i / 3][i % 3] /= determinant;
        i += 1;
    }
    Some(adjugate)
}

/// A light that a screen cannot show, and by how much.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutOfGamut {
    /// What it would need of red, green and blue, where 0…1 can be had.
    pub rgb: [f64; 3],
}

impl OutOfGamut {
    /// How far each channel is outside 0…1: negative below 0, positive above 1, 0 inside.
    #[must_use]
    pub fn excess(&self) -> [f64; 3] {
        self.rgb.map(|value| value - value.clamp(0.0, 1.0))
    }
}

impl fmt::Display for OutOfGamut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut separator = "";
        for ((name, value), excess) in CHANNELS.iter().zip(self.rgb).zip(self.excess()) {
            // A NaN is neither inside nor outside, but it must be named.
            if excess == 0.0 {
                continue;
            }
            let (side, by) = if excess < 0.0 { ("below 0", -excess) } else { ("above 1", excess) };
            if by < 1e-4 {
                write!(f, "{separator}{name} would be {by:.1e} {side}")?;
            } else {
                write!(f, "{separator}{name} would be {value:.4}, {by:.4} {side}")?;
            }
            separator = ", ";
        }
        Ok(())
    }
}

impl std::error::Error for OutOfGamut {}

/// `rgb` itself if all of it is within 0…1, where 1e-9 beyond counts as the end.
///
/// # Errors
/// When it is not: what it would need, and so by how much it is outside.
pub fn in_gamut(rgb: [f64; 3]) -> Result<[f64; 3], OutOfGamut> {
    if rgb.iter().all(|value| (-ROUNDING..=1.0 + ROUNDING).contains(value)) {
        Ok(rgb.map(|value| value.clamp(0.0, 1.0)))
    } else {
        Err(OutOfGamut { rgb })
    }
}

/// CIE 1976 L\*a\*b\*.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lab {
    /// L\*, 0 black to 100 white.
    pub lightness: f64,
    /// a\*, green (negative) to red; about −90…100 within sRGB.
    pub a: f64,
    /// b\*, blue (negative) to yellow; about −110…95 within sRGB.
    pub b: f64,
}

/// CIE 1976 L\*u\*v\*.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Luv {
    /// L\*, 0 black to 100 white.
    pub lightness: f64,
    /// u\*, green (negative) to red; about −85…180 within sRGB.
    pub u: f64,
    /// v\*, blue (negative) to yellow; about −135…110 within sRGB.
    pub v: f64,
}

/// δ of CIE 15:2004: the cube root becomes a straight line below δ³ = (6/29)³.
pub const LAB_DELTA: f64 = 6.0 / 29.0;

/// f of CIE 15:2004 §8.2.1.1: t^⅓ above (6/29)³, t/(3·(6/29)²) + 4/29 below.
fn lab_root(t: f64) -> f64 {
    if t > LAB_DELTA * LAB_DELTA * LAB_DELTA { t.cbrt() } else { t / (3.0 * LAB_DELTA * LAB_DELTA) + 4.0 / 29.0 }
}

/// The inverse of [`lab_root`].
#[inline]
fn lab_cube(root: f64) -> f64 {
    if root > LAB_DELTA { root * root * root } else { (root - 4.0 / 29.0) * (3.0 * LAB_DELTA * LAB_DELTA) }
}

/// L\*a\*b\* of `xyz` where `white` is white: L\* = 116 f(Y/Yn) − 16, a\* = 500 (f(X/Xn) − f(Y/Yn)), b\* = 200 (f(Y/Yn) −
/// f(Z/Zn)). CIE 15:2004 §8.2.1.1. Every part of `white` is above 0.
#[must_use]
pub fn lab_from_xyz(xyz: [f64; 3], white: [f64; 3]) -> Lab {
    let [x, y, z] = [0, 1, 2].map(|i| lab_root(xyz[i] / white[i]));
    Lab { lightness: 116.0 * y - 16.0, a: 500.0 * (x - y), b: 200.0 * (y - z) }
}

/// f(X/Xn), f(Y/Yn) and f(Z/Zn) of [`lab_from_xyz`]: the cube roots that Lab is made of, straight lines in it.
#[must_use]
#[inline]
pub fn cube_roots(lab: Lab) -> [f64; 3] {
    let y = (lab.lightness + 16.0) / 116.0;
    [y + lab.a / 500.0, y, y - lab.b / 200.0]
}

/// The X, Y and Z that [`lab_from_xyz`] makes `lab` of. CIE 15:2004 appendix D.
#[must_use]
#[inline]
pub fn xyz_from_lab(lab: Lab, white: [f64; 3]) -> [f64; 3] {
    let roots = cube_roots(lab);
    [0, 1, 2].map(|i| lab_cube(roots[i]) * white[i])
}

/// u′ = 4X/(X+15Y+3Z) and v′ = 9Y/(X+15Y+3Z), or `None` for black. CIE 15:2004 §8.1.
fn uniform_chromaticity([x, y, z]: [f64; 3]) -> Option<(f64, f64)> {
    let total = x + 15.0 * y + 3.0 * z;
    (total != 0.0).then(|| (4.0 * x / total, 9.0 * y / total))
}

/// L\*u\*v\* of `xyz` where `white` is white: L\* as in Lab, u\* = 13 L\* (u′ − u′n), v\* = 13 L\* (v′ − v′n). CIE 15:2004
/// §8.2.2.1. Black has u\* = v\* = 0. The Y of `white` is above 0.
#[must_use]
pub fn luv_from_xyz(xyz: [f64; 3], white: [f64; 3]) -> Luv {
    let lightness = 116.0 * lab_root(xyz[1] / white[1]) - 16.0;
    match (uniform_chromaticity(xyz), uniform_chromaticity(white)) {
        (Some((u, v)), Some((white_u, white_v))) => {
            Luv { lightness, u: 13.0 * lightness * (u - white_u), v: 13.0 * lightness * (v - white_v) }
        }
        _ => Luv { lightness, u: 0.0, v: 0.0 },
    }
}

/// The X, Y and Z that [`luv_from_xyz`] makes `luv` of; black where L\* is 0.
#[must_use]
pub fn xyz_from_luv(luv: Luv, white: [f64; 3]) -> [f64; 3] {
    let Some((white_u, white_v)) = uniform_chromaticity(white).filter(|_| luv.lightness != 0.0) else {
        return [0.0; 3];
    };
    let (u, v) = (luv.u / (13.0 * luv.lightness) + white_u, luv.v / (13.0 * luv.lightness) + white_v);
    let y = lab_cube((luv.lightness + 16.0) / 116.0) * white[1];
    [y * 9.0 * u / (4.0 * v), y, y * (12.0 - 3.0 * u - 20.0 * v) / (4.0 * v)]
}
