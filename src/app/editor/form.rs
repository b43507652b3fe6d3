//! The draft of a definition, what was typed in each field, and the errors of each field.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
};

use eframe::egui::{Align, ComboBox, Id, Layout, Response, TextEdit, Ui};

use crate::{
    app::ui::{self, Field, parameter, theme::Icon},
    experiment::Protocol,
    report::names::{self, capitalized},
    stimulus::{Parameter, catalog},
    store::{
        FileError, FileErrors, definition,
        draft::{Draft, Typed},
    },
};

/// Width of the column of labels, points.
pub const LABELS: f32 = 150.0;
/// Width of a field for a number, points.
const NUMBER: f32 = 90.0;
/// Width of a field for a number that can be absent, points.
const OPTIONAL: f32 = 140.0;
/// Width of a list of values to choose from, points.
const LIST: f32 = 240.0;
/// Maximum number of errors shown for one field.
const MAX_SHOWN: usize = 3;

#[derive(Default)]
pub struct DefinitionForm {
    pub draft: Draft,
    /// What was typed, by the key of the field. The draft may have it in a different form.
    typed: BTreeMap<String, String>,
    /// The text of the draft when it was opened.
    pub original: String,
    /// The hash of what the definition said when it was opened.
    hash: Option<String>,
    /// The definition as it was when it last had no errors.
    pub protocol: Option<Protocol>,
    /// Increases with each change.
    pub revision: u64,
    pub errors: Vec<FileError>,
    /// The indices of the errors that this frame has shown next to their fields.
    pub shown: BTreeSet<usize>,
}

impl DefinitionForm {
    /// Opens a definition; with a folder, a copy of it for that folder.
    ///
    /// # Errors
    /// The definition cannot be read, or is not TOML. Any other error is shown next to its field.
    pub fn open(name_or_path: &str, folder: Option<&Path>) -> Result<Self, FileErrors> {
        let mut draft = Draft::parse(name_or_path, &definition::text(Path::new(name_or_path))?)?;
        if let Some(folder) = folder {
            folder.clone_into(&mut draft.folder);
            let name = draft.get("name").unwrap_or_else(|| "my-study".to_owned());
            draft.remove_opening_comment();
            draft.set("name", &copied(&name, ["-copy", "-", ""]), Typed::Text);
            if let Some(title) = draft.get("title") {
                draft.set("title", &copied(&title, [" (copy", " ", ")"]), Typed::Text);
            }
            if draft.get("session.own_means").is_some() {
                // A first look may show people their own ratings; a study begins without.
                draft.set_flag("session.own_means", false);
            }
        }
        let mut form = Self { original: draft.text(), draft, ..Self::default() };
        form.check();
        form.hash = form.protocol.as_ref().map(definition::hash);
        Ok(form)
    }

    /// Returns whether anything was changed since the definition was opened.
    pub fn is_changed(&self) -> bool {
        self.draft.text() != self.original
    }

    /// Returns whether the definition now says something else than when it was opened, apart from the plan.
    pub fn is_another_experiment(&self) -> bool {
        self.protocol.as_ref().map(definition::hash) != self.hash
    }

