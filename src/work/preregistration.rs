//! The text of a preregistration, from a definition and a plan: what will be measured, how many people, how it will be
//! analyzed, and what each result would mean. What only its author knows is in square brackets.

use std::fmt::Write;

use super::{
    plan::{OPTIONS, Plan, Planned, in_order},
    plan_thresholds::{Found, PlannedThresholds},
    words,
};
use crate::{
    analysis::{
        FEW_FOR_LIKELIHOOD_RATIOS, LEAST_FOR_SIGNS, Resampling, Slopes,
        power::{Effect, Hypothesis, Power, Precision, Quantity, Sampling, Test},
        tasks::psychometric::Model,
    },
    experiment::{Factor, Protocol},
    report::{
        document::numbers::{count, list},
        names,
        tasks::{MODEL_OF_DIFFERENCES, MODEL_OVER_PEOPLE, method, model_of_a_person, task},
    },
};

/// Practice trials and corrected trials, whatever the task.
const EXCLUSIONS: &str = "Practice trials are not analyzed, and only the last attempt of each trial counts. Unanswered trials \
    are missing; they are not replaced. No other trial and no participant is excluded.";

impl Plan {
    /// Writes the preregistration of a study that was planned with this request, in Markdown.
    pub fn preregistration(&self, found: &Found) -> String {
        let (protocol, of_task, options) = match found {
            Found::Ratings(planned) => {
                let spec = &planned.plan.spec;
                let options = format!(" --terms {} --link {} --slopes {}", spec.terms, spec.link, spec.slopes);
                (&planned.protocol, planned.sections(), options)
            }
            Found::Thresholds(planned) => (&planned.protocol, planned.sections(), String::new()),
        };
        let title = if protocol.title.is_empty() { &protocol.name } else { &protocol.title };
        let collected = "[State whether data have been collected, and who has seen them.]".to_owned();
        let programs = format!(
            "The study is run and analyzed with machband {}. Its definition has the SHA-256 {}. The power was computed with\n\n    \
             machband plan {}\n\nand the analysis will be\n\n    machband analyze results/{}{options} --out analysis",
            env!("CARGO_PKG_VERSION"),
            crate::store::definition::hash(protocol),
            words(self).join(" "),
            protocol.name,
        );
        let mut text = format!("# Preregistration: {title}\n");
        let of_task = HEADINGS.into_iter().zip(of_task);
        for (heading, body) in
            [("Data collection", collected)].into_iter().chain(of_task).chain([("Programs", programs)])
        {
            // Writing to a string cannot fail.
            let _ = write!(text, "\n## {heading}\n\n{body}\n");
        }
        text
    }
}

/// The headings of what depends on the task.
const HEADINGS: [&str; 6] =
    ["Hypotheses", "Design", "Sample size", "Exclusions", "Analysis", "What each result would mean"];

/// Returns how a session begins and what is shown between trials, whatever the task.
fn course(protocol: &Protocol) -> String {
    let practice = match protocol.design.practice {
        0 => String::new(),
        n => format!("{} come first. ", count(n.into(), "practice trial")),
    };
    format!(
        "{practice}A uniform field of relative luminance {} is shown for {} s before each trial.",
        protocol.recovery.level, protocol.recovery.duration_s,
    )
}

fn viewing(protocol: &Protocol) -> String {
    format!(
        "The viewing distance is {} cm, and the stimulus is {}° wide. The remaining parameters of the stimulus are in the definition.",
        protocol.viewing.distance_cm, protocol.viewing.window_deg
    )
}

/// Lists the factors with their levels.
fn factors(protocol: &Protocol) -> String {
    let known = Some(protocol.stimulus.parameters());
    let levels = |factor: &Factor| {
        let shown = factor.levels.iter().map(|level| names::level(known, &factor.name, &level.to_string()).to_string());
        shown.collect::<Vec<_>>().join(", ")
    };
    let named =
        protocol.factors.iter().map(|factor| format!("{} ({})", names::factor(known, &factor.name), levels(factor)));
    list(&named.collect::<Vec<_>>())
}

