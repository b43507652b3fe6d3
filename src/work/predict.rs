//! The predicted visibility of bands: in one stimulus or image, or in every condition of a definition.

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde::Serialize;

use super::{
    Drawn, Encoded, Encoding, FittedPath, Ratings, RequestError, Watcher, explained,
    image::side,
    request::{paths, positive},
};
use crate::{
    experiment::{Condition, Protocol, visibilities},
    light::{Bits, CodeImage, LinearImage, Quantizer, Transfer},
    report::{
        Study,
        prediction::{self, Comparison, MAX_PICTURES, window_deg},
        terminal::printable,
    },
    stimulus::{Parameter, Stimulus, StimulusPrediction, ViewingConditions},
    store::{self, definition, observer, ratings::Source},
    text::{Cell, Column, Table},
    vision::{Criterion, Visibility, VisionError},
};

/// Maximum number of conditions of a definition, unless the user allows more. A prediction takes milliseconds; a study
/// has a hundred conditions.
const MAX_CONDITIONS: usize = 500;

/// Maximum number of pixels of an image, unless the user allows more: those of a 4K screen. Each takes about 110 bytes.
const MAX_PIXELS: u64 = 3840 * 2160;

/// What to predict, how it is seen, and what the prediction is compared with.
#[derive(Clone, Debug, PartialEq, clap::Args, Serialize)]
pub struct Predict {
    /// Built-in definition or path to a .toml file; all its conditions are predicted.
    #[serde(serialize_with = "paths")]
    pub experiment: Option<PathBuf>,
    /// Predict the bands in this image, which can be any opaque PNG. Without a transfer function or a display profile,
    /// the codes mean what the file's sRGB or gAMA chunk says, or sRGB.
    #[arg(long, value_name = "FILE.png", conflicts_with = "experiment")]
    #[serde(serialize_with = "paths")]
    pub image: Option<PathBuf>,
    /// Also accept more than 500 conditions (100 if each has a rendered picture), an image of more than 3840 × 2160
    /// pixels, and ratings beyond the limits of `analyze`. This needs more time and memory.
    #[arg(long)]
    pub large: bool,
    #[command(flatten)]
    #[serde(flatten)]
    pub drawn: Drawn,
    #[command(flatten)]
    #[serde(flatten)]
    pub encoding: Encoding,
    /// Side of the stimulus in pixels [default: 512, or 1024 if it varies in one direction only].
    #[arg(long, value_name = "PX", value_parser = side(16))]
    pub size: Option<u32>,
    /// Width of the stimulus or image in degrees of visual angle [default: the width in the rated sessions, otherwise
    /// in the definition, otherwise 10].
    #[arg(long = "window", value_name = "DEG", value_parser = positive)]
    pub window_deg: Option<f64>,
    /// Pixels per degree of visual angle, in place of the width.
    #[arg(long, value_name = "PX", value_parser = positive, conflicts_with = "window_deg")]
    pub ppd: Option<f64>,
    /// Luminance of white in cd/m² [default: the display profile's, or 100].
    #[arg(long, value_name = "CD_M2", value_parser = positive)]
    pub white: Option<f64>,
    /// Compare the prediction with ratings from these result files or folders.
    #[arg(long, value_name = "FILE|DIR", num_args = 1.., requires = "experiment")]
    #[serde(serialize_with = "paths")]
    pub fit: Vec<PathBuf>,
    /// File with the thresholds between ratings; written if the prediction is compared with ratings,
    /// otherwise read.
    #[arg(long, value_name = "FILE.toml")]
    pub criterion: Option<FittedPath>,
}

/// What a caller shows in place of what the request names.
#[derive(Clone, Debug, PartialEq)]
pub enum Shown {
    Stimulus(Stimulus),
    /// An image whose codes mean what the request says, by default sRGB.
    Codes(CodeImage),
    Light(LinearImage),
}

