//! A display's calibration: readings with the chosen curve, and how far each is from it.

use plotters::style::{RGBColor, text_anchor::HPos};

use super::{
    Figure,
    axes::{EDGE, Panel, Values},
    palette::{AXIS, GRID, Look, MARKER, Marker, TEXT},
    svg::{Canvas, Drawn, Setting, Stroke, WIDTH, drawing},
};
use crate::display::photometer::{Calibration, Channel, FittedChannel};

/// Steps of a curve.
const STEPS: usize = 128;
/// Height of the upper panel and of the lower one.
const HEIGHTS: (f64, f64) = (400.0, 230.0);
/// Least reach of the lower panel, 8-bit codes.
const LEAST_CODES: f64 = 1.0;

/// `calibration`: readings, curves and residuals.
#[must_use]
pub fn calibration(calibration: &Calibration) -> Option<Figure> {
    let model = calibration.model(calibration.chosen);
    let title = "Light of the display".to_owned();
    let caption = format!(
        "Above, luminance by encoded value: {} readings as markers, the chosen model ({}) as lines. Below, how far each \
         reading is from its line, in 8-bit codes.",
        calibration.readings.all().len(),
        calibration.chosen,
    );
    let light = Values::from_zero(calibration.readings.largest_cd_m2());
    let reach = residuals(calibration).map(|(_, _, codes)| codes.abs()).fold(LEAST_CODES, f64::max) * 1.1;
    let codes = Values::between(-reach, reach);
    let left = light.margin().max(codes.margin());
    let legend = EDGE + 0.6 * TEXT;
    let top = legend + TEXT;
    let panel = |top: f64, height: f64, values: &Values| Panel {
        left,
        right: WIDTH - EDGE - TEXT,
        top,
        bottom: top + height,
        low: values.low,
        high: values.high,
    };
    let upper = panel(top, HEIGHTS.0, &light);
    let lower = panel(upper.bottom + TEXT, HEIGHTS.1, &codes);
    let svg = drawing(lower.bottom + 2.9 * TEXT, &title, &caption, |canvas| {
        names(canvas, left, legend, &model.channels)?;
        light.draw(canvas, &upper, Some("Luminance (cd/m²)"))?;
        across(canvas, &upper, false)?;
        codes.draw(canvas, &lower, Some("Off (codes)"))?;
        across(canvas, &lower, true)?;
        for channel in &model.channels {
            curve(canvas, &upper, channel)?;
        }
        for one in calibration.readings.all() {
            canvas.marker((upper.x(one.level), upper.y(one.luminance_cd_m2)), 0.7 * MARKER, look(one.channel))?;
        }
        residuals(calibration).try_for_each(|(channel, level, codes)| {
            canvas.marker((lower.x(level), lower.y(codes)), 0.7 * MARKER, look(channel))
        })
    })?;
    Some(Figure { name: "calibration", title, caption, wide: false, svg })
}

/// Channel, level and distance from the curve in 8-bit codes of every reading.
fn residuals(calibration: &Calibration) -> impl Iterator<Item = (Channel, f64, f64)> + '_ {
    let model = calibration.model(calibration.chosen);
    calibration.readings.all().iter().filter_map(move |one| {
        let fitted = model.channels.iter().find(|fitted| fitted.channel == one.channel)?;
        Some((one.channel, one.level, 255.0 * (fitted.response.encoded(one.luminance_cd_m2) - one.level)))
    })
}

/// Okabe & Ito's colours nearest to the channels, and a marker and a dash for each.
fn look(channel: Channel) -> Look {
    let (colour, marker, dash) = match channel {
        Channel::Red => (RGBColor(213, 94, 0), Marker::Square, Some((18.0, 8.0))),
        Channel::Green => (RGBColor(0, 158, 115), Marker::Triangle, Some((8.0, 6.0))),
        Channel::Blue => (RGBColor(0, 114, 178), Marker::Diamond, Some((30.0, 7.0))),
        Channel::Gray => (RGBColor(0, 0, 0), Marker::Circle, None),
    };
    Look { colour, marker, open: false, dash }
}

fn names(canvas: &Canvas<'_>, left: f64, y: f64, channels: &[FittedChannel]) -> Drawn {
    let room = (WIDTH - EDGE - left) / channels.len() as f64;
    for (index, channel) in channels.iter().enumerate() {
        let at = (left + index as f64 * room, y);
        canvas.legend_entry(at, look(channel.channel), true, channel.channel.name(), TEXT)?;
    }
    Ok(())
}

/// The axis of encoded values, with lines across the panel.
fn across(canvas: &Canvas<'_>, panel: &Panel, named: bool) -> Drawn {
    canvas.line(&[(panel.left, panel.bottom), (panel.right, panel.bottom)], AXIS)?;
    for quarter in 0..=4 {
        let level = f64::from(quarter) / 4.0;
        let x = panel.x(level);
        canvas.line(&[(x, panel.top), (x, panel.bottom)], GRID)?;
        if named {
            let name = format!("{level}");
            canvas.text(&name, (x, panel.bottom + 0.8 * TEXT), Setting::new(TEXT, HPos::Center))?;
        }
    }
    if named {
        let middle = (panel.x(0.5), panel.bottom + 2.1 * TEXT);
        canvas.text("Encoded value", middle, Setting::new(TEXT, HPos::Center))?;
    }
    let zero = panel.y(0.0);
    canvas.line(&[(panel.left, zero), (panel.right, zero)], Stroke { width: 1.4, ..AXIS })
}

fn curve(canvas: &Canvas<'_>, panel: &Panel, channel: &FittedChannel) -> Drawn {
    let point = |step: usize| {
        let v = step as f64 / STEPS as f64;
        (panel.x(v), panel.y(channel.response.cd_m2(v)))
    };
    let points: Vec<(f64, f64)> = (0..=STEPS).map(point).collect();
    canvas.line(&points, Stroke { width: 2.4, ..look(channel.channel).stroke() })
}
