//! A chart of response times: the median and quartiles by participant, or by rating if there is only one.

use super::{figure::Figure, tasks::estimates};
use crate::{
    analysis::{Results, counts::Quartiles},
    report::document::count,
    statistics::Interval,
};

/// Draws `times`, if response times are known.
pub(super) fn figure(results: &Results) -> Option<Figure> {
    let counts = &results.measured.counts;
    let n: u64 = results.times.iter().flatten().map(|quartiles| quartiles.n).sum();
    let caption = format!(
        "Markers are medians, with bars from the lower to the upper quartile; {}, {}.",
        count(results.people() as u64, "participant"),
        count(n, "response time"),
    );
    let value = |times: Quartiles| (times.median, Some(Interval { low: times.lower, high: times.upper }));
    let (by, places, times): (_, _, Vec<Option<Quartiles>>) = if results.is_inferential() {
        ("participant", &counts.subjects, results.subjects.iter().map(|subject| subject.times).collect())
    } else {
        ("rating", &counts.categories, results.times.clone())
    };
    let series = (String::new(), times.into_iter().map(|times| times.map(value)).collect());
    estimates("times", places, &[series], (&format!("Response times by {by}"), "Response time (s)", caption))
}
