//! The analysis of ratings: which are read, and the ordinal model that is fitted and that a plan simulates.

use std::{
    collections::{BTreeSet, HashSet},
    path::{Path, PathBuf},
};

use serde::Serialize;

use super::{RequestError, Study, Watcher, request::allow_only};
use crate::{
    analysis::{
        Link, MAX_COEFFICIENTS, ModelError, Options, Random, Resampling, Slopes, analyze_with,
        counts::{Counts, Exclusions},
        numbers_of,
        tasks::psychometric::{self, Guess},
        terms::{Terms, Variable},
    },
    experiment::task::{Common, Curve, Easier},
    report::{
        Analyzed,
        tasks::{self, Levels, TaskResults, TaskStudy},
    },
    store::{
        Columns, FileErrors, StoreError,
        answers::{self, AnswerColumns, AnswersRead},
        ratings::{ReadOptions, Source},
        table::List,
    },
    text::names::{expected_one_of, one_of},
};

/// The fields that apply to every task; the others are about ratings.
const OF_TASKS: [&str; 3] = ["paths", "exclude", "seed"];
/// Those that apply to a table of answers at levels.
const OF_LEVELS: [&str; 13] = [
    "paths", "exclude", "seed", "subject", "factors", "levels", "level", "correct", "total", "guess", "function",
    "easier", "log",
];

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
    #[arg(long, value_parser = one_of::<Random>(Random::NAMES))]
    pub random: Option<Random>,
    /// Numbers that describe participants: each has one slope in the model, and no levels [default: numbers that are the same
    /// in all ratings of each participant].
    #[arg(long, value_name = "COL,…")]
    pub covariate: Option<List>,
    /// Column that names the stimuli of which the study shows a sample, such as pictures: each has a random intercept, beside
    /// those of the participants, so that conclusions hold for other stimuli.
    #[arg(long, value_name = "COL")]
    pub items: Option<String>,
    #[command(flatten)]
    #[serde(flatten)]
    pub resampling: Resampling,
    #[command(flatten)]
    #[serde(flatten)]
    pub levels: AnswersAtLevels,
}

/// The ordinal model.
#[derive(Clone, Debug, Default, PartialEq, clap::Args, Serialize)]
pub struct Model {
    /// Terms of the model: names of factors. Prefix a numeric term with num:, and join the factors of an interaction
    /// with *, or with : beside its parts [default: every factor that varies].
    #[arg(long, value_name = "T,…")]
    pub terms: Option<Terms>,
    /// Link function of the cumulative model.
    #[arg(long, default_value_t, value_parser = one_of::<Link>(Link::NAMES))]
    pub link: Link,
    /// Random slopes: for each term that varies within participants, where the design supports it (independent), or
    /// with all their correlations (correlated).
    #[arg(long, default_value_t, value_parser = one_of::<Slopes>(Slopes::NAMES))]
    pub slopes: Slopes,
    /// Also analyze a study that is larger than usual: more than 10 factors, 120 levels of a factor, 5,000 conditions,
    /// 20,000 participants or 120 coefficients, or names of more than 200 bytes. The time grows with their square or cube.
    #[arg(long)]
    pub large: bool,
}

impl Model {
    /// Returns the options of an analysis with this model.
    pub fn options(&self) -> Options {
        let Self { terms, link, slopes, large } = self.clone();
        let max_coefficients = Some(if large { usize::MAX } else { MAX_COEFFICIENTS });
        Options { terms, link, slopes, max_coefficients, ..Options::default() }
    }
}

