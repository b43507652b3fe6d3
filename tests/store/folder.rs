//! Results on disk: nothing is overwritten, nothing is lost, and nothing is recorded twice; and the frames file next to a
//! session's rows.

use std::{collections::BTreeSet, fs, path::Path, time::Duration};

use jiff::Timestamp;
use machband::{
    experiment::{
        Course, Effect, Event, FrameCount, Identity, Phase, Protocol, Rating, Resumed, RowContext, Schedule, Seconds,
        Session, SessionOptions, State, TrialRecord,
    },
    light::Depth,
    store::{
        StoreError,
        check::{self, check},
        dataset::free_participant,
        definition,
        ratings::ReadOptions,
        results::{FRAMES_HEADER, frames_line, new_frames, open_frames},
        session::{Changes, Interrupted, SessionStore},
        sidecar::Sidecar,
    },
    work::Study,
};
use proptest::prelude::*;

use crate::{
    common::{everything, json, refused},
    recording::{self, SEED, TEXT, create, identity, paths, resume, rows, sitting, small},
};

const TRIALS: usize = 6;

fn rate(store: &mut SessionStore, found: Option<&Interrupted>, limit: usize) -> Result<(), StoreError> {
    recording::rate(store, (&small(), &identity()), found, limit, false)
}

/// Records a session with this many rows, and closes it.
fn session_of(rows: usize) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    rate(&mut create(folder.path()).unwrap(), None, rows).unwrap();
    folder
}

fn assert_whole(results: &Path) {
    let csv = paths(results).csv;
    let ids: Vec<String> = rows(&csv).into_iter().map(|row| row.row_id).collect();
    assert_eq!(ids.len(), TRIALS, "{ids:?}");
    assert_eq!(ids.iter().collect::<BTreeSet<_>>().len(), TRIALS, "{ids:?}");
    let said = check::check(csv.to_str().unwrap()).unwrap().sentence;
    assert!(said.contains(&format!("{TRIALS} of {TRIALS} planned")), "{said}");
}

mod layout {
    use super::*;

    #[test]
    fn the_data_set_is_as_documented() {
        let folder = session_of(usize::MAX);
        let files: Vec<String> = everything(folder.path())
            .into_iter()
            .map(|(path, _)| path.strip_prefix(folder.path()).unwrap().to_str().unwrap().replace('\\', "/"))
            .collect();
        let expected = [
            "small-one/.psychds-ignore",
            "small-one/.psychdsignore",
            "small-one/CHANGES.md",
            "small-one/README.md",
            "small-one/data/subject-S001_session-1_task-smallone_data.csv",
            "small-one/data/subject-S001_session-1_task-smallone_data.json",
            "small-one/dataset_description.json",
        ];
        assert_eq!(files, expected);
        let paths = paths(folder.path());
        let csv = fs::read_to_string(&paths.csv).unwrap();
        let header: Vec<&str> = csv.lines().next().unwrap().split(',').collect();
        let contract = "row_id,experiment,subject_id,session_id,phase,block,trial,attempt,repetition,stimulus,width,depth,orientation_deg,low,high,color,rating,response_time_s,onset_s,recovery_s,frames,dropped_frames,started_at";
        assert!(csv.starts_with(contract), "{csv:.300}");
        let description = json(&paths.dataset.join("dataset_description.json"));
        for (key, value) in
            [("@context", "https://schema.org/"), ("@type", "Dataset"), ("name", "small-one"), ("description", "Small")]
        {
            let given = description[key].as_str().unwrap();
            assert_eq!(given.trim_end_matches('/'), value.trim_end_matches('/'), "{key}");
        }
        let names: Vec<&str> =
            description["variableMeasured"].as_array().unwrap().iter().map(|v| v["name"].as_str().unwrap()).collect();
        assert_eq!(names, header);
        let further = ["stimulus_s", "late_onset", "response_uncertainty_s", "sitting", "seed", "tanh_k"];
        assert_eq!(header[23..], further);
        let sidecar = json(&paths.sidecar);
        let described: Vec<&String> = sidecar["columns"].as_object().unwrap().keys().collect();
        assert_eq!(described, header);
        assert!(
            sidecar["columns"].as_object().unwrap().values().all(|c| !c["description"].as_str().unwrap().is_empty())
        );
        assert_eq!((sidecar["seed"].as_u64(), sidecar["sittings"][0]["complete"].as_bool()), (Some(7), Some(true)));
        assert_eq!(sidecar["definition_sha256"], definition::hash(&small()));
        let kept = definition::from_json("sidecar", &sidecar["definition"]).unwrap();
        assert_eq!(kept, small());
    }

