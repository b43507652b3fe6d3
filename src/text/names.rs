//! Values that commands and files write as words.

use std::{error::Error, ops::RangeInclusive, str::FromStr};

use clap::builder::{PossibleValuesParser, TypedValueParser};

/// Returns "expected one of …", followed by "; did you mean …?" if a known name is similar to `name`; if only one is known,
/// "expected …".
pub(crate) fn expected_one_of<S: AsRef<str>>(name: &str, known: &[S]) -> String {
    let known: Vec<&str> = known.iter().map(AsRef::as_ref).collect();
    if let [only] = known[..] {
        return format!("expected {only}");
    }
    let length = name.chars().count();
    let near = |candidate: &&&str| {
        let (other, most) = (candidate.chars().count(), 2.max(candidate.chars().count() / 2));
        // A name may have megabytes. It is at least as far away as the lengths differ.
        let distance = || strsim::damerau_levenshtein(&name.to_lowercase(), &candidate.to_lowercase());
        (length.abs_diff(other) <= most)
            .then(distance)
            .filter(|distance| *distance <= most.min(other.saturating_sub(1)))
    };
    let best = known.iter().filter_map(|candidate| Some((near(&candidate)?, candidate))).min().map(|(_, best)| best);
    let question = best.map_or_else(String::new, |candidate| format!("; did you mean {candidate}?"));
    format!("expected one of {}{question}", some_of(&known))
}

/// Lists names; if there are many, as of the columns of another program's table, only the first ones and the number of others.
pub(crate) fn some_of<S: AsRef<str>>(names: &[S]) -> String {
    const SHOWN: usize = 24;
    let shown = if names.len() > SHOWN + 1 { SHOWN } else { names.len() };
    let list = names[..shown].iter().map(AsRef::as_ref).collect::<Vec<_>>().join(", ");
    if shown < names.len() { format!("{list} and {} more", names.len() - shown) } else { list }
}

/// Compares strings in natural order: runs of digits are compared as whole numbers, so that S2 comes before S10.
pub(crate) fn natural(a: &str, b: &str) -> std::cmp::Ordering {
    // `S01` and `S1` must not compare as equal.
    natural_parts(a).cmp(natural_parts(b)).then_with(|| a.cmp(b))
}

/// Splits a string into its numbers, each without leading zeros and with its length, and the text between them.
fn natural_parts(text: &str) -> impl Iterator<Item = (usize, &[u8])> {
    text.as_bytes().chunk_by(|a, b| a.is_ascii_digit() == b.is_ascii_digit()).map(|part| {
        let zeros = part.iter().take_while(|digit| **digit == b'0').count();
        if part[0].is_ascii_digit() { (part.len() - zeros, &part[zeros..]) } else { (usize::MAX, part) }
    })
}

/// Returns a parser of the command line that accepts only one of `names`.
pub(crate) fn one_of<T>(names: &'static [&'static str]) -> impl TypedValueParser<Value = T>
where
    T: FromStr<Err: Error + Send + Sync + 'static> + Clone + Send + Sync + 'static,
{
    PossibleValuesParser::new(names).try_map(|name| name.parse())
}

/// Declares an enum whose values have a name in commands and files, and the error for any other name.
macro_rules! named {
    ($(#[$meta:meta])* $enum:ident, $error:ident {
        $(#[$first_doc:meta])* $first:ident = $first_name:literal,
        $($(#[$doc:meta])* $variant:ident = $name:literal,)*
    }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum $enum {
            $(#[$first_doc])* $first,
            $($(#[$doc])* $variant,)*
        }

        #[doc = concat!("The error for a string that names no [`", stringify!($enum), "`].")]
        #[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
        #[error("{0:?} is not known; expected {expected}", expected = $enum::EXPECTED)]
        pub struct $error(String);

        impl $enum {
            /// Every value, in the order in which lists show them.
            pub const ALL: &'static [$enum] = &[$enum::$first, $($enum::$variant,)*];
            /// Their names, in the same order.
            pub const NAMES: &'static [&'static str] = &[$first_name, $($name,)*];
            /// All names, as an error says what is expected.
            pub const EXPECTED: &'static str = concat!("one of ", $first_name $(, ", ", $name)*);

            /// The name in commands and files.
            pub const fn name(self) -> &'static str {
                match self {
                    $enum::$first => $first_name,
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
                let text = text.trim();
                $enum::ALL.iter().copied().find(|value| value.name() == text).ok_or_else(|| $error(text.to_owned()))
            }
        }

        $crate::text::names::serde_as_text!($enum);
    };
}
pub(crate) use named;

/// Parses one of `names` and a number of `what` within `range`, joined by a colon.
pub(crate) fn with_number<T: FromStr>(
    text: &str,
    names: &[&str],
    range: RangeInclusive<u32>,
    what: &str,
) -> Result<(T, u32), String> {
    let number = |text: &str| text.parse().ok().filter(|number| range.contains(number));
    let parsed = text.split_once(':').and_then(|(name, of)| Some((name.parse().ok()?, number(of)?)));
    parsed.ok_or_else(|| {
        let (last, others) = names.split_last().unwrap_or((&"", names));
        let (others, least, most) = (others.join(", "), range.start(), range.end());
        format!("{text:?} is not known; expected {others} or {last}, a colon and {least}…{most} {what}, such as {last}:{most}")
    })
}

/// Makes serde store these types as their text.
macro_rules! serde_as_text {
    ($($type:ty),*) => {$(
        impl serde::Serialize for $type {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.collect_str(self)
            }
        }

        impl<'de> serde::Deserialize<'de> for $type {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                String::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
            }
        }
    )*};
}
pub(crate) use serde_as_text;
