//! Data quality: errors, exclusions, and sessions.

use std::collections::BTreeMap;

use super::{exclusions, sittings};
use crate::{
    analysis::Results,
    report::document::{Section, TableOf, count, fixed, list, whole},
    store::ratings::{FileRead, SessionRead, Source},
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
    let excluded = exclusions::sentences(source, results);
    if !excluded.is_empty() {
        section.text(excluded.join(" "));
    }
    exclusions::table(&mut section, source, results);
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
        let analyzed: Vec<&SessionRead> = exclusions::sessions(source, results).collect();
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
    if sittings::all(source, results).next().is_some() {
        screens(&mut section, source, results);
    }
    section
}

/// Says how many of the sessions that were not excluded are known to be finished; `None` if there are none.
pub(super) fn finished_sentence(source: &Source, results: &Results) -> Option<String> {
    let sessions = exclusions::sessions(source, results);
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
        Some(_) if sittings::is_simulated(session) => "a program",
        Some(_) => "a person",
    }
}

fn screens(section: &mut Section, source: &Source, results: &Results) {
    section.heading("Screens and incidents");
    // The number of sittings with each problem.
    let mut problems: BTreeMap<&str, u64> = BTreeMap::new();
    let checks = sittings::all(source, results).flat_map(|(_, sitting)| &sitting.preflight);
    for note in checks.filter(|note| !note.ok) {
        *problems.entry(&note.sentence).or_default() += 1;
    }
    if !problems.is_empty() {
        section.text("Preflight checks found these problems:");
    }
    section.list(problems.iter().map(|(text, n)| format!("{text} ({})", count(*n, "sitting"))).collect());
    let incidents: Vec<String> = sittings::all(source, results)
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
    let properties = sittings::properties(source, results);
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
