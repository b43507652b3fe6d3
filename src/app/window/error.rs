//! Why there is no window.

use std::path::{Path, PathBuf};

/// Why there is no window.
#[derive(Debug, thiserror::Error)]
pub enum WindowError {
    /// No display to open a window on.
    #[error(
        "display: no window can be opened, since neither DISPLAY nor WAYLAND_DISPLAY is set; expected a desktop session (without one, `machband simulate` runs sessions with a simulated observer)"
    )]
    NoDisplay,
    /// The window system or the graphics driver refused.
    #[error(
        "display: no window can be opened ({0}); expected a desktop session with Vulkan or OpenGL (without one, `machband simulate` runs sessions with a simulated observer)"
    )]
    Refused(String),
    /// The window system or the graphics driver went away while the window was open.
    #[error("{}", lost(reason, rows.as_deref()))]
    Lost {
        /// The reason they gave.
        reason: String,
        /// Where the rows of the running session are.
        rows: Option<PathBuf>,
    },
}

fn lost(reason: &str, rows: Option<&Path>) -> String {
    let (place, kept) = match rows {
        Some(rows) => (
            rows.display().to_string(),
            "every answer that was saved is there; expected the same command with --resume, or Home with the same participant and session, to resume it",
        ),
        None => ("display".to_owned(), "expected a window system and graphics that stay"),
    };
    format!("{place}: the window was lost ({reason}); {kept}")
}
