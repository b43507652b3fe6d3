//! Experiment definitions: TOML files and built-in definitions.

use std::{borrow::Cow, collections::HashSet, path::Path};

use serde::Deserialize;
use serde_json::{Map, Value};

use super::{
    FileErrors, StoreError, Writer,
    file::{read_text, sha256},
    pictures::{self, Place},
    toml::{self, TableReader, unknown_key},
};
use crate::{
    experiment::{
        Category, Definition, DefinitionError, DefinitionErrors, Factor, ParticipantField, Protocol, ResponseScale,
        task::{Adaptive, Common, Method, OptionReader as _, Task},
    },
    stimulus::{
        KINDS, ParameterValue, Stimulus,
        picture::{Gallery, Picture},
    },
    system::found,
    text::names::expected_one_of,
};

/// A built-in definition.
pub struct BuiltIn {
    /// The name, as in `machband run NAME`.
    pub name: &'static str,
    /// The TOML text of the file in `experiments/`.
    pub text: &'static str,
}

macro_rules! built_in {
    ($($name:literal),*) => {
        /// The built-in definitions; the first is the default.
        pub const BUILT_IN: &[BuiltIn] = &[$(BuiltIn {
            name: $name,
            text: include_str!(concat!("../../experiments/", $name, ".toml")),
        }),*];
    };
}
built_in!("quick", "bangay2003", "orientation", "shaders", "threshold-width", "pairs-shaders", "kink-threshold");

/// Opens a built-in definition by its name, or a file by its path.
///
/// # Errors
/// Returns every error in the file, or reports that neither such a definition nor such a file exists.
pub fn open(name_or_path: impl AsRef<Path>) -> Result<Protocol, FileErrors> {
    let name_or_path = name_or_path.as_ref();
    parse(&name_or_path.display().to_string(), &text(name_or_path)?)
}

/// Returns the text of a built-in definition, or of a file.
///
/// # Errors
/// Reports that neither such a definition nor such a file exists, or why the file cannot be read.
pub fn text(name_or_path: &Path) -> Result<Cow<'static, str>, FileErrors> {
    if let Some(built_in) = built_in(name_or_path) {
        return Ok(built_in.text.into());
    }
    let looks_like_a_name = name_or_path.extension().is_none() && name_or_path.components().count() == 1;
    if looks_like_a_name && matches!(found(name_or_path), Ok(None)) {
        let names: Vec<_> = BUILT_IN.iter().map(|built_in| built_in.name).collect();
        let expected = expected_one_of(&name_or_path.display().to_string(), &names);
        let expected = expected.replacen("one of", "the path to a .toml file, or one of", 1);
        let message = format!("is neither a built-in definition nor a file; {expected}");
        return Err(FileErrors::whole(name_or_path, message));
    }
    read_text(name_or_path).map(Cow::Owned)
}

/// Returns the built-in definition of this name, or `None` if there is none.
pub fn built_in(name: &Path) -> Option<&'static BuiltIn> {
    BUILT_IN.iter().find(|built_in| built_in.name == name.as_os_str())
}

/// Parses the text of a definition; `file` identifies it in messages.
///
/// # Errors
/// Returns every error, with its line and column.
pub fn parse(file: &str, text: &str) -> Result<Protocol, FileErrors> {
    parse_again(file, text, None)
}

/// Like [`parse`], for a definition that is edited: pictures that it had `before` are not read again.
///
/// # Errors
/// Returns every error, with its line and column.
pub fn parse_again(file: &str, text: &str, before: Option<&Protocol>) -> Result<Protocol, FileErrors> {
    let (written, mut document) = toml::read::<Map<String, Value>>(file, text)?;
    let known = match before.map(|before| &before.stimulus) {
        Some(Stimulus::Image(picture)) => Some(&*picture.gallery),
        _ => None,
    };
    let place = Place { folder: Path::new(file).parent().unwrap_or(Path::new("")), known };
    match protocol(written, Some(place)) {
        Ok(protocol) => document.finish(protocol),
        Err(errors) => {
            errors.into_iter().for_each(|error| document.error(&error.path, error.message));
            Err(document.located())
        }
    }
}

