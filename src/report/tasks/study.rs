//! What was asked, by a definition or as the columns of a table say, and the answers, from the sessions of a data set or
//! from a table.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::{Path, PathBuf},
};

use crate::{
    analysis::tasks::{
        person::{Answers, Detection, Settings},
        psychometric::{Model, Point},
    },
    experiment::{
        Factor, Phase, Protocol, Replayed,
        task::{Adaptive, Answer, Common, Dial, Presentation, Second, Task},
    },
    report::{
        document::{Shown, fixed, significant, unit},
        names,
    },
    statistics::Interval,
    stimulus::{ParameterValue, Stimulus},
    store::{
        FileError, FileErrors, StoreError,
        answers::AnswerRow,
        definition,
        ratings::{self, Listed},
        recorded::Recorded,
        sidecar::Sidecar,
    },
    text::Cell,
};

/// What was asked.
#[derive(Clone, Debug, Default)]
pub struct Asked {
    /// The title of the study, or the name of its experiment or file.
    pub title: String,
    /// What is measured in each condition.
    pub measure: Measure,
    /// The factors; the last one is the second parameter of an adaptive method, if it has one.
    pub factors: Vec<Factor>,
    /// Each condition's level of each factor.
    pub conditions: Vec<Vec<usize>>,
    /// The definition; `None` for a table of answers at levels.
    pub protocol: Option<Protocol>,
}

/// What is measured for each person in each condition.
#[derive(Clone, Debug, Default)]
pub enum Measure {
    /// The threshold of a psychometric function.
    Thresholds(Levels),
    /// The proportion of correct answers.
    Proportions,
    /// How well targets are told from catch trials.
    Sensitivity,
    /// The value that participants set.
    Settings(Dial),
    /// The place on a scale of comparisons.
    #[default]
    Scale,
}

/// The levels of a psychometric function.
#[derive(Clone, Debug)]
pub struct Levels {
    /// What is varied, and on which scale.
    pub common: Common,
    /// The lowest and the highest level that could be shown.
    pub range: [f64; 2],
    /// What is known about the functions.
    pub model: Model,
}

/// How a measured value is told.
#[derive(Clone, Debug)]
pub struct Estimand {
    /// What it is, without its parameter: `threshold`.
    pub name: &'static str,
    /// Of which parameter: ` of width`, or nothing.
    pub of: String,
    /// The unit of differences and errors, unless they are logarithms.
    pub unit: &'static str,
    /// Whether the values are base-10 logarithms.
    pub log: bool,
    /// The ends of its scale, if it has any.
    pub ends: Option<[f64; 2]>,
    /// How a value is written; `None` for a level or a setting.
    format: Option<fn(f64) -> Shown>,
}

impl Estimand {
    /// Returns how a value is written whose interval, if any, is known.
    pub fn format(&self, interval: Option<Interval>) -> Box<dyn Fn(f64) -> Shown> {
        self.format.map_or_else(|| Box::new(scaled(self.log, interval)) as _, |format| Box::new(format) as _)
    }
}

/// Returns how a level or a setting is written, which is a logarithm if the method or the dial counts in ratios: with three
/// significant digits, and more if its interval is narrow.
pub(super) fn scaled(log: bool, interval: Option<Interval>) -> impl Fn(f64) -> Shown {
    let of_scale = move |value: f64| if log { f64::powf(10.0, value) } else { value };
    let width = interval.map(|interval| of_scale(interval.high) - of_scale(interval.low));
    let width = width.filter(|width| *width > 0.0).unwrap_or(f64::INFINITY);
    move |value| {
        let value = of_scale(value);
        // On a linear scale, a value near 0 is as large as its error.
        let size = value.abs().max(if log || width.is_infinite() { 0.0 } else { width / 10.0 });
        significant(value, size, width.min(size))
    }
}

impl Asked {
    fn known(&self) -> names::Known {
        self.protocol.as_ref().map(|protocol| protocol.stimulus.parameters())
    }

    /// Returns the name of a factor or of another parameter in a sentence.
    pub fn factor(&self, name: &str) -> String {
        names::factor(self.known(), name)
    }

    /// Returns the levels at which psychometric functions were measured, if they were.
    pub fn levels(&self) -> Option<&Levels> {
        if let Measure::Thresholds(levels) = &self.measure { Some(levels) } else { None }
    }

