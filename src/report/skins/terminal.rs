//! A section as text: one line a paragraph, so that the terminal breaks it.

use crate::report::document::{Block, Section};

/// The lines of a section. Tables and charts are in files.
pub fn terminal(section: &Section) -> Vec<String> {
    let mut lines = Vec::new();
    for block in &section.blocks {
        match block {
            Block::Text(text) | Block::Note(text) | Block::Code(text) => lines.push(text.clone()),
            Block::Heading(text) => lines.push(format!("{text}:")),
            Block::Warning(text) => lines.push(format!("warning: {text}")),
            Block::List(items) => lines.extend(items.iter().map(|item| format!("- {item}"))),
            Block::Table(_) | Block::Figure(_) => {}
        }
    }
    lines
}
