//! Experiment definitions: TOML files, and those built into the program.

use std::path::Path;

use super::toml_reader::{Reader, Section, locate, nearest};
use super::{FileFaults, hash::sha256, text, toml_reader};
use crate::{
    experiment::{
        Category, Design, Factor, Order, Presentation, Protocol, Recovery, ResponseScale, Texts, ViewingPlan,
    },
    stimulus::{KINDS, MachBand, Stimulus},
};

/// A definition that comes with the program: name and TOML text.
pub struct BuiltIn {
    /// What `machband run NAME` takes.
    pub name: &'static str,
    /// The file in `experiments/`.
    pub text: &'static str,
}

macro_rules! built_in {
    ($($name:literal),*) => {
        /// The definitions that come with the program; the first is the default.
        pub const BUILT_IN: &[BuiltIn] = &[$(BuiltIn {
            name: $name,
            text: include_str!(concat!("../../experiments/", $name, ".toml")),
        }),*];
    };
}
built_in!("quick", "bangay2003", "orientation", "shaders");

/// A definition by the name of a built-in one, or by the path of a file.
///
/// # Errors
/// Every fault of the file, or that there is neither such a name nor such a file.
pub fn open(name_or_path: &str) -> Result<Protocol, FileFaults> {
    if let Some(built_in) = BUILT_IN.iter().find(|built_in| built_in.name == name_or_path) {
        return parse(built_in.name, built_in.text);
    }
    let path = Path::new(name_or_path);
    let looks_like_a_name = path.extension().is_none() && path.components().count() == 1;
    if looks_like_a_name && !path.exists() {
        let names: Vec<_> = BUILT_IN.iter().map(|built_in| built_in.name).collect();
        return Err(FileFaults::whole(
            name_or_path,
            format!(
                "is neither a built-in definition nor a file; {}, or the path of a .toml file",
                nearest(name_or_path, &names)
            ),
        ));
    }
    parse(name_or_path, &text::read(path)?)
}

/// Reads a definition; `file` names it in messages.
///
/// # Errors
/// Every fault with its line and column.
pub fn parse(file: &str, text: &str) -> Result<Protocol, FileFaults> {
    let table = toml_reader::parse(file, text)?;
    let reader = Reader::new(file, text);
    let root = reader.root(&table);
    root.schema();
    let name = root.required_text("name");
    let title = root.text("title");
    let stimulus = stimulus(&root);
    let protocol = Protocol {
        schema: 1,
        title: title.or_else(|| name.clone()).unwrap_or_default(),
        // A missing or ill-typed name is a fault already; this keeps a second one from being made of it.
        name: name.unwrap_or_else(|| "unnamed".to_owned()),
        factors: factors(&root, &stimulus),
        stimulus,
        design: design(&root),
        recovery: recovery(&root),
        presentation: presentation(&root),
        response: response(&root),
        viewing: viewing(&root),
        instructions: instructions(&root),
    };
    root.finish();
    // A value that could not be read is a fault already; what follows from it is none of its own.
    let unread = reader.places();
    for fault in protocol.faults() {
        let at = locate(&table, &fault.path);
        if !unread.contains(&at) {
            reader.fault(at, fault.message);
        }
    }
    reader.finish()?;
    Ok(protocol)
}

/// Reads back the definition that a sidecar keeps.
///
/// # Errors
/// Every fault; positions are those of the definition written out as TOML.
pub fn from_json(file: &str, definition: &serde_json::Value) -> Result<Protocol, FileFaults> {
    let text = toml::to_string(definition).map_err(|error| {
        FileFaults::whole(file, format!("the definition cannot be read: {error}; expected a table"))
    })?;
    parse(file, &text)
}

/// SHA-256 of what a definition means, in lower-case hexadecimal: comments and layout do not change it.
pub fn hash(protocol: &Protocol) -> String {
    let canonical = serde_json::to_vec(protocol).unwrap_or_default();
    sha256(&canonical)
}

fn stimulus(root: &Section<'_, '_>) -> Stimulus {
    let section = root.section("stimulus");
    let fallback = || Stimulus::MachBand(MachBand::default());
    let mut stimulus = match section.required_text("kind") {
        None => fallback(),
        Some(kind) => Stimulus::default_of(&kind).unwrap_or_else(|| {
            section.fault_at("kind", format!("kind {kind:?} is not known; {}", nearest(&kind, KINDS)));
            fallback()
        }),
    };
    for parameter in stimulus.parameters() {
        if let Some((value, _)) = section.parameter(parameter.name)
            && let Err(error) = stimulus.set(parameter.name, &value)
        {
            section.fault_at(parameter.name, error.to_string());
        }
    }
    section.finish();
    stimulus
}