    /// Returns whether some trials showed no target.
    pub fn has_catches(&self) -> bool {
        self.protocol.as_ref().is_some_and(|protocol| protocol.task.catches().is_some())
    }

    /// Returns the conditions that a trial is about: two if it compares them, and otherwise one, with its level of the second
    /// parameter. `planned` is the condition in the schedule.
    pub fn places(&self, planned: usize, shown: &Presentation) -> Option<Vec<usize>> {
        let protocol = self.protocol.as_ref()?;
        if let Measure::Scale = self.measure {
            let conditions = protocol.conditions();
            let of = |stimulus: &Stimulus| conditions.iter().position(|condition| condition.stimulus == *stimulus);
            return shown.stimuli.iter().map(of).collect();
        }
        let Some(Second { parameter, levels, .. }) = protocol.adaptive.as_ref().and_then(Adaptive::second) else {
            return Some(vec![planned]);
        };
        let own = shown.described().get(parameter);
        let level = levels.iter().position(|level| own.as_ref() == Some(&(*level).into()));
        // A catch trial has none of these levels, and says nothing about a function.
        Some(vec![planned * levels.len() + level.or((shown.target == Some(0)).then_some(0))?])
    }

    /// Returns how what is measured is told.
    pub fn estimand(&self) -> Estimand {
        let of = |parameter: &str| format!(" of {}", self.factor(parameter));
        let plain = |name, unit, format: fn(f64) -> Shown| Estimand {
            name,
            of: String::new(),
            unit,
            log: false,
            ends: None,
            format: Some(format),
        };
        let hundredths = |value| fixed(value, 2);
        match &self.measure {
            Measure::Thresholds(Levels { common: Common { parameter, log, .. }, .. }) => {
                let unit = "units of the level";
                Estimand { name: "threshold", of: of(parameter), unit, log: *log, ends: None, format: None }
            }
            Measure::Settings(Dial { parameter, log, range, .. }) => {
                let (name, of) = parameter.as_ref().map_or(("rating", String::new()), |name| ("setting", of(name)));
                let ends = Some(range.map(|end| if *log { end.log10() } else { end }));
                Estimand { name, of, unit: "units of the scale", log: *log, ends, format: None }
            }
            Measure::Proportions => {
                Estimand { ends: Some([0.0, 1.0]), ..plain("proportion of correct answers", "proportions", unit) }
            }
            Measure::Sensitivity => plain("d’", "d’", hundredths),
            Measure::Scale => plain("scale value", "JND", hundredths),
        }
    }

    /// Formats a level of a factor.
    pub fn level(&self, factor: &str, level: &str) -> String {
        names::level(self.known(), factor, level).to_string()
    }

    /// Returns the title of an axis for a parameter, or for its logarithm.
    pub fn axis(&self, name: &str, log: bool) -> String {
        match log {
            true => format!("{} (base-10 logarithm)", names::heading(self.known(), name)),
            false => names::axis(self.known(), name),
        }
    }
}

/// Names the answers to a task other than a rating on a scale of categories.
pub(crate) fn answers(task: &Task) -> String {
    match task {
        Task::Rating(_) => "answers on a slider".to_owned(),
        _ => format!("answers to the task {}", task.name()),
    }
}

impl From<&Protocol> for Asked {
    fn from(protocol: &Protocol) -> Self {
        let title = if protocol.title.trim().is_empty() { &protocol.name } else { &protocol.title };
        let levels = protocol.adaptive.as_ref().zip(Model::of(protocol)).map(|(adaptive, model)| Levels {
            common: adaptive.common.clone(),
            range: adaptive.range(),
            model,
        });
        let measure = match (levels, protocol.task.dial()) {
            (Some(levels), _) => Measure::Thresholds(levels),
            (None, Some(dial)) => Measure::Settings(dial),
            _ if protocol.pairs().is_some() => Measure::Scale,
            _ if protocol.task.catches().is_some() => Measure::Sensitivity,
            _ => Measure::Proportions,
        };
        let mut factors = protocol.factors.clone();
        let mut conditions: Vec<Vec<usize>> =
            protocol.conditions().iter().map(|condition| condition.levels.clone()).collect();
        if let Some(second) = protocol.adaptive.as_ref().and_then(Adaptive::second) {
            let levels: Vec<ParameterValue> = second.levels.iter().map(|level| (*level).into()).collect();
            let with = |condition: &Vec<usize>| -> Vec<Vec<usize>> {
                (0..levels.len()).map(|level| [&condition[..], &[level]].concat()).collect()
            };
            conditions = conditions.iter().flat_map(with).collect();
            factors.push(Factor { name: second.parameter.clone(), levels });
        }
        Self { title: title.clone(), measure, factors, conditions, protocol: Some(protocol.clone()) }
    }
}

