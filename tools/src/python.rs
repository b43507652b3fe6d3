//! The parameters of the Python functions, written from the requests of the operations: names, types, defaults and
//! descriptions stand at the fields of the requests.

use std::{any::TypeId, collections::BTreeMap, fmt::Write as _};

use clap::{Arg, ArgAction, Args, Command};
use machband::{
    light::{Dither, Transfers},
    stimulus::StimulusColor,
    work::{Analyze, Export, Image, compare::Compare, predict::Predict, shade::Shade, simulate::Simulate},
};

/// Number of characters in a line of Python.
const LINE: usize = 120;

/// A Python function that makes a request.
struct Function {
    file: &'static str,
    name: &'static str,
    /// The options of the request.
    options: Vec<Arg>,
}

/// Returns the functions. Options that Python names or defaults in its own way are left out.
fn functions() -> Vec<Function> {
    fn function<T: Args>(file: &'static str, name: &'static str, but: &[&str]) -> Function {
        let command = T::augment_args(Command::new(name));
        let is_option = |argument: &&Arg| argument.get_long().is_some() && !but.contains(&argument.get_id().as_str());
        Function { file, name, options: command.get_arguments().filter(is_option).cloned().collect() }
    }
    let parameters: Vec<String> = Predict::augment_args(Command::new("predict"))
        .get_arguments()
        .map(|argument| argument.get_id().to_string())
        .filter(|name| !["display", "size", "ppd", "white", "black"].contains(&name.as_str()))
        .collect();
    let parameters: Vec<&str> = parameters.iter().map(String::as_str).collect();
    vec![
        function::<Simulate>("_experiment.py", "simulate", &["results", "accept_changes"]),
        function::<Shade>("_shading.py", "shade", &["mesh", "vertices", "normals", "shader", "truth"]),
        function::<Image>("_stimulus.py", "stimulus", &[]),
        function::<Image>("_stimulus.py", "profile", &[]),
        function::<Analyze>("_study.py", "analyze", &["factors", "levels", "response", "missing", "level"]),
        function::<Export>("_study.py", "export", &["format", "out"]),
        function::<Predict>("_vision.py", "predict", &parameters),
        function::<Compare>("_vision.py", "compare", &["steps", "max"]),
        function::<Compare>("_vision.py", "steps", &["steps", "max", "mask"]),
    ]
}

/// Returns every file with the functions, given the text that it has now.
pub fn files(now: impl Fn(&str) -> String) -> BTreeMap<&'static str, String> {
    let mut files = BTreeMap::new();
    for Function { file, name, options } in functions() {
        let text = files.entry(file).or_insert_with(|| now(file));
        *text = updated(text, name, &options);
    }
    files
}

/// Returns the text of a file in which a function has these options.
fn updated(text: &str, function: &str, options: &[Arg]) -> String {
    let mut updated = String::new();
    let mut rest = text;
    let start = format!("\ndef {function}(\n");
    while let Some(at) = rest.find(&start) {
        let (before, from) = rest.split_at(at + start.len());
        let end = from.find("\n\n\n").unwrap_or(from.len());
        let (one, after) = from.split_at(end);
        updated += before;
        updated += &documented(&declared(one, options), options);
        rest = after;
    }
    updated + rest
}

/// Replaces the options among the keyword-only parameters. Others stay, after them.
fn declared(function: &str, options: &[Arg]) -> String {
    let Some((before, rest)) = function.split_once("    *,\n") else { return function.to_owned() };
    let Some((parameters, after)) = rest.split_once(") ->") else { return function.to_owned() };
    let own = parameters.lines().filter(|line| {
        let name = line.trim().split([':', '=']).next().unwrap_or_default();
        options.iter().all(|option| option.get_id() != name)
    });
    let declared =
        options.iter().map(|option| format!("    {}: {},", option.get_id(), Type::of(option).declared(option)));
    let lines: Vec<String> = declared.chain(own.map(str::to_owned)).collect();
    format!("{before}    *,\n{}\n) ->{after}", lines.join("\n"))
}

/// Replaces the descriptions of the options in the docstring. Those of parameters before them stay before them.
fn documented(function: &str, options: &[Arg]) -> String {
    const HEADING: &str = "    Parameters\n    ----------\n";
    let Some((before, rest)) = function.split_once(HEADING) else { return function.to_owned() };
    let Some((described, after)) = rest.split_once("\n\n") else { return function.to_owned() };
    let mut blocks: Vec<(String, String)> = Vec::new();
    for line in described.lines() {
        match (line.strip_prefix("        "), blocks.last_mut()) {
            (Some(_), Some((_, text))) => *text += &format!("{line}\n"),
            _ => blocks.push((line.trim().to_owned(), String::new())),
        }
    }
    let keywords = before.find("    *,\n").unwrap_or_default();
    let is_option = |name: &str| options.iter().any(|option| option.get_id() == name);
    let is_first =
        |name: &str| before[..keywords].contains(&format!("    {}:", name.split(", ").next().unwrap_or_default()));
    let block = |(name, text): &(String, String)| format!("    {name}\n{text}");
    let kept = |first: bool| {
        let kept = blocks.iter().filter(|(name, _)| !is_option(name) && is_first(name) == first);
        kept.map(block).collect::<String>()
    };
    // "size, bits" with a reference to another function describes these options.
    let listed: Vec<&str> =
        blocks.iter().filter(|(name, _)| name.contains(", ")).flat_map(|(name, _)| name.split(", ")).collect();
    let is_new = |option: &&Arg| !listed.contains(&option.get_id().as_str());
    let new: String = options.iter().filter(is_new).map(description).collect();
    let all = kept(true) + &new + &kept(false);
    format!("{before}{HEADING}{}\n\n{after}", all.trim_end())
}

