//! How visible the bands of a ramp are, and the whole picture: of one stimulus, or in every condition of a definition.

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::{
    Drawn, Encoded, Encoding, FittedPath, Luminances, Ratings, RequestError, Study, Watcher,
    criterion::{self, Comparison, LEAST, window_deg},
};
use crate::{
    experiment::{Condition, Factor, Protocol, VisionRater},
    stimulus::{Parameter, Stimulus, ViewingConditions, Visible, recipe::MAX_SIZE},
    store::{definition, observer, ratings::Source},
    text::{
        Column, Table,
        number::{positive, whole},
    },
    vision::{Criterion, VisionError},
};

/// Maximum number of conditions of a definition, unless the user allows more. A prediction takes milliseconds; a study
/// has a hundred conditions.
const MAX_CONDITIONS: usize = 500;
/// The same maximum if each condition needs a rendered picture, which takes a few tenths of a second.
const MAX_PICTURES: usize = 100;

/// What to predict, how it is seen, and what the prediction is compared with.
#[derive(Clone, Debug, PartialEq, clap::Args, Serialize)]
pub struct Predict {
    /// Built-in definition or path to a .toml file; all its conditions are predicted.
    pub experiment: Option<PathBuf>,
    /// Also accept more than 500 conditions (100 if each has a rendered picture), and ratings beyond the limits of
    /// `analyze`. This needs more time and memory.
    #[arg(long)]
    pub large: bool,
    #[command(flatten)]
    #[serde(flatten)]
    pub drawn: Drawn,
    /// Display profile written by `machband calibrate`, for its white and black; stimuli have the primaries of sRGB.
    #[arg(long, value_name = "FILE")]
    pub display: Option<PathBuf>,
    /// Side of the stimulus in pixels [default: 512, or 1024 if it varies in one direction only].
    #[arg(long, value_name = "PX", value_parser = whole(16..=MAX_SIZE))]
    pub size: Option<u32>,
    /// Width of the stimulus in degrees of visual angle [default: the width in the rated sessions, otherwise
    /// in the definition, otherwise 10].
    #[arg(long = "window", value_name = "DEG", value_parser = positive)]
    pub window_deg: Option<f64>,
    /// Pixels per degree of visual angle, in place of the width.
    #[arg(long, value_name = "PX", value_parser = positive, conflicts_with = "window_deg")]
    pub ppd: Option<f64>,
    #[command(flatten)]
    #[serde(flatten)]
    pub luminances: Luminances,
    /// Compare the prediction with ratings from these result files or folders.
    #[arg(long, value_name = "FILE|DIR", num_args = 1.., requires = "experiment")]
    pub fit: Vec<PathBuf>,
    /// File with the thresholds between ratings, fitted to people; written if the prediction is compared with ratings,
    /// otherwise read to predict ratings.
    #[arg(long, value_name = "FILE.toml")]
    pub criterion: Option<FittedPath>,
}

/// What is predicted for one stimulus.
#[derive(Clone, Debug)]
pub struct Prediction {
    pub visible: Visible,
    /// Contrast of the picture, in multiples of an average person's threshold.
    pub detection: f64,
    /// The mean rating, if there is a criterion.
    pub rating: Option<f64>,
}

/// What is predicted for every condition of a definition.
#[derive(Clone, Debug)]
pub struct Predictions {
    /// One row for each condition.
    pub table: Table,
    /// How the prediction compares with ratings, and where these come from.
    pub fit: Option<(Comparison, Source)>,
}

