//! A display profile from photometer readings.

use std::path::PathBuf;

use jiff::civil::Date;
use serde::Serialize;

use super::today;
use crate::{
    display::{
        DisplayProfile, LuminanceRange, Measurement,
        photometer::{Calibration, Family, largest_percent},
    },
    store::{FileErrors, readings},
    text::names::one_of,
};

/// The instrument, unless it is named.
const WITH: &str = "photometer";

/// The readings, and what else the profile says.
#[derive(Clone, Debug, PartialEq, Eq, clap::Args, Serialize)]
pub struct Calibrate {
    /// Photometer readings.
    #[arg(value_name = "READINGS.csv")]
    pub readings: PathBuf,
    /// Name of the display [default: the profile's file name].
    #[arg(long, value_parser = filled)]
    pub name: Option<String>,
    /// Name of the person who took the readings.
    #[arg(long, value_name = "WHO")]
    pub by: Option<String>,
    /// Name of the photometer.
    #[arg(long, value_name = "PHOTOMETER", default_value = WITH)]
    pub with: String,
    /// Date of the measurement, such as 2026-01-31 [default: today].
    #[arg(long, value_name = "DATE", value_parser = date)]
    pub on: Option<Date>,
    /// Model of the profile [default: the simplest of those that predict left-out levels best].
    #[arg(long, value_parser = one_of::<Family>(Family::NAMES))]
    pub model: Option<Family>,
}

fn filled(text: &str) -> Result<String, &'static str> {
    if text.trim().is_empty() { Err("is empty; expected a name") } else { Ok(text.to_owned()) }
}

fn date(text: &str) -> Result<Date, &'static str> {
    text.parse().map_err(|_| "is not a date; expected one such as 2026-01-31")
}

/// The fitted models, and the profile.
#[derive(Clone, Debug)]
pub struct Calibrated {
    pub calibration: Calibration,
    /// The model of the profile.
    pub family: Family,
    pub profile: DisplayProfile,
}

impl Calibrate {
    /// Asks for the profile that readings give if nothing else is said.
    pub fn of(readings: PathBuf) -> Self {
        Self { readings, name: None, by: None, with: WITH.to_owned(), on: None, model: None }
    }

    /// Fits the models; `name` is the display's unless the request has one.
    ///
    /// # Errors
    /// The readings are not valid, or the light hardly rises at the top and no table is asked for.
    pub fn calibrate(&self, name: &str) -> anyhow::Result<Calibrated> {
        let made = self.fit(name)?;
        match made.calibration.refusal(self.model) {
            Some(message) => anyhow::bail!("{}: {message}", self.readings.display()),
            None => Ok(made),
        }
    }

    /// Fits the models also to light that hardly rises at the top.
    ///
    /// # Errors
    /// The readings are not valid.
    pub fn fit(&self, name: &str) -> Result<Calibrated, FileErrors> {
        let calibration = Calibration::new(&readings::open(&self.readings)?);
        let family = self.model.unwrap_or(calibration.chosen);
        let measured =
            Measurement { on: Some(self.on.unwrap_or_else(today)), by: self.by.clone(), with: Some(self.with.clone()) };
        let profile = calibration.profile(family, self.name.as_deref().unwrap_or(name), measured);
        Ok(Calibrated { calibration, family, profile })
    }
}

impl Calibrated {
    /// Says what was found, in sentences.
    pub fn sentences(&self) -> Vec<String> {
        let Self { calibration, family, .. } = self;
        let (readings, model) = (&calibration.readings, calibration.model(*family));
        let channels: Vec<&str> = readings.channels().iter().map(|channel| channel.name()).collect();
        let (count, misfit) = (readings.all().len(), 100.0 * model.misfit);
        let LuminanceRange { black_cd_m2, white_cd_m2 } = calibration.luminance_of(*family);
        let mut told = vec![
            format!("{count} readings of {}; they differ from the model by {misfit:.2} %.", channels.join(", ")),
            format!("Black {black_cd_m2:.4} cd/m², white {white_cd_m2:.2} cd/m²."),
        ];
        if !calibration.additivity.is_empty() {
            let percent = largest_percent(&calibration.additivity).abs();
            told.push(format!("Additivity: gray differs from red + green + blue − 2 black by at most {percent:.2} %."));
        }
        let best = "the simplest of the models that predict left-out levels best";
        told.push(match calibration.chosen {
            chosen if chosen == *family => format!("Chosen: {family}, {best}."),
            chosen => format!("Chosen: {family}, as requested; {best} is {chosen}."),
        });
        told
    }
}