/// What is predicted for one stimulus or image.
#[derive(Clone, Debug)]
pub struct Prediction {
    pub view: StimulusPrediction,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Contrast of the picture, in multiples of an average person's threshold.
    pub detection: f64,
    /// Expected rating of the strongest band.
    pub rating: f64,
    /// All of it in one row, with what was predicted.
    pub table: Table,
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
    /// Predicts the bands in `shown`, or otherwise in the image or stimulus that the request names.
    ///
    /// # Errors
    /// A value is impossible, a file cannot be read, or the picture is too large, too small or all black.
    pub fn one(&self, shown: Option<Shown>, watcher: &dyn Watcher) -> anyhow::Result<Prediction> {
        let (encoded, criterion) = (self.encoding.read(watcher)?, self.criterion()?);
        let image = match shown {
            Some(Shown::Stimulus(stimulus)) => return self.stimulus(&stimulus, &encoded, &criterion),
            Some(Shown::Codes(codes)) => {
                self.check_pixels(codes.width, codes.height)?;
                codes.light(&encoded.transfers)
            }
            Some(Shown::Light(light)) => {
                self.check_pixels(light.width, light.height)?;
                light
            }
            None => match &self.image {
                None => return self.stimulus(&self.drawn.stimulus()?, &encoded, &criterion),
                Some(path) => {
                    let transfers = encoded.is_given.then_some(&encoded.transfers);
                    store::image::read_light(path, transfers, self.pixels())?
                }
            },
        };
        let name = self
            .image
            .as_ref()
            .map_or_else(|| "image".to_owned(), |path| printable(&path.display().to_string()).into_owned());
        let viewing = self.viewing(&encoded, image.width, ViewingConditions::WINDOW_DEG);
        let wrong = |error| anyhow::anyhow!("{name}: {error}");
        let view = viewing.predict_image(&image).map_err(wrong)?;
        let lines = view.lines;
        let (view, detection) =
            (StimulusPrediction::Picture(Box::new(view)), viewing.detection_of_image(&image).map_err(wrong)?);
        let columns = vec![Column::new("image", "", "The file.")];
        let size = [image.width, image.height];
        let mut found = Prediction::new(view, size, detection, columns, vec![name.into()], &criterion);
        found.table.columns.extend([("bright", lines.bright), ("dark", lines.dark)].map(|(which, visibility)| {
            Column {
                cells: vec![decimals(visibility)],
                ..Column::new(
                    format!("lines_{which}"),
                    TIMES,
                    format!("Visibility of the strongest {which} line in the image."),
                )
            }
        }));
        Ok(found)
    }

    fn stimulus(&self, stimulus: &Stimulus, encoded: &Encoded, criterion: &Criterion) -> anyhow::Result<Prediction> {
        let size = self.size_of(stimulus)?;
        let viewing = self.viewing(encoded, size, ViewingConditions::WINDOW_DEG);
        let wrong = |error| anyhow::anyhow!("{}: {error}", stimulus.kind());
        let view = viewing.predict(stimulus, size).map_err(wrong)?;
        let detection = viewing.detection(stimulus).map_err(wrong)?;
        let kind = Column::new("stimulus", "", "Kind of stimulus.");
        let columns = std::iter::once(kind).chain(stimulus.parameters().iter().map(column)).collect();
        let values = stimulus.parameters().iter().map(|parameter| Cell::from(stimulus.get(parameter.name)));
        let cells = std::iter::once(Cell::from(stimulus.kind())).chain(values).collect();
        Ok(Prediction::new(view, [size; 2], detection, columns, cells, criterion))
    }

    /// Predicts every condition of `experiment`, and compares the predictions with the ratings, if there are any.
    ///
    /// # Errors
    /// A file cannot be read, there are too many conditions, a condition cannot be seen, or the ratings cannot be
    /// compared with the prediction.
    pub fn all(&self, experiment: &Path, watcher: &dyn Watcher) -> anyhow::Result<Predictions> {
        let encoded = self.encoding.read(watcher)?;
        let protocol = definition::open(experiment)?;
        let conditions = protocol.conditions();
        self.check_number(&protocol, conditions.len())?;
        conditions.iter().try_for_each(|condition| self.size_of(&condition.stimulus).map(drop))?;
        let study = if self.fit.is_empty() { None } else { Some(self.study()?) };
        let planned = study.as_ref().map_or(protocol.viewing.window_deg, |study| window_deg(&study.source, &protocol));
        let viewing = self.viewing(&encoded, self.size_of(&protocol.stimulus)?, planned);
        let wrong = |error: VisionError| anyhow::anyhow!("{}: {error}", protocol.stimulus.kind());
        let found = visibilities(conditions, &viewing, self.size).map_err(wrong)?;
        let compared = |study: Study| {
            prediction::compare_conditions(&study.measured.counts, &protocol, conditions, &found)
                .map(|comparison| (comparison, study.source))
                .map_err(|error| anyhow::anyhow!("{}: {error}", self.fit[0].display()))
        };
        let fit = study.map(compared).transpose()?;
        let (criterion, least) = match &fit {
            Some((comparison, _)) => (comparison.criterion.clone(), prediction::MIN_VISIBILITY),
            None => (self.criterion()?, 0.0),
        };
        let detections = conditions.par_iter().map(|condition| viewing.detection(&condition.stimulus));
        let detections = detections.collect::<Result<Vec<f64>, _>>().map_err(wrong)?;
        let known = protocol.stimulus.parameters();
        let named = |name: &str| known.iter().find(|parameter| parameter.name == name).map(column);
        let columns = protocol.factors.iter().filter_map(|factor| named(&factor.name)).chain(columns()).collect();
        let row = |((condition, visibility), detection): ((&Condition, &Visibility), f64)| {
            let levels = protocol.factors.iter().zip(&condition.levels);
            let levels = levels.map(|(factor, level)| Cell::from(factor.levels[*level].clone()));
            let rating = criterion.mean(visibility.max().max(least));
            levels.chain(cells(*visibility, detection, rating)).collect()
        };
        let table = Table::new(columns, conditions.iter().zip(&found).zip(detections).map(row));
        Ok(Predictions { table, fit })
    }

