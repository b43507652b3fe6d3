//! The plot on the last page: what participants answered, in a form that they understand.

use std::collections::BTreeMap;

use eframe::egui;
use egui_plot::{GridMark, Line, Points};

use crate::{
    app::ui::{legend, still_plot, theme},
    experiment::{
        Factor, Phase, Protocol, TaskAnswer, TrialRecord,
        task::{Answer, significant},
    },
    report::names,
    stimulus::ParameterValue,
};

/// Maximum number of lines that have a legend.
const MAX_LEGEND: usize = 6;

/// A plot of one participant's answers.
#[derive(Default)]
pub struct OwnPlot {
    /// What it shows, in a sentence.
    pub caption: String,
    x_label: String,
    y_label: String,
    /// The names of the places 0, 1, … on the horizontal axis; none if it has numbers.
    places: Vec<String>,
    /// The ends of the vertical axis.
    y: [f64; 2],
    /// Whether the vertical axis shows powers of ten.
    log: bool,
    /// Name and points of each line.
    lines: Vec<(String, Vec<[f64; 2]>)>,
}

impl OwnPlot {
    /// Plots the last attempts of the main trials; `None` if there is nothing to plot.
    pub fn new(protocol: &Protocol, rows: &[TrialRecord]) -> Option<Self> {
        // Later attempts overwrite earlier ones, because rows are in chronological order.
        let last: BTreeMap<u32, &TrialRecord> =
            rows.iter().filter(|row| row.phase == Phase::Main).map(|row| (row.trial, row)).collect();
        let rows: Vec<&TrialRecord> = last.into_values().collect();
        let (task, texts) = (&protocol.task, &protocol.instructions);
        let plot = if let Some(dial) = task.dial() {
            let label = dial.parameter.as_ref().unwrap_or(&texts.mean_rating);
            means(protocol, &rows, (label, dial.range), |row| match row.given(protocol)? {
                Answer::Value(value) => Some(value),
                Answer::Key(_) => None,
            })
        } else if task.is_default() {
            let y = [0.0, protocol.response.highest().into()];
            means(protocol, &rows, (&texts.mean_rating, y), |row| Some(row.rating?.0.into()))
        } else if protocol.pairs().is_some() {
            chosen(protocol, &rows)
        } else if protocol.adaptive.is_some() {
            levels(protocol, &rows)
        } else {
            means(protocol, &rows, (&texts.right, [0.0, 1.0]), |row| {
                row.answer.as_ref()?.correct.map(|right| f64::from(u8::from(right)))
            })
        };
        plot.filter(|plot| !plot.lines.is_empty())
    }

    /// Draws the plot and what its lines are, this high, points.
    pub fn draw(&self, ui: &mut egui::Ui, height: f32) {
        let ([low, high], log) = (self.y, self.log);
        let pad = 0.05 * (high - low);
        let last = self.places.len().saturating_sub(1) as f64;
        let (dark, places) = (ui.visuals().dark_mode, self.places.clone());
        let titles = [self.x_label.as_str(), self.y_label.as_str()];
        let mut plot = still_plot(ui, "ratings", titles).height(height).include_y(low - pad).include_y(high + pad);
        if log {
            plot = plot
                .y_grid_spacer(move |grid| {
                    let round: Vec<f64> = round_levels(grid.bounds).collect();
                    // A short axis has no two round levels, so its ends are marked.
                    let marks = if round.len() < 2 { vec![low, high] } else { round };
                    marks.into_iter().map(|value| GridMark { value, step_size: 1.0 }).collect()
                })
                .y_axis_formatter(|mark, _| significant(f64::powf(10.0, mark.value)).to_string());
        }
        if !places.is_empty() {
            plot = plot
                .include_x(-0.3)
                .include_x(last + 0.3)
                .x_grid_spacer(move |_| (0..=last as i64).map(mark).collect())
                .x_axis_formatter(move |mark, _| {
                    let index = mark.value.round();
                    if index < 0.0 { String::new() } else { places.get(index as usize).cloned().unwrap_or_default() }
                });
        }
        if (2..=MAX_LEGEND).contains(&self.lines.len()) {
            let names = self.lines.iter().enumerate();
            legend(ui, names.map(|(i, (name, _))| (theme::series(dark, i).0, name.as_str())));
        }
        plot.show(ui, |plot| {
            for (i, (name, points)) in self.lines.iter().enumerate() {
                let (color, marker) = theme::series(dark, i);
                plot.line(Line::new(name, points.clone()).color(color).width(2.0));
                plot.points(Points::new(name, points.clone()).shape(marker).radius(5.0).color(color));
            }
        });
    }
}

/// Returns the logarithms of 1, 2 and 5 times the powers of ten between the ends of an axis.
fn round_levels((low, high): (f64, f64)) -> impl Iterator<Item = f64> {
    let decades = (low.floor() as i32)..=(high.ceil() as i32);
    let all = decades.flat_map(|decade| [1.0_f64, 2.0, 5.0].map(|digit| f64::from(decade) + digit.log10()));
    all.filter(move |level| (low..=high).contains(level))
}

fn mark(at: i64) -> GridMark {
    GridMark { value: at as f64, step_size: 1.0 }
}

