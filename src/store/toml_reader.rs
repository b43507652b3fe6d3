//! TOML with the place of everything, so that a fault can name line and column, and all faults are found in one go.

use std::{cell::RefCell, collections::HashSet, ops::Range};

use toml::{
    Spanned,
    de::{DeTable, DeValue},
};

use super::{FileFault, FileFaults, text::position};
use crate::stimulus::ParameterValue;

/// A document being read; collects faults.
pub(super) struct Reader<'t> {
    file: &'t str,
    text: &'t str,
    faults: RefCell<Vec<(usize, String)>>,
}

/// One table of it. Every key is asked for by name; what nobody asked for is unknown.
pub(super) struct Section<'r, 't> {
    reader: &'r Reader<'t>,
    table: Option<&'r DeTable<'t>>,
    /// Where a fault of the table itself is shown.
    span: Range<usize>,
    /// Dotted name, empty for the document.
    name: String,
    asked: RefCell<Vec<&'static str>>,
}

/// Parses a document.
///
/// # Errors
/// The first place where the text is no TOML.
pub(super) fn parse<'t>(file: &str, text: &'t str) -> Result<DeTable<'t>, FileFaults> {
    DeTable::parse(text).map(Spanned::into_inner).map_err(|error| {
        let at = error.span().map_or(text.len(), |span| span.start);
        FileFaults(vec![FileFault {
            file: file.to_owned(),
            position: Some(position(text, at)),
            message: format!("is not valid TOML: {}", error.message().replace('\n', ", ")),
        }])
    })
}

impl<'t> Reader<'t> {
    pub(super) fn new(file: &'t str, text: &'t str) -> Self {
        Self { file, text, faults: RefCell::default() }
    }

    /// The document's top table.
    pub(super) fn root<'r>(&'r self, table: &'r DeTable<'t>) -> Section<'r, 't> {
        Section { reader: self, table: Some(table), span: 0..0, name: String::new(), asked: RefCell::default() }
    }

    pub(super) fn fault(&self, at: usize, message: impl Into<String>) {
        self.faults.borrow_mut().push((at, message.into()));
    }

    /// Where faults have been found so far.
    pub(super) fn places(&self) -> HashSet<usize> {
        self.faults.borrow().iter().map(|(at, _)| *at).collect()
    }

    /// All faults in the order of the text, if there are any.
    pub(super) fn finish(self) -> Result<(), FileFaults> {
        let mut faults = self.faults.into_inner();
        if faults.is_empty() {
            return Ok(());
        }
        faults.sort();
        faults.dedup();
        // From one fault to the next, not each from the start: there may be a hundred thousand of them.
        let (mut from, mut line, mut column) = (0, 1, 1);
        let located = faults.into_iter().map(|(at, message)| {
            let (lines, columns) = position(&self.text[from..], at - from);
            (line, column) = if lines > 1 { (line + lines - 1, columns) } else { (line, column + columns - 1) };
            from = at;
            FileFault { file: self.file.to_owned(), position: Some((line, column)), message }
        });
        Err(FileFaults(located.collect()))
    }
}

/// The place of a dotted path such as `factors.width.2`, or of the nearest table or array that exists on the way.
pub(super) fn locate(table: &DeTable<'_>, path: &str) -> usize {
    let mut at = 0;
    let mut steps = path.split('.');
    let Some((key, value)) = steps.next().and_then(|step| table.get_key_value(step)) else { return at };
    at = key.span().start;
    let mut value = value;
    for step in steps {
        value = match value.get_ref() {
            DeValue::Table(inner) => match inner.get_key_value(step) {
                Some((key, value)) => {
                    at = key.span().start;
                    value
                }
                None => return at,
            },
            DeValue::Array(items) => match step.parse::<usize>().ok().and_then(|i| items.get(i)) {
                Some(item) => {
                    at = item.span().start;
                    item
                }
                None => return at,
            },
            _ => return at,
        };
    }
    at
}

impl<'r, 't> Section<'r, 't> {
    fn get(&self, key: &'static str) -> Option<(&'r Spanned<DeValue<'t>>, usize)> {
        self.asked.borrow_mut().push(key);
        let value = self.table?.get(key)?;
        Some((value, value.span().start))
    }