fn factors(root: &Section<'_, '_>, stimulus: &Stimulus) -> Vec<Factor> {
    let section = root.section("factors");
    let mut factors = Vec::new();
    // In the order of the file: it is the order in which factors cross and columns stand.
    for key in section.keys() {
        let Some(parameter) = stimulus.parameters().iter().find(|p| p.name == key) else { continue };
        if let Some(mut levels) = section.parameters(parameter.name) {
            // As the stimulus writes them, so that `1` and `1.0`, or `grey` and `gray`, are one level.
            for level in &mut levels {
                let mut probe = stimulus.clone();
                if probe.set(&key, level).is_ok() {
                    *level = probe.get(&key).unwrap_or_else(|| level.clone());
                }
            }
            factors.push(Factor { name: key, levels });
        }
    }
    for parameter in stimulus.parameters() {
        // Asked for again only to be known when the rest is called unknown.
        section.knows(parameter.name);
    }
    section.finish();
    factors
}

fn design(root: &Section<'_, '_>) -> Design {
    let section = root.section("design");
    let default = Design::default();
    let order = section.text("order").map_or(Ok(default.order), |text| text.parse::<Order>());
    let design = Design {
        repetitions: section.whole("repetitions").unwrap_or(default.repetitions),
        practice: section.whole("practice").unwrap_or(default.practice),
        break_every: section.whole("break_every").unwrap_or(default.break_every),
        order: order.unwrap_or_else(|message| {
            section.fault_at("order", message);
            Order::Random
        }),
        max_run: section.whole("max_run"),
    };
    section.finish();
    design
}

fn recovery(root: &Section<'_, '_>) -> Recovery {
    let section = root.section("recovery");
    let default = Recovery::default();
    let recovery = Recovery {
        duration_s: section.number("duration_s", default.duration_s),
        level: section.number("level", default.level),
    };
    section.finish();
    recovery
}

/// `None` where the definition has no such table; a table without its key is a fault, since it would mean nothing.
fn presentation(root: &Section<'_, '_>) -> Option<Presentation> {
    let given = root.has("presentation");
    let section = root.section("presentation");
    if given && !section.has("duration_s") {
        section.missing("duration_s");
    }
    let presentation = Presentation { duration_s: section.number("duration_s", 1.0) };
    section.finish();
    given.then_some(presentation)
}

fn viewing(root: &Section<'_, '_>) -> ViewingPlan {
    let section = root.section("viewing");
    let default = ViewingPlan::default();
    let viewing = ViewingPlan {
        distance_cm: section.number("distance_cm", default.distance_cm),
        window_deg: section.number("window_deg", default.window_deg),
    };
    section.finish();
    viewing
}

fn response(root: &Section<'_, '_>) -> ResponseScale {
    let section = root.section("response");
    let default = ResponseScale::default();
    let question = section.text("question").unwrap_or(default.question);
    let labels = section.texts("labels");
    let keys = section.texts("keys");
    let count = labels.as_ref().map_or(default.categories.len(), Vec::len);
    let labels = labels.unwrap_or_else(|| default.categories.iter().map(|c| c.label.clone()).collect());
    let keys = keys.unwrap_or_else(|| (0..count).map(|i| i.to_string()).collect());
    if keys.len() != count {
        section
            .fault_at("keys", format!("response.keys has {} keys; expected {count}, one for each label", keys.len()));
    }
    let mut categories = Vec::with_capacity(count);
    for (i, label) in labels.into_iter().enumerate() {
        let key = keys.get(i).map_or("", String::as_str);
        let mut characters = key.chars();
        let (first, rest) = (characters.next(), characters.next());
        if i < keys.len() && (first.is_none() || rest.is_some()) {
            section
                .fault_at("keys", format!("response key {key:?} is not one character; expected a digit or a letter"));
        }
        categories.push(Category { label, key: first.unwrap_or(char::from_digit(i as u32 % 10, 10).unwrap_or('0')) });
    }
    section.finish();
    ResponseScale { question, categories }
}

fn instructions(root: &Section<'_, '_>) -> Texts {
    let section = root.section("instructions");
    let mut texts = Texts::default();
    for (key, text) in texts.entries_mut() {
        if let Some(given) = section.text(key) {
            *text = given;
        }
    }
    section.finish();
    texts
}
