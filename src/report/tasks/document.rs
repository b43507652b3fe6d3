//! Describes the answers to a task in a document.

use super::{
    further,
    results::{PersonFunction, TaskResults},
    study::{Asked, Levels, TaskStudy},
};
use crate::{
    analysis::tasks::{
        population::Population,
        psychometric::{Fit, Guess, Model},
    },
    experiment::task::{Common, Curve, Measures},
    report::{
        document::{
            Document, Section, Shown, TableOf, count, fixed, list, p_is, probability, range, short_list, unit, whole,
            with_interval,
        },
        figures::Figure,
        study::{Provenance, definition},
    },
    statistics::Interval,
};

/// Describes a study; `provenance` says how to repeat the analysis.
pub fn document(
    study: &TaskStudy,
    results: &TaskResults,
    figures: &[Figure],
    provenance: Option<&Provenance>,
) -> Document {
    let mut sections = vec![summary(study, results), data(study, figures)];
    sections.extend(thresholds(study, results, figures));
    sections.extend(further::sections(study, results, figures));
    sections.push(methods(study, results));
    sections.extend(provenance.map(|provenance| repeat(study, provenance)));
    let Asked { title, task, protocol, .. } = &study.asked;
    let subtitle = match protocol {
        Some(protocol) => format!("Experiment {}: {task}", protocol.name),
        None => format!("A {task}"),
    };
    Document { title: title.clone(), subtitle, sections }
}

/// Returns how a level is written whose interval, if any, is known.
fn level(common: &Common, interval: Option<Interval>) -> impl Fn(f64) -> Shown {
    further::scaled(common.log, interval)
}

fn summary(study: &TaskStudy, results: &TaskResults) -> Section {
    let mut section = Section::new("summary", "Summary");
    let who = count(study.people.len() as u64, "participant");
    let what = count(study.answers(), "answer");
    section.text(format!("{who} gave {what}."));
    if study.unfinished > 0 {
        section.warning(format!("Not complete: {}.", count(study.unfinished as u64, "session")));
    }
    if study.simulated > 0 {
        let whose = if study.asked.protocol.is_some() { "session" } else { "participant" };
        let whose = count(study.simulated as u64, whose);
        section.warning(format!("These data are simulated: a program gave the answers of {whose}."));
    }
    if !study.excluded.is_empty() {
        section.text(format!("Left out on request: {}.", list(&study.excluded)));
    }
    section.list(further::summary(study, results));
    let Some(Levels { common, range: [low, high], .. }) = &study.asked.levels else { return section };
    let name = study.asked.factor(&common.parameter);
    let sentence = |(condition, population): &(usize, Population)| {
        let of = study.at(*condition);
        let level = level(common, population.interval);
        let interval = with_interval(population.interval, &level);
        let who = count(population.contributions.len() as u64, "participant");
        format!("The mean threshold of {name}{of} is {}{interval} across {who}.", level(population.function.threshold))
    };
    section.list(results.populations.iter().map(sentence).collect());
    let beyond = format!("beyond the levels, {low} to {high}");
    for condition in &results.beyond {
        let of = study.at(*condition);
        section.warning(format!(
            "The threshold of {name}{of} was not measured: the most probable one of at least half of the participants lies {beyond}."
        ));
    }
    if results.populations.is_empty() && results.beyond.is_empty() {
        let of_person = |function: &PersonFunction| {
            let (who, of) = (&study.people[function.person], study.at(function.condition));
            if let Err(error) = &function.fit {
                return Some(format!("{who}: there is no threshold of {name}{of}: {error}."));
            }
            let fit = function.described()?;
            let level = level(common, Some(fit.threshold));
            let interval = with_interval(Some(fit.threshold), &level);
            let says_nothing = fit.range.iter().all(|end| fit.threshold.contains(*end));
            let what = match function.threshold() {
                None if function.is_beyond() && !says_nothing => {
                    format!("was not measured: the most probable one lies {beyond}")
                }
                Some(threshold) => format!("is {}{interval}", level(threshold)),
                None => format!("is not determined by the answers{interval}"),
            };
            Some(format!("{who}: the threshold of {name}{of} {what}."))
        };
        section.list(results.functions.iter().filter_map(of_person).collect());
    }
    reversed(&mut section, study, results);
    compared(&mut section, study, results, common);
    section
}

