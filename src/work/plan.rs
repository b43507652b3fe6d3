//! How many participants and trials a study needs, whatever its task.

use std::{
    fmt,
    path::PathBuf,
    str::FromStr,
    sync::atomic::{AtomicU64, Ordering},
};

use serde::Serialize;

pub use super::precision::{Precision, Quantity, TaskObserver, TaskPlan};
use super::{Model, RequestError, Watcher, analyze, request::allow_only};
use crate::{
    analysis::power::{self, Hypothesis, PlanError, Power, Sampling, Shift, Slope},
    experiment::{
        Definition, Identity, ObserverParameters as _, OrderedLogit, Protocol, Schedule,
        task::{Pairs, Task},
    },
    report::{
        tables::Rows,
        tasks::{Estimand, answers},
    },
    store::{definition, observer},
    text::{
        Table,
        names::{expected_one_of, serde_as_text},
        number::whole,
    },
};

/// The study to plan, the effects to find, and the model that finds them.
#[derive(Clone, Debug, PartialEq, clap::Args, Serialize)]
pub struct Plan {
    /// Built-in definition or path to a .toml file.
    pub experiment: PathBuf,
    /// Number of participants per study; give several numbers to compare them.
    #[arg(long, value_name = "N,…", required = true, value_delimiter = ',', value_parser = whole::<u32>(1..=10_000))]
    pub participants: Vec<u32>,
    /// An effect to find: NAME=VALUE or FACTOR:LEVEL=SHIFT; can be repeated.
    #[arg(long = "effect", value_name = "NAME=VALUE", value_parser = effect)]
    pub effects: Vec<Assignment>,
    /// How much people differ in the effect of a factor, as the standard deviation in logits or, for tasks other than
    /// ratings, in the unit of shifts; can be repeated.
    #[arg(long = "slope", value_name = "FACTOR=SD", value_parser = deviation)]
    pub deviations: Vec<Assignment>,
    /// Number of studies to simulate for each number of participants.
    #[arg(long, value_name = "N", default_value_t = Sampling::default().studies, value_parser = whole::<u32>(1..=100_000))]
    pub studies: u32,
    /// Significance level: an effect is found if p is below it.
    #[arg(long, value_name = "P", default_value_t = Sampling::default().alpha, value_parser = proportion)]
    pub alpha: f64,
    /// Target power.
    #[arg(long, value_name = "P", default_value_t = 0.8, value_parser = proportion)]
    pub target: f64,
    /// Number of trials of each condition or pair, or of all adaptive pairs, of a task other than a rating; give several
    /// numbers to compare them [default: that of the definition].
    #[arg(long, value_name = "N,…", value_delimiter = ',', value_parser = whole::<u32>(1..=10_000))]
    pub trials: Vec<u32>,
    /// Seed of the simulated ratings.
    #[arg(long, value_name = "N", default_value_t = Sampling::default().seed, value_parser = whole(0..=u64::MAX))]
    pub seed: u64,
    /// Parameters of the observer; experiments/observers/paper.toml has the documented defaults.
    #[arg(long, value_name = "FILE.toml")]
    pub observer_file: Option<PathBuf>,
    #[command(flatten)]
    #[serde(flatten)]
    pub model: Model,
}

/// The options that give effects and deviations, for the sentences about a plan.
pub const OPTIONS: [&str; 2] = ["--effect", "--slope"];

/// A value for something that has a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Assignment {
    pub name: String,
    /// Finite.
    pub value: f64,
}

impl fmt::Display for Assignment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={}", self.name, self.value)
    }
}

impl FromStr for Assignment {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, value) = text.rsplit_once('=').ok_or("contains no =")?;
        let value = value.trim().parse::<f64>().ok().filter(|value| value.is_finite());
        let value = value.ok_or("the value is not a finite number")?;
        Ok(Self { name: name.trim().to_owned(), value })
    }
}

serde_as_text!(Assignment);

/// The most that a level can add, or by which people can differ; far beyond the whole scale.
const MAX_SHIFT: f64 = 1000.0;