/// The columns of a table of answers at levels, from which thresholds are estimated.
#[derive(Clone, Debug, Default, PartialEq, clap::Args, Serialize)]
pub struct AnswersAtLevels {
    /// Column with the levels of a psychometric function: the table has answers at levels instead of ratings.
    #[arg(long, value_name = "COL", requires_all = ["correct", "guess"])]
    pub level: Option<String>,
    /// Column with the number of correct answers, or of yes answers; 1 or 0 if each row is one trial.
    #[arg(long, value_name = "COL", requires = "level")]
    pub correct: Option<String>,
    /// Column with the number of trials [default: each row is one trial].
    #[arg(long, value_name = "COL", requires = "level")]
    pub total: Option<String>,
    /// Probability of a correct answer by guessing, such as 0.5 for two alternatives; free to estimate it, as for yes answers.
    #[arg(long, value_name = "N|free", requires = "level")]
    pub guess: Option<Guess>,
    /// Shape of the psychometric function [default: normal].
    #[arg(long, requires = "level", value_parser = one_of::<Curve>(Curve::NAMES))]
    pub function: Option<Curve>,
    /// The end of the levels that is easier to see [default: high].
    #[arg(long, requires = "level", value_parser = one_of::<Easier>(Easier::NAMES))]
    pub easier: Option<Easier>,
    /// Fit the function to the base-10 logarithms of the levels.
    #[arg(long, requires = "level")]
    pub log: bool,
}

impl Analyze {
    /// Returns the names of the columns that the terms use as factors, and of their numbers, the covariates and the items.
    fn columns(&self, terms: Option<&Terms>) -> [Vec<String>; 2] {
        let terms = terms.into_iter().flat_map(Terms::iter);
        let (numbers, factors): (Vec<&Variable>, Vec<&Variable>) =
            terms.flat_map(|term| &term.variables).partition(|variable| matches!(variable, Variable::Number(_)));
        let roles = numbers.into_iter().map(Variable::name).chain(self.roles().map(|(_, name)| name.as_str()));
        [factors.into_iter().map(|factor| factor.name().to_owned()).collect(), roles.map(str::to_owned).collect()]
    }

    /// Returns the names of the covariates and the items, each with its option.
    fn roles(&self) -> impl Iterator<Item = (&'static str, &String)> {
        let covariates = self.covariate.iter().flat_map(|list| &list.0).map(|name| ("covariate", name));
        covariates.chain(self.items.iter().map(|name| ("items", name)))
    }

    /// Reads the ratings, also if the order of their categories is not known.
    ///
    /// # Errors
    /// There is nothing to analyze, or the study is too large.
    pub fn read_unordered(&self) -> anyhow::Result<Study> {
        self.ratings.read(self.columns(self.model.terms.as_ref()), true, self.model.large)
    }

    /// Reads the ratings.
    ///
    /// # Errors
    /// There is nothing to analyze, the study is too large, or the order of its categories is not known.
    pub fn read(&self) -> anyhow::Result<Study> {
        let study = self.read_unordered()?;
        study.check_order(false)?;
        Ok(study)
    }

    /// Takes the ratings from a table in memory instead of files; `name` stands for it in messages.
    ///
    /// # Errors
    /// The same errors as [`Analyze::read`].
    pub fn read_columns(&self, name: &str, columns: Columns) -> anyhow::Result<Study> {
        let how = self.ratings.options(self.columns(self.model.terms.as_ref()), true, self.model.large);
        let study = Study::from_columns(name, columns, &how)?;
        study.check_order(false)?;
        Ok(study)
    }

    /// Reads the answers to a task, if the sessions have a task other than a rating.
    ///
    /// # Errors
    /// The sessions cannot be read, they have different definitions, or an option applies to ratings only.
    pub fn read_task(&self) -> anyhow::Result<Option<TaskStudy>> {
        let paths = &self.ratings.paths;
        if self.levels.level.is_some() {
            let [path] = &paths[..] else {
                return Err(RequestError::whole("several files have answers at levels; expected one table").into());
            };
            return Ok(Some(self.answers(path, |columns| answers::read(path, columns))?));
        }
        let Some((_, task)) = TaskStudy::task_at(paths)? else { return Ok(None) };
        let message = format!("does not apply to {}; expected only --exclude and --seed", tasks::answers(&task));
        allow_only(self, &OF_TASKS, &message)?;
        let exclude = self.ratings.how.exclude.clone().unwrap_or_default().0;
        Ok(Some(without(TaskStudy::read(paths, &exclude)?, &exclude, &paths[0])?))
    }

