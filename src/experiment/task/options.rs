//! The options of the tables of a definition, as a form lists them.

use serde::de::DeserializeOwned;
use serde_json::Value;

/// An option in a table of a definition.
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
    /// An order of the trials.
    Order,
    /// Parameters of the stimulus and their values.
    Settings,
}

/// Declares the options of a table of a definition: a struct with a field for each of them, and how a form lists them. A last
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
            pub const OPTIONS: &[$crate::experiment::task::TaskOption] = &[
                $($crate::experiment::task::TaskOption {
                    key: stringify!($field), label: $label, value: $value, about: $about
                },)*
                $($($crate::experiment::task::TaskOption {
                    key: $key, label: $key_label, value: $key_value, about: $key_about
                },)*)?
            ];
        }
    };
}
pub(in crate::experiment) use options;

/// Reads the options of a task or of a method from a table, whatever their type.
pub trait OptionReader {
    /// Returns the options. Those that cannot be read have their defaults, and the reader keeps the errors.
    fn read<T: DeserializeOwned + Default>(&mut self) -> T;
}

/// Leaves every option at its default.
pub struct Defaults;

impl OptionReader for Defaults {
    fn read<T: DeserializeOwned + Default>(&mut self) -> T {
        T::default()
    }
}

/// Returns an option as it is typed in a form; empty if there is none.
pub fn typed(options: &Value, key: &str) -> String {
    let found = key.split('.').try_fold(options, |table, key| table.get(key));
    let plain = |value: &Value| match (value.as_str(), value.as_f64()) {
        (Some(text), _) => text.to_owned(),
        (None, Some(number)) => number.to_string(),
        (None, None) => value.to_string(),
    };
    match found {
        None | Some(Value::Null | Value::Object(_)) => String::new(),
        Some(Value::Array(list)) => list.iter().map(plain).collect::<Vec<_>>().join(", "),
        Some(value) => plain(value),
    }
}

/// Declares an enum of options of several kinds, which a definition names with a tag.
macro_rules! kinds {
    ($(#[$meta:meta])* $enum:ident, $tag:literal { $(#[doc = $doc:literal] $variant:ident($kind:ty) = $name:literal,)* }) => {
        $(#[$meta])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize)]
        #[serde(tag = $tag)]
        pub enum $enum {
            $(#[doc = $doc] #[serde(rename = $name)] $variant($kind),)*
        }

        impl $enum {
            /// The names in definitions.
            pub const NAMES: &[&str] = &[$($name),*];
            /// What each is, in the same order, in a sentence.
            pub const ABOUT: &[&str] = &[$($doc),*];

            /// Returns the name in a definition.
            pub fn name(&self) -> &'static str {
                match self {
                    $(Self::$variant(_) => $name,)*
                }
            }

            /// Returns the options of the kind `name`, in the order in which a form lists them; none if there is no such
            /// kind.
            pub fn options(name: &str) -> &'static [$crate::experiment::task::TaskOption] {
                match name {
                    $($name => <$kind>::OPTIONS,)*
                    _ => &[],
                }
            }

            /// Reads the options of the kind `name`; `None` if there is no such kind.
            pub fn read(name: &str, reader: &mut impl $crate::experiment::task::options::OptionReader) -> Option<Self> {
                match name {
                    $($name => Some(Self::$variant(reader.read())),)*
                    _ => None,
                }
            }
        }
    };
}
pub(in crate::experiment) use kinds;