/// Parses an effect.
fn effect(text: &str) -> Result<Assignment, String> {
    const FORM: &str = "expected NAME=VALUE or FACTOR:LEVEL=SHIFT, such as oblique=0.5";
    let effect: Assignment = text.parse().map_err(|error| format!("{error}; {FORM}"))?;
    if effect.name.contains(':') && effect.value.abs() > MAX_SHIFT {
        return Err(format!("the value is out of range; expected {}…{MAX_SHIFT}", -MAX_SHIFT));
    }
    Ok(effect)
}

/// Parses how much people differ in the effect of a factor.
fn deviation(text: &str) -> Result<Assignment, String> {
    let deviation: Assignment =
        text.parse().map_err(|error| format!("{error}; expected FACTOR=SD, such as width=0.5"))?;
    if (0.0..=MAX_SHIFT).contains(&deviation.value) {
        return Ok(deviation);
    }
    Err(format!("the value is out of range; expected 0…{MAX_SHIFT}"))
}

/// Parses a proportion between 0 and 1, exclusive.
fn proportion(text: &str) -> Result<f64, String> {
    let number = text.trim().parse::<f64>().ok().filter(|number| *number > 0.0 && *number < 1.0);
    number.ok_or_else(|| "expected a number between 0 and 1".to_owned())
}

/// The simulated powers of a plan, and the settings they depend on.
#[derive(Clone, Debug)]
pub struct Planned {
    pub protocol: Protocol,
    /// The observer and the effects given for it, such as `paper oblique=0.3`.
    pub observer: String,
    pub plan: power::Plan,
    pub sampling: Sampling,
    /// Target power.
    pub target: f64,
    /// Powers, in the order of the plan.
    pub powers: Vec<Power>,
}

/// The fields that apply to tasks other than ratings.
const OF_TASKS: [&str; 7] = ["experiment", "participants", "effects", "deviations", "studies", "seed", "trials"];

/// The simulated precision of a plan, and the settings on which it depends.
#[derive(Clone, Debug)]
pub struct PlannedTask {
    /// The plan with the first number of trials.
    pub plan: TaskPlan,
    pub sampling: Sampling,
    /// For each number of trials and of participants, each quantity.
    pub found: Vec<Precision>,
}

/// What a plan found.
pub enum Found {
    /// The power of a study of ratings.
    Ratings(Box<Planned>),
    /// The precision of a study of another task.
    Task(Box<PlannedTask>),
}

impl Found {
    /// Returns the table that a CSV file has.
    pub fn table(&self) -> Table {
        match self {
            Self::Ratings(planned) => planned.table(),
            Self::Task(planned) => planned.table(),
        }
    }
}

impl Plan {
    /// Simulates the studies. Progress is counted in participants, because the time per study is proportional to their
    /// number.
    ///
    /// # Errors
    /// A file cannot be read, an effect or a term does not exist, there is nothing to test, or the study is too large.
    pub fn plan(&self, watcher: &dyn Watcher) -> anyhow::Result<Found> {
        let protocol = definition::open(&self.experiment)?;
        for (field, given) in [("effects", &self.effects), ("deviations", &self.deviations)] {
            let is_known = |i: usize| given[..i].iter().any(|other| other.name == given[i].name);
            if let Some(i) = (0..given.len()).find(|i| is_known(*i)) {
                let message = format!("{}: {} is given twice; expected it once", given[i], given[i].name);
                return Err(RequestError::value(field, message).into());
            }
        }
        if !protocol.task.is_default() {
            return Ok(Found::Task(Box::new(self.task(protocol, watcher)?)));
        }
        if !self.trials.is_empty() {
            let message = "does not apply to ratings; expected another task";
            return Err(RequestError::new("trials", message).into());
        }
        Ok(Found::Ratings(Box::new(self.ratings(protocol, watcher)?)))
    }

