//! Everything needed to reproduce the report.

use jiff::Timestamp;

use crate::{
    experiment::Protocol,
    report::document::{Section, TableOf, whole},
    store::ratings::Source,
};

/// How an analysis was performed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Provenance {
    /// The command line, quoted for a shell.
    pub command: String,
    /// When the report was made.
    pub made_at: Timestamp,
}

impl Provenance {
    /// Describes an analysis by this program with this command at this time.
    pub fn new(command: impl Into<String>, made_at: Timestamp) -> Self {
        Self { command: command.into(), made_at }
    }

    /// Says how to repeat an analysis, and how its page was created.
    pub fn tell(&self, section: &mut Section) {
        section.text("The same program, command and files produce the same numbers on every machine.");
        section.code(self.command.clone());
        let facts = [
            ("Program", format!("machband {}", env!("CARGO_PKG_VERSION"))),
            ("Commit", env!("MACHBAND_COMMIT").to_owned()),
            ("Created at", self.made_at.strftime("%Y-%m-%d %H:%M:%S UTC").to_string()),
        ];
        section.facts("How this page was created", facts);
    }
}

pub(super) fn section(source: &Source, provenance: &Provenance) -> Section {
    let mut section = Section::new("repeat", "Repeat this analysis");
    provenance.tell(&mut section);
    TableOf::new("Files", &source.files)
        .text("File", |file| file.path.display().to_string())
        .text("SHA-256", |file| file.sha256.as_deref().unwrap_or("not computed"))
        .number("Rows", |file| whole(file.rows))
        .number("Rows that count", |file| whole(file.counted))
        .add_to(&mut section);
    definition(&mut section, source.protocol.as_ref());
    section
        .list(source.definition_sha256.iter().map(|hash| format!("SHA-256 of its canonical form: {hash}")).collect());
    section
}

/// Shows the definition of a study.
pub(crate) fn definition(section: &mut Section, protocol: Option<&Protocol>) {
    if let Some(protocol) = protocol {
        section.heading("The definition");
        section.code(toml::to_string(protocol).unwrap_or_else(|error| format!("# cannot be written: {error}")));
    }
}
