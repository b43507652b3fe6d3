//! Wide CSV as PsychoPy's `ExperimentHandler` writes it, for scripts that read that: a file a session, a row a trial,
//! the loops `practice` and `trials`, the response `key_resp`.

use std::path::Path;

use super::{Experiment, make_folder};
use crate::{
    experiment::{Phase, TrialRecord, columns},
    store::{StoreError, fault::io, file::write_file, recorded::Recorded},
};

/// Counters of a loop, each from 0.
const COUNTERS: [&str; 4] = ["thisRepN", "thisTrialN", "thisN", "thisIndex"];
/// What stands after the counters of both loops.
const MEASURED: [&str; 6] =
    ["thisRow.t", "stimulus.started", "stimulus.stopped", "key_resp.keys", "key_resp.rt", "key_resp.started"];
/// What is said of the session in every row.
const SESSION: [&str; 6] = ["participant", "session", "date", "expName", "psychopyVersion", "frameRate"];
/// Columns of ours that stand there under PsychoPy's names.
const RENAMED: [&str; 4] = ["experiment", "subject_id", "session_id", "response_time_s"];

/// Writes a folder of files for each experiment below `to`.
pub(super) fn write(experiments: &[Experiment], to: &Path) -> Result<(), StoreError> {
    for experiment in experiments {
        let folder = to.join(&experiment.name);
        make_folder(&folder)?;
        for session in &experiment.sessions {
            let (subject, date) = (session.identity.subject(), date(session));
            let mut path = folder.join(format!("{subject}_{}_{date}.csv", experiment.name));
            if path.exists() {
                // Begun in the same millisecond.
                let id = session.identity.session();
                path = folder.join(format!("{subject}_{}_{date}_session-{id}.csv", experiment.name));
            }
            write_file(&path, &table(session, &date).map_err(|error| io(&path, "write")(error.into()))?)?;
        }
    }
    Ok(())
}

/// When a session began, in UTC, as PsychoPy writes it in names: `2026-01-31_09h30.00.000`.
fn date(session: &Recorded) -> String {
    let said = session.sidecar.sittings.first().and_then(|sitting| sitting.started_at.parse().ok());
    let began: Option<jiff::Timestamp> = said.or(session.rows.first().map(|row| row.started_at));
    began.unwrap_or_default().strftime("%Y-%m-%d_%Hh%M.%S.%3f").to_string()
}

fn table(session: &Recorded, date: &str) -> Result<Vec<u8>, csv::Error> {
    let columns: Vec<String> = columns(&session.protocol).into_iter().map(|column| column.name).collect();
    let factors: Vec<&str> = session.protocol.factors.iter().map(|factor| factor.name.as_str()).collect();
    let place = |name: &str| columns.iter().position(|column| column == name);
    let factor_places: Vec<Option<usize>> = factors.iter().map(|name| place(name)).collect();
    let rest: Vec<usize> = (0..columns.len())
        .filter(|i| !RENAMED.contains(&columns[*i].as_str()) && !factors.contains(&columns[*i].as_str()))
        .collect();
    let mut writer = csv::Writer::from_writer(Vec::new());
    let loops = ["practice", "trials"].iter().flat_map(|name| COUNTERS.map(|counter| format!("{name}.{counter}")));
    let header = factors.iter().map(|name| (*name).to_owned()).chain(loops);
    let header = header.chain(MEASURED.map(str::to_owned)).chain(rest.iter().map(|i| columns[*i].clone()));
    writer.write_record(header.chain(SESSION.map(str::to_owned)))?;
    for row in &session.rows {
        let cells = row.cells();
        let mut line: Vec<String> =
            factor_places.iter().map(|i| i.map_or_else(String::new, |i| cells[i].clone())).collect();
        line.extend(counters(session, row));
        line.extend(measured(session, row));
        line.extend(rest.iter().map(|i| cells[*i].clone()));
        line.extend(said(session, row, date));
        writer.write_record(&line)?;
    }
    writer.into_inner().map_err(|error| error.into_error().into())
}

/// Those of the practice loop, then those of the main one: empty in the rows of the other. As PsychoPy counts a list
/// that is shuffled as a whole.
fn counters(session: &Recorded, row: &TrialRecord) -> Vec<String> {
    let conditions = session.schedule.conditions.len().max(1);
    let number = (row.trial as usize).saturating_sub(1);
    let condition = session.condition(row).map_or_else(String::new, |condition| condition.to_string());
    let own =
        [(number / conditions).to_string(), (number % conditions).to_string(), number.to_string(), condition].to_vec();
    let other = vec![String::new(); COUNTERS.len()];
    if row.phase == Phase::Practice { [own, other].concat() } else { [other, own].concat() }
}

/// Times since the session's start in seconds, and the key.
fn measured(session: &Recorded, row: &TrialRecord) -> [String; MEASURED.len()] {
    let onset = row.onset_s.0;
    let time = |seconds: f64| format!("{seconds:.4}");
    let key = session.protocol.response.categories.get(usize::from(row.rating.0));
    [
        time((onset - row.recovery_s.0).max(0.0)),
        time(onset),
        row.stimulus_s.map_or_else(String::new, |duration| time(onset + duration.0)),
        key.map_or_else(String::new, |category| category.key.to_string()),
        time(row.response_time_s.0),
        time(onset),
    ]
}

fn said(session: &Recorded, row: &TrialRecord, date: &str) -> [String; SESSION.len()] {
    let sitting = session.sidecar.sittings.get((row.sitting as usize).saturating_sub(1));
    // No version of PsychoPy ran it.
    let program =
        sitting.map_or_else(String::new, |sitting| format!("{} {}", sitting.program.name, sitting.program.version));
    let refresh_s = sitting.and_then(|sitting| sitting.frames.as_ref()?.get("refresh_s")?.as_f64());
    [
        session.identity.subject().to_owned(),
        session.identity.session().to_owned(),
        date.to_owned(),
        session.protocol.name.clone(),
        program,
        refresh_s.filter(|seconds| *seconds > 0.0).map_or_else(String::new, |seconds| format!("{:.4}", 1.0 / seconds)),
    ]
}