/// Returns a factor and its level as people read them: `orientation 90°`.
fn shown(protocol: &Protocol, factor: &Factor, level: &str) -> String {
    let known = Some(protocol.stimulus.parameters());
    format!("{} {}", names::factor(known, &factor.name), names::level(known, &factor.name, level))
}

/// Plots the mean of a value by the level of a factor, with one line for each level of another.
fn means(
    protocol: &Protocol,
    rows: &[&TrialRecord],
    (y_label, y): (&str, [f64; 2]),
    value: impl Fn(&TrialRecord) -> Option<f64>,
) -> Option<OwnPlot> {
    let factors = &protocol.factors;
    let factor =
        |wanted: &str, other: usize| factors.iter().find(|factor| factor.name == wanted).or_else(|| factors.get(other));
    let along = factor("width", 0)?;
    let by = factor("depth", 1).filter(|by| along.name != by.name);
    let index = |row: &TrialRecord, factor: &Factor| {
        let text = row.level(protocol, &factor.name)?;
        factor.levels.iter().position(|level| level.to_string() == text)
    };
    let mut values: BTreeMap<usize, BTreeMap<usize, Vec<f64>>> = BTreeMap::new();
    for row in rows {
        let (Some(x), Some(value)) = (index(row, along), value(row)) else { continue };
        let line = by.and_then(|by| index(row, by)).unwrap_or(0);
        values.entry(line).or_default().entry(x).or_default().push(value);
    }
    let lines = values.into_iter().map(|(line, points)| {
        let name = by.map_or_else(|| "rating".to_owned(), |by| shown(protocol, by, &by.levels[line].to_string()));
        let mean = |(x, values): (usize, Vec<f64>)| [x as f64, values.iter().sum::<f64>() / values.len() as f64];
        (name, points.into_iter().map(mean).collect())
    });
    let known = Some(protocol.stimulus.parameters());
    let x = names::factor(known, &along.name);
    let caption = match by {
        Some(by) if *y_label == protocol.instructions.mean_rating => {
            let lines = names::factor(known, &by.name);
            protocol.instructions.ratings.replace("{x}", &x).replace("{lines}", &lines)
        }
        _ => y_label.to_owned(),
    };
    let place = |level: &ParameterValue| names::level(known, &along.name, &level.to_string()).to_string();
    Some(OwnPlot {
        caption,
        x_label: x,
        y_label: y_label.to_owned(),
        places: along.levels.iter().map(place).collect(),
        y,
        lines: lines.collect(),
        ..OwnPlot::default()
    })
}

/// Plots the level of each trial, with one line for each condition.
fn levels(protocol: &Protocol, rows: &[&TrialRecord]) -> Option<OwnPlot> {
    let common = &protocol.adaptive.as_ref()?.common;
    let mut lines: BTreeMap<String, Vec<[f64; 2]>> = BTreeMap::new();
    for row in rows {
        let Some(TaskAnswer { level: Some(level), target, .. }) = &row.answer else { continue };
        if *target == Some(0) {
            continue;
        }
        let level_of = |factor: &Factor| row.level(protocol, &factor.name).map(|level| shown(protocol, factor, &level));
        let name = protocol.factors.iter().filter_map(level_of).collect::<Vec<_>>().join(", ");
        let name = if name.is_empty() { common.parameter.clone() } else { name };
        let line = lines.entry(name).or_default();
        line.push([line.len() as f64 + 1.0, common.scaled(*level)]);
    }
    let all = || lines.values().flatten().map(|point| point[1]);
    let y = [all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max)];
    Some(OwnPlot {
        caption: protocol.instructions.levels.clone(),
        x_label: protocol.instructions.trial.clone(),
        y_label: common.parameter.clone(),
        y,
        log: common.log,
        lines: lines.into_iter().collect(),
        ..OwnPlot::default()
    })
}

/// Plots the share of comparisons that each condition won, lowest first.
fn chosen(protocol: &Protocol, rows: &[&TrialRecord]) -> Option<OwnPlot> {
    let mut tallies: BTreeMap<String, [f64; 2]> = BTreeMap::new();
    for row in rows {
        let answer = row.given(protocol)?;
        for (place, suffix) in [(Answer::Key(0), ""), (Answer::Key(1), "_2")] {
            let level = |factor: &Factor| row.level(protocol, &format!("{}{suffix}", factor.name));
            let name = protocol.factors.iter().filter_map(level).collect::<Vec<_>>().join(", ");
            let [won, all] = tallies.entry(name).or_default();
            (*won, *all) = (*won + f64::from(u8::from(answer == place)), *all + 1.0);
        }
    }
    let mut shares: Vec<(String, f64)> = tallies.into_iter().map(|(name, [won, all])| (name, won / all)).collect();
    shares.sort_by(|a, b| a.1.total_cmp(&b.1));
    let points = shares.iter().enumerate().map(|(x, (_, share))| [x as f64, *share]).collect();
    Some(OwnPlot {
        caption: protocol.instructions.chosen.clone(),
        x_label: protocol.factors.iter().map(|factor| factor.name.as_str()).collect::<Vec<_>>().join(", "),
        y_label: protocol.instructions.share.clone(),
        // A long name has room only in two lines.
        places: shares.into_iter().map(|(name, _)| name.replace('-', "-\n")).collect(),
        y: [0.0, 1.0],
        lines: vec![(protocol.instructions.share.clone(), points)],
        ..OwnPlot::default()
    })
}