    #[test]
    fn the_next_free_participant_has_no_files() {
        let folder = tempfile::tempdir().unwrap();
        let free = || free_participant(folder.path(), &small()).unwrap();
        assert_eq!(free(), "P001");
        let data = folder.path().join("small-one/data");
        fs::create_dir_all(&data).unwrap();
        for (file, next) in [
            ("subject-P001_session-1_task-smallone_data.csv", "P002"),
            ("subject-P003_session-1_task-smallone_data.csv", "P002"),
            // A different session, only a sidecar, and lowercase, which some file systems do not distinguish.
            ("subject-P002_session-9_task-smallone_data.json", "P004"),
            ("subject-p004_session-1_task-smallone_data.csv", "P005"),
            ("subject-P1000_session-1_task-smallone_data.csv", "P005"),
            ("notes.txt", "P005"),
        ] {
            fs::write(data.join(file), "").unwrap();
            assert_eq!(free(), next, "{file}");
        }
        // A folder that cannot be listed may have any participant.
        fs::remove_dir_all(&data).unwrap();
        std::os::unix::fs::symlink(&data, &data).unwrap();
        let error = free_participant(folder.path(), &small()).unwrap_err().to_string();
        assert!(error.contains("cannot list"), "{error}");
    }
}

mod rows_on_disk {
    use super::*;

    fn number() -> impl Strategy<Value = Option<f64>> {
        prop::option::of(prop_oneof![any::<f64>().prop_filter("finite", |x| x.is_finite()), 0.0..1.0])
    }

    fn seconds() -> impl Strategy<Value = Seconds> {
        // With the recorded precision of 0.1 ms, up to thirty years.
        (0..10_000_000_000_000_u64).prop_map(|ticks| Seconds(ticks as f64 / 1e4))
    }

    prop_compose! {
        fn any_row()(
            texts in prop::array::uniform5("[^\r\n\0]{1,12}"), phase in prop::sample::select(vec![Phase::Practice, Phase::Main]),
            counts in prop::array::uniform5(any::<u32>()), seed: u64,
            numbers in prop::array::uniform4(number()), times in prop::array::uniform3(seconds()),
            depth in prop::option::of(prop_oneof![Just(Depth::Infinite), (1..33_u8).prop_map(Depth::Finite)]),
            color in prop::option::of("[^\r\n\0]{1,9}"), rating in 0..4_u8, frames in prop::option::of(any::<(u32, u32)>()),
            late in prop::option::of((seconds(), any::<bool>(), seconds())), millisecond in -62_000_000_000_000_i64..250_000_000_000_000, extra_factors in "[^\r\n\0]{0,9}",
        ) -> TrialRecord {
            let [row_id, experiment, subject_id, session_id, stimulus] = texts;
            let [block, trial, attempt, repetition, sitting] = counts;
            let [width, orientation_deg, low, high] = numbers;
            let [response_time_s, onset_s, recovery_s] = times;
            TrialRecord {
                row_id, experiment, subject_id, session_id, phase, block, trial, attempt, repetition, stimulus, width,
                depth, orientation_deg, low, high, color, rating: Some(Rating(rating)), answer: None, response_time_s, onset_s, recovery_s,
                frames: frames.map(|f| f.0), dropped_frames: frames.map(|f| f.1),
                started_at: Timestamp::from_millisecond(millisecond).unwrap(), sitting, seed, further: vec![extra_factors],
                stimulus_s: late.map(|l| l.0), late_onset: late.map(|l| l.1), response_uncertainty_s: late.map(|l| l.2),
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(100))]
        #[test]
        fn appended_rows_read_back_unchanged(records in prop::collection::vec(any_row(), 1..4)) {
            let folder = tempfile::tempdir().unwrap();
            let mut store = create(folder.path()).unwrap();
            for record in &records {
                store.append(record).unwrap();
            }
            prop_assert_eq!(rows(&paths(folder.path()).csv), records);
        }
    }

