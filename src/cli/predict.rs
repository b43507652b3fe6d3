//! `machband predict`

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::{Bar, FittedPath, OutPath, count, print_data, print_line};
use crate::{
    experiment::{Condition, Protocol, visibilities},
    light::{LinearImage, Quantizer},
    report::{
        Study,
        prediction::{self, Comparison, MAX_PICTURES, window_deg},
        terminal::printable,
    },
    stimulus::{Parameter, Stimulus, ViewingConditions},
    store::{self, Writer, definition, observer, ratings::ReadOptions},
    text::{Cell, Column, Table},
    vision::{Criterion, PicturePrediction, Visibility},
    work::{Drawn, Encoded, Encoding, RequestError},
};

/// Maximum number of conditions of a definition, unless the user allows more. A prediction takes milliseconds; a study
/// has a hundred conditions.
const MAX_CONDITIONS: usize = 500;

/// Maximum number of pixels of an image, unless the user allows more: those of a 4K screen. Each takes about 110 bytes.
const MAX_PIXELS: u64 = 3840 * 2160;

/// Predict the visibility of Mach bands in one stimulus, in every condition of a definition, or in any image.
///
/// Visibility 0 means no band; 1 means a band that is just visible, like a thin line at its threshold. Detection is how
/// many times the contrast of the whole picture stands above an average person's threshold. No observer is needed;
/// --fit compares the prediction with ratings and estimates the thresholds between ratings.
#[derive(clap::Args)]
#[command(
    after_help = "Examples: machband predict --width 0.1 --depth 3\n          machband predict bangay2003 --out predicted.csv\n          machband predict --image render.png --window 20 --map bands.png\n          machband predict bangay2003 --fit results --criterion lab.toml"
)]
pub(super) struct Arguments {
    /// Built-in definition or path to a .toml file; all its conditions are predicted.
    experiment: Option<PathBuf>,
    /// Predict the bands in this image, which can be any opaque PNG. Unless --transfer or --display is given, the codes
    /// mean what the file's sRGB or gAMA chunk says, or sRGB.
    #[arg(long, value_name = "FILE.png", conflicts_with = "experiment")]
    image: Option<PathBuf>,
    /// Also accept more than 500 conditions (100 if each has a rendered picture), an image of more than 3840 × 2160
    /// pixels (up to 16384 per side), and ratings beyond the limits of `analyze`. This needs more time and memory.
    #[arg(long)]
    large: bool,
    /// Where to write a map of the image's bands: bright bands are white, dark bands are black.
    #[arg(long, value_name = "FILE.png", requires = "image")]
    map: Option<OutPath>,
    #[command(flatten)]
    stimulus: Drawn,
    #[command(flatten)]
    encoding: Encoding,
    /// Side of the stimulus in pixels [default: 512, or 1024 if it varies in one direction only].
    #[arg(long, value_name = "PX", value_parser = clap::value_parser!(u32).range(16..=16384))]
    size: Option<u32>,
    /// Width of the stimulus or image in degrees of visual angle [default: the width in the rated sessions, otherwise
    /// in the definition, otherwise 10].
    #[arg(long, value_name = "DEG")]
    window: Option<f64>,
    /// Luminance of white in cd/m² [default: the display profile's, or 100].
    #[arg(long, value_name = "CD")]
    white: Option<f64>,
    /// Compare the prediction with ratings from these result files or folders.
    #[arg(long, value_name = "FILE|DIR", num_args = 1.., requires = "experiment")]
    fit: Vec<PathBuf>,
    /// File with the thresholds between ratings; written with --fit, otherwise read.
    #[arg(long, value_name = "FILE.toml")]
    criterion: Option<FittedPath>,
    /// Where to write the table [default: standard output].
    #[arg(long, value_name = "FILE.csv")]
    out: Option<OutPath>,
    /// Write JSON instead: an object for one stimulus or image, otherwise a list with an object per condition; with
    /// --fit, the comparison.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &Arguments, writer: &Writer) -> anyhow::Result<()> {
    let positive = |name: &str, value: Option<f64>| match value {
        Some(value) if !(value.is_finite() && value > 0.0) => {
            Err(RequestError::whole(format!("--{name} {value} is invalid; expected a number above 0")))
        }
        value => Ok(value),
    };
    let window = positive("window", arguments.window)?;
    let encoded = arguments.encoding.read(&Bar::new("conditions"))?;
    let white = encoded.white_cd_m2(positive("white", arguments.white)?);
    let viewing = |window_deg| ViewingConditions { window_deg, white_cd_m2: white };
    if let Some(experiment) = &arguments.experiment {
        let protocol = definition::open(experiment)?;
        let study = if arguments.fit.is_empty() {
            None
        } else {
            Some(Study::read(&arguments.fit, &ReadOptions { large: arguments.large, ..ReadOptions::default() })?)
        };
        let planned = study.as_ref().map_or(protocol.viewing.window_deg, |study| window_deg(&study.source, &protocol));
        return all(arguments, writer, &protocol, study.as_ref(), &viewing(window.unwrap_or(planned)));
    }
    let criterion = criterion(arguments)?;
    let viewing = viewing(window.unwrap_or(10.0));
    if let Some(path) = &arguments.image {
        let (seen, view) = image(arguments, writer, path, &encoded, &viewing)?;
        let name = Cell::Text(printable(&path.display().to_string()).into_owned());
        let image = vec![Column::new("image", "", "The file.")];
        let mut table = table(image, vec![vec![name]], &[seen], &criterion, 0.0);
        table.columns.extend(lines(view.lines));
        return one(arguments, writer, &table);
    }
    let stimulus = arguments.stimulus.stimulus()?;
    check_size(arguments.size, &stimulus)?;
    let size = arguments.size.unwrap_or_else(|| ViewingConditions::px(&stimulus));
    let wrong = |error| anyhow::anyhow!("{}: {error}", stimulus.kind());
    let visibility = viewing.predict(&stimulus, size).map_err(wrong)?.visibility();
    let seen = Seen { visibility, detection: viewing.detection(&stimulus).map_err(wrong)? };
    let kind = Column::new("stimulus", "", "Kind of stimulus.");
    let columns = std::iter::once(kind).chain(stimulus.parameters().iter().map(column)).collect();
    let mut row = vec![Cell::from(stimulus.kind())];
    row.extend(stimulus.parameters().iter().map(|parameter| Cell::from(stimulus.get(parameter.name))));
    one(arguments, writer, &table(columns, vec![row], &[seen], &criterion, 0.0))
}

