//! The frames file next to a session's rows.

use std::{fs, path::Path, time::Duration};

use machband::{
    experiment::{
        Course, Effect, Event, FrameCount, Resumed, RowContext, Schedule, Session, SessionOptions, State, TrialRecord,
    },
    report::Study,
    store::{
        StoreError,
        check::check,
        ratings::ReadOptions,
        results::{FRAMES_HEADER, FrameFile, frames_line},
        session::SessionStore,
        sidecar::Sidecar,
    },
};

use crate::recording::{SEED, create, identity, paths, rows, small};

/// Rates trials at 60 Hz, as the window does, until `trials` trials are rated.
fn rate(store: &mut SessionStore, schedule: &Schedule, resumed: &Resumed, sitting: u32, trials: usize) {
    let (protocol, identity) = (small(), identity());
    let options = SessionOptions { pages: 0, frames: FrameCount::Against(1.0 / 60.0) };
    let mut session = Session::new(Course::new(protocol.clone(), schedule.clone()), resumed, options);
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
fn session(results: &Path, trials: usize) -> SessionStore {
    let mut store = create(results).unwrap();
    rate(&mut store, &schedule(), &Resumed::default(), 1, trials);
    store
}

#[test]
fn frames_are_appended() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a_frames.csv");
    let mut file = FrameFile::new(&path);
    file.append(&[]).unwrap();
    assert!(!path.exists(), "a session without frames has no file");
    let rows = [
        "1,main,2,1,stimulus,16683.350,16683 16684 33367\n",
        "2,practice,2,1,recovery,,4294967295\n",
        "1,main,2,3,response,16683.350,1\n",
        "1,main,2,1,closing,16683.350,7 8\n",
    ]
    .map(str::to_owned);
    file.append(&rows[..1]).unwrap();
    file.append(&rows[1..]).unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), format!("{FRAMES_HEADER}\n{}", rows.concat()));
    assert!(check(path.to_str().unwrap()).unwrap().sentence.contains("frames of a session"));
    // If a power failure truncates the file, it continues after the last complete row.
    drop(file);
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, &text[..text.len() - 3]).unwrap();
    FrameFile::resume(&path).unwrap().append(&rows[3..]).unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), text);
    // A foreign file is not changed.
    fs::write(&path, "name,age\n").unwrap();
    assert!(FrameFile::resume(&path).is_err());
    assert!(FrameFile::new(&path).append(&rows).is_err());
    assert_eq!(fs::read_to_string(&path).unwrap(), "name,age\n");
}

#[test]
fn frames_are_next_to_the_rows_and_are_not_read_as_data() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = session(folder.path(), 6);
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
    rate(&mut store, &schedule(), &Resumed::default(), 1, 2);
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
