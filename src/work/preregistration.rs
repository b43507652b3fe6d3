//! The text of a preregistration, from a definition and a plan: what will be measured, how many people, how it will be
//! analyzed, and what each result would mean. What only its author knows stands in square brackets.

use std::fmt::Write;

use super::plan::{Plan, Planned};
use crate::{
    analysis::{
        FEW_FOR_LIKELIHOOD_RATIOS, Resampling, Slopes,
        power::{Effect, Hypothesis, Power, Test},
    },
    report::document::numbers::{count, list},
    work::words,
};

impl Plan {
    /// Writes the preregistration of a study that was planned with this request, in Markdown.
    #[must_use]
    pub fn preregistration(&self, planned: &Planned) -> String {
        let protocol = &planned.protocol;
        let title = if protocol.title.is_empty() { &protocol.name } else { &protocol.title };
        let mut text = format!("# Preregistration: {title}\n");
        let mut section = |heading: &str, body: String| {
            // Writing to a string cannot fail.
            let _ = write!(text, "\n## {heading}\n\n{body}\n");
        };
        section("Data collection", "[State whether data have been collected, and who has seen them.]".to_owned());
        section("Hypotheses", bullets(planned.effects().map(|(_, one)| hypothesis(one)).collect()));
        section("Design", planned.design());
        section("Sample size", planned.sample_size());
        section(
            "Exclusions",
            "Practice trials are not analyzed, and only the last attempt of each trial counts. Unrated trials are missing; they \
             are not replaced. No other trial and no participant is excluded. [Or name each reason, with its limit, such as \
             --min-time 0.2, and whether excluded participants are replaced.]"
                .to_owned(),
        );
        section("Analysis", planned.analysis());
        section(
            "What each result would mean",
            bullets(planned.effects().map(|(_, one)| meaning(planned, one)).collect()),
        );
        let shell = |command: &str, words: Vec<String>| format!("    machband {command} {}", words.join(" "));
        section(
            "Programs",
            format!(
                "The study is run and analyzed with machband {}. Its definition has the SHA-256 {}. The power was computed with\n\n\
                 {}\n\nand the analysis will be\n\n    machband analyze results/{} --terms {} --link {} --slopes {} --out analysis",
                env!("CARGO_PKG_VERSION"),
                crate::store::definition::hash(protocol),
                shell("plan", words(self)),
                protocol.name,
                planned.plan.spec().terms,
                planned.plan.spec().link,
                planned.plan.spec().slopes
            ),
        );
        text
    }
}

impl Planned {
    /// Returns the hypotheses about the terms of the model.
    fn effects(&self) -> impl Iterator<Item = (usize, &Hypothesis)> {
        let all = self.plan.hypotheses().iter().enumerate();
        all.filter(|(_, hypothesis)| hypothesis.test == Test::LikelihoodRatio)
    }

    fn design(&self) -> String {
        let protocol = &self.protocol;
        let levels = |factor: &crate::experiment::Factor| {
            factor.levels.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
        };
        let factors: Vec<String> =
            protocol.factors.iter().map(|factor| format!("{} ({})", factor.name, levels(factor))).collect();
        let categories = protocol.response.categories.iter().enumerate();
        let categories: Vec<String> =
            categories.map(|(rating, category)| format!("{rating} ({})", category.label)).collect();
        format!(
            "Every participant rates every combination of {}: {}, each {}, which makes {} in a session of about {}. {} come first. \
             A uniform field of relative luminance {} is shown for {} s before each stimulus. The answers are {}. The viewing \
             distance is {} cm, and the stimulus is {}° wide. The remaining parameters of the stimulus are in the definition.",
            list(&factors),
            count(protocol.conditions().len() as u64, "condition"),
            match protocol.design.repetitions {
                1 => "once".to_owned(),
                2 => "twice".to_owned(),
                n => format!("{n} times"),
            },
            count(protocol.main_trials() as u64, "rating"),
            count(protocol.minutes(), "minute"),
            count(protocol.design.practice.into(), "practice trial"),
            protocol.recovery.level,
            protocol.recovery.duration_s,
            list(&categories),
            protocol.viewing.distance_cm,
            protocol.viewing.window_deg
        )
    }

