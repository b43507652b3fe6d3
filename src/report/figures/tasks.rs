//! Charts of estimates: a task's psychometric functions and thresholds, and the effects in a model of ratings.

use super::{
    axes::{Levels, MARKER, Values, chart, told},
    labels::some_of,
    palette::Series,
    ratings::{Line, draw},
    svg::Figure,
};
use crate::{
    analysis::{Coefficient, Results},
    report::{document::count, names},
    statistics::Interval,
};

/// The proportions of correct answers in a condition, and its psychometric function.
pub(crate) struct Curve {
    /// Name of the condition.
    pub name: String,
    /// Level, proportion and number of trials.
    pub points: Vec<(f64, f64, u32)>,
    /// The function, at equally spaced levels over `range`.
    pub line: Vec<f64>,
}

/// Draws `psychometric`: all people's answers by level, and the function of the mean threshold. Levels are on the scale
/// named by `axis`, between the two of `range`.
pub(crate) fn psychometric(curves: &[Curve], range: [f64; 2], axis: &str, caption: String) -> Option<Figure> {
    if curves.is_empty() {
        return None;
    }
    let series = curves.iter().enumerate().map(|(index, curve)| (Series::of(index), curve.name.as_str()));
    let series: Vec<_> = series.collect();
    let texts = ["Answers by level, and psychometric functions".to_owned(), caption];
    let values = (Values::from_zero(1.0), "Proportion of answers");
    let levels = (&Levels::numbers(range[0], range[1]), axis);
    Some(chart("psychometric", texts, values, levels, ("", &series, true), |svg, panel| {
        let share = |x: f64| (x - range[0]) / (range[1] - range[0]);
        let largest = curves.iter().flat_map(|curve| &curve.points).map(|point| point.2).max().unwrap_or(1);
        for (curve, (series, _)) in curves.iter().zip(&series) {
            let last = curve.line.len().saturating_sub(1).max(1) as f64;
            let line = curve.line.iter().enumerate().map(|(i, y)| (panel.x(i as f64 / last), panel.y(*y)));
            svg.line(&line.collect::<Vec<_>>(), series.line());
            for (x, y, n) in &curve.points {
                // The area of a marker stands for the number of trials.
                let radius = MARKER * (0.3 + 0.9 * (f64::from(*n) / f64::from(largest)).sqrt());
                let of = if curve.name.is_empty() { String::new() } else { format!("{}, ", curve.name) };
                let [level, answers] = [*x, *y].map(|value| told(value, None));
                let text = format!("{of}{axis} {level}: {answers} of {n} trials");
                svg.point((panel.x(share(*x)), panel.y(*y)), radius, *series, text);
            }
        }
    }))
}

/// The estimates of one person or condition at each place, with their intervals, and its name.
pub(crate) type Estimates = (String, Vec<Option<(f64, Option<Interval>)>>);

/// Draws `name`: estimates with their intervals, one for each place, in one series for each person or condition.
pub(crate) fn estimates(
    name: &'static str,
    places: &[String],
    series: &[Estimates],
    (title, axis, caption): (&str, &str, String),
) -> Option<Figure> {
    let ends = series.iter().flat_map(|(_, all)| all.iter().flatten());
    let ends = ends.flat_map(|(value, interval)| [Some(*value), interval.map(|i| i.low), interval.map(|i| i.high)]);
    let (low, high) = super::axes::ends(ends.flatten().filter(|end| end.is_finite()))?;
    let pad = if high > low { 0.06 * (high - low) } else { 0.5 };
    let values = Values::between(low - pad, high + pad);
    let of = |index: usize| if series.len() > 1 { Series::of(index) } else { Series::only() };
    let line = |(index, (name, means)): (usize, &Estimates)| {
        let name = if series.len() > 1 { name.clone() } else { String::new() };
        Line { name, series: of(index), means: means.clone() }
    };
    let lines: Vec<Line> = series.iter().enumerate().map(line).collect();
    let levels = Levels::evenly(places, false);
    let series: Vec<_> = lines.iter().map(|line| (line.series, line.name.as_str())).collect();
    let texts = [title.to_owned(), caption];
    Some(chart(name, texts, (values, axis), (&levels, ""), ("", &series, false), |svg, panel| {
        draw(svg, panel, &levels, &lines, ["", ""]);
    }))
}

/// Maximum number of coefficients in a chart.
const MAX_SHOWN: usize = 60;

/// Draws `effects`, if there is a model with coefficients.
pub(super) fn effects(results: &Results) -> Option<Figure> {
    let model = &results.model.as_ref().ok()?.model;
    let finite = model.coefficients.iter().filter(|own| own.estimate.is_finite());
    let shown: Vec<&Coefficient> = finite.take(MAX_SHOWN).collect();
    let effects = shown.iter().map(|own| Some((own.estimate, own.interval))).collect();
    let names = shown.iter().map(|own| names::coefficient(results, &own.parts)).collect::<Vec<_>>();
    let caption = format!(
        "Coefficients of the cumulative-link {}model{}, from {}; bars are 95\u{a0}% intervals, where there are any. A positive \
         value means higher ratings than at the factor’s baseline (the level without a coefficient) or, of a number, ratings \
         that rise with it.",
        if model.random.is_some() { "mixed " } else { "" },
        some_of(shown.len(), model.coefficients.len()),
        count(model.nobs, "rating")
    );
    let title = format!("Effects in the {} model", model.link);
    estimates("effects", &names, &[(String::new(), effects)], (&title, "Shift of the ratings", caption))
}