/// Reads the definition in a sidecar.
///
/// # Errors
/// Returns every error in the definition.
pub fn from_json(file: &str, definition: &Value) -> Result<Protocol, FileErrors> {
    let fail = |message: String| FileErrors::whole(file, message);
    let Value::Object(mut written) = definition.clone() else {
        return Err(fail("the definition cannot be read; expected a table, as in a definition file".to_owned()));
    };
    if written.shift_remove("schema") != Some(1.into()) {
        return Err(fail("the schema of the definition is missing or not 1; expected schema 1".to_owned()));
    }
    protocol(written, None).map_err(|errors| {
        FileErrors(errors.into_iter().flat_map(|error| fail(format!("definition: {}", error.message)).0).collect())
    })
}

/// Writes a definition. `opened` is the text of the file when it was opened, if it was edited, and `None` for a new file.
///
/// # Errors
/// Another program changed the file meanwhile, there is a file with this name, or the file cannot be written. Then no
/// file is lost.
pub fn save(path: &Path, opened: Option<&str>, written: &str) -> Result<(), StoreError> {
    if let Some(opened) = opened
        && text(path)? != opened
    {
        let what = "was changed by another program; expected it as it was opened. Leave the form and open it again";
        return Err(StoreError::protected(path, what));
    }
    // Only the file that was edited is replaced: another may be the definition of a study with sessions.
    Writer::new(Vec::new(), opened.is_some()).write(path, written.as_bytes())
}

/// Returns the SHA-256 of what a definition says, in lowercase hexadecimal. Comments, layout, the order of keys, and
/// values that are equal to their defaults do not affect it; the order of factors and of questions does.
pub fn hash(protocol: &Protocol) -> String {
    sha256(content(protocol).to_string().as_bytes())
}

/// Returns the content of a definition in a fixed order, without the values that are equal to their defaults.
fn content(protocol: &Protocol) -> Value {
    let value = |definition: &Definition| serde_json::to_value(definition).unwrap_or_default();
    // A study's own pictures are part of what it says.
    let pictures = || Stimulus::Image(Gallery::default().into());
    let stimulus = Stimulus::default_of(protocol.stimulus.kind()).unwrap_or_else(pictures);
    let (mut content, mut default) = (value(protocol), value(&Definition::new(protocol.name.clone(), stimulus)));
    // Every definition says its name and its kind of stimulus.
    for (table, key) in [("", "name"), ("/stimulus", "kind")] {
        default.pointer_mut(table).and_then(Value::as_object_mut).and_then(|table| table.shift_remove(key));
    }
    remove_equal(&mut content, &default);
    content
}

/// Removes every key whose value is equal to that in `default`.
fn remove_equal(value: &mut Value, default: &Value) {
    let (Value::Object(keys), Value::Object(default)) = (value, default) else { return };
    keys.retain(|key, value| default.get(key) != Some(value));
    for (key, value) in keys {
        if let Some(default) = default.get(key) {
            remove_equal(value, default);
        }
    }
}

/// The tables that [`Definition`] reads itself. A list would be read as the values of such a table, in their order.
const OWN: [&str; 7] = ["design", "recovery", "presentation", "viewing", "instructions", "session", "plan"];
/// The tables that it does not read.
const TABLES: [&str; 6] = ["stimulus", "factors", "task", "adaptive", "response", "participant"];

#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct WrittenScale {
    question: Option<String>,
    labels: Option<Vec<String>>,
    keys: Option<Vec<char>>,
}

