//! The analysis of ratings.

use serde::Serialize;

use super::{Model, Ratings, RequestError, Watcher, named, ratings::explained};
use crate::{
    analysis::{ModelError, Options, Random, Resampling, Results, analyze_with},
    report::{Study, StudyError},
    store::{
        Columns,
        table::{List, list},
    },
};

/// What to analyze, and how.
#[derive(Clone, Debug, Default, PartialEq, clap::Args, Serialize)]
pub struct Analyze {
    #[command(flatten)]
    #[serde(flatten)]
    pub ratings: Ratings,
    #[command(flatten)]
    #[serde(flatten)]
    pub model: Model,
    /// Random intercept for each participant [default: subject if there are at least two participants].
    #[arg(long, value_parser = named::<Random>(Random::NAMES))]
    pub random: Option<Random>,
    /// Numbers that describe participants: each has one slope in the model, and no levels [default: numbers that are the same
    /// in all ratings of each participant].
    #[arg(long, value_name = "COL,…")]
    pub covariate: Option<List>,
    #[command(flatten)]
    #[serde(flatten)]
    pub resampling: Resampling,
}

impl Analyze {
    /// Returns the names of the columns that the terms use.
    pub fn columns(&self) -> impl Iterator<Item = &str> {
        let terms = self.model.terms.iter().flat_map(|terms| terms.iter());
        let variables = terms.flat_map(|term| &term.variables).map(|variable| variable.name());
        variables.chain(self.covariate.iter().flat_map(|list| &list.0).map(String::as_str))
    }

    /// Reads the ratings, also if the order of their categories is not known.
    ///
    /// # Errors
    /// There is nothing to analyze, or the study is too large.
    pub fn read_unordered(&self) -> Result<Study, StudyError> {
        self.ratings.read(self.columns().map(str::to_owned).collect(), true, self.model.large)
    }

    /// Reads the ratings.
    ///
    /// # Errors
    /// There is nothing to analyze, the study is too large, or the order of its categories is not known.
    pub fn read(&self) -> anyhow::Result<Study> {
        self.ordered(self.read_unordered())
    }

    /// Takes the ratings from a table in memory instead of files; `name` stands for it in messages.
    ///
    /// # Errors
    /// The same errors as [`Analyze::read`].
    pub fn read_columns(&self, name: &str, columns: Columns) -> anyhow::Result<Study> {
        let how = self.ratings.options(self.columns().map(str::to_owned).collect(), true, self.model.large);
        self.ordered(Study::from_columns(name, columns, &how))
    }

    /// Checks that the order of the categories is known.
    fn ordered(&self, study: Result<Study, StudyError>) -> anyhow::Result<Study> {
        let study = study.map_err(explained)?;
        let counts = &study.measured.counts;
        if counts.is_ordered(study.source.shape.categories.as_deref()) {
            return Ok(study);
        }
        let texts = list(counts.categories.iter().take(12));
        let message =
            format!("{}: {texts} are not numbers; expected their order, lowest first", study.source.shape.response);
        // Not an order of these words, which somebody would copy.
        Err(RequestError::value("response", message).such_as("categories", "LOWEST,…,HIGHEST").into())
    }

    /// Returns the options of the analysis.
    pub fn options(&self) -> Options {
        Options {
            terms: self.model.terms.clone(),
            covariates: self.covariate.clone().map(|list| list.0),
            link: self.model.link,
            random: self.random,
            max_coefficients: self.model.max_coefficients(),
            max_minutes: self.model.max_minutes(),
            slopes: self.model.slopes,
            resampling: self.resampling,
            ..Options::default()
        }
    }

    /// Analyzes the ratings. The watcher learns the number of simulated studies that are done, and of all.
    ///
    /// # Errors
    /// The requested model is impossible.
    pub fn analyze(&self, study: &Study, watcher: &dyn Watcher) -> Result<Results, RequestError> {
        let progress = |done: usize, all: usize| watcher.progress(done as u64, all as u64);
        let results = analyze_with(study.measured.clone(), &self.options(), &progress);
        match results.model.as_ref().err().and_then(refused) {
            Some(error) => Err(error),
            None => Ok(results),
        }
    }
}

/// Returns what is wrong with the requested model, if it is not the data.
pub(super) fn refused(error: &ModelError) -> Option<RequestError> {
    match error {
        ModelError::UnknownFactor { .. } | ModelError::NotANumber { .. } | ModelError::InfiniteDepth { .. } => {
            Some(RequestError::value("terms", error))
        }
        ModelError::TooManyCoefficients { .. } | ModelError::TooMuchWork { .. } => {
            Some(RequestError::new("terms", error).unless("large"))
        }
        ModelError::TooManySlopes { .. } => Some(RequestError::value("slopes", error)),
        _ => None,
    }
}
