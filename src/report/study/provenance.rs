//! Everything needed to reproduce the report.

use jiff::Timestamp;

use crate::{
    analysis::Results,
    report::document::{Section, numbers::whole},
    store::ratings::{FileRead, Layout, Source},
};

/// How an analysis was performed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Provenance {
    /// The program's version.
    pub version: String,
    /// The commit it was built from, or `unknown`.
    pub commit: String,
    /// The command line, quoted for a shell.
    pub command: String,
    /// When the report was made.
    pub made_at: Timestamp,
}

impl Provenance {
    /// Describes an analysis by this program with this command at this time.
    pub fn new(command: impl Into<String>, made_at: Timestamp) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            commit: env!("MACHBAND_COMMIT").to_owned(),
            command: command.into(),
            made_at,
        }
    }
}

impl Provenance {
    /// Says how to repeat an analysis, and how its page was created; `further` are other facts.
    pub fn tell(&self, section: &mut Section, further: impl IntoIterator<Item = (&'static str, String)>) {
        section.text("The same program, command and files produce the same numbers on every machine.");
        section.code(self.command.clone());
        let facts = [
            ("Program", format!("machband {}", self.version)),
            ("Commit", self.commit.clone()),
            ("Created at", self.made_at.strftime("%Y-%m-%d %H:%M:%S UTC").to_string()),
        ];
        section.facts("How this page was created", facts.into_iter().chain(further));
    }
}

/// Returns this program's name and the arguments, quoted for a POSIX shell.
pub fn shell_command(arguments: impl IntoIterator<Item = String>) -> String {
    let command: Vec<String> = std::iter::once(env!("CARGO_PKG_NAME").to_owned()).chain(arguments).collect();
    // Quoting fails only for a zero byte, which no shell can pass to a program.
    shlex::try_join(command.iter().map(String::as_str)).unwrap_or_default()
}

pub(super) fn section(source: &Source, results: &Results, provenance: &Provenance) -> Section {
    let mut section = Section::new("repeat", "Repeat this analysis");
    let resampling = results.options.resampling;
    let further = [
        ("Seed of the simulated studies", resampling.seed.to_string()),
        ("Simulated studies, at most", whole(resampling.draws.into()).to_string()),
    ];
    provenance.tell(&mut section, further);
    let row = |file: &FileRead| {
        let layout = match file.layout {
            Layout::Results => "results",
            Layout::Counts => "counts",
            Layout::Long => "long table",
        };
        let hash = file.sha256.clone().unwrap_or_else(|| "not computed".to_owned());
        vec![file.path.display().to_string().into(), layout.into(), hash.into(), whole(file.rows), whole(file.counted)]
    };
    let texts = ["File", "Kind", "SHA-256"];
    section.table("Files", &texts, &["Rows", "Rows that count"], source.files.iter().map(row).collect());
    if let Some(protocol) = &source.protocol {
        section.heading("The definition");
        if let Some(hash) = &source.definition_sha256 {
            section.text(format!("The SHA-256 of the definition in its canonical form is {hash}."));
        }
        section.code(toml::to_string(protocol).unwrap_or_else(|error| format!("# cannot be written: {error}")));
    }
    section
}