    /// Simulates studies of a task other than a rating on categories.
    fn task(&self, protocol: Protocol, watcher: &dyn Watcher) -> anyhow::Result<PlannedTask> {
        let message = format!("does not apply to {}; expected a definition of ratings", answers(&protocol.task));
        allow_only(self, &OF_TASKS, &message)?;
        // What prevents one schedule prevents all.
        Schedule::new(&protocol, &Identity::new("S00000", "1").map_err(anyhow::Error::msg)?, self.seed)?;
        // A difference is found by its corrected p, as in an analysis.
        let sampling = Sampling { studies: self.studies, seed: self.seed, ..Sampling::default() };
        let ((shifts, parameters), slopes) = (self.given(), self.slopes());
        let plan = |protocol: &Protocol| {
            let set = |observer: &mut TaskObserver| {
                parameters.iter().try_for_each(|effect| set(effect, &mut observer.parameters(), protocol))
            };
            TaskPlan::new(protocol, &shifts, &slopes, set)
        };
        let mut plans = self.with_trials(&protocol)?.iter().map(plan).collect::<Result<Vec<_>, _>>()?;
        let participants = in_order(&self.participants);
        let all = participants.iter().map(|people| u64::from(*people)).sum::<u64>() * u64::from(self.studies);
        let progress = progress(watcher, all * plans.len() as u64);
        let sizes = plans.iter().flat_map(|plan| participants.iter().map(move |people| (plan, *people)));
        let found = sizes.map(|(plan, people)| plan.run(people, &sampling, &progress));
        let found = found.collect::<Result<Vec<_>, _>>()?.concat();
        Ok(PlannedTask { plan: plans.swap_remove(0), sampling, found })
    }

    /// Returns the definition with each number of trials.
    fn with_trials(&self, protocol: &Protocol) -> Result<Vec<Protocol>, RequestError> {
        if self.trials.is_empty() {
            return Ok(vec![protocol.clone()]);
        }
        let with = |trials: u32| {
            let set = |definition: &mut Definition| match (&mut definition.adaptive, &mut definition.task) {
                (Some(adaptive), _) => adaptive.common.trials = trials,
                (None, Task::Pair(pair)) if pair.pairs == Pairs::Adaptive => pair.trials = Some(trials),
                _ => definition.design.repetitions = trials,
            };
            protocol.with(set).map_err(|errors| {
                let message = errors.into_iter().next().map_or_else(String::new, |error| error.message);
                RequestError::value("trials", message.strip_prefix("trials ").unwrap_or(&message))
            })
        };
        in_order(&self.trials).into_iter().map(with).collect()
    }

    /// Simulates studies of ratings.
    fn ratings(&self, protocol: Protocol, watcher: &dyn Watcher) -> anyhow::Result<Planned> {
        let mut observer: OrderedLogit =
            self.observer_file.as_deref().map(observer::open).transpose()?.unwrap_or_default();
        let name = self.observer_file.as_ref().map_or_else(|| "paper".to_owned(), |path| path.display().to_string());
        let (shifts, parameters) = self.given();
        for effect in parameters {
            set(effect, &mut observer.parameters(), &protocol)?;
        }
        let model = self.model.options();
        let plan =
            power::Plan::new(&protocol, &observer, &shifts, &self.slopes(), &model).map_err(RequestError::from)?;
        let sampling = Sampling { studies: self.studies, alpha: self.alpha, seed: self.seed };
        let participants = in_order(&self.participants);
        let all = plan.simulated(&participants, &sampling);
        let powers = plan.run(&participants, &sampling, &progress(watcher, all));
        let given = self.effects.iter().map(ToString::to_string);
        let observer = std::iter::once(name).chain(given).collect::<Vec<_>>().join(" ");
        Ok(Planned { protocol, observer, plan, sampling, target: self.target, powers })
    }

    /// Returns how much people differ in effects.
    fn slopes(&self) -> Vec<Slope> {
        let slope = |given: &Assignment| Slope { factor: given.name.clone(), sd: given.value };
        self.deviations.iter().map(slope).collect()
    }

