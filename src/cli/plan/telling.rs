//! What a plan found, as a table for people, as sentences and as CSV.

use crate::{
    analysis::power::{Effect, Hypothesis, Plan, Power, Sampling, Test},
    experiment::Protocol,
    report::tables::{Table, number},
};

/// Everything there is to tell.
pub(super) struct Telling<'a> {
    pub protocol: &'a Protocol,
    /// The observer and the effects that it was given: `paper oblique=0.3`.
    pub observer: String,
    pub plan: &'a Plan,
    pub sampling: Sampling,
    /// The power that is enough.
    pub target: f64,
    /// In the order of the plan.
    pub powers: &'a [Power],
}

impl Telling<'_> {
    fn hypothesis(&self, power: &Power) -> &Hypothesis {
        &self.plan.hypotheses()[power.hypothesis]
    }

    /// What was simulated and analysed.
    pub fn heading(&self) -> String {
        let (spec, Sampling { studies, alpha, seed }) = (self.plan.spec(), self.sampling);
        let (experiment, ratings, link) = (&self.protocol.name, self.plan.ratings(), spec.link);
        format!(
            "{experiment}, observer {}: {ratings} ratings from each participant, {studies} studies for each number, seed {seed}; \
             {link} model of {}, alpha {alpha}",
            self.observer, spec.terms
        )
    }

    /// The aligned table, a line a row. A column that nothing stands in is left out.
    pub fn table(&self) -> Vec<String> {
        let header = [
            "participants",
            "term",
            "test",
            "true effect, logits",
            "power",
            "false alarms",
            "95 % interval",
            "median estimate",
        ];
        let mut columns: Vec<Vec<String>> = header.iter().map(|name| vec![(*name).to_owned()]).collect();
        for power in self.powers {
            for (column, cell) in columns.iter_mut().zip(self.cells(power)) {
                column.push(cell);
            }
        }
        columns.retain(|column| column.len() == 1 || column[1..].iter().any(|cell| !cell.is_empty()));
        let padded: Vec<Vec<String>> = columns.iter().map(|column| pad(column)).collect();
        let line = |row: usize| padded.iter().map(|column| column[row].as_str()).collect::<Vec<_>>().join("  ");
        (0..=self.powers.len()).map(|row| line(row).trim_end().to_owned()).collect()
    }

    fn cells(&self, power: &Power) -> [String; 8] {
        let hypothesis = self.hypothesis(power);
        let interval = power.interval();
        let share = format!("{:.1} %", 100.0 * power.share());
        let (found, false_alarms) =
            if hypothesis.effect.is_some() { (share, String::new()) } else { (String::new(), share) };
        [
            power.participants.to_string(),
            hypothesis.term.clone(),
            test_name(hypothesis.test, power.participants).to_owned(),
            hypothesis.effect.as_ref().map_or("none".to_owned(), in_table),
            found,
            false_alarms,
            format!("{:.1}–{:.1} %", 100.0 * interval.low, 100.0 * interval.high),
            power.estimate.map_or_else(String::new, |estimate| format!("{estimate:.2}")),
        ]
    }

    /// A sentence for each term and factor, then what to bear in mind.
    pub fn sentences(&self) -> Vec<String> {
        let indices: Vec<usize> = (0..self.plan.hypotheses().len()).collect();
        let term = |index: usize| &self.plan.hypotheses()[index].term;
        let sentences = indices.chunk_by(|l, r| term(*l) == term(*r)).filter_map(|tests| self.sentence(tests));
        let mut sentences: Vec<String> = sentences.collect();
        sentences.extend(self.hopeless());
        sentences.extend(self.untested());
        sentences.extend(self.bearing_in_mind());
        sentences
    }

    /// All tests of one effect in one sentence.
    fn sentence(&self, tests: &[usize]) -> Option<String> {
        let several = self.powers.iter().any(|power| power.participants != self.powers[0].participants);
        let powers =
            |index: &usize| -> Vec<&Power> { self.powers.iter().filter(|power| power.hypothesis == *index).collect() };
        let powers: Vec<Vec<&Power>> = tests.iter().map(powers).filter(|powers| !powers.is_empty()).collect();
        let first = powers.first()?.first()?;
        let Hypothesis { term, effect, .. } = self.hypothesis(first);
        let each = |clause: &dyn Fn(&[&Power]) -> String, between: &str| {
            powers.iter().map(|powers| clause(powers)).collect::<Vec<_>>().join(between)
        };
        Some(match effect {
            None => {
                let expected = percent(self.sampling.alpha);
                let shares = each(&|powers| self.false_alarms(powers), ", ");
                format!(
                    "{term} has no effect on this observer: what is found are false alarms, {shares}; expected are {expected}."
                )
            }
            Some(effect) if several => {
                let clauses = each(&|powers| self.fewest(powers), "; ");
                format!("{term} ({}): of the numbers tried, {clauses}.", in_sentence(effect))
            }
            Some(effect) => {
                let found = |powers: &[&Power]| format!("{} {}", with_interval(powers[0]), self.by(powers[0]));
                let (people, about) = (people(first.participants), in_sentence(effect));
                let (clauses, studies) = (each(&found, ", "), first.studies);
                format!(
                    "With {people} the effect of {term} ({about}) is found in {clauses}, of {studies} studies each."
                )
            }
        })
    }

    /// How many participants are enough for one test.
    fn fewest(&self, powers: &[&Power]) -> String {
        let (enough, by) = (percent(self.target), self.by(powers[powers.len() - 1]));
        // More people can only help: a number is enough where all larger ones are enough too.
        let short = powers.iter().rposition(|power| power.share() < self.target);
        if let Some(power) = powers.get(short.map_or(0, |last| last + 1)) {
            let (people, found) = (power.participants, with_interval(power));
            return format!("{people} is the fewest with a power of at least {enough} {by}, {found}");
        }
        let most = powers.iter().max_by(|l, r| l.share().total_cmp(&r.share()));
        let most = most.map_or_else(String::new, |power| {
            format!(", the most is {} with {}", with_interval(power), people(power.participants))
        });
        format!("none has a power of {enough} {by}{most}")
    }

    fn false_alarms(&self, powers: &[&Power]) -> String {
        let by = self.by(powers[powers.len() - 1]);
        if let [power] = powers {
            return format!("{} {by}", with_interval(power));
        }
        let shares = || powers.iter().map(|power| power.share());
        let (least, most) = (shares().fold(1.0, f64::min), shares().fold(0.0, f64::max));
        let to = if least < most { format!(" to {}", percent(most)) } else { String::new() };
        format!("{}{to} {by}", percent(least))
    }

    fn by(&self, power: &Power) -> &'static str {
        match self.hypothesis(power).test {
            Test::Friedman => "by Friedman's test",
            Test::LikelihoodRatio if power.participants == 1 => "by the ordinal model",
            Test::LikelihoodRatio => "by the mixed model",
        }
    }

    /// Tests that can find nothing, whatever the ratings.
    fn hopeless(&self) -> impl Iterator<Item = String> {
        self.powers.iter().filter_map(|power| {
            let least = self.plan.least_p(power).filter(|least| *least >= self.sampling.alpha)?;
            Some(format!(
                "Friedman's test of {} cannot find anything with {}: the least p that it can have is {least:.3}.",
                self.hypothesis(power).term,
                people(power.participants)
            ))
        })
    }

    /// Studies without a test, the most of all hypotheses for each number of participants.
    fn untested(&self) -> Vec<String> {
        let worst = self.powers.chunk_by(|l, r| l.participants == r.participants).filter_map(|powers| {
            powers.iter().rev().filter(|power| power.untested > 0).max_by_key(|power| power.untested)
        });
        worst
            .map(|power| {
                let hypothesis = self.hypothesis(power);
                format!(
                    "With {}, {} of {} studies had no test of {} {}; they count as not found.",
                    people(power.participants),
                    power.untested,
                    power.studies,
                    hypothesis.term,
                    self.by(power)
                )
            })
            .collect()
    }

    fn bearing_in_mind(&self) -> Vec<String> {
        let hypotheses = self.plan.hypotheses();
        let mut lines = Vec::new();
        if hypotheses.iter().all(|hypothesis| hypothesis.effect.is_none()) {
            let factor = self.protocol.factors.iter().rfind(|factor| factor.levels.len() > 1);
            let example = factor.and_then(|factor| Some(format!("{}:{}=0.5", factor.name, factor.levels.last()?)));
            let example = example.map_or_else(String::new, |example| format!(", such as --effect {example}"));
            lines.push(format!("Nothing has an effect on this observer; --effect asks for one{example}."));
        }
        if self.powers.iter().any(|power| power.participants == 1) {
            lines.push(
                "With one participant the model has no random intercept: what it finds holds for that person alone."
                    .to_owned(),
            );
        }
        let sd = self.plan.observer().subject_sd;
        let alike = if sd > 0.0 {
            format!("differ by their intercepts only (sd {sd} logits)")
        } else {
            "are all alike".to_owned()
        };
        lines
            .push(format!("The simulated people {alike}; where real people differ in the effects too, power is less."));
        lines
    }

    /// One row for each number of participants and each test.
    pub fn csv(&self) -> Table {
        let header = [
            "experiment",
            "participants",
            "term",
            "test",
            "truth",
            "effect_logits",
            "above",
            "below",
            "studies",
            "found",
            "untested",
            "power",
            "false_alarms",
            "ci_low",
            "ci_high",
            "median_estimate",
            "alpha",
            "link",
            "terms",
            "quadrature",
            "seed",
            "observer",
        ];
        Table {
            header: header.map(str::to_owned).to_vec(),
            rows: self.powers.iter().map(|power| self.csv_row(power)).collect(),
        }
    }

    fn csv_row(&self, power: &Power) -> Vec<String> {
        let (hypothesis, spec) = (self.hypothesis(power), self.plan.spec());
        let effect = hypothesis.effect.as_ref();
        let text = |part: fn(&Effect) -> &String| effect.map(part).cloned().unwrap_or_default();
        let maybe = |value: Option<f64>| value.map(number).unwrap_or_default();
        let interval = power.interval();
        vec![
            self.protocol.name.clone(),
            power.participants.to_string(),
            hypothesis.term.clone(),
            match hypothesis.test {
                Test::LikelihoodRatio => "likelihood-ratio".to_owned(),
                Test::Friedman => "friedman".to_owned(),
            },
            if effect.is_some() { "effect" } else { "none" }.to_owned(),
            effect.map_or_else(|| "0".to_owned(), |effect| maybe(effect.logits)),
            text(|effect| &effect.above),
            text(|effect| &effect.below),
            power.studies.to_string(),
            power.found.to_string(),
            power.untested.to_string(),
            maybe(effect.map(|_| power.share())),
            maybe(effect.is_none().then(|| power.share())),
            number(interval.low),
            number(interval.high),
            maybe(power.estimate),
            number(self.sampling.alpha),
            spec.link.to_string(),
            spec.terms.to_string(),
            spec.quadrature.to_string(),
            self.sampling.seed.to_string(),
            self.observer.clone(),
        ]
    }
}