/// Returns the description of an option.
fn description(option: &Arg) -> String {
    let help = option.get_long_help().or_else(|| option.get_help()).map(ToString::to_string).unwrap_or_default();
    let mut text = format!("    {}\n       ", option.get_id());
    let mut column = 7;
    for word in help.split_whitespace() {
        if column + 1 + word.chars().count() > LINE {
            text += "\n       ";
            column = 7;
        }
        write!(text, " {word}").unwrap_or_default();
        column += 1 + word.chars().count();
    }
    if !help.ends_with('.') { text + ".\n" } else { text + "\n" }
}

/// The type of an option in Python.
enum Type {
    Flag,
    Whole,
    Seed,
    /// One of these whole numbers.
    Sizes(Vec<String>),
    Number,
    /// A number or a word, such as a depth.
    Value,
    /// Three numbers.
    Triple,
    /// The name of a color, or its three weights.
    Color,
    Text,
    Transfer,
    Dither,
    /// One of these texts.
    Choice(Vec<String>),
    Path,
    /// A list of texts.
    Texts,
    /// Names with lists of texts.
    Levels,
}

impl Type {
    fn of(option: &Arg) -> Self {
        let names = option.get_value_names().unwrap_or_default();
        let name = names.first().map_or("", |name| name.as_str());
        let parser = option.get_value_parser().type_id();
        let is = |types: &[TypeId]| types.iter().any(|one| parser == *one);
        match option.get_action() {
            ArgAction::SetTrue => Self::Flag,
            ArgAction::Append if name.contains('=') => Self::Levels,
            _ if name.ends_with(",…") => Self::Texts,
            _ if name == "X,Y,Z" => Self::Triple,
            _ if is(&[TypeId::of::<StimulusColor>()]) => Self::Color,
            _ if name.starts_with("FILE") || name == "DIR" => Self::Path,
            _ if is(&[TypeId::of::<Transfers>()]) => Self::Transfer,
            _ if is(&[TypeId::of::<Dither>()]) => Self::Dither,
            // Other numbers have no need of 64 bits.
            _ if is(&[TypeId::of::<u64>()]) => Self::Seed,
            _ if is(&[TypeId::of::<u32>(), TypeId::of::<usize>()]) => Self::Whole,
            _ if is(&[TypeId::of::<f64>()]) => Self::Number,
            _ => {
                let choices = option.get_possible_values();
                let choices: Vec<String> = choices.iter().map(|choice| choice.get_name().to_owned()).collect();
                match choices.iter().all(|choice| choice.parse::<u32>().is_ok()) {
                    true if choices.is_empty() && (name == "N" || name.starts_with("N|")) => Self::Value,
                    true if choices.is_empty() => Self::Text,
                    true => Self::Sizes(choices),
                    false => Self::Choice(choices),
                }
            }
        }
    }

    /// Returns the type and the default of a parameter.
    fn declared(&self, option: &Arg) -> String {
        let kind = match self {
            Self::Flag => return "bool = False".to_owned(),
            Self::Whole => "int".to_owned(),
            Self::Seed => "Seed".to_owned(),
            Self::Sizes(numbers) => format!("Literal[{}]", numbers.join(", ")),
            Self::Transfer => "str | Transfer".to_owned(),
            Self::Dither => "Dither".to_owned(),
            Self::Number => "float".to_owned(),
            Self::Value => "float | str".to_owned(),
            Self::Triple => "Triple".to_owned(),
            Self::Color => "str | Triple".to_owned(),
            Self::Text => "str".to_owned(),
            Self::Choice(names) => format!("Literal[{}]", quoted(names)),
            Self::Path => "str | PathLike[str]".to_owned(),
            Self::Texts => "Texts".to_owned(),
            Self::Levels => "Mapping[str, Listed]".to_owned(),
        };
        let [default] = option.get_default_values() else { return format!("{kind} | None = None") };
        let default = default.to_string_lossy();
        let default = match self {
            Self::Triple => format!("({})", default.replace(',', ", ")),
            Self::Whole | Self::Seed | Self::Sizes(_) | Self::Number | Self::Value
                if default.parse::<f64>().is_ok_and(f64::is_finite) =>
            {
                default.into()
            }
            Self::Number => format!("float(\"{default}\")"),
            _ => format!("\"{default}\""),
        };
        format!("{kind} = {default}")
    }
}

fn quoted(names: &[String]) -> String {
    names.iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ")
}
