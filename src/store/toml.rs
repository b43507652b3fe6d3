//! TOML files, read into types that derive `Deserialize`. Each fault has its line and column, and all faults of a file are
//! found in one pass: a value that cannot be read is reported and skipped, as if its key were absent.

use serde::de::DeserializeOwned;
use serde_json::{Map, Value};
use toml::de::{DeTable, DeValue};

use super::{FileFault, FileFaults, fault::position};
use crate::light::names::expected_one_of;

/// Maximum number of unreadable values: the file is read again for each of them.
const MOST_UNREAD: usize = 100;

/// A TOML document, and the faults found in it so far.
pub(super) struct Document<'t> {
    file: &'t str,
    text: &'t str,
    table: DeTable<'t>,
    /// Locations in the text, and their faults.
    faults: Vec<(usize, String)>,
    /// Locations of the values that could not be read.
    unread: Vec<usize>,
}

/// Reads a document whose `schema` is 1. The caller checks the value, reports faults with [`Document::fault`], and ends
/// with [`Document::finish`].
///
/// # Errors
/// Text that is not TOML; faults that leave no value, such as a missing key without a default.
pub(super) fn read<'t, T: DeserializeOwned>(file: &'t str, text: &'t str) -> Result<(T, Document<'t>), FileFaults> {
    let mut document = Document::parse(file, text)?;
    let mut value = json_table(&document.table);
    match value.as_object_mut().and_then(|keys| keys.shift_remove("schema")) {
        Some(Value::Number(one)) if one.as_u64() == Some(1) => {}
        Some(other) => document.fault("schema", format!("schema is {other}; expected 1")),
        None => document.fault("schema", "schema is missing; expected schema = 1"),
    }
    loop {
        let error = match serde_path_to_error::deserialize::<_, T>(&value) {
            Ok(read) => return Ok((read, document)),
            Err(error) => error,
        };
        let path = error.path().to_string().replace('[', ".").replace(']', "");
        // A single dot is the document.
        let path = path.trim_matches('.');
        let message = error.inner().to_string();
        if let Some(field) = message.strip_prefix("missing field `") {
            let field = field.trim_end_matches('`');
            let name = format!("{path}.{field}");
            let name = name.trim_start_matches('.');
            document.fault(name, format!("{name} is missing; expected {field} = …"));
        } else {
            let place = document.locate(path);
            document.faults.push((place, explained(path, &message)));
            document.unread.push(place);
        }
        if document.unread.len() > MOST_UNREAD || !remove(&mut value, path) {
            return Err(document.located());
        }
    }
}

impl<'t> Document<'t> {
    /// # Errors
    /// The first place where the text is not TOML.
    pub(super) fn parse(file: &'t str, text: &'t str) -> Result<Self, FileFaults> {
        let table = DeTable::parse(text).map_err(|error| {
            let at = error.span().map_or(text.len(), |span| span.start);
            let message = format!("is not valid TOML: {}", error.message().replace('\n', ", "));
            FileFaults(vec![FileFault::at(file, position(text, at), message)])
        })?;
        Ok(Self { file, text, table: table.into_inner(), faults: Vec::new(), unread: Vec::new() })
    }

    /// Whether there is such a key at the top level.
    pub(super) fn has(&self, key: &str) -> bool {
        self.table.contains_key(key)
    }

    /// Reports a fault at a dotted path such as `factors.width.2`, or at the nearest existing parent. If the value could not
    /// be read at all, the fault about that is enough.
    pub(super) fn fault(&mut self, path: &str, message: impl Into<String>) {
        let place = self.locate(path);
        if !self.unread.contains(&place) {
            self.faults.push((place, message.into()));
        }
    }

    /// Reports a number at the top level that is outside `least…most`.
    pub(super) fn check_range(&mut self, key: &str, value: f64, least: f64, most: f64) {
        if !(least..=most).contains(&value) {
            self.fault(key, format!("{key} {value} is outside {least}…{most}; expected a number in this range"));
        }
    }

    /// The value, unless the document has faults.
    ///
    /// # Errors
    /// Every fault, in the order of the text.
    pub(super) fn finish<T>(self, value: T) -> Result<T, FileFaults> {
        if self.faults.is_empty() { Ok(value) } else { Err(self.located()) }
    }

