//! Parameters of simulated observers (TOML); the documented defaults are in `experiments/observers`.

use std::path::Path;

use super::{FileErrors, StoreError, Writer, file::read_text, toml};
use crate::{experiment::ObserverParameters, vision::Criterion};

/// The file of the default observer, which is built into the program.
pub const PAPER: &str = include_str!("../../experiments/observers/paper.toml");

/// Opens the parameters of an observer.
///
/// # Errors
/// Returns every error in the file, with its line and column.
pub fn open<T: ObserverParameters>(path: &Path) -> Result<T, FileErrors> {
    parse(&path.display().to_string(), &read_text(path)?)
}

/// Parses the parameters of an observer; `file` identifies the text in messages.
///
/// # Errors
/// Returns every error, with its line and column.
pub fn parse<T: ObserverParameters>(file: &str, text: &str) -> Result<T, FileErrors> {
    let (mut observer, mut document) = toml::read::<T>(file, text)?;
    let [a, b, c] = observer.thresholds();
    if !(T::ABOVE < a && a < b && b < c && c < f64::INFINITY) {
        let sign = if T::ABOVE < 0.0 { "" } else { " above 0" };
        let example = T::default().thresholds();
        let message = format!("thresholds must be three increasing numbers{sign}; expected a list such as {example:?}");
        document.error("thresholds", message);
    }
    for (key, value, [least, most]) in observer.parameters() {
        document.check_range(key, &[*value], least..=most);
    }
    document.finish(observer)
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
