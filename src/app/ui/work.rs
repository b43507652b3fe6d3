//! Long computations on threads of their own, so that the window is still drawn.

use std::sync::mpsc::{Receiver, TryRecvError, channel};

use eframe::egui;

/// Something that is being computed. If it is dropped before it is done, its result is lost.
pub struct Work<T>(Receiver<T>);

/// How far work has come.
pub enum Progress<T> {
    /// It is not done.
    Going,
    /// Its result, once.
    Done(T),
    /// It ended without a result: a defect of the program, not of the data.
    Lost,
}

impl<T: Send + 'static> Work<T> {
    /// Starts it; the window is drawn again at its end.
    pub fn start(ctx: &egui::Context, compute: impl FnOnce() -> T + Send + 'static) -> Self {
        let (send, receive) = channel();
        let ctx = ctx.clone();
        std::thread::spawn(move || {
            // Dropped last, also where the computation panics: the window then finds nobody at the other end.
            let _repaint = Repaint(ctx);
            let send = send;
            // Newer work may have taken this one's place; then nobody needs the result.
            let _ = send.send(compute());
        });
        Self(receive)
    }

    /// How far it has come.
    pub fn poll(&self) -> Progress<T> {
        match self.0.try_recv() {
            Ok(result) => Progress::Done(result),
            Err(TryRecvError::Empty) => Progress::Going,
            Err(TryRecvError::Disconnected) => Progress::Lost,
        }
    }
}

/// Has the window drawn when it goes out of scope.
struct Repaint(egui::Context);

impl Drop for Repaint {
    fn drop(&mut self) {
        self.0.request_repaint();
    }
}

/// One computation at a time, for the key that was wanted last: a new one begins when the one before is done.
pub struct Latest<K, T> {
    going: Option<(K, Work<Result<T, String>>)>,
    done: Option<(K, Result<T, String>)>,
}

impl<K, T> Default for Latest<K, T> {
    fn default() -> Self {
        Self { going: None, done: None }
    }
}

impl<K: PartialEq, T: Send + 'static> Latest<K, T> {
    /// Sees that the result for `key` comes: `job` is asked for what computes it, when that is to begin.
    pub fn want<F>(&mut self, ctx: &egui::Context, key: K, job: impl FnOnce() -> F)
    where
        F: FnOnce() -> Result<T, String> + Send + 'static,
    {
        self.take();
        let is_done = self.done.as_ref().is_some_and(|(done, _)| *done == key);
        if self.going.is_none() && !is_done {
            self.going = Some((key, Work::start(ctx, job())));
        }
    }

    /// The result for `key`, as soon as it is there; of no other.
    pub fn get(&self, key: &K) -> Option<&Result<T, String>> {
        self.done.as_ref().filter(|(done, _)| done == key).map(|(_, result)| result)
    }

    fn take(&mut self) {
        let Some((key, work)) = self.going.take() else { return };
        match work.poll() {
            Progress::Going => self.going = Some((key, work)),
            Progress::Done(result) => self.done = Some((key, result)),
            Progress::Lost => self.done = Some((key, Err("it could not be computed".to_owned()))),
        }
    }
}