    fn sample_size(&self) -> String {
        let enough = |people: u32| {
            let own = |power: &&Power| power.participants == people && self.hypothesis(power).effect.is_some();
            let mut powers =
                self.powers.iter().filter(own).filter(|p| self.hypothesis(p).test == Test::LikelihoodRatio);
            powers.clone().count() > 0 && powers.all(|power| power.share() >= self.target)
        };
        let mut tried: Vec<u32> = self.powers.iter().map(|power| power.participants).collect();
        tried.dedup();
        // More people can only help, so a number is enough if all larger ones are.
        let least = tried.iter().rev().take_while(|people| enough(**people)).last();
        let target = 100.0 * self.target;
        let numbers = list(&tried.iter().map(ToString::to_string).collect::<Vec<_>>());
        let decision = match least {
            Some(people) => format!(
                "{} will be tested: the smallest number tried ({numbers}) with a power of at least {target} % for every effect above.",
                count((*people).into(), "participant")
            ),
            None => format!(
                "[N] participants will be tested. No number tried ({numbers}) has a power of at least {target} % for every effect above."
            ),
        };
        format!(
            "{decision} The data are not analyzed before all have been tested. [Say why effects of this size are of interest.] The \
             simulation found:\n\n{}",
            bullets(self.sentences())
        )
    }

    fn analysis(&self) -> String {
        let spec = self.plan.spec();
        let slopes = match spec.slopes {
            Slopes::None => "random intercepts",
            Slopes::Independent => {
                "random intercepts and, as far as the design supports them, independent random slopes of each term"
            }
            Slopes::Correlated => "correlated random intercepts and slopes",
        };
        format!(
            "The ratings are modeled with a cumulative-link mixed model with {} link and the terms {}. Participants have {slopes}. \
             The likelihood is Laplace’s approximation. Each term is tested by the likelihood ratio against the model without it, at \
             the level {}. With fewer than {FEW_FOR_LIKELIHOOD_RATIOS} participants, p comes from a parametric bootstrap with up to \
             {} simulated studies. If the design supports no random slope of a term that varies within participants, the exact \
             Friedman test of its levels takes the place of this test. The p values of different terms are not corrected for their number. Levels of a factor are \
             compared in the same model, corrected with Holm’s method.\n\n\
             Interactions of two factors that are not in the model are tested from its residuals, corrected for their number. If \
             one is below {}, the effect of one factor is described at each level of the other, and no main effect alone. \
             Proportional odds, drift over the trials and the dependence of successive trials are checks; they do not change the \
             analysis. Everything else is exploratory and will be called so.",
            spec.link,
            list(&spec.terms.iter().map(ToString::to_string).collect::<Vec<_>>()),
            self.sampling.alpha,
            Resampling::default().draws,
            self.sampling.alpha
        )
    }
}

fn bullets(items: Vec<String>) -> String {
    items.iter().map(|item| format!("- {item}")).collect::<Vec<_>>().join("\n")
}

fn hypothesis(hypothesis: &Hypothesis) -> String {
    let term = &hypothesis.term;
    match &hypothesis.effect {
        Some(Effect { above, below, logits }) => {
            let size =
                logits.map_or_else(String::new, |logits| format!(" The effect planned for is {logits:.2} logits."));
            format!("{term}: ratings at {above} are higher than at {below}.{size}")
        }
        None => format!("{term}: no direction is predicted, and none is planned for."),
    }
}

/// Says what would count as which result.
fn meaning(planned: &Planned, hypothesis: &Hypothesis) -> String {
    let (term, alpha) = (&hypothesis.term, planned.sampling.alpha);
    let otherwise = "Otherwise, the study does not decide; this will not be called evidence of no effect.";
    match &hypothesis.effect {
        Some(Effect { above, below, .. }) => format!(
            "{term}: p below {alpha} with a higher estimate at {above} than at {below} supports the hypothesis, and p below {alpha} \
             with the opposite order contradicts it. {otherwise}"
        ),
        None => format!("{term}: p below {alpha} is an effect that was not predicted. {otherwise}"),
    }
}
