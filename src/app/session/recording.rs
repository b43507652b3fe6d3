//! Writes the files of a session: the rows, the frame intervals, and the sidecar, which contains the images' hashes; and
//! whether the frames of a sitting kept up with the screen.

use std::{
    collections::BTreeMap,
    sync::mpsc::{Receiver, Sender, channel},
    time::Duration,
};

use jiff::Timestamp;

use super::{
    instructions::INSTRUCTION_PAGES,
    request::{Prepared, Request},
};
use crate::{
    app::ui::Monitor,
    display::frames::{FrameTimes, KnownRefresh, Refresh},
    experiment::{
        Answers, FrameCount, Identity, Phase, RowContext, Session, SessionOptions, State, TrialRecord, TrialResponse,
        session_seed,
    },
    light::CodeImage,
    report::{document::numbers::count, terminal::message},
    stimulus::Stimulus,
    store::{
        StoreError, image,
        results::frames_line,
        session::{Interrupted, SessionStore},
        sidecar::{FrameSummary, InputSummary, Pictures, PreflightNote, Sitting, UsedDisplay},
    },
    system::{after, before, now, run_on_thread},
};

/// What a timestamp means, for the sidecar.
const STAMP: &str = "A rating with a response_uncertainty_s is timestamped when the window system delivers the key or \
    click, before the frame that responds to it. The event may have waited since the program last read events (it reads \
    none while it draws), for at most response_uncertainty_s. Delays of the keyboard, cable, and window system are not \
    included. A rating without one is timestamped at the start of the frame that receives it, and is therefore late by \
    at most one frame interval.";

/// The files of a sitting, open for writing.
pub struct Recording {
    pub store: SessionStore,
    pub identity: Identity,
    sitting: u32,
    /// All rows so far, including earlier sittings, for the plot at the end.
    pub rows: Vec<TrialRecord>,
    /// Wall-clock time at which the session's time was 0.
    origin: Timestamp,
    /// The stimuli and the hashes of their images. Each is computed on another thread, so that no frame waits for it.
    hashes: (Sender<Hashed>, Receiver<Hashed>),
    closed: bool,
}

type Hashed = (Stimulus, String);

impl Recording {
    /// Creates or opens the files, and keeps the participant's `answers`, if they were asked. Also returns the session, and the session's time at the start of this sitting.
    pub fn begin(
        request: &Request,
        prepared: &Prepared,
        notes: Vec<PreflightNote>,
        monitor: &Monitor,
        screen: &ScreenRefresh,
        answers: Option<Answers>,
    ) -> Result<(Self, Session, Duration), StoreError> {
        let Request { protocol, identity, display, results, .. } = request;
        let used = UsedDisplay::from(display);
        let hash = used.sha256.clone();
        let sitting = Sitting {
            started_at: now().to_string(),
            display: Some(used),
            monitor: Some(monitor.clone()),
            viewing: Some(prepared.geometry.clone()),
            preflight: notes,
            pictures: Some(Pictures::new(protocol, prepared.geometry.stimulus_px, &display.transfers, Some(hash))),
            ..Sitting::default()
        };
        let (mut store, found) = if request.resume {
            SessionStore::resume(results, protocol, identity, request.seed, sitting, request.changes)?
        } else {
            let seed = request.seed.unwrap_or_else(fresh_seed);
            SessionStore::create(results, protocol, identity, seed, sitting)?
        };
        let Interrupted { course, mut resumed, elapsed_s, rows, sitting, .. } = found;
        let hours_ago = |row: &TrialRecord| now().duration_since(row.started_at).as_secs_f64() / 3600.0;
        let hours = rows.last().map(hours_ago);
        if protocol.session.refresh_after_h.zip(hours).is_some_and(|(after, hours)| after == 0.0 || hours > after) {
            let practice = rows.iter().filter(|row| row.phase == Phase::Practice);
            let attempts = practice.map(|row| (row.trial as usize - 1, row.attempt));
            resumed.repeat_practice(protocol.design.practice as usize, attempts);
        }
        if let Some(answers) = answers {
            store.keep_participant(answers);
        }
        let offset = offset(elapsed_s, rows.first());
        let options = SessionOptions { pages: INSTRUCTION_PAGES, frames: screen.frames() };
        let session = Session::new(course, &resumed, options);
        let recording = Self {
            store,
            identity: identity.clone(),
            sitting,
            rows,
            origin: before(now(), offset),
            hashes: channel(),
            closed: false,
        };
        Ok((recording, session, offset))
    }