/// Returns the definition with this content of its file. `place` is where its pictures are; without it, they are only
/// described.
///
/// # Errors
/// Returns every error.
fn protocol(mut written: Map<String, Value>, place: Option<Place<'_>>) -> Result<Protocol, Vec<DefinitionError>> {
    let (mut errors, is_recorded) = (DefinitionErrors::default(), place.is_none());
    let has_name = written.contains_key("name");
    let [stimulus_table, factors_table, task_table, adaptive_table, response, participant] =
        TABLES.map(|key| match written.shift_remove(key)? {
            Value::Object(table) => Some(table),
            other => {
                add_unexpected(&mut errors, key, key, &other, "a table");
                None
            }
        });
    written.retain(|key, value| {
        let is_table = !(value.is_array() && OWN.contains(&key.as_str()));
        if !is_table {
            add_unexpected(&mut errors, key, key, value, "a table");
        }
        is_table
    });
    let all = TableReader { path: "", table: written, taken: TABLES.to_vec(), errors: &mut errors }.read();
    let mut definition = Definition { schema: 1, ..all };
    if !has_name {
        errors.add("name", "name is missing; expected name = …");
        "unnamed".clone_into(&mut definition.name);
    }
    if definition.title.is_empty() {
        definition.title.clone_from(&definition.name);
    }
    let is_picture = |table: &Map<String, Value>| table.get("kind").is_some_and(|kind| kind == Picture::KIND);
    (definition.stimulus, definition.factors) = match stimulus_table {
        Some(table) if is_picture(&table) => {
            let level = definition.recovery.level;
            let picture = pictures(table, place, [&factors_table, &task_table], level, &mut errors);
            let factors = picture.factors().into_iter().map(|(name, levels)| Factor { name, levels }).collect();
            (picture.into(), factors)
        }
        table => {
            let stimulus = stimulus(table.as_ref(), &mut errors);
            let factors = factors(factors_table.unwrap_or_default(), &stimulus, &mut errors);
            (stimulus, factors)
        }
    };
    let task = task_table.map(|table| task(table, &mut errors)).unwrap_or_default();
    definition.adaptive = adaptive_table.map(|table| adaptive(table, &mut errors));
    definition.response = scale(response.unwrap_or_default(), &task, &mut errors);
    let of_pictures = matches!(definition.stimulus, Stimulus::Image(_));
    task.instruct(&mut definition.instructions, &definition.response, of_pictures);
    definition.task = task;
    definition.participant =
        participant.into_iter().flatten().filter_map(|field| question(field, &mut errors)).collect();
    let protocol = Protocol::new(definition);
    let protocol = if is_recorded { protocol } else { protocol.and_then(Protocol::with_effect) };
    if errors.0.is_empty() {
        return protocol;
    }
    // A value that could not be read would only cause follow-up errors, as would the options of an unknown kind.
    let (mut unread, mut unknown) = (HashSet::new(), Vec::new());
    for DefinitionError { path, .. } in &errors.0 {
        unread.insert(path.clone());
        // A list or a table without one of its items is not read, either.
        unread.extend(path.match_indices('.').skip(1).map(|(end, _)| path[..end].to_owned()));
        match path.as_str() {
            "task" | "task.kind" => unknown.extend(["task", "adaptive", "response"]),
            "adaptive" | "adaptive.method" => unknown.push("adaptive"),
            // Pictures bring their factors.
            "stimulus" | "stimulus.files" => {
                unknown.push("factors");
                unread.extend(["design.order", "task.along"].map(str::to_owned));
            }
            _ => {}
        }
    }
    let follows = |DefinitionError { path, .. }: &DefinitionError| {
        unread.contains(path) || unknown.contains(&path.split('.').next().unwrap_or(path))
    };
    errors.0.extend(protocol.err().unwrap_or_default().into_iter().filter(|error| !follows(error)));
    Err(errors.0)
}

