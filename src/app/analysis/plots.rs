//! The plots, drawn.

use std::collections::HashMap;

use eframe::egui::{self, Color32, Rangef, Stroke, Vec2};
use egui_plot::{AxisHints, Bar, BarChart, GridMark, HoverPosition, Line, MarkerShape, Plot, PlotUi, Points, VLine};

use super::{
    charts::{Chart, Drawing, Lines, Series, Sort, Stacks},
    look, words,
};
use crate::app::{
    theme,
    ui::theme::{MARKERS, SERIES as COLORS},
};

/// Most points of a plot's sides.
const LARGEST: Vec2 = Vec2::new(1200.0, 760.0);
/// Least height; below it, the view scrolls.
const LEAST: f32 = 190.0;
/// From this many series on a legend would be longer than the plot.
const MOST_NAMED: usize = 24;
/// Width of a bar, of the distance of two.
const BAR: f64 = 0.8;
/// Between the names of two places, points.
const LABEL_GAP: f32 = 10.0;

/// Which plot is looked at.
#[derive(Clone, Copy, Debug, Default)]
pub struct Chosen {
    sort: usize,
    by: usize,
}

/// Draws the choice and the chosen plot.
pub fn show(ui: &mut egui::Ui, sorts: &[Sort], chosen: &mut Chosen, narrow: bool) {
    let names: Vec<&str> = sorts.iter().map(|sort| sort.name.as_str()).collect();
    let mut choices = |ui: &mut egui::Ui| {
        look::choice(ui, "Plot", &mut chosen.sort, &names, narrow);
        let Some(sort) = sorts.get(chosen.sort) else { return };
        let by: Vec<&str> = sort.charts.iter().map(|(by, _)| by.as_str()).collect();
        chosen.by = chosen.by.min(by.len().saturating_sub(1));
        if by.len() > 1 {
            look::choice(ui, "Plotted by", &mut chosen.by, &by, narrow);
        }
    };
    if narrow {
        ui.horizontal_wrapped(&mut choices).inner
    } else {
        choices(ui)
    }
    let chart = sorts.get(chosen.sort).and_then(|sort| sort.charts.get(chosen.by));
    let Some((_, chart)) = chart else { return };
    egui::ScrollArea::vertical().id_salt("plot").auto_shrink(false).show(ui, |ui| draw(ui, chart));
}

fn draw(ui: &mut egui::Ui, chart: &Chart) {
    look::heading(ui, &chart.title);
    look::quiet(ui, &chart.about);
    ui.add_space(2.0);
    let room = ui.available_size();
    let width = room.x.min(LARGEST.x);
    let response = match &chart.drawing {
        Drawing::Lines(lines) => {
            let named = lines.series.len() > 1 && lines.series.len() <= MOST_NAMED;
            if named {
                legend(ui, width, lines.series.iter().enumerate().map(|(i, series)| (&*series.name, mark_of(i))));
            }
            let least = if lines.sideways { 70.0 + 24.0 * lines.labels.len() as f32 } else { LEAST };
            let size = Vec2::new(width, ui.available_height().clamp(least, LARGEST.y.max(least)));
            if lines.sideways { sideways(ui, lines, size) } else { upright(ui, lines, size) }
        }
        Drawing::Stacks(stacks) => {
            let names = stacks.categories.iter().map(|(name, _)| name.as_str());
            let colors = shades(stacks.categories.len());
            legend(ui, width, names.zip(colors.into_iter().map(|color| (color, MarkerShape::Square))));
            let size = Vec2::new(width, ui.available_height().clamp(LEAST, LARGEST.y));
            stacked(ui, stacks, size)
        }
    };
    ui.ctx().accesskit_node_builder(response.id, |node| {
        node.set_role(egui::accesskit::Role::Image);
        node.set_label(format!("Plot: {}", chart.title));
    });
}

/// Colour and marker of a series. After all markers, the same colours come with other markers.
fn mark_of(index: usize) -> (Color32, MarkerShape) {
    (COLORS[index % COLORS.len()], MARKERS[(index + index / COLORS.len()) % MARKERS.len()])
}

