//! Parameters of the ordered-logit observer (TOML); the documented default is `experiments/observers/paper.toml`.

use std::path::Path;

use super::{FileFaults, text, toml_reader};
use crate::experiment::OrderedLogit;

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
