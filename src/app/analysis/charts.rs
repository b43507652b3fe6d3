//! What the plots show, computed once for each analysis.

use std::collections::BTreeMap;

use super::words;
use crate::analysis::{
    Results,
    bootstrap::{Bootstrap, Interval},
    counts::{Counts, CountsBuilder},
    summary::{Group, by_cell, category_values},
    times::Quartiles,
};

/// Plots of one sort.
pub struct Sort {
    /// Its name among the others.
    pub name: String,
    /// The plots, each by the name of what it is by.
    pub charts: Vec<(String, Chart)>,
}

/// A plot.
pub struct Chart {
    /// What is shown.
    pub title: String,
    /// How it is to be read.
    pub about: String,
    /// Its points.
    pub drawing: Drawing,
}

/// How a plot is drawn.
pub enum Drawing {
    /// Points along the places of an axis, those of a series joined.
    Lines(Lines),
    /// Proportions on top of each other.
    Stacks(Stacks),
}

/// Points along the places of an axis.
pub struct Lines {
    /// What is along the places.
    pub places: String,
    /// The places by name.
    pub labels: Vec<String>,
    /// What is measured.
    pub values: String,
    /// Values that are to be seen in any case.
    pub range: Option<(f64, f64)>,
    /// Whether the values go to the right, and the places downward.
    pub sideways: bool,
    /// Whether the points of a series belong together.
    pub joined: bool,
    /// The series.
    pub series: Vec<Series>,
}

/// Points that belong together.
pub struct Series {
    /// Its name; empty where there is one only.
    pub name: String,
    /// Its points.
    pub points: Vec<Point>,
}

/// A value and how sure it is.
pub struct Point {
    /// Index of the place.
    pub place: usize,
    /// The value.
    pub value: f64,
    /// Its interval.
    pub interval: Option<Interval>,
    /// Both in words.
    pub words: String,
}

/// Proportions of the categories.
pub struct Stacks {
    /// What is along the places.
    pub places: String,
    /// The places by name.
    pub labels: Vec<String>,
    /// The categories, the lowest first, and the proportion of each at every place.
    pub categories: Vec<(String, Vec<f64>)>,
}

/// All plots that the results have something for.
pub fn all(results: &Results) -> Vec<Sort> {
    let sorts = [
        figures(results),
        means(results),
        proportions(results),
        participants(results),
        effects(results).map(|chart| Sort { name: "Effects".to_owned(), charts: vec![(String::new(), chart)] }),
        times(results),
    ];
    sorts.into_iter().flatten().collect()
}

/// The sentence about the intervals of a plot of means.
fn about_intervals(results: &Results) -> String {
    let Bootstrap { level, replicates, .. } = results.options.bootstrap;
    if results.is_inferential() {
        format!(
            "Bars are {} % intervals of the mean over participants ({replicates} bootstrap samples).",
            level * 100.0
        )
    } else {
        "The ratings of one participant: no intervals.".to_owned()
    }
}

/// From the lowest to the highest rating.
fn scale(counts: &Counts) -> Option<(f64, f64)> {
    let values = category_values(counts);
    Some((values.first().copied()?, values.last().copied()?))
}

/// Figure 4: the mean rating by width, a line a depth, and the other way round. Of a design without these, the first
/// two factors that vary.
fn figures(results: &Results) -> Option<Sort> {
    let counts = &results.measured.counts;
    let mut varied: Vec<usize> = (0..counts.factors.len()).filter(|&f| counts.factors[f].levels.len() > 1).collect();
    let known = ["width", "depth"];
    let rank = |&factor: &usize| known.iter().position(|name| *name == counts.factors[factor].name).unwrap_or(2);
    varied.sort_by_key(rank);
    let (&first, &second) = varied.first().zip(varied.get(1))?;
    let original = [first, second].map(|factor| counts.factors[factor].name.as_str()) == known;
    let charts = [("a", first, second), ("b", second, first)]
        .map(|(letter, along, lines)| {
            let (x, line) = (&counts.factors[along].name, &counts.factors[lines].name);
            let figure = if original { format!("Figure 4 ({letter}). ") } else { String::new() };
            let chart = Chart {
                title: format!("{figure}Mean rating by {x}, one line a level of {line}"),
                about: about_intervals(results),
                drawing: Drawing::Lines(crossed(results, along, lines)),
            };
            (format!("by {x}"), chart)
        })
        .into();
    let name = if original { "Figure 4".to_owned() } else { "Mean rating".to_owned() };
    Some(Sort { name, charts })
}