    #[test]
    fn existing_files_are_never_overwritten() {
        let folder = session_of(3);
        let error = refused(folder.path(), || create(folder.path()));
        assert!(matches!(&error, StoreError::Exists(path) if *path == paths(folder.path()).csv), "{error}");
        // A sidecar is data too, even if its rows were moved elsewhere.
        fs::remove_file(paths(folder.path()).csv).unwrap();
        let error = refused(folder.path(), || create(folder.path()));
        assert!(matches!(&error, StoreError::Exists(path) if *path == paths(folder.path()).sidecar), "{error}");
    }
}

mod interrupted {
    use super::*;

    /// The file may end anywhere in the last row, or with zero bytes where the system had allocated space but not yet
    /// written to it.
    #[test]
    fn truncation_at_any_byte_loses_only_the_last_row() {
        let folder = session_of(4);
        let paths = paths(folder.path());
        let [whole, saved] = [&paths.csv, &paths.sidecar].map(|path| fs::read(path).unwrap());
        let ends: Vec<usize> = (0..whole.len()).filter(|i| whole[*i] == b'\n').map(|i| i + 1).collect();
        let (header, two_rows) = (ends[0], ends[ends.len() - 3]);
        let cuts = (0..=header).step_by(7).chain(two_rows..=whole.len()).map(|length| (length, 0));
        let zeros = [0, 5, header, two_rows, two_rows + 30, whole.len()].map(|length| [(length, 1), (length, 4096)]);
        let mut cases: Vec<_> = cuts
            .chain(zeros.concat())
            .map(|(length, zeros)| (length, [&whole[..length], &vec![0; zeros]].concat()))
            .collect();
        // The first half of the last row was not written, but the second half was.
        let last = ends[ends.len() - 2];
        let holed = [&whole[..last], &vec![0; whole.len() - 30 - last], &whole[whole.len() - 30..]].concat();
        cases.push((last, holed));
        for (length, content) in cases {
            fs::write(&paths.csv, &content).unwrap();
            fs::write(&paths.sidecar, &saved).unwrap();
            let (mut store, found) = resume(folder.path()).unwrap_or_else(|error| panic!("{length}: {error}"));
            let kept = ends.iter().filter(|end| **end <= length).count();
            assert_eq!(found.rows.len(), kept.saturating_sub(1), "{length}");
            let torn = kept.checked_sub(1).map_or(0, |last| ends[last]) < content.len();
            assert_eq!(found.partial_line.is_some(), torn, "{length} {:?}", found.partial_line);
            rate(&mut store, Some(&found), usize::MAX).unwrap();
            drop(store);
            assert_whole(folder.path());
            // Complete rows stay unchanged, byte for byte.
            let kept = kept.checked_sub(1).map_or(0, |last| ends[last]);
            assert!(fs::read(&paths.csv).unwrap().starts_with(&whole[..kept]), "{length}");
            let sidecar = Sidecar::read(&paths.sidecar).unwrap().unwrap();
            let incidents = &sidecar.sittings.last().unwrap().incidents;
            assert_eq!(incidents.iter().any(|incident| incident.contains("incomplete last row")), torn, "{length}");
        }
    }

