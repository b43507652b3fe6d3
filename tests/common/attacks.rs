//! The table of attacks, of which `docs/faults.md` has a summary. `scripts/attacks.sh` runs all attacks and adds up what
//! they print.

use std::io::Write as _;

/// What an attack must not cause; a column of the table.
pub const ROWS: &str = "rows lost";
pub const FILES: &str = "files destroyed";
pub const LIES: &str = "silent lies";
pub const PANICS: &str = "panics";
pub const HANGS: &str = "hangs";
pub const ALL: [&str; 5] = [ROWS, FILES, LIES, PANICS, HANGS];

/// Prints how many attacks of a class were made. A test calls this after its assertions, so that the attacks caused
/// none of what was `checked`.
pub fn withstood(class: &str, attacks: usize, checked: &[&str]) {
    let cells = ALL.map(|what| if checked.contains(&what) { "0" } else { "–" });
    // Not with `println!`, because the test harness captures it.
    let _ = writeln!(std::io::stderr(), "ATTACKS | {class} | {attacks} | {} |", cells.join(" | "));
}
