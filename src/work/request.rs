//! Requests: what an operation is asked to do, whoever asks.
//!
//! A request is one struct. The command line reads it with clap, Python gives its fields by name, the window keeps it as
//! its state, and [`words`] writes it back as the command that repeats it. Names, bounds, defaults and help stand at its
//! fields and nowhere else.
//!
//! From the types of the paths of outputs follows what a skin must guard, so a new operation is guarded too.
//!
//! A [`Watcher`] is whoever waits for an operation, and what it learns about files.

use std::{
    collections::BTreeSet,
    error::Error as _,
    fmt::Display,
    ops::Deref,
    path::{Path, PathBuf},
};

use clap::{
    Arg, Args, Command, FromArgMatches,
    builder::{MapValueParser, PathBufValueParser, TypedValueParser as _, ValueParserFactory},
    error::{ContextKind, ContextValue, ErrorKind},
};
use serde::Serialize;
use serde_json::{Map, Value};

use crate::{
    store::{StoreError, table::list},
    text::names::expected_one_of,
};

/// A struct with a field for each option. To be written as [words], it also implements [`Serialize`], which writes a field
/// as the option's value: a text, a number, a flag, or a list.
pub trait Request: Args + FromArgMatches {}

impl<T: Args + FromArgMatches> Request for T {}

/// A request that cannot be carried out. Each skin names the field in its own way.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", self.told(str::to_owned))]
pub struct RequestError {
    /// The field that is wrong; `None` if it is the request as a whole.
    pub field: Option<String>,
    /// What follows the name of the field: its value, what is wrong with it, and what is expected.
    text: String,
    /// What would be possible: some words, a field, and its value, quoted for a shell.
    hint: Option<(&'static str, &'static str, String)>,
}

impl RequestError {
    /// Says what is wrong with a field.
    pub fn new(field: &str, message: impl Display) -> Self {
        Self { field: Some(field.to_owned()), text: format!(": {message}"), hint: None }
    }

    /// Says what is wrong with a field; the message begins with its value.
    pub fn value(field: &str, message: impl Display) -> Self {
        Self { field: Some(field.to_owned()), text: format!(" {message}"), hint: None }
    }

    /// Says what is wrong with the request as a whole.
    pub fn whole(message: impl Display) -> Self {
        Self { field: None, text: message.to_string(), hint: None }
    }

    /// Adds a value of a field that would be possible.
    #[must_use]
    pub fn such_as(self, field: &'static str, value: &str) -> Self {
        let quoted = shlex::try_quote(value).map_or_else(|_| value.to_owned(), Into::into);
        Self { hint: Some((", such as ", field, format!(" {quoted}"))), ..self }
    }

    /// Adds that a flag would make the request possible.
    #[must_use]
    pub fn unless(self, flag: &'static str) -> Self {
        Self { hint: Some((", or the option ", flag, String::new())), ..self }
    }

    /// Returns the message with its fields as `name` writes them.
    pub fn told(&self, name: impl Fn(&str) -> String) -> String {
        let field = self.field.as_deref().map_or_else(String::new, &name);
        let hint = self.hint.as_ref().map(|(words, field, value)| format!("{words}{}{value}", name(field)));
        field + &self.text + &hint.unwrap_or_default()
    }

    /// Returns the message without the field and without a hint at another one.
    pub fn plain(&self) -> &str {
        self.text.trim_start_matches([':', ' '])
    }

    /// Reads an error of clap, which names options as the command line does.
    fn of(error: &clap::Error, command: &Command) -> Self {
        let context = |kind| error.get(kind).map(ToString::to_string);
        let named = context(ContextKind::InvalidArg).unwrap_or_default();
        let option = named.split([' ', '=']).next().unwrap_or_default().trim_start_matches("--");
        let field = command.get_arguments().find(|argument| argument.get_long() == Some(option));
        let field = field.map(|argument| argument.get_id().to_string());
        let value = context(ContextKind::InvalidValue).filter(|value| !value.is_empty());
        let message = match (error.kind(), error.get(ContextKind::ValidValue), error.source()) {
            (ErrorKind::InvalidValue, Some(ContextValue::Strings(known)), _) if !known.is_empty() => {
                let name = value.as_deref().unwrap_or_default();
                format!("{name:?} is not known; {}", expected_one_of(name, known))
            }
            (_, _, Some(source)) => format!("{}: {source}", value.unwrap_or_default()),
            _ => {
                let text = error.render().to_string();
                let lines =
                    text.lines().take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more"));
                let lines: Vec<&str> = lines.map(str::trim).filter(|line| !line.is_empty()).collect();
                return Self::whole(lines.join("; ").replace(":; ", ": ").trim_start_matches("error: "));
            }
        };
        Self { field, text: format!(" {message}"), hint: None }
    }
}