    /// Writes a row to disk; on failure, the row is kept in memory for [`SessionStore::retry`].
    pub fn record(&mut self, session: &mut Session, response: &TrialResponse) -> Result<(), StoreError> {
        let context = RowContext {
            protocol: session.protocol(),
            schedule: session.schedule(),
            identity: &self.identity,
            sitting: self.sitting,
        };
        let row = TrialRecord::new(&context, response, after(self.origin, response.onset));
        let stored = self.store.append(&row);
        self.rows.push(row);
        self.store_frames(session);
        stored
    }

    fn store_frames(&mut self, session: &mut Session) {
        let runs = session.take_frame_runs();
        let lines = runs.iter().filter_map(|run| frames_line(run, session.schedule(), self.sitting));
        self.store.append_frames(&lines.collect::<Vec<_>>());
    }

    /// Returns how the ratings of this sitting were timestamped.
    fn input(&self) -> InputSummary {
        let own = || self.rows.iter().filter(|row| row.sitting == self.sitting);
        let mut waits: Vec<f64> = own().filter_map(|row| Some(row.response_uncertainty_s?.0)).collect();
        waits.sort_by(f64::total_cmp);
        let rounded = |wait: Option<&f64>| wait.map(|wait| (wait * 1e6).round() / 1e6);
        InputSummary {
            stamp: STAMP.to_owned(),
            stamped: waits.len(),
            unstamped: (own().count() - waits.len()) as u32,
            median_uncertainty_s: rounded(waits.get(waits.len() / 2)),
            max_uncertainty_s: rounded(waits.last()),
        }
    }

    /// Takes the image of a stimulus, which is hashed on another thread.
    pub fn picture(&self, stimulus: Stimulus, picture: CodeImage) {
        let hashes = self.hashes.0.clone();
        // If the system cannot create a thread, the missing hash shows this.
        let _ = run_on_thread(move || _ = hashes.send((stimulus, image::hash(&picture))));
    }

    /// Records the end of the sitting in the sidecar; does so only once. Returns the write error, which is also printed
    /// to stderr. If the sidecar cannot be written now, it lacks these details, but no other data are lost.
    pub fn close(&mut self, session: &mut Session, screen: &ScreenRefresh) -> Option<String> {
        if std::mem::replace(&mut self.closed, true) {
            return None;
        }
        // This is the last attempt to save an answer that is only in memory.
        let saved = if session.is_storing() { self.store.retry() } else { Ok(()) };
        self.store_frames(session);
        self.store.sitting().input = Some(self.input());
        // Without the other sender, the last image ends the list.
        let (_, hashes) = std::mem::replace(&mut self.hashes, channel());
        let hashed: BTreeMap<String, Hashed> = hashes.iter().map(|hashed| (hashed.0.key(), hashed)).collect();
        self.store.note_pictures(hashed.values().map(|(stimulus, sha256)| (stimulus, sha256.clone())));
        let summary = screen.summary(session.frame_times(), self.store.frames_file());
        let complete = *session.state() == State::Done;
        let ended = self.store.finish(complete, now().to_string(), summary);
        let errors: Vec<String> = [saved, ended].into_iter().filter_map(Result::err).map(|e| e.to_string()).collect();
        // The last resort for an answer that no disk accepts.
        for row in self.store.unsaved() {
            let place = self.store.csv().display();
            message("error", &format!("{place}: this row is not on disk; expected it at the end of the file: {row}"));
        }
        errors.iter().for_each(|error| message("error", error));
        (!errors.is_empty()).then(|| errors.join("\n"))
    }
}