/// Describes the column of a parameter.
fn column(parameter: &Parameter) -> Column {
    Column::new(parameter.name, parameter.unit, format!("{}.", parameter.description))
}

/// Returns the visibility of the lines that an image itself contains.
fn lines(Visibility { bright, dark }: Visibility) -> [Column; 2] {
    [("lines_bright", bright, "bright"), ("lines_dark", dark, "dark")].map(|(name, visibility, which)| Column {
        cells: vec![decimals(visibility)],
        ..Column::new(name, "times threshold", format!("Visibility of the strongest {which} line in the image."))
    })
}

/// What is predicted for one stimulus.
#[derive(Clone, Copy)]
struct Seen {
    visibility: Visibility,
    /// How many times the contrast of the picture stands above an average person's threshold.
    detection: f64,
}

fn image(
    arguments: &Arguments,
    writer: &Writer,
    path: &Path,
    encoded: &Encoded,
    viewing: &ViewingConditions,
) -> anyhow::Result<(Seen, PicturePrediction)> {
    let transfers = encoded.is_given.then_some(&encoded.transfers);
    let pixels = if arguments.large { u64::MAX } else { MAX_PIXELS };
    let image = store::image::read_light(path, transfers, pixels)?;
    let wrong = |error| anyhow::anyhow!("{}: {error}", path.display());
    let view = viewing.predict_image(&image).map_err(wrong)?;
    let detection = viewing.detection_of_image(&image).map_err(wrong)?;
    if let Some(map) = &arguments.map {
        // The strongest band is white or black; medium gray means no band.
        let most = view.map.bright.iter().chain(&view.map.dark).copied().fold(1e-9, f64::max);
        let gray = |i: usize| (0.5 + 0.5 * (view.map.bright[i] - view.map.dark[i]) / most) as f32;
        let place = |x: u32, y: u32| y as usize * image.width as usize + x as usize;
        let drawn = LinearImage::from_fn(image.width, image.height, |x, y| [gray(place(x, y)); 3]);
        let codes = Quantizer::new(&crate::light::Transfer::Srgb, crate::light::Bits::Eight).quantize(&drawn);
        store::image::write_codes(writer, map, &codes)?;
    }
    Ok((Seen { visibility: view.visibility, detection }, view))
}