    #[test]
    fn errors_before_the_last_row_are_reported_and_nothing_is_changed() {
        let folder = session_of(4);
        let csv = paths(folder.path()).csv;
        let whole = fs::read_to_string(&csv).unwrap();
        let lines: Vec<&str> = whole.lines().collect();
        let column = |line: &str, cell: &str| line.find(cell).map(|at| line[..at].chars().count() + 1).unwrap();
        let with = |at: usize, line: &str| {
            let mut lines = lines.clone();
            lines[at] = line;
            lines.join("\n") + "\n"
        };
        let mut zeros = whole.clone().into_bytes();
        let second = whole.find(lines[2]).unwrap();
        zeros[second + 3..second + 40].fill(0);
        let mut latin = whole.clone().into_bytes();
        latin[second + 3] = 0xff;
        let cases: Vec<(Vec<u8>, String, &str)> = vec![
            (with(2, "garbage").into(), "3:1".into(), "cells in the row is 1; expected "),
            (
                with(2, &lines[2].replacen(",mach-band,", ",mach-band,wide", 1)).into(),
                format!("3:{}", column(lines[2], ",mach-band,") + 11),
                "width is \"wide",
            ),
            (zeros, "3:".into(), ""),
            (latin, "3:4".into(), "not UTF-8"),
            // A foreign text, which is not an incomplete header and must not be truncated.
            (b"My notes on this participant".to_vec(), "1:1".into(), "begins with \"My notes"),
        ];
        for (content, position, part) in cases {
            fs::write(&csv, &content).unwrap();
            let error = refused(folder.path(), || resume(folder.path())).to_string();
            let start = format!("{}:{position}", csv.display());
            assert!(
                error.starts_with(&start) && error.contains(part) && error.contains("expected"),
                "{start} {part}: {error}"
            );
        }
    }

    #[test]
    fn a_different_definition_seed_or_participant_is_rejected_and_nothing_is_changed() {
        let folder = session_of(4);
        let csv = paths(folder.path()).csv;
        let is_refused = |protocol: &Protocol, seed: Option<u64>, part: &str| {
            // A rejection must not remove an incomplete last row either.
            let whole = fs::read(&csv).unwrap();
            fs::write(&csv, [&whole[..], b"S001_1_ma"].concat()).unwrap();
            let resumed =
                || SessionStore::resume(folder.path(), protocol, &identity(), seed, sitting(), Changes::Refuse);
            let error = refused(folder.path(), resumed);
            assert!(matches!(error, StoreError::FileErrors(_)), "{error}");
            assert!(error.to_string().contains(part) && error.to_string().contains("expected"), "{error}");
            fs::write(&csv, whole).unwrap();
        };
        let other = |from: &str, to: &str| definition::parse("small.toml", &TEXT.replace(from, to)).unwrap();
        is_refused(&other("0.4", "0.5"), Some(7), "another definition");
        is_refused(&other("tanh_k = [5, 7.5]", "depth = [1, 2]"), Some(7), "another definition");
        is_refused(&small(), Some(8), "has seed 7; expected that seed or no seed, not 8");
        let rows = fs::read_to_string(&csv).unwrap();
        fs::write(&csv, rows.replace("S001", "S002")).unwrap();
        is_refused(&small(), Some(7), "row S002_1_practice_0001_1 is not planned");
        fs::write(&csv, rows).unwrap();
        // Without a given seed, the session's own seed is used.
        let (mut store, found) =
            SessionStore::resume(folder.path(), &small(), &identity(), None, sitting(), Changes::Refuse).unwrap();
        assert_eq!((found.course.schedule().seed, found.sitting), (7, 2));
        rate(&mut store, Some(&found), usize::MAX).unwrap();
        assert_whole(folder.path());
        let nobody = Identity::new("S009", "1").unwrap();
        let error =
            SessionStore::resume(folder.path(), &small(), &nobody, None, sitting(), Changes::Refuse).unwrap_err();
        assert!(matches!(error, StoreError::NothingToResume(_)), "{error}");
    }

