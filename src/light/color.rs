//! Color spaces and color models: CIE XYZ, xyY, CIELAB and CIELUV (Shoaff §2.2.3 and §2.2.4), and the models that only
//! rearrange red, green and blue: HSV, HLS, CMY and CMYK (Shoaff §2.2.5–2.2.7).
//!
//! The name of each function states the direction of the conversion. For the CIE spaces, RGB is linear in light, 0…1
//! per channel, on a screen with the sRGB primaries; XYZ is relative to white, whose Y is 1. Lab and Luv are the CIE
//! 1976 spaces as defined in CIE 15:2004, with its exact constants. The other models take RGB as given: the HSV of
//! linear values is not the HSV of encoded values.
//!
//! Hues are angles in degrees: red is 0, green 120, blue 240. A gray has no hue; the models give it a hue of 0.

type Matrix = [[f64; 3]; 3];

/// M in XYZ = M·RGB; its columns are the XYZ of the primaries. Computed from the chromaticities in ITU-R BT.709-6 and
/// the white point (0.3127, 0.3290); IEC 61966-2-1 prints it rounded to four digits. Shoaff §2.2.4.
const XYZ_FROM_RGB: Matrix = [
    [0.412_390_799_265_959_3, 0.357_584_339_383_878, 0.180_480_788_401_834_3],
    [0.212_639_005_871_510_24, 0.715_168_678_767_756, 0.072_192_315_360_733_71],
    [0.019_330_818_715_591_82, 0.119_194_779_794_625_98, 0.950_532_152_249_660_6],
];

/// The inverse of [`XYZ_FROM_RGB`].
const RGB_FROM_XYZ: Matrix = [
    [3.240_969_941_904_522_6, -1.537_383_177_570_094, -0.498_610_760_293_003_44],
    [-0.969_243_636_280_879_5, 1.875_967_501_507_720_2, 0.041_555_057_407_175_6],
    [0.055_630_079_696_993_63, -0.203_976_958_888_976_5, 1.056_971_514_242_878_4],
];

/// X, Y and Z of the white point.
pub const WHITE: [f64; 3] = [0.950_455_927_051_671_7, 0.999_999_999_999_999_9, 1.089_057_750_759_878_4];

fn product(m: &Matrix, [a, b, c]: [f64; 3]) -> [f64; 3] {
    m.map(|row| row[0] * a + row[1] * b + row[2] * c)
}

/// Converts linear RGB to XYZ. Shoaff §2.2.4.
pub fn xyz_from_rgb(rgb: [f64; 3]) -> [f64; 3] {
    product(&XYZ_FROM_RGB, rgb)
}

/// Converts XYZ to linear RGB; the result is outside 0…1 if the screen cannot show the color. Shoaff §2.2.4.
pub fn rgb_from_xyz(xyz: [f64; 3]) -> [f64; 3] {
    product(&RGB_FROM_XYZ, xyz)
}

/// Converts xyY to XYZ: X = Y·x/y, Z = Y·(1 − x − y)/y. `y` must be above 0. Shoaff §2.2.3.
pub fn xyz_from_xyy([x, y, luminance]: [f64; 3]) -> [f64; 3] {
    let total = luminance / y;
    [x * total, luminance, (1.0 - x - y) * total]
}

/// δ of CIE 15:2004: the cube root becomes a straight line below δ³ = (6/29)³.
const LAB_DELTA: f64 = 6.0 / 29.0;

/// f of CIE 15:2004 §8.2.1.1: t^⅓ above (6/29)³, t/(3·(6/29)²) + 4/29 below.
fn lab_root(t: f64) -> f64 {
    if t > LAB_DELTA * LAB_DELTA * LAB_DELTA { t.cbrt() } else { t / (3.0 * LAB_DELTA * LAB_DELTA) + 4.0 / 29.0 }
}

/// The inverse of [`lab_root`].
#[inline]
fn lab_cube(root: f64) -> f64 {
    if root > LAB_DELTA { root * root * root } else { (root - 4.0 / 29.0) * (3.0 * LAB_DELTA * LAB_DELTA) }
}

