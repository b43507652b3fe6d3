//! Charts of a display: its calibration readings with the chosen curves, and its frame intervals.

use super::{
    axes::{EDGE, MARKER, PANEL, Panel, TEXT, Values, below, number_axis},
    figure::Figure,
    palette::{AXIS, BLACK, BLUE, GREEN, Marker, Series, Stroke, VERMILION},
    svg::WIDTH,
};
use crate::display::{
    Channel,
    frames::Refresh,
    photometer::{Calibration, Family, FittedChannel, FittedModel},
};

/// Number of line segments in a curve.
const STEPS: usize = 128;
/// Heights of the upper and the lower panel.
const HEIGHTS: (f64, f64) = (400.0, 230.0);
/// Minimum range of the lower panel, in 8-bit codes.
const MIN_CODES: f64 = 1.0;

/// Draws `calibration`: readings, and the curves and residuals of a model.
pub fn calibration(calibration: &Calibration, family: Family) -> Figure {
    let model = calibration.model(family);
    let caption = format!(
        "Top: luminance by encoded value, with {} readings as markers and the chosen model ({family}) as lines. Bottom: the \
         distance of each reading from its line, in 8-bit codes.",
        calibration.readings.all().len(),
    );
    let light = Values::from_zero(calibration.readings.largest_cd_m2());
    let reach = residuals(calibration, model).map(|(_, _, codes)| codes.abs()).fold(MIN_CODES, f64::max) * 1.1;
    let codes = Values::between(-reach, reach);
    let (left, right) = (light.margin().max(codes.margin()), WIDTH - EDGE - TEXT);
    let legend = EDGE + 0.6 * TEXT;
    let upper = light.panel(left, right, legend + TEXT, HEIGHTS.0);
    let lower = codes.panel(left, right, upper.bottom + TEXT, HEIGHTS.1);
    Figure::draw("calibration", "Light of the display".to_owned(), caption, lower.bottom + below(TEXT), |svg| {
        let room = (WIDTH - EDGE - left) / model.channels.len() as f64;
        for (index, FittedChannel { channel, .. }) in model.channels.iter().enumerate() {
            svg.legend_entry((left + index as f64 * room, legend), series(*channel), true, channel.name(), TEXT);
        }
        number_axis(svg, &Panel { top: upper.top, ..lower }, (0.0, 1.0), "Encoded value");
        light.draw(svg, &upper, Some("Luminance (cd/m²)"));
        codes.draw(svg, &lower, Some("Residual (codes)"));
        for panel in [upper, lower] {
            svg.line(&[(panel.left, panel.y(0.0)), (panel.right, panel.y(0.0))], Stroke { width: 1.4, ..AXIS });
        }
        for FittedChannel { channel, curve, .. } in &model.channels {
            let levels = (0..=STEPS).map(|step| step as f64 / STEPS as f64);
            let points: Vec<_> = levels.map(|v| (upper.x(v), upper.y(curve.cd_m2(v)))).collect();
            svg.line(&points, Stroke { width: 2.4, ..series(*channel).line() });
        }
        for one in calibration.readings.all() {
            svg.marker((upper.x(one.level), upper.y(one.luminance_cd_m2)), 0.7 * MARKER, series(one.channel));
        }
        for (channel, level, codes) in residuals(calibration, model) {
            svg.marker((lower.x(level), lower.y(codes)), 0.7 * MARKER, series(channel));
        }
    })
}

/// Returns the channel and the level of every reading, and its distance from the curve in 8-bit codes.
fn residuals<'a>(
    calibration: &'a Calibration,
    model: &'a FittedModel,
) -> impl Iterator<Item = (Channel, f64, f64)> + 'a {
    calibration.readings.all().iter().filter_map(move |one| {
        let fitted = model.channels.iter().find(|fitted| fitted.channel == one.channel)?;
        Some((one.channel, one.level, 255.0 * (fitted.curve.encoded(one.luminance_cd_m2) - one.level)))
    })
}

/// Returns the palette color that is closest to a channel's, with a marker and a dash pattern.
fn series(channel: Channel) -> Series {
    let (color, marker, dash) = match channel {
        Channel::Red => (VERMILION, Marker::Square, Some((18.0, 8.0))),
        Channel::Green => (GREEN, Marker::Triangle, Some((8.0, 6.0))),
        Channel::Blue => (BLUE, Marker::Diamond, Some((30.0, 7.0))),
        Channel::Gray => (BLACK, Marker::Circle, None),
    };
    Series { color, marker, dash }
}

/// Draws `intervals`: every frame interval, and a line at the screen's refresh interval.
pub fn intervals(intervals_us: &[u32], refresh: Option<Refresh>) -> Figure {
    let longest = intervals_us.iter().copied().max().unwrap_or(0);
    let refresh_ms = refresh.map(|refresh| refresh.seconds() * 1e3);
    let values = Values::from_zero((f64::from(longest) * 1e-3).max(refresh_ms.unwrap_or(0.0)));
    let panel = values.panel(values.margin(), WIDTH - EDGE - TEXT, EDGE, PANEL);
    let last = intervals_us.len().max(2) as f64;
    let line = refresh
        .map_or_else(String::new, |refresh| format!("; the line marks the refresh interval at {:.3} Hz", refresh.hz()));
    let caption = format!("Frames 1 to {}{line}.", intervals_us.len());
    let height = panel.bottom + below(TEXT);
    Figure::draw("intervals", "Frame intervals".to_owned(), caption, height, |svg| {
        values.draw(svg, &panel, Some("Interval (ms)"));
        number_axis(svg, &panel, (1.0, last), "Frame");
        if let Some(ms) = refresh_ms {
            svg.line(&[(panel.left, panel.y(ms)), (panel.right, panel.y(ms))], Stroke::new(VERMILION, 2.0));
        }
        for (frame, us) in intervals_us.iter().enumerate() {
            svg.circle((panel.x(frame as f64 / (last - 1.0)), panel.y(f64::from(*us) * 1e-3)), 1.6, BLUE);
        }
    })
}
