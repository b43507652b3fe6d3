//! How many participants a study needs, whatever its task, and how precise thresholds are after so many trials.

use super::{
    RequestError, Watcher,
    plan::{Assignment, Plan, Planned, in_order, progress},
    request::allow_only,
};
use crate::{
    analysis::power::{Precision, Quantity, Sampling, Shift, Slope, ThresholdObserver, ThresholdPlan},
    experiment::{Definition, Identity, Protocol, Schedule},
    report::{names, tables::Rows, tasks::task},
    store::definition,
    text::{Table, names::expected_one_of},
};

/// The fields that apply to thresholds; the others are about ratings.
const OF_THRESHOLDS: [&str; 8] =
    ["experiment", "participants", "effects", "deviations", "studies", "target", "seed", "trials"];

/// The simulated precision of a plan, and the settings on which it depends.
#[derive(Clone, Debug)]
pub struct PlannedThresholds {
    pub protocol: Protocol,
    pub observer: ThresholdObserver,
    pub sampling: Sampling,
    /// Target power.
    pub target: f64,
    /// For each number of trials and of participants, each quantity.
    pub found: Vec<Precision>,
}

/// What a plan found.
pub enum Found {
    /// The power of a study of ratings.
    Ratings(Box<Planned>),
    /// The precision of a study of thresholds.
    Thresholds(Box<PlannedThresholds>),
}