/// Returns the session time at which a resumed sitting starts. It follows the wall clock, but is never before the last
/// recorded time, because a clock can be set back.
fn offset(elapsed_s: f64, first: Option<&TrialRecord>) -> Duration {
    let recorded = Duration::try_from_secs_f64(elapsed_s).unwrap_or_default();
    let Some(first) = first else { return recorded };
    let since_first = now().duration_since(first.started_at).as_secs_f64() + first.onset_s.0;
    recorded.max(Duration::try_from_secs_f64(since_first).unwrap_or_default())
}

/// Returns a seed that differs from session to session.
pub fn fresh_seed() -> u64 {
    session_seed(now().as_nanosecond() as u64 ^ (u64::from(std::process::id()) << 32))
}

/// The refresh of the screen, updated if the window moves to another screen.
pub struct ScreenRefresh {
    /// The preflight's finding, and the name and rate of the monitor at that time, which identify it.
    first: (Option<String>, Option<f64>, KnownRefresh),
    now: KnownRefresh,
}

impl ScreenRefresh {
    /// Starts with the preflight's finding about the monitor.
    pub fn new(monitor: &Monitor, found: KnownRefresh) -> Self {
        Self { first: (monitor.name.clone(), monitor.refresh_hz, found), now: found }
    }

    /// Updates the refresh for the monitor that shows the window; returns a note if it has changed.
    pub fn update(&mut self, monitor: &Monitor) -> Option<String> {
        let before = self.now.0;
        let (name, hz, found) = &self.first;
        let same = (name, *hz) == (&monitor.name, monitor.refresh_hz);
        self.now = if same { *found } else { Refresh::known(monitor.refresh_hz, &[]) };
        let (refresh, source) = self.now;
        (refresh != before).then(|| {
            let hz = refresh.map(|refresh| format!("{:.3} Hz, ", refresh.hz())).unwrap_or_default();
            format!("the screen's refresh rate changed: {} {hz}{source}", monitor.title())
        })
    }

    /// Returns how the session counts frames.
    pub fn frames(&self) -> FrameCount {
        self.now.0.map_or(FrameCount::Frames, |refresh| FrameCount::Against(refresh.seconds()))
    }

    /// Returns the frames of a sitting in one sentence, for the experimenter; `None` if none were counted.
    pub fn sentence(&self, times: &FrameTimes) -> Option<String> {
        let ms = |seconds: f64| format!("{:.1} ms", seconds * 1e3);
        let (median, p99) = (ms(times.quantile(0.5)?), ms(times.quantile(0.99)?));
        let counted = count(times.intervals_us().len() as u64, "frame");
        let verdict = match (times.dropped(), self.now.0) {
            (Some(dropped), Some(refresh)) => {
                let late = count(times.late_onsets().into(), "onset");
                format!("{dropped} dropped at {:.2} Hz, {late} late", refresh.hz())
            }
            (Some(dropped), None) => format!("{dropped} dropped"),
            (None, _) => "none could be judged, because the screen's refresh rate is unknown".to_owned(),
        };
        Some(format!("{counted}, half of them within {median} and 99 % within {p99}: {verdict}."))
    }

    /// Returns the summary of a sitting's frames for the sidecar; `None` if none were counted. `file` is the name of
    /// the file with every interval.
    pub fn summary(&self, times: &FrameTimes, file: Option<String>) -> Option<FrameSummary> {
        let round = |seconds: f64| (seconds * 1e6).round() / 1e6;
        let (refresh, source) = self.now;
        Some(FrameSummary {
            intervals: times.intervals_us().len(),
            median_s: round(times.quantile(0.5)?),
            p01_s: round(times.quantile(0.01)?),
            p99_s: round(times.quantile(0.99)?),
            refresh_s: refresh.map(|refresh| (refresh.seconds() * 1e9).round() / 1e9),
            refresh_source: source.to_owned(),
            dropped: times.dropped(),
            missed_refreshes: times.missed_refreshes(),
            late_onsets: times.dropped().map(|_| times.late_onsets()),
            file,
        })
    }
}
