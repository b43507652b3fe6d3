//! Signals that ask the program to end: SIGTERM, SIGINT and SIGHUP. A sitting then ends as if its window had been
//! closed. A second SIGTERM or SIGINT ends the program at once. Only Unix has these signals.

use std::{
    fmt,
    path::Path,
    sync::{
        Arc, OnceLock,
        atomic::{AtomicUsize, Ordering},
    },
};

/// A signal that asked the program to end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Signal(u8);

impl Signal {
    /// Returns the exit status that shells report for a program that this signal ended.
    pub fn status(self) -> u8 {
        self.0.saturating_add(128)
    }
}

impl fmt::Display for Signal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            1 => f.write_str("SIGHUP"),
            2 => f.write_str("SIGINT"),
            15 => f.write_str("SIGTERM"),
            number => write!(f, "signal {number}"),
        }
    }
}

/// The last signal; 0 before the first. Empty until signals are watched.
static RECEIVED: OnceLock<Arc<AtomicUsize>> = OnceLock::new();

/// Starts to watch for signals. The first one is only noted, for [`received`]; the next one ends the program at once. A
/// signal that cannot be watched ends the program, as before.
#[cfg(unix)]
pub fn watch() {
    use signal_hook::{
        consts::{SIGHUP, SIGXFSZ},
        flag,
    };

    // Otherwise, this signal would end the program where a write can fail because the file is too large.
    let _ = flag::register(SIGXFSZ, Arc::default());
    let (received, again) = (RECEIVED.get_or_init(Arc::default), Arc::default());
    for signal in watched() {
        // The order matters: the first signal arms the second. SIGHUP does neither, because a system that shuts down may
        // send it together with SIGTERM.
        if signal != SIGHUP {
            let _ = flag::register_conditional_shutdown(signal, 128 + signal, Arc::clone(&again))
                .and_then(|_| flag::register(signal, Arc::clone(&again)));
        }
        let _ = flag::register_usize(signal, Arc::clone(received), signal.unsigned_abs() as usize);
    }
}

/// Does nothing, because this system has no such signals.
#[cfg(not(unix))]
pub fn watch() {}

/// Calls `wake` when a signal arrives, so that an idle event loop notices it. If the system cannot create a thread for
/// this, the loop notices the signal at its next event.
#[cfg(unix)]
pub fn wake(wake: impl Fn() + Send + 'static) {
    let Ok(mut signals) = signal_hook::iterator::Signals::new(watched()) else { return };
    let _ = super::threads::run_on_thread(move || signals.forever().for_each(|_| wake()));
}

/// Does nothing, because this system has no such signals.
#[cfg(not(unix))]
pub fn wake(_: impl Fn() + Send + 'static) {}

/// The signals to watch. If the program was started with a signal ignored, for example by `nohup`, that signal stays
/// ignored on systems that report this (Linux).
#[cfg(unix)]
fn watched() -> impl Iterator<Item = i32> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let ignored = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
    [SIGTERM, SIGINT, SIGHUP].into_iter().filter(move |signal| (ignored >> (signal - 1)) & 1 == 0)
}

/// Returns the signal that asked the program to end, if there was one.
pub fn received() -> Option<Signal> {
    let signal = u8::try_from(RECEIVED.get()?.load(Ordering::SeqCst)).ok()?;
    (signal > 0).then_some(Signal(signal))
}

/// A session ended because a signal asked the program to end.
#[derive(Debug, thiserror::Error)]
#[error("{place}: ended by {signal}")]
pub struct Ended {
    /// Where the answers are.
    pub place: String,
    /// The signal.
    pub signal: Signal,
}

/// Checks that no signal has asked the program to end; `place` says where the answers are.
///
/// # Errors
/// [`Ended`] after a signal.
pub fn check(place: &Path) -> Result<(), Ended> {
    received().map_or(Ok(()), |signal| Err(Ended { place: place.display().to_string(), signal }))
}
