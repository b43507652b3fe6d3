//! The options of tasks and methods, as a form lists them.

/// An option of a task or of an adaptive method.
#[derive(Clone, Copy, Debug)]
pub struct TaskOption {
    /// The key in the table of a definition. A key in a table of its own, such as `second.levels`, is an option only if
    /// that table is there; its first key opens it.
    pub key: &'static str,
    /// What it is, in a few words.
    pub label: &'static str,
    /// What it means, in a sentence.
    pub about: &'static str,
    /// What it can be.
    pub value: OptionValue,
}

/// What an option can be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OptionValue {
    /// A number.
    Number,
    /// A number, or none; the text says what none means.
    Optional(&'static str),
    /// A list of numbers; the text says what an empty one means, if it can be empty.
    Numbers(&'static str),
    /// True or false.
    Flag,
    /// One of these words or numbers.
    OneOf(&'static [&'static str]),
    /// A parameter of the stimulus that no factor varies; `true` if it can be missing.
    Parameter(bool),
    /// A factor, or none.
    Factor,
    /// Parameters of the stimulus and their values.
    Settings,
}

impl TaskOption {
    /// Describes an option.
    pub(super) const fn new(key: &'static str, label: &'static str, value: OptionValue, about: &'static str) -> Self {
        Self { key, label, about, value }
    }
}