    /// Takes answers at levels from a table in memory, if the fields say that it has them; `name` stands for it in messages.
    /// Rows with an unexpected value are left out and told.
    ///
    /// # Errors
    /// A column is missing, every row has an unexpected value, or an option applies to ratings only.
    pub fn answers_in(&self, name: &str, table: &Columns) -> anyhow::Result<Option<TaskStudy>> {
        let read = |columns: &AnswerColumns| answers::of_columns(name, table, columns);
        self.levels.level.is_some().then(|| self.answers(Path::new(name), read)).transpose()
    }

    /// Analyzes the rows that `read` returns for the columns of answers.
    fn answers(
        &self,
        path: &Path,
        read: impl FnOnce(&AnswerColumns) -> Result<AnswersRead, StoreError>,
    ) -> anyhow::Result<TaskStudy> {
        let message = "does not apply to answers at levels; expected only --subject, --factors, --levels, --exclude, --seed \
                       and the options of answers, such as --guess";
        allow_only(self, &OF_LEVELS, message)?;
        let given = self.levels.clone();
        if given.function == Some(Curve::Weibull) && !given.log {
            let message = "weibull: uses logarithms of the level; expected logistic or normal";
            return Err(RequestError::value("function", message).unless("log").into());
        }
        let factors = self.ratings.how.factors.clone().unwrap_or_default().0;
        let columns = AnswerColumns {
            level: given.level.unwrap_or_default(),
            correct: given.correct.unwrap_or_default(),
            total: given.total,
            subject: self.ratings.how.subject.clone(),
            factors: factors.clone(),
        };
        let AnswersRead { mut rows, notes, errors } = read(&columns)?;
        let exclude = self.ratings.how.exclude.clone().unwrap_or_default().0;
        let mut excluded = exclude.clone();
        excluded.retain(|id| rows.iter().any(|row| row.subject == *id));
        rows.retain(|row| !exclude.contains(&row.subject));
        let common = Common {
            parameter: columns.level,
            log: given.log,
            easier: given.easier.unwrap_or(Easier::High),
            ..Common::default()
        };
        let range = [f64::min, f64::max].map(|end| rows.iter().map(|row| row.level).fold(f64::NAN, end));
        if given.log && range[0] <= 0.0 {
            let message = format!("a level is {}; expected levels above 0 for a logarithmic scale", range[0]);
            return Err(RequestError::new("log", message).into());
        }
        let model = psychometric::Model {
            curve: given.function.unwrap_or(Curve::Normal),
            guess: given.guess.unwrap_or(Guess::Free),
            falls: common.easier == Easier::Low,
            // Blocks can vary more than binomially; single trials say nothing about it.
            overdispersed: columns.total.is_some(),
            // Each person's levels in a condition say in which range the priors place a threshold, as in psignifit.
            range: None,
        };
        for (factor, levels) in &self.ratings.how.levels {
            let place = factors.iter().position(|name| name == factor);
            let known: BTreeSet<&str> =
                place.into_iter().flat_map(|place| rows.iter().map(move |row| &*row.factors[place])).collect();
            if let Some(level) = levels.iter().find(|level| !known.contains(level.as_str())) {
                let known: Vec<&str> = known.into_iter().collect();
                let message = format!("{level} is not a level of {factor}; {}", expected_one_of(level, &known));
                return Err(RequestError::value("levels", message).into());
            }
        }
        let order = |factor: String| {
            let known = self.ratings.how.levels.iter().chain(&self.ratings.how.orders).find(|one| one.0 == factor);
            let levels = known.map_or_else(Vec::new, |one| one.1.clone());
            (factor, levels)
        };
        let factors = factors.into_iter().map(order).collect();
        let study = TaskStudy::of_answers(path, &rows, factors, Levels { common, range, model });
        let study = TaskStudy { excluded, errors, warnings: notes, ..study };
        without(study, &exclude, path)
    }

    /// Returns the options of the analysis of ratings from this source.
    pub fn options(&self, source: &Source) -> Options {
        Options {
            covariates: self.covariate.clone().map(|list| list.0),
            items: self.items.clone(),
            random: self.random,
            resampling: self.resampling,
            parameters: source.parameters(),
            ..self.model.options()
        }
    }

