//! Tests on ranks, for which each participant is one observation.

use maud::{Markup, html};

use super::{cautions::hopeless_pairs, names};
use crate::analysis::{
    Results,
    rank_tests::{PMethod, Pair},
    results::FactorResults,
};
use crate::report::document::numbers::{fixed, probability, short_list, unit};
use crate::report::skins::html::table::{Kind, table};

/// Subjects below which the χ² distribution is a rough guide to Friedman's statistic.
const FEW_SUBJECTS: usize = 6;

/// The section.
pub(crate) fn section(results: &Results) -> Markup {
    if !results.is_inferential() {
        return html! {
            p { "These tests compare people. With one participant there is nothing to test." }
        };
    }
    let tested: Vec<&FactorResults> = names::varied(results).collect();
    if tested.is_empty() {
        return html! { p { "No factor has two levels, so there is nothing to compare." } };
    }
    html! {
        p {
            "For these tests the ratings of a participant at a level become one mean, and only the order of the means counts. "
            "Friedman’s test asks whether any level is rated differently; Kendall’s W says how far participants order the levels alike, 0 not at all and 1 entirely."
        }
        (friedman(&tested))
        @if results.people() < FEW_SUBJECTS {
            p.note { "With " (results.people()) " participants the probabilities of Friedman’s test are approximate." }
        }
        p { "Wilcoxon’s signed-rank test compares two levels; Holm’s correction keeps the chance of any false alarm among all pairs of a factor at the stated level." }
        @for factor in tested { (pairs(results, factor)) }
    }
}

fn friedman(factors: &[&FactorResults]) -> Markup {
    let columns = [
        ("Factor", Kind::Text),
        ("Participants", Kind::Number),
        ("Levels", Kind::Number),
        ("χ²", Kind::Number),
        ("df", Kind::Number),
        ("p", Kind::Number),
        ("Kendall’s W", Kind::Number),
    ];
    let row = |factor: &&FactorResults| {
        let name = names::factor(&factor.name).to_owned();
        match factor.friedman {
            None => [name].into_iter().chain(std::iter::repeat_n("–".to_owned(), columns.len() - 1)).collect(),
            Some(f) => vec![
                name,
                f.subjects.to_string(),
                f.levels.to_string(),
                fixed(f.chi_squared, 2),
                f.df.to_string(),
                probability(f.p),
                unit(f.w),
            ],
        }
    };
    html! {
        h3 { "Friedman’s test" }
        (table("Friedman’s test for each factor", &columns, factors.iter().map(row).collect::<Vec<_>>()))
        @for factor in factors {
            @if !factor.incomplete.is_empty() {
                p.note {
                    "Not in the tests of " (names::factor(&factor.name)) ", because a level is missing: " (short_list(&factor.incomplete, 12)) "."
                }
            }
        }
    }
}

fn pairs(results: &Results, factor: &FactorResults) -> Markup {
    let Some(pairs) = factor.pairs.as_ref().filter(|pairs| !pairs.pairs.is_empty()) else { return html! {} };
    let columns = [
        ("Pair", Kind::Text),
        ("Difference of means", Kind::Number),
        ("Differences other than 0", Kind::Number),
        ("V", Kind::Number),
        ("p", Kind::Number),
        ("p by Holm", Kind::Number),
    ];
    let level = |name: &str| names::level(&factor.name, name);
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
    let normal = pairs.pairs.iter().any(|pair| pair.test.method == PMethod::Normal);
    let name = names::factor(&factor.name);
    html! {
        h3 { "Pairs of levels: " (name) }
        @if let Some(warning) = hopeless_pairs(results, factor) { p.warning { (warning) } }
        @else { p { "The least p that these pairs could have after Holm’s correction is " (probability(pairs.least_p)) "." } }
        (table(&format!("Wilcoxon’s signed-rank tests of {name}"), &columns, pairs.pairs.iter().map(row).collect::<Vec<_>>()))
        p.note { @if normal { "Probabilities by the normal distribution where there are more than 50 differences, exact elsewhere." } @else { "Exact probabilities; differences of 0 are left out." } }
    }
}
