//! `machband plan`

mod findings;

use std::{
    path::PathBuf,
    sync::atomic::{AtomicU64, Ordering},
};

use super::{Bar, OutPath, print_line};
use crate::{
    analysis::power::{ModelChoice, Plan, Power, Sampling, Shift, Slope},
    experiment::{OrderedLogit, Protocol},
    store::{Writer, definition, observer},
    text::names::expected_one_of,
    work::{Model, RequestError, Watcher as _},
};
use findings::Findings;

/// Find how many participants a study needs, by simulating its power.
///
/// Simulates studies with the ordered-logit observer of `simulate` and analyzes each as `analyze` would. For each
/// number of participants and each effect, reports the proportion of studies that find it, with its exact 95 % interval
/// (Clopper and Pearson). Two tests are used: the likelihood-ratio test of the term in the ordinal mixed model, and
/// Friedman's test of the participants' means. If an effect is absent, this proportion is reported as the false-alarm
/// rate.
#[derive(clap::Args)]
#[command(
    after_help = "Effects: NAME=VALUE sets a parameter of the observer: depth, fall, narrow, oblique, contrast, \
    infinite_as, strongest_width, subject_sd, lapse (see experiments/observers/paper.toml). FACTOR:LEVEL=LOGITS adds to \
    one level of any factor of the experiment.\n\n\
    --slope FACTOR=SD lets people differ in the effect of a factor: each deviates at each of its levels by an independent \
    normal value, as in R's (1 | subject:factor). The more they differ, the lower the power.\n\n\
    Below 12 participants, p values of the model come from simulated studies without the effect: as many as --studies, \
    but at least 199 and at most 999.\n\n\
    Results depend on the seed but not on the number of threads (ChaCha8, one stream per participant and study).\n\n\
    Examples:\n  machband plan orientation --participants 4,8,12 --effect oblique=0.5\n  \
    machband plan orientation --participants 12 --effect oblique=0.5 --slope orientation_deg=0.5\n  \
    machband plan shaders --participants 8 --effect shader:gouraud=1 --effect shader:flat=2"
)]
pub(super) struct Arguments {
    /// Built-in definition or path to a .toml file.
    experiment: PathBuf,
    /// Number of participants per study; give several numbers to compare them.
    #[arg(long, value_name = "N,…", required = true, value_delimiter = ',', value_parser = clap::value_parser!(u32).range(1..=10_000))]
    participants: Vec<u32>,
    /// An effect to find: NAME=VALUE or FACTOR:LEVEL=LOGITS; can be repeated.
    #[arg(long = "effect", value_name = "NAME=VALUE")]
    effects: Vec<String>,
    /// How much people differ in the effect of a factor, as the standard deviation in logits; can be repeated.
    #[arg(long = "slope", value_name = "FACTOR=SD")]
    deviations: Vec<String>,
    /// Number of studies to simulate for each number of participants.
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    studies: u32,
    /// Significance level: an effect is found if p is below it.
    #[arg(long, value_name = "P", default_value_t = 0.05, value_parser = proportion)]
    alpha: f64,
    /// Target power.
    #[arg(long, value_name = "P", default_value_t = 0.8, value_parser = proportion)]
    target: f64,
    /// Seed of the simulated ratings.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Parameters of the observer; experiments/observers/paper.toml has the documented defaults.
    #[arg(long, value_name = "FILE.toml")]
    observer_file: Option<PathBuf>,
    #[command(flatten)]
    model: Model,
    /// Where to write the table as CSV.
    #[arg(long, value_name = "FILE.csv")]
    out: Option<OutPath>,
}

pub(super) fn run(arguments: &Arguments, writer: &Writer) -> anyhow::Result<()> {
    let protocol = definition::open(&arguments.experiment)?;
    let (observer, name) = match &arguments.observer_file {
        Some(path) => (observer::open(path)?, path.display().to_string()),
        None => (observer::parse("paper.toml", observer::PAPER)?, "paper".to_owned()),
    };
    let (observer, shifts) = apply(observer, &arguments.effects, &protocol)?;
    let slopes = slopes(&arguments.deviations)?;
    let options = &arguments.model;
    let model =
        ModelChoice { terms: options.terms.clone(), link: options.link, slopes: options.slopes, large: options.large };
    let plan = Plan::new(&protocol, &observer, &shifts, &slopes, &model)
        .map_err(|error| RequestError::whole(error.to_string()))?;
    let sampling = Sampling { studies: arguments.studies, alpha: arguments.alpha, seed: arguments.seed };
    let mut participants = arguments.participants.clone();
    participants.sort_unstable();
    participants.dedup();
    let powers = simulate(&plan, &participants, &sampling);
    let findings = Findings {
        protocol: &protocol,
        observer: [vec![name], arguments.effects.clone()].concat().join(" "),
        plan: &plan,
        sampling,
        target: arguments.target,
        powers: &powers,
    };
    findings.lines().iter().try_for_each(|line| print_line(line))?;
    // Written last, so that no result is lost if the path cannot be written.
    if let Some(path) = &arguments.out {
        writer.write(path, &findings.csv())?;
    }
    Ok(())
}