/// The answers to a task.
#[derive(Clone, Debug, Default)]
pub struct TaskStudy {
    /// What was asked.
    pub asked: Asked,
    /// Each file and its number of rows.
    pub files: Vec<(PathBuf, usize)>,
    /// The participants' IDs, in natural order of the files.
    pub people: Vec<String>,
    /// In how many sessions a program answered; in a table, for how many participants.
    pub simulated: usize,
    /// How many sessions are not complete.
    pub unfinished: usize,
    /// The answers of each person in each condition, by their indices: the condition's first.
    pub given: BTreeMap<(usize, usize), Given>,
    /// The comparisons: the person, the condition that was chosen, and the other one.
    pub compared: Vec<(usize, [usize; 2])>,
    /// What is wrong with the files.
    pub errors: Vec<FileError>,
    /// Warnings about files that were read anyway: files that were changed after their session ended, links that lead out
    /// of a data set, and folders that were not read.
    pub warnings: Vec<FileError>,
    /// The participants that were left out.
    pub excluded: Vec<String>,
}

/// The answers of a person to the main trials of a condition, the last attempt of each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Given {
    /// In how many trials the target was seen or chosen, at each level on the scale of the method; at 0 if there are no levels,
    /// and at −∞ in catch trials.
    pub points: Vec<Point>,
    /// The values that were set, as logarithms if the dial counts in ratios, and whether each adjustment began in the upper
    /// half of its range; `None` without a start.
    pub values: Vec<(f64, Option<bool>)>,
}

/// What follows from the answers of a person in a condition.
#[derive(Clone, Debug)]
pub struct OfPerson<T> {
    /// Index into [`TaskStudy::people`].
    pub person: usize,
    /// Index into the conditions.
    pub condition: usize,
    /// What follows.
    pub found: T,
}

/// The answers of a person in a condition, and sensitivity and criterion: `None` without targets or catch trials, and over
/// different levels, where both would describe how the levels were chosen, not any stimulus.
pub type Detected = (Answers, Option<Detection>);

impl Given {
    /// Returns in how many trials with a target it was seen or chosen, and their number; those of catch trials unless
    /// `are_targets`.
    pub fn seen(&self, are_targets: bool) -> [u32; 2] {
        let points = self.points.iter().filter(|point| point.is_target() == are_targets);
        points.fold([0, 0], |[seen, all], point| [seen + point.correct, all + point.total])
    }
}

impl TaskStudy {
    /// Returns the task of the first session with a sidecar at these paths, and the path, if it is not a rating on a scale of
    /// categories.
    ///
    /// # Errors
    /// A sidecar cannot be read.
    pub fn task_at(paths: &[PathBuf]) -> Result<Option<(PathBuf, Task)>, FileErrors> {
        for path in paths {
            for csv in Listed::sessions(path).files {
                let sidecar = csv.with_extension("json");
                match Sidecar::read(&sidecar) {
                    Ok(Some(found)) => {
                        let Ok(protocol) = definition::from_json("", &found.definition) else { continue };
                        return Ok(Some((path.clone(), protocol.task.clone())).filter(|(_, task)| !task.is_default()));
                    }
                    // That a session has none, or that a file beside the data is none, is told when the data are read.
                    Ok(None) | Err(StoreError::FileErrors(_)) => {}
                    Err(error) => return Err(FileErrors(error.errors(&sidecar))),
                }
            }
        }
        Ok(None)
    }