    #[test]
    fn a_missing_sidecar_is_recreated() {
        // With rows, a missing sidecar is an error: see `edits.rs`.
        let folder = session_of(0);
        fs::remove_file(paths(folder.path()).sidecar).unwrap();
        let (mut store, found) = resume(folder.path()).unwrap();
        assert_eq!(found.sitting, 2, "each sitting has its own entry in the sidecar");
        rate(&mut store, Some(&found), usize::MAX).unwrap();
        drop(store);
        assert_whole(folder.path());
        let sidecar = Sidecar::read(&paths(folder.path()).sidecar).unwrap().unwrap();
        assert_eq!((sidecar.seed, sidecar.sittings.len()), (7, 2));
        assert!(sidecar.sittings[0].incidents[0].contains("missing"), "{:?}", sidecar.sittings[0].incidents);
    }
}

mod trouble {
    use super::*;

    #[test]
    fn a_file_changed_by_someone_else_is_not_overwritten() {
        let folder = session_of(0);
        let (mut store, found) = resume(folder.path()).unwrap();
        let csv = paths(folder.path()).csv;
        fs::remove_file(&csv).unwrap();
        fs::write(&csv, "someone else's").unwrap();
        let error = rate(&mut store, Some(&found), 1).unwrap_err();
        assert!(error.to_string().contains("expected the file as this session left it"), "{error}");
        assert!(store.retry().is_err());
        assert_eq!(fs::read_to_string(&csv).unwrap(), "someone else's");
        let elsewhere = tempfile::tempdir().unwrap();
        store.continue_in(elsewhere.path()).unwrap();
        assert_eq!(rows(store.csv()).len(), 1);
    }
}

/// Rates trials at 60 Hz, as the window does, until `trials` trials are rated.
fn rate_at_60_hz(store: &mut SessionStore, schedule: &Schedule, resumed: &Resumed, sitting: u32, trials: usize) {
    let (protocol, identity) = (small(), identity());
    let options = SessionOptions { pages: 0, frames: FrameCount::Against(1.0 / 60.0) };
    let mut session = Session::new(Course::new(&protocol, &identity, SEED).unwrap(), resumed, options);
    let context = RowContext { protocol: &protocol, schedule, identity: &identity, sitting };
    let mut rated = 0;
    // Each sitting begins after the previous one.
    let start = 1000.0 * f64::from(sitting - 1);
    for frame in 0.. {
        let now = Duration::from_secs_f64(start + f64::from(frame) / 60.0);
        let event = match session.state() {
            State::Stimulus { .. } => Some(Event::Rate(2)),
            State::PhaseStart(_) | State::Break => Some(Event::Continue),
            State::Done => break,
            _ => None,
        };
        if let Some(Effect::Record(response)) = event.map(|event| session.step(event, now)) {
            store.append(&TrialRecord::new(&context, &response, jiff::Timestamp::UNIX_EPOCH + response.onset)).unwrap();
            session.step(Event::Stored, now);
            let runs = session.take_frame_runs();
            let lines = runs.iter().filter_map(|run| frames_line(run, schedule, sitting));
            store.append_frames(&lines.collect::<Vec<_>>());
            rated += 1;
        }
        if rated == trials {
            break;
        }
        session.step(Event::Frame, now);
    }
}

