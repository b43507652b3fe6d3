//! Data quality: errors, what was excluded on request, sessions, and what differs between their sittings according to the
//! sidecars: who rated, and on which screen.

use std::collections::{BTreeMap, BTreeSet};

use super::names;
use crate::{
    analysis::{
        Results,
        counts::{Excluded, Part},
    },
    report::document::{Section, Shown, TableOf, count, fixed, list, whole},
    store::{
        ratings::{FileRead, Reason, SessionRead, Source},
        sidecar::{SimulatedObserver, Sitting, UsedDisplay},
    },
};

pub(super) fn section(source: &Source, results: &Results) -> Section {
    let mut section = Section::new("health", "Data quality");
    let sum = |of: fn(&FileRead) -> u64| whole(source.files.iter().map(of).sum());
    let facts = [
        ("Files", whole(source.files.len() as u64)),
        ("Rows below the headers", sum(|file| file.rows)),
        ("Excluded: practice", sum(|file| file.practice)),
        ("Excluded: corrected ratings", sum(|file| file.superseded)),
        ("Excluded: rows with errors", sum(|file| file.erroneous)),
        ("Rows used", sum(|file| file.counted)),
        ("Ratings in these rows", sum(|file| file.ratings)),
        ("Ratings analyzed", whole(results.measured.counts.total())),
    ];
    section.facts("Rows read and excluded", facts);
    let excluded = exclusions(source, results);
    if !excluded.is_empty() {
        section.text(excluded.join(" "));
    }
    exclusions_table(&mut section, source, results);
    section.heading("Errors");
    if source.errors.is_empty() {
        section.text("No errors were found in the files.");
    } else {
        section.text("Rows with errors were excluded; the rest was analyzed.");
        section.list(source.errors.iter().map(ToString::to_string).collect());
    }
    if !source.warnings.is_empty() {
        section.warning("These files were analyzed despite the following warnings.");
        section.list(source.warnings.iter().map(ToString::to_string).collect());
    }
    if !source.sessions.is_empty() {
        let analyzed: Vec<&SessionRead> = sessions(source, results).collect();
        let is_excluded = |session: &SessionRead| !analyzed.iter().any(|one| std::ptr::eq(*one, session));
        section.heading("Sessions");
        let known = |n: Option<u64>| n.map_or_else(|| fixed(None, 0), whole);
        TableOf::new("Sessions: trials planned and rated", &source.sessions)
            .text("Participant", |session| &session.subject)
            .text("Session", |session| &session.session)
            .text("State", |session| if is_excluded(session) { "excluded".to_owned() } else { state(session) })
            .text("Ratings by", rated_by)
            .number("Planned", |session| known(session.planned))
            .number("Rated", |session| whole(session.rated))
            .number("Trials with dropped frames", |session| known(session.dropped))
            .add_to(&mut section);
    }
    if all_sittings(source, results).next().is_some() {
        screens(&mut section, source, results);
    }
    section
}

/// Says how many of the sessions that were not excluded are known to be finished; `None` if there are none.
pub(super) fn finished_sentence(source: &Source, results: &Results) -> Option<String> {
    let sessions = sessions(source, results);
    let all = sessions.clone().count();
    let unknown = sessions.clone().filter(|session| session.planned.is_none()).count();
    let open = sessions.filter(|session| session.is_unfinished()).count();
    let are = |n: usize| if n == 1 { "is" } else { "are" };
    match (unknown, open, all) {
        (.., 0) => None,
        (0, 0, _) => Some(format!("All planned trials of {} are rated.", count(all as u64, "session"))),
        (0, ..) => Some(format!("{open} of {} {} unfinished.", count(all as u64, "session"), are(open))),
        _ => {
            let others = match all - unknown {
                0 => String::new(),
                others => format!("; of the other {others}, {open} {} unfinished", are(open)),
            };
            let unknown = count(unknown as u64, "session");
            Some(format!("It is not known how many trials were planned in {unknown}{others}."))
        }
    }
}

fn state(session: &SessionRead) -> String {
    match session.planned {
        None => "not known".to_owned(),
        Some(planned) if session.rated < planned => format!("unfinished, {} missing", whole(planned - session.rated)),
        Some(_) => "finished".to_owned(),
    }
}

fn rated_by(session: &SessionRead) -> &'static str {
    match &session.sidecar {
        None => "not known",
        Some(_) if is_simulated(session) => "a program",
        Some(_) => "a person",
    }
}

fn screens(section: &mut Section, source: &Source, results: &Results) {
    section.heading("Screens and incidents");
    // The number of sittings with each problem.
    let mut problems: BTreeMap<&str, u64> = BTreeMap::new();
    let checks = all_sittings(source, results).flat_map(|(_, sitting)| &sitting.preflight);
    for note in checks.filter(|note| !note.ok) {
        *problems.entry(&note.sentence).or_default() += 1;
    }
    if !problems.is_empty() {
        section.text("Preflight checks found these problems:");
    }
    section.list(problems.iter().map(|(text, n)| format!("{text} ({})", count(*n, "sitting"))).collect());
    let incidents: Vec<String> = all_sittings(source, results)
        .flat_map(|(session, sitting)| {
            let who = move |text| format!("{}, session {}: {text}", session.subject, session.session);
            sitting.incidents.iter().map(who)
        })
        .collect();
    if !incidents.is_empty() {
        section.text("Repairs and moves during sessions:");
        section.list(incidents);
    }
    // Differences between sittings may be confounded with differences between people.
    let properties = properties(source, results);
    let different: Vec<&str> =
        properties.iter().filter(|(_, values)| values.len() > 1).map(|(name, _)| *name).collect();
    if different.is_empty() {
        section.text("According to their sidecars, all sittings were run in the same way.");
    } else {
        let different = list(&different);
        section.warning(format!("Sittings differ in {different}, which may explain differences between participants."));
    }
    let value = |(value, n): &(String, usize)| format!("{value} ({})", count(*n as u64, "sitting"));
    TableOf::new("How the sittings were run", &properties)
        .text("Setting", |(name, _)| *name)
        .text("Value", |(_, values)| values.iter().map(value).collect::<Vec<_>>().join("; "))
        .text("Across sittings", |(_, values)| if values.len() > 1 { "differs" } else { "the same" })
        .add_to(section);
}