/// Says for each pair of conditions whether their thresholds clearly differ.
fn compared(section: &mut Section, study: &TaskStudy, results: &TaskResults, common: &Common) {
    let all = &results.differences;
    let corrected_by = if all.len() > 1 { ", Holm-corrected" } else { "" };
    for difference in all {
        let Some(interval) = difference.mean.interval else { continue };
        let ([one, two], level) = (difference.conditions.map(|one| study.name(one)), level(common, Some(interval)));
        let kind = if common.log { "ratio of the thresholds" } else { "difference of the thresholds" };
        section.text(format!(
            "The {kind} at {one} and at {two} is {}{} over {}{}, {}.",
            level(difference.mean.mean),
            with_interval(Some(interval), &level),
            count(difference.mean.people as u64, "participant"),
            difference.p.map(|p| format!(" ({}{corrected_by})", p_is(p))).unwrap_or_default(),
            if difference.is_clear() { "so they differ" } else { "so it is not clear that they differ" },
        ));
    }
}

fn data(study: &TaskStudy, figures: &[Figure]) -> Section {
    let mut section = Section::new("data", "Data");
    let asked = &study.asked;
    let mut facts = vec![("Task", asked.task.clone())];
    if let Some(protocol) = &asked.protocol {
        facts.push(("Question", protocol.response.question.clone()));
        facts.push(("Sessions", whole(study.files.len() as u64).to_string()));
    }
    facts.extend([("Participants", short_list(&study.people, 20)), ("Answers", whole(study.answers()).to_string())]);
    if let Some(Levels { common, range: [low, high], .. }) = &asked.levels {
        let name = study.asked.factor(&common.parameter);
        facts.push(("Levels", format!("{name} from {low} to {high}")));
    }
    section.facts("What was asked and answered", facts);
    section.figures(figures, &["stimulus"]);
    section.problems(&study.errors, &study.warnings);
    section
}

fn thresholds(study: &TaskStudy, results: &TaskResults, figures: &[Figure]) -> Option<Section> {
    let Levels { common, .. } = study.asked.levels.as_ref()?;
    if results.functions.is_empty() {
        return None;
    }
    let mut section = Section::new("thresholds", "Thresholds");
    section.figures(figures, &["psychometric", "thresholds"]);
    functions(&mut section, study, results, common);
    doubts(&mut section, study, results);
    let failed =
        results.functions.iter().filter_map(|function| Some((of(study, function), function.fit.as_ref().err()?)));
    section.list(failed.map(|(name, error)| format!("{name}: {error}")).collect());
    Some(section)
}

/// Adds the psychometric function of each participant.
fn functions(section: &mut Section, study: &TaskStudy, results: &TaskResults, common: &Common) {
    let level = |own: &PersonFunction| level(common, own.described().map(|fit| fit.threshold));
    let slope = |own: &PersonFunction| further::scaled(false, own.described().map(|fit| fit.slope_interval));
    TableOf::new("The psychometric function of each participant", &results.functions)
        .text("Participant", |own| &study.people[own.person])
        .text("Condition", |own| study.name(own.condition))
        .number("Trials", |own| whole(own.trials()))
        .number("Threshold", |own| own.threshold().map_or_else(|| fixed(None, 0), level(own)))
        .number("95\u{a0}% interval", |own| range(own.described().map(|fit| fit.threshold), level(own)))
        .number("Slope", |own| {
            own.described().and_then(Fit::determined_slope).map_or_else(|| fixed(None, 0), slope(own))
        })
        .number("95\u{a0}% interval of the slope", |own| {
            range(own.described().map(|fit| fit.slope_interval), slope(own))
        })
        .number("Guess rate", |own| unit(own.described().map(|fit| fit.estimate.guess)))
        .number("Lapse rate", |own| unit(own.described().map(|fit| fit.estimate.lapse)))
        .number("p of the fit", |own| probability(own.goodness.map(|goodness| goodness.p)))
        .add_to(section);
}

/// Names a participant, and the condition if there are several.
fn of(study: &TaskStudy, function: &PersonFunction) -> String {
    format!("{}{}", study.people[function.person], study.at(function.condition))
}

/// Says which functions mean nothing.
fn reversed(section: &mut Section, study: &TaskStudy, results: &TaskResults) {
    let odd = results.functions.iter().filter(|function| function.is_reversed);
    let odd: Vec<String> = odd.map(|function| of(study, function)).collect();
    if !odd.is_empty() {
        section.warning(format!(
            "According to the answers, the other end of the levels is easier, so these functions mean nothing and are left out (easier = \
             \"low\" in a definition, or --easier low, says that low levels are easier): {}.",
            short_list(&odd, 12)
        ));
    }
}