fn test_name(test: Test, participants: u32) -> &'static str {
    match test {
        Test::Friedman => "Friedman",
        Test::LikelihoodRatio if participants == 1 => "ordinal model",
        Test::LikelihoodRatio => "mixed model",
    }
}

fn people(number: u32) -> String {
    format!("{number} participant{}", if number == 1 { "" } else { "s" })
}

/// `2.80: 0.05 over 0.8`.
fn in_table(effect: &Effect) -> String {
    match effect.logits {
        Some(logits) => format!("{logits:.2}: {} over {}", effect.above, effect.below),
        None => format!("{} over {}", effect.above, effect.below),
    }
}

/// `2.8 logits between 0.05 and 0.8`.
fn in_sentence(effect: &Effect) -> String {
    let between = format!("between {} and {}", effect.above, effect.below);
    effect.logits.map_or(between.clone(), |logits| format!("{} logits {between}", rounded(logits, 2)))
}

/// `83.5 % (77.6–88.4 %)`.
fn with_interval(power: &Power) -> String {
    let interval = power.interval();
    let ends = [interval.low, interval.high].map(|end| rounded(100.0 * end, 1));
    format!("{} ({}–{} %)", percent(power.share()), ends[0], ends[1])
}

fn percent(share: f64) -> String {
    format!("{} %", rounded(100.0 * share, 1))
}

/// With so many decimals at most, without zeros that say nothing.
fn rounded(value: f64, decimals: usize) -> String {
    format!("{value:.decimals$}").trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Cells padded to the widest, numbers to the right.
fn pad(column: &[String]) -> Vec<String> {
    let width = column.iter().map(|cell| cell.chars().count()).max().unwrap_or(0);
    let numeric = |cell: &String| cell.is_empty() || cell.starts_with(|c: char| c.is_ascii_digit() || c == '-');
    let right = column[1..].iter().all(numeric) && !column[0].starts_with("true") && column[0] != "term";
    let cell = |cell: &String| if right { format!("{cell:>width$}") } else { format!("{cell:<width$}") };
    column.iter().map(cell).collect()
}
