//! `machband predict`

use std::path::{Path, PathBuf};

use super::{
    UsageError,
    options::{StimulusOptions, TransferOptions},
    parallel, say,
};
use crate::{
    analysis::counts::Counts,
    experiment::{Condition, Protocol},
    light::{LinearImage, Quantizer},
    report::{
        Study,
        prediction::{self, Held},
    },
    stimulus::{ParameterValue, Stimulus},
    store::{self, definition, observer, ratings::Reading},
    vision::{Criterion, Eye, Picture, Visibility, luminances},
};

/// Predict how visible Mach bands are: of one stimulus, of every condition of a definition, or of any image.
///
/// Visibility is contrast times sensitivity, over all channels: 0 for no band, 1 for what is just seen. It needs no
/// observer; --fit holds it against ratings and says where one rating gives way to the next.
#[derive(clap::Args)]
#[command(
    after_help = "Examples: machband predict --width 0.1 --depth 3\n          machband predict bangay2003 --out predicted.csv\n          machband predict --image render.png --window 20 --map bands.png\n          machband predict bangay2003 --fit results --criterion lab.toml"
)]
pub(super) struct Arguments {
    /// Built-in definition or path of a .toml file: all its conditions.
    experiment: Option<String>,
    /// Any opaque PNG.
    #[arg(long, value_name = "FILE.png", conflicts_with = "experiment")]
    image: Option<PathBuf>,
    /// Where the image's bands are, to write: bright ones white, dark ones black.
    #[arg(long, value_name = "FILE.png", requires = "image")]
    map: Option<PathBuf>,
    #[command(flatten)]
    stimulus: StimulusOptions,
    #[command(flatten)]
    transfer: TransferOptions,
    /// Side of the stimulus in pixels.
    #[arg(long, value_name = "PX", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(16..=16384))]
    size: u32,
    /// Degrees that the stimulus, or the image's width, takes of the eye's field [default: the definition's, or 10].
    #[arg(long, value_name = "DEG")]
    window: Option<f64>,
    /// Luminance of white, cd/m² [default: the display profile's, or 100].
    #[arg(long, value_name = "CD")]
    white: Option<f64>,
    /// Hold the prediction against these ratings: result files or folders.
    #[arg(long, value_name = "FILE|DIR", num_args = 1.., requires = "experiment")]
    fit: Vec<PathBuf>,
    /// Where one rating gives way to the next: written with --fit, else read.
    #[arg(long, value_name = "FILE.toml")]
    criterion: Option<PathBuf>,
    /// Table to write, in place of standard output.
    #[arg(long, value_name = "FILE.csv")]
    out: Option<PathBuf>,
}

/// What is predicted of one thing.
struct Prediction {
    /// In the order of the header.
    values: Vec<String>,
    visibility: Visibility,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let positive = |name: &str, value: Option<f64>| match value {
        Some(value) if !(value.is_finite() && value > 0.0) => {
            Err(UsageError(format!("--{name} {value} is impossible; expected a number above 0")))
        }
        value => Ok(value),
    };
    let window = positive("window", arguments.window)?;
    let white = match positive("white", arguments.white)? {
        Some(white) => white,
        None => arguments.transfer.white()?.unwrap_or(100.0),
    };
    if let Some(experiment) = &arguments.experiment {
        let protocol = definition::open(experiment)?;
        return all(arguments, &protocol, window, white);
    }
    let criterion = criterion(arguments)?;
    let window = window.unwrap_or(10.0);
    if let Some(path) = &arguments.image {
        let visibility = image(arguments, path, window, white)?;
        let row = Prediction { values: vec![path.display().to_string()], visibility };
        return write(arguments, &["image".to_owned()], &[row], &criterion);
    }
    let stimulus = arguments.stimulus.stimulus()?;
    let seen = see(&stimulus, arguments.size, window, white)?;
    let names: Vec<&str> = stimulus.parameters().iter().map(|parameter| parameter.name).collect();
    let header: Vec<String> = std::iter::once("stimulus").chain(names.iter().copied()).map(str::to_owned).collect();
    let value = |name: &&str| stimulus.get(name).map_or_else(String::new, |value| value.to_string());
    let values = std::iter::once(stimulus.kind().to_owned()).chain(names.iter().map(value)).collect();
    write(arguments, &header, &[Prediction { values, visibility: seen }], &criterion)
}

/// An eye that is set for an image's mean light.
fn eye(mean: f64, window: f64, white: f64) -> Eye {
    Eye { luminance: (white * mean).max(0.01), field_deg: window }
}

fn see(stimulus: &Stimulus, size: u32, window: f64, white: f64) -> anyhow::Result<Visibility> {
    let view = stimulus.seen(size, f64::from(size) / window, &stimulus.eye(size, window, white));
    view.map(|view| view.visibility()).map_err(|error| anyhow::anyhow!("{}: {error}", stimulus.kind()))
}

fn image(arguments: &Arguments, path: &Path, window: f64, white: f64) -> anyhow::Result<Visibility> {
    let (transfers, _) = arguments.transfer.transfers()?;
    let image = store::picture::read(path, &transfers)?;
    let light = luminances(&image);
    let (width, height) = (image.width as usize, image.height as usize);
    let mean = light.iter().sum::<f64>() / light.len().max(1) as f64;
    let eye = eye(mean, window, white);
    let picture = Picture { light: &light, width, height, px_per_deg: f64::from(image.width) / window, mask: None };
    let view = picture.see(&eye).map_err(|error| anyhow::anyhow!("{}: {error}", path.display()))?;
    if let Some(map) = &arguments.map {
        // What is as strong as the strongest band is white or black; nothing is a mean gray.
        let most = view.map.bright.iter().chain(&view.map.dark).copied().fold(1e-9, f64::max);
        let gray = |i: usize| (0.5 + 0.5 * (view.map.bright[i] - view.map.dark[i]) / most) as f32;
        let drawn = LinearImage::from_fn(image.width, image.height, |x, y| [gray(y as usize * width + x as usize); 3]);
        let codes = Quantizer::new(&crate::light::Transfer::Srgb, crate::light::Bits::Eight).quantize(&drawn);
        store::image::write_codes(map, &codes)?;
    }
    Ok(view.visibility)
}

