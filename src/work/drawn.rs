//! The options of a stimulus.

use std::collections::BTreeMap;

use clap::{Arg, ArgMatches, Args, Command, FromArgMatches, builder::PossibleValuesParser};
use serde::Serialize;

use super::RequestError;
use crate::stimulus::{KINDS, Parameter, Stimulus, catalog};

/// A stimulus: its kind, and one option for each parameter that any kind in the catalog has.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Drawn {
    kind: String,
    #[serde(flatten)]
    given: BTreeMap<&'static str, String>,
}

impl Drawn {
    /// Returns the options of a stimulus, without those that have the defaults of its kind.
    pub fn of(stimulus: &Stimulus) -> Self {
        let default = Stimulus::default_of(stimulus.kind());
        let value = |name: &'static str| {
            let value = stimulus.get(name)?;
            let is_default = default.as_ref().and_then(|default| default.get(name)).as_ref() == Some(&value);
            (!is_default).then(|| (name, value.to_string()))
        };
        let given = stimulus.parameters().iter().filter_map(|parameter| value(parameter.name)).collect();
        Self { kind: stimulus.kind().to_owned(), given }
    }

    /// True if nothing was asked for.
    pub(super) fn is_default(&self) -> bool {
        self.kind == KINDS[0] && self.given.is_empty()
    }

    /// Builds the stimulus.
    ///
    /// # Errors
    /// Reports every parameter that the kind does not have, and every invalid value.
    pub fn stimulus(&self) -> Result<Stimulus, RequestError> {
        let given = self.given.iter().map(|(name, text)| (*name, text.parse().unwrap_or_else(|never| match never {})));
        Stimulus::with_parameters(&self.kind, given).map_err(|errors| RequestError::whole(errors.join("\n")))
    }
}

/// Lists every parameter in the catalog once, with the kinds that have it.
fn parameters() -> Vec<(&'static Parameter, Vec<&'static str>)> {
    let mut found: Vec<(&Parameter, Vec<&str>)> = Vec::new();
    for entry in catalog::all() {
        for parameter in entry.default_stimulus().parameters() {
            match found.iter_mut().find(|(known, _)| known.name == parameter.name) {
                Some((_, kinds)) => kinds.push(entry.kind),
                None => found.push((parameter, vec![entry.kind])),
            }
        }
    }
    found
}

impl Args for Drawn {
    fn augment_args(command: Command) -> Command {
        let kind = Arg::new("kind")
            .long("kind")
            .value_name("KIND")
            .default_value(KINDS[0])
            .value_parser(PossibleValuesParser::new(KINDS))
            .help("Kind of stimulus");
        parameters().into_iter().fold(command.arg(kind), |command, (parameter, kinds)| {
            let of = if kinds.len() == KINDS.len() { String::new() } else { format!(" [{}]", kinds.join(", ")) };
            let mut defaults: Vec<String> = kinds
                .iter()
                .filter_map(|kind| Some(Stimulus::default_of(kind)?.get(parameter.name)?.to_string()))
                .collect();
            defaults.dedup();
            let default = match defaults.as_slice() {
                [one] => format!(" [default: {one}]"),
                [first, ..] => format!(" [default: {first} for {}; other kinds have their own]", kinds[0]),
                [] => String::new(),
            };
            let expected = parameter.expected.trim_start_matches("one of ");
            let is_told = !parameter.unit.is_empty() || parameter.description.contains(expected);
            let expected = if is_told { String::new() } else { format!(" ({expected})") };
            command.arg(
                Arg::new(parameter.name)
                    .long(parameter.option())
                    .value_name("VALUE")
                    .allow_hyphen_values(true)
                    .help(format!("{}{expected}{default}{of}", parameter.description)),
            )
        })
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for Drawn {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let text = |name: &str| matches.get_one::<String>(name).cloned();
        Ok(Self {
            kind: text("kind").unwrap_or_else(|| KINDS[0].to_owned()),
            given: parameters()
                .into_iter()
                .filter_map(|(parameter, _)| Some((parameter.name, text(parameter.name)?)))
                .collect(),
        })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}