    /// Returns the parameters of the stimulus.
    pub fn parameters(&self) -> &'static [Parameter] {
        catalog::parameters(&self.value("stimulus.kind", ""))
    }

    /// Returns the parameters that no factor varies.
    pub fn free_parameters(&self) -> impl Iterator<Item = &'static Parameter> + use<> {
        let factors = self.draft.factors();
        self.parameters().iter().filter(move |parameter| factors.iter().all(|factor| factor != parameter.name))
    }

    /// Returns the label of a factor.
    pub fn factor(&self, name: &str) -> String {
        parameter::label(self.parameters(), name)
    }

    /// Returns the errors that this frame has not shown next to a field.
    pub fn unshown(&self) -> Vec<FileError> {
        let unshown = self.errors.iter().enumerate().filter(|(i, _)| !self.shown.contains(i));
        unshown.map(|(_, error)| error.clone()).collect()
    }

    /// Changes the draft.
    pub fn edit(&mut self, change: impl FnOnce(&mut Draft)) {
        change(&mut self.draft);
        self.check();
    }

    /// Changes the folder from which pictures are named.
    pub fn set_folder(&mut self, folder: &Path) {
        if self.draft.folder != folder {
            folder.clone_into(&mut self.draft.folder);
            self.protocol = None;
            self.check();
        }
    }

    /// Changes the draft so that other fields have new values, and forgets what was typed in them.
    pub fn rebuild(&mut self, change: impl FnOnce(&mut Draft)) {
        self.typed.clear();
        self.edit(change);
    }

    /// Returns to an earlier text of the draft.
    pub fn restore(&mut self, text: &str) {
        let folder = std::mem::take(&mut self.draft.folder);
        self.rebuild(|draft| {
            // What was written from a draft can be read.
            if let Ok(earlier) = Draft::parse("", text) {
                *draft = earlier;
            }
            draft.folder = folder;
        });
    }

    fn check(&mut self) {
        self.revision += 1;
        match self.draft.check(self.protocol.as_ref()) {
            Ok(protocol) => (self.protocol, self.errors) = (Some(protocol), Vec::new()),
            Err(FileErrors(errors)) => self.errors = errors,
        }
    }

    /// Returns the text of a field.
    pub fn value(&self, key: &str, default: &str) -> String {
        let typed = self.typed.get(key).cloned().or_else(|| self.draft.get(key));
        typed.unwrap_or_else(|| default.to_owned())
    }

    /// Keeps what was typed in a field, without a change of the draft.
    pub fn keep_typed(&mut self, key: &str, text: &str) {
        self.typed.insert(key.to_owned(), text.to_owned());
    }

    /// Stores what was typed in a field.
    pub fn type_value(&mut self, key: &str, text: &str, typed: Typed) {
        if Draft::ARRANGES.contains(&key) {
            // Its texts change as well.
            self.typed.clear();
        }
        self.keep_typed(key, text);
        self.edit(|draft| draft.set(key, text, typed));
    }

    /// Returns the errors of a field, one a line, and counts them as shown.
    pub fn error(&mut self, key: &str) -> String {
        self.show(|error| error.strip_prefix(key).is_some_and(|rest| rest.is_empty() || rest.starts_with('.')))
    }

    /// Like [`DefinitionForm::error`], without the errors of the values in this table or list.
    pub fn own_error(&mut self, key: &str) -> String {
        self.show(|error| error == key)
    }

    fn show(&mut self, is_here: impl Fn(&str) -> bool) -> String {
        let found: Vec<usize> = (0..self.errors.len()).filter(|i| is_here(&self.errors[*i].key)).collect();
        self.shown.extend(&found);
        let mut lines: Vec<String> = found.iter().take(MAX_SHOWN).map(|i| plain(&self.errors[*i])).collect();
        if found.len() > MAX_SHOWN {
            lines.push(format!("and {} more", found.len() - MAX_SHOWN));
        }
        lines.join("\n")
    }

    /// Draws a text field for a value, with its errors. `about` explains it.
    pub fn text(&mut self, ui: &mut Ui, label: &str, key: &str, default: &str, about: &str) {
        let width = room(ui);
        self.field([label, key, default, about], Typed::Text, None, |field, text| field.width(width).text(ui, text));
    }

    /// Draws a field for text below another field, with its errors; an empty one is removed. `name` is for screen readers.
    pub fn line(&mut self, ui: &mut Ui, name: &str, key: &str, typed: Typed, hint: &str) {
        let width = room(ui);
        self.field(["", key, "", hint], typed, Some(key), |field, text| {
            field.named(name).width(width).hint(hint).text(ui, text)
        });
    }

    /// Draws a field for text that may have several lines, with its errors.
    pub fn lines(&mut self, ui: &mut Ui, label: &str, key: &str, default: &str, about: &str) {
        let width = (ui.available_width() - LABELS - 40.0).max(120.0);
        self.field([label, key, default, about], Typed::Text, None, |field, text| {
            field.add(ui, TextEdit::multiline(text).id_salt(("field", label)).desired_rows(1).desired_width(width))
        });
    }

    /// Draws a field for a number, with its errors.
    pub fn number(&mut self, ui: &mut Ui, label: &str, key: &str, default: impl ToString, about: &str) {
        let field = [label, key, &default.to_string(), about];
        self.field(field, Typed::Value, None, |field, text| field.width(NUMBER).text(ui, text));
    }

    /// Draws a list of values to choose from, with the errors of the chosen one; returns a value that was just chosen.
    /// `title` is what the list shows of a value.
    pub fn choice<'n>(
        &mut self,
        ui: &mut Ui,
        [label, key, default, about]: [&str; 4],
        names: impl IntoIterator<Item = &'n str>,
        title: impl Fn(&str) -> String,
    ) -> Option<String> {
        let (before, error) = (self.value(key, default), self.error(key));
        let mut chosen = before.clone();
        let names: Vec<String> = names.into_iter().map(ToOwned::to_owned).collect();
        let field = Field::new(label).column(LABELS).error(&error).width(LIST);
        field.choice(ui, &mut chosen, &names, |name| title(name)).on_hover_text(about);
        (chosen != before).then_some(chosen)
    }

    /// Draws a field for a list of numbers, with its errors; a long list wraps. An empty one is removed; `absent` says
    /// what that means.
    pub fn list(&mut self, ui: &mut Ui, label: &str, key: &str, [default, absent]: [&str; 2], about: &str) {
        let width = room(ui);
        self.field([label, key, default, about], Typed::Values, Some(key), |field, text| {
            let edit = TextEdit::multiline(text).id_salt(("field", label)).desired_rows(1).hint_text(absent);
            field.add(ui, edit.desired_width(width).return_key(None))
        });
    }

    /// Draws a field for a number that can be absent; `absent` says what that means, and `owner` is then removed.
    pub fn optional(&mut self, ui: &mut Ui, label: &str, [key, owner]: [&str; 2], absent: &str, about: &str) {
        self.field([label, key, "", about], Typed::Value, Some(owner), |field, text| {
            field.width(OPTIONAL).hint(absent).text(ui, text)
        });
    }

    /// Draws a row for each value of a table of parameters, with its errors and a button that removes it; returns the name
    /// of the one to remove. `field` and `removed` precede the parameter in the names of the field and of the button.
    pub fn rows(&mut self, ui: &mut Ui, table: &str, [field, removed]: [&str; 2], typed: Typed) -> Option<String> {
        let mut to_remove = None;
        for name in self.draft.keys(table) {
            let key = format!("{table}.{name}");
            let parameter = self.parameters().iter().find(|parameter| parameter.name == name);
            let about = parameter.map_or_else(String::new, |p| format!("{}: {}", p.description, p.expected));
            let words = names::factor(Some(self.parameters()), &name);
            let label = if removed.is_empty() { self.factor(&name) } else { format!("{field}{words}") };
            let (mut text, error) = (self.value(&key, ""), self.error(&key));
            let mut line = |ui: &mut Ui, of: Id| {
                let width = (ui.available_width() - 100.0).clamp(120.0, 300.0);
                // A long list wraps.
                let edit = TextEdit::multiline(&mut text).id_salt(&key).desired_rows(1).desired_width(width);
                let edit = ui.add(edit.return_key(None)).on_hover_text(&about);
                let edit = if removed.is_empty() {
                    ui::text::name(ui, &edit, &format!("{field}{words}"));
                    edit
                } else {
                    edit.labelled_by(of)
                };
                let remove = ui::quiet(ui, Icon::Close, "", &format!("Remove {removed}{words}"));
                (edit.changed(), remove.clicked())
            };
            let layout = Layout::left_to_right(Align::TOP).with_main_wrap(true);
            let row = Field::new(&label).column(LABELS).slot().error(&error);
            let (changed, remove) = row.show(ui, |ui, label| ui.with_layout(layout, |ui| line(ui, label)).inner);
            if changed {
                self.type_value(&key, &text, typed);
            }
            if remove {
                to_remove = Some(name);
            }
        }
        to_remove
    }

    /// Draws a field. If nothing is typed in it, `owner` is removed, if there is one.
    fn field(
        &mut self,
        [label, key, default, about]: [&str; 4],
        typed: Typed,
        owner: Option<&str>,
        draw: impl FnOnce(Field<'_>, &mut String) -> Response,
    ) {
        let mut text = self.value(key, default);
        let response = draw(Field::new(label).column(LABELS).slot().error(&self.error(key)), &mut text);
        if !response.on_hover_text(about).changed() {
        } else if let Some(owner) = owner.filter(|_| text.trim().is_empty()) {
            self.keep_typed(key, "");
            self.edit(|draft| draft.remove(owner));
        } else {
            self.type_value(key, &text, typed);
        }
    }
}

