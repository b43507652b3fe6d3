//! Tests on ranks, for which each participant is one observation.

use super::names;
use crate::{
    analysis::{
        Results,
        rank_tests::{PMethod, Pair},
        results::FactorResults,
    },
    report::document::{
        Section,
        numbers::{fixed, maybe, maybe_unit, probability, short_list},
    },
};

/// Participants below which the χ² distribution is a rough guide to Friedman's statistic.
const FEW_PARTICIPANTS: usize = 6;

/// The section.
pub(super) fn section(results: &Results) -> Section {
    let mut section = Section::new("tests", "Rank tests");
    let tested: Vec<&FactorResults> = names::varied(results).collect();
    if !results.is_inferential() {
        section.text("These tests compare people. With one participant there is nothing to test.");
    } else if tested.is_empty() {
        section.text("No factor has two levels, so there is nothing to compare.");
    } else {
        section.text(
            "For these tests the ratings of a participant at a level become one mean, and only the order of the means \
             counts. Friedman’s test asks whether any level is rated differently; Kendall’s W says how far participants \
             order the levels alike, from 0 (not at all) to 1 (entirely).",
        );
        friedman(&mut section, results, &tested);
        section.text(
            "Wilcoxon’s signed-rank test compares two levels. Holm’s correction keeps the chance of any false alarm \
             among all pairs of a factor at the stated level.",
        );
        tested.iter().for_each(|factor| pairs(&mut section, factor));
    }
    section
}

fn friedman(section: &mut Section, results: &Results, factors: &[&FactorResults]) {
    let row = |factor: &&FactorResults| {
        let test = factor.friedman;
        let number = |n: Option<usize>| n.map_or_else(|| "–".to_owned(), |n| n.to_string());
        vec![
            names::factor(&factor.name).to_owned(),
            number(test.map(|test| test.subjects)),
            number(test.map(|test| test.levels)),
            maybe(test.map(|test| test.chi_squared), 2),
            number(test.map(|test| test.df)),
            probability(test.map_or(f64::NAN, |test| test.p)),
            maybe_unit(test.map(|test| test.w)),
        ]
    };
    section.heading("Friedman’s test");
    let numbers = ["Participants", "Levels", "χ²", "df", "p", "Kendall’s W"];
    section.table("Friedman’s test of each factor", &["Factor"], &numbers, factors.iter().map(row).collect());
    for factor in factors.iter().filter(|factor| !factor.incomplete.is_empty()) {
        let (name, who) = (names::factor(&factor.name), short_list(&factor.incomplete, 12));
        section.note(format!("Left out of the tests of {name}, because a level is missing: {who}."));
    }
    if results.people() < FEW_PARTICIPANTS {
        let people = results.people();
        section.note(format!("With {people} participants the probabilities of Friedman’s test are approximate."));
    }
}

fn pairs(section: &mut Section, factor: &FactorResults) {
    let Some(pairs) = factor.pairs.as_ref().filter(|pairs| !pairs.pairs.is_empty()) else { return };
    let name = names::factor(&factor.name);
    let level = |level: &str| names::level(&factor.name, level);
    let row = |pair: &Pair| {
        vec![
            format!("{} – {}", level(&pair.level), level(&pair.other)),
            fixed(pair.difference, 2),
            pair.test.n.to_string(),
            fixed(pair.test.v, 1),
            probability(pair.test.p),
            probability(pair.p_holm),
        ]
    };
    section.heading(format!("Pairs of levels: {name}"));
    let numbers = ["Difference of means", "Differences other than 0", "V", "p", "p by Holm"];
    let rows = pairs.pairs.iter().map(row).collect();
    section.table(format!("Wilcoxon’s signed-rank tests of {name}"), &["Pair"], &numbers, rows);
    let method = if pairs.pairs.iter().any(|pair| pair.test.method == PMethod::Normal) {
        "Probabilities come from the normal distribution where there are more than 50 differences, and are exact elsewhere."
    } else {
        "Probabilities are exact; differences of 0 are left out."
    };
    let least = probability(pairs.least_p);
    section.note(format!("{method} The smallest p that these pairs could have after Holm’s correction is {least}."));
}