fn all(
    arguments: &Arguments,
    writer: &Writer,
    protocol: &Protocol,
    study: Option<&Study>,
    viewing: &ViewingConditions,
) -> anyhow::Result<()> {
    let conditions = protocol.conditions();
    let is_line = protocol.stimulus.is_line();
    let (most, kind) = if is_line { (MAX_CONDITIONS, "") } else { (MAX_PICTURES, " with a rendered picture") };
    if conditions.len() > most && !arguments.large {
        let (name, found) = (&protocol.name, conditions.len());
        let message = format!(
            "{name}: the number of conditions{kind} is {found}; expected at most {most}, or the option --large"
        );
        return Err(RequestError::whole(message).into());
    }
    conditions.iter().try_for_each(|condition| check_size(arguments.size, &condition.stimulus))?;
    let wrong = |error| anyhow::anyhow!("{}: {error}", protocol.stimulus.kind());
    let found = visibilities(conditions, viewing, arguments.size).map_err(wrong)?;
    let known = protocol.stimulus.parameters();
    let columns: Vec<Column> = protocol
        .factors
        .iter()
        .filter_map(|factor| known.iter().find(|parameter| parameter.name == factor.name).map(column))
        .collect();
    let row = |condition: &Condition| -> Vec<Cell> {
        let levels = protocol.factors.iter().zip(&condition.levels);
        levels.map(|(factor, level)| factor.levels[*level].clone().into()).collect()
    };
    let rows = conditions.iter().map(row).collect();
    let all = |criterion: &Criterion, least: f64| {
        let detections = conditions.par_iter().map(|condition| viewing.detection(&condition.stimulus));
        let detections = detections.collect::<Result<Vec<f64>, _>>().map_err(wrong)?;
        let seen =
            found.iter().zip(detections).map(|(visibility, detection)| Seen { visibility: *visibility, detection });
        let table = table(columns, rows, &seen.collect::<Vec<_>>(), criterion, least);
        put(arguments, writer, &if arguments.json { json(&table.json())? } else { table.csv() })
    };
    let Some(study) = study else {
        return all(&criterion(arguments)?, 0.0);
    };
    let comparison = prediction::compare_conditions(&study.measured.counts, protocol, conditions, &found)
        .map_err(|error| anyhow::anyhow!("{}: {error}", arguments.fit[0].display()))?;
    if let Some(path) = &arguments.criterion {
        observer::write_criterion(writer, path, &comparison.criterion)?;
    }
    if arguments.out.is_some() {
        all(&comparison.criterion, prediction::MIN_VISIBILITY)?;
    }
    if arguments.json {
        print_data(&json(&serde_json::json!({
            "ratings": comparison.ratings,
            "conditions": comparison.conditions,
            "criterion": comparison.criterion,
            "rank_correlation": comparison.rank_correlation,
            "rank_correlation_with_participants": comparison.with_subjects,
            "noise_ceiling": comparison.ceiling,
        }))?)?;
    } else {
        print_comparison(&comparison)?;
    }
    super::ratings::problems(&study.source)
}