    /// Reads the ratings with which the prediction is compared.
    fn study(&self) -> anyhow::Result<Study> {
        let ratings = Ratings { paths: self.fit.clone(), ..Ratings::default() };
        ratings.read(Default::default(), false, self.large).map_err(explained)
    }

    /// Returns the criterion from the file, or the default.
    fn criterion(&self) -> anyhow::Result<Criterion> {
        let read = |path: &FittedPath| Ok(observer::open_vision(path)?.criterion());
        self.criterion.as_ref().map_or_else(|| Ok(Criterion::default()), read)
    }

    /// Returns the conditions under which a picture of this width is seen; its window has by default `planned` degrees.
    fn viewing(&self, encoded: &Encoded, width_px: u32, planned: f64) -> ViewingConditions {
        let of_ppd = self.ppd.map(|ppd| f64::from(width_px) / ppd);
        let window_deg = self.window_deg.or(of_ppd).unwrap_or(planned);
        ViewingConditions { window_deg, white_cd_m2: encoded.white_cd_m2(self.white) }
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

    /// Returns the maximum number of pixels of an image.
    fn pixels(&self) -> u64 {
        if self.large { u64::MAX } else { MAX_PIXELS }
    }

    fn check_pixels(&self, width: u32, height: u32) -> Result<(), RequestError> {
        if u64::from(width) * u64::from(height) <= self.pixels() {
            return Ok(());
        }
        let message = format!("the image has {width} × {height} pixels; expected at most {MAX_PIXELS} pixels");
        Err(RequestError::whole(message).unless("large"))
    }
}

impl Prediction {
    fn new(
        view: StimulusPrediction,
        size: [u32; 2],
        detection: f64,
        mut named: Vec<Column>,
        mut row: Vec<Cell>,
        criterion: &Criterion,
    ) -> Self {
        let visibility = view.visibility();
        let rating = criterion.mean(visibility.max());
        named.extend(columns());
        row.extend(cells(visibility, detection, rating));
        Self { view, size, detection, rating, table: Table::new(named, [row]) }
    }

    /// Draws the bands of a picture: the strongest is white or black, and medium gray means no band. A stimulus that
    /// varies in one direction has no such map.
    #[must_use]
    pub fn map(&self) -> Option<CodeImage> {
        let StimulusPrediction::Picture(view) = &self.view else { return None };
        let ([width, height], map) = (self.size, &view.map);
        let most = map.bright.iter().chain(&map.dark).copied().fold(1e-9, f64::max);
        let gray = |i: usize| (0.5 + 0.5 * (map.bright[i] - map.dark[i]) / most) as f32;
        let drawn = LinearImage::from_fn(width, height, |x, y| [gray(y as usize * width as usize + x as usize); 3]);
        Some(Quantizer::new(&Transfer::Srgb, Bits::Eight).quantize(&drawn))
    }
}

/// Describes the column of a parameter.
fn column(parameter: &Parameter) -> Column {
    Column::new(parameter.name, parameter.unit, format!("{}.", parameter.description))
}

/// The unit of visibility.
const TIMES: &str = "times threshold";

/// Describes the columns of a prediction.
fn columns() -> [Column; 5] {
    [
        Column::new("visibility", TIMES, "Visibility of the strongest band."),
        Column::new("detection", TIMES, "Contrast of the whole picture, for an average person."),
        Column::new("predicted_rating", "", "Expected rating of the strongest band."),
        Column::new("visibility_bright", TIMES, "Visibility of the bright band."),
        Column::new("visibility_dark", TIMES, "Visibility of the dark band."),
    ]
}

fn cells(visibility: Visibility, detection: f64, rating: f64) -> [Cell; 5] {
    [visibility.max(), detection, rating, visibility.bright, visibility.dark].map(decimals)
}

/// Returns a prediction with four decimals; more would mean nothing.
fn decimals(value: f64) -> Cell {
    Cell::from((value * 1e4).round() / 1e4)
}
