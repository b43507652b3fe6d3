//! Describes the answers to a task in a document.

use super::{
    results::{PersonFunction, TaskResults},
    sections,
    study::{Asked, Estimand, Levels, Measure, TaskStudy, scaled},
};
use crate::{
    analysis::tasks::{
        population::Mean,
        psychometric::{Guess, Model},
    },
    experiment::task::Curve,
    report::{
        document::{Document, Section, TableOf, count, list, p_is, short_list, unit, whole, with_interval},
        figures::Figure,
        study::{Provenance, definition},
    },
};

/// Describes a study; `provenance` says how to repeat the analysis.
pub fn document(
    study: &TaskStudy,
    results: &TaskResults,
    figures: &[Figure],
    provenance: Option<&Provenance>,
) -> Document {
    let mut sections = vec![summary(study, results), data(study, figures)];
    sections.extend(sections::of_results(study, results, figures));
    sections.push(methods(study, results));
    sections.extend(provenance.map(|provenance| repeat(study, provenance)));
    let Asked { title, protocol, .. } = &study.asked;
    let subtitle = match protocol {
        Some(protocol) => format!("Experiment {}: task {}", protocol.name, protocol.task.name()),
        None => "A table of answers".to_owned(),
    };
    Document { title: title.clone(), subtitle, sections }
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
    section.list(means(study, results));
    section.list(results.comparisons.iter().flat_map(|found| sections::order(study, found)).collect());
    if let Some(levels) = study.asked.levels() {
        not_measured(&mut section, study, results, levels);
    }
    compared(&mut section, study, results);
    section
}

/// Says what the mean of each condition is. Values of a scale mean something only beside each other.
fn means(study: &TaskStudy, results: &TaskResults) -> Vec<String> {
    let estimand = study.asked.estimand();
    let guess = match (&study.asked.measure, &study.asked.protocol) {
        (Measure::Proportions, Some(protocol)) => format!("; guessing gives {}", unit(protocol.task.guess())),
        _ => String::new(),
    };
    let kind = if estimand.log { "geometric mean " } else { "mean " };
    let of_condition = |condition: usize| {
        let (at, found) = (study.at(condition), results.means.iter().find(|(of, _)| *of == condition));
        let Some((_, Mean { mean, interval, people })) = found else {
            return matches!(study.asked.measure, Measure::Sensitivity)
                .then(|| format!("There is no d’{at}, because no participant had both targets and catch trials."));
        };
        let (kind, over) = match *people {
            1 => ("", " for 1 participant".to_owned()),
            people => (kind, format!(", averaged over {}", count(people as u64, "participant"))),
        };
        let (format, Estimand { name, of, .. }) = (estimand.format(*interval), &estimand);
        let interval = with_interval(*interval, &format);
        Some(format!("The {kind}{name}{of}{at} is {}{interval}{over}{guess}.", format(*mean)))
    };
    let conditions = if results.comparisons.is_some() { 0 } else { study.asked.conditions.len() };
    (0..conditions).filter_map(of_condition).collect()
}

/// Says which thresholds were not measured, which functions mean nothing and, without means, what the threshold of each participant
/// is.
fn not_measured(section: &mut Section, study: &TaskStudy, results: &TaskResults, levels: &Levels) {
    let Levels { common, range: [low, high], .. } = levels;
    let name = study.asked.factor(&common.parameter);
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
            if let Err(error) = &function.estimate {
                return Some(format!("{who}: there is no threshold of {name}{of}: {error}."));
            }
            let fit = function.described()?;
            let level = scaled(common.log, Some(fit.threshold));
            let interval = with_interval(Some(fit.threshold), &level);
            let says_nothing = function.range.iter().all(|end| fit.threshold.contains(*end));
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
    let odd = results.functions.iter().filter(|function| function.is_reversed);
    let odd: Vec<String> = odd.map(|function| sections::of(study, function)).collect();
    if !odd.is_empty() {
        section.warning(format!(
            "According to the answers, the other end of the levels is easier, so these functions mean nothing and are left out (easier = \
             \"low\" in a definition, or --easier low, says that low levels are easier): {}.",
            short_list(&odd, 12)
        ));
    }
}