/// Colours of ordered categories, dark to light as they rise: told apart in grey too, and by colour-blind readers
/// (after cividis: Nuñez, Anderton & Renslow 2018, PLoS ONE 13, e0199239).
fn shades(number: usize) -> Vec<Color32> {
    const ANCHORS: [[f64; 3]; 4] =
        [[58.0, 76.0, 110.0], [124.0, 123.0, 120.0], [187.0, 173.0, 108.0], [255.0, 233.0, 69.0]];
    let shade = |index: usize| {
        let at = index as f64 / (number.max(2) - 1) as f64 * 3.0;
        let below = (at.floor() as usize).min(2);
        let mix = |channel: usize| {
            let (low, high) = (ANCHORS[below][channel], ANCHORS[below + 1][channel]);
            (low + (at - below as f64) * (high - low)).round() as u8
        };
        Color32::from_rgb(mix(0), mix(1), mix(2))
    };
    (0..number).map(shade).collect()
}

/// Names with their marks, on as many lines as they need.
fn legend<'a>(ui: &mut egui::Ui, width: f32, names: impl Iterator<Item = (&'a str, (Color32, MarkerShape))>) {
    ui.allocate_ui_with_layout(
        Vec2::new(width, 0.0),
        egui::Layout::left_to_right(egui::Align::Center).with_main_wrap(true),
        |ui| {
            ui.spacing_mut().item_spacing = Vec2::new(14.0, 2.0);
            for (name, (color, shape)) in names {
                // Mark and name stay on one line.
                let text = ui.painter().layout_no_wrap(name.to_owned(), theme_small(ui), theme::QUIET);
                let (rect, response) =
                    ui.allocate_exact_size(Vec2::new(20.0 + text.size().x, 20.0), egui::Sense::hover());
                response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, name));
                mark(ui.painter(), egui::pos2(rect.left() + 7.0, rect.center().y), shape, color);
                let corner = egui::pos2(rect.left() + 20.0, rect.center().y - text.size().y / 2.0);
                ui.painter().galley(corner, text, theme::QUIET);
            }
        },
    );
}

fn theme_small(ui: &egui::Ui) -> egui::FontId {
    egui::TextStyle::Small.resolve(ui.style())
}

/// A marker as the plots draw it.
fn mark(painter: &egui::Painter, center: egui::Pos2, shape: MarkerShape, color: Color32) {
    const R: f32 = 5.0;
    let at = |x: f32, y: f32| center + Vec2::new(x, y) * R;
    let filled = |points: Vec<egui::Pos2>| egui::Shape::convex_polygon(points, color, Stroke::NONE);
    let stroke = Stroke::new(1.5, color);
    match shape {
        MarkerShape::Square => {
            _ = painter.add(filled(vec![at(-0.8, -0.8), at(0.8, -0.8), at(0.8, 0.8), at(-0.8, 0.8)]))
        }
        MarkerShape::Diamond => _ = painter.add(filled(vec![at(0.0, -1.0), at(1.0, 0.0), at(0.0, 1.0), at(-1.0, 0.0)])),
        MarkerShape::Up => _ = painter.add(filled(vec![at(0.0, -1.0), at(0.87, 0.5), at(-0.87, 0.5)])),
        MarkerShape::Down => _ = painter.add(filled(vec![at(0.0, 1.0), at(-0.87, -0.5), at(0.87, -0.5)])),
        MarkerShape::Cross => {
            painter.line_segment([at(-0.7, -0.7), at(0.7, 0.7)], stroke);
            painter.line_segment([at(-0.7, 0.7), at(0.7, -0.7)], stroke);
        }
        MarkerShape::Plus => {
            painter.line_segment([at(-1.0, 0.0), at(1.0, 0.0)], stroke);
            painter.line_segment([at(0.0, -1.0), at(0.0, 1.0)], stroke);
        }
        _ => _ = painter.circle_filled(center, R, color),
    }
}

/// A plot that stays as it is: what is on the page scrolls with it.
fn still<'a>(id: &str, size: Vec2) -> Plot<'a> {
    Plot::new(id.to_owned())
        .width(size.x)
        .height(size.y)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .allow_double_click_reset(false)
        .show_crosshair(false)
        .grid_color(Color32::from_gray(0x4c))
        .set_margin_fraction(Vec2::new(0.02, 0.0))
}

