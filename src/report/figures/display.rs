//! Charts of a display, its calibration readings with the chosen curves and its frame intervals; the tables of its
//! calibration; and a coarse picture of a stimulus.

use super::{
    axes::{EDGE, Levels, MARKER, Values, chart},
    palette::{BLACK, BLUE, GREEN, Marker, Rgb, Series, Stroke, VERMILION},
    svg::{Figure, WIDTH},
};
use crate::{
    display::{
        Channel,
        frames::Refresh,
        photometer::{Calibration, Family, FittedChannel},
    },
    experiment::{Factor, Protocol},
    light::{Bits, Quantizer, Transfer},
    report::{
        document::{Shown, TableOf, TextTable, fixed, list},
        names,
    },
};

/// Number of line segments in a curve.
const STEPS: usize = 128;

/// Draws `calibration`: readings, and the curves of the chosen model.
pub fn calibration(calibration: &Calibration) -> Figure {
    let (family, model) = (calibration.chosen, calibration.model(calibration.chosen));
    let caption = format!(
        "Luminance by encoded value, with {} readings as markers and the chosen model ({family}) as lines.",
        calibration.readings.all().len(),
    );
    let channels = model.channels.iter().map(|own| (series(own.channel), own.channel.name()));
    let channels: Vec<_> = channels.collect();
    let texts = ["Light of the display".to_owned(), caption];
    let values = (Values::from_zero(calibration.readings.largest_cd_m2()), "Luminance (cd/m²)");
    let levels = (&Levels::numbers(0.0, 1.0), "Encoded value");
    chart("calibration", texts, values, levels, ("", &channels, true), |svg, panel| {
        for FittedChannel { channel, curve, .. } in &model.channels {
            let levels = (0..=STEPS).map(|step| step as f64 / STEPS as f64);
            let points: Vec<_> = levels.map(|v| (panel.x(v), panel.y(curve.cd_m2(v)))).collect();
            svg.line(&points, Stroke { width: 2.4, ..series(*channel).line() });
        }
        for one in calibration.readings.all() {
            svg.marker((panel.x(one.level), panel.y(one.luminance_cd_m2)), 0.7 * MARKER, series(one.channel));
        }
    })
}

/// Returns the fitted models, channel by channel, and how well each predicts levels that were left out.
pub fn calibration_tables(calibration: &Calibration) -> [TextTable; 2] {
    let models = &calibration.models;
    let channels = models.iter().flat_map(|model| model.channels.iter().map(|channel| (model.family, channel)));
    let channels: Vec<(Family, &FittedChannel)> = channels.collect();
    let fits = TableOf::new("Fitted models", &channels)
        .text("model", |(family, _)| family.name())
        .text("channel", |(_, own)| own.channel.name())
        .number("gamma", |(_, own)| {
            let (gamma, se) = (fixed(own.curve.gamma(), 4), own.curve.gamma_se);
            let se = se.map_or_else(String::new, |se| format!(" ± {se:.4}"));
            Shown::new(gamma.value().clone(), format!("{gamma}{se}"))
        })
        .number("gain", |(_, own)| fixed(own.curve.gain_and_offset().map(|both| both.0), 4))
        .number("offset", |(_, own)| fixed(own.curve.gain_and_offset().map(|both| both.1), 4))
        .number("R²", |(_, own)| fixed(own.r_squared, 6))
        .number("largest codes", |(_, own)| fixed(own.largest_codes, 2));
    let validation = TableOf::new("Leave-one-level-out error", models)
        .text("model", |model| model.family.name())
        .number("rms codes", |model| fixed(model.rms_codes, 2));
    [fits.into(), validation.into()]
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
    let last = intervals_us.len().max(2) as f64;
    let line = refresh
        .map_or_else(String::new, |refresh| format!("; the line marks the refresh interval at {:.3} Hz", refresh.hz()));
    let texts = ["Frame intervals".to_owned(), format!("Frames 1 to {}{line}.", intervals_us.len())];
    let values = (Values::from_zero((f64::from(longest) * 1e-3).max(refresh_ms.unwrap_or(0.0))), "Interval (ms)");
    let levels = (&Levels::numbers(1.0, last), "Frame");
    chart("intervals", texts, values, levels, Default::default(), |svg, panel| {
        if let Some(ms) = refresh_ms {
            svg.line(&[(panel.left, panel.y(ms)), (panel.right, panel.y(ms))], Stroke::new(VERMILION, 2.0));
        }
        for (frame, us) in intervals_us.iter().enumerate() {
            svg.circle((panel.x(frame as f64 / (last - 1.0)), panel.y(f64::from(*us) * 1e-3)), 1.6, BLUE);
        }
    })
}

/// Squares across and down.
const SQUARES: u32 = 64;
/// Side of a square.
const SIDE: f64 = 6.0;

/// Draws `stimulus`: that of the first condition of a definition, unless it is a file of the study that was not read.
pub fn stimulus(protocol: &Protocol) -> Option<Figure> {
    let condition = protocol.conditions().first().filter(|condition| condition.stimulus.is_drawable())?;
    let known = Some(protocol.stimulus.parameters());
    let level = |(factor, level): (&Factor, &usize)| {
        let level = names::level(known, &factor.name, &factor.levels[*level].to_string());
        format!("{} {level}", names::factor(known, &factor.name))
    };
    let levels: Vec<String> = protocol.factors.iter().zip(&condition.levels).map(level).collect();
    let which = if levels.is_empty() { String::new() } else { format!(" at {}", list(&levels)) };
    let caption = format!("The stimulus of the first condition{which}, in {SQUARES} × {SQUARES} squares.");
    let codes = condition.stimulus.codes(SQUARES, &Quantizer::new(&Transfer::Srgb.into(), Bits::Eight));
    let color = |[r, g, b]: [u16; 3]| Rgb(r as u8, g as u8, b as u8);
    let left = ((WIDTH - f64::from(SQUARES) * SIDE) / 2.0).round();
    let height = f64::from(SQUARES) * SIDE + 2.0 * EDGE;
    Some(Figure::draw("stimulus", ["A stimulus".to_owned(), caption], height, |svg| {
        for x in 0..SQUARES {
            let column: Vec<Rgb> = (0..SQUARES).map(|y| color(codes.pixel(x, y))).collect();
            let (from, mut top) = (left + f64::from(x) * SIDE, EDGE);
            // Squares of one color are one rectangle.
            for run in column.chunk_by(|a, b| a == b) {
                let bottom = top + run.len() as f64 * SIDE;
                svg.rectangle((from, top), (from + SIDE, bottom), run[0]);
                top = bottom;
            }
        }
    }))
}
