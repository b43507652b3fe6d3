//! Charts of ratings. As in Figure 4 of Bangay's paper, one chart shows the means by one factor, with
//! one line for each level of the other factor, and a second chart shows the reverse. Other charts show the means by direction
//! and by participant, and how often each category was used, with one bar for each level of a factor.

use std::collections::{BTreeMap, HashMap};

use super::{
    axes::{Levels, MARKER, Panel, Values, chart, told},
    labels::{self, chosen, evenly},
    palette::{GRAY, MAX_SERIES, Marker, Series, Stroke, category},
    svg::{Figure, Point, Svg},
};
use crate::{
    analysis::{
        Results,
        counts::Factor,
        summary::{Group, by_levels, means_by_subject},
    },
    report::{document::whole_percent, names},
    statistics::Interval,
};

/// Maximum number of participants drawn as lines. More lines could not be told apart and would take long to draw.
const MAX_LINES: usize = 300;

/// What the charts of measured means show.
const WHAT: &str = "Mean rating";

/// A mean and its interval.
pub(super) type Mean = (f64, Option<Interval>);

/// One line of a chart, with a mean for each level of the factor on the horizontal axis.
pub(super) struct Line {
    /// The level of the other factor; empty if there is none.
    pub name: String,
    pub series: Series,
    pub means: Vec<Option<Mean>>,
}

/// Draws `figure4a` and, if there are two factors, `figure4b`. The factors are width and depth if both exist.
pub(super) fn figures(results: &Results) -> Vec<Figure> {
    let factors = chosen(&results.measured.counts);
    let means = by_levels(&results.measured.counts, &factors);
    let chart = |of| by_factor(results, &factors, &means, of);
    (0..factors.len()).zip(["figure4a", "figure4b"]).map(chart).collect()
}