/// L\* = 116 f(Y/Yn) − 16, a\* = 500 (f(X/Xn) − f(Y/Yn)) and b\* = 200 (f(Y/Yn) − f(Z/Zn)). CIE 15:2004 §8.2.1.1.
pub fn lab_from_xyz(xyz: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = [0, 1, 2].map(|i| lab_root(xyz[i] / WHITE[i]));
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// The inverse of [`lab_from_xyz`]. CIE 15:2004 appendix D.
#[inline]
pub fn xyz_from_lab([lightness, a, b]: [f64; 3]) -> [f64; 3] {
    let y = (lightness + 16.0) / 116.0;
    let roots = [y + a / 500.0, y, y - b / 200.0];
    [0, 1, 2].map(|i| lab_cube(roots[i]) * WHITE[i])
}

/// u′ = 4X/(X+15Y+3Z) and v′ = 9Y/(X+15Y+3Z). CIE 15:2004 §8.1.
fn uniform_chromaticity([x, y, z]: [f64; 3]) -> [f64; 2] {
    let total = x + 15.0 * y + 3.0 * z;
    [4.0 * x / total, 9.0 * y / total]
}

/// Returns XYZ from L\* as in Lab, u\* = 13 L\* (u′ − u′n) and v\* = 13 L\* (v′ − v′n). CIE 15:2004 §8.2.2.1 and appendix D.
/// An L\* of 0 gives black.
pub fn xyz_from_luv([lightness, u, v]: [f64; 3]) -> [f64; 3] {
    if lightness == 0.0 {
        return [0.0; 3];
    }
    let [white_u, white_v] = uniform_chromaticity(WHITE);
    let (u, v) = (u / (13.0 * lightness) + white_u, v / (13.0 * lightness) + white_v);
    let y = lab_cube((lightness + 16.0) / 116.0) * WHITE[1];
    [y * 9.0 * u / (4.0 * v), y, y * (12.0 - 3.0 * u - 20.0 * v) / (4.0 * v)]
}

/// Returns the largest and the smallest channel.
fn extremes([r, g, b]: [f64; 3]) -> (f64, f64) {
    (r.max(g).max(b), r.min(g).min(b))
}

/// Returns the hue in degrees, at least 0 and less than 360. It is determined by the largest channel and the difference
/// between the other two. Returns `None` for a gray (Shoaff's UNDEFINED). Shoaff §2.2.6.
pub fn hue(rgb: [f64; 3]) -> Option<f64> {
    let ([r, g, b], (max, min)) = (rgb, extremes(rgb));
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

/// Wraps the angle `degrees` into 0…360; 360 itself becomes 0.
pub fn wrapped_deg(degrees: f64) -> f64 {
    let wrapped = degrees.rem_euclid(360.0);
    // An angle just below 0 wraps to 360. Adding 0 turns −0 into 0.
    if wrapped >= 360.0 { 0.0 } else { wrapped + 0.0 }
}

/// Hue, saturation S = (max − min)/max and value V = max: a six-sided pyramid with black at its tip. Black has S = 0.
/// Shoaff §2.2.6.
pub fn hsv_from_rgb(rgb: [f64; 3]) -> [f64; 3] {
    let (max, min) = extremes(rgb);
    [hue(rgb).unwrap_or(0.0), if max > 0.0 { (max - min) / max } else { 0.0 }, max]
}

/// The inverse of [`hsv_from_rgb`] (Foley, van Dam, Feiner and Hughes 1990, fig. 13.34); accepts any angle as a hue.
#[inline]
pub fn rgb_from_hsv([hue, saturation, value]: [f64; 3]) -> [f64; 3] {
    let sixth = wrapped_deg(hue) / 60.0;
    let part = sixth - sixth.floor();
    let least = value * (1.0 - saturation);
    let falling = value * (1.0 - saturation * part);
    let rising = value * (1.0 - saturation * (1.0 - part));
    // A whole number below 6.
    match sixth as u8 {
        0 => [value, rising, least],
        1 => [falling, value, least],
        2 => [least, value, rising],
        3 => [least, falling, value],
        4 => [rising, least, value],
        _ => [value, least, falling],
    }
}

/// Hue, lightness and saturation: two six-sided pyramids base to base, with black and white at the tips. L = (max +
/// min)/2, S = (max − min)/(max + min) in the lower half and (max − min)/(2 − max − min) in the upper half. Shoaff
/// §2.2.7, corrected: the code printed there divides by (2 − max + min), so saturated colors in the upper half never
/// reach S = 1. Accepts any angle as a hue.
pub fn rgb_from_hls([hue, lightness, saturation]: [f64; 3]) -> [f64; 3] {
    // Half the difference between the largest and the smallest channel.
    let half = saturation * lightness.min(1.0 - lightness);
    let max = lightness + half;
    rgb_from_hsv([hue, if max > 0.0 { 2.0 * half / max } else { 0.0 }, max])
}

/// Cyan, magenta and yellow, 1 − RGB: ideal inks, each absorbing one of the three primaries. This function is its own
/// inverse. Shoaff §2.2.5.
pub fn cmy_from_rgb(rgb: [f64; 3]) -> [f64; 3] {
    rgb.map(|value| 1.0 - value)
}

/// Cyan, magenta, yellow and black: K = min(C, M, Y) was subtracted from each of the three inks, and is added back. Shoaff
/// §2.2.5.
pub fn rgb_from_cmyk([cyan, magenta, yellow, black]: [f64; 4]) -> [f64; 3] {
    cmy_from_rgb([cyan + black, magenta + black, yellow + black])
}

/// ȳ of the CIE 1931 observer from 380 to 780 nm in steps of 5 nm (CIE 15:2004, table T.4).
const LUMINOUS_EFFICIENCY: [f64; 81] = [
    3.9e-05, 6.4e-05, 0.00012, 0.000217, 0.000396, 0.00064, 0.00121, 0.00218, 0.004, 0.0073, 0.0116, 0.01684, 0.023,
    0.0298, 0.038, 0.048, 0.06, 0.0739, 0.09098, 0.1126, 0.13902, 0.1693, 0.20802, 0.2586, 0.323, 0.4073, 0.503,
    0.6082, 0.71, 0.7932, 0.862, 0.91485, 0.954, 0.9803, 0.99495, 1.0, 0.995, 0.9786, 0.952, 0.9154, 0.87, 0.8163,
    0.757, 0.6949, 0.631, 0.5668, 0.503, 0.4412, 0.381, 0.321, 0.265, 0.217, 0.175, 0.1382, 0.107, 0.0816, 0.061,
    0.04458, 0.032, 0.0232, 0.017, 0.01192, 0.00821, 0.005723, 0.004102, 0.002929, 0.002091, 0.001484, 0.001047,
    0.00074, 0.00052, 0.0003611, 0.0002492, 0.0001719, 0.00012, 8.48e-05, 6e-05, 4.24e-05, 3e-05, 2.12e-05, 1.499e-05,
];

/// Returns the luminance in cd/m² of a spectrum of radiance in W/(sr·m²) per band, whose first band is at `start_nm` and whose
/// bands are `step_nm` apart: 683 lm/W · Σ ȳ(λ)·P(λ).
pub fn luminance_of_spectrum(spectrum: &[f64], start_nm: f64, step_nm: f64) -> f64 {
    let efficiency = |nm: f64| {
        let place = (nm - 380.0) / 5.0;
        let (below, part) = (place.floor(), place.fract());
        let at = |index: f64| {
            if index < 0.0 { 0.0 } else { LUMINOUS_EFFICIENCY.get(index as usize).copied().unwrap_or(0.0) }
        };
        at(below) + part * (at(below + 1.0) - at(below))
    };
    let bands = (0_u32..).zip(spectrum).map(|(band, power)| power * efficiency(start_nm + f64::from(band) * step_nm));
    683.0 * bands.sum::<f64>()
}
