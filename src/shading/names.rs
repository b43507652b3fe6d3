//! Enums whose values have names in commands and files.

/// Makes an enum whose values have a name in commands and files.
macro_rules! named {
    ($(#[$meta:meta])* $enum:ident, $error:ident { $($(#[$doc:meta])* $variant:ident = $name:literal,)* }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum $enum {
            $($(#[$doc])* $variant,)*
        }

        #[doc = concat!("A name that is none of [`", stringify!($enum), "`]'s.")]
        #[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
        #[error("{0:?} is not known; expected one of {expected}", expected = $enum::NAMES.join(", "))]
        pub struct $error(String);

        impl $enum {
            /// Every value, in the order in which lists show them.
            pub const ALL: &'static [$enum] = &[$($enum::$variant,)*];
            /// Their names, in the same order.
            pub const NAMES: &'static [&'static str] = &[$($name,)*];

            /// The name in commands and files.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $($enum::$variant => $name,)*
                }
            }
        }

        impl std::fmt::Display for $enum {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.pad(self.name())
            }
        }

        impl std::str::FromStr for $enum {
            type Err = $error;

            fn from_str(text: &str) -> Result<Self, Self::Err> {
                $enum::ALL.iter().copied().find(|value| value.name() == text).ok_or_else(|| $error(text.to_owned()))
            }
        }
    };
}

pub(crate) use named;
