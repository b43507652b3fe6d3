//! A chart of the model's coefficients with their intervals.

use super::{
    axes::{EDGE, MARKER, Panel, below, ends, number_axis, told},
    figure::Figure,
    labels::{self, TEXT},
    palette::{AXIS, Series, Stroke},
    svg::{Anchor, Font, Point, Svg, WIDTH},
};
use crate::{
    analysis::{Coefficient, Model, Results},
    report::names,
    statistics::Interval,
};

/// Maximum number of coefficients in a chart.
const MAX_SHOWN: usize = 60;
/// Distance between rows.
const PITCH: f64 = 1.4 * TEXT;
/// Maximum width of a row's name.
const MAX_NAME: f64 = 300.0;

/// Draws `effects`, if there is a model with coefficients.
pub(super) fn figure(results: &Results) -> Option<Figure> {
    let model = &results.model.as_ref().ok()?.model;
    if model.coefficients.is_empty() {
        return None;
    }
    let (known, shown) = (results.options.parameters, model.coefficients.iter().take(MAX_SHOWN));
    let rows: Vec<(String, &Coefficient)> =
        shown.map(|own| (labels::fit(&names::coefficient(known, &own.parts), MAX_NAME), own)).collect();
    let (low, high) = range(model);
    let widest = rows.iter().map(|(name, _)| labels::width(name)).fold(120.0, f64::max);
    let left = EDGE + widest.min(MAX_NAME) + 14.0;
    let bottom = EDGE + PITCH * rows.len() as f64 + 8.0;
    let panel = Panel { left, right: WIDTH - EDGE - 8.0, top: EDGE, bottom, low: 0.0, high: 1.0 };
    let share = |value: f64| (value - low) / (high - low);
    let title = format!("Effects in the {} model", model.link);
    Some(Figure::draw("effects", title, caption(model), bottom + below(TEXT), |svg| {
        number_axis(svg, &panel, (low, high), &format!("Shift of the ratings ({} units)", model.link));
        let zero = panel.x(share(0.0));
        svg.line(&[(zero, panel.top), (zero, bottom)], Stroke { dash: Some((9.0, 6.0)), ..AXIS });
        for (index, (name, coefficient)) in rows.iter().enumerate() {
            let y = panel.top + PITCH * (index as f64 + 0.5);
            svg.text(name, (left - 14.0, y), Font::new(Anchor::End));
            effect(svg, &panel, coefficient, share, y, name);
        }
    }))
}

fn caption(model: &Model) -> String {
    let mut text = format!(
        "Coefficients of the cumulative-link {}model ({} link), with 95\u{a0}% profile-likelihood intervals. Positive \
         values mean higher ratings than at the factor’s baseline, the level without a coefficient, or with a larger number; {}.",
        if model.random.is_some() { "mixed " } else { "" },
        model.link,
        labels::fitted(model)
    );
    if model.coefficients.iter().any(|coefficient| !coefficient.estimate.is_finite()) {
        text += " An arrow without a marker means that there is no finite estimate.";
    }
    let all = model.coefficients.len();
    if all > MAX_SHOWN {
        text += &format!(" Only the first {MAX_SHOWN} of {all} coefficients are shown.");
    }
    text
}

/// Returns the interval of a coefficient or, if there is none, only the estimate.
fn interval(&Coefficient { estimate, interval, .. }: &Coefficient) -> Interval {
    interval.unwrap_or(Interval { low: estimate, high: estimate })
}

/// Returns the range of the axis: all intervals, except a few extreme ones that would leave no room for the others.
fn range(model: &Model) -> (f64, f64) {
    let finite = || model.coefficients.iter().take(MAX_SHOWN).filter(|c| c.estimate.is_finite());
    let limit = 3.0 * finite().map(|c| c.estimate.abs()).fold(1.0, f64::max);
    let bounds = finite().map(interval).flat_map(|interval| [interval.low, interval.high]);
    let (low, high) = ends(bounds.map(|end| end.clamp(-limit, limit)).chain([0.0])).unwrap_or((-1.0, 1.0));
    let pad = (0.06 * (high - low)).max(0.1);
    (low - pad, high + pad)
}

/// Draws an estimate with its interval, and an arrow where they extend beyond the panel.
fn effect(svg: &mut Svg, panel: &Panel, coefficient: &Coefficient, share: impl Fn(f64) -> f64, y: f64, name: &str) {
    let (series, estimate) = (Series::only(), coefficient.estimate);
    if estimate.is_nan() {
        return;
    }
    let Interval { low, high } = interval(coefficient);
    let [from, to] = [low, high].map(|end| panel.x(share(end).clamp(0.0, 1.0)));
    if to > from {
        svg.line(&[(from, y), (to, y)], Stroke { width: 3.0, ..series.bar() });
    }
    for (is_beyond, x, direction) in [(share(low) < 0.0, from, -1.0), (share(high) > 1.0, to, 1.0)] {
        if is_beyond {
            arrow(svg, (x, y), direction, series);
        }
    }
    if estimate.is_finite() {
        let text = format!("{name}: {}", told(estimate, coefficient.interval));
        svg.point((panel.x(share(estimate)), y), MARKER + 1.0, series, text);
    }
}

/// Draws an arrowhead that points right (1) or left (−1).
fn arrow(svg: &mut Svg, (x, y): Point, direction: f64, series: Series) {
    let back = x - direction * 18.0;
    svg.polygon(&[(x, y), (back, y - 9.0), (back, y + 9.0)], series.color);
}
