//! Work that runs without the interpreter's lock, reports its progress, and stops on Ctrl+C.

use std::{
    any::Any,
    panic::{AssertUnwindSafe, catch_unwind, resume_unwind},
    path::Path,
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicBool, AtomicU64, Ordering},
        mpsc::{RecvTimeoutError, channel},
    },
    time::Duration,
};

use machband::cli::simulate::Watcher;
use pyo3::{exceptions::PyRuntimeError, prelude::*};
use rayon::{ThreadPool, ThreadPoolBuilder};

/// How often a waiting function looks for Ctrl+C and reports progress.
const INTERVAL: Duration = Duration::from_millis(100);

/// A running computation, as it sees itself.
#[derive(Default)]
pub struct Job {
    stopped: AtomicBool,
    done: AtomicU64,
    total: AtomicU64,
    warnings: Mutex<Vec<String>>,
}

/// The computation was stopped.
struct Stopped;

impl Job {
    /// Notes how much of the work is done. Ends the computation if it was stopped.
    pub fn set(&self, done: usize, total: usize) {
        self.done.store(done as u64, Ordering::Relaxed);
        self.total.store(total as u64, Ordering::Relaxed);
        if self.is_stopped() {
            resume_unwind(Box::new(Stopped));
        }
    }

    pub fn start(&self, total: u64) {
        self.total.store(total, Ordering::Relaxed);
    }

    pub fn is_stopped(&self) -> bool {
        self.stopped.load(Ordering::Relaxed)
    }
}

impl Watcher for Job {
    fn advance(&self, trials: u64) {
        self.done.fetch_add(trials, Ordering::Relaxed);
    }

    fn warn(&self, warning: &str) {
        self.warnings.lock().unwrap_or_else(PoisonError::into_inner).push(warning.to_owned());
    }

    fn check(&self, place: &Path) -> anyhow::Result<()> {
        anyhow::ensure!(!self.is_stopped(), "{}: stopped", place.display());
        Ok(())
    }
}

/// Returns the threads of this process. A fork copies no threads, so a child process gets new ones.
fn pool() -> PyResult<Arc<ThreadPool>> {
    static POOL: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);
    let mut pool = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    let process = std::process::id();
    if let Some((owner, threads)) = pool.as_ref()
        && *owner == process
    {
        return Ok(Arc::clone(threads));
    }
    let threads = ThreadPoolBuilder::new().build();
    let threads = Arc::new(threads.map_err(|error| PyRuntimeError::new_err(format!("threads: {error}")))?);
    // The threads of the parent do not exist here, so they cannot be joined.
    std::mem::forget(pool.replace((process, Arc::clone(&threads))));
    Ok(threads)
}

/// Runs `work` and waits for it. `progress` is called with the work done and the total, several times a second, if they
/// are known. Ctrl+C stops the work; if `writes` is set, the call waits until the work has ended cleanly.
pub fn run<T: Send + 'static>(
    py: Python<'_>,
    progress: Option<Py<PyAny>>,
    writes: bool,
    work: impl FnOnce(&Job) -> anyhow::Result<T> + Send + 'static,
) -> PyResult<T> {
    let job = Arc::new(Job::default());
    let (send, receive) = channel();
    let running = Arc::clone(&job);
    pool()?.spawn(move || {
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
            job.stopped.store(true, Ordering::Relaxed);
            if writes {
                let _ = wait(Duration::from_secs(3600));
            }
            return Err(error);
        }
        result = wait(INTERVAL);
    }
    let result = match result {
        Ok(Ok(result)) => result.map_err(|error| crate::error(format!("{error:#}"))),
        Ok(Err(panic)) => Err(PyRuntimeError::new_err(panic_text(&*panic))),
        Err(_) => Err(PyRuntimeError::new_err("the computation ended without a result")),
    }?;
    let warnings = std::mem::take(&mut *job.warnings.lock().unwrap_or_else(PoisonError::into_inner));
    warn(py, &warnings)?;
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