fn all(arguments: &Arguments, protocol: &Protocol, window: Option<f64>, white: f64) -> anyhow::Result<()> {
    let conditions = protocol.conditions()?;
    let window = window.unwrap_or(protocol.viewing.window_deg);
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let seen = std::sync::Mutex::new(vec![Visibility::default(); conditions.len()]);
    parallel::each(conditions.len(), threads, |i| {
        let visibility = see(&conditions[i].stimulus, arguments.size, window, white)?;
        seen.lock().unwrap_or_else(std::sync::PoisonError::into_inner)[i] = visibility;
        anyhow::Ok(())
    })?;
    let seen = seen.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    let header: Vec<String> = protocol.factors.iter().map(|factor| factor.name.clone()).collect();
    let level = |condition: &Condition| -> Vec<String> {
        let levels = protocol.factors.iter().zip(&condition.levels);
        levels.map(|(factor, level)| factor.levels[*level].to_string()).collect()
    };
    let rows: Vec<Prediction> = conditions
        .iter()
        .zip(&seen)
        .map(|(condition, visibility)| Prediction { values: level(condition), visibility: *visibility })
        .collect();
    if arguments.fit.is_empty() {
        return write(arguments, &header, &rows, &criterion(arguments)?);
    }
    let study = Study::read(&arguments.fit, &Reading::default())?;
    let counts = &study.measured.counts;
    let visibilities: Vec<f64> = seen.iter().map(|visibility| visibility.max()).collect();
    let held = prediction::hold(counts, &matched(counts, &conditions, &visibilities))
        .map_err(|error| anyhow::anyhow!("{}: {error}", arguments.fit[0].display()))?;
    if let Some(path) = &arguments.criterion {
        observer::write_criterion(path, &held.criterion)?;
    }
    if arguments.out.is_some() {
        write(arguments, &header, &rows, &held.criterion)?;
    }
    tell(&held)?;
    super::ratings::faults(&study.source)
}

/// The prediction for each condition that was rated.
fn matched(counts: &Counts, conditions: &[Condition], visibilities: &[f64]) -> Vec<Option<f64>> {
    let same = |value: Option<ParameterValue>, text: &str| {
        let value = value.map_or_else(String::new, |value| value.to_string());
        match (value.parse::<f64>(), text.parse::<f64>()) {
            (Ok(a), Ok(b)) => a == b || (a - b).abs() <= 1e-12 * a.abs(),
            _ => value == text,
        }
    };
    let found = |condition: u32| {
        let names = counts.level_names(condition);
        conditions.iter().position(|condition| {
            counts.factors.iter().zip(&names).all(|(factor, text)| same(condition.stimulus.get(&factor.name), text))
        })
    };
    (0..counts.conditions.len() as u32).map(|condition| found(condition).map(|i| visibilities[i])).collect()
}

fn tell(held: &Held) -> anyhow::Result<()> {
    let number = |value: Option<f64>| value.map_or_else(|| "—".to_owned(), |value| format!("{value:.3}"));
    say(&format!("{} ratings of {} conditions", held.ratings, held.conditions))?;
    let [a, b, c] = held.criterion.thresholds;
    say(&format!(
        "criterion: half of the ratings are above 0, 1, 2 at a visibility of {a:.3}, {b:.3}, {c:.3}; spread {:.3}",
        held.criterion.spread
    ))?;
    say(&format!("rank correlation of visibility and mean rating: {}", number(held.rank_correlation)))?;
    let ceiling = held.ceiling.map_or_else(
        || "noise ceiling unknown: a single subject".to_owned(),
        |[low, high]| format!("noise ceiling, subjects with each other: {low:.3} to {high:.3}"),
    );
    say(&format!("with single subjects, on average: {}; {ceiling}", number(held.with_subjects)))
}

/// The criterion named, or the default.
fn criterion(arguments: &Arguments) -> anyhow::Result<Criterion> {
    match &arguments.criterion {
        Some(path) => Ok(observer::open_vision(path)?.criterion),
        None => Ok(Criterion::default()),
    }
}

fn write(arguments: &Arguments, header: &[String], rows: &[Prediction], criterion: &Criterion) -> anyhow::Result<()> {
    let mut table = csv::Writer::from_writer(Vec::new());
    let columns = ["visibility", "predicted_rating", "visibility_bright", "visibility_dark"];
    table.write_record(header.iter().map(String::as_str).chain(columns))?;
    for row in rows {
        let visibility = row.visibility;
        let numbers = [visibility.max(), criterion.mean(visibility.max()), visibility.bright, visibility.dark];
        table.write_record(row.values.iter().cloned().chain(numbers.map(|number| format!("{number:.4}"))))?;
    }
    let bytes = table.into_inner().map_err(|error| anyhow::anyhow!("{error}"))?;
    match &arguments.out {
        Some(path) => Ok(store::write_file(path, &bytes)?),
        None => say(String::from_utf8_lossy(&bytes).trim_end()),
    }
}
