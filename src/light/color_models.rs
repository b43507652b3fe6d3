//! Other ways to write an RGB: HSV, HLS, CMY and CMYK. Shoaff §2.2.5–2.2.7.
//!
//! All take RGB as it comes, each 0…1, and know nothing of a screen: the RGB may be linear in light, as everywhere in this
//! crate, or encoded, as in most paint programs, and the HSV of one is not the HSV of the other.
//!
//! A gray has no hue. Here that is `None`, Shoaff's UNDEFINED; it is not 0, which is red.

/// Hue, saturation and value: a six-sided pyramid, black its tip. Shoaff §2.2.6.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hsv {
    /// Angle around the axis in degrees, 0…360 (not 360): red 0, green 120, blue 240. `None` for grays.
    pub hue: Option<f64>,
    /// Distance from the axis, 0 gray to 1.
    pub saturation: f64,
    /// The largest of red, green and blue, 0…1.
    pub value: f64,
}

/// Hue, lightness and saturation: two six-sided pyramids base to base, black and white their tips. Shoaff §2.2.7.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hls {
    /// As in [`Hsv`].
    pub hue: Option<f64>,
    /// Mean of the largest and the smallest of red, green and blue, 0…1.
    pub lightness: f64,
    /// Distance from the axis, 0 gray to 1.
    pub saturation: f64,
}

/// Inks of a print with black, each 0…1. Shoaff §2.2.5.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cmyk {
    /// Cyan beyond black.
    pub cyan: f64,
    /// Magenta beyond black.
    pub magenta: f64,
    /// Yellow beyond black.
    pub yellow: f64,
    /// Black: the smallest of the three without it.
    pub black: f64,
}

/// The largest and the smallest of three.
fn extremes([r, g, b]: [f64; 3]) -> (f64, f64) {
    (r.max(g).max(b), r.min(g).min(b))
}

/// The angle of [`Hsv::hue`], in degrees: which channel leads, and by how much the second is ahead of the third. Shoaff
/// §2.2.6.
fn hue([r, g, b]: [f64; 3]) -> Option<f64> {
    let (max, min) = extremes([r, g, b]);
    let delta = max - min;
    if delta <= 0.0 || delta.is_nan() {
        return None;
    }
    let sixth = if r == max {
        (g - b) / delta
    } else if g == max {
        2.0 + (b - r) / delta
    } else {
        4.0 + (r - g) / delta
    };
    Some(wrapped_deg(60.0 * sixth))
}

/// The angle `degrees` in 0…360, 360 itself being 0.
#[must_use]
pub fn wrapped_deg(degrees: f64) -> f64 {
    let wrapped = degrees.rem_euclid(360.0);
    // A hair below 0 wraps to 360. Adding 0 takes the sign off −0.
    if wrapped >= 360.0 { 0.0 } else { wrapped + 0.0 }
}

/// V = max, S = (max − min)/max, H by the leading channel. Shoaff §2.2.6. Black has S = 0.
#[must_use]
pub fn hsv_from_rgb(rgb: [f64; 3]) -> Hsv {
    let (max, min) = extremes(rgb);
    let saturation = if max > 0.0 { (max - min) / max } else { 0.0 };
    Hsv { hue: hue(rgb).filter(|_| saturation > 0.0), saturation, value: max }
}

/// The inverse of [`hsv_from_rgb`], Foley, van Dam, Feiner and Hughes 1990, fig. 13.34. A missing hue is a gray, whatever
/// the saturation; any angle is a hue.
#[must_use]
#[inline]
pub fn rgb_from_hsv(hsv: Hsv) -> [f64; 3] {
    let Some(hue) = hsv.hue else { return [hsv.value; 3] };
    let sixth = wrapped_deg(hue) / 60.0;
    let (sector, part) = (sixth.floor(), sixth - sixth.floor());
    let max = hsv.value;
    let min = max * (1.0 - hsv.saturation);
    let falling = max * (1.0 - hsv.saturation * part);
    let rising = max * (1.0 - hsv.saturation * (1.0 - part));
    arranged(sector, max, min, rising, falling)
}

/// The values of red, green and blue in a sector of the hexagon, 0…5.
#[inline]
fn arranged(sector: f64, max: f64, min: f64, rising: f64, falling: f64) -> [f64; 3] {
    // A whole number below 6.
    match sector as u8 {
        0 => [max, rising, min],
        1 => [falling, max, min],
        2 => [min, max, rising],
        3 => [min, falling, max],
        4 => [rising, min, max],
        _ => [max, min, falling],
    }
}

/// L = (max + min)/2, S = (max − min)/(max + min) in the lower half and (max − min)/(2 − max − min) in the upper. Shoaff
/// §2.2.7, repaired: the code printed there divides by (2 − max + min), which leaves saturated colors in the upper half
/// short of S = 1.
#[must_use]
pub fn hls_from_rgb(rgb: [f64; 3]) -> Hls {
    let (max, min) = extremes(rgb);
    let lightness = 0.5 * (max + min);
    let range = if lightness < 0.5 { max + min } else { 2.0 - max - min };
    let saturation = if max > min && range > 0.0 { ((max - min) / range).min(1.0) } else { 0.0 };
    Hls { hue: hue(rgb).filter(|_| saturation > 0.0), lightness, saturation }
}

/// The inverse of [`hls_from_rgb`], Foley, van Dam, Feiner and Hughes 1990, fig. 13.37. A missing hue is a gray, whatever
/// the saturation; any angle is a hue.
#[must_use]
pub fn rgb_from_hls(hls: Hls) -> [f64; 3] {
    let Some(hue) = hls.hue else { return [hls.lightness; 3] };
    let sixth = wrapped_deg(hue) / 60.0;
    let (sector, part) = (sixth.floor(), sixth - sixth.floor());
    // Half the height of the color over the axis.
    let half = hls.saturation * hls.lightness.min(1.0 - hls.lightness);
    let (max, min) = (hls.lightness + half, hls.lightness - half);
    arranged(sector, max, min, min + (max - min) * part, max - (max - min) * part)
}

/// Cyan, magenta and yellow, 1 − RGB: inks that each take away one of the three. Ideal; real inks need more. Shoaff
/// §2.2.5.
#[must_use]
pub fn cmy_from_rgb(rgb: [f64; 3]) -> [f64; 3] {
    rgb.map(|value| 1.0 - value)
}

/// Red, green and blue, 1 − CMY. Shoaff §2.2.5.
#[must_use]
pub fn rgb_from_cmy(cmy: [f64; 3]) -> [f64; 3] {
    cmy.map(|value| 1.0 - value)
}

/// K = min(C, M, Y), taken off each of the three. Shoaff §2.2.5.
#[must_use]
pub fn cmyk_from_cmy(cmy: [f64; 3]) -> Cmyk {
    let (_, black) = extremes(cmy);
    let [cyan, magenta, yellow] = cmy.map(|value| value - black);
    Cmyk { cyan, magenta, yellow, black }
}

/// The inverse of [`cmyk_from_cmy`]: black put back on each of the three. Shoaff §2.2.5.
#[must_use]
pub fn cmy_from_cmyk(cmyk: Cmyk) -> [f64; 3] {
    [cmyk.cyan, cmyk.magenta, cmyk.yellow].map(|value| value + cmyk.black)
}