/// Draws the means by the factor at a place, with one line for each level of the other, if there is one.
fn by_factor(results: &Results, factors: &[usize], means: &[Group], (x, name): (usize, &'static str)) -> Figure {
    let all = &results.measured.counts.factors;
    let means: HashMap<&[String], Mean> =
        means.iter().map(|own| (&*own.names, (own.summary.mean, own.summary.interval))).collect();
    let (across, by) = (&all[factors[x]], factors.get(1 - x).map(|by| &all[*by]));
    let shown = evenly(by.map_or(1, |by| by.levels.len()), MAX_SERIES);
    let line = |(index, &level): (usize, &usize)| {
        let level = by.map(|by| &by.levels[level]);
        let mean = |own: &String| {
            let mut key: Vec<String> = [Some(own), level].into_iter().flatten().cloned().collect();
            if x == 1 {
                key.reverse();
            }
            means.get(&*key).copied()
        };
        Line {
            name: level.map(|level| labels::level(level)).unwrap_or_default(),
            series: if shown.len() == 1 { Series::only() } else { Series::of(index) },
            means: across.levels.iter().map(mean).collect(),
        }
    };
    let lines: Vec<Line> = shown.iter().enumerate().map(line).collect();
    let levels = Levels::of(across);
    let mut title = format!("{WHAT} by {}", names::factor(results, &across.name));
    let mut caption = String::new();
    if let Some(by) = by {
        let thing = if levels.ordered { "line" } else { "marker" };
        let (by_name, some) = (names::factor(results, &by.name), labels::some_of(lines.len(), by.levels.len()));
        title += &format!(" and {by_name}");
        caption = format!("one {thing} for each level of {by_name}{some}; ");
    }
    let caption = names::capitalized(&format!("{caption}{}.", labels::bars(results)));
    let heading = by.map(|by| names::heading(results, &by.name)).unwrap_or_default();
    let series: Vec<(Series, &str)> = lines.iter().map(|line| (line.series, line.name.as_str())).collect();
    let values = (Values::ratings(&results.measured.counts), WHAT);
    let axis = (&levels, &*names::axis(results, &across.name));
    let names = [Some(across), by].map(|of| of.map_or_else(String::new, |of| names::factor(results, &of.name)));
    chart(name, [title, caption], values, axis, (&heading, &series, levels.ordered), |svg, panel| {
        draw(svg, panel, &levels, &lines, [&names[0], &names[1]]);
    })
}

/// Draws lines of means. `names` are those of the factor on the horizontal axis and of the other factor.
pub(super) fn draw(svg: &mut Svg, panel: &Panel, levels: &Levels, lines: &[Line], [across, by]: [&str; 2]) {
    let count = lines.len() as f64;
    // Series are offset so that no interval hides another; with lines, a smaller offset is enough.
    let most = if levels.ordered { 10.0 } else { 26.0 };
    let step = (0.75 * levels.gap() * panel.width() / count).min(most);
    for (index, line) in lines.iter().enumerate() {
        let shift = (index as f64 - (count - 1.0) / 2.0) * step;
        let x = |at: f64| panel.x(at) + shift;
        let means = || levels.at.iter().zip(&line.means);
        if levels.ordered {
            let points: Vec<_> = means().map(|(&at, mean)| mean.map(|(mean, _)| (x(at), panel.y(mean)))).collect();
            svg.path(&points, line.series.line());
        }
        for (&at, (_, interval)) in means().filter_map(|(at, mean)| Some((at, mean.as_ref()?))) {
            if let Some(interval) = interval {
                // An end may be infinite.
                let [low, high] = [interval.low, interval.high].map(|end| panel.y(end.clamp(panel.low, panel.high)));
                svg.interval(x(at), low, high, 5.0, line.series.bar());
            }
        }
        let named = |factor: &str, level: &str| format!("{factor} {level}").trim().to_owned();
        for ((at, name), mean) in levels.at.iter().zip(&levels.names).zip(&line.means) {
            let Some((mean, interval)) = *mean else { continue };
            let mut places = vec![named(across, name), named(by, &line.name)];
            places.retain(|place| !place.is_empty());
            let text = format!("{}: {}", places.join(", "), told(mean, interval));
            svg.point((x(*at), panel.y(mean)), MARKER, line.series, text);
        }
    }
}

/// Draws `orientation`: the means by a direction with several levels that is not in Figure 4.
pub(super) fn orientation(results: &Results) -> Option<Figure> {
    let counts = &results.measured.counts;
    let is_direction = |factor: &Factor| factor.is_direction && factor.levels.len() > 1;
    let index = counts.factors.iter().position(is_direction).filter(|index| !chosen(counts).contains(index))?;
    Some(by_factor(results, &[index], &by_levels(counts, &[index]), (0, "orientation")))
}

/// Draws `subjects`, if there are several: every participant's mean rating by the most interesting factor, and the mean of all ratings.
pub(super) fn participants(results: &Results) -> Option<Figure> {
    let counts = &results.measured.counts;
    let factor = *chosen(counts).first().filter(|_| results.is_inferential())?;
    let by = &counts.factors[factor];
    let (name, sample) = (names::factor(results, &by.name), labels::sample(results));
    let shown = evenly(results.people(), MAX_LINES);
    let title = format!("{WHAT} of every participant by {name}");
    let some = labels::some_of(shown.len(), results.people());
    let caption =
        format!("Each gray line is one participant{some}, and markers are means over participants; {sample}.");
    let levels = Levels::of(by);
    let people = shown.len() as f64;
    let thin = Stroke { opacity: (12.0 / people).clamp(0.25, 0.75), ..Stroke::new(GRAY, 2.0) };
    let (values, axis) = ((Values::ratings(counts), WHAT), (&levels, &*names::axis(results, &by.name)));
    Some(chart("subjects", [title, caption], values, axis, Default::default(), |svg, panel| {
        let level = |_, condition: u32| counts.conditions[condition as usize][factor].map(|level| level as usize);
        let means = means_by_subject(counts, by.levels.len(), level);
        for person in shown {
            let point = |(at, of_level): (&f64, &BTreeMap<u32, f64>)| -> Option<Point> {
                Some((panel.x(*at), panel.y(*of_level.get(&(person as u32))?)))
            };
            svg.path(&levels.at.iter().zip(&means).map(point).collect::<Vec<_>>(), thin);
        }
        let groups = &results.factors[factor].levels;
        let mean = |level: &String| Some((groups.iter().find(|group| group.names[0] == *level)?.summary.mean, None));
        let means = by.levels.iter().map(mean).collect();
        draw(svg, panel, &levels, &[Line { name: String::new(), series: Series::only(), means }], [&name, ""]);
    }))
}

/// Maximum number of categories in the legend; readers can interpolate the colors in between.
const MAX_NAMED: usize = 10;

/// Draws `proportions`.
pub(super) fn proportions(results: &Results) -> Option<Figure> {
    let counts = &results.measured.counts;
    let index = *chosen(counts).first()?;
    let (groups, factor) = (by_levels(counts, &[index]), &counts.factors[index]);
    let levels = Levels::evenly(&factor.levels, factor.numbers.is_some());
    let title = format!("How often each rating was given by {}", names::factor(results, &factor.name));
    let caption = format!("Proportions of the ratings; {}.", labels::sample(results));
    let color = |index: usize| category(index, counts.categories.len());
    // The highest category is on top.
    let named = evenly(counts.categories.len(), MAX_NAMED).into_iter().rev();
    let series = named.map(|index| {
        (Series { color: color(index), marker: Marker::Square, dash: None }, counts.categories[index].as_str())
    });
    let series: Vec<(Series, &str)> = series.collect();
    let values = (Values::between(0.0, 100.0), "Ratings (%)");
    let axis = (&levels, &*names::axis(results, &factor.name));
    Some(chart("proportions", [title, caption], values, axis, ("Rating", &series, false), |svg, panel| {
        let half = 0.4 * levels.gap() * panel.width();
        for (at, level) in levels.at.iter().zip(&factor.levels) {
            let own = groups.iter().find(|group| group.names[0] == *level);
            let Some(summary) = own.map(|group| &group.summary) else { continue };
            let (x, mut from) = (panel.x(*at), 0.0);
            for (index, share) in summary.proportions.iter().enumerate().filter(|(_, share)| **share > 0.0) {
                let (name, to) = (labels::level(&counts.categories[index]), from + 100.0 * share);
                let text = format!("{name}: {} of {} ratings", whole_percent(*share), summary.n);
                svg.bar((x - half, panel.y(to)), (x + half, panel.y(from)), color(index), text);
                from = to;
            }
        }
    }))
}