/// Says how many people are tested, if some number tried is enough for all effects.
fn decision(tried: &[u32], has_effects: bool, enough: impl Fn(u32) -> bool, target: f64) -> String {
    if !has_effects {
        return "[N] participants will be tested. No effect is planned for, so no power decides the number.".to_owned();
    }
    // More people can only help, so a number is enough if all larger ones are.
    let least = tried.iter().rev().take_while(|people| enough(**people)).last();
    let target = format!("{:.0} %", 100.0 * target);
    let numbers = list(&tried.iter().map(ToString::to_string).collect::<Vec<_>>());
    match least {
        Some(people) => format!(
            "{} will be tested: the smallest number tried ({numbers}) at which the 95 % interval of the power lies at \
             or above {target} for every effect above.",
            count((*people).into(), "participant")
        ),
        None => format!(
            "[N] participants will be tested. At no number tried ({numbers}) does the 95 % interval of the power lie at or \
             above {target} for every effect above."
        ),
    }
}

const UNDECIDED: &str = "Otherwise, the study is inconclusive; this will not be called evidence of no effect.";

impl Planned {
    /// Returns what stands below the [`HEADINGS`].
    fn sections(&self) -> [String; 6] {
        let exclusions = format!(
            "{EXCLUSIONS} [Or name each reason, with its limit, such as --min-time 0.2, and whether excluded participants are \
             replaced.]"
        );
        let hypotheses = bullets(self.effects().map(|one| hypothesis(self, one)).collect());
        let meanings = bullets(self.effects().map(|one| meaning(self, one)).collect());
        [hypotheses, self.design(), self.sample_size(), exclusions, self.analysis(), meanings]
    }

    /// Returns the hypotheses, each once: about the terms of the model, and about the factors of its interactions.
    fn effects(&self) -> impl Iterator<Item = &Hypothesis> {
        let all = &self.plan.hypotheses;
        let is_of_model = |own: &Hypothesis| own.test == Test::LikelihoodRatio;
        all.iter().filter(move |own| is_of_model(own) || !all.iter().any(|o| is_of_model(o) && o.term == own.term))
    }

    fn design(&self) -> String {
        let protocol = &self.protocol;
        let categories = protocol.response.categories.iter().enumerate();
        let categories: Vec<String> =
            categories.map(|(rating, category)| format!("{rating} ({})", category.label)).collect();
        format!(
            "Every participant rates every combination of {}: {}, each {}, which makes {} in a session of about {}. {} The answers are \
             {}. {}",
            factors(protocol),
            count(protocol.conditions().len() as u64, "condition"),
            match protocol.design.repetitions {
                1 => "once".to_owned(),
                2 => "twice".to_owned(),
                n => format!("{n} times"),
            },
            count(protocol.main_trials() as u64, "rating"),
            count(protocol.minutes(), "minute"),
            course(protocol),
            list(&categories),
            viewing(protocol)
        )
    }

    fn sample_size(&self) -> String {
        let enough = |people: u32| {
            let own = |power: &&Power| power.participants == people && self.hypothesis(power).effect.is_some();
            let mut powers = self.powers.iter().filter(own).filter(|power| self.leads(power));
            powers.clone().count() > 0 && powers.all(|power| power.interval().low >= self.target)
        };
        let mut tried: Vec<u32> = self.powers.iter().map(|power| power.participants).collect();
        tried.dedup();
        let has_effects = self.effects().any(|hypothesis| hypothesis.effect.is_some());
        let decision = decision(&tried, has_effects, enough, self.target);
        format!(
            "{decision} The data are not analyzed before all have been tested. [Say why effects of this size are of interest.] The \
             simulation found:\n\n{}",
            bullets(self.sentences(OPTIONS))
        )
    }

