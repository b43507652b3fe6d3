//! Options that several requests share: a stimulus, and how its light becomes codes on a display.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use clap::{Arg, ArgMatches, Args, Command, FromArgMatches, builder::PossibleValuesParser};
use serde::{Serialize, Serializer};

use super::{RequestError, Watcher, today};
use crate::{
    display::DisplayProfile,
    light::{Bits, CodeImage, Dither, Transfer, Transfers},
    stimulus::{
        KINDS, Parameter, Stimulus, ViewingConditions, catalog,
        recipe::{MAX_SIZE, Recipe},
    },
    store::{
        self,
        image::{ASSUMED, Picture},
    },
    text::{
        names::one_of,
        number::{whole, within},
    },
};

/// How the display converts codes to light.
#[derive(Clone, Debug, Default, PartialEq, clap::Args, Serialize)]
pub struct Encoding {
    /// Transfer function of the display: srgb, linear, gamma:G or gog:GAMMA,GAIN,OFFSET; for separate
    /// functions for red, green and blue, join three with /.
    #[arg(long)]
    #[serde(serialize_with = "as_text")]
    pub transfer: Option<Transfers>,
    /// Display profile written by `machband calibrate`.
    #[arg(long, value_name = "FILE")]
    pub display: Option<PathBuf>,
}

/// How bright the display is.
#[derive(Clone, Debug, Default, PartialEq, clap::Args, Serialize)]
pub struct Luminances {
    /// Luminance of white in cd/m², without that of black [default: the display profile's, or 100].
    #[arg(long, value_name = "CD_M2", value_parser = within(1e-3, 1e6))]
    pub white: Option<f64>,
    /// Luminance of black in cd/m², with what the screen reflects [default: the display profile's, or 0.2].
    #[arg(long, value_name = "CD_M2", value_parser = within(0.0, 1e6))]
    pub black: Option<f64>,
}

/// Writes a value as its text.
fn as_text<T: ToString, S: Serializer>(value: &Option<T>, serializer: S) -> Result<S::Ok, S::Error> {
    value.as_ref().map(ToString::to_string).serialize(serializer)
}

/// An [`Encoding`] whose display profile, if it names one, has been read.
#[derive(Clone, Debug, PartialEq)]
pub struct Encoded {
    /// The transfer functions, by default sRGB.
    pub transfers: Transfers,
    /// True if they were asked for.
    pub is_given: bool,
    /// The display profile and its hash.
    profile: Option<(DisplayProfile, String)>,
}

impl Encoded {
    /// Returns codes in memory as a picture.
    pub fn given(&self, codes: CodeImage) -> Picture {
        let picture = Picture::given(codes, self.transfers.clone());
        self.shows(if self.is_given { picture } else { Picture { origin: ASSUMED, ..picture } })
    }

    /// Returns a picture with the primaries of the display profile, if it has any.
    pub fn shows(&self, picture: Picture) -> Picture {
        let primaries = self.profile.as_ref().and_then(|(profile, _)| profile.primaries);
        let weights = primaries.and_then(|own| own.weights()).unwrap_or(picture.weights);
        Picture { weights, ..picture }
    }

    /// Returns how a window of this width looks: on a screen of the luminances that were asked for, otherwise of the
    /// profile's, otherwise of a typical one.
    pub fn viewing(&self, window_deg: f64, asked: &Luminances) -> ViewingConditions {
        let seen = ViewingConditions::on(self.profile.as_ref().and_then(|(own, _)| own.luminance), window_deg);
        ViewingConditions {
            white_cd_m2: asked.white.unwrap_or(seen.white_cd_m2),
            black_cd_m2: asked.black.unwrap_or(seen.black_cd_m2),
            window_deg,
        }
    }
}

impl Encoding {
    /// Reads the display profile. The watcher is warned if it should be measured again.
    ///
    /// # Errors
    /// The profile cannot be read, or there are transfer functions besides it.
    pub fn read(&self, watcher: &dyn Watcher) -> anyhow::Result<Encoded> {
        let Some(path) = &self.display else {
            let transfers = self.transfer.clone().unwrap_or_else(|| Transfer::Srgb.into());
            return Ok(Encoded { transfers, is_given: self.transfer.is_some(), profile: None });
        };
        if self.transfer.is_some() {
            let message = "excludes a display profile, which has its own; expected one of them";
            return Err(RequestError::value("transfer", message).into());
        }
        let profile = store::profile::open(path)?;
        outdated(path, &profile).iter().for_each(|warning| watcher.warn(warning));
        let hash = store::profile::hash(&profile);
        Ok(Encoded { transfers: profile.transfers.clone(), is_given: true, profile: Some((profile, hash)) })
    }
}

/// Returns a warning if a measured profile should be measured again. `place` says where the profile comes from.
pub fn outdated(place: &Path, profile: &DisplayProfile) -> Option<String> {
    profile.warning(today()).map(|warning| format!("{}: {warning}", place.display()))
}

/// How many pixels an image has, and how it converts light to codes.
#[derive(Clone, Debug, PartialEq, clap::Args, Serialize)]
pub struct Image {
    /// Side of the image in pixels.
    #[arg(long, value_name = "PX", default_value_t = 1024, value_parser = whole(1..=MAX_SIZE))]
    pub size: u32,
    #[command(flatten)]
    #[serde(flatten)]
    pub encoding: Encoding,
    /// Bits per channel.
    #[arg(long, default_value = "8", value_parser = one_of::<Bits>(Bits::NAMES))]
    pub bits: Bits,
    /// Dither: none, ordered, blue-noise or random; for a specific matrix, ordered:bayer2, 4, 8 or 16, or
    /// ordered:clustered2 or 3.
    #[arg(long, default_value = "none")]
    pub dither: Dither,
    /// Seed of the random dither.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole(0..=u64::MAX))]
    pub seed: u64,
}

impl Image {
    /// Returns the complete description of an image of this stimulus.
    ///
    /// # Errors
    /// The display profile cannot be read.
    pub fn recipe(&self, stimulus: Stimulus, watcher: &dyn Watcher) -> anyhow::Result<Recipe> {
        let Encoded { transfers, profile, .. } = self.encoding.read(watcher)?;
        Ok(Recipe {
            stimulus,
            size: self.size,
            transfers,
            bits: self.bits,
            dither: self.dither,
            seed: self.seed,
            display_sha256: profile.map(|(_, hash)| hash),
            finish: None,
        })
    }
}

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
        let given = self.given.iter().map(|(name, text)| (*name, text.as_str()));
        Stimulus::with_parameters(&self.kind, given).map_err(|errors| {
            let errors: Vec<String> = errors.iter().map(ToString::to_string).collect();
            RequestError::whole(errors.join("\n"))
        })
    }
}

/// Lists every parameter in the catalog once, with the kinds that have it.
fn parameters() -> Vec<(&'static Parameter, Vec<&'static str>)> {
    let mut found: Vec<(&Parameter, Vec<&str>)> = Vec::new();
    for entry in catalog::all() {
        for parameter in entry.parameters {
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
