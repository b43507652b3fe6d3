//! Combines the information from a study's sidecars: who rated, on which screen, and what differs between sittings.

use std::collections::{BTreeMap, BTreeSet};

use super::exclusions;
use crate::{
    analysis::Results,
    report::document::numbers::fixed,
    store::{
        ratings::{SessionRead, Source},
        sidecar::Sitting,
    },
};

/// Returns every sitting of the participants who were not excluded, with its session.
pub(super) fn all<'a>(source: &'a Source, results: &Results) -> impl Iterator<Item = (&'a SessionRead, &'a Sitting)> {
    exclusions::sessions(source, results).flat_map(|session| sittings(session).map(move |sitting| (session, sitting)))
}

fn sittings(session: &SessionRead) -> impl Iterator<Item = &Sitting> {
    session.sidecar.iter().flat_map(|sidecar| &sidecar.sittings)
}

/// True if any ratings of a session come from a program instead of a person.
pub(super) fn is_simulated(session: &SessionRead) -> bool {
    sittings(session).any(|sitting| sitting.observer.is_some())
}

/// Returns the analyzed participants who have any ratings from a program.
pub(super) fn simulated<'a>(source: &'a Source, results: &Results) -> BTreeSet<&'a str> {
    let subjects = &results.measured.counts.subjects;
    let sessions =
        source.sessions.iter().filter(|session| is_simulated(session) && subjects.contains(&session.subject));
    sessions.map(|session| session.subject.as_str()).collect()
}

/// Returns the first and the last day on which a sitting began, such as `2026-11-21`.
pub(super) fn days<'a>(source: &'a Source, results: &Results) -> Option<(&'a str, &'a str)> {
    let days: BTreeSet<&str> = all(source, results).filter_map(|(_, sitting)| sitting.started_at.get(..10)).collect();
    Some((days.first()?, days.last()?))
}

/// Returns the settings that may differ between sittings, with the number of sittings for each value. A setting that no
/// sitting recorded is omitted.
pub(super) fn properties(source: &Source, results: &Results) -> Vec<(&'static str, Vec<(String, usize)>)> {
    type Value = fn(&Sitting) -> Option<String>;
    let values_of: [(&'static str, Value); 7] = [
        ("program", program),
        ("observer", observer),
        ("display profile", display),
        ("monitor", monitor),
        ("viewing distance", |s| Some(format!("{} cm", trimmed(s.viewing.as_ref()?["distance_cm"].as_f64()?, 1)))),
        ("stimulus", stimulus),
        ("median frame interval", |s| Some(format!("{} ms", fixed(1e3 * s.frames.as_ref()?["median_s"].as_f64()?, 1)))),
    ];
    (values_of.into_iter())
        .filter_map(|(name, value_of)| {
            let mut values: BTreeMap<Option<String>, usize> = BTreeMap::new();
            for (_, sitting) in all(source, results) {
                *values.entry(value_of(sitting)).or_default() += 1;
            }
            let recorded = values.keys().any(Option::is_some);
            let value = |value: Option<String>| value.unwrap_or_else(|| "not recorded".to_owned());
            recorded.then(|| (name, values.into_iter().map(|(v, n)| (value(v), n)).collect()))
        })
        .collect()
}

fn program(sitting: &Sitting) -> Option<String> {
    let program = &sitting.program;
    let commit: String = program.commit.chars().take(10).collect();
    Some(format!("{} {} (commit {commit})", program.name, program.version))
}

fn observer(sitting: &Sitting) -> Option<String> {
    let name = sitting.observer.as_ref().map(|observer| observer["observer"].as_str().unwrap_or("by a program"));
    Some(name.map_or_else(|| "a person".to_owned(), |name| format!("simulated: {name}")))
}

fn display(sitting: &Sitting) -> Option<String> {
    let display = sitting.display.as_ref()?;
    let measured = match &display["measured"] {
        measured if measured.is_null() => "not measured".to_owned(),
        measured => format!("measured {}", measured.as_str().map_or_else(|| measured.to_string(), str::to_owned)),
    };
    let parts = [display["name"].as_str(), display["transfer"].as_str(), Some(&measured)];
    Some(parts.into_iter().flatten().collect::<Vec<_>>().join(", "))
}

fn monitor(sitting: &Sitting) -> Option<String> {
    let monitor = sitting.monitor.as_ref()?;
    let name = monitor["name"].as_str().unwrap_or("without a name");
    let size = monitor["width_px"].as_f64().zip(monitor["height_px"].as_f64());
    let size = size.map(|(width, height)| format!(", {width} × {height} pixels")).unwrap_or_default();
    let refresh = monitor["refresh_hz"].as_f64().map(|hz| format!(", {} Hz", trimmed(hz, 2))).unwrap_or_default();
    Some(format!("{name}{size}{refresh}"))
}

fn stimulus(sitting: &Sitting) -> Option<String> {
    let viewing = sitting.viewing.as_ref()?;
    let (deg, px) = (trimmed(viewing["stimulus_deg"].as_f64()?, 2), viewing["stimulus_px"].as_f64()?);
    let windowed = if viewing["windowed"] == true { ", in a window" } else { "" };
    Some(format!("{deg}° in {px} pixels{windowed}"))
}

/// Rounds a number to at most this many decimals.
fn trimmed(number: f64, decimals: i32) -> f64 {
    let scale = 10_f64.powi(decimals);
    (number * scale).round() / scale
}
