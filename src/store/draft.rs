//! Edits the text of a definition. Comments, order and layout stay as they are, except within a value that changes.

use std::path::{Path, PathBuf};

use toml_edit::{DocumentMut, InlineTable, Item, Table, TableLike, Value};

use super::{FileErrors, definition, toml};
use crate::{
    experiment::{
        Protocol,
        task::{Adaptive, Task},
    },
    stimulus::{catalog, picture::Picture},
};

/// The text of a definition while it is edited. Values are addressed by their keys: `name`, `design.repetitions`,
/// `participant.age.required`.
#[derive(Clone, Debug, Default)]
pub struct Draft {
    /// The folder from which pictures are named.
    pub folder: PathBuf,
    document: DocumentMut,
    /// Whether the lines end in a carriage return and a line feed.
    crlf: bool,
}

/// How a typed value is written in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Typed {
    /// As text.
    Text,
    /// As a number if it is one, and otherwise as text.
    Value,
    /// As a list of such values, which are separated by commas. Text that contains a comma is typed in quotes.
    Values,
}

impl Draft {
    /// The options of a task that decide how many images a trial shows, and where, or how it is answered. Its texts say so.
    pub const ARRANGES: [&str; 3] = ["task.shown", "task.alternatives", "task.scale"];

    /// Reads a definition; `file` is its path, or identifies it in messages. It may contain errors, which [`Draft::check`] reports.
    ///
    /// # Errors
    /// The first place where the text is not TOML.
    pub fn parse(file: &str, text: &str) -> Result<Self, FileErrors> {
        // This reader reports the same errors as everywhere else.
        toml::Document::parse(file, text)?;
        let crlf = text.contains("\r\n");
        let document = text.replace("\r\n", "\n").parse();
        let document = document.map_err(|error: toml_edit::TomlError| FileErrors::whole(file, error.to_string()))?;
        let folder = Path::new(file).parent().unwrap_or(Path::new("")).to_owned();
        Ok(Self { folder, document, crlf })
    }

    /// Returns the text of the file.
    pub fn text(&self) -> String {
        let text = self.document.to_string();
        if self.crlf { text.replace('\n', "\r\n") } else { text }
    }

    /// Returns the definition. Pictures that it had `before` are not read again.
    ///
    /// # Errors
    /// Returns every error, with its key.
    pub fn check(&self, before: Option<&Protocol>) -> Result<Protocol, FileErrors> {
        let file = self.folder.join(self.get("name").unwrap_or_default());
        definition::parse_again(&file.display().to_string(), &self.text(), before)
    }

    /// Returns a value as it would be typed; `None` if the file does not have it.
    pub fn get(&self, key: &str) -> Option<String> {
        let value = self.value(key)?;
        let list = value.as_array().map(|list| list.iter().map(listed).collect::<Vec<_>>().join(", "));
        Some(list.unwrap_or_else(|| plain(value)))
    }

    /// Returns a list of texts; `None` if the file does not have it.
    pub fn texts(&self, key: &str) -> Option<Vec<String>> {
        Some(self.value(key)?.as_array()?.iter().map(plain).collect())
    }

    fn value(&self, key: &str) -> Option<&Value> {
        let (table, key) = split(key);
        self.found(table)?.get(key)?.as_value()
    }

    /// Returns a table, by its names from the top, which are separated by dots; an empty name is the top level.
    fn found(&self, table: &str) -> Option<&dyn TableLike> {
        let mut found: &dyn TableLike = self.document.as_table();
        for name in table.split('.').filter(|name| !name.is_empty()) {
            found = found.get(name)?.as_table_like()?;
        }
        Some(found)
    }

    /// Adds an empty table in one line.
    pub fn add_table(&mut self, key: &str) {
        self.put(key, Value::InlineTable(InlineTable::new()));
    }

    /// Changes a value that is true or false.
    pub fn set_flag(&mut self, key: &str, flag: bool) {
        self.put(key, flag.into());
    }

    /// Changes a value. Its table is added if it is missing. If a trial then shows other images or is answered in another
    /// way, the texts about the old ones are removed.
    pub fn set(&mut self, key: &str, text: &str, typed: Typed) {
        if Self::ARRANGES.contains(&key) {
            self.remove_task_texts();
            // They apply to intervals only.
            ["task.duration_s", "task.gap_s"].iter().filter(|_| text == "places").for_each(|key| self.remove(key));
        }
        match typed {
            Typed::Text => self.put(key, text.into()),
            Typed::Value => self.put(key, value(text)),
            Typed::Values => self.put_list(key, values(text)),
        }
    }

    /// Changes a list of texts.
    pub fn set_texts(&mut self, key: &str, texts: &[String]) {
        self.put_list(key, texts.iter().map(Value::from).collect());
    }

    /// Removes a value or a table.
    pub fn remove(&mut self, key: &str) {
        let (table, name) = split(key);
        if self.found(table).is_some()
            && let Some(table) = self.table(table)
        {
            table.remove(name);
        }
    }

    /// Removes the comment before the first line: in a copy, it would be about the original.
    pub fn remove_opening_comment(&mut self) {
        if let Some((mut key, _)) = self.document.iter_mut().next() {
            key.leaf_decor_mut().set_prefix("");
        }
    }

