//! What the model says: every coefficient with its interval, by term.

use plotters::style::{WHITE, text_anchor::HPos};

use super::{
    Figure,
    axes::{EDGE, Panel, base, below, ends, number_ticks, plain, ticks},
    labels as text,
    palette::{AXIS, GRID, Look, MARKER, TEXT},
    svg::{Canvas, Drawn, Setting, Stroke, WIDTH, drawing},
};
use crate::analysis::{
    Coefficient, Link, Model, Note, Results,
    terms::{Term, Variable},
};

/// Most coefficients in a chart.
const MOST: usize = 60;
/// Distance of two rows.
const PITCH: f64 = 1.4 * TEXT;
/// Longest name of a row.
const LONGEST: f64 = 290.0;
/// The 97.5 % quantile of the normal distribution.
const Z: f64 = 1.959_963_984_540_054;

/// `effects`, where there is a model of several people with coefficients.
pub(super) fn figures(results: &Results) -> Vec<Figure> {
    figure(results).into_iter().collect()
}

fn figure(results: &Results) -> Option<Figure> {
    let model = &results.model.as_ref().ok()?.model;
    if !results.is_inferential() || model.coefficients.is_empty() {
        return None;
    }
    let title = format!("Effects in the {} model", model.link);
    let caption = caption(results, model);
    let svg = svg(results, model, &title, &caption)?;
    Some(Figure { name: "effects", title, caption, wide: false, svg })
}

fn caption(results: &Results, model: &Model) -> String {
    let endless = model.coefficients.iter().filter(|coefficient| !coefficient.estimate.is_finite()).count();
    let all = model.coefficients.len();
    let mut text = format!(
        "Coefficients of the cumulative {} model ({}), with 95 % intervals (1.96 standard errors): to the right, \
         ratings are higher than at the level in brackets; {}.",
        model.link,
        model.method,
        text::sample(results)
    );
    if endless > 0 {
        text += " An arrow alone: no finite estimate.";
    }
    if all > MOST {
        text += &format!(" The first {MOST} of {all} coefficients.");
    }
    text
}

/// A line of the chart.
enum Row<'a> {
    Term(String),
    Effect(String, &'a Coefficient),
}

fn rows<'a>(results: &Results, model: &'a Model) -> Vec<Row<'a>> {
    let mut rows = Vec::new();
    let mut last = None;
    for coefficient in model.coefficients.iter().take(MOST) {
        let term = results.spec.terms.iter().find(|term| term.to_string() == coefficient.term);
        let number = term.is_none_or(|term| matches!(term.variables[..], [Variable::Number(_)]));
        if !number && last != Some(&coefficient.term) {
            rows.extend(term.map(|term| Row::Term(heading(results, model, term))));
        }
        last = Some(&coefficient.term);
        let name = term.and_then(|term| levels(results, term, &coefficient.name));
        rows.push(Row::Effect(name.unwrap_or_else(|| text::clean(&coefficient.name)), coefficient));
    }
    rows
}

/// The levels of a coefficient: its name without the factors', which stand above it.
fn levels(results: &Results, term: &Term, name: &str) -> Option<String> {
    let mut rest = name;
    let mut parts = Vec::new();
    for (index, variable) in term.variables.iter().enumerate() {
        rest = if index > 0 { rest.strip_prefix(':')? } else { rest }.strip_prefix(variable.name())?;
        let Variable::Factor(factor) = variable else {
            parts.push(text::heading(variable.name()));
            continue;
        };
        let (_, factor) = results.measured.counts.factor(factor)?;
        // A level may have a colon too: the longest that fits is meant.
        let after = |level: &&String| {
            rest.strip_prefix(level.as_str()).filter(|after| after.is_empty() || after.starts_with(':'))
        };
        let level = factor.levels.iter().filter(|level| after(level).is_some()).max_by_key(|level| level.len())?;
        rest = after(&level)?;
        parts.push(text::level(level));
    }
    rest.is_empty().then(|| parts.join(" × "))
}

/// A term, with the level of a factor that the others are compared with.
fn heading(results: &Results, model: &Model, term: &Term) -> String {
    let [Variable::Factor(name)] = &term.variables[..] else {
        return term.variables.iter().map(|variable| text::heading(variable.name())).collect::<Vec<_>>().join(" × ");
    };
    let rebased = model.notes.iter().find_map(|note| match note {
        Note::Rebased { factor, baseline, .. } if factor == name => Some(baseline),
        _ => None,
    });
    let baseline = results.measured.counts.factor(name).and_then(|(_, factor)| rebased.or(factor.levels.first()));
    baseline.map_or_else(
        || text::heading(name),
        |level| format!("{} (against {})", text::heading(name), text::level(level)),
    )
}

/// Ends of an interval; of one without a standard error, the estimate.
fn interval(coefficient: &Coefficient) -> (f64, f64) {
    let half = coefficient.se.filter(|se| se.is_finite()).map_or(0.0, |se| Z * se);
    (coefficient.estimate - half, coefficient.estimate + half)
}

