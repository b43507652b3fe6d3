//! Threads. If the system refuses to create one, the program uses fewer or reports an error.

use std::{
    cell::RefCell,
    io,
    panic::resume_unwind,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
        mpsc::{Sender, channel},
    },
    thread::{self, Builder},
};

use rayon::{ThreadBuilder, ThreadPoolBuilder};

thread_local! {
    static STOP: RefCell<Option<Arc<AtomicBool>>> = const { RefCell::new(None) };
}

/// The panic of a computation that was stopped.
#[derive(Debug)]
pub struct Stopped;

/// Lets another thread stop the computations on this one: each ends at its next [`checkpoint`] once `stop` is true.
pub fn stop_with(stop: Arc<AtomicBool>) {
    STOP.set(Some(stop));
}

/// Ends the computation if it was stopped, by unwinding with [`Stopped`]. Long computations call this once for each row
/// or iteration; on a thread without [`stop_with`], it does nothing.
pub fn checkpoint() {
    let is_stopped = STOP.with_borrow(|stop| stop.as_ref().is_some_and(|stop| stop.load(Ordering::Relaxed)));
    if is_stopped {
        resume_unwind(Box::new(Stopped));
    }
}

/// Runs `work` on a new thread.
///
/// # Errors
/// The system cannot create a thread; `work` is then dropped.
pub fn run_on_thread(work: impl FnOnce() + Send + 'static) -> io::Result<()> {
    Builder::new().spawn(work).map(drop)
}

/// Creates up to `most` threads for a pool; returns their number, and a function that gives each of them its work in
/// the pool.
///
/// # Errors
/// The system cannot create even one thread.
pub fn threads(most: usize) -> Result<(usize, impl FnMut(ThreadBuilder) -> io::Result<()>), ThreadError> {
    let mut waiting: Vec<Sender<ThreadBuilder>> = Vec::new();
    while waiting.len() < most.max(1) {
        let (send, receive) = channel::<ThreadBuilder>();
        let work = move || _ = receive.recv().map(ThreadBuilder::run);
        match run_on_thread(work) {
            Ok(()) => waiting.push(send),
            Err(error) if waiting.is_empty() => return Err(ThreadError(error)),
            Err(_) => break,
        }
    }
    let count = waiting.len();
    let begin = move |thread| {
        let next = waiting.pop().ok_or(io::ErrorKind::OutOfMemory)?;
        next.send(thread).map_err(|_| io::ErrorKind::BrokenPipe.into())
    };
    Ok((count, begin))
}

/// Creates the threads that all computations share. Without this, the first computation would panic if the system
/// cannot create as many threads as there are cores.
///
/// # Errors
/// The system cannot create even one thread.
pub fn start_threads() -> Result<(), ThreadError> {
    let cores = thread::available_parallelism().map_or(1, usize::from);
    let (count, begin) = threads(cores)?;
    let pool = ThreadPoolBuilder::new().num_threads(count).spawn_handler(begin);
    pool.build_global().map_err(|error| ThreadError(io::Error::other(error)))
}

/// The system cannot create a thread.
#[derive(Debug, thiserror::Error)]
#[error("threads: cannot create a thread ({0}); expected a system with fewer processes or a higher limit (ulimit -u)")]
pub struct ThreadError(io::Error);