impl Predict {
    /// Predicts the bands of `given`, or otherwise of the stimulus that the request names. Also returns a table of one row.
    ///
    /// # Errors
    /// A value is impossible, a file cannot be read, or the picture is too large, too small or all black.
    pub fn one(&self, given: Option<Stimulus>, watcher: &dyn Watcher) -> anyhow::Result<(Prediction, Table)> {
        let (encoded, criterion) = (self.encoded(watcher)?, self.criterion()?);
        let stimulus = given.map_or_else(|| self.drawn.stimulus(), Ok)?;
        let size = self.size_of(&stimulus)?;
        let viewing = self.viewing(&encoded, size, ViewingConditions::WINDOW_DEG);
        let wrong = |error| self.unseen(stimulus.kind(), &error);
        let visible = viewing.visible(&[&stimulus], Some(size)).map_err(wrong)?.remove(0);
        let detection = viewing.detection(&stimulus).map_err(wrong)?;
        let rating = criterion.as_ref().and_then(|criterion| Some(criterion.mean(visible.rated()?)));
        let kind = Column::new("stimulus", "", "Kind of stimulus.");
        let kind = Column { cells: vec![stimulus.kind().into()], ..kind };
        let value =
            |parameter: &Parameter| Column { cells: vec![stimulus.get(parameter.name).into()], ..column(parameter) };
        let columns = std::iter::once(kind).chain(stimulus.parameters().iter().map(value)).collect();
        let found = Prediction { visible, detection, rating };
        let table = table(columns, std::slice::from_ref(&found), &stimulus, criterion.is_some());
        Ok((found, table))
    }

    /// Predicts every condition of `experiment`, and compares the predictions with the ratings, if there are any.
    ///
    /// # Errors
    /// A file cannot be read, there are too many conditions, a condition cannot be seen, or the ratings cannot be
    /// compared with the prediction.
    pub fn all(&self, experiment: &Path, watcher: &dyn Watcher) -> anyhow::Result<Predictions> {
        if !self.drawn.is_default() {
            let message = "the definition determines the stimuli; expected no options of a stimulus";
            return Err(RequestError::whole(message).into());
        }
        let encoded = self.encoded(watcher)?;
        let protocol = definition::open(experiment)?;
        protocol.chosen_later().map_or(Ok(()), |message| Err(RequestError::whole(message)))?;
        let conditions = protocol.conditions();
        self.check_number(&protocol, conditions.len())?;
        let size = self.size_of(&protocol.stimulus)?;
        let study = if self.fit.is_empty() { None } else { Some(self.study(&protocol)?) };
        let planned = study.as_ref().map_or(protocol.viewing.window_deg, |study| window_deg(&study.source, &protocol));
        let viewing = self.viewing(&encoded, size, planned);
        let wrong = |error| self.unseen(protocol.stimulus.kind(), &error);
        let stimuli: Vec<&Stimulus> = conditions.iter().map(|condition| &condition.stimulus).collect();
        let found = viewing.visible(&stimuli, self.size).map_err(wrong)?;
        let compared = |study: Study| {
            criterion::compare(&study.measured.counts, &protocol, conditions, &found)
                .map(|comparison| (comparison, study.source))
                .map_err(|error| anyhow::anyhow!("{}: {error}", self.fit[0].display()))
        };
        let fit = study.map(compared).transpose()?;
        let (criterion, least) = match &fit {
            Some((comparison, _)) => (Some(comparison.criterion.clone()), LEAST),
            None => (self.criterion()?, 0.0),
        };
        let detections = viewing.detections(&stimuli).map_err(wrong)?;
        let predicted = |(visible, detection): (Visible, f64)| {
            let rating = criterion.as_ref().and_then(|criterion| Some(criterion.mean(visible.rated()?.max(least))));
            Prediction { visible, detection, rating }
        };
        let rows: Vec<Prediction> = found.into_iter().zip(detections).map(predicted).collect();
        let levels = |(place, factor): (usize, &Factor)| {
            let known = protocol.stimulus.parameters().iter().find(|parameter| parameter.name == factor.name);
            let named = known.map_or_else(|| Column::new(&factor.name, "", "Level of the picture."), column);
            let level = |condition: &Condition| factor.levels[condition.levels[place]].clone().into();
            Column { cells: conditions.iter().map(level).collect(), ..named }
        };
        let columns = protocol.factors.iter().enumerate().map(levels).collect();
        let table = table(columns, &rows, &protocol.stimulus, criterion.is_some());
        Ok(Predictions { table, fit })
    }

    /// Reads the ratings of this experiment with which the prediction is compared. Ratings of another one may have the
    /// same factors, but their stimuli were others.
    fn study(&self, protocol: &Protocol) -> anyhow::Result<Study> {
        let ratings = Ratings { paths: self.fit.clone(), ..Ratings::default() };
        let study = ratings.read(Default::default(), false, self.large)?;
        match &study.source.protocol {
            Some(rated) if rated.stimulus != protocol.stimulus || rated.factors != protocol.factors => {
                let path = self.fit[0].display();
                let [other, own] = [rated, protocol].map(|protocol| &protocol.name);
                let version = if other == own { " in another version" } else { "" };
                let message = format!(
                    "{path}: these are ratings of other stimuli, those of {other}{version}; expected those of {own}"
                );
                Err(RequestError::whole(message).into())
            }
            _ => Ok(study),
        }
    }