/// An axis of places by name.
fn place_axis<'a>(hints: AxisHints<'a>, name: &str, labels: &[String]) -> AxisHints<'a> {
    let labels = labels.to_vec();
    // The marks are far enough from each other as they are set.
    hints
        .label(name.to_owned())
        .formatter(move |mark, _| label_at(&labels, mark.value))
        .label_spacing(Rangef::new(1.0, 2.0))
}

/// An axis of values, whose marks are this far apart.
fn value_axis<'a>(hints: AxisHints<'a>, name: &str, step: f64) -> AxisHints<'a> {
    let decimals = (-step.log10().floor()).max(0.0) as usize;
    hints
        .label(name.to_owned())
        .formatter(move |mark, _| words::fixed(mark.value, decimals))
        .label_spacing(Rangef::new(1.0, 2.0))
}

/// The distance of marks, 1, 2 or 5 times a power of ten, of which there are at most so many.
fn step_between([low, high]: [f64; 2], most: f64) -> f64 {
    let least = (high - low).max(1e-9) / most.max(1.0);
    let power = 10_f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power).into_iter().find(|step| *step >= least).unwrap_or(10.0 * power)
}

/// Marks at multiples of a step.
fn multiples([low, high]: [f64; 2], step: f64) -> Vec<GridMark> {
    let (first, last) = ((low / step).ceil() as i64, (high / step).floor() as i64);
    (first..=last).map(|i| GridMark { value: i as f64 * step, step_size: step }).collect()
}

/// Marks at whole numbers, as many as there are places; of many, one in so many that the names do not touch.
fn places(labels: &[String], step: usize) -> Vec<GridMark> {
    (0..labels.len()).step_by(step).map(|i| GridMark { value: i as f64, step_size: step as f64 }).collect()
}

/// How many places a name takes along an axis of a width.
fn label_step(ui: &egui::Ui, labels: &[String], width: f32) -> usize {
    let font = egui::TextStyle::Body.resolve(ui.style());
    // The longest by letters is near enough the longest on the screen.
    let longest = labels.iter().max_by_key(|label| label.chars().count()).cloned().unwrap_or_default();
    let needed = ui.painter().layout_no_wrap(longest, font, theme::QUIET).size().x + LABEL_GAP;
    let room = (width - 80.0).max(1.0) / labels.len().max(1) as f32;
    (needed / room).ceil().max(1.0) as usize
}

fn label_at(labels: &[String], value: f64) -> String {
    let index = value.round();
    let whole = index >= 0.0 && (value - index).abs() < 1e-6;
    labels.get(index as usize).filter(|_| whole).cloned().unwrap_or_default()
}

/// How far a series stands beside its place, so that intervals do not hide each other.
fn shift(index: usize, number: usize) -> f64 {
    let step = (0.4 / number.max(1) as f64).min(0.07);
    (index as f64 - (number as f64 - 1.0) / 2.0) * step
}

/// The least and the greatest value that is to be seen, and a little more.
fn reach(lines: &Lines) -> [f64; 2] {
    let ends = (lines.series.iter().flat_map(|series| &series.points))
        .flat_map(|point| {
            [point.interval.map_or(point.value, |i| i.low), point.interval.map_or(point.value, |i| i.high)]
        })
        .chain(lines.range.into_iter().flat_map(|(low, high)| [low, high]));
    let (low, high) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), end| (l.min(end), h.max(end)));
    if low > high {
        return [0.0, 1.0];
    }
    let more = 0.04 * (high - low).max(1e-6);
    [low - more, high + more]
}

/// What the mouse is told at each point.
fn hover_words(lines: &Lines) -> HashMap<String, Vec<String>> {
    let words = |series: &Series| {
        let place = |place: usize| format!("{} {}", lines.places, lines.labels[place]).trim().to_owned();
        let name = if series.name.is_empty() { String::new() } else { format!("{}, ", series.name) };
        (series.points.iter())
            .map(|point| match lines.sideways {
                true => point.words.clone(),
                false => format!("{name}{}: {}", place(point.place), point.words),
            })
            .collect()
    };
    lines.series.iter().map(|series| (series.name.clone(), words(series))).collect()
}

/// The words at a point; nothing elsewhere.
fn hovered(words: &HashMap<String, Vec<String>>, position: &HoverPosition<'_>) -> Option<String> {
    match position {
        HoverPosition::NearDataPoint { plot_name, index, .. } => words.get(*plot_name)?.get(*index).cloned(),
        HoverPosition::Elsewhere { .. } => None,
    }
}

