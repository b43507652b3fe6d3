//! What commands write to the terminal: lines, data, and the progress of an operation.

use std::{
    io::{self, Write as _},
    path::Path,
    thread::sleep,
    time::Duration,
};

use indicatif::{ProgressBar, ProgressStyle};

use crate::{
    report::terminal::{message, printable},
    system::{run_on_thread, signals},
    work::Watcher,
};

/// Shows what is being done, and how many steps are done if they are counted. Nothing is shown unless stderr is a terminal.
pub(super) struct Bar(ProgressBar);

impl Bar {
    pub fn new(what: &'static str) -> Self {
        let bar = ProgressBar::new_spinner().with_message(what);
        let turning = bar.clone();
        // `enable_steady_tick` would panic if the system cannot create a thread; the text is then shown without the
        // moving spinner.
        let turned = run_on_thread(move || {
            while !turning.is_finished() {
                turning.tick();
                sleep(Duration::from_millis(120));
            }
        });
        if turned.is_err() {
            bar.tick();
        }
        Self(bar)
    }

    /// Removes the bar from the screen.
    pub fn clear(&self) {
        self.0.finish_and_clear();
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.clear();
    }
}

impl Watcher for Bar {
    fn stage(&self, what: &'static str) {
        self.0.set_message(what);
        self.0.unset_length();
        self.0.set_style(ProgressStyle::default_spinner());
    }

    fn progress(&self, done: u64, total: u64) {
        if self.0.length() != Some(total) {
            let style = ProgressStyle::with_template("{spinner} {msg}: {pos} of {len}, {eta} to go");
            self.0.set_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()));
            self.0.set_length(total);
        }
        // Steps may end out of order.
        self.0.set_position(done.max(self.0.position()));
    }

    fn warn(&self, warning: &str) {
        self.0.suspend(|| message("warning", warning));
    }

    fn found(&self, file: &Path, sentence: &str) -> anyhow::Result<()> {
        self.0.suspend(|| print_line(&format!("{}: {sentence}", file.display())))
    }

    fn check(&self, place: &Path) -> anyhow::Result<()> {
        signals::check(place)
            .map_err(|ended| anyhow::anyhow!("{ended}; to continue, use the same command with --resume"))
    }
}

/// Prints one line of text to stdout.
pub(super) fn print_line(line: &str) -> anyhow::Result<()> {
    print_data(format!("{}\n", printable(line)).as_bytes())
}

/// Writes data to stdout unchanged. It is not an error if the reader has already closed the pipe, as `head -1` does.
pub(super) fn print_data(data: &[u8]) -> anyhow::Result<()> {
    match io::stdout().write_all(data) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(anyhow::anyhow!("standard output: cannot write: {error}; expected enough space for the data"))
        }
        _ => Ok(()),
    }
}
