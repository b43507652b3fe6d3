//! Everything that is needed to make the same report again.

use jiff::Timestamp;
use maud::{Markup, html};

use crate::report::document::numbers::whole;
use crate::report::skins::html::table::{Kind, table};
use crate::{
    analysis::Results,
    store::ratings::{FileRead, Layout, Source},
};

/// How an analysis was made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Repetition {
    /// The program's version.
    pub version: String,
    /// The commit it was built from, or `unknown`.
    pub commit: String,
    /// The command line, as a shell takes it.
    pub command: String,
    /// When.
    pub made_at: Timestamp,
}

impl Repetition {
    /// An analysis by this program, by this command, at this time.
    pub fn new(command: impl Into<String>, made_at: Timestamp) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            commit: env!("MACHBAND_COMMIT").to_owned(),
            command: command.into(),
            made_at,
        }
    }

    /// An analysis by the process that runs, now: its arguments, the program by its name alone.
    pub fn of_process() -> Self {
        let arguments = std::env::args_os().skip(1).map(|argument| quoted(&argument.to_string_lossy()));
        let command: Vec<String> = std::iter::once(env!("CARGO_PKG_NAME").to_owned()).chain(arguments).collect();
        Self::new(command.join(" "), Timestamp::now())
    }
}

/// An argument as a POSIX shell takes it.
fn quoted(argument: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./,:=+@%".contains(c);
    if !argument.is_empty() && argument.chars().all(plain) {
        argument.to_owned()
    } else {
        format!("'{}'", argument.replace('\'', r"'\''"))
    }
}

/// The section.
pub(crate) fn section(source: &Source, results: &Results, how: &Repetition) -> Markup {
    let bootstrap = &results.options.bootstrap;
    let row = |what: &str, value: String| vec![what.to_owned(), value];
    let terms = results.spec.terms.to_string();
    let rows = vec![
        row("Program", format!("machband {}", how.version)),
        row("Commit", how.commit.clone()),
        row("Made at", how.made_at.strftime("%Y-%m-%d %H:%M:%S UTC").to_string()),
        row("Terms", if terms.is_empty() { "none".to_owned() } else { terms }),
        row("Link", results.spec.link.to_string()),
        row("Quadrature nodes", results.spec.quadrature.to_string()),
        row("Seed of the bootstrap", bootstrap.seed.to_string()),
        row("Bootstrap samples", whole(bootstrap.replicates as u64)),
    ];
    html! {
        p { "The same program, command and files give the same numbers on every machine." }
        pre { code { (how.command) } }
        (table("How this page was made", &[("What", Kind::Text), ("Value", Kind::Code)], rows))
        (files(source))
        (definition(source))
    }
}

fn files(source: &Source) -> Markup {
    let columns = [
        ("File", Kind::Code),
        ("Kind", Kind::Text),
        ("Rows", Kind::Number),
        ("Rows that count", Kind::Number),
        ("SHA-256", Kind::Code),
    ];
    let row = |file: &FileRead| {
        let layout = match file.layout {
            Layout::Results => "results",
            Layout::Counts => "counts",
            Layout::Long => "long table",
        };
        vec![
            file.path.display().to_string(),
            layout.to_owned(),
            whole(file.rows),
            whole(file.counted),
            file.sha256.clone().unwrap_or_else(|| "not computed".to_owned()),
        ]
    };
    table("Files", &columns, source.files.iter().map(row).collect::<Vec<_>>())
}

fn definition(source: &Source) -> Markup {
    let Some(protocol) = &source.protocol else { return html! {} };
    let text = toml::to_string(protocol).unwrap_or_else(|error| format!("# not representable: {error}"));
    html! {
        h3 { "The definition" }
        @if let Some(hash) = &source.definition_sha256 {
            p { "SHA-256 of its canonical form: " code.hash { (hash) } }
        }
        details {
            summary { "The definition in full" }
            pre { code { (text) } }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::quoted;

    #[test]
    fn arguments_are_quoted_for_a_shell() {
        assert_eq!(
            ["analyze", "a b", "it's", "", "num:inv_n,width"].map(quoted),
            ["analyze", "'a b'", r"'it'\''s'", "''", "num:inv_n,width"]
        );
    }
}