/// Returns the message of an error, in which `name` writes the fields of the request.
pub fn told(error: &anyhow::Error, name: impl Fn(&str) -> String) -> String {
    let remedy = error.downcast_ref().and_then(StoreError::remedy);
    match (error.downcast_ref::<RequestError>(), remedy) {
        (Some(request), _) => request.told(name),
        (None, Some(field)) => format!("{error}, or the option {}", name(field)),
        (None, None) => error.to_string(),
    }
}

/// Makes a request from named values. Missing fields and `null` have their defaults; a list is a list of names.
///
/// # Errors
/// A name is not known, or a value is not possible.
pub fn from_names<T: Request>(given: &Map<String, Value>) -> Result<T, RequestError> {
    let command = T::augment_args(Command::new("machband").no_binary_name(true));
    let mut line = Line::default();
    let known: Vec<&str> = command.get_arguments().map(|argument| argument.get_id().as_str()).collect();
    if let Some(name) = given.keys().find(|name| !known.contains(&name.as_str())) {
        return Err(RequestError::value(name, format!("is not known; {}", expected_one_of(name, &known))));
    }
    // In the order of the command, which tells arguments without a name apart.
    for argument in command.get_arguments() {
        if let Some(value) = given.get(argument.get_id().as_str()) {
            line.add(argument, value);
        }
    }
    let matches = command.clone().try_get_matches_from(line.words());
    matches.and_then(|matches| T::from_arg_matches(&matches)).map_err(|error| RequestError::of(&error, &command))
}

/// Returns the arguments of a request that differ from their defaults, with their values.
fn given<T: Request + Serialize>(request: &T) -> Vec<(Arg, Value)> {
    // A request has texts, numbers, flags and lists. Only a path that is not Unicode cannot be written.
    let values = serde_json::to_value(request).unwrap_or_default();
    let is_default = |argument: &Arg, value: &Value| {
        let default: Vec<_> = argument.get_default_values().iter().map(|value| value.to_string_lossy()).collect();
        let is_nothing =
            matches!(value, Value::Null | Value::Bool(false)) || value.as_array().is_some_and(Vec::is_empty);
        // An infinite number is null in JSON.
        if default.is_empty() { is_nothing } else { value.is_null() || default.join(",") == text(value) }
    };
    let command = T::augment_args(Command::new("machband"));
    let arguments = command.get_arguments().map(|argument| (argument, &values[argument.get_id().as_str()]));
    let arguments = arguments.filter(|(argument, value)| !is_default(argument, value));
    arguments.map(|(argument, value)| (argument.clone(), value.clone())).collect()
}

/// Returns the fields of a request that differ from their defaults, with their values: what stands without an option on
/// the command line, then the options.
pub fn changed<T: Request + Serialize>(request: &T) -> Vec<(String, Value)> {
    given(request).into_iter().map(|(argument, value)| (argument.get_id().to_string(), value)).collect()
}

/// Checks that only these fields of a request differ from their defaults.
///
/// # Errors
/// Says the message about the first other field.
pub(super) fn allow_only<T: Request + Serialize>(
    request: &T,
    fields: &[&str],
    message: &str,
) -> Result<(), RequestError> {
    let other = changed(request).into_iter().find(|(field, _)| !fields.contains(&field.as_str()));
    other.map_or(Ok(()), |(field, _)| Err(RequestError::new(&field, message)))
}

/// Returns the words of the command line that repeat a request: what stands without an option, then every option that
/// differs from its default.
pub fn words<T: Request + Serialize>(request: &T) -> Vec<String> {
    let mut line = Line::default();
    given(request).iter().for_each(|(argument, value)| line.add(argument, value));
    line.words()
}

/// Returns the command that repeats a request, quoted for a POSIX shell: this program's name, that of the command, the words of
/// the request, and `others`.
pub fn command<T: Request + Serialize>(name: &str, request: &T, others: &[&str]) -> String {
    let words = words(request);
    let all = [env!("CARGO_PKG_NAME"), name].into_iter().chain(words.iter().map(String::as_str));
    // Quoting fails only for a zero byte, which no shell can pass to a program.
    shlex::try_join(all.chain(others.iter().copied())).unwrap_or_default()
}

/// A command line.
#[derive(Default)]
struct Line {
    /// Names of options, with their values.
    options: Vec<(String, Option<String>)>,
    /// Values without an option.
    places: Vec<String>,
}