fn upright(ui: &mut egui::Ui, lines: &Lines, size: Vec2) -> egui::Response {
    let ends = reach(lines);
    let every = step_between(ends, f64::from(size.y) / 60.0);
    let labels = lines.labels.clone();
    let step = label_step(ui, &labels, size.x);
    let last = labels.len().saturating_sub(1) as f64;
    let words = hover_words(lines);
    let plot = still("upright", size)
        .include_x(-0.4)
        .include_x(last + 0.4)
        .include_y(ends[0])
        .include_y(ends[1])
        .custom_x_axes(vec![place_axis(AxisHints::new_x(), &lines.places, &labels)])
        .custom_y_axes(vec![value_axis(AxisHints::new_y(), &lines.values, every)])
        .y_grid_spacer(move |_| multiples(ends, every))
        .x_grid_spacer(move |_| places(&labels, step))
        .label_formatter(move |position| hovered(&words, position));
    let number = lines.series.len();
    let beside = lines.series.iter().flat_map(|series| &series.points).any(|point| point.interval.is_some());
    plot.show(ui, |plot| {
        for (index, series) in lines.series.iter().enumerate() {
            let (color, marker) = mark_of(index);
            let at = |place: usize| place as f64 + if beside { shift(index, number) } else { 0.0 };
            for point in &series.points {
                let Some(interval) = point.interval else { continue };
                let x = at(point.place);
                bar(plot, [[x, interval.low], [x, interval.high]], color);
            }
            let points: Vec<[f64; 2]> = series.points.iter().map(|point| [at(point.place), point.value]).collect();
            if lines.joined {
                let thin = if number > MOST_NAMED { 1.0 } else { 2.0 };
                let line = Line::new(series.name.clone(), points.clone()).color(color).width(thin);
                plot.line(line.allow_hover(false));
            }
            plot.points(Points::new(series.name.clone(), points).shape(marker).radius(5.0).color(color));
        }
    })
    .response
}

fn sideways(ui: &mut egui::Ui, lines: &Lines, size: Vec2) -> egui::Response {
    let ends = reach(lines);
    let every = step_between(ends, f64::from(size.x) / 90.0);
    let labels = lines.labels.clone();
    let number = labels.len();
    let words = hover_words(lines);
    // The first on top.
    let at = move |place: usize| (number - 1 - place) as f64;
    let names: Vec<String> = labels.iter().rev().cloned().collect();
    let plot = still("sideways", size)
        .include_y(-0.6)
        .include_y(number as f64 - 0.4)
        .include_x(ends[0])
        .include_x(ends[1])
        .custom_x_axes(vec![value_axis(AxisHints::new_x(), &lines.values, every)])
        .x_grid_spacer(move |_| multiples(ends, every))
        .custom_y_axes(vec![place_axis(AxisHints::new_y(), &lines.places, &names)])
        .y_grid_spacer(move |_| places(&names, 1))
        .label_formatter(move |position| hovered(&words, position));
    plot.show(ui, |plot| {
        plot.vline(VLine::new("none", 0.0).color(theme::QUIET).width(1.0).allow_hover(false));
        for (index, series) in lines.series.iter().enumerate() {
            let (color, marker) = mark_of(index);
            for point in &series.points {
                let Some(interval) = point.interval else { continue };
                let y = at(point.place);
                bar(plot, [[interval.low, y], [interval.high, y]], color);
            }
            let points: Vec<[f64; 2]> = series.points.iter().map(|point| [point.value, at(point.place)]).collect();
            plot.points(Points::new(series.name.clone(), points).shape(marker).radius(5.0).color(color));
        }
    })
    .response
}

/// An interval.
fn bar(plot: &mut PlotUi<'_>, ends: [[f64; 2]; 2], color: Color32) {
    plot.line(Line::new("interval", ends.to_vec()).color(color).width(1.5).allow_hover(false));
}