/// Returns the study's own pictures. `factors` and `task` are these tables of the definition.
fn pictures(
    mut table: Map<String, Value>,
    place: Option<Place<'_>>,
    [factors, task]: [&Option<Map<String, Value>>; 2],
    background: f64,
    errors: &mut DefinitionErrors,
) -> Picture {
    table.shift_remove("kind");
    let Some(place) = place else {
        return TableReader { path: "stimulus", table, taken: Vec::new(), errors }.read::<Gallery>().into();
    };
    for key in factors.iter().flat_map(Map::keys) {
        errors.add(format!("factors.{key}"), "pictures have their factors in pictures.csv; expected no [factors]");
    }
    let written = ["kind", "files", "show", "size"];
    for key in table.keys().filter(|key| !written.contains(&key.as_str())) {
        errors.add(format!("stimulus.{key}"), unknown_key("stimulus", key, &written));
    }
    table.retain(|key, _| written.contains(&key.as_str()));
    let reference = task.as_ref().and_then(|task| task.get("reference")?.get(Picture::PICTURE)?.as_str());
    pictures::gallery(table, place, reference, background, errors).into()
}

/// Returns a question about the participant.
fn question((name, spec): (String, Value), errors: &mut DefinitionErrors) -> Option<ParticipantField> {
    let path = format!("participant.{name}");
    let Value::Object(table) = spec else {
        add_unexpected(errors, &path, &path, &spec, "a table");
        return None;
    };
    let read = TableReader { path: &path, table, taken: Vec::new(), errors }.read();
    Some(ParticipantField { name, ..read })
}

fn add_unexpected(errors: &mut DefinitionErrors, path: &str, name: &str, value: &Value, expected: &str) {
    let found = match value {
        Value::Array(_) => "a list".to_owned(),
        Value::Object(_) => "a table".to_owned(),
        other => other.to_string(),
    };
    errors.add(path, format!("{name} is {found}; expected {expected}"));
}

fn stimulus(given: Option<&Map<String, Value>>, errors: &mut DefinitionErrors) -> Stimulus {
    let kind = given.and_then(|given| given.get("kind")).map(|kind| (kind, kind.as_str().unwrap_or_default()));
    let Some(mut stimulus) = kind.and_then(|(_, name)| Stimulus::default_of(name)) else {
        let message = match kind {
            Some((kind, name)) => format!("kind {kind} is not known; {}", expected_one_of(name, KINDS)),
            // That it is no table was already said.
            None if errors.0.iter().any(|error| error.path == "stimulus") => return Stimulus::default(),
            None => "stimulus.kind is missing; expected kind = …".to_owned(),
        };
        errors.add("stimulus.kind", message);
        return Stimulus::default();
    };
    for (name, value) in given.into_iter().flatten().filter(|(name, _)| *name != "kind") {
        let path = format!("stimulus.{name}");
        match parameter(value) {
            _ if !is_known(&stimulus, "stimulus", name, errors) => {}
            Some(value) => {
                if let Err(error) = stimulus.set(name, &value) {
                    errors.add(path, error.to_string());
                }
            }
            None => add_unexpected(errors, &path, &path, value, "a number or text"),
        }
    }
    stimulus
}

fn factors(given: Map<String, Value>, stimulus: &Stimulus, errors: &mut DefinitionErrors) -> Vec<Factor> {
    let mut factors = Vec::new();
    for (name, levels) in given {
        let path = format!("factors.{name}");
        match levels {
            _ if !is_known(stimulus, "factors", &name, errors) => {}
            Value::Array(levels) => {
                let level = |(i, level)| {
                    // The stimulus normalizes values, so that `1` and `1.0`, or `white` and `gray`, are the same level.
                    let written = |level: ParameterValue| {
                        let mut probe = stimulus.clone();
                        probe.set(&name, &level).ok().and_then(|()| probe.get(&name)).unwrap_or(level)
                    };
                    parameter(level).map(written).unwrap_or_else(|| {
                        add_unexpected(errors, &format!("{path}.{i}"), &path, level, "a number or text");
                        "".into()
                    })
                };
                let levels = levels.iter().enumerate().map(level).collect();
                factors.push(Factor { name, levels });
            }
            other => add_unexpected(errors, &path, &path, &other, "a list of numbers or text in brackets"),
        }
    }
    factors
}

