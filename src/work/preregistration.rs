//! The text of a preregistration, from a definition and a plan: what will be measured, how many people, how it will be
//! analyzed, and what each result would mean. What only its author knows is in square brackets.

use std::fmt::Write;

use super::{
    plan::{OPTIONS, Plan, Planned},
    words,
};
use crate::{
    analysis::{
        FEW_FOR_LIKELIHOOD_RATIOS, LEAST_FOR_SIGNS, Resampling, Slopes,
        power::{Effect, Hypothesis, Power, Sampling, Test},
    },
    experiment::Factor,
    report::{
        document::numbers::{count, list},
        names,
    },
    stimulus::ParameterValue,
};

impl Plan {
    /// Writes the preregistration of a study of ratings that was planned with this request, in Markdown.
    pub fn preregistration(&self, planned: &Planned) -> String {
        let (protocol, spec) = (&planned.protocol, &planned.plan.spec);
        let title = if protocol.title.is_empty() { &protocol.name } else { &protocol.title };
        let programs = format!(
            "The study is run and analyzed with machband {}. Its definition has the SHA-256 {}. The power was computed with\n\n    \
             machband plan {}\n\nand the analysis will be\n\n    machband analyze results/{} --terms {} --link {} --slopes {} --out analysis",
            env!("CARGO_PKG_VERSION"),
            crate::store::definition::hash(protocol),
            words(self).join(" "),
            protocol.name,
            spec.terms,
            spec.link,
            spec.slopes,
        );
        let of_each = |say: fn(&Planned, &Hypothesis) -> String| {
            bullets(planned.effects().map(|hypothesis| say(planned, hypothesis)).collect())
        };
        let mut text = format!("# Preregistration: {title}\n");
        for (heading, body) in [
            ("Data collection", "[State whether data have been collected, and who has seen them.]".to_owned()),
            ("Hypotheses", of_each(hypothesis)),
            ("Design", planned.design()),
            ("Sample size", planned.sample_size()),
            ("Exclusions", EXCLUSIONS.to_owned()),
            ("Analysis", planned.analysis()),
            ("What each result would mean", of_each(meaning)),
            ("Programs", programs),
        ] {
            // Writing to a string cannot fail.
            let _ = write!(text, "\n## {heading}\n\n{body}\n");
        }
        text
    }
}

/// What is left out.
const EXCLUSIONS: &str = "Practice trials are not analyzed, and only the last attempt of each trial counts. Unanswered trials \
    are missing; they are not replaced. No other trial and no participant is excluded. [Or name each reason, with its limit, \
    such as --min-time 0.2, and whether excluded participants are replaced.]";

impl Planned {
    /// Returns the hypotheses, each once: about the terms of the model, and about the factors of its interactions.
    fn effects(&self) -> impl Iterator<Item = &Hypothesis> {
        let all = &self.plan.hypotheses;
        let is_of_model = |own: &Hypothesis| own.test == Test::LikelihoodRatio;
        all.iter().filter(move |own| is_of_model(own) || !all.iter().any(|o| is_of_model(o) && o.term == own.term))
    }

    fn design(&self) -> String {
        let (protocol, known) = (&self.protocol, Some(self.protocol.stimulus.parameters()));
        let factor = |factor: &Factor| {
            let level = |level: &ParameterValue| names::level(known, &factor.name, &level.to_string()).to_string();
            let levels: Vec<String> = factor.levels.iter().map(level).collect();
            format!("{} ({})", names::factor(known, &factor.name), levels.join(", "))
        };
        let categories = protocol.response.categories.iter().enumerate();
        let categories: Vec<String> =
            categories.map(|(rating, category)| format!("{rating} ({})", category.label)).collect();
        let practice = match protocol.design.practice {
            0 => String::new(),
            n => format!("{} come first. ", count(n.into(), "practice trial")),
        };
        format!(
            "Every participant rates every combination of {}: {}, each {}, which makes {} in a session of about {}. {practice}A \
             uniform field of relative luminance {} is shown for {} s before each trial. The answers are {}. The viewing distance is \
             {} cm, and the stimulus is {}° wide. The remaining parameters of the stimulus are in the definition.",
            list(&protocol.factors.iter().map(factor).collect::<Vec<_>>()),
            count(protocol.conditions().len() as u64, "condition"),
            match protocol.design.repetitions {
                1 => "once".to_owned(),
                2 => "twice".to_owned(),
                n => format!("{n} times"),
            },
            count(protocol.main_trials() as u64, "rating"),
            count(protocol.minutes(), "minute"),
            protocol.recovery.level,
            protocol.recovery.duration_s,
            list(&categories),
            protocol.viewing.distance_cm,
            protocol.viewing.window_deg
        )
    }