    /// Changes the kind of the stimulus, and removes the parameters that the new kind does not have, and the texts about
    /// the old one.
    pub fn set_kind(&mut self, kind: &str) {
        let has = |name: &str| catalog::parameters(kind).iter().any(|parameter| parameter.name == name);
        self.put("stimulus.kind", kind.into());
        self.retain("stimulus", |name| name == "kind" || has(name));
        if kind == Picture::KIND {
            // Pictures bring their factors.
            self.remove("factors");
        }
        ["instructions.task", "response.question"].iter().for_each(|key| self.remove(key));
    }

    /// Changes what participants do. Options that the new task does not have are removed, and so are the instructions,
    /// the question and the answers of the old one.
    pub fn set_task(&mut self, kind: &str) {
        self.put("task.kind", kind.into());
        let options = Task::options(kind);
        self.retain("task", |name| name == "kind" || options.iter().any(|option| option.key == name));
        self.remove_task_texts();
    }

    fn remove_task_texts(&mut self) {
        ["instructions.task", "response"].iter().for_each(|key| self.remove(key));
    }

    /// Changes how levels are chosen; `None` if the factors alone have levels. Options that the new method does not have
    /// are removed, and so are the repetitions, because a method has its number of trials.
    pub fn set_method(&mut self, method: Option<&str>) {
        let Some(method) = method else { return self.remove("adaptive") };
        self.put("adaptive.method", method.into());
        self.remove("design.repetitions");
        let options = Adaptive::options(method);
        let has = |name: &str| options.iter().any(|option| option.key.split('.').next() == Some(name));
        self.retain("adaptive", |name| name == "method" || has(name));
    }

    fn retain(&mut self, table: &str, keep: impl Fn(&str) -> bool) {
        let removed: Vec<String> = self.keys(table).into_iter().filter(|key| !keep(key)).collect();
        removed.iter().for_each(|key| self.remove(&format!("{table}.{key}")));
    }

    /// Returns the names of the factors, in their order.
    pub fn factors(&self) -> Vec<String> {
        self.keys("factors")
    }

    /// Returns the keys of a table, in their order.
    pub fn keys(&self, table: &str) -> Vec<String> {
        let table = self.found(table);
        table.map_or_else(Vec::new, |table| table.iter().map(|(key, _)| key.to_owned()).collect())
    }

    /// Returns a table, which is added if it is missing; `None` if its key has a value that is not a table.
    fn table(&mut self, name: &str) -> Option<&mut dyn TableLike> {
        let mut table: &mut dyn TableLike = self.document.as_table_mut();
        for name in name.split('.').filter(|name| !name.is_empty()) {
            table = table.entry(name).or_insert(Item::Table(Table::new())).as_table_like_mut()?;
        }
        Some(table)
    }

    fn put(&mut self, key: &str, mut value: Value) {
        let (table, key) = split(key);
        let Some(table) = self.table(table) else { return };
        match table.get_mut(key) {
            Some(Item::Value(old)) => {
                // The spaces and comments around the old value.
                *value.decor_mut() = old.decor().clone();
                *old = value;
            }
            _ => drop(table.insert(key, Item::Value(value))),
        }
    }

    fn put_list(&mut self, key: &str, values: Vec<Value>) {
        // A list that says the same keeps its layout and its comments.
        let list = self.value(key).and_then(Value::as_array);
        if !list.is_some_and(|list| list.iter().map(listed).eq(values.iter().map(listed))) {
            self.put(key, Value::Array(values.into_iter().collect()));
        }
    }
}

/// Splits a key into its table, which is empty at the top level, and its name.
fn split(key: &str) -> (&str, &str) {
    key.rsplit_once('.').unwrap_or(("", key))
}

/// Returns the text of a value without quotes.
fn plain(value: &Value) -> String {
    value.as_str().map_or_else(|| value.clone().decorated("", "").to_string(), ToOwned::to_owned)
}

/// Returns a value as it is typed in a list: text in quotes only if it would otherwise be read as something else.
fn listed(item: &Value) -> String {
    let text = plain(item);
    let reads_back = matches!(&values(&text)[..], [one] if plain(one) == text && one.is_str() == item.is_str());
    if reads_back { text } else { Value::from(text).decorated("", "").to_string() }
}

/// Reads a typed value: a number, in the form in which it was typed if possible, or text.
fn value(text: &str) -> Value {
    let text = text.trim();
    if !text.parse().is_ok_and(f64::is_finite) {
        return text.into();
    }
    let number = text.parse().ok().filter(|value: &Value| value.is_integer() || value.is_float());
    number
        .or_else(|| Some(text.parse::<i64>().ok()?.into()))
        .unwrap_or_else(|| text.parse::<f64>().unwrap_or(0.0).into())
}

/// Reads a list of values that are separated by commas. Brackets around it are allowed, as in the file.
fn values(text: &str) -> Vec<Value> {
    let text = text.trim();
    let text = text.strip_prefix('[').and_then(|text| text.strip_suffix(']')).unwrap_or(text);
    let mut quote = None;
    let is_between = |c: char| {
        match quote {
            None if c == '"' || c == '\'' => quote = Some(c),
            Some(open) if c == open => quote = None,
            _ => {}
        }
        c == ',' && quote.is_none()
    };
    let mut items: Vec<&str> = text.split(is_between).map(str::trim).collect();
    // The comma at the end may have been typed before the next value.
    if items.last().is_some_and(|last| last.is_empty()) {
        items.pop();
    }
    let quoted = |item: &str| item.parse().ok().filter(|value: &Value| value.is_str());
    items.into_iter().map(|item| quoted(item).unwrap_or_else(|| value(item))).collect()
}
