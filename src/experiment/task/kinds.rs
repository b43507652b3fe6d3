//! Options of which there are several kinds, as tables of a definition.

use serde::de::DeserializeOwned;
use serde_json::Value;

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
            pub fn options(name: &str) -> &'static [$crate::experiment::task::options::TaskOption] {
                match name {
                    $($name => <$kind>::OPTIONS,)*
                    _ => &[],
                }
            }

            /// Reads the options of the kind `name`; `None` if there is no such kind.
            pub fn read(name: &str, reader: &mut impl $crate::experiment::task::kinds::OptionReader) -> Option<Self> {
                match name {
                    $($name => Some(Self::$variant(reader.read())),)*
                    _ => None,
                }
            }
        }
    };
}
pub(in crate::experiment) use kinds;