    fn analysis(&self) -> String {
        let spec = &self.plan.spec;
        let usual = Sampling::default().alpha;
        let is_one = self.powers.iter().all(|power| power.participants == 1);
        let slopes = match spec.slopes {
            Slopes::None => "random intercepts",
            Slopes::Independent => {
                "random intercepts and, where the design supports them, independent random slopes of each term"
            }
            Slopes::Correlated => "correlated random intercepts and slopes",
        };
        let effects = if is_one {
            "It has no random effects: its conclusions are about the trials of one participant, not about people."
                .to_owned()
        } else {
            format!("Participants have {slopes}. The likelihood is integrated by Laplace’s approximation.")
        };
        format!(
            "The ratings are modeled with a cumulative-link {}model with {} link and the terms {}. {effects} Each term is tested by the likelihood ratio against the model without it, at \
             the level {}{}. With fewer than {FEW_FOR_LIKELIHOOD_RATIOS} participants, p comes from a parametric bootstrap with up to \
             {} simulated studies.{} The p values of different terms are not corrected for their number. Levels of a factor are \
             compared in the same model, corrected with Holm’s method.\n\n\
             Interactions of two factors that are not in the model are tested from its residuals (with fewer than \
             {LEAST_FOR_SIGNS} participants, by likelihood ratios in simulated studies), corrected for their number. If p of one \
             is below {}, the effect of one factor is described at each level of the other, and no main effect is described alone. \
             Proportional odds, drift over the trials and the dependence of successive trials are checks; they do not change the \
             analysis. Everything else is exploratory and will be called so.{}",
            if is_one { "" } else { "mixed " },
            spec.link,
            list(&spec.terms.iter().map(|term| self.in_words(&term.to_string())).collect::<Vec<_>>()),
            self.sampling.alpha,
            if spec.terms.iter().any(|term| spec.terms.is_marginal(term)) {
                "; the effect of a factor in an interaction is its mean over the levels of the other factor"
            } else {
                ""
            },
            Resampling::default().draws,
            if is_one {
                ""
            } else if spec.slopes == Slopes::None {
                " Because effects have no random slopes, conclusions about the effect of a factor that varies within participants rest on \
                 Friedman’s test of its levels, at the same level, and not on the likelihood ratio."
            } else {
                " If the design supports no random slope of a term that varies within participants, Friedman’s test of its \
                 levels takes the place of this test."
            },
            self.sampling.alpha,
            if usual == self.sampling.alpha {
                String::new()
            } else {
                let alpha = self.sampling.alpha;
                format!(
                    " The sentences of the analysis report use the level {usual}; p is compared with {alpha} by hand."
                )
            }
        )
    }
}

impl PlannedThresholds {
    /// Returns what stands below the [`HEADINGS`].
    fn sections(&self) -> [String; 6] {
        let exclusions = format!("{EXCLUSIONS} [Or name each reason, and whether excluded participants are replaced.]");
        let hypotheses = bullets(self.differences().map(|(found, truth)| self.hypothesis(found, truth)).collect());
        let meanings = bullets(self.differences().map(|(found, truth)| self.meaning(found, truth)).collect());
        [hypotheses, self.design(), self.sample_size(), exclusions, self.analysis(), meanings]
    }

    /// Returns what a precision is that of, in words.
    pub fn told(&self, quantity: &Quantity) -> String {
        let Quantity::Difference { factor, level, .. } = *quantity else { return self.name(quantity) };
        let (of, known) = (&self.protocol.factors[factor], Some(self.protocol.stimulus.parameters()));
        let [level, first] = [level, 0].map(|place| names::level(known, &of.name, &of.levels[place].to_string()));
        format!("{} {level} − {first}", names::factor(known, &of.name))
    }

    /// Returns the differences between levels, each with its planned size.
    fn differences(&self) -> impl Iterator<Item = (&Precision, f64)> {
        let first =
            |one: &&Precision| one.participants == self.found[0].participants && one.trials == self.found[0].trials;
        self.found.iter().filter(first).filter_map(|one| Some((one, one.quantity.truth()?)))
    }

    fn hypothesis(&self, found: &Precision, truth: f64) -> String {
        let name = self.told(&found.quantity);
        if truth == 0.0 {
            return format!("{name}: no difference of thresholds is predicted, and none is planned for.");
        }
        let order = if truth > 0.0 { "higher" } else { "lower" };
        format!(
            "{name}: the threshold at the first of these levels is {order}. The difference planned for is {truth} {}.",
            self.unit()
        )
    }

    fn design(&self) -> String {
        let protocol = &self.protocol;
        let levels = protocol.adaptive.as_ref().map_or_else(String::new, |adaptive| {
            let [low, high] = adaptive.range();
            let known = Some(protocol.stimulus.parameters());
            let (chosen, parameter) = (method(&adaptive.method), names::factor(known, &adaptive.common.parameter));
            format!("The level, {parameter} from {low} to {high}, is chosen by {chosen}. ")
        });
        let conditions = match protocol.conditions().len() as u64 {
            1 => "There is one condition.".to_owned(),
            n => format!(
                "Every participant answers in {}, the combinations of {}.",
                count(n, "condition"),
                factors(protocol)
            ),
        };
        format!(
            "The task is {} and asks “{}” {levels}{conditions} {} {}",
            task(&protocol.task),
            protocol.response.question,
            course(protocol),
            viewing(protocol)
        )
    }

