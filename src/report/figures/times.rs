//! Response times: median and quartiles by rating, and by subject.

use super::{
    Figure,
    axes::{EDGE, Levels, PANEL, Panel, Values, below},
    labels as text,
    palette::{Look, MARKER},
    svg::{Canvas, Drawn, Stroke, WIDTH, drawing},
};
use crate::analysis::{Results, counts::Factor, numbers_of, times::Quartiles};

/// `times`, where response times are known.
pub(super) fn figures(results: &Results) -> Vec<Figure> {
    figure(results).into_iter().collect()
}

fn figure(results: &Results) -> Option<Figure> {
    let subjects: Vec<Option<Quartiles>> = results.subjects.iter().map(|subject| subject.times).collect();
    let n: u64 = results.times.iter().flatten().map(|quartiles| quartiles.n).sum();
    if n == 0 {
        return None;
    }
    let several = results.is_inferential();
    let title = if several { "Response times by rating and by subject" } else { "Response times by rating" }.to_owned();
    let caption = format!(
        "Time from the band's onset to the rating: median, and the middle half of the times as bars, by \
         rating{}; {}, {}.",
        if several { " and by subject" } else { "" },
        text::number(results.people() as u64, "subject"),
        text::number(n, "response time"),
    );
    let svg = svg(results, &subjects, &title, &caption)?;
    Some(Figure { name: "times", title, caption, wide: false, svg })
}

fn svg(results: &Results, subjects: &[Option<Quartiles>], title: &str, caption: &str) -> Option<String> {
    let counts = &results.measured.counts;
    let several = results.is_inferential();
    let drawn = || results.times.iter().chain(if several { subjects } else { &[] }).flatten();
    let values = Values::from_zero(drawn().map(|quartiles| quartiles.upper).fold(0.0, f64::max));
    let left = values.margin();
    let full = WIDTH - EDGE - left;
    let gap = 36.0;
    let right = if several { left + 0.42 * full } else { left + full };
    let panel = Panel { left, right, top: EDGE, bottom: EDGE + PANEL, low: values.low, high: values.high };
    let beside = Panel { left: right + gap, right: left + full, ..panel };
    // Names in order, evenly, though they may be numbers.
    let even = |names: &[String]| {
        Levels::of(&Factor { name: "depth".to_owned(), numbers: numbers_of(names), levels: names.to_vec() })
    };
    let (ratings, people) = (even(&counts.categories), even(&counts.subjects));
    let (below_ratings, below_people) = (ratings.labels(panel.width()), people.labels(beside.width()));
    let height = if several { below_ratings.height.max(below_people.height) } else { below_ratings.height };
    drawing(panel.bottom + below(height), title, caption, |canvas| {
        values.draw(canvas, &panel, Some("Response time (s)"))?;
        ratings.draw(canvas, &panel, &below_ratings, "Rating")?;
        quartiles(canvas, &panel, &ratings, &results.times)?;
        if several {
            values.draw(canvas, &beside, None)?;
            people.draw(canvas, &beside, &below_people, "Subject")?;
            quartiles(canvas, &beside, &people, subjects)?;
        }
        Ok(())
    })
}

/// The middle half of the times as a bar, with the median.
fn quartiles(canvas: &Canvas<'_>, panel: &Panel, levels: &Levels, times: &[Option<Quartiles>]) -> Drawn {
    let look = Look::only();
    let room = levels.gap() * panel.width();
    let (bar, radius) = ((0.3 * room).clamp(1.0, 12.0), (0.4 * room).clamp(1.5, MARKER));
    for (&at, times) in levels.at.iter().zip(times) {
        let Some(times) = times else { continue };
        let x = panel.x(at);
        let ends = [(x, panel.y(times.lower)), (x, panel.y(times.upper))];
        canvas.line(&ends, Stroke { alpha: 0.45, ..Stroke::new(look.colour, bar) })?;
        canvas.marker((x, panel.y(times.median)), radius, look)?;
    }
    Ok(())
}