    /// Checks that the columns with a role are there and suit it, that no term determines another one, and that each trial has
    /// a place of its own.
    ///
    /// # Errors
    /// Says which field is wrong.
    pub fn check(&self, study: &Study) -> Result<(), RequestError> {
        let counts = &study.measured.counts;
        if let Some((option, name)) = self.roles().find(|(_, name)| counts.factor(name).is_none()) {
            let names: Vec<&str> = counts.factors.iter().map(|factor| factor.name.as_str()).collect();
            return Err(RequestError::value(option, format!("{name}: {}", expected_one_of(name, &names))));
        }
        self.check_factors(counts)?;
        if self.random == Some(Random::None) && self.model.slopes == Slopes::Correlated {
            let message = "correlated: the model has no random effects; expected independent or none";
            return Err(RequestError::value("slopes", message));
        }
        let terms = self.options(&study.source).terms(counts);
        let [factors, numbers] = self.columns(terms.as_ref());
        let is_both = |name: &&String| numbers.contains(name) && self.items.as_ref() != Some(name);
        let both = |name: &String| format!("{name} is both a factor and a number; expected only one of them");
        let twice = factors.iter().find(is_both).map(both);
        if let Some(message) = twice.or_else(|| determined(counts, [factors, numbers])) {
            return Err(RequestError::value("terms", message));
        }
        let Some(order) = &self.ratings.how.order else { return Ok(()) };
        let mut known = HashSet::new();
        let placed = study.measured.trials.iter().filter_map(|trial| Some((trial, trial.position?)));
        for (trial, place) in placed {
            if !known.insert((trial.subject, trial.session, place.to_bits())) {
                let who = &counts.subjects[trial.subject as usize];
                let message = format!("{order}: several ratings by {who} have the place {place}; expected one");
                return Err(RequestError::value("order", message));
            }
        }
        Ok(())
    }

    /// Checks the options about factors.
    fn check_factors(&self, counts: &Counts) -> Result<(), RequestError> {
        let lists = |list: &Option<List>| list.iter().flat_map(|list| list.0.clone()).collect::<Vec<String>>();
        if let Some(items) = &self.items {
            if lists(&self.ratings.how.factors).contains(items) {
                let message = format!("{items}: is also a factor; expected a column that is not one");
                return Err(RequestError::value("items", message));
            }
            if counts.factors.len() == 1 {
                let message = format!("{items}: no factors were given; expected factors or terms beside the items");
                return Err(RequestError::value("items", message));
            }
        }
        let is_words = |name: &String| counts.factor(name).is_some_and(|(_, own)| numbers_of(&own.levels).is_none());
        for (option, names) in [("covariate", &self.covariate), ("direction", &self.ratings.how.direction)] {
            if let Some(name) = lists(names).into_iter().find(is_words) {
                let message = format!("{name}: has levels that are not numbers; expected numbers");
                return Err(RequestError::value(option, message));
            }
        }
        Ok(())
    }

    /// Reads and analyzes ratings, or the answers to another task.
    ///
    /// # Errors
    /// The same errors as [`Analyze::read_task`], [`Analyze::read`] and [`Analyze::analyze`].
    pub fn run(&self, watcher: &dyn Watcher) -> anyhow::Result<Analyzed> {
        if let Some(study) = self.read_task()? {
            watcher.stage("analyzing");
            return Ok(self.analyze_task(study));
        }
        let study = self.read()?;
        watcher.stage("analyzing");
        Ok(self.analyze(study, watcher)?)
    }

    /// Analyzes the ratings. The watcher learns the number of simulated studies that are done, and of all.
    ///
    /// # Errors
    /// The requested model is impossible.
    pub fn analyze(&self, study: Study, watcher: &dyn Watcher) -> Result<Analyzed, RequestError> {
        self.check(&study)?;
        let progress = |done: usize, all: usize| watcher.progress(done as u64, all as u64);
        let Study { source, measured } = study;
        let results = analyze_with(measured, &self.options(&source), &progress);
        match results.model.as_ref().err().and_then(refused) {
            Some(error) => Err(error),
            None => Ok(Analyzed::Ratings(source.into(), results.into())),
        }
    }

