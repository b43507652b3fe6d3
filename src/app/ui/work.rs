//! Long computations on separate threads, so that the window stays responsive.

use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicU64, Ordering},
        mpsc::{Receiver, TryRecvError, channel},
    },
    thread::available_parallelism,
};

use eframe::egui;
use rayon::ThreadPoolBuilder;

use super::{text::secondary, theme::ink};
use crate::{
    report::document::numbers::whole,
    system::{run_on_thread, stop_with, threads},
};

/// A running computation. If it is dropped before it is done, its result is lost.
pub struct BackgroundTask<T> {
    result: Receiver<T>,
    /// Becomes true when the task is dropped.
    dropped: Arc<AtomicBool>,
}

/// A computation ended without a result, because of an error in the program, not in the data.
pub struct Lost;

impl<T: Send + 'static> BackgroundTask<T> {
    /// Starts a computation on a separate thread. The window is drawn again when it ends.
    pub fn start(ctx: &egui::Context, compute: impl FnOnce() -> T + Send + 'static) -> Self {
        let (send, receive) = channel();
        let ctx = ctx.clone();
        // If the system cannot create a thread, the channel is closed too, and the work counts as lost.
        let _ = run_on_thread(move || {
            // Dropped last, even if the computation panics, so that the window then finds the channel closed.
            let _repaint = Repaint(ctx);
            let send = send;
            // If newer work has replaced this, nobody needs the result.
            let _ = send.send(compute());
        });
        Self { result: receive, dropped: Arc::default() }
    }

    /// Starts a long computation, which ends at its next checkpoint once the task is dropped. It has its own threads, so
    /// that no other computation waits for it.
    pub fn stoppable(ctx: &egui::Context, compute: impl FnOnce() -> T + Send + 'static) -> Self {
        let dropped = Arc::<AtomicBool>::default();
        let stop = dropped.clone();
        let mut task = Self::start(ctx, move || {
            let Ok((count, begin)) = threads(available_parallelism().map_or(1, usize::from)) else { return compute() };
            let pool = ThreadPoolBuilder::new().num_threads(count).start_handler(move |_| stop_with(stop.clone()));
            match pool.spawn_handler(begin).build() {
                Ok(pool) => pool.install(compute),
                Err(_) => compute(),
            }
        });
        task.dropped = dropped;
        task
    }

    /// Returns the result, which is returned only once; `None` while the computation is running.
    pub fn poll(&self) -> Option<Result<T, Lost>> {
        match self.result.try_recv() {
            Err(TryRecvError::Empty) => None,
            result => Some(result.map_err(|_| Lost)),
        }
    }
}

impl<T> Drop for BackgroundTask<T> {
    fn drop(&mut self) {
        self.dropped.store(true, Ordering::Relaxed);
    }
}

/// How many steps of a computation are done, and of how many.
#[derive(Default)]
pub struct Steps {
    done: AtomicU64,
    all: AtomicU64,
}

impl Steps {
    pub fn set(&self, done: u64, all: u64) {
        self.all.store(all, Ordering::Relaxed);
        // Steps may end out of order.
        self.done.fetch_max(done, Ordering::Relaxed);
    }

    /// Draws how far it is: `Checking: 3 of 8 sessions`. `what` is the computation, and `items` is what is counted.
    pub fn show(&self, ui: &mut egui::Ui, what: &str, items: &str) {
        let [done, all] = [&self.done, &self.all].map(|count| count.load(Ordering::Relaxed));
        let share = done as f32 / all.max(1) as f32;
        ui.add(egui::ProgressBar::new(share).desired_width(96.0).desired_height(4.0).fill(ink(ui).dim));
        // Its length changes, so it is last.
        ui.label(secondary(match all {
            0 => format!("{what}…"),
            _ => format!("{what}: {} of {} {items}", whole(done), whole(all)).trim_end().to_owned(),
        }));
        ui.ctx().request_repaint_after_secs(0.1);
    }
}

/// A value that is made again only for another key.
pub struct Kept<K, T>(Option<(K, T)>);

impl<K, T> Default for Kept<K, T> {
    fn default() -> Self {
        Self(None)
    }
}

impl<K: PartialEq, T> Kept<K, T> {
    /// Returns the value for a key.
    pub fn get(&mut self, key: K, make: impl FnOnce() -> T) -> &mut T {
        let made = match self.0.take() {
            Some((of, made)) if of == key => made,
            _ => make(),
        };
        &mut self.0.insert((key, made)).1
    }

    /// Returns the last value.
    pub fn last(&self) -> Option<&T> {
        self.0.as_ref().map(|(_, made)| made)
    }
}

/// Requests a repaint of the window when it goes out of scope.
struct Repaint(egui::Context);

impl Drop for Repaint {
    fn drop(&mut self) {
        self.0.request_repaint();
    }
}

/// Runs one computation at a time, for the last requested key. A new one begins when the previous one is done.
pub struct Latest<K, T> {
    running: Option<(K, BackgroundTask<Result<T, String>>)>,
    done: Option<(K, Result<T, String>)>,
}

impl<K, T> Default for Latest<K, T> {
    fn default() -> Self {
        Self { running: None, done: None }
    }
}

impl<K: PartialEq, T: Send + 'static> Latest<K, T> {
    /// Ensures that the result for `key` is computed. `job` is called when the computation is about to begin, and
    /// returns it.
    pub fn want<F>(&mut self, ctx: &egui::Context, key: K, job: impl FnOnce() -> F)
    where
        F: FnOnce() -> Result<T, String> + Send + 'static,
    {
        self.take();
        let is_done = self.done.as_ref().is_some_and(|(done, _)| *done == key);
        if self.running.is_none() && !is_done {
            self.running = Some((key, BackgroundTask::start(ctx, job())));
        }
    }

    /// Stores a result that was computed at once.
    pub fn put(&mut self, key: K, result: Result<T, String>) {
        (self.running, self.done) = (None, Some((key, result)));
    }

    /// Returns the result for exactly this key, once it is available.
    pub fn get(&self, key: &K) -> Option<&Result<T, String>> {
        self.done.as_ref().filter(|(done, _)| done == key).map(|(_, result)| result)
    }

    /// Returns the last result, whatever its key.
    pub fn last(&self) -> Option<&Result<T, String>> {
        self.done.as_ref().map(|(_, result)| result)
    }

    fn take(&mut self) {
        let Some((key, work)) = self.running.take() else { return };
        match work.poll() {
            None => self.running = Some((key, work)),
            Some(result) => {
                self.done = Some((key, result.unwrap_or_else(|Lost| Err("it could not be computed".to_owned()))));
            }
        }
    }
}