/// The mean at the levels of one factor for each level of another, over everything else.
fn crossed(results: &Results, along: usize, lines: usize) -> Lines {
    let counts = &results.measured.counts;
    let cells = by_cell(&over(counts, &[lines, along]), &results.options.bootstrap);
    let (x, line) = (&counts.factors[along], &counts.factors[lines]);
    let series = (line.levels.iter())
        .map(|level| {
            let own = cells.iter().filter(|cell| cell.names[0] == *level);
            Series { name: format!("{} {level}", line.name), points: points(own, 1, &x.levels) }
        })
        .collect();
    mean_lines(counts, &x.name, &x.levels, series)
}

fn mean_lines(counts: &Counts, places: &str, labels: &[String], series: Vec<Series>) -> Lines {
    Lines {
        places: places.to_owned(),
        labels: labels.to_vec(),
        values: "mean rating".to_owned(),
        range: scale(counts),
        sideways: false,
        joined: true,
        series,
    }
}

/// The means of groups; `name` says which of a group's names is the place.
fn points<'a>(groups: impl Iterator<Item = &'a Group>, name: usize, labels: &[String]) -> Vec<Point> {
    let point = |group: &Group| {
        let summary = &group.summary;
        let interval = summary.interval.map(|i| format!(" ({})", words::interval(i, 2))).unwrap_or_default();
        Some(Point {
            place: labels.iter().position(|label| *label == group.names[name])?,
            value: summary.mean,
            interval: summary.interval,
            words: format!("mean {}{interval}, n {}", words::fixed(summary.mean, 2), words::grouped(summary.n)),
        })
    };
    groups.filter_map(point).collect()
}

/// The same ratings without some of the factors. Missing values stay missing.
fn over(counts: &Counts, factors: &[usize]) -> Counts {
    let names: Vec<&str> = factors.iter().map(|&factor| counts.factors[factor].name.as_str()).collect();
    let mut builder = CountsBuilder::new(&names).with_categories(&counts.categories);
    for row in &counts.rows {
        let levels = counts.level_names(row.condition);
        let values: Vec<&str> = factors.iter().map(|&factor| levels[factor]).collect();
        let (who, rating) = (&counts.subjects[row.subject as usize], &counts.categories[row.rating as usize]);
        // What was counted once is counted again.
        let _ = builder.add(who, &values, rating, row.count);
    }
    builder.finish()
}

/// The mean by each factor alone; orientation is one of them.
fn means(results: &Results) -> Option<Sort> {
    let counts = &results.measured.counts;
    let charts: Vec<_> = (results.factors.iter())
        .map(|factor| {
            let labels: Vec<String> = factor.levels.iter().map(|group| group.names[0].clone()).collect();
            let series = vec![Series { name: String::new(), points: points(factor.levels.iter(), 0, &labels) }];
            let chart = Chart {
                title: format!("Mean rating by {}", factor.name),
                about: about_intervals(results),
                drawing: Drawing::Lines(mean_lines(counts, &factor.name, &labels, series)),
            };
            (format!("by {}", factor.name), chart)
        })
        .collect();
    (!charts.is_empty()).then(|| Sort { name: "Factors".to_owned(), charts })
}

/// How often each category was chosen, by factor and by participant.
fn proportions(results: &Results) -> Option<Sort> {
    let counts = &results.measured.counts;
    let stacks = |places: &str, groups: Vec<&Group>| {
        let share = |category: usize| groups.iter().map(|group| group.summary.proportions[category]).collect();
        let chart = Chart {
            title: format!("Proportions of the ratings by {places}"),
            about: "How often each rating was given, the lowest at the bottom.".to_owned(),
            drawing: Drawing::Stacks(Stacks {
                places: places.to_owned(),
                labels: groups.iter().map(|group| group.names[0].clone()).collect(),
                categories: counts.categories.iter().enumerate().map(|(c, name)| (name.clone(), share(c))).collect(),
            }),
        };
        (format!("by {places}"), chart)
    };
    let mut charts: Vec<_> =
        results.factors.iter().map(|factor| stacks(&factor.name, factor.levels.iter().collect())).collect();
    charts.push(stacks("participant", results.subjects.iter().map(|subject| &subject.group).collect()));
    Some(Sort { name: "Proportions".to_owned(), charts })
}