    /// Returns the effects of levels of factors, and those that set parameters of the observer.
    fn given(&self) -> (Vec<Shift>, Vec<&Assignment>) {
        let shift = |effect: &Assignment| {
            let (factor, level) = effect.name.split_once(':')?;
            Some(Shift { factor: factor.trim().to_owned(), level: level.trim().to_owned(), size: effect.value })
        };
        let parameters = self.effects.iter().filter(|effect| !effect.name.contains(':')).collect();
        (self.effects.iter().filter_map(shift).collect(), parameters)
    }
}

/// Returns the numbers in ascending order, each once.
fn in_order(numbers: &[u32]) -> Vec<u32> {
    let mut numbers = numbers.to_vec();
    numbers.sort_unstable();
    numbers.dedup();
    numbers
}

/// Counts simulated participants.
fn progress(watcher: &dyn Watcher, all: u64) -> impl Fn(u64) + Sync {
    let done = AtomicU64::new(0);
    move |people| watcher.progress(done.fetch_add(people, Ordering::Relaxed) + people, all)
}

impl From<PlanError> for RequestError {
    fn from(error: PlanError) -> Self {
        match &error {
            PlanError::Model(of_model) => analyze::refused(of_model).unwrap_or_else(|| Self::whole(&error)),
            PlanError::UnknownFactor { is_slope: true, .. } => Self::value("deviations", &error),
            PlanError::UnknownFactor { .. } | PlanError::UnknownLevel { .. } => Self::value("effects", &error),
            PlanError::Untestable { .. } => Self::value("terms", &error),
            PlanError::TooLarge(_) => Self::whole(&error).unless("large"),
            PlanError::NothingVaries => Self::whole(&error),
        }
    }
}

/// Sets the parameter of an observer that an effect names.
fn set(
    effect: &Assignment,
    parameters: &mut [(&str, &mut f64, [f64; 2])],
    protocol: &Protocol,
) -> Result<(), RequestError> {
    let Assignment { name, value } = effect;
    let known: Vec<&str> = parameters.iter().map(|(name, ..)| *name).collect();
    let message = match parameters.iter_mut().find(|(known, ..)| known == name) {
        Some((_, parameter, [least, most])) if (*least..=*most).contains(value) => {
            **parameter = *value;
            return Ok(());
        }
        Some((.., [least, most])) => {
            format!("{name} {value} is outside {least}…{most}; expected a number in this range")
        }
        None => {
            let factors: Vec<&str> = protocol.factors.iter().map(|factor| factor.name.as_str()).collect();
            let (expected, factors) = (expected_one_of(name, &known), factors.join(", "));
            format!("the observer has no such parameter; {expected}; or FACTOR:LEVEL with one of the factors {factors}")
        }
    };
    Err(RequestError::value("effects", format!("{effect}: {message}")))
}

impl Planned {
    /// Returns what a power is the power of.
    pub fn hypothesis(&self, power: &Power) -> &Hypothesis {
        &self.plan.hypotheses[power.hypothesis]
    }