/// The most differences that each have a sentence.
const MAX_TOLD: usize = 6;

/// Says whether conditions clearly differ.
fn compared(section: &mut Section, study: &TaskStudy, results: &TaskResults) {
    let (all, estimand) = (&results.differences, study.asked.estimand());
    if all.len() > MAX_TOLD {
        let clear = all.iter().filter(|difference| difference.is_clear()).count();
        return section.text(format!(
            "Of {} pairs of conditions, {clear} clearly differ (Holm-corrected p below .05): see differences.csv.",
            all.len()
        ));
    }
    let corrected_by = if all.len() > 1 { ", Holm-corrected" } else { "" };
    for difference in all {
        let Some(interval) = difference.mean.interval else { continue };
        let ([one, two], level) = (difference.conditions.map(|one| study.name(one)), estimand.format(Some(interval)));
        let (kind, than) = if estimand.log { ("ratio", "to") } else { ("difference", "from") };
        section.text(format!(
            "The {kind} of the {} at {one} {than} that at {two} is {}{} over {}{}, {}.",
            estimand.name,
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
    let mut facts = Vec::new();
    if let Some(protocol) = &asked.protocol {
        facts.push(("Task", protocol.task.name().to_owned()));
        facts.push(("Question", protocol.response.question.clone()));
        facts.push(("Sessions", whole(study.files.len() as u64).to_string()));
    }
    facts.extend([("Participants", short_list(&study.people, 20)), ("Answers", whole(study.answers()).to_string())]);
    if let Some(Levels { common, range: [low, high], .. }) = asked.levels() {
        let name = study.asked.factor(&common.parameter);
        facts.push(("Levels", format!("{name} from {low} to {high}")));
    }
    section.facts("What was asked and answered", facts);
    section.figures(figures, &["stimulus"]);
    section.problems(&study.errors, &study.warnings);
    section
}

fn methods(study: &TaskStudy, results: &TaskResults) -> Section {
    let mut section = Section::new("methods", "Methods");
    let how = match (&study.asked.measure, study.asked.has_catches()) {
        (Measure::Thresholds(_), true) => {
            " An answer counts as seen if it was yes; catch trials show no target, so F is 0 there, and their answers determine γ."
        }
        (_, true) => " An answer counts as seen if it was yes; catch trials show no target.",
        (Measure::Thresholds(_) | Measure::Proportions, false) => " An answer counts as seen if the target was chosen.",
        _ => "",
    };
    if study.asked.protocol.is_some() {
        section.text(format!("Practice trials are left out, and the last attempt of a corrected trial counts.{how}"));
    }
    let levels = study.asked.levels();
    if let Some(Levels { model, .. }) = levels {
        section.text(model_of_a_person(model));
        if !results.populations.is_empty() {
            section.text(MODEL_OVER_PEOPLE);
        }
    }
    if !results.differences.is_empty() {
        section.text(match (levels, &results.comparisons) {
            (Some(_), _) => "Conditions are compared by the differences between the contributions of the participants who have both.",
            (None, Some(_)) => "Conditions are compared by t tests of their differences, whose standard errors come from the same studies as the intervals.",
            (None, None) => "Conditions are compared by t tests of the differences between the values of the participants who have both.",
        });
    }
    section
}

/// How the answers of all people are modeled.
const MODEL_OVER_PEOPLE: &str = "Each participant has a threshold of their own, drawn from a normal distribution; all share the width, the lapse rate and the guess rate. This is \
     a mixed model whose likelihood is integrated numerically about the peak of each participant. The interval of the mean is the t \
     interval of what each participant contributes to it (Liang & Zeger 1986, Biometrika 73, 13), weighted by how informative the \
     participant’s trials are (Hartung & Knapp 2001, Stat. Med. 20, 3875).";

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
         (2016, Vision Res. 122, 105), over the range of the levels{range}; its 95\u{a0}% interval lies between quantiles of its \
         marginal posterior distribution, which is integrated over a grid. The goodness of fit compares the deviance with those of 1,000 simulated studies (Wichmann & Hill 2001, Percept. Psychophys. 63, 1293).",
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
