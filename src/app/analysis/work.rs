//! What takes its time runs beside the window's loop, so that the window goes on drawing.

use std::sync::mpsc::{Receiver, TryRecvError, channel};

use eframe::egui;

/// Something that is being computed. Dropped before its end, nobody hears of its result.
pub struct Work<T>(Receiver<T>);

/// How far work has come.
pub enum Progress<T> {
    /// It goes on.
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

    /// Looks how far it is.
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