    fn label(&self, key: &str) -> String {
        if self.name.is_empty() { key.to_owned() } else { format!("{}.{key}", self.name) }
    }

    fn expected(&self, key: &str, at: usize, value: &DeValue<'_>, what: &str) {
        self.reader.fault(at, format!("{} is {}; expected {what}", self.label(key), describe(value)));
    }

    /// A table within this one; absent is like empty.
    pub(super) fn section(&self, key: &'static str) -> Section<'r, 't> {
        let found = self.get(key);
        let table = found.and_then(|(value, at)| match value.get_ref() {
            DeValue::Table(table) => Some(table),
            other => {
                self.expected(key, at, other, &format!("a table [{}]", self.label(key)));
                None
            }
        });
        Section {
            reader: self.reader,
            table,
            span: found.map_or(self.span.clone(), |(value, _)| value.span()),
            name: self.label(key),
            asked: RefCell::default(),
        }
    }

    /// A number; `default` where the key is absent.
    pub(super) fn number(&self, key: &'static str, default: f64) -> f64 {
        let Some((value, at)) = self.get(key) else { return default };
        number(value.get_ref()).unwrap_or_else(|| {
            self.expected(key, at, value.get_ref(), "a number");
            default
        })
    }

    /// The version of the format, which must be there and be 1.
    pub(super) fn schema(&self) {
        match self.whole("schema") {
            Some(1) => {}
            Some(other) => self.fault_at("schema", format!("schema {other} is not known; expected 1")),
            // Of another type is a fault already.
            None if self.table.is_some_and(|table| table.contains_key("schema")) => {}
            None => self.missing("schema"),
        }
    }

    /// A whole number from 0; `None` where the key is absent.
    pub(super) fn whole(&self, key: &'static str) -> Option<u32> {
        let (value, at) = self.get(key)?;
        let whole = match value.get_ref() {
            DeValue::Integer(digits) => u32::from_str_radix(digits.as_str(), digits.radix()).ok(),
            _ => None,
        };
        if whole.is_none() {
            self.expected(key, at, value.get_ref(), "a whole number from 0 to 4294967295");
        }
        whole
    }

    /// A text; `None` where the key is absent.
    pub(super) fn text(&self, key: &'static str) -> Option<String> {
        let (value, at) = self.get(key)?;
        match value.get_ref() {
            DeValue::String(text) => Some(text.to_string()),
            other => {
                self.expected(key, at, other, "a text in quotes");
                None
            }
        }
    }

    /// A text that must be there.
    pub(super) fn required_text(&self, key: &'static str) -> Option<String> {
        let text = self.text(key);
        if self.table.is_some_and(|table| !table.contains_key(key)) || self.table.is_none() {
            self.missing(key);
        }
        text
    }

    /// Says that a key is missing.
    pub(super) fn missing(&self, key: &str) {
        self.reader.fault(self.span.start, format!("{} is missing; expected {key} = …", self.label(key)));
    }