impl Line {
    /// Adds an argument with this value, if it has one.
    fn add(&mut self, argument: &Arg, value: &Value) {
        let is_repeated =
            matches!(argument.get_action(), clap::ArgAction::Append) && argument.get_value_delimiter().is_none();
        let values = match value {
            Value::Null | Value::Bool(false) => return,
            Value::Array(values) if is_repeated || argument.is_positional() => values.iter().map(text).collect(),
            Value::Array(values) if values.is_empty() => return,
            value => vec![text(value)],
        };
        match argument.get_long() {
            None => self.places.extend(values),
            Some(long) if *value == Value::Bool(true) => self.options.push((long.to_owned(), None)),
            Some(long) => self.options.extend(values.into_iter().map(|value| (long.to_owned(), Some(value)))),
        }
    }

    /// Returns the words. A value that begins with a hyphen cannot be taken for an option.
    fn words(self) -> Vec<String> {
        let hyphen = self.places.iter().any(|place| place.starts_with('-')).then(|| "--".to_owned());
        let option = |(long, value): (String, Option<String>)| match value {
            None => vec![format!("--{long}")],
            Some(value) if value.starts_with('-') || value.is_empty() => vec![format!("--{long}={value}")],
            Some(value) => vec![format!("--{long}"), value],
        };
        match hyphen {
            None => self.places.into_iter().chain(self.options.into_iter().flat_map(option)).collect(),
            Some(hyphen) => self.options.into_iter().flat_map(option).chain([hyphen]).chain(self.places).collect(),
        }
    }
}

/// Writes a value as a word of the command line.
fn text(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        Value::Array(values) => list(values.iter().map(text)),
        Value::Number(number) if number.is_f64() => number.as_f64().unwrap_or_default().to_string(),
        other => other.to_string(),
    }
}

macro_rules! output_path {
    ($(#[$documentation:meta])* $name:ident) => {
        $(#[$documentation])*
        #[derive(Clone, Debug, PartialEq, Eq, Serialize)]
        pub struct $name(PathBuf);

        impl ValueParserFactory for $name {
            type Parser = MapValueParser<PathBufValueParser, fn(PathBuf) -> Self>;

            fn value_parser() -> Self::Parser {
                PathBufValueParser::new().map(Self)
            }
        }

        impl From<PathBuf> for $name {
            fn from(path: PathBuf) -> Self {
                Self(path)
            }
        }

        impl Deref for $name {
            type Target = Path;

            fn deref(&self) -> &Path {
                &self.0
            }
        }
    };
}

output_path! {
    /// A file to write, or, with the hint [`clap::ValueHint::DirPath`], a folder to write files into.
    OutPath
}
output_path! {
    /// A folder to create; the operation itself checks that it is new or empty.
    NewFolder
}
output_path! {
    /// A file that is written if the field `fit` is given, and otherwise read.
    FittedPath
}

/// Learns how far an operation is, and may end it. A skin shows what it learns in its own way.
pub trait Watcher: Sync {
    /// Learns what is being done now, such as `reading`.
    fn stage(&self, _what: &'static str) {}
    /// Learns that `done` of `total` steps are done. Steps may end out of order.
    fn progress(&self, _done: u64, _total: u64) {}
    /// Receives a warning.
    fn warn(&self, _warning: &str) {}
    /// Learns something about a file as soon as it is known.
    ///
    /// # Errors
    /// The operation should end.
    fn found(&self, _file: &Path, _sentence: &str) -> anyhow::Result<()> {
        Ok(())
    }
    /// Says whether to continue; `place` is where the results so far are.
    ///
    /// # Errors
    /// The operation should end.
    fn check(&self, _place: &Path) -> anyhow::Result<()> {
        Ok(())
    }
}

/// Nobody waits.
impl Watcher for () {}

/// A sentence about each file, and everything that is wrong.
#[derive(Debug, Default)]
pub struct Found {
    pub files: Vec<(PathBuf, String)>,
    /// The data files of the sessions in which something is wrong.
    pub wrong: BTreeSet<PathBuf>,
    pub errors: Vec<StoreError>,
}

impl Found {
    /// Adds a sentence about a file, of which the watcher learns at once.
    ///
    /// # Errors
    /// The watcher ends the operation.
    pub(super) fn add(&mut self, file: &Path, sentence: String, watcher: &dyn Watcher) -> anyhow::Result<()> {
        watcher.found(file, &sentence)?;
        self.files.push((file.to_owned(), sentence));
        Ok(())
    }
}
