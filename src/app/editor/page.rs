//! The page: leaving it, saving, and the summary next to the form.

use std::path::{Path, PathBuf, absolute};

use eframe::egui::{CentralPanel, Context, Frame, Key, KeyboardShortcut, Modifiers, Panel, ScrollArea, Ui};

use super::{form::DefinitionForm, sections, thumbnails::Thumbnails};
use crate::{
    app::ui::{self, Dialog, Field, FileKind, Saving, Step, theme},
    store::definition,
};

/// In a window narrower than this, in points, the summary is below the form.
const NARROW: f32 = 1100.0;
/// Width of the form, points.
const FORM: f32 = 640.0;
/// The keys that save the definition.
const SAVE: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::S);
/// Width of the label of the folder, points.
const FOLDER: f32 = 60.0;

/// A copy of a definition while it is edited.
pub struct Editor {
    /// The definition that is copied, as it was named.
    of: String,
    /// The form, or why the definition cannot be edited.
    form: Result<DefinitionForm, String>,
    /// The folder for the new file.
    folder: String,
    dialog: Dialog,
    saving: Saving,
    thumbnails: Thumbnails,
    /// Whether the user is being asked to discard the changes.
    leaving: bool,
}

impl Editor {
    /// Opens a copy of a built-in definition or of a file.
    pub fn of(name_or_path: &str) -> Self {
        let path = Path::new(name_or_path);
        let beside = definition::built_in(path).map_or(path.parent(), |_| None);
        let folder = beside.filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let folder = absolute(folder).unwrap_or_default();
        Self {
            of: name_or_path.to_owned(),
            form: DefinitionForm::open(name_or_path, &folder).map_err(|error| error.to_string()),
            folder: folder.display().to_string(),
            dialog: Dialog::default(),
            saving: Saving::default(),
            thumbnails: Thumbnails::default(),
            leaving: false,
        }
    }

    fn is_changed(&self) -> bool {
        self.form.as_ref().is_ok_and(DefinitionForm::is_changed)
    }

    /// Returns whether the page asks before changes are lost by closing the window. Closing it a second time answers
    /// the question.
    pub fn asks_before_closing(&mut self) -> bool {
        let asks = self.is_changed() && !self.leaving;
        self.leaving |= asks;
        asks
    }

    /// Draws the page. The step to the next page has the path of the saved definition.
    pub fn show(&mut self, ui: &mut Ui) -> Step<PathBuf> {
        let escaped = ui::escaped(ui);
        let heading = format!("Duplicate {}", Path::new(&self.of).file_stem().unwrap_or_default().display());
        if let Err(error) = &self.form {
            let (back, ()) = ui::tool_page(ui, &heading, |ui| ui::show_error(ui, error));
            return Step::back_if(back);
        }
        let frame = Frame::NONE.inner_margin(theme::LARGE_GAP);
        let (mut back, mut saved) = (false, None);
        if ui.available_width() < NARROW {
            let summary = Panel::bottom("summary").resizable(false).frame(frame);
            summary.show(ui, |ui| {
                theme::compact(ui);
                saved = self.summary(ui);
            });
            CentralPanel::default().frame(frame).show(ui, |ui| {
                theme::compact(ui);
                ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                    // Leaves room for the scroll bar.
                    ui.set_max_width(ui.available_width() - 8.0);
                    back = ui::heading(ui, &heading);
                    self.fields(ui);
                    ui.separator();
                    self.conditions(ui);
                });
            });
        } else {
            Panel::left("editor").resizable(false).exact_size(FORM).frame(frame).show(ui, |ui| {
                theme::compact(ui);
                back = ui::heading(ui, &heading);
                ScrollArea::vertical().auto_shrink(false).show(ui, |ui| self.fields(ui));
            });
            CentralPanel::default().frame(frame).show(ui, |ui| {
                theme::compact(ui);
                saved = self.summary(ui);
                ScrollArea::vertical().auto_shrink(false).show(ui, |ui| self.conditions(ui));
            });
        }
        if let Some(path) = saved {
            return Step::Next(path);
        }
        if back || escaped {
            self.leaving = self.is_changed();
            return Step::back_if(!self.leaving);
        }
        Step::back_if(self.leaving && self.discards(ui.ctx()))
    }

    fn fields(&mut self, ui: &mut Ui) {
        let Ok(form) = &mut self.form else { return };
        form.begin_frame();
        sections::show(form, ui);
    }

    /// Draws the number of trials, the errors that no field shows, and the button that saves; returns the path of the
    /// saved file.
    fn summary(&mut self, ui: &mut Ui) -> Option<PathBuf> {
        let Ok(form) = &mut self.form else { return None };
        if let Some(protocol) = form.protocol() {
            ui::section(ui, ui::extent(protocol));
        }
        for error in form.unshown() {
            ui.horizontal_wrapped(|ui| {
                ui::show_error(ui, &error.message);
                if !error.key.is_empty() && ui.button("Remove").on_hover_text(&error.key).clicked() {
                    form.rebuild(|draft| draft.remove(&error.key));
                }
            });
        }
        Field::new("Folder").column(FOLDER).show(ui, |ui, label| {
            ui.horizontal_wrapped(|ui| {
                let width = (ui.available_width() - 120.0).clamp(120.0, 420.0);
                let field = eframe::egui::TextEdit::singleline(&mut self.folder).id_salt("folder").desired_width(width);
                ui.add(field).labelled_by(label).on_hover_text("The folder for the new file.");
                self.dialog.browse(ui, FileKind::Folder, "Choose the folder…", &mut self.folder);
            });
            self.dialog.missing_error(ui);
        });
        let folder = absolute(self.folder.trim()).unwrap_or_else(|_| self.folder.trim().into());
        let path = folder.join(format!("{}.toml", form.draft().get("name").unwrap_or_default()));
        let hint = match form.errors() {
            [] => format!("as {}", path.display()),
            errors => {
                let mut fields: Vec<&str> = errors.iter().map(|error| field_of(&error.key)).collect();
                fields.dedup();
                let count = if errors.len() == 1 { "1 error".to_owned() } else { format!("{} errors", errors.len()) };
                format!("{count} in {}. The conditions shown are the last ones without errors.", fields.join(", "))
            }
        };
        let valid = form.errors().is_empty();
        let clicked = ui::primary(ui, self.saving.caption("Save", &path), valid, &hint);
        let saves = clicked || valid && ui.input_mut(|input| input.consume_shortcut(&SAVE));
        let written = saves.then(|| {
            let writer = self.saving.writer(&path, &[self.of.clone().into()]);
            writer.write(&path, form.draft().text().as_bytes())
        });
        match written {
            Some(Ok(())) => return Some(path),
            Some(Err(error)) => self.saving.finish(&path, Err(error)),
            None => {}
        }
        self.saving.show(ui);
        None
    }

    fn conditions(&mut self, ui: &mut Ui) {
        let Ok(form) = &self.form else { return };
        let Some(protocol) = form.protocol() else { return };
        self.thumbnails.show(ui, protocol, form.revision());
    }

    /// Asks whether to discard the changes; returns whether the user agreed.
    fn discards(&mut self, ctx: &Context) -> bool {
        let text = "The changes to this copy have not been saved.";
        let discard = ui::ask(ctx, "Discard changes?", text, ["Keep editing", "Discard changes"]);
        self.leaving = discard != Some(false);
        discard == Some(true)
    }
}

/// Returns the key without the index in a list.
fn field_of(key: &str) -> &str {
    key.match_indices('.').nth(1).map_or(key, |(end, _)| &key[..end])
}
