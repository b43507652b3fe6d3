//! Parameters of simulated observers (TOML); the documented defaults are in `experiments/observers`.

use std::path::Path;

use super::{
    FileErrors, StoreError, Writer,
    file::read_text,
    toml::{self, Document},
};
use crate::{
    experiment::{OrderedLogit, VisionRater},
    vision::Criterion,
};

/// The file of the default observer, which is built into the program.
pub const PAPER: &str = include_str!("../../experiments/observers/paper.toml");

/// Reads an ordered-logit observer from a file.
///
/// # Errors
/// Reports every error, with its line and column.
pub fn open(path: &Path) -> Result<OrderedLogit, FileErrors> {
    parse(&path.display().to_string(), &read_text(path)?)
}

/// Parses the text of an ordered-logit observer; missing keys keep their defaults.
///
/// # Errors
/// Reports every error, with its line and column.
pub fn parse(file: &str, text: &str) -> Result<OrderedLogit, FileErrors> {
    let (mut observer, mut document) = toml::read::<OrderedLogit>(file, text)?;
    check_thresholds(&mut document, observer.thresholds, f64::NEG_INFINITY, "[0.0, 1.5, 3.5]");
    for (key, value, [least, most]) in observer.parameters() {
        document.check_range(key, &[*value], least..=most);
    }
    document.finish(observer)
}

/// Reads a vision observer from a file.
///
/// # Errors
/// Reports every error, with its line and column.
pub fn open_vision(path: &Path) -> Result<VisionRater, FileErrors> {
    parse_vision(&path.display().to_string(), &read_text(path)?)
}

/// Parses the text of a vision observer; missing keys keep their defaults.
///
/// # Errors
/// Reports every error, with its line and column.
pub fn parse_vision(file: &str, text: &str) -> Result<VisionRater, FileErrors> {
    let (rater, mut document) = toml::read::<VisionRater>(file, text)?;
    check_thresholds(&mut document, rater.thresholds, 0.0, "[0.25, 1.0, 4.0]");
    document.check_range("spread", &[rater.spread], 1e-6..=1000.0);
    document.check_range("subject_sd", &[rater.subject_sd], 0.0..=100.0);
    document.check_range("lapse", &[rater.lapse], 0.0..=1.0);
    document.finish(rater)
}

/// Writes a criterion as a file for a vision observer. `origin` is a line that says what it rests on.
///
/// # Errors
/// The same errors as [`Writer::write`].
pub fn write_criterion(writer: &Writer, path: &Path, origin: &str, criterion: &Criterion) -> Result<(), StoreError> {
    let [a, b, c] = criterion.thresholds;
    let text =
        format!("# {origin}\nschema = 1\nthresholds = [{a:.6}, {b:.6}, {c:.6}]\nspread = {:.6}\n", criterion.spread);
    writer.write(path, text.as_bytes())
}

fn check_thresholds(document: &mut Document<'_>, [a, b, c]: [f64; 3], above: f64, example: &str) {
    if !(above < a && a < b && b < c && c < f64::INFINITY) {
        let sign = if above < 0.0 { "" } else { " above 0" };
        let message = format!("thresholds must be three increasing numbers{sign}; expected a list such as {example}");
        document.error("thresholds", message);
    }
}