fn print_comparison(found: &Comparison) -> anyhow::Result<()> {
    let number = |value: Option<f64>| value.map_or_else(|| "—".to_owned(), |value| format!("{value:.3}"));
    print_line(&format!("{} of {}", count(found.ratings, "rating"), count(found.conditions as u64, "condition")))?;
    let [a, b, c] = found.criterion.thresholds;
    print_line(&format!(
        "criterion: half of the ratings are above 0, 1, 2 at a visibility of {a:.3}, {b:.3}, {c:.3}; spread {:.3}",
        found.criterion.spread
    ))?;
    print_line(&format!("rank correlation between visibility and mean rating: {}", number(found.rank_correlation)))?;
    let ceiling = found.ceiling.map_or_else(
        || "noise ceiling unknown: only one participant".to_owned(),
        |[low, high]| format!("noise ceiling from agreement between participants: {low:.3} to {high:.3}"),
    );
    print_line(&format!("mean for individual participants: {}; {ceiling}", number(found.with_subjects)))
}

/// Checks that a picture of this stimulus fits into memory.
fn check_size(size: Option<u32>, stimulus: &Stimulus) -> Result<(), RequestError> {
    let most = ViewingConditions::MAX_PICTURE_PX;
    match size {
        Some(size) if size > most && !stimulus.is_line() => Err(RequestError::whole(format!(
            "--size {size} is too large for {}, which varies in two directions; expected at most {most}",
            stimulus.kind()
        ))),
        _ => Ok(()),
    }
}

/// Returns the criterion from the given file, or the default.
fn criterion(arguments: &Arguments) -> anyhow::Result<Criterion> {
    match &arguments.criterion {
        Some(path) => Ok(observer::open_vision(path)?.criterion()),
        None => Ok(Criterion::default()),
    }
}

/// Returns the table, whose first columns have these rows. A band that is less visible than `least` is rated as if it
/// had that visibility.
fn table(
    mut columns: Vec<Column>,
    mut rows: Vec<Vec<Cell>>,
    seen: &[Seen],
    criterion: &Criterion,
    least: f64,
) -> Table {
    const TIMES: &str = "times threshold";
    columns.extend([
        Column::new("visibility", TIMES, "Visibility of the strongest band."),
        Column::new("detection", TIMES, "Contrast of the whole picture, for an average person."),
        Column::new("predicted_rating", "", "Expected rating of the strongest band."),
        Column::new("visibility_bright", TIMES, "Visibility of the bright band."),
        Column::new("visibility_dark", TIMES, "Visibility of the dark band."),
    ]);
    for (row, Seen { visibility, detection }) in rows.iter_mut().zip(seen) {
        let strongest = visibility.max();
        let rating = criterion.mean(strongest.max(least));
        row.extend([strongest, *detection, rating, visibility.bright, visibility.dark].map(decimals));
    }
    Table::new(columns, rows)
}

/// Returns a prediction with four decimals; more would mean nothing.
fn decimals(value: f64) -> Cell {
    Cell::from((value * 1e4).round() / 1e4)
}

/// Writes a table that has one row.
fn one(arguments: &Arguments, writer: &Writer, table: &Table) -> anyhow::Result<()> {
    let object = || json(&table.json().first());
    put(arguments, writer, &if arguments.json { object()? } else { table.csv() })
}

fn json(value: &impl serde::Serialize) -> anyhow::Result<Vec<u8>> {
    let mut text = serde_json::to_vec_pretty(value)?;
    text.push(b'\n');
    Ok(text)
}

/// Writes to the file that was asked for, otherwise to standard output.
fn put(arguments: &Arguments, writer: &Writer, data: &[u8]) -> anyhow::Result<()> {
    match &arguments.out {
        Some(path) => Ok(writer.write(path, data)?),
        None => print_data(data),
    }
}
