//! How a terminal shows the progress of an operation.

use std::{
    path::Path,
    sync::atomic::{AtomicBool, Ordering},
    thread::sleep,
    time::Duration,
};

use indicatif::{ProgressBar, ProgressStyle};

use super::print::print_line;
use crate::{
    report::terminal::message,
    system::{run_on_thread, signals},
    work::Watcher,
};

/// A progress bar, or a spinner while progress cannot be measured. Nothing is shown unless stderr is a terminal.
pub(super) struct Bar {
    bar: ProgressBar,
    /// True until progress can be measured.
    spins: AtomicBool,
}

impl Bar {
    /// Creates a bar; `what` names the steps that are counted.
    pub fn new(what: &str) -> Self {
        let template = format!("{{bar:40}} {{pos}}/{{len}} {what}, {{eta}} to go");
        let style = ProgressStyle::with_template(&template).unwrap_or_else(|_| ProgressStyle::default_bar());
        Self { bar: ProgressBar::no_length().with_style(style), spins: AtomicBool::new(false) }
    }

    /// Creates a spinner for work whose progress is not counted.
    pub fn spinner(what: &'static str) -> Self {
        let spinner = ProgressBar::new_spinner().with_message(what);
        let turning = spinner.clone();
        // `enable_steady_tick` would panic if the system cannot create a thread; the text is then shown without the
        // moving spinner.
        let turned = run_on_thread(move || {
            while !turning.is_finished() {
                turning.tick();
                sleep(Duration::from_millis(120));
            }
        });
        if turned.is_err() {
            spinner.tick();
        }
        Self { bar: spinner, spins: AtomicBool::new(true) }
    }

    /// Removes the bar from the screen.
    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }

    /// Prints something above the bar.
    pub fn above<T>(&self, print: impl FnOnce() -> T) -> T {
        self.bar.suspend(print)
    }
}

impl Watcher for Bar {
    fn stage(&self, what: &'static str) {
        self.bar.set_message(what);
        if !self.spins.swap(true, Ordering::Relaxed) {
            self.bar.set_style(ProgressStyle::default_spinner());
        }
    }

    fn progress(&self, done: u64, total: u64) {
        if self.spins.swap(false, Ordering::Relaxed) {
            let style = ProgressStyle::with_template("{spinner} {msg}: {pos} of {len}");
            self.bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()));
        }
        self.bar.set_length(total);
        // Steps may end out of order.
        self.bar.set_position(done.max(self.bar.position()));
    }

    fn warn(&self, warning: &str) {
        self.above(|| message("warning", warning));
    }

    fn found(&self, file: &Path, sentence: &str) -> anyhow::Result<()> {
        self.above(|| print_line(&format!("{}: {sentence}", file.display())))
    }

    fn check(&self, place: &Path) -> anyhow::Result<()> {
        signals::check(place)
            .map_err(|ended| anyhow::anyhow!("{ended}; to continue, use the same command with --resume"))
    }
}