    /// Reads the sessions at these paths, without the participants in `exclude`. Sessions with errors are left out and
    /// told.
    ///
    /// # Errors
    /// There are no sessions, a folder cannot be read, or they have different definitions.
    pub fn read(paths: &[PathBuf], exclude: &[String]) -> Result<Self, StoreError> {
        let Listed { files, mut errors, mut warnings, .. } = ratings::files(paths)?;
        let mut sessions = Vec::<Recorded>::new();
        for csv in files {
            match Recorded::open(&csv) {
                Ok(session) if session.row_errors.is_empty() => sessions.push(session),
                Ok(session) => errors.extend(session.row_errors),
                Err(StoreError::FileErrors(found)) => errors.extend(found.0),
                Err(error) => return Err(FileErrors(error.errors(&csv)).into()),
            }
        }
        let Some(first) = sessions.first() else { return Err(FileErrors(errors).into()) };
        let mut study = Self { errors, asked: Asked::from(&first.protocol), ..Self::default() };
        let mut known = BTreeMap::new();
        for session in &sessions {
            if session.protocol != first.protocol {
                let message =
                    "has another definition than the sessions before it; expected the sessions of one definition";
                return Err(FileErrors::whole(&session.csv, message).into());
            }
            if let Some(other) = known.insert((session.identity.subject(), session.identity.session()), &session.csv) {
                let message =
                    format!("has the same participant and session as {}; expected each once", other.display());
                return Err(FileErrors::whole(&session.csv, message).into());
            }
            warnings.extend(session.changed.iter().cloned().chain(session.interruption()));
            study.add(session, exclude);
        }
        study.warnings = warnings;
        Ok(study)
    }

    /// Takes the rows of a table of answers. `factors` have the levels whose order is known; the others follow in the order of
    /// the rows. `levels` says what is known about the levels of the functions.
    pub fn of_answers(path: &Path, rows: &[AnswerRow], factors: Vec<(String, Vec<String>)>, levels: Levels) -> Self {
        let (names, mut found): (Vec<String>, Vec<Vec<String>>) = factors.into_iter().unzip();
        let mut people = Vec::new();
        let mut given: BTreeMap<Vec<usize>, BTreeMap<usize, Given>> = BTreeMap::new();
        for row in rows {
            let of = row.factors.iter().zip(&mut found).map(|(level, known)| place(known, level.clone())).collect();
            let person = place(&mut people, row.subject.clone());
            let own = given.entry(of).or_default().entry(person).or_default();
            if row.total > 0 {
                Point::add(&mut own.points, levels.common.scaled(row.level), row.correct, row.total);
            }
        }
        let factor = |(name, levels): (String, Vec<String>)| {
            let levels = levels.into_iter().map(|level| ParameterValue::from(level.as_str())).collect();
            Factor { name, levels }
        };
        let asked = Asked {
            title: path.file_stem().unwrap_or_default().display().to_string(),
            measure: Measure::Thresholds(levels),
            factors: names.into_iter().zip(found).map(factor).collect(),
            conditions: given.keys().cloned().collect(),
            protocol: None,
        };
        let of_condition = |(condition, own): (usize, BTreeMap<usize, Given>)| {
            own.into_iter().map(move |(person, given)| ((condition, person), given))
        };
        let given = given.into_values().enumerate().flat_map(of_condition).collect();
        let simulated: BTreeSet<&String> = rows.iter().filter(|row| row.is_simulated).map(|row| &row.subject).collect();
        let files = vec![(path.to_owned(), rows.len())];
        Self { asked, files, people, simulated: simulated.len(), given, ..Self::default() }
    }

    /// Returns what follows from the answers of each person in each condition, in this order of both, if anything does.
    pub fn each<T>(&self, one: impl Fn(&Given) -> Option<T>) -> Vec<OfPerson<T>> {
        let own = |(&(condition, person), given)| Some(OfPerson { person, condition, found: one(given)? });
        self.given.iter().filter_map(own).collect()
    }

    /// Returns the number of correct answers of each person and condition, and of all.
    pub fn shares(&self) -> Vec<OfPerson<[u32; 2]>> {
        self.each(|given| Some(given.seen(true)))
    }

    /// Returns hits and false alarms of each person and condition, with sensitivity and criterion.
    pub fn detection(&self) -> Vec<OfPerson<Detected>> {
        self.each(|given| {
            let [[hits, targets], [false_alarms, catches]] = [true, false].map(|are_targets| given.seen(are_targets));
            let (misses, correct_rejections) = (targets - hits, catches - false_alarms);
            let answers = Answers { hits, misses, false_alarms, correct_rejections };
            Some((answers, answers.detection().filter(|_| self.asked.levels().is_none())))
        })
    }

