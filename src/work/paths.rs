//! Paths of outputs. From their types follows what a skin must guard, so a new operation is guarded too.

use std::{
    ops::Deref,
    path::{Path, PathBuf},
};

use clap::builder::{MapValueParser, PathBufValueParser, TypedValueParser as _, ValueParserFactory};
use serde::Serialize;

macro_rules! output_path {
    ($(#[$documentation:meta])* $name:ident) => {
        $(#[$documentation])*
        #[derive(Clone, Debug, PartialEq, Eq, Serialize)]
        pub struct $name(PathBuf);

        impl ValueParserFactory for $name {
            type Parser = MapValueParser<PathBufValueParser, fn(PathBuf) -> Self>;

            fn value_parser() -> Self::Parser {
                PathBufValueParser::new().map(Self)
            }
        }

        impl From<PathBuf> for $name {
            fn from(path: PathBuf) -> Self {
                Self(path)
            }
        }

        impl Deref for $name {
            type Target = Path;

            fn deref(&self) -> &Path {
                &self.0
            }
        }
    };
}

output_path! {
    /// A file to write, or, with the hint [`clap::ValueHint::DirPath`], a folder to write files into.
    OutPath
}
output_path! {
    /// A folder to create; the operation itself checks that it is new or empty.
    NewFolder
}
output_path! {
    /// A file that is written if the field `fit` is given, and otherwise read.
    FittedPath
}
