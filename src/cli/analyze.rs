//! `machband analyze`

use std::{ffi::OsString, time::Duration};

use super::{
    OutPath, UsageError,
    options::{ModelOptions, named},
    ratings::RatingOptions,
};
use crate::{
    analysis::{ModelError, Options, Random, Resampling, Results, analyze_with},
    report::{
        AnalysisOutput, Provenance, Study, check_folder,
        prediction::{PredictionError, StudyPrediction},
        skins,
        study::{Parts, document, shell_command},
        write_all,
    },
    store::{Writer, table},
    system::now,
};

/// What to analyze, and how.
#[derive(clap::Args)]
pub struct AnalysisOptions {
    #[command(flatten)]
    ratings: RatingOptions,
    #[command(flatten)]
    model: ModelOptions,
    /// Random intercept for each participant [default: subject if there are at least two participants].
    #[arg(long, value_parser = named::<Random>(Random::NAMES))]
    random: Option<Random>,
    /// Seed of the simulated studies that calibrate tests and intervals.
    #[arg(long, value_name = "N", default_value_t = Resampling::default().seed)]
    seed: u64,
    /// Number of simulated studies; an analysis of many ratings uses at most 199.
    #[arg(long, value_name = "N", default_value_t = Resampling::default().draws, value_parser = clap::value_parser!(u32).range(19..=1_000_000))]
    draws: u32,
}

/// Analyze ratings: descriptive statistics, ordinal model, tests, figures and a report.
///
/// Reads result files, folders of result files, tables of counts, or any CSV file with column names. If part of the
/// input has errors, every error is reported, the rest is analyzed, and the exit status is 1. Files that were changed
/// after their session ended are analyzed with a warning.
#[derive(clap::Args)]
#[command(after_help = "Examples: machband analyze results/bangay2003 --out analysis\n          \
    machband analyze ratings.csv --subject id --response score --terms width,num:inv_n --out analysis")]
pub(super) struct Arguments {
    #[command(flatten)]
    analysis: AnalysisOptions,
    /// Folder for tables, figures and report.html; --force replaces an earlier analysis.
    #[arg(long, value_name = "DIR", value_hint = clap::ValueHint::DirPath)]
    out: OutPath,
    /// Write only the tables and model.json.
    #[arg(long)]
    tables_only: bool,
}

impl AnalysisOptions {
    /// Reads the ratings.
    ///
    /// # Errors
    /// There is nothing to analyze, the study is too large, or the order of its categories is not known.
    pub fn read(&self) -> anyhow::Result<Study> {
        let terms = self.model.terms()?;
        let names = terms.iter().flatten().flat_map(|term| &term.variables).map(|variable| variable.name().to_owned());
        let study = self.ratings.read(&names.collect::<Vec<_>>(), true, self.model.large)?;
        let counts = &study.measured.counts;
        if !counts.is_ordered(study.source.shape.categories.as_deref()) {
            let texts = table::list(counts.categories.iter().take(12));
            let message = format!(
                "--response {}: {texts} are not numbers; expected their order, lowest first, such as --categories {}",
                study.source.shape.response,
                shlex::try_quote(&texts).unwrap_or_default()
            );
            return Err(UsageError(message).into());
        }
        Ok(study)
    }

    /// Analyzes the ratings; `progress` learns the number of simulated studies that are done, and of all.
    ///
    /// # Errors
    /// The requested model is impossible.
    pub fn analyze(&self, study: &Study, progress: &(dyn Fn(usize, usize) + Sync)) -> anyhow::Result<Results> {
        let options = Options {
            terms: self.model.terms()?,
            link: self.model.link,
            random: self.random,
            max_coefficients: self.model.max_coefficients(),
            slopes: self.model.slopes,
            resampling: Resampling { draws: self.draws, seed: self.seed },
            checks: true,
        };
        let results = analyze_with(study.measured.clone(), &options, progress);
        match &results.model {
            Err(error) if is_usage(error) => Err(UsageError(error.to_string()).into()),
            _ => Ok(results),
        }
    }
}

pub(super) fn run(arguments: &Arguments, words: &[OsString], writer: &Writer) -> anyhow::Result<()> {
    check_folder(writer, &arguments.out)?;
    let progress = super::spinner("reading");
    let study = arguments.analysis.read()?;
    progress.set_message("analyzing");
    let results = arguments.analysis.analyze(&study, &|done, all| {
        progress.set_message(format!("analyzing: simulated study {done} of {all}"));
    })?;
    progress.set_message(if arguments.tables_only { "writing" } else { "predicting, drawing and writing" });
    let words = words.iter().skip(1).map(|word| word.to_string_lossy().into_owned());
    let provenance = Provenance::new(shell_command(words), now());
    let AnalysisOutput { files, prediction } =
        write_all(writer, &study, &results, &provenance, &arguments.out, arguments.tables_only)?;
    progress.finish_and_clear();
    super::print_line(&super::ratings::sentence(&study.source, &results.measured.counts))?;
    let document = document(&study.source, &results, Parts::default());
    for line in document.sections.first().iter().flat_map(|summary| skins::terminal(summary)) {
        super::print_line(&line)?;
    }
    if let Ok(report) = &results.model {
        let terms = results.spec.terms.to_string();
        let terms = if terms.is_empty() { "without terms" } else { &terms };
        let model = &report.model;
        super::print_line(&format!(
            "model {terms} ({} {}): log-likelihood {:.3}",
            model.link, model.method, model.loglik
        ))?;
    }
    if let Some((predicted, took)) = &prediction {
        super::print_line(&prediction_line(predicted, *took))?;
    }
    let report = files.iter().find(|file| file.extension().is_some_and(|extension| extension == "html"));
    let place = report.map_or(&*arguments.out, |report| report);
    super::print_line(&format!("{} files written; see {}", files.len(), place.display()))?;
    super::ratings::problems(&study.source)
}

/// True if the error is in the requested model and not in the data.
fn is_usage(error: &ModelError) -> bool {
    matches!(
        error,
        ModelError::UnknownFactor { .. }
            | ModelError::NotANumber { .. }
            | ModelError::InfiniteDepth { .. }
            | ModelError::TooManyCoefficients { .. }
            | ModelError::TooManySlopes { .. }
    )
}

/// Summarizes the vision model's prediction in one line.
fn prediction_line(predicted: &Result<StudyPrediction, PredictionError>, took: Duration) -> String {
    match predicted {
        Ok(StudyPrediction { comparison, .. }) => format!(
            "vision model: rank correlation {} with the mean ratings of {} conditions ({:.1} s)",
            comparison.rank_correlation.map_or_else(|| "—".to_owned(), |rho| format!("{rho:.3}")),
            comparison.conditions,
            took.as_secs_f64()
        ),
        Err(error) => format!("no prediction by the vision model: {error}"),
    }
}
