//! The dialogs that simulate a pilot and export a study.

use std::path::{Path, PathBuf};

use eframe::egui::{self, RichText};

use crate::{
    app::ui::{self, Dialog, Field, FileKind, Step, primary, theme::GAP},
    experiment::Protocol,
    store::export::Format,
    system::found,
    work::{
        Export,
        simulate::{ObserverKind, Simulate},
    },
};

/// Width of a dialog, and of its column of labels, points.
const WIDTH: f32 = 560.0;
const LABELS: f32 = 152.0;
/// Number of simulated participants if none is planned.
const PARTICIPANTS: u32 = 8;

/// What a pilot is to be.
pub struct PilotForm {
    participants: u32,
    observer: ObserverKind,
    /// Whether participants rate, as in the paper, and do no other task.
    is_rating: bool,
}

impl PilotForm {
    pub fn new(protocol: &Protocol) -> Self {
        Self {
            participants: protocol.plan.participants.unwrap_or(PARTICIPANTS),
            observer: ObserverKind::usual(protocol),
            is_rating: protocol.task.is_default(),
        }
    }

    /// Draws the dialog; returns the request once it is confirmed.
    pub fn show(&mut self, ctx: &egui::Context, experiment: &str, results: &Path) -> Step<Box<Simulate>> {
        // Simulated sessions never lie among those of people.
        let beside = |number: u32| results.with_file_name(format!("pilot-{number}"));
        let free = (1..).map(beside).find(|folder| !matches!(found(folder), Ok(Some(_)))).unwrap_or_default();
        let entered = ui::entered(ctx);
        let (step, closed) = ui::modal(ctx, "pilot", WIDTH, |ui, _| {
            ui.heading("Simulate a pilot");
            let [rate, ratings] = if self.is_rating { ["rate", "ratings"] } else { ["do", "answers"] };
            let text = format!(
                "Simulated observers {rate} every trial, and their {ratings} are analyzed as a study would be."
            );
            ui::hint(ui, text);
            ui.add_space(GAP);
            Field::new("Participants").column(LABELS).show(ui, |ui, label| {
                ui.add(egui::DragValue::new(&mut self.participants).range(1..=1000)).labelled_by(label)
            });
            let kinds = [ObserverKind::Paper, ObserverKind::Vision, ObserverKind::Random];
            let title = |kind: &ObserverKind| match kind {
                ObserverKind::Paper => "follows the findings of the paper".to_owned(),
                ObserverKind::Vision => "answers what the vision model predicts".to_owned(),
                ObserverKind::Random => "presses keys at random".to_owned(),
            };
            Field::new("Observer").column(LABELS).width(300.0).choice(ui, &mut self.observer, &kinds, title);
            ui::hint(ui, format!("The files go into the new folder {}.", free.display()));
            ui.add_space(GAP);
            ui.horizontal(|ui| {
                if primary(ui, "Simulate", true, "") || entered {
                    let request = Simulate {
                        experiment: experiment.into(),
                        participants: self.participants,
                        results: free.clone(),
                        observer: Some(self.observer),
                        seed: 1,
                        observer_file: None,
                        resume: false,
                        accept_changes: false,
                    };
                    return Step::Next(Box::new(request));
                }
                Step::back_if(ui.button("Cancel").clicked())
            })
            .inner
        });
        if closed { Step::Back } else { step }
    }
}

/// Where an export goes, and what is in it.
pub struct ExportForm {
    format: Format,
    out: String,
    complete_only: bool,
    dialog: Dialog,
}

impl ExportForm {
    pub fn new(folder: &Path) -> Self {
        let name = folder.file_name().unwrap_or_default().display().to_string();
        let beside = folder.parent().and_then(Path::parent).unwrap_or(Path::new(""));
        let out = beside.join(format!("{name}-psych-ds")).display().to_string();
        Self { format: Format::PsychDs, out, complete_only: false, dialog: Dialog::default() }
    }

    /// Draws the dialog; returns the request once it is confirmed.
    pub fn show(&mut self, ctx: &egui::Context, folder: &Path) -> Step<Export> {
        let entered = ui::entered(ctx);
        let (step, closed) = ui::modal(ctx, "export", WIDTH, |ui, _| {
            ui.heading("Export");
            ui.label(RichText::new(folder.display().to_string()).small().weak());
            ui.add_space(GAP);
            let before = self.format;
            let title = |format: &Format| match format {
                Format::PsychDs => "Psych-DS".to_owned(),
                Format::Bids => "BIDS".to_owned(),
            };
            Field::new("Format").column(LABELS).width(160.0).choice(
                ui,
                &mut self.format,
                &[Format::PsychDs, Format::Bids],
                title,
            );
            if before != self.format {
                let [old, new] = [before, self.format].map(|format| title(&format).to_lowercase());
                self.out = self.out.replace(&old, &new);
            }
            Field::new("New folder").column(LABELS).show(ui, |ui, label| {
                ui.horizontal_wrapped(|ui| {
                    let edit = egui::TextEdit::singleline(&mut self.out).desired_width(260.0);
                    ui.add(edit).labelled_by(label);
                    self.dialog.browse(ui, FileKind::Folder, "Choose the new folder…", &mut self.out);
                });
                self.dialog.missing_error(ui);
            });
            Field::new("").column(LABELS).show(ui, |ui, _| {
                ui.checkbox(&mut self.complete_only, "Only finished sessions");
            });
            ui.add_space(GAP);
            ui.horizontal(|ui| {
                let ready = !self.out.trim().is_empty();
                if primary(ui, "Export", ready, "") || entered && ready {
                    return Step::Next(Export {
                        folder: folder.to_owned(),
                        format: self.format,
                        out: PathBuf::from(self.out.trim()).into(),
                        complete_only: self.complete_only,
                        accept_changes: false,
                    });
                }
                Step::back_if(ui.button("Cancel").clicked())
            })
            .inner
        });
        if closed { Step::Back } else { step }
    }
}