    /// Returns the criterion from the file, if there is one.
    fn criterion(&self) -> anyhow::Result<Option<Criterion>> {
        let path = self.criterion.as_ref().filter(|_| self.fit.is_empty());
        path.map(|path| Ok(observer::open::<VisionRater>(path)?.criterion())).transpose()
    }

    fn encoded(&self, watcher: &dyn Watcher) -> anyhow::Result<Encoded> {
        Encoding { transfer: None, display: self.display.clone() }.read(watcher)
    }

    /// Returns the conditions under which a picture of this width is seen; its window has by default `planned` degrees.
    fn viewing(&self, encoded: &Encoded, width_px: u32, planned: f64) -> ViewingConditions {
        let of_ppd = self.ppd.map(|ppd| f64::from(width_px) / ppd);
        let window_deg = self.window_deg.or(of_ppd).unwrap_or(planned);
        encoded.viewing(window_deg, &self.luminances)
    }

    /// Says why a stimulus cannot be judged.
    fn unseen(&self, kind: &str, error: &VisionError) -> anyhow::Error {
        match error {
            VisionError::Extent(_) | VisionError::Sampling(_) => {
                RequestError::new(if self.ppd.is_some() { "ppd" } else { "window_deg" }, error).into()
            }
            _ => anyhow::anyhow!("{kind}: {error}"),
        }
    }

    /// Returns the side of this stimulus, of which a picture fits into memory.
    fn size_of(&self, stimulus: &Stimulus) -> Result<u32, RequestError> {
        let (size, most) =
            (self.size.unwrap_or_else(|| ViewingConditions::px(stimulus)), ViewingConditions::MAX_PICTURE_PX);
        if size <= most || stimulus.is_line() {
            return Ok(size);
        }
        let kind = stimulus.kind();
        let message =
            format!("{size} is too large for {kind}, which varies in two directions; expected at most {most}");
        Err(RequestError::value("size", message))
    }

    fn check_number(&self, protocol: &Protocol, found: usize) -> Result<(), RequestError> {
        let is_line = protocol.stimulus.is_line();
        let (most, kind) = if is_line { (MAX_CONDITIONS, "") } else { (MAX_PICTURES, " with a rendered picture") };
        if found <= most || self.large {
            return Ok(());
        }
        let name = &protocol.name;
        let message = format!("{name}: the number of conditions{kind} is {found}; expected at most {most}");
        Err(RequestError::whole(message).unless("large"))
    }
}

/// Describes the column of a parameter.
fn column(parameter: &Parameter) -> Column {
    Column::new(parameter.name, parameter.unit, format!("{}.", parameter.description))
}

/// The unit of what the model predicts.
const TIMES: &str = "times threshold";

/// Adds what is predicted to the columns of what varies.
fn table(mut columns: Vec<Column>, rows: &[Prediction], like: &Stimulus, is_rated: bool) -> Table {
    let mut add = |name: &str, unit: &str, description: &str, value: fn(&Prediction) -> Option<f64>| {
        // Four decimals; more would mean nothing.
        let cell = |row| value(row).map(|value| (value * 1e4).round() / 1e4).into();
        columns.push(Column { cells: rows.iter().map(cell).collect(), ..Column::new(name, unit, description) });
    };
    let bright = "The ramp's difference from the nearest smooth edge, on its light side.";
    add("band_bright", TIMES, bright, |row| row.visible.bands().map(|bands| bands.bright));
    add("band_dark", TIMES, "The same on its dark side.", |row| row.visible.bands().map(|bands| bands.dark));
    add("detection", TIMES, "Contrast of the whole picture, for an average person.", |row| Some(row.detection));
    if !like.is_line() {
        let difference = "The largest difference of a shaded mesh from the smooth surface.";
        add("difference", TIMES, difference, |row| row.visible.rated());
    }
    if is_rated {
        add("predicted_rating", "", "Mean rating by the criterion.", |row| row.rating);
    }
    Table { columns }
}