/// The range of the axis: all intervals, but not where a few endless ones would leave no room for the others.
fn range(model: &Model) -> (f64, f64) {
    let finite = || model.coefficients.iter().take(MOST).filter(|c| c.estimate.is_finite());
    let largest = finite().map(|c| c.estimate.abs()).fold(0.0, f64::max);
    let mut halves: Vec<f64> = finite().map(|c| (interval(c).1 - c.estimate).abs()).collect();
    halves.sort_by(f64::total_cmp);
    let limit = largest + 4.0 * halves.get(halves.len() / 2).copied().unwrap_or(1.0);
    let bounds = finite().map(interval).flat_map(|(low, high)| [low, high]);
    let (low, high) = ends(bounds.map(|end| end.clamp(-limit, limit)).chain([0.0])).unwrap_or((-1.0, 1.0));
    let pad = (0.06 * (high - low)).max(0.1);
    (low - pad, high + pad)
}

fn svg(results: &Results, model: &Model, title: &str, caption: &str) -> Option<String> {
    let rows = rows(results, model);
    let (low, high) = range(model);
    let indent = 18.0;
    let widest = rows.iter().map(|row| match row {
        Row::Effect(name, _) => indent + text::width(name, TEXT),
        // Headings may reach into the panel, where their line is empty.
        Row::Term(_) => 0.0,
    });
    let label = widest.fold(120.0, f64::max).min(LONGEST);
    let panel = Panel {
        left: EDGE + label + 14.0,
        right: WIDTH - EDGE - 8.0,
        top: EDGE,
        bottom: EDGE + PITCH * rows.len() as f64 + 8.0,
        low: 0.0,
        high: 1.0,
    };
    let share = |value: f64| (value - low) / (high - low);
    let unit = match model.link {
        Link::Logit => "logit units",
        Link::Probit => "probit units",
    };
    drawing(panel.bottom + below(TEXT), title, caption, |canvas| {
        let most = (panel.width() / 80.0) as usize;
        let at: Vec<(f64, String)> = ticks(low, high, most).into_iter().map(|t| (share(t), plain(t))).collect();
        for (share, _) in &at {
            canvas.line(&[(panel.x(*share), panel.top), (panel.x(*share), panel.bottom)], GRID)?;
        }
        let zero = panel.x(share(0.0));
        canvas.line(&[(zero, panel.top), (zero, panel.bottom)], Stroke { dash: Some((9.0, 6.0)), ..AXIS })?;
        number_ticks(canvas, &panel, &at, "")?;
        base(canvas, &panel, TEXT, &format!("Shift of the ratings ({unit})"))?;
        for (index, row) in rows.iter().enumerate() {
            let y = panel.top + PITCH * (index as f64 + 0.5);
            match row {
                Row::Term(name) => {
                    let name = text::fit(name, WIDTH - 2.0 * EDGE, TEXT);
                    let ground = EDGE + text::width(&name, 1.05 * TEXT);
                    canvas.rectangle((EDGE, y - 0.5 * PITCH), (ground, y + 0.45 * PITCH), WHITE)?;
                    canvas.text(&name, (EDGE, y), Setting::new(TEXT, HPos::Left).bold())?;
                }
                Row::Effect(name, coefficient) => {
                    let name = text::fit(name, LONGEST - indent, TEXT);
                    canvas.text(&name, (panel.left - 14.0, y), Setting::new(TEXT, HPos::Right))?;
                    effect(canvas, &panel, coefficient, share, y)?;
                }
            }
        }
        Ok(())
    })
}

/// An estimate with its interval; an arrow where they go on beyond the panel.
fn effect(canvas: &Canvas<'_>, panel: &Panel, coefficient: &Coefficient, share: impl Fn(f64) -> f64, y: f64) -> Drawn {
    let look = Look::only();
    let estimate = coefficient.estimate;
    if estimate.is_nan() {
        return Ok(());
    }
    if estimate.is_infinite() {
        let (edge, inward) = if estimate > 0.0 { (panel.right, -1.0) } else { (panel.left, 1.0) };
        canvas.line(&[(edge + inward * 90.0, y), (edge + inward * 16.0, y)], look.bar())?;
        return arrow(canvas, (edge, y), -inward, look);
    }
    let (low, high) = interval(coefficient);
    let [from, to] = [low, high].map(|end| panel.x(share(end).clamp(0.0, 1.0)));
    if to > from {
        canvas.line(&[(from, y), (to, y)], Stroke { width: 3.0, ..look.bar() })?;
        for (end, x, direction) in [(share(low), from, -1.0), (share(high), to, 1.0)] {
            if (0.0..=1.0).contains(&end) {
                canvas.line(&[(x, y - 7.0), (x, y + 7.0)], look.bar())?;
            } else {
                arrow(canvas, (x, y), direction, look)?;
            }
        }
    }
    canvas.marker((panel.x(share(estimate)), y), MARKER + 1.0, look)
}

/// A tip at a place, to the right (1) or left (−1).
fn arrow(canvas: &Canvas<'_>, (x, y): (f64, f64), direction: f64, look: Look) -> Drawn {
    let back = x - direction * 18.0;
    canvas.polygon(&[(x, y), (back, y - 9.0), (back, y + 9.0)], look.colour)
}
