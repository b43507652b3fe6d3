//! Sections about model-free results: rank tests, which treat each participant as one observation, and agreement
//! between and within participants.

use super::names;
use crate::{
    analysis::{
        Results,
        rank_tests::{EXACT_PARTICIPANTS, Friedman, PERMUTATIONS},
        results::FactorResults,
    },
    report::document::{Section, TableOf, count, fixed, list, probability, short_list, unit, whole, with_interval},
};

/// Describes the rank tests.
pub(super) fn section(results: &Results) -> Section {
    let mut section = Section::new("tests", "Rank tests");
    let tested: Vec<&FactorResults> = names::varied(results).collect();
    if !results.is_inferential() {
        section.text("These tests need several participants; with only one, there is nothing to test.");
    } else if tested.is_empty() {
        section.text("No factor has two levels, so there is nothing to compare.");
    } else {
        section.text(
            "For these tests, each participant’s ratings at a level are averaged over those conditions of the other factors \
             that the participant rated at every level. Friedman’s test uses only the order of each participant’s means. It asks whether any level is rated differently; Kendall’s W measures how consistently participants \
             order the levels, from 0 (not at all) to 1 (identically). The summary follows this test for a factor only if its test in the model is withheld or random slopes were \
             turned off, and for the simple effects of an interaction that the model leaves out.",
        );
        friedman(&mut section, results, &tested);
    }
    section
}

fn friedman(section: &mut Section, results: &Results, factors: &[&FactorResults]) {
    section.heading("Friedman’s test");
    if factors.iter().all(|factor| factor.friedman.is_none()) {
        section
            .text("No factor could be tested: the test needs participants who rated every level in the same conditions, and it cannot account for items.");
        return;
    }
    let of = |number: fn(Friedman) -> f64, decimals: usize| {
        move |factor: &&FactorResults| fixed(factor.friedman.map(number), decimals)
    };
    TableOf::new("Friedman’s test of each factor", factors)
        .text("Factor", |factor| names::factor(results, &factor.name))
        .number("Participants", of(|test| test.subjects as f64, 0))
        .number("Levels", of(|test| test.levels as f64, 0))
        .number("χ²", of(|test| test.chi_squared, 2))
        .number("df", of(|test| test.df as f64, 0))
        .number("p", |factor| probability(factor.friedman.map(|test| test.p)))
        .number("Kendall’s W", |factor| unit(factor.friedman.map(|test| test.w)))
        .add_to(section);
    for factor in factors.iter().filter(|factor| !factor.crossing.is_empty() && !factor.matched.incomplete.is_empty()) {
        let (name, who) = (names::factor(results, &factor.name), short_list(&factor.matched.incomplete, 12));
        section.note(format!("Excluded from the tests of {name}, because they did not rate every level of it in the same conditions: {who}."));
    }
    let between: Vec<String> =
        factors.iter().filter(|f| f.crossing.is_empty()).map(|factor| names::factor(results, &factor.name)).collect();
    if !between.is_empty() {
        section
            .note(format!("Each participant rated only one level of {}, so there is nothing to rank.", list(&between)));
    }
    section.note(format!(
        "The p values are over all orders in which participants could rank the levels or, if there are too many, over up to {} \
         random orders; with more than {EXACT_PARTICIPANTS} participants, they come from the χ² distribution, which is then accurate.",
        whole(PERMUTATIONS as u64)
    ));
}

/// Counts what agreement is about: conditions, items, or items in conditions.
fn units(results: &Results, number: u64) -> String {
    match &results.spec.items {
        None => count(number, "condition"),
        Some(_) if names::varied(results).next().is_none() => count(number, "item"),
        Some(items) => format!("{} of {} and condition", count(number, "combination"), names::factor(results, items)),
    }
}

pub(super) fn agreement(results: &Results) -> Section {
    let mut section = Section::new("agreement", "Agreement");
    section.heading("Between participants");
    match results.alpha {
        Some(alpha) => {
            section.text(format!(
                "Krippendorff’s ordinal α is {}{}, from {} of {} that two or more participants rated. 1 is perfect \
                 agreement; 0 is agreement by chance.",
                unit(alpha.alpha),
                with_interval(alpha.interval, unit),
                count(alpha.ratings, "rating"),
                units(results, alpha.units as u64),
            ));
            section.note(
                "Krippendorff’s limits of .800 and .667 are meant for coders who apply a rule. Participants may differ \
                 because they see differently; in that case, a low α is a finding and not an error. α is also near 0 if the \
                 conditions hardly differ.",
            );
        }
        None if results.is_inferential() => section.text(
            "Fewer than two conditions were rated by two participants, or all ratings are the same: agreement cannot be computed.",
        ),
        None => section.text("Agreement between participants requires at least two participants."),
    }
    section.heading("Within participants");
    let Some((kappa, interval)) = results.kappa else {
        section.text(
            "Test–retest agreement could not be computed: κ needs a participant who rated at least five conditions twice, in a \
             known order, and used more than one category in them.",
        );
        return section;
    };
    section.text(format!(
        "Cohen’s κ with quadratic weights compares a participant’s first and second rating of a condition. {} {}{}. 1 is \
         perfect agreement, and 0 is agreement by chance.",
        if results.is_inferential() { "Its mean over participants is" } else { "It is" },
        unit(kappa),
        with_interval(interval, unit),
    ));
    TableOf::new("First and second ratings of each participant", &results.subjects)
        .text("Participant", names::participant)
        .number("Conditions rated twice", |subject| whole(subject.retests))
        .number("Weighted κ", |subject| unit(subject.kappa))
        .add_to(&mut section);
    section
}