    /// Analyzes the answers to a task.
    pub fn analyze_task(&self, study: TaskStudy) -> Analyzed {
        let results = TaskResults::of(&study, self.resampling.seed);
        Analyzed::Task(study.into(), results.into())
    }
}

/// Checks that everyone to exclude was there, and that answers of others are left.
fn without(study: TaskStudy, exclude: &[String], path: &Path) -> anyhow::Result<TaskStudy> {
    if let Some(unknown) = exclude.iter().find(|id| !study.excluded.contains(id)) {
        let known = [&study.people[..], &study.excluded].concat();
        let message = format!("{unknown} is not a participant; {}", expected_one_of(unknown, &known));
        return Err(RequestError::new("exclude", message).into());
    }
    if study.answers() == 0 {
        let message = "has no answers to analyze; expected at least one";
        return Err(StoreError::from(FileErrors::whole(path, message)).into());
    }
    Ok(study)
}

/// Says which of these factors determines another one, or a number, so that their effects cannot be told apart.
fn determined(counts: &Counts, names: [Vec<String>; 2]) -> Option<String> {
    let [factors, numbers] =
        names.map(|names| names.iter().filter_map(|name| Some(counts.factor(name)?.0)).collect::<Vec<usize>>());
    let mut pairs = factors.iter().flat_map(|own| factors.iter().chain(&numbers).map(move |other| (*own, *other)));
    let (own, other) = pairs.find(|(own, other)| counts.determines(*own, *other))?;
    let [one, two] = [own, other].map(|factor| &counts.factors[factor].name);
    Some(format!(
        "{one} determines {two}: each level of {one} occurs with one level of {two}{}, so their effects cannot be told apart; \
         expected only one of them",
        if counts.determines(other, own) { ", and the reverse" } else { "" }
    ))
}

/// Returns what is wrong with the requested model, if it is not the data.
pub(super) fn refused(error: &ModelError) -> Option<RequestError> {
    match error {
        ModelError::UnknownFactor { .. } | ModelError::NotANumber { .. } | ModelError::InfiniteDepth { .. } => {
            Some(RequestError::value("terms", error))
        }
        ModelError::TooManyCoefficients { .. } => Some(RequestError::new("terms", error).unless("large")),
        ModelError::Items { .. } => Some(RequestError::value("items", error)),
        ModelError::TooManySlopes { .. } => Some(RequestError::value("slopes", error)),
        _ => None,
    }
}

/// Where to find the ratings, and how to read them.
#[derive(Clone, Debug, Default, PartialEq, clap::Args, Serialize)]
pub struct Ratings {
    /// Result files, folders of result files, tables of counts, or any table (CSV or Excel).
    #[arg(required = true, value_name = "FILE|DIR")]
    pub paths: Vec<PathBuf>,
    #[command(flatten)]
    #[serde(flatten)]
    pub how: ReadOptions,
}

impl Ratings {
    /// Returns the same ratings without what is to be excluded.
    #[must_use]
    pub fn excluding(mut self, Exclusions { exclude, only }: Exclusions) -> Self {
        (self.how.exclude, self.how.only) = ((!exclude.is_empty()).then_some(List(exclude)), only);
        self
    }

    /// Reads the files; `also` names additional columns that a model needs: those of its terms, and of covariates and items.
    ///
    /// # Errors
    /// No file can be read, or an exclusion is not possible.
    pub fn read(&self, also: [Vec<String>; 2], details: bool, large: bool) -> anyhow::Result<Study> {
        if let Some((path, task)) = TaskStudy::task_at(&self.paths)? {
            let answers = tasks::answers(&task);
            let message =
                format!("has {answers}; expected ratings on a scale of categories (machband analyze reads every task)");
            return Err(FileErrors::whole(&path, message).into());
        }
        Study::read(&self.paths, &self.options(also, details, large))
    }

    /// Returns how the ratings are read.
    fn options(&self, [also, roles]: [Vec<String>; 2], details: bool, unlimited: bool) -> ReadOptions {
        ReadOptions { also, roles, details, unlimited, ..self.how.clone() }
    }
}
