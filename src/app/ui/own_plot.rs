//! The plot on the last page: what participants answered, in a form that they understand.

use std::collections::BTreeMap;

use eframe::egui;
use egui_plot::{GridMark, Line, Points};

use crate::{
    app::ui::{legend, still_plot, theme},
    experiment::{
        Factor, Phase, Protocol, TaskAnswer, TrialRecord,
        task::{Answer, Measures},
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
    /// The titles of the axes, across and up.
    titles: [String; 2],
    /// The names of the places 0, 1, … on the horizontal axis; none if it has numbers.
    places: Vec<String>,
    /// The ends of the vertical axis.
    y: [f64; 2],
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
        let plot = match (protocol.task.measures(), &protocol.adaptive) {
            (Measures::Comparisons, _) => Some(chosen(protocol, &rows)),
            (Measures::Proportions | Measures::Detection, Some(adaptive)) => {
                Some(levels(protocol, &adaptive.common.parameter, &rows))
            }
            _ => means(protocol, &rows),
        };
        plot.filter(|plot| !plot.lines.is_empty())
    }

    /// Draws the plot and what its lines are, this high, points.
    pub fn draw(&self, ui: &mut egui::Ui, height: f32) {
        let pad = 0.05 * (self.y[1] - self.y[0]);
        let [low, high] = [self.y[0] - pad, self.y[1] + pad];
        let titles = self.titles.each_ref().map(String::as_str);
        let [least, most] = self.y;
        let mut plot = still_plot(ui, "ratings", titles).height(height).include_y(low).include_y(high);
        plot = plot.y_axis_formatter(move |mark, _| {
            let value = (1e4 * mark.value).round() / 1e4;
            if (least..=most).contains(&value) { value.to_string() } else { String::new() }
        });
        if let Some(last) = self.places.len().checked_sub(1) {
            let places = self.places.clone();
            let mark = |at: usize| GridMark { value: at as f64, step_size: 1.0 };
            plot = plot
                .include_x(-0.3)
                .include_x(last as f64 + 0.3)
                .x_grid_spacer(move |_| (0..=last).map(mark).collect())
                .x_axis_formatter(move |mark, _| places.get(mark.value.round() as usize).cloned().unwrap_or_default());
        }
        let dark = ui.visuals().dark_mode;
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

/// Returns a factor and its level as people read them: `orientation 90°`.
fn named(protocol: &Protocol, factor: &Factor, level: &str) -> String {
    let known = Some(protocol.stimulus.parameters());
    format!("{} {}", names::factor(known, &factor.name), names::level(known, &factor.name, level))
}

/// Plots the mean answer by the level of the first factor, with one line for each level of the second.
fn means(protocol: &Protocol, rows: &[&TrialRecord]) -> Option<OwnPlot> {
    let (texts, known) = (&protocol.instructions, Some(protocol.stimulus.parameters()));
    let is_share = matches!(protocol.task.measures(), Measures::Proportions | Measures::Detection);
    let (title, y) = match protocol.task.dial() {
        _ if is_share => (texts.right.clone(), [0.0, 1.0]),
        Some(dial) => (dial.parameter.unwrap_or_else(|| texts.mean_rating.clone()), dial.range),
        None => (texts.mean_rating.clone(), [0.0, protocol.response.highest().into()]),
    };
    let value = |row: &TrialRecord| match row.given(protocol)? {
        _ if is_share => row.answer.as_ref()?.correct.map(|right| f64::from(u8::from(right))),
        Answer::Value(value) => Some(value),
        Answer::Key(key) => Some(key.into()),
    };
    let (along, by) = (protocol.factors.first()?, protocol.factors.get(1));
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
    let place = |level: &ParameterValue| names::level(known, &along.name, &level.to_string()).to_string();
    let name = |factor: &Factor| names::factor(known, &factor.name);
    let lines = values.into_iter().map(|(line, points)| {
        let told = by.map(|by| named(protocol, by, &by.levels[line].to_string()));
        let mean = |(x, values): (usize, Vec<f64>)| [x as f64, values.iter().sum::<f64>() / values.len() as f64];
        (told.unwrap_or_default(), points.into_iter().map(mean).collect())
    });
    let caption = match by {
        Some(by) if title == texts.mean_rating => {
            texts.ratings.replace("{x}", &name(along)).replace("{lines}", &name(by))
        }
        _ => title.clone(),
    };
    Some(OwnPlot {
        caption,
        titles: [name(along), title],
        places: along.levels.iter().map(place).collect(),
        y,
        lines: lines.collect(),
    })
}

/// Plots the level of each trial, with one line for each condition.
fn levels(protocol: &Protocol, parameter: &str, rows: &[&TrialRecord]) -> OwnPlot {
    let mut lines: BTreeMap<String, Vec<[f64; 2]>> = BTreeMap::new();
    for row in rows {
        // A catch trial has no level.
        let Some(TaskAnswer { level: Some(level), target, .. }) = &row.answer else { continue };
        if *target != Some(0) {
            let level_of = |factor: &Factor| Some(named(protocol, factor, &row.level(protocol, &factor.name)?));
            let name = protocol.factors.iter().filter_map(level_of).collect::<Vec<_>>().join(", ");
            let line = lines.entry(name).or_default();
            line.push([line.len() as f64 + 1.0, *level]);
        }
    }
    let all = || lines.values().flatten().map(|point| point[1]);
    let y = [all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max)];
    let (caption, trial) = (protocol.instructions.levels.clone(), protocol.instructions.trial.clone());
    let titles = [trial, parameter.to_owned()];
    OwnPlot { caption, titles, y, lines: lines.into_iter().collect(), ..OwnPlot::default() }
}

/// Plots the share of comparisons that each condition won, lowest first.
fn chosen(protocol: &Protocol, rows: &[&TrialRecord]) -> OwnPlot {
    let mut tallies: BTreeMap<String, [f64; 2]> = BTreeMap::new();
    for row in rows {
        let answer = row.given(protocol);
        for (place, suffix) in [(Answer::Key(0), ""), (Answer::Key(1), "_2")] {
            let level = |factor: &Factor| row.level(protocol, &format!("{}{suffix}", factor.name));
            let name = protocol.factors.iter().filter_map(level).collect::<Vec<_>>().join(", ");
            let [won, all] = tallies.entry(name).or_default();
            (*won, *all) = (*won + f64::from(u8::from(answer == Some(place))), *all + 1.0);
        }
    }
    let mut shares: Vec<(String, f64)> = tallies.into_iter().map(|(name, [won, all])| (name, won / all)).collect();
    shares.sort_by(|a, b| a.1.total_cmp(&b.1));
    let points = shares.iter().enumerate().map(|(x, (_, share))| [x as f64, *share]).collect();
    let (texts, factors) = (&protocol.instructions, protocol.factors.iter().map(|factor| factor.name.as_str()));
    OwnPlot {
        caption: texts.chosen.clone(),
        titles: [factors.collect::<Vec<_>>().join(", "), texts.share.clone()],
        // A long name has room only in two lines.
        places: shares.into_iter().map(|(name, _)| name.replace('-', "-\n")).collect(),
        y: [0.0, 1.0],
        lines: vec![(String::new(), points)],
    }
}
