//! Conversions between visual angle, centimeters and physical pixels; a monitor, as the window system describes it.
//!
//! A size is centered on the line of sight and perpendicular to it, so that size = 2·distance·tan(angle/2). Pixels are
//! the display's physical pixels, not the scaled pixels of the window system, and are square.

use serde::{Deserialize, Serialize};

/// The width in centimeters of an identity card or bank card (ISO/IEC 7810 ID-1), which most people have at hand to
/// measure a screen.
pub const CARD_WIDTH_CM: f64 = 8.56;

/// Plausible numbers of pixels along a side of a screen.
const SIDE_PX: std::ops::RangeInclusive<f64> = 16.0..=65_536.0;
/// Plausible widths of a screen, from a phone held sideways to a projection on a wall.
const WIDTH_CM: std::ops::RangeInclusive<f64> = 5.0..=500.0;
/// Plausible viewing distances, from the eye's near point to the length of a large room.
const DISTANCE_CM: std::ops::RangeInclusive<f64> = 10.0..=2000.0;
/// Fewest pixels per degree, and pixels along the side of a stimulus, that show a ramp rather than steps.
const MIN_PX_PER_DEGREE: f64 = 10.0;
const MIN_STIMULUS_PX: f64 = 64.0;

/// Writes a number without hundreds of digits.
fn short(value: f64) -> String {
    if value == 0.0 || (1e-4..1e7).contains(&value.abs()) { value.to_string() } else { format!("{value:.1e}") }
}

fn check(
    quantity: &str,
    value: f64,
    range: &std::ops::RangeInclusive<f64>,
    unit: &str,
    expected: &str,
) -> Result<f64, String> {
    if range.contains(&value) {
        return Ok(value);
    }
    let (value, lowest, highest) = (short(value), range.start(), range.end());
    Err(format!("{quantity} {value} is outside {lowest}…{highest} {unit}; expected {expected}"))
}

/// A screen: its physical pixels, which are square, and the width of its lit part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Screen {
    /// Physical pixels per row.
    pub(crate) width_px: u32,
    /// Rows of physical pixels.
    pub(crate) height_px: u32,
    /// Width of the lit part in centimeters.
    pub(crate) width_cm: f64,
}

impl Screen {
    /// Makes a screen of `width_px` × `height_px` physical pixels whose lit part, without the frame, is `width_cm`
    /// wide.
    ///
    /// # Errors
    /// Returns an error if a side is not within 16…65536 pixels or the width is not within 5…500 cm.
    pub fn new(width_px: u32, height_px: u32, width_cm: f64) -> Result<Screen, String> {
        for (quantity, side) in [("screen width", width_px), ("screen height", height_px)] {
            check(quantity, side.into(), &SIDE_PX, "pixels", "the screen's physical pixels")?;
        }
        let expected = "the width of the lit part of the screen";
        let width_cm = check("screen width", width_cm, &WIDTH_CM, "cm", expected)?;
        Ok(Screen { width_px, height_px, width_cm })
    }

    /// Physical pixels per centimeter, the same in both directions.
    pub fn px_per_cm(&self) -> f64 {
        f64::from(self.width_px) / self.width_cm
    }
}

/// A screen viewed from a distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewing {
    screen: Screen,
    /// Distance from the eye to the screen in centimeters.
    pub(crate) distance_cm: f64,
}

impl Viewing {
    /// Creates a view of `screen` from a distance of `distance_cm` centimeters.
    ///
    /// # Errors
    /// Returns an error if the distance is not within 10…2000 cm.
    pub fn new(screen: Screen, distance_cm: f64) -> Result<Viewing, String> {
        let expected = "the distance from the eye to the screen";
        Ok(Viewing { screen, distance_cm: check("distance", distance_cm, &DISTANCE_CM, "cm", expected)? })
    }

    pub fn screen(&self) -> Screen {
        self.screen
    }