    fn sample_size(&self) -> String {
        let enough = |people: &&u32| {
            let own = |power: &&Power| power.participants == **people && self.hypothesis(power).effect.is_some();
            let mut powers = self.powers.iter().filter(own);
            powers.clone().count() > 0 && powers.all(|power| power.interval().low >= self.target)
        };
        let mut tried: Vec<u32> = self.powers.iter().map(|power| power.participants).collect();
        tried.dedup();
        let numbers = list(&tried.iter().map(ToString::to_string).collect::<Vec<_>>());
        let target = format!("{:.0} %", 100.0 * self.target);
        // More people can only help, so a number is enough if all larger ones are.
        let least = tried.iter().rev().take_while(enough).last();
        let decision = match least {
            _ if self.effects().all(|hypothesis| hypothesis.effect.is_none()) => {
                "[N] participants will be tested. No effect is planned for, so no power decides the number.".to_owned()
            }
            Some(people) => format!(
                "{} will be tested: the smallest number tried ({numbers}) at which the 95 % interval of the power lies at or above \
                 {target} for every test of every effect above.",
                count((*people).into(), "participant")
            ),
            None => format!(
                "[N] participants will be tested. At no number tried ({numbers}) does the 95 % interval of the power lie at or above \
                 {target} for every test of every effect above."
            ),
        };
        format!(
            "{decision} The data are not analyzed before all have been tested. [Say why effects of this size are of interest.] The \
             simulation found:\n\n{}",
            bullets(self.sentences(OPTIONS))
        )
    }

    fn analysis(&self) -> String {
        let (spec, alpha) = (&self.plan.spec, self.sampling.alpha);
        let slopes = match spec.slopes {
            Slopes::None => "random intercepts",
            Slopes::Independent => {
                "random intercepts and, where the design supports them, independent random slopes of each term"
            }
            Slopes::Correlated => "correlated random intercepts and slopes",
        };
        let ranks = if spec.slopes == Slopes::None {
            "Because effects have no random slopes, conclusions about the effect of a factor that varies within participants rest on \
             Friedman’s test of its levels, at the same level, and not on the likelihood ratio."
        } else {
            "If the design supports no random slope of a term that varies within participants, Friedman’s test of its levels takes \
             the place of this test."
        };
        format!(
            "The ratings are modeled with a cumulative-link mixed model with {} link and the terms {}. Participants have {slopes}. The \
             likelihood is integrated by Laplace’s approximation. Each term is tested by the likelihood ratio against the model \
             without it, at the level {alpha}; the effect of a factor in an interaction is its mean over the levels of the other factor. \
             With fewer than {FEW_FOR_LIKELIHOOD_RATIOS} participants, p comes from a parametric bootstrap with up to {} simulated \
             studies. {ranks} A single participant has no random effects and no such test, and conclusions are then about that person \
             only. The p values of different terms are not corrected for their number. Levels of a factor are compared in the same \
             model, corrected with Holm’s method.\n\n\
             Interactions of two factors that are not in the model are tested from its residuals (with fewer than \
             {LEAST_FOR_SIGNS} participants, by likelihood ratios in simulated studies), corrected for their number. If p of one \
             is below {alpha}, the effect of one factor is described at each level of the other, and no main effect is described alone. \
             Proportional odds, drift over the trials and the dependence of successive trials are checks; they do not change the \
             analysis. Everything else is exploratory and will be called so. The sentences of the analysis report use the level {}.",
            spec.link,
            list(&spec.terms.iter().map(|term| self.in_words(&term.to_string())).collect::<Vec<_>>()),
            Resampling::default().draws,
            Sampling::default().alpha,
        )
    }
}

const UNDECIDED: &str = "Otherwise, the study is inconclusive; this will not be called evidence of no effect.";

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
