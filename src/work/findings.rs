//! What a plan found, in sentences and as the text of a preregistration: what will be measured, how many people, how it will
//! be analyzed, and what each result would mean. What only its author knows is in square brackets.

use super::{
    plan::{Plan, Planned},
    words,
};
use crate::{
    analysis::{
        FEW_FOR_LIKELIHOOD_RATIOS, LEAST_FOR_SIGNS, Resampling, Slopes,
        power::{self, Effect, Hypothesis, Power, Sampling, Slope, Test},
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

    /// Returns what was found, and what else can be asked. `effects` and `deviations` are the names of the fields in which they are
    /// given.
    pub fn sentences(&self, [effects, deviations]: [&str; 2]) -> Vec<String> {
        let has_none = self.plan.hypotheses.iter().all(|hypothesis| hypothesis.effect.is_none());
        let hint = has_none.then(|| format!("No factor has an effect on this observer. Add an effect with {effects}."));
        let other = format!("{deviations} lets participants differ in an effect.");
        self.findings().into_iter().chain(hint).chain([other]).collect()
    }

    /// Returns a sentence for each term and factor, followed by the limitations of the findings.
    fn findings(&self) -> Vec<String> {
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
        if self.powers.iter().any(|power| power.participants == 1) {
            let text =
                "With one participant, the model has no random intercept, so its findings apply only to that person.";
            sentences.push(text.to_owned());
        }
        sentences.push(self.differences());
        let known = Some(self.protocol.stimulus.parameters());
        for slope in self.plan.unmodeled() {
            sentences.push(format!(
                "The simulated participants differ in the effect of {}, but the model has no random slope of it, so it finds \
                 this effect too often.",
                names::factor(known, &slope.factor)
            ));
        }
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
                clauses(&|powers| {
                    let share = |power: &&Power| format!("{} with {}", found(power), people(power.participants));
                    let shares: Vec<String> = powers.iter().map(share).collect();
                    format!("{} by {}", list(&shares), self.test(powers[powers.len() - 1]))
                })
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

    /// Says how the simulated participants differ.
    fn differences(&self) -> String {
        let sd = self.plan.scenario.observer.subject_sd;
        let intercepts = (sd > 0.0).then(|| format!("in their intercepts (sd {})", logits(sd)));
        let known = Some(self.protocol.stimulus.parameters());
        let slope = |slope: &Slope| {
            format!("at each level of {} (sd {})", names::factor(known, &slope.factor), logits(slope.sd))
        };
        let slopes = self.plan.scenario.slopes.iter().filter(|slope| slope.sd > 0.0).map(slope);
        let all: Vec<String> = intercepts.into_iter().chain(slopes).collect();
        let differ = if all.is_empty() { "are identical".to_owned() } else { format!("differ {}", list(&all)) };
        format!("The simulated participants {differ}. If real ones differ more, power is lower.")
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
        let Planned { protocol, plan: power::Plan { spec, .. }, sampling: Sampling { alpha, .. }, .. } = planned;
        let known = Some(protocol.stimulus.parameters());
        let factor = |factor: &Factor| {
            let level = |level: &ParameterValue| names::level(known, &factor.name, &level.to_string()).to_string();
            let levels: Vec<String> = factor.levels.iter().map(level).collect();
            format!("{} ({})", names::factor(known, &factor.name), levels.join(", "))
        };
        let practice = match protocol.design.practice {
            0 => String::new(),
            n => format!("{} come first. ", count(n.into(), "practice trial")),
        };
        let effects = match spec.slopes {
            Slopes::None => "random intercepts",
            Slopes::Independent => "random intercepts and, where the design supports them, independent random slopes",
            Slopes::Correlated => "correlated random intercepts and slopes",
        };
        format!(
            include_str!("preregistration.md"),
            title = if protocol.title.is_empty() { &protocol.name } else { &protocol.title },
            hypotheses = bullets(planned.effects().map(|effect| planned.expected(effect)).collect()),
            factors = list(&protocol.factors.iter().map(factor).collect::<Vec<_>>()),
            conditions = count(protocol.conditions().len() as u64, "condition"),
            times = times(protocol.design.repetitions),
            ratings = count(protocol.main_trials() as u64, "rating"),
            minutes = count(protocol.minutes(), "minute"),
            practice = practice,
            level = protocol.recovery.level,
            recovery_s = protocol.recovery.duration_s,
            categories = list(&names::categories_of(protocol)),
            distance_cm = protocol.viewing.distance_cm,
            window_deg = protocol.viewing.window_deg,
            decision = planned.sample_size(),
            found = bullets(planned.findings()),
            link = spec.link,
            terms = list(&spec.terms.iter().map(|term| planned.in_words(term)).collect::<Vec<_>>()),
            effects = effects,
            alpha = alpha,
            few = FEW_FOR_LIKELIHOOD_RATIOS,
            draws = Resampling::default().draws,
            least = LEAST_FOR_SIGNS,
            usual_alpha = Sampling::default().alpha,
            version = env!("CARGO_PKG_VERSION"),
            hash = crate::store::definition::hash(protocol),
            words = words(self).join(" "),
            name = protocol.name,
            terms_option = spec.terms,
            slopes = spec.slopes,
        )
    }
}

impl Planned {
    /// Returns the hypotheses, each once: about the terms of the model, and about the factors of its interactions.
    fn effects(&self) -> impl Iterator<Item = &Hypothesis> {
        let all = &self.plan.hypotheses;
        let is_of_model = |own: &Hypothesis| own.test == Test::LikelihoodRatio;
        all.iter().filter(move |own| is_of_model(own) || !all.iter().any(|o| is_of_model(o) && o.term == own.term))
    }

    /// Says what is expected of a term, and what would count as which result.
    fn expected(&self, Hypothesis { term, effect, .. }: &Hypothesis) -> String {
        let (name, alpha) = (self.in_words(term), self.sampling.alpha);
        let Some(Effect { logits, above, below }) = effect else {
            return format!(
                "{name}: no effect is predicted. p below {alpha} indicates an effect that was not predicted."
            );
        };
        let known = Some(self.protocol.stimulus.parameters());
        let [above, below] = [above, below].map(|level| names::level(known, term.name(), level));
        let size = logits.map_or_else(String::new, |logits| format!(" The effect planned for is {logits:.2} logits."));
        format!(
            "{name}: ratings at {above} are higher than at {below}.{size} p below {alpha} with a higher estimate at {above} than at \
             {below} supports the hypothesis, and p below {alpha} with the opposite order contradicts it."
        )
    }

    /// Says how many people will be tested, and why.
    fn sample_size(&self) -> String {
        let enough = |people: &&u32| {
            let own = |power: &&Power| power.participants == **people && self.hypothesis(power).effect.is_some();
            let mut powers = self.powers.iter().filter(own);
            powers.clone().count() > 0 && powers.all(|power| power.interval().low >= self.target)
        };
        let mut tried: Vec<u32> = self.powers.iter().map(|power| power.participants).collect();
        tried.dedup();
        let numbers = list(&tried.iter().map(ToString::to_string).collect::<Vec<_>>());
        let found = format!(
            "({numbers}) at which the 95 % interval of the power lies at or above {} for every test of every effect above.",
            percent(self.target)
        );
        // More people can only help, so a number is enough if all larger ones are.
        match tried.iter().rev().take_while(enough).last() {
            _ if self.effects().all(|hypothesis| hypothesis.effect.is_none()) => {
                "[N] participants will be tested. No effect is planned for, so no power decides the number.".to_owned()
            }
            Some(people) => format!("{} will be tested: the smallest number tried {found}", self::people(*people)),
            None => format!("[N] participants will be tested. There is no number tried {found}"),
        }
    }
}

fn bullets(items: Vec<String>) -> String {
    items.iter().map(|item| format!("- {item}")).collect::<Vec<_>>().join("\n")
}