/// Runs the studies. Progress is counted in participants, because the time per study is proportional to their number.
fn simulate(plan: &Plan, participants: &[u32], sampling: &Sampling) -> Vec<Power> {
    let bar = Bar::new("simulated participants");
    let (done, all) = (AtomicU64::new(0), plan.simulated(participants, sampling));
    let powers = plan.run(participants, sampling, &|people| {
        bar.progress(done.fetch_add(people, Ordering::Relaxed) + people, all);
    });
    bar.clear();
    powers
}

/// Parses a proportion between 0 and 1, exclusive.
fn proportion(text: &str) -> Result<f64, String> {
    let number = text.trim().parse::<f64>().ok().filter(|number| *number > 0.0 && *number < 1.0);
    number.ok_or_else(|| "expected a number between 0 and 1, such as 0.05".to_owned())
}

/// Largest number of logits that a level can add, or by which people can differ; far beyond the whole scale.
const MAX_LOGITS: f64 = 1000.0;

/// Parses the values of an option, each of the form NAME=VALUE with a different name.
fn assignments<'a>(option: &str, form: &str, texts: &'a [String]) -> Result<Vec<(&'a str, f64)>, RequestError> {
    let mut parsed: Vec<(&str, f64)> = Vec::new();
    for text in texts {
        let error = |message: String| RequestError::whole(format!("--{option} {text}: {message}"));
        let (name, value) = text.rsplit_once('=').ok_or_else(|| error(format!("contains no =; expected {form}")))?;
        let (name, number) = (name.trim(), value.trim().parse::<f64>().ok().filter(|value| value.is_finite()));
        let value =
            number.ok_or_else(|| error("the value is not a finite number; expected one such as 0.5".to_owned()))?;
        if parsed.iter().any(|(other, _)| *other == name) {
            return Err(error(format!("{name} is given twice; expected each {option} once")));
        }
        parsed.push((name, value));
    }
    Ok(parsed)
}

/// Parses how much people differ in the effects.
fn slopes(texts: &[String]) -> Result<Vec<Slope>, RequestError> {
    let slope = |(text, (factor, sd)): (&String, (&str, f64))| {
        if (0.0..=MAX_LOGITS).contains(&sd) {
            return Ok(Slope { factor: factor.to_owned(), sd });
        }
        Err(RequestError::whole(format!("--slope {text}: the value is out of range; expected 0…{MAX_LOGITS} logits")))
    };
    let parsed = assignments("slope", "FACTOR=SD, such as width=0.5", texts)?;
    texts.iter().zip(parsed).map(slope).collect()
}

/// Returns the observer with the requested effects, and the effects that none of its parameters can express.
fn apply(
    observer: OrderedLogit,
    effects: &[String],
    protocol: &Protocol,
) -> Result<(OrderedLogit, Vec<Shift>), RequestError> {
    let mut observer = observer;
    let mut shifts: Vec<Shift> = Vec::new();
    let form = "NAME=VALUE or FACTOR:LEVEL=LOGITS, such as oblique=0.5";
    for (effect, (name, value)) in effects.iter().zip(assignments("effect", form, effects)?) {
        let error = |message: &str| RequestError::whole(format!("--effect {effect}: {message}"));
        match name.split_once(':') {
            Some(_) if value.abs() > MAX_LOGITS => {
                return Err(error(&format!("the value is out of range; expected {}…{MAX_LOGITS} logits", -MAX_LOGITS)));
            }
            Some((factor, level)) => {
                shifts.push(Shift { factor: factor.trim().to_owned(), level: level.trim().to_owned(), logits: value })
            }
            None => observer = with(&observer, name, value, protocol).map_err(|message| error(&message))?,
        }
    }
    Ok((observer, shifts))
}

/// Returns the observer with a new value for one parameter, validated like an observer file.
fn with(observer: &OrderedLogit, name: &str, value: f64, protocol: &Protocol) -> Result<OrderedLogit, String> {
    let mut table = toml::Table::try_from(observer).map_err(|error| error.to_string())?;
    match table.get_mut(name) {
        Some(parameter) if parameter.is_float() => *parameter = value.into(),
        _ => return Err(unknown(name, &table, protocol)),
    }
    table.insert("schema".to_owned(), 1.into());
    observer::parse("--effect", &table.to_string())
        .map_err(|errors| errors.0.into_iter().map(|error| error.message).collect::<Vec<_>>().join("; "))
}

fn unknown(name: &str, table: &toml::Table, protocol: &Protocol) -> String {
    if let Some(factor) = protocol.factors.iter().find(|factor| factor.name == name) {
        let levels: Vec<String> = factor.levels.iter().map(ToString::to_string).collect();
        return format!(
            "{name} is a factor; expected {name}:LEVEL=LOGITS with one of the levels {}",
            levels.join(", ")
        );
    }
    let known: Vec<&str> = table.iter().filter(|(_, value)| value.is_float()).map(|(name, _)| name.as_str()).collect();
    let factors: Vec<&str> = protocol.factors.iter().map(|factor| factor.name.as_str()).collect();
    format!(
        "the observer has no such parameter; {}; or FACTOR:LEVEL with one of the factors {}",
        expected_one_of(name, &known),
        factors.join(", ")
    )
}