/// Returns the name or the title of a copy: `quick-copy` for `quick`, and `quick-copy-2` for that. `mark` is what the first
/// copy adds, what precedes the number of a further one, and what follows.
fn copied(text: &str, mark: [&str; 3]) -> String {
    let [copy, before, end] = mark;
    let number = |rest: &str| match rest.strip_suffix(end)? {
        "" => Some(1),
        number => number.strip_prefix(before)?.parse::<u32>().ok(),
    };
    let earlier = text.rsplit_once(copy).and_then(|(first, rest)| Some((first, number(rest)?)));
    match earlier {
        None => format!("{text}{copy}{end}"),
        Some((first, number)) => format!("{first}{copy}{before}{}{end}", number.saturating_add(1)),
    }
}

/// Returns the width of a field for text, points.
fn room(ui: &Ui) -> f32 {
    (ui.available_width() - LABELS - 40.0).clamp(120.0, 420.0)
}

/// Draws a list from which something is added, which `title` says; returns what was chosen.
pub fn add<T>(ui: &mut Ui, title: &str, entries: impl IntoIterator<Item = (T, String)>) -> Option<T> {
    let list = ComboBox::from_id_salt(title).selected_text(format!("{title}…")).width(200.0).height(400.0);
    let list = list.show_ui(ui, |ui| {
        let chosen = entries.into_iter().filter_map(|(one, text)| ui::entry(ui, false, text).clicked().then_some(one));
        chosen.last()
    });
    ui::text::name(ui, &list.response, title);
    list.inner.flatten()
}

/// Returns the message of an error beside its field, without the names and the limits of the file.
fn plain(error: &FileError) -> String {
    let name = error.key.rsplit('.').next().unwrap_or_default();
    let is_of_field = |what: &str| what.starts_with(&*error.key) || what.starts_with(&format!("{name} is "));
    let message = match error.message.split_once("; expected ") {
        Some((what, expected)) if !error.key.is_empty() && is_of_field(what) => format!("Enter {expected}."),
        _ => error.message.clone(),
    };
    capitalized(&message.replace(&format!(" from 0 to {}", u32::MAX), "").replace(" in quotes", ""))
}
