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

/// Declares the options of a task or of a method: a struct with a field for each of them, and how a form lists them. A last
/// field can be a table that is not always there, with the options in it.
macro_rules! options {
    (
        $(#[$meta:meta])*
        $name:ident {
            $($(#[$field_meta:meta])* $field:ident: $type:ty = $default:expr, $label:literal, $value:expr, $about:literal;)*
        }
        $($(#[$table_meta:meta])* $table:ident: $table_type:ty = None, [
            $($key:literal, $key_label:literal, $key_value:expr, $key_about:literal;)*
        ])?
    ) => {
        $(#[$meta])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct $name {
            $(#[doc = $about] $(#[$field_meta])* pub $field: $type,)*
            $($(#[$table_meta])* #[serde(skip_serializing_if = "Option::is_none")] pub $table: $table_type,)?
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default,)* $($table: None,)? }
            }
        }

        impl $name {
            /// The options, as a form lists them.
            pub const OPTIONS: &[$crate::experiment::task::options::TaskOption] = &[
                $($crate::experiment::task::options::TaskOption {
                    key: stringify!($field), label: $label, value: $value, about: $about
                },)*
                $($($crate::experiment::task::options::TaskOption {
                    key: $key, label: $key_label, value: $key_value, about: $key_about
                },)*)?
            ];
        }
    };
}
pub(super) use options;