/// Returns the cells of the rows of a frames file.
fn frame_rows(path: &Path) -> Vec<Vec<String>> {
    let text = fs::read_to_string(path).unwrap();
    assert_eq!(text.lines().next(), Some(FRAMES_HEADER));
    text.lines().skip(1).map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

fn schedule() -> Schedule {
    Schedule::new(&small(), &identity(), SEED).unwrap()
}

/// Records a session with `trials` rated trials.
fn framed(results: &Path, trials: usize) -> SessionStore {
    let mut store = create(results).unwrap();
    rate_at_60_hz(&mut store, &schedule(), &Resumed::default(), 1, trials);
    store
}

#[test]
fn frames_are_appended() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a_frames.csv");
    let mut file = new_frames(&path);
    file.append(&[]).unwrap();
    assert!(!path.exists(), "a session without frames has no file");
    let rows = [
        "1,main,2,1,stimulus,16683.350,16683 16684 33367\n",
        "2,practice,2,1,recovery,,4294967295\n",
        "1,main,2,3,response,16683.350,1\n",
        "1,main,2,1,closing,16683.350,7 8\n",
    ];
    file.append(rows[0].as_bytes()).unwrap();
    file.append(rows[1..].concat().as_bytes()).unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), format!("{FRAMES_HEADER}\n{}", rows.concat()));
    assert!(check(path.to_str().unwrap()).is_err(), "they are checked with their session");
    // If a power failure truncates the file, it continues after the last complete row.
    drop(file);
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, &text[..text.len() - 3]).unwrap();
    open_frames(&path).unwrap().append(rows[3].as_bytes()).unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), text);
    // A foreign file is not changed.
    fs::write(&path, "name,age\n").unwrap();
    assert!(open_frames(&path).is_err());
    assert!(new_frames(&path).append(rows[0].as_bytes()).is_err());
    assert_eq!(fs::read_to_string(&path).unwrap(), "name,age\n");
}

#[test]
fn frames_are_next_to_the_rows_and_are_not_read_as_data() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = framed(folder.path(), 6);
    let paths = paths(folder.path());
    assert_eq!(store.frames_file().as_deref(), Some("subject-S001_session-1_task-smallone_frames.csv"));
    store.finish(true, "then".to_owned(), None).unwrap();
    let frames = frame_rows(&paths.frames);
    let shown: Vec<_> = frames.iter().map(|row| (&*row[2], &*row[4], row[6].split(' ').count())).collect();
    let expected: Vec<_> =
        ["1", "2", "1", "2", "3", "4"].into_iter().flat_map(|n| [(n, "recovery", 6), (n, "stimulus", 1)]).collect();
    assert_eq!(shown, expected);
    let rows = rows(&paths.csv);
    assert_eq!(rows.iter().map(|row| (row.late_onset, row.frames)).collect::<Vec<_>>(), [(Some(false), Some(1)); 6]);
    assert!(rows.iter().all(|row| (row.stimulus_s.unwrap().0 - 1.0 / 60.0).abs() < 1e-4));
    // Only the rows are read, whether the folder or a file pattern is given.
    for named in [vec![folder.path().to_owned()], vec![paths.csv.clone(), paths.frames.clone()]] {
        let source = Study::read(&named, &ReadOptions::default()).unwrap().source;
        assert_eq!((source.files.len(), source.errors.len()), (1, 0), "{named:?}");
    }
    // A frames file is never overwritten, even if its rows are gone.
    fs::remove_file(&paths.csv).unwrap();
    fs::remove_file(&paths.sidecar).unwrap();
    assert!(matches!(create(folder.path()), Err(StoreError::Exists(path)) if path == paths.frames));
}

#[test]
fn a_failure_to_write_frames_is_noted_once_and_harms_nothing_else() {
    let (first, second) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let mut store = create(first.path()).unwrap();
    // A folder has the name of the frames file.
    let place = paths(first.path()).frames;
    fs::create_dir(&place).unwrap();
    rate_at_60_hz(&mut store, &schedule(), &Resumed::default(), 1, 2);
    assert_eq!(rows(&paths(first.path()).csv).len(), 2);
    // After the move, all frames are saved.
    store.continue_in(second.path()).unwrap();
    store.finish(false, "then".to_owned(), None).unwrap();
    assert_eq!(frame_rows(&paths(second.path()).frames).len(), 4);
    let sidecar = Sidecar::read(&paths(second.path()).sidecar).unwrap().unwrap();
    let incidents = &sidecar.sittings[0].incidents;
    let noted = incidents.iter().filter(|incident| incident.contains("frames could not be written")).count();
    assert_eq!(noted, 1, "{incidents:?}");
}