    fn sample_size(&self) -> String {
        let sorted = |number: fn(&Precision) -> u32| in_order(&self.found.iter().map(number).collect::<Vec<_>>());
        let (people, trials) = (sorted(|one| one.participants), sorted(|one| one.trials));
        let most = trials.last().copied().unwrap_or_default();
        let enough = |people: u32| {
            let own = self.found.iter().filter(|one| one.participants == people && one.trials == most);
            let mut effects = own.filter(|one| one.quantity.differs());
            effects.clone().count() > 0 && effects.all(|one| one.share().1.low >= self.target)
        };
        let row = |one: &Precision| {
            let number =
                |what: &str, value: Option<f64>| value.map_or_else(String::new, |value| format!(", {what} {value:.3}"));
            let tested = one.quantity.truth().filter(|_| one.half_width.is_some());
            let what = if one.quantity.differs() { "power" } else { "false alarms" };
            let share = tested.map_or_else(String::new, |_| format!(", {what} {:.0} %", 100.0 * one.share().0));
            format!(
                "{} with {} of each condition: {}{}{}{share}",
                count(one.participants.into(), "participant"),
                count(one.trials.into(), "trial"),
                self.told(&one.quantity),
                number("half-width of the 95 % interval", one.half_width),
                number("root mean square error", one.error),
            )
        };
        format!(
            "{} Each answers {} of each condition. The data are not analyzed before all have been tested. [Say why differences of \
             this size are of interest.] {} simulated studies of each size found, in {}:\n\n{}",
            decision(&people, self.differences().any(|(_, truth)| truth != 0.0), enough, self.target),
            count(most.into(), "trial"),
            self.sampling.studies,
            self.unit(),
            bullets(self.found.iter().map(row).collect())
        )
    }

    fn analysis(&self) -> String {
        let model = Model::of(&self.protocol).map_or_else(String::new, |model| model_of_a_person(&model));
        format!(
            "{model}\n\n{MODEL_OVER_PEOPLE} {MODEL_OF_DIFFERENCES}\n\nA difference is found if its 95 % interval excludes 0. The intervals of different \
             comparisons are not corrected for their number; the sentences of the report are (Holm), so they may find fewer differences. \
             Everything else is exploratory and will be called so."
        )
    }

    fn meaning(&self, found: &Precision, truth: f64) -> String {
        let name = self.told(&found.quantity);
        if truth == 0.0 {
            return format!("{name}: a 95 % interval excluding 0 is a difference that was not predicted. {UNDECIDED}");
        }
        let [supports, contradicts] = if truth > 0.0 { ["above", "below"] } else { ["below", "above"] };
        format!(
            "{name}: a 95 % interval that lies {supports} 0 supports the hypothesis, and one that lies {contradicts} 0 contradicts it. \
             {UNDECIDED}"
        )
    }
}

fn bullets(items: Vec<String>) -> String {
    items.iter().map(|item| format!("- {item}")).collect::<Vec<_>>().join("\n")
}

/// Returns the term of a hypothesis in words, and the levels that are rated higher and lower.
fn in_words(planned: &Planned, hypothesis: &Hypothesis) -> (String, [String; 2]) {
    let known = Some(planned.protocol.stimulus.parameters());
    let level = |level: &String| names::level(known, &hypothesis.term, level).to_string();
    let levels = hypothesis.effect.as_ref().map(|Effect { above, below, .. }| [above, below].map(level));
    (names::term(known, &hypothesis.term), levels.unwrap_or_default())
}

fn hypothesis(planned: &Planned, hypothesis: &Hypothesis) -> String {
    let (term, [above, below]) = in_words(planned, hypothesis);
    match &hypothesis.effect {
        Some(Effect { logits, .. }) => {
            let size =
                logits.map_or_else(String::new, |logits| format!(" The effect planned for is {logits:.2} logits."));
            format!("{term}: ratings at {above} are higher than at {below}.{size}")
        }
        None => format!("{term}: no effect is predicted."),
    }
}

/// Says what would count as which result.
fn meaning(planned: &Planned, hypothesis: &Hypothesis) -> String {
    let (alpha, (term, [above, below])) = (planned.sampling.alpha, in_words(planned, hypothesis));
    match &hypothesis.effect {
        Some(_) => format!(
            "{term}: p below {alpha} with a higher estimate at {above} than at {below} supports the hypothesis, and p below {alpha} \
             with the opposite order contradicts it. {UNDECIDED}"
        ),
        None => format!("{term}: p below {alpha} indicates an effect that was not predicted. {UNDECIDED}"),
    }
}