    fn located(mut self) -> FileFaults {
        self.faults.sort();
        // Counted from one fault to the next instead of from the start, since there may be a hundred thousand of them.
        let (mut from, mut line, mut column) = (0, 1, 1);
        let located = self.faults.into_iter().map(|(at, message)| {
            let (lines, columns) = position(&self.text[from..], at - from);
            (line, column) = if lines > 1 { (line + lines - 1, columns) } else { (line, column + columns - 1) };
            from = at;
            FileFault::at(self.file, (line, column), message)
        });
        FileFaults(located.collect())
    }

    /// Where a key or a list item begins.
    fn locate(&self, path: &str) -> usize {
        let (first, rest) = path.split_once('.').unwrap_or((path, ""));
        let Some((key, value)) = self.table.get_key_value(first) else { return 0 };
        let (mut place, mut value) = (key.span().start, value);
        for step in rest.split('.') {
            let next = match value.get_ref() {
                DeValue::Table(table) => table.get_key_value(step).map(|(key, value)| (key.span(), value)),
                DeValue::Array(items) => {
                    step.parse::<usize>().ok().and_then(|i| items.get(i)).map(|item| (item.span(), item))
                }
                _ => None,
            };
            let Some((span, found)) = next else { break };
            (place, value) = (span.start, found);
        }
        place
    }
}

/// Non-finite numbers become texts, since `inf` is a depth; so do times.
fn json(value: &DeValue<'_>) -> Value {
    let number = |number: f64| if number.is_finite() { number.into() } else { number.to_string().into() };
    match value {
        DeValue::String(text) => text.as_ref().into(),
        DeValue::Integer(digits) => match i64::from_str_radix(digits.as_str(), digits.radix()) {
            Ok(whole) => whole.into(),
            Err(_) => digits.to_string().into(),
        },
        DeValue::Float(digits) => digits.as_str().parse().map_or(Value::Null, number),
        DeValue::Boolean(value) => (*value).into(),
        DeValue::Datetime(time) => time.to_string().into(),
        DeValue::Array(items) => items.iter().map(|item| json(item.get_ref())).collect(),
        DeValue::Table(table) => json_table(table),
    }
}

fn json_table(table: &DeTable<'_>) -> Value {
    let entry = |(key, value): (&toml::Spanned<_>, &toml::Spanned<_>)| {
        let key: &toml::de::DeString<'_> = key.get_ref();
        (key.to_string(), json(value.get_ref()))
    };
    Value::Object(table.iter().map(entry).collect::<Map<_, _>>())
}

/// Removes the key at a dotted path, or the key whose list has a fault there, and returns whether there was one.
fn remove(value: &mut Value, path: &str) -> bool {
    let Value::Object(keys) = value else { return false };
    let (first, rest) = path.split_once('.').unwrap_or((path, ""));
    keys.get_mut(first).is_some_and(|inner| remove(inner, rest)) || keys.shift_remove(first).is_some()
}

/// Rephrases serde's message about the value at `path` in this program's style.
fn explained(path: &str, error: &str) -> String {
    let (table, key) = path.rsplit_once('.').unwrap_or(("", path));
    if error.starts_with("unknown field") {
        // unknown field `widht`, expected one of `width`, `depth`
        let known: Vec<&str> = error.split('`').skip(3).step_by(2).collect();
        return unknown_key(table, key, &known);
    }
    let Some((wrong, expected)) = error.split_once(", expected ") else { return error.to_owned() };
    let expected = match expected {
        "f64" => "a number",
        "u8" => "a whole number from 0 to 255",
        "u32" => "a whole number from 0 to 4294967295",
        "a string" => "a text in quotes",
        "a sequence" => "a list in brackets",
        other if other.starts_with("struct ") => "a table",
        other => &other.replace("an array", "a list"),
    };
    let Some(found) = wrong.strip_prefix("invalid type: ").or(wrong.strip_prefix("invalid value: ")) else {
        return format!("{path}: {wrong}; expected {expected}");
    };
    let found = match found.split_once(' ') {
        None if found == "sequence" => "a list",
        None if found == "map" => "a table",
        Some(("string", text)) => &format!("the text {text}"),
        // integer `7`, floating point `0.5`, boolean `true`
        _ => found.split('`').nth(1).unwrap_or(found),
    };
    format!("{path} is {found}; expected {expected}")
}

/// The message for an unknown key in a table, with the valid keys.
pub(super) fn unknown_key(table: &str, key: &str, known: &[&str]) -> String {
    let place = if table.is_empty() { String::new() } else { format!(" in [{table}]") };
    format!("unknown key {key:?}{place}; {}", expected_one_of(key, known))
}
