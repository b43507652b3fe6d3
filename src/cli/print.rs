//! What commands write to standard output.

use std::io::{self, Write as _};

use crate::report::terminal::printable;

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
