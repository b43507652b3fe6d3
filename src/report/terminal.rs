//! Lines for a terminal.

use std::{borrow::Cow, io::Write as _};

/// Prints each line of a text to stderr, after a word such as `error`, so that a search for `error:` finds all of them.
/// It does not matter if stderr is closed, because the exit status reports a failure too.
pub fn message(kind: &str, text: &str) {
    for line in text.lines() {
        let _ = writeln!(std::io::stderr(), "{kind}: {}", printable(line));
    }
}

/// Escapes the characters that a terminal would act on instead of showing them, such as those that change its colors or
/// its title, or the direction of text. File names and the content of files may contain them.
pub fn printable(text: &str) -> Cow<'_, str> {
    let acts = |c: char| c.is_control() || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    if !text.contains(acts) {
        return Cow::Borrowed(text);
    }
    let shown = |c: char| if acts(c) { c.escape_default().collect() } else { c.to_string() };
    Cow::Owned(text.chars().map(shown).collect())
}
