//! Where the ratings come from, in words.

use eframe::egui::{self, CollapsingHeader};

use super::{
    look,
    words::{grouped, many},
};
use crate::{
    app::theme,
    store::ratings::{FileRead, Layout, SessionRead, Source},
};

/// Faults that are listed.
const MOST_FAULTS: usize = 200;
/// Files that are listed.
const MOST_FILES: usize = 200;

/// What is said of a source.
pub struct SourceView {
    title: String,
    said: Vec<String>,
    notes: Vec<String>,
    faults: Vec<String>,
    files: Vec<String>,
    /// Whether there are unfinished sessions, which can be left out.
    pub unfinished: bool,
    /// Whether its columns were named.
    pub named: bool,
}

impl SourceView {
    /// Of what was read.
    pub fn new(source: &Source) -> Self {
        let sum = |of: fn(&FileRead) -> u64| source.files.iter().map(of).sum::<u64>();
        let mut view = Self {
            title: title(source),
            said: vec![size(source, sum(|file| file.ratings))],
            notes: Vec::new(),
            faults: source.faults.iter().take(MOST_FAULTS).map(ToString::to_string).collect(),
            files: source.files.iter().take(MOST_FILES).map(file_line).collect(),
            unfinished: source.sessions.iter().any(SessionRead::is_unfinished) || sum(|file| file.unfinished) > 0,
            named: source.files.iter().any(|file| file.layout == Layout::Long),
        };
        let left_out = [
            (sum(|file| file.practice), "practice rating", ""),
            (sum(|file| file.superseded), "rating", " taken back"),
            (sum(|file| file.unfinished), "rating", " of unfinished sessions"),
            (sum(|file| file.faulty), "row", " with a fault"),
        ];
        let left_out: Vec<String> = (left_out.into_iter())
            .filter(|(number, ..)| *number > 0)
            .map(|(number, what, more)| many(number, what) + more)
            .collect();
        if !left_out.is_empty() {
            view.said.push(format!("Left out: {}.", left_out.join(", ")));
        }
        view.sessions(source);
        if source.faults.len() > MOST_FAULTS {
            view.faults.push(format!("… and {} more", grouped((source.faults.len() - MOST_FAULTS) as u64)));
        }
        if source.files.len() > MOST_FILES {
            view.files.push(format!("… and {} more", grouped((source.files.len() - MOST_FILES) as u64)));
        }
        view
    }

    fn sessions(&mut self, source: &Source) {
        let number = |wanted: fn(&SessionRead) -> bool| source.sessions.iter().filter(|s| wanted(s)).count() as u64;
        let simulated = number(is_simulated);
        if simulated > 0 {
            let whose = if simulated == source.sessions.len() as u64 {
                "Simulated: no person gave these ratings.".to_owned()
            } else {
                format!("{} of {} are simulated.", simulated, many(source.sessions.len() as u64, "session"))
            };
            self.notes.push(whose);
        }
        let unfinished: Vec<&SessionRead> = source.sessions.iter().filter(|s| s.is_unfinished()).collect();
        if let Some(first) = unfinished.first() {
            let example = first
                .planned
                .map(|planned| format!(" ({} {}: {} of {planned})", first.subject, first.session, first.rated));
            self.notes.push(format!(
                "{} unfinished{}.",
                many(unfinished.len() as u64, "session"),
                example.unwrap_or_default()
            ));
        }
        let dropped: u64 = source.sessions.iter().filter_map(|session| session.dropped).sum();
        if dropped > 0 {
            self.notes.push(format!("Frames were dropped in {}.", many(dropped, "trial")));
        }
    }

    /// Draws it.
    pub fn show(&self, ui: &mut egui::Ui) {
        ui.add(egui::Label::new(egui::RichText::new(&self.title).strong()).wrap());
        for text in &self.said {
            look::quiet(ui, text);
        }
        for note in &self.notes {
            ui.add(egui::Label::new(egui::RichText::new(note).small().color(theme::NOTE)).wrap());
        }
        if !self.faults.is_empty() {
            let title = format!("Faults: {}", self.faults.len());
            let title = egui::RichText::new(title).color(theme::FAULT);
            CollapsingHeader::new(title).id_salt("faults").default_open(true).show(ui, |ui| {
                egui::ScrollArea::vertical().id_salt("faults").max_height(170.0).show(ui, |ui| {
                    for fault in &self.faults {
                        theme::fault(ui, fault);
                    }
                });
            });
        }
        CollapsingHeader::new(many(self.files.len() as u64, "file")).id_salt("files").show(ui, |ui| {
            egui::ScrollArea::vertical().id_salt("files").max_height(170.0).show(ui, |ui| {
                for file in &self.files {
                    look::quiet(ui, file);
                }
            });
        });
    }
}

fn title(source: &Source) -> String {
    match (&source.protocol, source.files.first()) {
        (Some(protocol), _) => format!("{}: {}", protocol.name, protocol.title),
        (None, Some(file)) => file.path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        (None, None) => "No file".to_owned(),
    }
}

fn size(source: &Source, ratings: u64) -> String {
    let ratings = many(ratings, "rating");
    match source.sessions.len() as u64 {
        0 => format!("{ratings}."),
        sessions => format!("{ratings} in {}.", many(sessions, "session")),
    }
}

fn file_line(file: &FileRead) -> String {
    let name = file.path.file_name().unwrap_or_default().to_string_lossy();
    format!("{name}: {}", many(file.ratings, "rating"))
}

/// Whether any sitting of a session was simulated.
fn is_simulated(session: &SessionRead) -> bool {
    session.sidecar.as_ref().is_some_and(|sidecar| sidecar.sittings.iter().any(|sitting| sitting.observer.is_some()))
}
