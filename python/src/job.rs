//! Work that runs without the interpreter's lock, reports its progress, and stops on Ctrl+C.

use std::{
    any::Any,
    panic::{AssertUnwindSafe, catch_unwind},
    path::Path,
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicBool, AtomicU64, Ordering},
        mpsc::{RecvTimeoutError, channel},
    },
    time::Duration,
};

use machband::{
    system::{checkpoint, stop_with},
    work::Watcher,
};
use pyo3::{exceptions::PyRuntimeError, prelude::*};
use rayon::{ThreadPool, ThreadPoolBuilder};

/// How often a waiting function looks for Ctrl+C and reports progress.
const INTERVAL: Duration = Duration::from_millis(100);
/// How long a function waits for work that was stopped. Most work looks for a stop far more often.
const PATIENCE: Duration = Duration::from_secs(5);

/// A running computation, as it sees itself.
pub struct Job {
    done: AtomicU64,
    total: AtomicU64,
    warnings: Mutex<Vec<String>>,
    /// Whether it should end.
    stop: Arc<AtomicBool>,
}

impl Watcher for Job {
    fn progress(&self, done: u64, total: u64) {
        checkpoint();
        self.done.fetch_max(done, Ordering::Relaxed);
        self.total.store(total, Ordering::Relaxed);
    }

    fn warn(&self, warning: &str) {
        self.warnings.lock().unwrap_or_else(PoisonError::into_inner).push(warning.to_owned());
    }

    /// Ends a simulation cleanly, whose own threads no [`checkpoint`] stops.
    fn check(&self, place: &Path) -> anyhow::Result<()> {
        anyhow::ensure!(!self.stop.load(Ordering::Relaxed), "{}: stopped", place.display());
        Ok(())
    }
}

/// Threads for one job at a time, so that it can be stopped without stopping others.
struct Threads {
    pool: ThreadPool,
    stop: Arc<AtomicBool>,
    /// A fork copies no threads, so a child process cannot use those of its parent.
    process: u32,
}

impl Threads {
    /// Returns threads that have no job.
    fn free() -> PyResult<Self> {
        let mut idle = IDLE.lock().unwrap_or_else(PoisonError::into_inner);
        while let Some(threads) = idle.pop() {
            if threads.process == std::process::id() {
                return Ok(threads);
            }
            // They do not exist in this process, so they cannot be joined.
            std::mem::forget(threads);
        }
        let stop = Arc::new(AtomicBool::new(false));
        let token = Arc::clone(&stop);
        let pool = ThreadPoolBuilder::new().start_handler(move |_| stop_with(Arc::clone(&token))).build();
        let pool = pool.map_err(|error| PyRuntimeError::new_err(format!("threads: {error}")))?;
        Ok(Self { pool, stop, process: std::process::id() })
    }
}

/// The threads without a job.
static IDLE: Mutex<Vec<Threads>> = Mutex::new(Vec::new());

/// Runs `work` and waits for it. `progress` is called with the work done and the total, several times a second, if they
/// are known. Ctrl+C stops the work, and the call returns when it has ended, or after [`PATIENCE`] unless `writes` is
/// set.
pub fn run<T: Send + 'static>(
    py: Python<'_>,
    progress: Option<Py<PyAny>>,
    writes: bool,
    work: impl FnOnce(&Job) -> anyhow::Result<T> + Send + 'static,
) -> PyResult<T> {
    let (send, receive) = channel();
    let threads = Threads::free()?;
    let (done, total, stop) = (AtomicU64::new(0), AtomicU64::new(0), Arc::clone(&threads.stop));
    let job = Arc::new(Job { done, total, warnings: Mutex::default(), stop });
    let running = Arc::clone(&job);
    threads.pool.spawn(move || {
        let _ = send.send(catch_unwind(AssertUnwindSafe(|| work(&running))));
    });
    // A receiver cannot be shared between threads, and to give up the lock counts as changing the thread.
    let receive = Mutex::new(receive);
    let wait = |interval| py.detach(|| receive.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(interval));
    let mut result = wait(INTERVAL);
    while matches!(result, Err(RecvTimeoutError::Timeout)) {
        let (done, total) = (job.done.load(Ordering::Relaxed), job.total.load(Ordering::Relaxed));
        let report = || progress.as_ref().filter(|_| total > 0).map(|report| report.call1(py, (done, total)));
        if let Err(error) = py.check_signals().and_then(|()| report().transpose()) {
            job.stop.store(true, Ordering::Relaxed);
            // The threads end with the job.
            let _ = wait(if writes { Duration::MAX } else { PATIENCE });
            return Err(error);
        }
        result = wait(INTERVAL);
    }
    IDLE.lock().unwrap_or_else(PoisonError::into_inner).push(threads);
    let result = match result {
        Ok(Ok(result)) => result.map_err(|error| crate::raised(py, &error)),
        Ok(Err(panic)) => Err(PyRuntimeError::new_err(panic_text(&*panic))),
        Err(_) => Err(PyRuntimeError::new_err("the computation ended without a result")),
    }?;
    warn(py, &job.warnings.lock().unwrap_or_else(PoisonError::into_inner))?;
    Ok(result)
}

fn panic_text(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str).or_else(|| panic.downcast_ref::<&str>().copied());
    format!("an error in machband itself, which should be reported: {}", text.unwrap_or("no message"))
}

/// Issues Python warnings.
pub fn warn(py: Python<'_>, warnings: &[String]) -> PyResult<()> {
    let module = py.import("warnings")?;
    for warning in warnings {
        // The caller of the function in the package.
        module.call_method1("warn", (warning, py.get_type::<pyo3::exceptions::PyUserWarning>(), 3))?;
    }
    Ok(())
}