/// Returns a sentence for each kind of exclusion, and then how many ratings were analyzed; nothing without exclusions.
pub(super) fn exclusions(source: &Source, results: &Results) -> Vec<String> {
    let measured = &results.measured;
    let with_ratings = |name: &str, ratings: u64| format!("{name} ({})", count(ratings, "rating"));
    let (mut people, mut sentences, mut further) = (Vec::new(), Vec::new(), false);
    for Excluded { what, ratings, participants } in &measured.excluded {
        match what {
            Part::Participant(id) => people.push(with_ratings(id, *ratings)),
            Part::Levels { factor, kept } => {
                let kept: Vec<Shown> = kept.iter().map(|level| names::level(results, factor, level)).collect();
                sentences.push(format!(
                    "Only ratings at {} {} were analyzed, on request; {} at other levels {} left out.",
                    names::factor(results, factor),
                    list(&kept),
                    count(*ratings, "rating"),
                    if *ratings == 1 { "was" } else { "were" }
                ));
            }
            Part::Missing(factor) => sentences.push(format!(
                "{}{} by {} without a value of {} {} left out, because the model needs it.",
                if std::mem::replace(&mut further, true) { "A further " } else { "" },
                count(*ratings, "rating"),
                count(*participants, "participant"),
                names::factor(results, factor),
                if *ratings == 1 { "was" } else { "were" }
            )),
        }
    }
    if !people.is_empty() {
        let who = if people.len() == 1 { "Participant" } else { "Participants" };
        let were = if people.len() == 1 { "was" } else { "were" };
        sentences.insert(0, format!("{who} {} {were} left out on request.", list(&people)));
    }
    let (least, most) = source.shape.time_limits;
    for (limit, reason, than) in [(least, Reason::TooFast, "less"), (most, Reason::TooSlow, "more")] {
        sentences.extend(limit.map(|limit| {
            let (rows, people) = source.left_out(reason);
            let (rows, people) = (count(rows, "trial"), count(people as u64, "participant"));
            format!("Trials answered in {than} than {limit} s were left out on request ({rows} by {people}).")
        }));
    }
    if !sentences.is_empty() {
        sentences.push(format!(
            "All numbers are about the remaining {} by {}.",
            count(measured.counts.total(), "rating"),
            count(results.people() as u64, "participant")
        ));
    }
    sentences
}

/// Adds a table of everything that was left out and can be read: why, how much, and of how many participants.
fn exclusions_table(section: &mut Section, source: &Source, results: &Results) {
    let reasons = Reason::ALL.iter().map(|reason| (format!("rows {reason}"), source.left_out(*reason)));
    let reasons = reasons.filter(|(_, (rows, _))| *rows > 0);
    let reasons = reasons.map(|(why, (rows, people))| (why, rows, people as u64));
    let requests = results.measured.excluded.iter().map(|excluded| {
        let why = match &excluded.what {
            Part::Participant(id) => format!("ratings by {id}"),
            Part::Levels { factor, .. } => format!("ratings at other levels of {}", names::factor(results, factor)),
            Part::Missing(factor) => format!("ratings without a value of {}", names::factor(results, factor)),
        };
        (why, excluded.ratings, excluded.participants)
    });
    let rows: Vec<(String, u64, u64)> = reasons.chain(requests).collect();
    if !rows.is_empty() {
        TableOf::new("What was left out, and why", &rows)
            .text("Left out", |(why, ..)| why)
            .number("Number", |(_, number, _)| whole(*number))
            .number("Participants", |(.., people)| whole(*people))
            .add_to(section);
    }
}

/// Returns the sessions of participants who were not excluded.
fn sessions<'a>(source: &'a Source, results: &Results) -> impl Iterator<Item = &'a SessionRead> + Clone {
    let excluded: Vec<String> = (results.measured.excluded.iter())
        .filter_map(|excluded| if let Part::Participant(id) = &excluded.what { Some(id.clone()) } else { None })
        .collect();
    source.sessions.iter().filter(move |session| !excluded.contains(&session.subject))
}

/// Returns every sitting of the participants who were not excluded, with its session.
pub(super) fn all_sittings<'a>(
    source: &'a Source,
    results: &Results,
) -> impl Iterator<Item = (&'a SessionRead, &'a Sitting)> {
    sessions(source, results).flat_map(|session| sittings(session).map(move |sitting| (session, sitting)))
}

fn sittings(session: &SessionRead) -> impl Iterator<Item = &Sitting> {
    session.sidecar.iter().flat_map(|sidecar| &sidecar.sittings)
}

/// True if any ratings of a session come from a program instead of a person.
fn is_simulated(session: &SessionRead) -> bool {
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
    let days: BTreeSet<&str> =
        all_sittings(source, results).filter_map(|(_, sitting)| sitting.started_at.get(..10)).collect();
    Some((days.first()?, days.last()?))
}

/// Returns the settings that may differ between sittings, with the number of sittings for each value. A setting that no
/// sitting recorded is omitted.
fn properties(source: &Source, results: &Results) -> Vec<(&'static str, Vec<(String, usize)>)> {
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
            for (_, sitting) in all_sittings(source, results) {
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
