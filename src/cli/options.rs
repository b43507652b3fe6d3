//! Options that several commands share: the stimulus, and how its light is converted to codes.

use std::{path::PathBuf, str::FromStr};

use clap::{
    Arg, ArgMatches, Args, Command, FromArgMatches,
    builder::{PossibleValuesParser, TypedValueParser},
};

use super::UsageError;
use crate::{
    analysis::{Link, MAX_COEFFICIENTS, Slopes, terms::Terms},
    light::{Bits, Dither, Transfer, Transfers},
    stimulus::{KINDS, Parameter, Stimulus, catalog, recipe::Recipe},
    store,
};

/// Returns a parser that accepts only one of `names`.
pub(super) fn named<T>(names: &'static [&'static str]) -> impl TypedValueParser<Value = T>
where
    T: FromStr<Err: std::error::Error + Send + Sync + 'static> + Clone + Send + Sync + 'static,
{
    PossibleValuesParser::new(names).try_map(|name| name.parse())
}

/// The ordinal model that `analyze` fits and `plan` simulates.
#[derive(clap::Args)]
pub(super) struct ModelOptions {
    /// Terms of the model: names of factors. Prefix a numeric term with num:, and join the factors of an interaction
    /// with : or * [default: every factor that varies].
    #[arg(long, value_name = "T,…")]
    terms: Option<String>,
    /// Link function of the cumulative model.
    #[arg(long, default_value_t, value_parser = named::<Link>(Link::NAMES))]
    pub(super) link: Link,
    /// Random slopes: for each term that varies within participants, as far as the design supports it (independent), or
    /// with all their correlations (correlated).
    #[arg(long, default_value_t, value_parser = named::<Slopes>(Slopes::NAMES))]
    pub(super) slopes: Slopes,
    /// Also analyze a study that is larger than usual: more than 10 factors, 120 levels of a factor, 5,000 conditions,
    /// 20,000 participants or 120 coefficients, or names of more than 200 bytes. The time grows with their square or
    /// cube.
    #[arg(long)]
    pub(super) large: bool,
}

impl ModelOptions {
    /// Returns the maximum number of coefficients.
    pub(super) fn max_coefficients(&self) -> usize {
        if self.large { usize::MAX } else { MAX_COEFFICIENTS }
    }

    /// Parses the terms, if any were given.
    pub(super) fn terms(&self) -> Result<Option<Terms>, UsageError> {
        let terms = self.terms.as_deref().map(Terms::parse).transpose();
        terms.map_err(|error| UsageError(error.to_string()))
    }
}

/// How the display converts codes to light.
#[derive(clap::Args)]
pub(super) struct TransferOptions {
    /// Transfer function of the display: srgb, linear, gamma:G or gog:GAMMA,GAIN,OFFSET; for separate
    /// functions for red, green and blue, join three with /.
    #[arg(long, conflicts_with = "display")]
    transfer: Option<Transfers>,
    /// Display profile written by `machband calibrate`.
    #[arg(long, value_name = "FILE")]
    display: Option<PathBuf>,
}

impl TransferOptions {
    /// Returns the transfer functions (sRGB by default) and the hash of their profile.
    pub(super) fn transfers(&self) -> anyhow::Result<(Transfers, Option<String>)> {
        Ok(match (&self.display, &self.transfer) {
            (Some(path), _) => {
                let profile = store::profile::open(path)?;
                super::warn(path, &profile);
                let hash = store::profile::hash(&profile);
                (profile.transfers, Some(hash))
            }
            (None, Some(transfers)) => (transfers.clone(), None),
            (None, None) => (Transfer::Srgb.into(), None),
        })
    }

    /// Returns the transfer functions that were asked for; `None` if neither option was given.
    pub(super) fn given(&self) -> anyhow::Result<Option<Transfers>> {
        let given = self.display.is_some() || self.transfer.is_some();
        given.then(|| self.transfers().map(|(transfers, _)| transfers)).transpose()
    }

    /// Returns the luminance of white in cd/m², if the profile contains it.
    pub(super) fn white(&self) -> anyhow::Result<Option<f64>> {
        let profile = self.display.as_deref().map(store::profile::open).transpose()?;
        Ok(profile.and_then(|profile| profile.luminance).map(|range| range.white_cd_m2))
    }
}

/// How an image converts light to codes.
#[derive(clap::Args)]
pub(super) struct ImageOptions {
    /// Side of the image in pixels.
    #[arg(long, value_name = "PX", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(1..=16384))]
    pub(super) size: u32,
    #[command(flatten)]
    transfer: TransferOptions,
    /// Bits per channel.
    #[arg(long, default_value = "8", value_parser = named::<Bits>(&["8", "16"]))]
    bits: Bits,
    /// Dither: none, ordered, blue-noise or random; for a specific matrix, ordered:bayer2, 4, 8 or 16, or
    /// ordered:clustered2 or 3.
    #[arg(long, default_value = "none")]
    dither: Dither,
    /// Seed of the random dither.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
}

impl ImageOptions {
    /// Returns the complete description of an image of this stimulus. Call it only once, because it reads the display
    /// profile and prints its warning.
    pub(super) fn recipe(&self, stimulus: Stimulus) -> anyhow::Result<Recipe> {
        let (transfers, display_sha256) = self.transfer.transfers()?;
        Ok(Recipe {
            stimulus,
            size: self.size,
            transfers,
            bits: self.bits,
            dither: self.dither,
            seed: self.seed,
            display_sha256,
        })
    }
}

/// The stimulus options: `--kind`, and one option for each parameter that any kind in the catalog has.
pub(super) struct StimulusOptions {
    kind: String,
    given: Vec<(&'static str, String)>,
}

impl StimulusOptions {
    /// Builds the stimulus.
    ///
    /// # Errors
    /// Reports every parameter that the kind does not have, and every invalid value.
    pub(super) fn stimulus(&self) -> anyhow::Result<Stimulus> {
        let given = self.given.iter().map(|(name, text)| (*name, text.parse().unwrap_or_else(|never| match never {})));
        Stimulus::with_parameters(&self.kind, given).map_err(|errors| UsageError(errors.join("\n")).into())
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

impl Args for StimulusOptions {
    fn augment_args(command: Command) -> Command {
        let kind = Arg::new("kind")
            .long("kind")
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
            command.arg(
                Arg::new(parameter.name)
                    .long(parameter.option())
                    .value_name("VALUE")
                    .allow_hyphen_values(true)
                    .help(format!("{}{default}{of}", parameter.description)),
            )
        })
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for StimulusOptions {
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
