//! The page: leaving it, saving, and the summary next to the form.

use std::path::{Path, PathBuf};

use eframe::egui::{CentralPanel, Context, Frame, Key, KeyboardShortcut, Modifiers, Panel, ScrollArea, Ui};

use super::{
    form::DefinitionForm,
    preview::{Preview, Thumbnails},
    sections,
};
use crate::{
    app::ui::{self, Field, FileKind, History, Step, fonts::TextFonts, theme},
    report::document::numbers::count,
    store::{FileErrors, definition},
};

/// In a window narrower than this, in points, the summary is below the form.
const NARROW: f32 = 1100.0;
/// In a window wider than this, in points, the parts of the form are listed beside it; the width of that list, points.
const WIDE: f32 = 1500.0;
const PARTS: f32 = 132.0;
/// Width of the form, points.
const FORM: f32 = 640.0;
/// The keys that save the definition.
const SAVE: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::S);
/// Width of the label of the folder, points.
const FOLDER: f32 = 60.0;

/// A definition, or a copy of one, while it is edited.
#[derive(Default)]
pub struct Editor {
    /// The definition that is edited or copied, as it was named.
    of: String,
    /// Number of sessions that were recorded with the definition that is edited; `None` if a copy is edited.
    sessions: Option<usize>,
    /// The text of the file when it was opened, with which it is compared when the file itself is saved.
    opened: String,
    form: DefinitionForm,
    /// The earlier texts of the draft.
    history: History<String>,
    /// The folder for the new file.
    folder: String,
    /// Why the definition could not be saved; empty if it could.
    error: String,
    preview: Preview,
    thumbnails: Thumbnails,
    fonts: TextFonts,
    /// The part of the form to scroll to.
    wanted: Option<usize>,
    /// Whether the user is being asked to discard the changes.
    leaving: bool,
}

impl Editor {
    /// Opens a copy of a built-in definition or of a file or, if `sessions` says how many were recorded with it, the file
    /// itself.
    ///
    /// # Errors
    /// The definition cannot be read, or is not TOML.
    pub fn of(name_or_path: &str, sessions: Option<usize>) -> Result<Self, FileErrors> {
        let path = Path::new(name_or_path);
        let beside = definition::built_in(path).map_or(path.parent(), |_| None);
        let folder = beside.filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let folder = ui::full(folder);
        let form = DefinitionForm::open(name_or_path, sessions.is_none().then_some(&*folder))?;
        Ok(Self {
            of: name_or_path.to_owned(),
            sessions,
            opened: definition::text(path)?.into_owned(),
            history: History::new(form.original.clone()),
            form,
            folder: folder.display().to_string(),
            ..Self::default()
        })
    }

    /// Returns whether the page asks before changes are lost by closing the window. Closing it a second time answers
    /// the question.
    pub fn asks_before_closing(&mut self) -> bool {
        let asks = self.form.is_changed() && !self.leaving;
        self.leaving |= asks;
        asks
    }

    /// Draws the page. The step to the next page has the path of the saved definition.
    pub fn show(&mut self, ui: &mut Ui) -> Step<PathBuf> {
        let escaped = ui::escaped(ui);
        let action = if self.sessions.is_none() { "Duplicate" } else { "Edit" };
        let heading = format!("{action} {}", Path::new(&self.of).file_stem().unwrap_or_default().display());
        self.fonts.find(ui.ctx(), [self.form.draft.text().as_str()]);
        let frame = Frame::NONE.inner_margin(theme::LARGE_GAP);
        let (mut back, mut saved) = (false, None);
        if ui.available_width() < NARROW {
            let form = |ui: &mut Ui, editor: &mut Self| {
                editor.scrolled().show(ui, |ui| {
                    // Leaves room for the scroll bar.
                    ui.set_max_width(ui.available_width() - 8.0);
                    back = editor.head(ui, &heading);
                    editor.fields(ui);
                    ui.separator();
                    editor.conditions(ui);
                });
            };
            CentralPanel::default().frame(frame).show(ui, |ui| {
                theme::compact(ui);
                (_, saved) = ui::pinned(ui, self, form, |ui, editor| editor.summary(ui));
            });
        } else {
            if ui.available_width() > WIDE {
                Panel::left("parts").resizable(false).exact_size(PARTS).frame(frame).show(ui, |ui| {
                    for (i, (name, _)) in sections::PARTS.iter().enumerate() {
                        if ui.selectable_label(false, *name).clicked() {
                            self.wanted = Some(i);
                        }
                    }
                });
            }
            Panel::left("editor").resizable(false).exact_size(FORM).frame(frame).show(ui, |ui| {
                theme::compact(ui);
                back = self.head(ui, &heading);
                self.scrolled().show(ui, |ui| self.fields(ui));
            });
            CentralPanel::default().frame(frame).show(ui, |ui| {
                theme::compact(ui);
                saved = self.summary(ui);
                ScrollArea::vertical().auto_shrink(false).show(ui, |ui| self.conditions(ui));
            });
        }
        self.history.record(ui, &self.form.draft.text());
        if let Some(path) = saved {
            return Step::Next(path);
        }
        if back || escaped {
            self.leaving = self.form.is_changed();
            return Step::back_if(!self.leaving);
        }
        Step::back_if(self.leaving && self.discards(ui.ctx()))
    }

