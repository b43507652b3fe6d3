//! What the sidecars of a study say together: who rated, on what, and what differs between sittings.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::Value as Json;

use crate::{
    report::document::numbers::fixed,
    store::{
        ratings::{SessionRead, Source},
        sidecar::{PreflightNote, Sitting},
    },
};

/// Something that sittings may have in common.
pub(super) struct Property {
    /// What.
    pub name: &'static str,
    /// Its values, each with the number of sittings.
    pub values: Vec<(String, usize)>,
}

/// Every sitting with its session.
pub(super) fn all(source: &Source) -> impl Iterator<Item = (&SessionRead, &Sitting)> {
    source.sessions.iter().flat_map(|session| {
        session.sidecar.iter().flat_map(|sidecar| &sidecar.sittings).map(move |sitting| (session, sitting))
    })
}

/// Whether a program, and not a person, gave ratings of a session.
pub(super) fn is_simulated(session: &SessionRead) -> bool {
    session.sidecar.iter().flat_map(|sidecar| &sidecar.sittings).any(|sitting| sitting.observer.is_some())
}

/// Subjects whose ratings a program gave, in whole or in part.
pub(super) fn simulated(source: &Source) -> Vec<String> {
    let names: BTreeSet<&str> =
        source.sessions.iter().filter(|session| is_simulated(session)).map(|s| s.subject.as_str()).collect();
    names.into_iter().map(str::to_owned).collect()
}

/// What is the same in all sittings, and what is not; only what any of them records.
pub(super) fn properties(source: &Source) -> Vec<Property> {
    type Value = fn(&Sitting) -> Option<String>;
    let values_of: [(&'static str, Value); 7] = [
        ("program", program),
        ("observer", observer),
        ("display profile", display),
        ("monitor", monitor),
        ("viewing distance", |s| Some(format!("{} cm", trimmed(number(s.viewing.as_ref()?, "distance_cm")?, 1)))),
        ("stimulus", stimulus),
        ("median frame interval", |s| Some(format!("{} ms", fixed(1e3 * number(s.frames.as_ref()?, "median_s")?, 1)))),
    ];
    (values_of.into_iter())
        .filter_map(|(name, value_of)| {
            let mut values: BTreeMap<Option<String>, usize> = BTreeMap::new();
            for (_, sitting) in all(source) {
                *values.entry(value_of(sitting)).or_default() += 1;
            }
            let recorded = values.keys().any(Option::is_some);
            let value = |value: Option<String>| value.unwrap_or_else(|| "not recorded".to_owned());
            recorded.then(|| Property { name, values: values.into_iter().map(|(v, n)| (value(v), n)).collect() })
        })
        .collect()
}

/// Problems found by checks before sessions, each sentence with the number of sittings.
pub(super) fn preflight(source: &Source) -> Vec<(String, usize)> {
    let mut sentences: BTreeMap<&str, usize> = BTreeMap::new();
    for note in all(source).flat_map(|(_, sitting)| &sitting.preflight).filter(|note: &&PreflightNote| !note.ok) {
        *sentences.entry(note.sentence.as_str()).or_default() += 1;
    }
    sentences.into_iter().map(|(sentence, n)| (sentence.to_owned(), n)).collect()
}

/// What was repaired or moved while sessions ran.
pub(super) fn incidents(source: &Source) -> Vec<String> {
    all(source)
        .flat_map(|(session, sitting)| {
            let who = |incident| format!("{}, session {}: {incident}", session.subject, session.session);
            sitting.incidents.iter().map(who)
        })
        .collect()
}

/// The first and the last day on which a sitting began, `2026-11-21`.
pub(super) fn days(source: &Source) -> Option<(String, String)> {
    let day = |(_, sitting): (_, &Sitting)| sitting.started_at.get(..10).map(str::to_owned);
    let days: BTreeSet<String> = all(source).filter_map(day).collect();
    Some((days.first()?.clone(), days.last()?.clone()))
}

fn program(sitting: &Sitting) -> Option<String> {
    let program = &sitting.program;
    let commit: String = program.commit.chars().take(10).collect();
    Some(format!("{} {} (commit {commit})", program.name, program.version))
}

fn observer(sitting: &Sitting) -> Option<String> {
    Some(match &sitting.observer {
        None => "a person".to_owned(),
        Some(observer) => match observer.get("observer").and_then(Json::as_str) {
            Some(name) => format!("simulated: {name}"),
            None => "simulated".to_owned(),
        },
    })
}

fn display(sitting: &Sitting) -> Option<String> {
    let display = sitting.display.as_ref()?;
    let text = |key: &str| display.get(key).and_then(Json::as_str);
    let measured = match display.get("measured").filter(|measured| !measured.is_null()) {
        Some(measured) => format!("measured {}", measured.as_str().map_or_else(|| measured.to_string(), str::to_owned)),
        None => "not measured".to_owned(),
    };
    let parts = [text("name"), text("transfer"), Some(measured.as_str())];
    Some(parts.into_iter().flatten().collect::<Vec<_>>().join(", "))
}

fn monitor(sitting: &Sitting) -> Option<String> {
    let monitor = sitting.monitor.as_ref()?;
    let name = monitor.get("name").and_then(Json::as_str).unwrap_or("without a name");
    let size = number(monitor, "width_px").zip(number(monitor, "height_px"));
    let size = size.map(|(width, height)| format!(", {width} × {height} pixels")).unwrap_or_default();
    let refresh = number(monitor, "refresh_hz").map(|hz| format!(", {} Hz", trimmed(hz, 2))).unwrap_or_default();
    Some(format!("{name}{size}{refresh}"))
}

fn stimulus(sitting: &Sitting) -> Option<String> {
    let viewing = sitting.viewing.as_ref()?;
    let windowed = viewing.get("windowed").and_then(Json::as_bool) == Some(true);
    Some(format!(
        "{}° in {} pixels{}",
        trimmed(number(viewing, "stimulus_deg")?, 2),
        number(viewing, "stimulus_px")?,
        if windowed { ", in a window" } else { "" }
    ))
}

fn number(value: &Json, key: &str) -> Option<f64> {
    value.get(key).and_then(Json::as_f64)
}

/// At most so many decimals.
fn trimmed(number: f64, decimals: i32) -> f64 {
    let scale = 10_f64.powi(decimals);
    (number * scale).round() / scale
}