impl Found {
    /// Returns the table that a CSV file has.
    pub fn table(&self) -> Table {
        match self {
            Self::Ratings(planned) => planned.table(),
            Self::Thresholds(planned) => planned.table(),
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
        if protocol.adaptive.is_some() {
            return Ok(Found::Thresholds(Box::new(self.thresholds(protocol, watcher)?)));
        }
        if !protocol.task.is_default() {
            let message = format!(
                "{} has the task {}, whose precision depends on how much people differ, which is not known before they answer; \
                 expected a rating on a scale of categories, or a task with [adaptive]",
                protocol.name,
                task(&protocol.task),
            );
            return Err(RequestError::whole(message).into());
        }
        if !self.trials.is_empty() {
            let message = "does not apply to ratings; expected a task with [adaptive]";
            return Err(RequestError::new("trials", message).into());
        }
        Ok(Found::Ratings(Box::new(self.ratings(protocol, watcher)?)))
    }

    /// Simulates studies of a definition with `[adaptive]`.
    fn thresholds(&self, protocol: Protocol, watcher: &dyn Watcher) -> anyhow::Result<PlannedThresholds> {
        allow_only(self, &OF_THRESHOLDS, "does not apply to thresholds; expected a definition of ratings")?;
        // What prevents one schedule prevents all.
        Schedule::new(&protocol, &Identity::new("S00000", "1")?, self.seed)?;
        // A difference is found by its 95 % interval.
        let sampling = Sampling { studies: self.studies, seed: self.seed, ..Sampling::default() };
        let (observer, shifts) = self.threshold_observer(&protocol)?;
        let slope = |given: &Assignment| {
            let known = protocol.factors.iter().any(|factor| factor.name == given.name);
            let slope = Slope { factor: given.name.clone(), sd: given.value };
            known
                .then_some(slope)
                .ok_or_else(|| RequestError::value("deviations", unknown_factor(&given.name, &protocol)))
        };
        let slopes = self.deviations.iter().map(slope).collect::<Result<Vec<_>, _>>()?;
        let plans = self.with_trials(&protocol)?.into_iter().map(|protocol| {
            ThresholdPlan::new(&protocol, observer.clone(), shifts.clone(), slopes.clone()).ok_or_else(|| {
                let message = format!("{} has no method that varies a level; expected [adaptive]", protocol.name);
                RequestError::whole(message)
            })
        });
        let plans = plans.collect::<Result<Vec<_>, _>>()?;
        let participants = in_order(&self.participants);
        let all = participants.iter().map(|people| u64::from(*people)).sum::<u64>() * u64::from(self.studies);
        let progress = progress(watcher, all * plans.len() as u64);
        let found = plans.iter().flat_map(|plan| plan.run(&participants, &sampling, &progress)).collect();
        Ok(PlannedThresholds { protocol, observer, sampling, target: self.target, found })
    }

    /// Returns the definition with each number of trials.
    fn with_trials(&self, protocol: &Protocol) -> Result<Vec<Protocol>, RequestError> {
        if self.trials.is_empty() {
            return Ok(vec![protocol.clone()]);
        }
        let with = |trials: u32| {
            let mut definition: Definition = (**protocol).clone();
            if let Some(adaptive) = &mut definition.adaptive {
                adaptive.common.trials = trials;
            }
            Protocol::new(definition).map_err(|errors| {
                let message = errors.into_iter().next().map_or_else(String::new, |error| error.message);
                RequestError::value("trials", message.strip_prefix("trials ").unwrap_or(&message))
            })
        };
        in_order(&self.trials).into_iter().map(with).collect()
    }

    /// Returns the observer with the requested effects, and those of the levels of factors.
    fn threshold_observer(&self, protocol: &Protocol) -> Result<(ThresholdObserver, Vec<Shift>), RequestError> {
        let adaptive = protocol.adaptive.clone().unwrap_or_default();
        let (mut observer, (shifts, parameters)) = (ThresholdObserver::of(&adaptive), self.given());
        for Shift { factor, level, .. } in &shifts {
            let wrong = |message: String| RequestError::value("effects", format!("{factor}:{level}: {message}"));
            let of = protocol.factors.iter().find(|known| known.name == *factor);
            let of = of.ok_or_else(|| wrong(unknown_factor(factor, protocol)))?;
            let levels: Vec<String> = of.levels.iter().map(ToString::to_string).collect();
            if !levels.contains(level) {
                let expected = expected_one_of(level, &levels);
                return Err(wrong(format!("{factor} has no level {level}; {expected}")));
            }
        }
        for effect in parameters {
            let wrong = |message: String| RequestError::value("effects", format!("{effect}: {message}"));
            let [low, high] = adaptive.range();
            let (parameter, [least, most]) = match effect.name.as_str() {
                "threshold" => (&mut observer.threshold, [low, high]),
                "subject_sd" => (&mut observer.subject_sd, [0.0, 1e6]),
                "slope" => (&mut observer.slope, [1e-6, 1e6]),
                "lapse" => (&mut observer.lapse, [0.0, 0.5]),
                "false_alarms" => (&mut observer.false_alarms, [0.0, 0.9]),
                name => {
                    let known = ["threshold", "subject_sd", "slope", "lapse", "false_alarms"];
                    let expected = expected_one_of(name, &known);
                    return Err(wrong(format!("the observer has no such parameter; {expected}; or FACTOR:LEVEL")));
                }
            };
            if !(least..=most).contains(&effect.value) {
                return Err(wrong(format!("the value is out of range; expected {least}…{most}")));
            }
            *parameter = effect.value;
        }
        Ok((observer, shifts))
    }
}

fn unknown_factor(name: &str, protocol: &Protocol) -> String {
    let known: Vec<&str> = protocol.factors.iter().map(|factor| factor.name.as_str()).collect();
    if known.is_empty() {
        return format!("{name} is not a factor; {} has none", protocol.name);
    }
    format!("{name} is not a factor; {}", expected_one_of(name, &known))
}

impl PlannedThresholds {
    /// Returns the unit of thresholds.
    pub fn unit(&self) -> &'static str {
        let log = self.protocol.adaptive.as_ref().is_some_and(|adaptive| adaptive.common.log);
        if log { "log10 units" } else { "units of the level" }
    }

    /// Returns what a precision is that of: `threshold of one person`, `depth 2 − 1`.
    pub fn told(&self, quantity: &Quantity) -> String {
        match *quantity {
            Quantity::Person => "threshold of one person".to_owned(),
            Quantity::Mean => "mean threshold".to_owned(),
            Quantity::Difference { factor, level, .. } => {
                let (of, known) = (&self.protocol.factors[factor], Some(self.protocol.stimulus.parameters()));
                let [level, first] =
                    [level, 0].map(|place| names::level(known, &of.name, &of.levels[place].to_string()));
                format!("{} {level} − {first}", names::factor(known, &of.name))
            }
        }
    }

