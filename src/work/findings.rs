//! What a plan found, in sentences and as the text of a preregistration: what will be measured, how many people, how it will
//! be analyzed, and what each result would mean. What only its author knows is in square brackets.

use std::fmt::Write;

use super::{
    plan::{OPTIONS, Plan, Planned},
    words,
};
use crate::{
    analysis::{
        FEW_FOR_LIKELIHOOD_RATIOS, LEAST_FOR_SIGNS, Resampling, Slopes,
        power::{Effect, Hypothesis, Power, Sampling, Slope, Test},
        terms::Term,
    },
    experiment::Factor,
    report::{
        document::numbers::{count, fixed, list, percent, times, with_interval},
        names,
    },
    stimulus::ParameterValue,
};

impl Planned {
    /// Returns a term in words.
    pub fn in_words(&self, term: &Term) -> String {
        names::term(Some(self.protocol.stimulus.parameters()), term)
    }

    /// Returns the name of a test in a sentence.
    pub fn test(&self, power: &Power) -> &'static str {
        match self.hypothesis(power).test {
            Test::Friedman => "Friedman’s test",
            Test::LikelihoodRatio if power.participants == 1 => "the ordinal model",
            Test::LikelihoodRatio => "the mixed model",
        }
    }

    /// Returns a sentence for each term and factor, followed by remarks. `fields` are the names of effects and of
    /// deviations where they are given.
    pub fn sentences(&self, fields: [&str; 2]) -> Vec<String> {
        let indices: Vec<usize> = (0..self.plan.hypotheses.len()).collect();
        let term = |index: usize| &self.plan.hypotheses[index].term;
        let mut sentences: Vec<String> =
            indices.chunk_by(|l, r| term(*l) == term(*r)).filter_map(|tests| self.sentence(tests)).collect();
        for power in self.powers.iter().filter(|power| power.untested > 0) {
            let reason = power.withheld.map_or_else(String::new, |reason| format!(": {reason}"));
            sentences.push(format!(
                "With {}, {} of {} studies could not test {} with {}{reason}; they count as not finding an effect.",
                people(power.participants),
                power.untested,
                power.studies,
                self.in_words(&self.hypothesis(power).term),
                self.test(power)
            ));
        }
        sentences.extend(self.remarks(fields));
        sentences
    }

    /// Summarizes all tests of one effect in one sentence.
    fn sentence(&self, tests: &[usize]) -> Option<String> {
        let powers = |test: &usize| self.powers.iter().filter(|power| power.hypothesis == *test).collect::<Vec<_>>();
        let powers: Vec<Vec<&Power>> = tests.iter().map(powers).filter(|powers| !powers.is_empty()).collect();
        let Hypothesis { term, effect, .. } = self.hypothesis(powers.first()?.first()?);
        let clauses = |clause: &dyn Fn(&[&Power]) -> String| {
            powers.iter().map(|powers| clause(powers)).collect::<Vec<_>>().join("; ")
        };
        let (words, known) = (self.in_words(term), Some(self.protocol.stimulus.parameters()));
        Some(match effect {
            None => format!(
                "For this observer, {words} has no effect. The false-alarm rate, expected to be {}, is {}.",
                percent(self.sampling.alpha),
                clauses(&|powers| self.false_alarms(powers))
            ),
            Some(Effect { logits: effect, above, below }) => {
                let size = effect.map_or_else(String::new, |size| format!("{} ", logits(size)));
                let [above, below] = [above, below].map(|level| names::level(known, term.name(), level));
                let enough = clauses(&|powers| self.fewest(powers));
                format!("Effect of {words} ({size}between {above} and {below}): {enough}.")
            }
        })
    }

    /// Says how many participants are enough for one test.
    fn fewest(&self, powers: &[&Power]) -> String {
        let enough =
            format!("enough for a power of {} with {}", percent(self.target), self.test(powers[powers.len() - 1]));
        // More people can only help: a number is enough if all larger ones are enough too.
        let fewest = |share: fn(&Power) -> f64| {
            let short = powers.iter().rposition(|power| share(power) < self.target);
            powers.get(short.map_or(0, |last| last + 1))
        };
        let (certain, likely) = (fewest(|power| power.interval().low), fewest(Power::share));
        let most = powers.iter().max_by(|l, r| l.share().total_cmp(&r.share()));
        let Some(power) = certain.or(likely).or(most) else { return String::new() };
        let (people, share) = (people(power.participants), found(power));
        match (certain, likely) {
            (Some(_), _) if power.participants == 1 => format!("{people} is {enough}, {share}"),
            (Some(_), _) => format!("{people} are {enough}, {share}"),
            (None, Some(_)) => format!("{people} may be {enough}, {share}; only more simulated studies can tell"),
            (None, None) => format!("no number tried is {enough}; the highest power is {share} with {people}"),
        }
    }

    fn false_alarms(&self, powers: &[&Power]) -> String {
        let shares: Vec<String> = powers.iter().map(|power| found(power)).collect();
        format!("{} with {}", shares.join(", "), self.test(powers[powers.len() - 1]))
    }

    /// States the limitations of the findings.
    fn remarks(&self, [effects, deviations]: [&str; 2]) -> Vec<String> {
        let mut remarks = Vec::new();
        if self.plan.hypotheses.iter().all(|hypothesis| hypothesis.effect.is_none()) {
            remarks.push(format!("No factor has an effect on this observer. Add an effect with {effects}."));
        }
        if self.powers.iter().any(|power| power.participants == 1) {
            let text =
                "With one participant, the model has no random intercept, so its findings apply only to that person.";
            remarks.push(text.to_owned());
        }
        remarks.push(self.differences(deviations));
        let known = Some(self.protocol.stimulus.parameters());
        for slope in self.plan.unmodeled() {
            remarks.push(format!(
                "The simulated participants differ in the effect of {}, but the model has no random slope of it, so it finds \
                 this effect too often.",
                names::factor(known, &slope.factor)
            ));
        }
        remarks
    }

    /// Says how the simulated participants differ, and where to say how much.
    fn differences(&self, field: &str) -> String {
        let sd = self.plan.observer().subject_sd;
        let intercepts = (sd > 0.0).then(|| format!("in their intercepts (sd {})", logits(sd)));
        let known = Some(self.protocol.stimulus.parameters());
        let slope = |slope: &Slope| {
            format!("at each level of {} (sd {})", names::factor(known, &slope.factor), logits(slope.sd))
        };
        let slopes = self.plan.slopes().iter().filter(|slope| slope.sd > 0.0).map(slope);
        let all: Vec<String> = intercepts.into_iter().chain(slopes).collect();
        let differ = if all.is_empty() { "are identical".to_owned() } else { format!("differ {}", list(&all)) };
        format!(
            "The simulated participants {differ}. If real ones differ more, power is lower; {field} lets them differ in an effect."
        )
    }
}

