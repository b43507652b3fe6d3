//! A display's calibration: readings with the chosen curve, and how far each is from it.

use super::{
    axes::{EDGE, MARKER, Panel, TEXT, Values},
    figure::Figure,
    palette::{AXIS, BLACK, BLUE, GREEN, GRID, Marker, Series, Stroke, VERMILION},
    svg::{Anchor, Font, Svg, WIDTH},
};
use crate::display::{
    Channel,
    photometer::{Calibration, FittedChannel},
};

/// Steps of a curve.
const STEPS: usize = 128;
/// Height of the upper panel and of the lower one.
const HEIGHTS: (f64, f64) = (400.0, 230.0);
/// Least reach of the lower panel, 8-bit codes.
const LEAST_CODES: f64 = 1.0;

/// `calibration`: readings, curves and residuals.
#[must_use]
pub fn calibration(calibration: &Calibration) -> Figure {
    let model = calibration.model(calibration.chosen);
    let caption = format!(
        "Above, luminance by encoded value: {} readings as markers, the chosen model ({}) as lines. Below, how far each \
         reading is from its line, in 8-bit codes.",
        calibration.readings.all().len(),
        calibration.chosen,
    );
    let light = Values::from_zero(calibration.readings.largest_cd_m2());
    let reach = residuals(calibration).map(|(_, _, codes)| codes.abs()).fold(LEAST_CODES, f64::max) * 1.1;
    let codes = Values::between(-reach, reach);
    let (left, right) = (light.margin().max(codes.margin()), WIDTH - EDGE - TEXT);
    let legend = EDGE + 0.6 * TEXT;
    let upper = light.panel(left, right, legend + TEXT, HEIGHTS.0);
    let lower = codes.panel(left, right, upper.bottom + TEXT, HEIGHTS.1);
    Figure::draw("calibration", "Light of the display".to_owned(), caption, lower.bottom + 2.9 * TEXT, |svg| {
        let room = (WIDTH - EDGE - left) / model.channels.len() as f64;
        for (index, FittedChannel { channel, .. }) in model.channels.iter().enumerate() {
            svg.legend_entry((left + index as f64 * room, legend), series(*channel), true, channel.name(), TEXT);
        }
        light.draw(svg, &upper, Some("Luminance (cd/m²)"));
        encoded_axis(svg, &upper, false);
        codes.draw(svg, &lower, Some("Off (codes)"));
        encoded_axis(svg, &lower, true);
        for FittedChannel { channel, curve, .. } in &model.channels {
            let levels = (0..=STEPS).map(|step| step as f64 / STEPS as f64);
            let points: Vec<_> = levels.map(|v| (upper.x(v), upper.y(curve.cd_m2(v)))).collect();
            svg.line(&points, Stroke { width: 2.4, ..series(*channel).line() });
        }
        for one in calibration.readings.all() {
            svg.marker((upper.x(one.level), upper.y(one.luminance_cd_m2)), 0.7 * MARKER, series(one.channel));
        }
        for (channel, level, codes) in residuals(calibration) {
            svg.marker((lower.x(level), lower.y(codes)), 0.7 * MARKER, series(channel));
        }
    })
}

/// Channel, level and distance from the curve in 8-bit codes of every reading.
fn residuals(calibration: &Calibration) -> impl Iterator<Item = (Channel, f64, f64)> + '_ {
    let model = calibration.model(calibration.chosen);
    calibration.readings.all().iter().filter_map(move |one| {
        let fitted = model.channels.iter().find(|fitted| fitted.channel == one.channel)?;
        Some((one.channel, one.level, 255.0 * (fitted.curve.encoded(one.luminance_cd_m2) - one.level)))
    })
}

/// The palette's colors nearest to the channels, and a marker and a dash for each.
fn series(channel: Channel) -> Series {
    let (color, marker, dash) = match channel {
        Channel::Red => (VERMILION, Marker::Square, Some((18.0, 8.0))),
        Channel::Green => (GREEN, Marker::Triangle, Some((8.0, 6.0))),
        Channel::Blue => (BLUE, Marker::Diamond, Some((30.0, 7.0))),
        Channel::Gray => (BLACK, Marker::Circle, None),
    };
    Series { color, marker, dash }
}

/// The axis of encoded values, with lines across the panel.
fn encoded_axis(svg: &mut Svg, panel: &Panel, named: bool) {
    svg.line(&[(panel.left, panel.bottom), (panel.right, panel.bottom)], AXIS);
    for level in [0.0, 0.25, 0.5, 0.75, 1.0] {
        let x = panel.x(level);
        svg.line(&[(x, panel.top), (x, panel.bottom)], GRID);
        if named {
            svg.text(&level.to_string(), (x, panel.bottom + 0.8 * TEXT), Font::new(TEXT, Anchor::Middle));
        }
    }
    if named {
        svg.text("Encoded value", (panel.x(0.5), panel.bottom + 2.1 * TEXT), Font::new(TEXT, Anchor::Middle));
    }
    svg.line(&[(panel.left, panel.y(0.0)), (panel.right, panel.y(0.0))], Stroke { width: 1.4, ..AXIS });
}