    /// Returns the size in centimeters on the screen, centered on the line of sight, that subtends `deg` degrees (0 ≤
    /// `deg` < 180).
    pub fn cm_from_deg(&self, deg: f64) -> f64 {
        2.0 * self.distance_cm * (deg.to_radians() / 2.0).tan()
    }

    /// Returns the size in physical pixels, centered on the line of sight, that subtends `deg` degrees (0 ≤ `deg` <
    /// 180). The result is not rounded.
    pub fn px_from_deg(&self, deg: f64) -> f64 {
        self.cm_from_deg(deg) * self.screen.px_per_cm()
    }

    /// Returns the angle in degrees that `px` physical pixels, centered on the line of sight, subtend.
    pub fn deg_from_px(&self, px: f64) -> f64 {
        2.0 * (px / self.screen.px_per_cm() / (2.0 * self.distance_cm)).atan().to_degrees()
    }

    /// Returns the physical pixels per degree where the line of sight meets the screen: the limit for small angles.
    pub fn px_per_degree(&self) -> f64 {
        1f64.to_radians() * self.distance_cm * self.screen.px_per_cm()
    }

    /// Says why a stimulus of `deg` degrees cannot show a smooth ramp on this screen: it has too few pixels. `None` if
    /// it has enough.
    pub fn coarseness(&self, deg: f64) -> Option<String> {
        let (side, per_degree) = (self.px_from_deg(deg).round(), self.px_per_degree());
        let is_coarse = side < MIN_STIMULUS_PX || per_degree < MIN_PX_PER_DEGREE;
        is_coarse.then(|| {
            format!(
                "The stimulus has only {side} × {side} pixels, {per_degree:.1} a degree, too few for a smooth ramp; at least \
                    {MIN_STIMULUS_PX} and {MIN_PX_PER_DEGREE} are needed. Sit farther away, or plan a larger stimulus."
            )
        })
    }
}

/// Returns the width in centimeters of a screen that is `screen_width_px` physical pixels wide and on which a card of
/// [`CARD_WIDTH_CM`] covers `card_px` physical pixels.
///
/// # Errors
/// Returns an error if the card covers less than one pixel or more pixels than the screen has, or if the resulting
/// width is implausible for a screen.
pub fn width_cm_from_card(card_px: f64, screen_width_px: u32) -> Result<f64, String> {
    let screen_px = f64::from(screen_width_px);
    let expected = "the width of the card's outline on the screen";
    check("card width", card_px, &(1.0..=screen_px), "pixels", expected)?;
    let width = CARD_WIDTH_CM * screen_px / card_px;
    check("screen width", width, &WIDTH_CM, "cm", "an outline as wide as the card")
}

/// What is known about a monitor.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Monitor {
    /// The system's name for the monitor.
    pub name: Option<String>,
    /// Width in physical pixels.
    pub width_px: u32,
    /// Height in physical pixels.
    pub height_px: u32,
    /// Refresh rate in hertz, if the system reports it.
    pub refresh_hz: Option<f64>,
    /// Physical pixels per logical point of the system.
    pub scale: f64,
}

impl Monitor {
    /// Returns the name and size, for a list to choose from.
    pub fn title(&self) -> String {
        let size = format!("{} × {} pixels", self.width_px, self.height_px);
        match &self.name {
            Some(name) => format!("{name}, {size}"),
            None => size,
        }
    }

    /// Says what [`Monitor::assumed_width_cm`] assumes.
    pub fn assumption(&self) -> String {
        let per_inch = (96.0 * self.scale).round();
        let scaled =
            if self.scale == 1.0 { String::new() } else { format!(", from the system's scale of {}", self.scale) };
        format!("Assumed ({per_inch} pixels per inch{scaled}); measure it before a study")
    }

    /// Returns the width in cm with the pixels per inch that systems assume for unknown screens.
    pub fn assumed_width_cm(&self) -> f64 {
        f64::from(self.width_px) / self.scale.max(0.1) / 96.0 * 2.54
    }
}
