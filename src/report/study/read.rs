//! A study: files read, ratings measured.

use std::path::PathBuf;

use crate::{
    analysis::measured::{Measured, MeasuredBuilder, Observation},
    store::{
        FileFaults,
        ratings::{self, Reading, Row, Shape, Sink, Source},
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
    /// Where there is nothing to analyse at all. What is wrong with part of the input is in [`Source::faults`].
    pub fn read(paths: &[PathBuf], how: &Reading) -> Result<Self, FileFaults> {
        let (source, collector) = ratings::read(paths, how, Collector::new)?;
        Ok(Self { source, measured: collector.0.finish() })
    }
}

/// Hands rows on to the analysis.
struct Collector(MeasuredBuilder);

impl Collector {
    fn new(shape: &Shape) -> Self {
        let mut builder = MeasuredBuilder::new(&shape.factors);
        if let Some(categories) = &shape.categories {
            builder = builder.with_categories(categories);
        }
        Self(if shape.guessed { builder.only_varied_factors() } else { builder })
    }
}

impl Sink for Collector {
    fn row(&mut self, row: &Row<'_>) -> Result<(), String> {
        let Row { subject, values, rating, count, place, response_time_s } = *row;
        let observation = Observation { subject, values, rating, count, place, response_time_s };
        self.0.add(&observation).map_err(|error| error.to_string())
    }

    fn absorb(&mut self, later: Self) -> Result<(), String> {
        self.0.absorb(later.0).map_err(|error| error.to_string())
    }
}