fn people(number: u32) -> String {
    count(number.into(), "participant")
}

/// Formats a size on the latent scale.
fn logits(size: f64) -> String {
    format!("{} logits", fixed(size, 2))
}

/// Formats a power with its interval.
fn found(power: &Power) -> String {
    format!("{}{}", percent(power.share()), with_interval(Some(power.interval()), percent))
}

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
            times(protocol.design.repetitions),
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
             The proportions of the ratings in studies simulated from the model, drift over the trials and the dependence of \
             successive trials are checks; they do not change the analysis. Everything else is exploratory and will be called so. The sentences of the analysis report use the level {}.",
            spec.link,
            list(&spec.terms.iter().map(|term| self.in_words(term)).collect::<Vec<_>>()),
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
    let level = |level: &String| names::level(known, hypothesis.term.name(), level).to_string();
    let levels = hypothesis.effect.as_ref().map(|Effect { above, below, .. }| [above, below].map(level));
    (names::term(known, &hypothesis.term), levels.unwrap_or_default())
}

fn hypothesis(planned: &Planned, hypothesis: &Hypothesis) -> String {
    let (term, [above, below]) = in_words(planned, hypothesis);
    match &hypothesis.effect {
        Some(Effect { logits: size, .. }) => {
            let size = size.map_or_else(String::new, |size| format!(" The effect planned for is {}.", logits(size)));
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
