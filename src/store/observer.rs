//! Parameters of simulated observers (TOML); the documented defaults are in `experiments/observers`.

use std::path::Path;

use super::{FileFaults, text, toml_reader};
use crate::{
    experiment::{OrderedLogit, VisionRater},
    store::{StoreError, write_file},
    vision::Criterion,
};

/// The default observer's file, as it comes with the program.
pub const PAPER: &str = include_str!("../../experiments/observers/paper.toml");

/// Reads an observer.
///
/// # Errors
/// Every fault with its line and column.
pub fn open(path: &Path) -> Result<OrderedLogit, FileFaults> {
    parse(&path.display().to_string(), &text::read(path)?)
}

/// Reads an observer from its text; what is absent keeps its default.
///
/// # Errors
/// Every fault with its line and column.
pub fn parse(file: &str, text: &str) -> Result<OrderedLogit, FileFaults> {
    let table = toml_reader::parse(file, text)?;
    let reader = toml_reader::Reader::new(file, text);
    let root = reader.root(&table);
    root.schema();
    let default = OrderedLogit::default();
    let thresholds = root.numbers("thresholds").map_or(Ok(default.thresholds), <[f64; 3]>::try_from);
    let thresholds = match thresholds {
        Ok(t) if t.iter().all(|x| x.is_finite()) && t[0] < t[1] && t[1] < t[2] => t,
        _ => {
            root.fault_at(
                "thresholds",
                "thresholds must be three numbers that rise; expected for example [0.0, 1.5, 3.5]",
            );
            default.thresholds
        }
    };
    let number = |key: &'static str, default: f64, least: f64, most: f64| {
        let value = root.number(key, default);
        if !(least..=most).contains(&value) {
            root.fault_at(key, format!("{key} {value} is outside {least}…{most}; expected a number within"));
        }
        value
    };
    let weight = |key, default| number(key, default, -1000.0, 1000.0);
    let observer = OrderedLogit {
        thresholds,
        subject_sd: number("subject_sd", default.subject_sd, 0.0, 100.0),
        depth: weight("depth", default.depth),
        infinite_as: number("infinite_as", default.infinite_as, 1.0, 1000.0),
        strongest_width: number("strongest_width", default.strongest_width, 1e-6, 1.0),
        fall: weight("fall", default.fall),
        narrow: weight("narrow", default.narrow),
        oblique: weight("oblique", default.oblique),
        contrast: weight("contrast", default.contrast),
        lapse: number("lapse", default.lapse, 0.0, 1.0),
    };
    root.finish();
    reader.finish()?;
    Ok(observer)
}

/// Reads an observer who sees.
///
/// # Errors
/// Every fault with its line and column.
pub fn open_vision(path: &Path) -> Result<VisionRater, FileFaults> {
    parse_vision(&path.display().to_string(), &text::read(path)?)
}

/// Reads an observer who sees from its text; what is absent keeps its default.
///
/// # Errors
/// Every fault with its line and column.
pub fn parse_vision(file: &str, text: &str) -> Result<VisionRater, FileFaults> {
    let table = toml_reader::parse(file, text)?;
    let reader = toml_reader::Reader::new(file, text);
    let root = reader.root(&table);
    root.schema();
    let default = VisionRater::default();
    let thresholds = root.numbers("thresholds").map_or(Ok(default.criterion.thresholds), <[f64; 3]>::try_from);
    let thresholds = match thresholds {
        Ok(t) if t.iter().all(|x| x.is_finite()) && 0.0 < t[0] && t[0] < t[1] && t[1] < t[2] => t,
        _ => {
            root.fault_at(
                "thresholds",
                "thresholds must be three numbers above 0 that rise; expected for example [3.0, 8.0, 28.0]",
            );
            default.criterion.thresholds
        }
    };
    let number = |key: &'static str, default: f64, least: f64, most: f64| {
        let value = root.number(key, default);
        if !(least..=most).contains(&value) {
            root.fault_at(key, format!("{key} {value} is outside {least}…{most}; expected a number within"));
        }
        value
    };
    let rater = VisionRater {
        criterion: Criterion { thresholds, spread: number("spread", default.criterion.spread, 1e-6, 1000.0) },
        subject_sd: number("subject_sd", default.subject_sd, 0.0, 100.0),
        lapse: number("lapse", default.lapse, 0.0, 1.0),
    };
    root.finish();
    reader.finish()?;
    Ok(rater)
}

/// Writes a criterion as an observer who sees.
///
/// # Errors
/// The system's refusal.
pub fn write_criterion(path: &Path, criterion: &Criterion) -> Result<(), StoreError> {
    let [a, b, c] = criterion.thresholds;
    let text = format!("schema = 1\nthresholds = [{a:.6}, {b:.6}, {c:.6}]\nspread = {:.6}\n", criterion.spread);
    write_file(path, text.as_bytes())
}
