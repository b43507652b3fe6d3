//! The plots, drawn.

use std::collections::HashMap;

use eframe::egui::{self, Color32, Stroke, Vec2};
use egui_plot::{Bar, BarChart, GridMark, HoverPosition, Line, MarkerShape, Plot, PlotUi, Points, VLine};

use super::{
    charts::{Chart, Drawing, Lines, Series, Sort, Stacks},
    look,
};
use crate::app::{
    finish::{COLORS, MARKERS},
    theme,
};

/// Most points of a plot's sides.
const LARGEST: Vec2 = Vec2::new(1200.0, 760.0);
/// Least height; below it, the view scrolls.
const LEAST: f32 = 240.0;
/// From this many series on a legend would be longer than the plot.
const MOST_NAMED: usize = 24;
/// Between the names of two places, points.
const LABEL_GAP: f32 = 10.0;

/// Which plot is looked at.
#[derive(Clone, Copy, Debug, Default)]
pub struct Chosen {
    sort: usize,
    by: usize,
}

/// Draws the choice and the chosen plot.
pub fn show(ui: &mut egui::Ui, sorts: &[Sort], chosen: &mut Chosen) {
    chosen.sort = chosen.sort.min(sorts.len().saturating_sub(1));
    look::chips(ui, &mut chosen.sort, sorts.iter().map(|sort| sort.name.as_str()));
    let Some(sort) = sorts.get(chosen.sort) else { return };
    chosen.by = chosen.by.min(sort.charts.len().saturating_sub(1));
    if sort.charts.len() > 1 {
        look::chips(ui, &mut chosen.by, sort.charts.iter().map(|(by, _)| by.as_str()));
    }
    let Some((_, chart)) = sort.charts.get(chosen.by) else { return };
    ui.add_space(4.0);
    egui::ScrollArea::vertical().id_salt("plot").auto_shrink(false).show(ui, |ui| draw(ui, chart));
}

fn draw(ui: &mut egui::Ui, chart: &Chart) {
    look::heading(ui, &chart.title);
    look::quiet(ui, &chart.about);
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
}

/// Marks at whole numbers, as many as there are places; of many, one in so many that the names do not touch.
fn places(labels: &[String], step: usize) -> Vec<GridMark> {
    (0..labels.len()).step_by(step).map(|i| GridMark { value: i as f64, step_size: 1.0 }).collect()
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
    let labels = lines.labels.clone();
    let step = label_step(ui, &labels, size.x);
    let last = labels.len().saturating_sub(1) as f64;
    let words = hover_words(lines);
    let mut plot = still("upright", size)
        .include_x(-0.4)
        .include_x(last + 0.4)
        .x_axis_label(lines.places.clone())
        .y_axis_label(lines.values.clone())
        .x_grid_spacer({
            let labels = labels.clone();
            move |_| places(&labels, step)
        })
        .x_axis_formatter(move |mark, _| label_at(&labels, mark.value))
        .label_formatter(move |position| hovered(&words, position));
    if let Some((low, high)) = lines.range {
        plot = plot.include_y(low - 0.03 * (high - low)).include_y(high + 0.03 * (high - low));
    }
    plot.show(ui, |plot| {
        let number = lines.series.len();
        for (index, series) in lines.series.iter().enumerate() {
            let (color, marker) = mark_of(index);
            let at = |place: usize| place as f64 + shift(index, number);
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
    let labels = lines.labels.clone();
    let number = labels.len();
    let words = hover_words(lines);
    // The first on top.
    let at = move |place: usize| (number - 1 - place) as f64;
    let names: Vec<String> = labels.iter().rev().cloned().collect();
    let mut plot = still("sideways", size)
        .include_y(-0.6)
        .include_y(number as f64 - 0.4)
        .x_axis_label(lines.values.clone())
        .y_grid_spacer({
            let names = names.clone();
            move |_| places(&names, 1)
        })
        .y_axis_formatter(move |mark, _| label_at(&names, mark.value))
        .label_formatter(move |position| hovered(&words, position));
    if let Some((low, high)) = lines.range {
        plot = plot.include_x(low).include_x(high);
    }
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
        .x_axis_label(stacks.places.clone())
        .y_axis_label("proportion")
        .x_grid_spacer({
            let labels = labels.clone();
            move |_| places(&labels, step)
        })
        .x_axis_formatter({
            let labels = labels.clone();
            move |mark, _| label_at(&labels, mark.value)
        });
    plot.show(ui, |plot| {
        let mut charts: Vec<BarChart> = Vec::new();
        for ((category, shares), color) in stacks.categories.iter().zip(colors) {
            let bars = shares.iter().enumerate().map(|(i, &share)| Bar::new(i as f64, share).width(0.8)).collect();
            let (category, places, labels) = (category.clone(), stacks.places.clone(), labels.clone());
            let words = move |bar: &Bar, _: &BarChart| {
                let place = label_at(&labels, bar.argument);
                format!("{places} {place}: {:.1} % rated {category}", 100.0 * bar.value)
            };
            let chart = BarChart::new("stack", bars).color(color).element_formatter(Box::new(words));
            let below: Vec<&BarChart> = charts.iter().collect();
            charts.push(chart.stack_on(&below));
        }
        for chart in charts {
            plot.bar_chart(chart);
        }
    })
    .response
}