/// Each participant's means by each factor.
fn participants(results: &Results) -> Option<Sort> {
    let counts = &results.measured.counts;
    let values = category_values(counts);
    let charts: Vec<_> = (counts.factors.iter().enumerate())
        .filter(|(_, factor)| factor.levels.len() > 1)
        .map(|(index, factor)| {
            let mut sums: BTreeMap<(u32, u32), (f64, u64)> = BTreeMap::new();
            for row in &counts.rows {
                let Some(level) = counts.conditions[row.condition as usize][index] else { continue };
                let sum = sums.entry((row.subject, level)).or_default();
                sum.0 += row.count as f64 * values[row.rating as usize];
                sum.1 += row.count;
            }
            let point = |(&(_, level), &(sum, n)): (&(u32, u32), &(f64, u64))| Point {
                place: level as usize,
                value: sum / n as f64,
                interval: None,
                words: format!("mean {}, n {}", words::fixed(sum / n as f64, 2), words::grouped(n)),
            };
            let series = (counts.subjects.iter().zip(0_u32..))
                .map(|(name, subject)| {
                    let own = sums.range((subject, 0)..=(subject, u32::MAX));
                    Series { name: name.clone(), points: own.map(point).collect() }
                })
                .collect();
            let chart = Chart {
                title: format!("Mean rating by {}, one line a participant", factor.name),
                about: "How far people differ, and whether they differ in height only.".to_owned(),
                drawing: Drawing::Lines(mean_lines(counts, &factor.name, &factor.levels, series)),
            };
            (format!("by {}", factor.name), chart)
        })
        .collect();
    (!charts.is_empty()).then(|| Sort { name: "Participants".to_owned(), charts })
}

/// The model's coefficients.
fn effects(results: &Results) -> Option<Chart> {
    let model = &results.model.as_ref().ok()?.model;
    let finite: Vec<_> = model.coefficients.iter().filter(|c| c.estimate.is_finite()).collect();
    if finite.is_empty() {
        return None;
    }
    let points = (finite.iter().enumerate())
        .map(|(place, coefficient)| {
            let reach = coefficient.se.filter(|_| results.is_inferential()).map(|se| crate::light::normal::Z_95 * se);
            let interval =
                reach.map(|reach| Interval { low: coefficient.estimate - reach, high: coefficient.estimate + reach });
            let ends = interval.map(|i| format!(" ({})", words::interval(i, 2))).unwrap_or_default();
            let words = format!("{}: {}{ends}", coefficient.name, words::fixed(coefficient.estimate, 2));
            Point { place, value: coefficient.estimate, interval, words }
        })
        .collect();
    let mut about = "To the right of 0: higher ratings than at the factor's first level.".to_owned();
    if results.is_inferential() {
        about += " Bars are 95 % intervals.";
    }
    if finite.len() < model.coefficients.len() {
        about += " Effects without a finite estimate are left out.";
    }
    Some(Chart {
        title: format!("Effects in the model ({})", model.link),
        about,
        drawing: Drawing::Lines(Lines {
            places: String::new(),
            labels: finite.iter().map(|coefficient| coefficient.name.clone()).collect(),
            values: format!("effect on the {} scale", model.link),
            range: Some((0.0, 0.0)),
            sideways: true,
            joined: false,
            series: vec![Series { name: String::new(), points }],
        }),
    })
}

/// Response times by rating, factor and participant.
fn times(results: &Results) -> Option<Sort> {
    let counts = &results.measured.counts;
    let mut charts: Vec<(String, Chart)> = Vec::new();
    let mut add = |places: &str, labels: Vec<String>, times: Vec<Option<Quartiles>>| {
        let point = |(place, times): (usize, &Option<Quartiles>)| {
            let Quartiles { n, lower, median, upper } = (*times)?;
            let interval = Interval { low: lower, high: upper };
            let quartiles = words::interval(interval, 2);
            let words = format!("median {} s (quartiles {quartiles}), n {n}", words::fixed(median, 2));
            Some(Point { place, value: median, interval: Some(interval), words })
        };
        let points: Vec<Point> = times.iter().enumerate().filter_map(point).collect();
        if points.is_empty() {
            return;
        }
        let chart = Chart {
            title: format!("Response times by {places}"),
            about: "Medians; bars go from the first to the third quartile of the answers.".to_owned(),
            drawing: Drawing::Lines(Lines {
                places: places.to_owned(),
                labels,
                values: "response time, s".to_owned(),
                range: Some((0.0, 0.0)),
                sideways: false,
                joined: false,
                series: vec![Series { name: String::new(), points }],
            }),
        };
        charts.push((format!("by {places}"), chart));
    };
    add("rating", counts.categories.clone(), results.times.clone());
    for factor in &results.factors {
        let labels = factor.levels.iter().map(|group| group.names[0].clone()).collect();
        add(&factor.name, labels, factor.times.clone());
    }
    let names = results.subjects.iter().map(|subject| subject.group.names[0].clone()).collect();
    add("participant", names, results.subjects.iter().map(|subject| subject.times).collect());
    (!charts.is_empty()).then(|| Sort { name: "Response times".to_owned(), charts })
}
