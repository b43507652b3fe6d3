//! Options of which there are several kinds, as tables of a definition.

use serde::de::DeserializeOwned;

/// Reads the options of a task or of a method from a table, whatever their type.
pub trait OptionReader {
    /// Returns the options. Those that cannot be read have their defaults, and the reader keeps the errors.
    fn read<T: DeserializeOwned + Default>(&mut self) -> T;
}

/// Declares an enum of options of several kinds, which a definition names with a tag.
macro_rules! kinds {
    ($(#[$meta:meta])* $enum:ident, $tag:literal { $($(#[$doc:meta])* $variant:ident($kind:ty) = $name:literal,)* }) => {
        $(#[$meta])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize)]
        #[serde(tag = $tag)]
        pub enum $enum {
            $($(#[$doc])* #[serde(rename = $name)] $variant($kind),)*
        }

        impl $enum {
            /// The names in definitions.
            pub const NAMES: &[&str] = &[$($name),*];

            /// Returns the name in a definition.
            #[must_use]
            pub fn name(&self) -> &'static str {
                match self {
                    $(Self::$variant(_) => $name,)*
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
