//! The desktop's own file dialogs, beside the window's loop so that it goes on drawing.

use std::{
    path::PathBuf,
    sync::mpsc::{Receiver, channel},
    time::{Duration, Instant},
};

use eframe::egui;

/// What is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ask {
    /// A TOML file.
    Toml,
    /// An OBJ file.
    Obj,
    /// CSV files, one or more.
    Data,
    /// A folder.
    Folder,
}

/// A dialog that may be open.
#[derive(Default)]
pub struct Dialog {
    answer: Option<Receiver<Option<Vec<PathBuf>>>>,
    opened: Option<Instant>,
    missing: bool,
}

impl Dialog {
    /// Opens it, unless it is open already.
    pub fn open(&mut self, ctx: &egui::Context, ask: Ask) {
        if self.answer.is_some() {
            return;
        }
        let (send, receive) = channel();
        let ctx = ctx.clone();
        std::thread::spawn(move || {
            let dialog = rfd::FileDialog::new();
            let one = |path: Option<PathBuf>| path.map(|path| vec![path]);
            let paths = match ask {
                Ask::Toml => one(dialog.add_filter("TOML", &["toml"]).pick_file()),
                Ask::Obj => one(dialog.add_filter("OBJ", &["obj"]).pick_file()),
                Ask::Data => dialog.add_filter("CSV", &["csv"]).add_filter("all files", &["*"]).pick_files(),
                Ask::Folder => one(dialog.pick_folder()),
            };
            // The window may be gone; then nobody needs the answer.
            let _ = send.send(paths);
            ctx.request_repaint();
        });
        self.answer = Some(receive);
        self.opened = Some(Instant::now());
        self.missing = false;
    }

    /// Whether the last one never opened.
    pub fn is_missing(&self) -> bool {
        self.missing
    }

    /// The path chosen, once; of several the first.
    pub fn take(&mut self) -> Option<PathBuf> {
        self.take_all()?.into_iter().next()
    }

    /// All paths chosen, once.
    pub fn take_all(&mut self) -> Option<Vec<PathBuf>> {
        let answer = self.answer.as_ref()?.try_recv();
        match answer {
            Ok(paths) => {
                self.answer = None;
                // Nobody closes a dialog this fast: there was none. The system does not say so itself.
                let at_once = self.opened.is_some_and(|opened| opened.elapsed() < Duration::from_millis(400));
                self.missing = paths.is_none() && at_once;
                paths
            }
            Err(std::sync::mpsc::TryRecvError::Disconnected) => {
                self.answer = None;
                None
            }
            Err(std::sync::mpsc::TryRecvError::Empty) => None,
        }
    }
}