    /// Returns the settings of each person and condition, on the scale of the dial.
    pub fn settings(&self) -> Vec<OfPerson<Settings>> {
        self.each(|given| Settings::of(&given.values))
    }

    /// Returns the number of answers.
    pub fn answers(&self) -> u64 {
        let count = |given: &Given| {
            given.points.iter().map(|point| u64::from(point.total)).sum::<u64>() + given.values.len() as u64
        };
        self.given.values().map(count).sum::<u64>() + self.compared.len() as u64
    }

    fn add(&mut self, session: &Recorded, exclude: &[String]) {
        let id = session.identity.subject().to_owned();
        if exclude.contains(&id) {
            place(&mut self.excluded, id);
            return;
        }
        self.files.push((session.csv.clone(), session.rows.len()));
        self.simulated += usize::from(session.sidecar.sittings.iter().any(|sitting| sitting.observer.is_some()));
        self.unfinished += usize::from(!session.is_complete());
        let person = place(&mut self.people, id);
        // Later attempts replace earlier ones, because rows are in chronological order.
        let main = session.rows.iter().enumerate().filter(|(_, row)| row.phase == Phase::Main);
        let last: BTreeMap<u32, usize> = main.map(|(index, row)| (row.trial, index)).collect();
        for Replayed { trial, shown, answer, .. } in
            last.into_values().filter_map(|index| session.replayed[index].as_ref())
        {
            self.take(person, session.course.schedule().trials[*trial].condition, shown, answer);
        }
    }

    /// Takes the answer to a main trial of a definition, for which the schedule planned a condition or a pair; `None` if
    /// there is none.
    pub fn take(&mut self, person: usize, planned: usize, shown: &Presentation, answer: &Answer) -> Option<()> {
        let seen = self.asked.protocol.as_ref()?.task.outcome(shown, answer);
        let places = self.asked.places(planned, shown)?;
        if let [left, right] = places[..] {
            self.compared.push((person, if seen { [left, right] } else { [right, left] }));
            return Some(());
        }
        let given = self.given.entry((places[0], person)).or_default();
        match (&self.asked.measure, answer) {
            (Measure::Settings(dial), Answer::Value(value)) => {
                let value = if dial.log { value.log10() } else { *value };
                given.values.push((value, shown.start.map(|start| dial.share(start) > 0.5)));
            }
            (measured, Answer::Key(_)) => {
                let x = match measured {
                    _ if shown.target == Some(0) => f64::NEG_INFINITY,
                    Measure::Thresholds(levels) => levels.common.scaled(shown.level?),
                    _ => 0.0,
                };
                Point::add(&mut given.points, x, seen.into(), 1);
            }
            (_, Answer::Value(_)) => return None,
        }
        Some(())
    }

    /// Returns the name of a condition: its levels of the factors.
    pub fn name(&self, condition: usize) -> String {
        let named = self.asked.factors.iter().zip(self.levels(condition));
        let named = named.map(|(factor, level)| format!("{} {level}", self.asked.factor(&factor.name)));
        named.collect::<Vec<_>>().join(", ")
    }

    /// Returns ` at CONDITION`, or nothing if there is only one.
    pub fn at(&self, condition: usize) -> String {
        let name = self.name(condition);
        if name.is_empty() { name } else { format!(" at {name}") }
    }

    /// Returns a condition's level of a factor, given by index.
    pub fn cell(&self, condition: usize, factor: usize) -> Cell {
        self.asked.factors[factor].levels[self.asked.conditions[condition][factor]].clone().into()
    }

    /// Returns a condition's level of each factor.
    pub fn levels(&self, condition: usize) -> Vec<String> {
        let levels = self.asked.factors.iter().zip(&self.asked.conditions[condition]);
        levels.map(|(factor, level)| self.asked.level(&factor.name, &factor.levels[*level].to_string())).collect()
    }
}

/// Returns the place of a value in a list, to which it is added if it is missing.
fn place<T: PartialEq>(known: &mut Vec<T>, value: T) -> usize {
    known.iter().position(|one| *one == value).unwrap_or_else(|| {
        known.push(value);
        known.len() - 1
    })
}