/// Says what the answers do not determine.
fn doubts(section: &mut Section, study: &TaskStudy, results: &TaskResults) {
    for (condition, _) in results.populations.iter().filter(|(_, population)| population.interval.is_none()) {
        section.warning(format!(
            "The mean threshold{} has no interval: the functions of all participants rise between the same two levels, or their thresholds \
             are the same. It is not compared with others.",
            study.at(*condition)
        ));
    }
    section.note(
        "A threshold or slope is left out if its most probable value lies outside its interval, or a threshold beyond the levels: the answers \
         do not determine it. Where an interval reaches beyond the levels, only the prior limits it. If p of the fit is small, answers vary \
         more than a psychometric function allows.",
    );
}

fn methods(study: &TaskStudy, results: &TaskResults) -> Section {
    let mut section = Section::new("methods", "Methods");
    let how = match study.asked.measures {
        Some(Measures::Proportions) => " An answer counts as seen if the target was chosen.",
        Some(Measures::Detection) if study.asked.levels.is_some() => {
            " An answer counts as seen if it was yes; catch trials show no target, so F is 0 there, and their answers determine γ."
        }
        Some(Measures::Detection) => " An answer counts as seen if it was yes; catch trials show no target.",
        _ => "",
    };
    if study.asked.measures.is_some() {
        section.text(format!("Practice trials are left out, and the last attempt of a corrected trial counts.{how}"));
    }
    let levels = study.asked.levels.as_ref().filter(|_| !results.functions.is_empty());
    let Some(Levels { model, .. }) = levels else { return section };
    section.text(model_of_a_person(model));
    if !results.populations.is_empty() {
        section.text(MODEL_OVER_PEOPLE);
    }
    if !results.differences.is_empty() {
        section.text(MODEL_OF_DIFFERENCES);
    }
    section
}

/// How the answers of all people are modeled.
const MODEL_OVER_PEOPLE: &str = "Each participant has a threshold of their own, drawn from a normal distribution; all share the width, the lapse rate and the guess rate. This is \
     a mixed model whose likelihood is integrated numerically about the peak of each participant. The interval of the mean is the t \
     interval of what each participant contributes to it (Liang & Zeger 1986, Biometrika 73, 13), weighted by how informative the \
     participant’s trials are (Hartung & Knapp 2001, Stat. Med. 20, 3875).";

/// How the thresholds of two conditions are compared.
const MODEL_OF_DIFFERENCES: &str =
    "Conditions are compared by the differences between the contributions of the participants who have both.";

/// Says how the answers of one person in one condition are modeled.
fn model_of_a_person(model: &Model) -> String {
    let curve = match model.curve {
        Curve::Weibull => "Weibull",
        Curve::Logistic => "logistic",
        Curve::Normal => "cumulative normal",
    };
    let guess = match model.guess {
        Guess::Fixed(guess) => format!("the guess rate γ is {}, and the lapse rate λ is estimated", unit(guess)),
        Guess::Free => "the guess rate γ and the lapse rate λ are estimated".to_owned(),
    };
    let range = if model.range.is_some() { " that could be shown" } else { " of each participant" };
    let varies = if model.overdispersed {
        "Blocks of trials at one level may vary more than binomially, by an estimated overdispersion η (beta-binomial model), \
         which widens the intervals of a participant; single trials cannot tell it."
    } else {
        "Answers vary binomially."
    };
    format!(
        "The psychometric function is ψ(x) = γ + (1 − γ − λ)·F(x) with a {curve} F; {guess}. {varies} The threshold is the level with F = ½, \
         so that guesses and lapses do not move it{}. It is the most probable one under the priors of Schütt, Harmeling, Macke & Wichmann \
         (2016, Vision Res. 122, 105), over the range of the levels{range}; its 95\u{a0}% interval lies between quantiles of 60,000 draws \
         from the posterior distribution (Goodman & Weare 2010, Commun. Appl. Math. Comput. Sci. 5, 65). The goodness of fit compares the \
         deviance with those of 1,000 simulated studies (Wichmann & Hill 2001, Percept. Psychophys. 63, 1293).",
        match model.guess {
            Guess::Fixed(guess) if guess > 0.0 =>
                format!(" (a proportion of {} correct answers without lapses)", unit((1.0 + guess) / 2.0)),
            _ => String::new(),
        }
    )
}

fn repeat(study: &TaskStudy, provenance: &Provenance) -> Section {
    let mut section = Section::new("repeat", "Repeat this analysis");
    provenance.tell(&mut section);
    TableOf::new("Files", &study.files)
        .text("File", |(path, _)| path.display().to_string())
        .number("Rows", |(_, rows)| whole(*rows as u64))
        .add_to(&mut section);
    definition(&mut section, study.asked.protocol.as_ref());
    section
}
