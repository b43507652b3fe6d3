//! What the results of ratings and of other tasks share: the column of controls with the export, beside the sections, and
//! the files as they were when they were read.

use std::{path::PathBuf, time::SystemTime};

use eframe::egui::{self, CentralPanel, CollapsingHeader, Frame, Panel, RichText, ScrollArea};

use crate::{
    app::ui::{Field, folded, heading, paragraph, pinned, text, theme},
    report::document::numbers::whole,
    store::{FileError, ratings::with_files},
    system::found,
    work::Analyze,
};

/// Maximum number of listed errors, and of listed warnings.
const MAX_ERRORS: usize = 200;
/// In a window narrower than this, in points, the data and filters have a separate view.
const NARROW: f32 = 700.0;
/// Address and heading of the view of data and filters.
const DATA: (&str, &str) = ("data", "Data");

/// An action that only the page can perform.
pub enum Request {
    OtherData,
    /// Choose other columns of the same file.
    Columns,
    /// Read the same files again with other options.
    Read(Box<Analyze>),
}

/// Data that were read, and their analysis.
pub trait Opened {
    /// The address of the open section.
    fn section(&mut self) -> &mut &'static str;

    /// Returns the address and the heading of every section.
    fn headings(&self) -> Vec<(&'static str, &'static str)>;

    /// Draws the files and what is selected of them.
    fn controls(&mut self, ui: &mut egui::Ui);

    fn export(&mut self, ui: &mut egui::Ui);

    /// Draws what is shown, and how far a newer analysis is.
    fn state(&mut self, _: &mut egui::Ui) {}

    /// Draws the open section.
    fn document(&mut self, ui: &mut egui::Ui);
}

/// Draws the data, and the `error` in reading them in another way; returns whether the user leaves them.
pub fn show_opened<T: Opened>(ui: &mut egui::Ui, opened: &mut T, error: &str) -> bool {
    let narrow = ui.available_width() < NARROW;
    let mut back = false;
    if !narrow {
        if *opened.section() == DATA.0 {
            *opened.section() = "summary";
        }
        let controls = |ui: &mut egui::Ui, opened: &mut T| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                back = heading(ui, "Analyze");
                opened.controls(ui);
                text::errors(ui, error);
            });
        };
        let width = (ui.available_width() * 0.3).clamp(290.0, 360.0);
        let panel = Panel::left("analysis").resizable(false).exact_size(width).frame(Frame::NONE.inner_margin(12.0));
        panel.show(ui, |ui| {
            theme::compact(ui);
            pinned(ui, opened, controls, |ui, opened| opened.export(ui));
        });
    }
    CentralPanel::default().frame(Frame::NONE.inner_margin(12.0)).show(ui, |ui| {
        theme::compact(ui);
        ui.horizontal_wrapped(|ui| {
            let all = opened.headings();
            if narrow {
                back = ui.button("Back").clicked();
                let all: Vec<_> = std::iter::once(DATA).chain(all).collect();
                let heading =
                    |id: &&'static str| all.iter().find(|(one, _)| one == id).map_or("", |(_, heading)| heading);
                let ids: Vec<&'static str> = all.iter().map(|(id, _)| *id).collect();
                let field = Field::new("Section").width(180.0);
                field.choice(ui, opened.section(), &ids, |id| heading(id).to_owned());
            } else {
                for (id, heading) in all {
                    ui.selectable_value(opened.section(), id, heading);
                }
            }
        });
        opened.state(ui);
        ui.separator();
        if *opened.section() == DATA.0 {
            ScrollArea::vertical().id_salt("data").auto_shrink(false).show(ui, |ui| {
                opened.controls(ui);
                text::errors(ui, error);
                opened.export(ui);
            });
        } else {
            opened.document(ui);
        }
    });
    back
}

/// Lists errors or warnings about the files.
pub fn problems(ui: &mut egui::Ui, title: &str, problems: &[FileError], color: egui::Color32) {
    if problems.is_empty() {
        return;
    }
    let header = RichText::new(format!("{title}: {}", problems.len())).color(color);
    folded(ui, CollapsingHeader::new(header).id_salt(title).default_open(true), |ui| {
        ScrollArea::vertical().id_salt(title).max_height(170.0).show(ui, |ui| {
            let more = problems.len().saturating_sub(MAX_ERRORS);
            let shown = problems.iter().take(MAX_ERRORS).map(ToString::to_string);
            for line in shown.chain((more > 0).then(|| format!("… and {} more", whole(more as u64)))) {
                paragraph(ui, RichText::new(line).small().color(color));
            }
        });
    });
}

/// Files that were read, and how.
pub struct Files {
    pub asked: Analyze,
    seen: Seen,
}

/// The size of each file and when it was last changed, or why that is not known.
type Seen = Result<Vec<(PathBuf, Option<(u64, Option<SystemTime>)>)>, String>;

impl Files {
    /// Looks at the files. Call this before they are read, so that no change is missed.
    pub fn of(asked: Analyze) -> Self {
        Self { seen: seen(&asked), asked }
    }

    /// Returns whether the files are now others, or have changed.
    pub fn have_changed(&self) -> bool {
        self.seen != seen(&self.asked)
    }
}

fn seen(asked: &Analyze) -> Seen {
    let files = with_files(asked.ratings.paths.clone()).map_err(|error| error.to_string())?;
    let state = |path: PathBuf| {
        let metadata = found(&path).map_err(|error| error.to_string())?;
        // The time of a folder also changes when something else is written into it.
        let file = metadata.filter(|metadata| !metadata.is_dir());
        Ok((path, file.map(|file| (file.len(), file.modified().ok()))))
    };
    files.into_iter().map(state).collect()
}