fn stacked(ui: &mut egui::Ui, stacks: &Stacks, size: Vec2) -> egui::Response {
    let labels = stacks.labels.clone();
    let step = label_step(ui, &labels, size.x);
    let last = labels.len().saturating_sub(1) as f64;
    let colors = shades(stacks.categories.len());
    let plot = still("stacked", size)
        .include_x(-0.6)
        .include_x(last + 0.6)
        .include_y(0.0)
        .include_y(1.0)
        .custom_x_axes(vec![place_axis(AxisHints::new_x(), &stacks.places, &labels)])
        .custom_y_axes(vec![value_axis(AxisHints::new_y(), "proportion", 0.2)])
        .y_grid_spacer(|_| multiples([0.0, 1.0], 0.2))
        .x_grid_spacer(move |_| places(&labels, step))
        .label_formatter(|_| None);
    let shown = plot.show(ui, |plot| {
        let mut charts: Vec<BarChart> = Vec::new();
        for ((_, shares), color) in stacks.categories.iter().zip(colors) {
            let bar =
                |(i, &share): (usize, &f64)| Bar::new(i as f64, share).width(BAR).fill(color).stroke(Stroke::NONE);
            let chart = BarChart::new("stack", shares.iter().enumerate().map(bar).collect()).allow_hover(false);
            let below: Vec<&BarChart> = charts.iter().collect();
            charts.push(chart.stack_on(&below));
        }
        for chart in charts {
            plot.bar_chart(chart);
        }
    });
    let at = shown.response.hover_pos().map(|pos| shown.transform.value_from_position(pos));
    match at.and_then(|at| share_words(stacks, at.x, at.y)) {
        Some(words) => shown.response.on_hover_text_at_pointer(words),
        None => shown.response,
    }
}

/// What the bar at these coordinates says.
fn share_words(stacks: &Stacks, x: f64, y: f64) -> Option<String> {
    let place = x.round();
    let label = stacks.labels.get(place as usize).filter(|_| place >= 0.0 && (x - place).abs() <= BAR / 2.0)?;
    let mut top = 0.0;
    let (category, shares) = stacks.categories.iter().find(|(_, shares)| {
        top += shares[place as usize];
        (0.0..=top).contains(&y)
    })?;
    let percent = words::fixed(100.0 * shares[place as usize], 1);
    Some(format!("{} {label}: {percent} % rated {category}", stacks.places))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_round_and_not_too_many() {
        for (ends, most, step) in [([-0.12, 3.12], 8.0, 0.5), ([-5.3, 1.5], 4.0, 2.0), ([0.0, 1.0], 5.0, 0.2)] {
            assert_eq!(step_between(ends, most), step, "{ends:?}");
            let marks = multiples(ends, step);
            assert!((2..=most as usize + 1).contains(&marks.len()));
            assert!(marks.iter().all(|mark| ends[0] - 1e-9 <= mark.value && mark.value <= ends[1] + 1e-9));
        }
        assert_eq!(multiples([0.0, 1.0], 0.2).len(), 6);
    }

    #[test]
    fn a_bar_says_what_is_under_the_mouse() {
        let stacks = Stacks {
            places: "width".to_owned(),
            labels: ["0.1", "0.2"].map(str::to_owned).to_vec(),
            categories: vec![("0".to_owned(), vec![0.25, 0.0]), ("1".to_owned(), vec![0.75, 1.0])],
        };
        let words = |x, y| share_words(&stacks, x, y);
        assert_eq!(words(0.3, 0.2).as_deref(), Some("width 0.1: 25.0 % rated 0"));
        assert_eq!(words(-0.3, 0.3).as_deref(), Some("width 0.1: 75.0 % rated 1"));
        assert_eq!(words(1.0, 0.3).as_deref(), Some("width 0.2: 100.0 % rated 1"));
        assert_eq!([words(0.5, 0.2), words(0.0, 1.1), words(0.0, -0.1), words(2.0, 0.5)], [None, None, None, None]);
    }

    #[test]
    fn series_and_categories_differ() {
        let looks: Vec<_> = (0..MOST_NAMED).map(mark_of).collect();
        assert!((1..looks.len()).all(|i| !looks[..i].contains(&looks[i])));
        for number in 1..12 {
            let light: Vec<u32> =
                shades(number).iter().map(|c| c.to_array()[..3].iter().map(|&v| u32::from(v)).sum()).collect();
            assert!(light.windows(2).all(|pair| pair[0] < pair[1]), "{light:?}");
        }
    }
}
