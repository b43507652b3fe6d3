//! Where the ratings come from, in short; the document has the details.

use eframe::egui::{self, CollapsingHeader, RichText, ScrollArea};

use crate::{
    app::ui::{fault, hint, paragraph, theme},
    report::document::numbers::{count, whole},
    store::ratings::{Layout, SessionRead, Source},
};

/// Faults that are listed.
const MOST_FAULTS: usize = 200;

/// Whether there are unfinished sessions, which can be left out.
pub fn has_unfinished(source: &Source) -> bool {
    source.sessions.iter().any(SessionRead::is_unfinished) || source.files.iter().any(|file| file.unfinished > 0)
}

/// Whether its columns were named.
pub fn has_named_columns(source: &Source) -> bool {
    source.files.iter().any(|file| file.layout == Layout::Long)
}

/// Draws it.
pub fn show(ui: &mut egui::Ui, source: &Source) {
    let title = match (&source.protocol, source.files.first()) {
        (Some(protocol), _) => format!("{}: {}", protocol.name, protocol.title),
        (None, Some(file)) => file.path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        (None, None) => "No file".to_owned(),
    };
    paragraph(ui, RichText::new(title).strong());
    let ratings = source.files.iter().map(|file| file.ratings).sum();
    let sessions = match source.sessions.len() as u64 {
        0 => String::new(),
        sessions => format!(" in {}", count(sessions, "session")),
    };
    hint(ui, format!("{}{sessions}.", count(ratings, "rating")));
    if source.faults.is_empty() {
        return;
    }
    let title = RichText::new(format!("Faults: {}", source.faults.len())).color(theme::FAULT);
    CollapsingHeader::new(title).id_salt("faults").default_open(true).show(ui, |ui| {
        ScrollArea::vertical().id_salt("faults").max_height(170.0).show(ui, |ui| {
            for one in source.faults.iter().take(MOST_FAULTS) {
                fault(ui, one.to_string());
            }
            if let more @ 1.. = source.faults.len().saturating_sub(MOST_FAULTS) {
                fault(ui, format!("… and {} more", whole(more as u64)));
            }
        });
    });
}
