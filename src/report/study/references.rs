//! The literature behind the methods.

use std::collections::BTreeSet;

use crate::report::document::Section;

/// One publication a line, by name: how a text cites it, a tab, and its entry in the list.
const PUBLICATIONS: &str = include_str!("references.txt");

/// What a text cites.
#[derive(Default)]
pub(super) struct Cited(BTreeSet<&'static str>);

impl Cited {
    /// Publications as a text cites them, separated by semicolons: gives the same text.
    pub fn cite(&mut self, publications: &'static str) -> &'static str {
        self.0.extend(publications.split("; "));
        publications
    }
}

/// The list, by name, each once.
pub(super) fn section(cited: &Cited) -> Section {
    let mut section = Section::new("references", "References");
    let publications = PUBLICATIONS.lines().filter_map(|line| line.split_once('\t'));
    let entries: Vec<String> =
        publications.filter(|(short, _)| cited.0.contains(short)).map(|(_, entry)| entry.to_owned()).collect();
    debug_assert_eq!(entries.len(), cited.0.len(), "every publication has an entry: {:?}", cited.0);
    section.list(entries);
    section
}