    /// Returns the smallest study of those planned that finds each true difference with the target power.
    pub fn sentences(&self) -> Vec<String> {
        let mut told: Vec<&Quantity> = Vec::new();
        for quantity in self.found.iter().map(|one| &one.quantity) {
            if quantity.differs() && !told.contains(&quantity) {
                told.push(quantity);
            }
        }
        let sentence = |quantity: &Quantity| {
            let own = || self.found.iter().filter(|one| one.quantity == *quantity);
            let size = |one: &&Precision| (one.participants, one.trials);
            let certain = own().filter(|one| one.share().1.low >= self.target).min_by_key(size);
            let likely = own().filter(|one| one.share().0 >= self.target).min_by_key(size);
            let name = names::capitalized(&self.told(quantity));
            let target = format!("a power of {:.0}\u{a0}%", 100.0 * self.target);
            let study = |one: &Precision| {
                format!("{} participants with {} trials of each condition", one.participants, one.trials)
            };
            match (certain, likely) {
                (Some(one), _) => format!("{name}: {} reach {target}.", study(one)),
                (None, Some(one)) => {
                    format!("{name}: {} may reach {target}; only more simulated studies can tell.", study(one))
                }
                (None, None) => format!("{name}: none of these studies reaches {target}."),
            }
        };
        told.into_iter().map(sentence).collect()
    }

    /// Returns one row for each number of participants and of trials, and each quantity.
    pub fn table(&self) -> Table {
        const TRUTH: &str =
            "True difference, on the scale of the method: base-10 logarithms of the level if it is logarithmic.";
        const HALF_WIDTH: &str = "Median of half the width of the 95 % interval, on the scale of the method.";
        const SLOPE: &str = "Slope of their psychometric functions, on the scale of the method.";
        const FALSE_ALARMS: &str = "Proportion of studies that find a difference that is not there.";
        let truth = |found: &Precision| found.quantity.truth();
        // One participant has no interval, which could exclude 0.
        let tested = |found: &Precision| truth(found).filter(|_| found.half_width.is_some());
        let share = |found: &Precision, is_true: bool| {
            tested(found).filter(|_| found.quantity.differs() == is_true).map(|_| found.share().0)
        };
        let rate = "Their rate of yes answers to stimuli without a target.";
        let sd = "Standard deviation of their thresholds, on the scale of the method.";
        let observer = &self.observer;
        Rows::new(&self.found)
            .column("experiment", "Name of the definition.", |_| self.protocol.name.as_str())
            .column("participants", "Number of participants.", |found| found.participants)
            .column("trials", "Number of trials of each condition.", |found| found.trials)
            .column("estimate", "What is estimated.", |found| self.told(&found.quantity))
            .column("truth", TRUTH, truth)
            .column("estimates", "Number of estimates in the simulated studies.", |found| found.studies)
            .column("found", "Number of studies whose 95 % interval excludes 0.", |found| {
                tested(found).map(|_| found.found as f64)
            })
            .column("missing", "Number of estimates that are not possible or have no interval.", |found| found.missing)
            .column("power", "Proportion of studies that find the difference.", |found| share(found, true))
            .column("false_alarms", FALSE_ALARMS, |found| share(found, false))
            .interval("ci", "the 95 % interval of this proportion", |found| tested(found).map(|_| found.share().1))
            .column("half_width", HALF_WIDTH, |found| found.half_width)
            .column("error", "Root mean square of estimate minus truth, on the scale of the method.", |found| {
                found.error
            })
            .column("threshold", "Mean threshold of the simulated people, as a level.", |_| observer.threshold)
            .column("subject_sd", sd, |_| observer.subject_sd)
            .column("slope", SLOPE, |_| observer.slope)
            .column("lapse", "Their lapse rate.", |_| observer.lapse)
            .column("false_alarm_rate", rate, |_| observer.false_alarms)
            .column("seed", "Seed of the simulation.", |_| self.sampling.seed)
            .table()
    }
}
