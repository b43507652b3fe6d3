//! Combines the information from a study's sidecars: who rated, on which screen, and what differs between sittings.

use std::collections::{BTreeMap, BTreeSet};

use super::exclusions;
use crate::{
    analysis::Results,
    store::{
        ratings::{SessionRead, Source},
        sidecar::{SimulatedObserver, Sitting, UsedDisplay},
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

/// Returns the analyzed participants who have any ratings from a program: how many, and how many ratings they have.
pub(super) fn simulated<'a>(source: &'a Source, results: &Results) -> BTreeMap<&'a str, [u64; 2]> {
    let recorded = source.sessions.iter().filter(|session| session.sidecar.is_some());
    let of = |session: &SessionRead| [if is_simulated(session) { session.rated } else { 0 }, session.rated];
    let sessions = recorded.map(|session| (&session.subject, of(session)));
    let tables = source.files.iter().flat_map(|file| &file.simulated).map(|(subject, counts)| (subject, *counts));
    let mut all = BTreeMap::<&str, [u64; 2]>::new();
    for (subject, counts) in sessions.chain(tables) {
        all.entry(subject).or_default().iter_mut().zip(counts).for_each(|(sum, n)| *sum += n);
    }
    let subjects = &results.measured.counts.subjects;
    all.retain(|subject, [simulated, _]| *simulated > 0 && subjects.iter().any(|known| known == subject));
    all
}

/// True if all ratings of a participant in [`simulated`] come from a program.
pub(super) fn all_simulated([simulated, all]: &[u64; 2]) -> bool {
    simulated == all
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
    let values_of: [(&'static str, Value); 5] = [
        ("program", program),
        ("observer", observer),
        ("display profile", display),
        ("monitor", monitor),
        ("viewing distance", |s| Some(format!("{} cm", trimmed(s.viewing.as_ref()?.distance_cm, 1)))),
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
    let simulated = |observer: &SimulatedObserver| format!("simulated: {}", observer.name());
    Some(sitting.observer.as_ref().map_or_else(|| "a person".to_owned(), simulated))
}

fn display(sitting: &Sitting) -> Option<String> {
    let UsedDisplay { name, transfer, measured, .. } = sitting.display.as_ref()?;
    let measured = match measured {
        None => "not measured".to_owned(),
        Some(measured) => measured.on.map_or_else(|| "measured".to_owned(), |day| format!("measured {day}")),
    };
    Some(format!("{name}, {transfer}, {measured}"))
}

fn monitor(sitting: &Sitting) -> Option<String> {
    let monitor = sitting.monitor.as_ref()?;
    let refresh = monitor.refresh_hz.map(|hz| format!(", {} Hz", trimmed(hz, 2))).unwrap_or_default();
    Some(format!("{}{refresh}", monitor.title()))
}

/// Rounds a number to at most this many decimals.
fn trimmed(number: f64, decimals: i32) -> f64 {
    let scale = 10_f64.powi(decimals);
    (number * scale).round() / scale
}
