//! The errors in a definition.

/// An error at one location of a definition.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DefinitionError {
    /// Keys and array indices joined by dots: `factors.width.2`.
    pub path: String,
    /// What is wrong, and what is expected.
    pub message: String,
}

/// The errors in a definition.
#[derive(Clone, Debug, Default)]
pub struct DefinitionErrors(pub Vec<DefinitionError>);

impl DefinitionErrors {
    /// Adds an error at a path.
    pub fn add(&mut self, path: impl Into<String>, message: impl Into<String>) {
        self.0.push(DefinitionError { path: path.into(), message: message.into() });
    }

    /// Adds an error unless `value` is finite and within `low…high`.
    pub(super) fn check_range(&mut self, path: &str, value: f64, low: f64, high: f64, meaning: &str) {
        if !(low..=high).contains(&value) {
            // Not the number of a value in a list.
            let is_name = |part: &&str| part.parse::<usize>().is_err();
            let key = path.rsplit('.').find(is_name).unwrap_or(path);
            self.add(path, format!("{key} {value} is outside {low}…{high}; expected {meaning}"));
        }
    }
}
