//! A study: files read, ratings measured.

use std::path::PathBuf;

use crate::{
    analysis::counts::{Measured, MeasuredBuilder},
    experiment::RatingRow,
    store::{
        FileFaults,
        ratings::{self, ReadOptions, Shape, Source},
    },
};

/// What files say, and what was found wrong with them.
#[derive(Clone, Debug)]
pub struct Study {
    /// Where the ratings come from.
    pub source: Source,
    /// The ratings.
    pub measured: Measured,
}

impl Study {
    /// Reads files, and folders of them.
    ///
    /// # Errors
    /// Where there is nothing to analyze at all. What is wrong with part of the input is in [`Source::faults`].
    pub fn read(paths: &[PathBuf], how: &ReadOptions) -> Result<Self, FileFaults> {
        let new = |shape: &Shape| {
            let mut builder = MeasuredBuilder::new(&shape.factors);
            if let Some(categories) = &shape.categories {
                builder = builder.with_categories(categories);
            }
            if shape.guessed { builder.only_varied_factors() } else { builder }
        };
        let add =
            |builder: &mut MeasuredBuilder, row: &RatingRow<'_>| builder.add(row).map_err(|error| error.to_string());
        let (source, files) = ratings::read(paths, how, new, add)?;
        let mut all = new(&source.shape);
        for (file, read) in files.into_iter().zip(&source.files) {
            let name = || read.path.display().to_string();
            all.absorb(file).map_err(|error| FileFaults::whole(name(), error.to_string()))?;
        }
        Ok(Self { source, measured: all.finish() })
    }
}