    /// A list of values that `read` understands, `None` for each that it does not; `None` where the key is absent.
    fn list<T>(
        &self,
        key: &'static str,
        what: &str,
        read: impl Fn(&DeValue<'t>) -> Option<T>,
    ) -> Option<Vec<Option<T>>> {
        let (value, at) = self.get(key)?;
        let DeValue::Array(items) = value.get_ref() else {
            self.expected(key, at, value.get_ref(), &format!("a list of {what}s in brackets"));
            return None;
        };
        let mut list = Vec::with_capacity(items.len());
        for item in items.iter() {
            let read = read(item.get_ref());
            if read.is_none() {
                self.expected(key, item.span().start, item.get_ref(), &format!("a {what}"));
            }
            list.push(read);
        }
        Some(list)
    }

    /// A list of texts; `None` also where one is none: the others would not stand in their places.
    pub(super) fn texts(&self, key: &'static str) -> Option<Vec<String>> {
        self.list(key, "text", |value| match value {
            DeValue::String(text) => Some(text.to_string()),
            _ => None,
        })?
        .into_iter()
        .collect()
    }

    /// A list of numbers; `None` also where one is none.
    pub(super) fn numbers(&self, key: &'static str) -> Option<Vec<f64>> {
        self.list(key, "number", number)?.into_iter().collect()
    }

    /// A parameter's value, number or text; `None` where the key is absent.
    pub(super) fn parameter(&self, key: &'static str) -> Option<(ParameterValue, usize)> {
        let (value, at) = self.get(key)?;
        let parameter = parameter(value.get_ref());
        if parameter.is_none() {
            self.expected(key, at, value.get_ref(), "a number or a text");
        }
        parameter.map(|parameter| (parameter, at))
    }

    /// A list of parameter values. In the place of one that is none stands an empty text, which no parameter takes.
    pub(super) fn parameters(&self, key: &'static str) -> Option<Vec<ParameterValue>> {
        Some(
            self.list(key, "number or text", parameter)?
                .into_iter()
                .map(|value| value.unwrap_or_else(|| "".into()))
                .collect(),
        )
    }

    /// Whether a key is there, whatever its value.
    pub(super) fn has(&self, key: &str) -> bool {
        self.table.is_some_and(|table| table.contains_key(key))
    }

    /// Whether a key is there and a text.
    pub(super) fn is_text(&self, key: &str) -> bool {
        self.table.and_then(|table| table.get(key)).is_some_and(|value| matches!(value.get_ref(), DeValue::String(_)))
    }

    /// Whether this is the whole document.
    pub(super) fn is_root(&self) -> bool {
        self.name.is_empty()
    }

    /// The keys in the order of the text.
    pub(super) fn keys(&self) -> Vec<String> {
        self.table.map_or_else(Vec::new, |table| table.keys().map(|key| key.get_ref().to_string()).collect())
    }

    /// Makes a key known without reading it.
    pub(super) fn knows(&self, key: &'static str) {
        self.asked.borrow_mut().push(key);
    }

    /// A fault at a key's value, or at the table where the key is absent.
    pub(super) fn fault_at(&self, key: &str, message: impl Into<String>) {
        let at = self.table.and_then(|table| table.get(key)).map_or(self.span.start, |value| value.span().start);
        self.reader.fault(at, message);
    }

    /// Ends the table: every key that nobody asked for is unknown.
    pub(super) fn finish(self) {
        let mut asked = self.asked.into_inner();
        asked.sort_unstable();
        asked.dedup();
        for key in self.table.into_iter().flat_map(|table| table.keys()) {
            let name = key.get_ref().as_ref();
            if asked.contains(&name) {
                continue;
            }
            let place = if self.name.is_empty() { String::new() } else { format!(" in [{}]", self.name) };
            self.reader.fault(key.span().start, format!("unknown key {name:?}{place}; {}", nearest(name, &asked)));
        }
    }
}

/// "did you mean …?" where something is near, and what is known.
pub(super) fn nearest(name: &str, known: &[&str]) -> String {
    let best = known
        .iter()
        .map(|candidate| (strsim::damerau_levenshtein(name, candidate), candidate))
        .min()
        .filter(|(distance, candidate)| *distance <= 2.max(candidate.chars().count() / 2));
    match best {
        Some((_, candidate)) => format!("expected one of {}; did you mean {candidate}?", known.join(", ")),
        None => format!("expected one of {}", known.join(", ")),
    }
}

fn number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Integer(digits) => i64::from_str_radix(digits.as_str(), digits.radix()).ok().map(|i| i as f64),
        DeValue::Float(digits) => digits.as_str().parse().ok(),
        _ => None,
    }
}

fn parameter(value: &DeValue<'_>) -> Option<ParameterValue> {
    match value {
        DeValue::String(text) => Some(ParameterValue::Text(text.to_string())),
        // TOML's own inf can only mean what "inf" means.
        other => number(other).map(|number| match number {
            f64::INFINITY => ParameterValue::from("inf"),
            number => ParameterValue::Number(number),
        }),
    }
}

fn describe(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(text) => format!("the text {text:?}"),
        DeValue::Integer(digits) => digits.to_string(),
        DeValue::Float(digits) => digits.to_string(),
        DeValue::Boolean(value) => value.to_string(),
        DeValue::Datetime(time) => format!("the time {time}"),
        DeValue::Array(_) => "a list".to_owned(),
        DeValue::Table(_) => "a table".to_owned(),
    }
}