    /// Returns one row for each number of participants and each test.
    pub fn table(&self) -> Table {
        let spec = &self.plan.spec;
        let slopes = self.plan.scenario.slopes.iter().map(|slope| format!("{}={}", slope.factor, slope.sd));
        let slopes = slopes.collect::<Vec<_>>().join(" ");
        let effect = |power: &Power| self.hypothesis(power).effect.as_ref();
        let truth = |power: &Power| if effect(power).is_some() { "effect" } else { "none" };
        let logits = |power: &Power| effect(power).map_or(Some(0.0), |effect| effect.logits);
        let power = |power: &Power| effect(power).map(|_| power.share());
        let false_alarms = |power: &Power| effect(power).is_none().then(|| power.share());
        Rows::new(&self.powers)
            .column("experiment", "Name of the definition.", |_| self.protocol.name.as_str())
            .column("participants", "Number of participants.", |power| power.participants)
            .column("term", "Term or factor that is tested.", |power| self.hypothesis(power).term.to_string())
            .column("test", "Name of the test.", |power| self.hypothesis(power).test.name())
            .column("truth", "Whether the simulated observer has the effect.", truth)
            .column("effect_logits", "Size of the effect on the latent scale.", logits)
            .in_unit("logit", 1)
            .column("above", "Level that is rated higher.", |power| Some(effect(power)?.above.as_str()))
            .column("below", "Level that is rated lower.", |power| Some(effect(power)?.below.as_str()))
            .column("studies", "Number of simulated studies.", |power| power.studies)
            .column("found", "Number of studies in which the test is significant.", |power| power.found)
            .column("untested", "Number of studies in which the test is not possible.", |power| power.untested)
            .column("power", "Proportion of studies that find the effect.", power)
            .column("false_alarms", "Proportion of studies that find an effect that is not there.", false_alarms)
            .interval("ci", "the 95 % interval of this proportion", |power| Some(power.interval()))
            .column("alpha", "Level of significance.", |_| self.sampling.alpha)
            .column("link", "Link function of the model.", |_| spec.link.to_string())
            .column("terms", "Terms of the model.", |_| spec.terms.to_string())
            .column("slopes", "Random slopes of the model.", |_| spec.slopes.to_string())
            .column("slope_sd", "Standard deviations of the simulated random slopes.", |_| slopes.as_str())
            .in_unit("logit", 1)
            .column("seed", "Seed of the simulation.", |_| self.sampling.seed)
            .column("observer", "Simulated observer.", |_| self.observer.as_str())
            .table()
    }
}

impl PlannedTask {
    /// Returns the unit of differences and errors.
    pub fn unit(&self) -> &'static str {
        let Estimand { unit, log, .. } = self.plan.study.asked.estimand();
        if log { "log10 units" } else { unit }
    }

    /// Returns what a precision is that of: `threshold of one person`, `orientation 90° − orientation 0°`.
    pub fn told(&self, quantity: &Quantity) -> String {
        let name = self.plan.study.asked.estimand().name;
        match *quantity {
            Quantity::Person => format!("{name} of one person"),
            Quantity::Mean => format!("mean {name}"),
            Quantity::Difference { condition, .. } => {
                let [other, first] = [condition, 0].map(|condition| self.plan.study.name(condition));
                format!("{other} − {first}")
            }
        }
    }

    /// Returns one row for each number of participants and of trials, and each quantity.
    pub fn table(&self) -> Table {
        const TRUTH: &str = "True difference; base-10 logarithms if levels or settings are logarithmic.";
        const FALSE_ALARMS: &str = "Proportion of studies that find a difference that is not there.";
        let truth = |found: &Precision| match found.quantity {
            Quantity::Difference { truth, .. } => Some(truth),
            _ => None,
        };
        let share = |found: &Precision, is_true: bool| {
            found.tested().filter(|truth| (*truth != 0.0) == is_true).map(|_| found.share().0)
        };
        Rows::new(&self.found)
            .column("experiment", "Name of the definition.", |_| self.plan.protocol.name.as_str())
            .column("participants", "Number of participants.", |found| found.participants)
            .column("trials", "Number of trials of each condition or pair.", |found| found.trials)
            .column("estimate", "What is estimated.", |found| self.told(&found.quantity))
            .column("truth", TRUTH, truth)
            .column("estimates", "Number of estimates in the simulated studies.", |found| found.studies)
            .column("found", "Number of studies that find the difference.", |found| {
                found.tested().map(|_| found.found as f64)
            })
            .column("missing", "Number of estimates that are not possible or have no interval.", |found| found.missing)
            .column("power", "Proportion of studies that find the difference.", |found| share(found, true))
            .column("false_alarms", FALSE_ALARMS, |found| share(found, false))
            .interval("ci", "the 95 % interval of this proportion", |found| found.tested().map(|_| found.share().1))
            .column("half_width", "Median of half the width of the 95 % interval.", |found| found.half_width)
            .column("error", "Root mean square of estimate minus truth.", |found| found.error)
            .in_unit(self.unit(), 2)
            .column("seed", "Seed of the simulation.", |_| self.sampling.seed)
            .column("observer", "Simulated observer.", |_| self.plan.observer.to_string())
            .table()
    }
}