    /// Draws the name of the page, and what takes changes back; returns whether the user leaves the page.
    fn head(&mut self, ui: &mut Ui, heading: &str) -> bool {
        let back = ui::heading(ui, heading);
        let mut text = self.form.draft.text();
        self.history.show(ui, &mut text, self.form.original.clone());
        if text != self.form.draft.text() {
            self.form.restore(&text);
        }
        back
    }

    /// Returns the scrolling room of the form. That of another definition begins at its top.
    fn scrolled(&self) -> ScrollArea {
        ScrollArea::vertical().id_salt(("form", &self.of)).auto_shrink(false)
    }

    fn fields(&mut self, ui: &mut Ui) {
        self.form.shown.clear();
        if let Some(n) = self.sessions.filter(|n| *n > 0) {
            let sessions = if n == 1 { "1 session was".to_owned() } else { format!("{n} sessions were") };
            ui::note(
                ui,
                format!(
                    "{sessions} recorded with this definition. Only the plan may still change; to change anything else, \
                        duplicate the study under another name, so that its data are not mixed with these."
                ),
            );
        }
        sections::show(&mut self.form, ui, self.wanted.take());
    }

    /// Draws the number of trials, the errors that no field shows, and the button that saves; returns the saved
    /// file.
    fn summary(&mut self, ui: &mut Ui) -> Option<PathBuf> {
        let is_stale = !self.form.errors.is_empty();
        if let Some(protocol) = self.form.protocol.as_ref() {
            ui.scope(|ui| {
                if is_stale {
                    ui.multiply_opacity(theme::STALE);
                }
                ui::section(ui, ui::extent(protocol));
            });
        }
        if self.sessions.is_none() {
            let field = Field::new("Folder").column(FOLDER).width((ui.available_width() - 200.0).clamp(120.0, 420.0));
            let browse = (FileKind::Folder, "Choose the folder…");
            let (field, _) = field.path(ui, &mut self.folder, browse);
            field.on_hover_text("The folder for the new file.");
            self.form.set_folder(&ui::full(Path::new(self.folder.trim())));
        }
        let path = self.place();
        let form = &mut self.form;
        let is_frozen = self.sessions.is_some_and(|n| n > 0) && form.is_another_experiment();
        let valid = form.errors.is_empty() && !is_frozen;
        let clicked = ui.horizontal(|ui| {
            let clicked = ui::neutral_primary(ui, "Save", valid, "");
            match form.errors.as_slice() {
                [] if is_frozen => ui::note(ui, "Only the plan may change while there are sessions."),
                [] => ui::hint(ui, format!("as {}", path.display())),
                [first, ..] => {
                    let count = count(form.errors.len() as u64, "error");
                    let place = if first.key.is_empty() { "the file" } else { &first.key };
                    ui::show_error(ui, format!("{count}, first in {place}."));
                }
            }
            clicked
        });
        let saves = clicked.inner || valid && ui.input_mut(|input| input.consume_shortcut(&SAVE));
        let opened = self.sessions.map(|_| self.opened.as_str());
        match saves.then(|| definition::save(&path, opened, &form.draft.text())) {
            Some(Ok(())) => return Some(path),
            Some(Err(error)) => self.error = error.to_string(),
            None => {}
        }
        ui::text::errors(ui, &self.error);
        for error in form.unshown() {
            ui.horizontal_wrapped(|ui| {
                ui::show_error(ui, &error.message);
                if !error.key.is_empty() && ui.button("Remove").on_hover_text(&error.key).clicked() {
                    form.rebuild(|draft| draft.remove(&error.key));
                }
            });
        }
        None
    }

    /// Returns where the definition is saved.
    fn place(&self) -> PathBuf {
        let draft = &self.form.draft;
        match self.sessions {
            Some(_) => self.of.clone().into(),
            None => draft.folder.join(format!("{}.toml", draft.get("name").unwrap_or_default())),
        }
    }

    fn conditions(&mut self, ui: &mut Ui) {
        let form = &self.form;
        let Some(protocol) = form.protocol.as_ref() else { return };
        let is_stale = !form.errors.is_empty();
        if is_stale {
            ui.multiply_opacity(theme::STALE);
        }
        let when = if is_stale { ", before the errors" } else { "" };
        self.preview.show(ui, protocol, form.revision, when);
        self.thumbnails.show(ui, protocol, when);
    }

    /// Asks whether to discard the changes; returns whether the user agreed.
    fn discards(&mut self, ctx: &Context) -> bool {
        let text = "The changes have not been saved.";
        let discard = ui::ask(ctx, "Discard changes?", text, ["Keep editing", "Discard changes"]);
        self.leaving = discard != Some(false);
        discard == Some(true)
    }
}
