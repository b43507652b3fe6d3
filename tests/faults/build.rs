//! Libraries for tests, built from C by the compiler that links Rust programs too.

use std::{io::Write as _, path::Path, process::Command};

/// Builds `tests/faults/NAME.c`. `false`, said aloud, where that cannot be, unless `MACHBAND_REQUIRE_FAULTS=1`.
pub fn library(name: &str, to: &Path) -> bool {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/faults").join(name).with_extension("c");
    let mut compiler = Command::new("cc");
    compiler.args(["-O1", "-Wall", "-Wextra", "-shared", "-fPIC", "-o"]).arg(to).arg(source).arg("-ldl");
    let why = match compiler.output() {
        Ok(output) if output.status.success() => return true,
        Ok(output) => String::from_utf8_lossy(&output.stderr).into_owned(),
        Err(error) => format!("cc: {error}"),
    };
    skip(&why);
    false
}

/// Says that nothing is injected, which `MACHBAND_REQUIRE_FAULTS=1` does not allow.
pub fn skip(why: &str) {
    assert!(std::env::var_os("MACHBAND_REQUIRE_FAULTS").is_none_or(|value| value != "1"), "no faults injected: {why}");
    // Not by eprintln, which the test harness keeps to itself.
    let _ = writeln!(std::io::stderr(), "SKIPPED: no faults are injected, since {why}");
}
