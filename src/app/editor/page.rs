//! The page: leaving it, saving, and the summary next to the form.

use std::path::{Path, PathBuf, absolute};

use eframe::egui::{CentralPanel, Context, Frame, Key, KeyboardShortcut, Modifiers, Panel, ScrollArea, Ui};

use super::{form::DefinitionForm, preview::Preview, sections, thumbnails::Thumbnails};
use crate::{
    app::ui::{self, Dialog, Field, FileKind, Saving, Step, fonts::TextFonts, theme},
    report::document::numbers::count,
    store::{StoreError, Writer, definition},
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

/// A definition that was saved.
pub struct Saved {
    pub path: PathBuf,
    /// The path of the file before, if it was renamed.
    pub renamed: Option<String>,
}

/// A definition, or a copy of one, while it is edited.
pub struct Editor {
    /// The definition that is edited or copied, as it was named.
    of: String,
    /// Whether a copy is edited.
    copy: bool,
    /// Number of sessions that were recorded with the definition that is edited.
    sessions: usize,
    /// The text of the file when it was opened, and the name in it; they are compared when the file itself is saved.
    before: (String, Option<String>),
    /// The form, or why the definition cannot be edited.
    form: Result<DefinitionForm, String>,
    /// The folder for the new file.
    folder: String,
    dialog: Dialog,
    saving: Saving,
    preview: Preview,
    thumbnails: Thumbnails,
    fonts: TextFonts,
    /// The part of the form to scroll to.
    wanted: Option<usize>,
    /// Whether no frame was drawn yet, so that the form begins at its top.
    is_new: bool,
    /// Whether the user is being asked to discard the changes.
    leaving: bool,
}

impl Editor {
    /// Opens a copy of a built-in definition or of a file; or, unless `copy` is true, the file itself. `sessions` is how
    /// many were recorded with it.
    pub fn of(name_or_path: &str, copy: bool, sessions: usize) -> Self {
        let path = Path::new(name_or_path);
        let beside = definition::built_in(path).map_or(path.parent(), |_| None);
        let folder = beside.filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let folder = absolute(folder).unwrap_or_default();
        let form = DefinitionForm::open(name_or_path, copy.then_some(&folder)).map_err(|error| error.to_string());
        let name = form.as_ref().ok().and_then(|form| form.draft().get("name"));
        Self {
            of: name_or_path.to_owned(),
            copy,
            before: (definition::text(path).unwrap_or_default().into_owned(), name),
            sessions: if copy { 0 } else { sessions },
            form,
            folder: folder.display().to_string(),
            dialog: Dialog::default(),
            saving: Saving::default(),
            preview: Preview::default(),
            thumbnails: Thumbnails::default(),
            fonts: TextFonts::default(),
            wanted: None,
            is_new: true,
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

    /// Draws the page. The step to the next page has the saved definition.
    pub fn show(&mut self, ui: &mut Ui) -> Step<Saved> {
        let escaped = ui::escaped(ui);
        let action = if self.copy { "Duplicate" } else { "Edit" };
        let heading = format!("{action} {}", Path::new(&self.of).file_stem().unwrap_or_default().display());
        match &self.form {
            Ok(form) => _ = self.fonts.find(ui.ctx(), [form.draft().text().as_str()]),
            Err(error) => {
                return Step::back_if(ui::tool_page(ui, &heading, |ui| ui::show_error(ui, error)));
            }
        }
        let frame = Frame::NONE.inner_margin(theme::LARGE_GAP);
        let (mut back, mut saved) = (false, None);
        if ui.available_width() < NARROW {
            let form = |ui: &mut Ui, editor: &mut Self| {
                editor.scrolled().show(ui, |ui| {
                    // Leaves room for the scroll bar.
                    ui.set_max_width(ui.available_width() - 8.0);
                    back = ui::heading(ui, &heading);
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
                back = ui::heading(ui, &heading);
                self.scrolled().show(ui, |ui| self.fields(ui));
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

    /// Returns the scrolling room of the form, which begins at its top for each definition.
    fn scrolled(&mut self) -> ScrollArea {
        let area = ScrollArea::vertical().auto_shrink(false);
        if std::mem::take(&mut self.is_new) { area.vertical_scroll_offset(0.0) } else { area }
    }

    fn fields(&mut self, ui: &mut Ui) {
        let Ok(form) = &mut self.form else { return };
        form.begin_frame();
        if self.sessions > 0 {
            let n = self.sessions;
            let sessions = if n == 1 { "1 session was".to_owned() } else { format!("{n} sessions were") };
            ui::note(
                ui,
                format!(
                    "{sessions} recorded with this definition. Only the plan may still change; to change anything else, \
                        duplicate the study under another name, so that its data are not mixed with these."
                ),
            );
        }
        sections::show(form, ui, self.wanted.take());
    }

    /// Draws the number of trials, the errors that no field shows, and the button that saves; returns the saved
    /// file.
    fn summary(&mut self, ui: &mut Ui) -> Option<Saved> {
        let Ok(form) = &mut self.form else { return None };
        let is_stale = !form.errors().is_empty();
        if let Some(protocol) = form.protocol() {
            ui.scope(|ui| {
                if is_stale {
                    ui.multiply_opacity(theme::STALE);
                }
                ui::section(ui, ui::extent(protocol));
            });
        }
        if self.copy {
            Self::folder_field(ui, &mut self.folder, &mut self.dialog);
            form.set_folder(&absolute(self.folder.trim()).unwrap_or_else(|_| self.folder.trim().into()));
        }
        let path = if self.copy {
            form.draft().folder.join(format!("{}.toml", form.draft().get("name").unwrap_or_default()))
        } else {
            self.place()
        };
        let Ok(form) = &mut self.form else { return None };
        let is_frozen = self.sessions > 0 && form.is_another_experiment();
        let valid = form.errors().is_empty() && !is_frozen;
        let clicked = ui.horizontal(|ui| {
            let clicked = ui::neutral_primary(ui, self.saving.caption("Save", &path), valid, "");
            match form.errors() {
                [] if is_frozen => ui::note(ui, "Only the plan may change while there are sessions."),
                [] => ui::hint(ui, format!("as {}", path.display())),
                _ if form.lacks_pictures() => ui::hint(ui, "Choose the pictures first."),
                [first, ..] => {
                    let count = count(form.errors().len() as u64, "error");
                    ui::show_error(ui, format!("{count}, first in {}.", form.label(first)));
                }
            }
            clicked
        });
        let clicked = clicked.inner;
        let saves = clicked || valid && ui.input_mut(|input| input.consume_shortcut(&SAVE));
        let written = saves.then(|| {
            let text = form.draft().text();
            if self.copy {
                // What would be replaced may be the definition of a study with sessions.
                let written = Writer::new(Vec::new(), false).write(&path, text.as_bytes());
                return written.map_err(|error| match error {
                    StoreError::Occupied(path) => {
                        StoreError::Protected { path, what: "already exists; expected another name".to_owned() }
                    }
                    error => error,
                });
            }
            definition::save(Path::new(&self.of), &self.before.0, &path, &text)
        });
        match written {
            Some(Ok(())) => {
                let is_renamed = !self.copy && path != Path::new(&self.of);
                return Some(Saved { path, renamed: is_renamed.then(|| self.of.clone()) });
            }
            Some(Err(error)) => self.saving.finish(&path, Err(error)),
            None => {}
        }
        self.saving.show(ui);
        let Ok(form) = &mut self.form else { return None };
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

    /// Returns where the edited file is saved. A file that has the name of its experiment is renamed with it.
    fn place(&self) -> PathBuf {
        let of = Path::new(&self.of);
        let name = self.form.as_ref().ok().and_then(|form| form.draft().get("name"));
        let was_named = of.file_stem().and_then(|stem| stem.to_str()) == self.before.1.as_deref();
        match name {
            Some(name) if was_named => of.with_file_name(format!("{name}.toml")),
            _ => of.to_owned(),
        }
    }

    fn folder_field(ui: &mut Ui, folder: &mut String, dialog: &mut Dialog) {
        Field::new("Folder").column(FOLDER).show(ui, |ui, label| {
            ui.horizontal_wrapped(|ui| {
                let width = (ui.available_width() - 120.0).clamp(120.0, 420.0);
                let field = eframe::egui::TextEdit::singleline(folder).id_salt("folder").desired_width(width);
                ui.add(field).labelled_by(label).on_hover_text("The folder for the new file.");
                dialog.browse(ui, FileKind::Folder, "Choose the folder…", folder);
            });
        });
    }

    fn conditions(&mut self, ui: &mut Ui) {
        let Ok(form) = &self.form else { return };
        let Some(protocol) = form.protocol() else { return };
        let is_stale = !form.errors().is_empty();
        if is_stale {
            ui.multiply_opacity(theme::STALE);
        }
        let when = if is_stale { ", before the errors" } else { "" };
        self.preview.show(ui, protocol, form.revision(), when);
        self.thumbnails.show(ui, protocol, form.revision(), when);
    }

    /// Asks whether to discard the changes; returns whether the user agreed.
    fn discards(&mut self, ctx: &Context) -> bool {
        let text = "The changes have not been saved.";
        let discard = ui::ask(ctx, "Discard changes?", text, ["Keep editing", "Discard changes"]);
        self.leaving = discard != Some(false);
        discard == Some(true)
    }
}