fn is_known(stimulus: &Stimulus, table: &str, name: &str, errors: &mut DefinitionErrors) -> bool {
    let mut known: Vec<&str> = stimulus.parameters().iter().map(|parameter| parameter.name).collect();
    let is_known = known.contains(&name);
    if !is_known {
        if table == "stimulus" {
            known.insert(0, "kind");
        }
        errors.add(format!("{table}.{name}"), unknown_key(table, name, &known));
    }
    is_known
}

fn parameter(value: &Value) -> Option<ParameterValue> {
    match value {
        Value::Number(number) => number.as_f64().map(ParameterValue::Number),
        Value::String(text) => Some(ParameterValue::Text(text.clone())),
        _ => None,
    }
}

/// Reads the kind that a table names with `tag`.
fn tagged<T: Default>(
    mut reader: TableReader<'_>,
    (tag, names): (&str, &[&str]),
    read: impl FnOnce(&str, &mut TableReader<'_>) -> Option<T>,
) -> T {
    let path = format!("{}.{tag}", reader.path);
    let Some(name) = reader.table.shift_remove(tag) else {
        reader.errors.add(reader.path, format!("{path} is missing; expected {tag} = …"));
        return T::default();
    };
    read(name.as_str().unwrap_or_default(), &mut reader).unwrap_or_else(|| {
        let expected = expected_one_of(name.as_str().unwrap_or_default(), names);
        reader.errors.add(path, format!("{tag} {name} is not known; {expected}"));
        T::default()
    })
}

fn task(table: Map<String, Value>, errors: &mut DefinitionErrors) -> Task {
    let reader = TableReader { path: "task", table, taken: vec!["kind"], errors };
    tagged(reader, ("kind", Task::NAMES), |name, reader| Task::read(name, reader))
}

fn adaptive(mut table: Map<String, Value>, errors: &mut DefinitionErrors) -> Adaptive {
    let mut taken: Vec<&str> = Common::OPTIONS.iter().map(|option| option.key).collect();
    let common = taken.iter().filter_map(|key| Some(((*key).to_owned(), table.shift_remove(*key)?))).collect();
    let common = TableReader { path: "adaptive", table: common, taken: Vec::new(), errors }.read();
    taken.insert(0, "method");
    let reader = TableReader { path: "adaptive", table, taken, errors };
    let method = tagged(reader, ("method", Method::NAMES), |name, reader| Method::read(name, reader));
    Adaptive { common, method }
}

fn scale(table: Map<String, Value>, task: &Task, errors: &mut DefinitionErrors) -> ResponseScale {
    let WrittenScale { question, labels, keys } =
        TableReader { path: "response", table, taken: Vec::new(), errors }.read();
    let default_scale = task.scale();
    let labels =
        labels.unwrap_or_else(|| default_scale.categories.iter().map(|category| category.label.clone()).collect());
    let count = labels.len();
    let default = |answer| default_scale.default_key(answer, count).unwrap_or(' ');
    let usual = || (0..count).map(default).collect();
    let keys: Vec<char> = keys.unwrap_or_else(usual);
    // A definition that was written with all its keys has those that its labels would have.
    if task.dial().is_some() && keys != usual() {
        errors.add("response.keys", "participants set a value; expected no keys");
    } else if keys.len() != count {
        let message = format!("response.keys has length {}; expected {count}, one for each label", keys.len());
        errors.add("response.keys", message);
    }
    // A missing key has already been reported; its digit stands in for it.
    let keys = (0..count).map(|rating| keys.get(rating).copied().unwrap_or_else(|| default(rating)));
    let categories = labels.into_iter().zip(keys).map(|(label, key)| Category { label, key }).collect();
    ResponseScale { question: question.unwrap_or(default_scale.question), categories }
}
