//! Levels compared by tests on ranks, and agreement.

use eframe::egui::{self, ScrollArea};

use super::{
    grid::Grid,
    look,
    words::{fixed, interval, many, maybe, probability},
};
use crate::analysis::{
    Results,
    rank_tests::{PMethod, Pairs},
    results::FactorResults,
};

/// What is said of one person's ratings.
const ONE_PERSON: &str = "These are the ratings of one participant. They describe this participant: how far other people would see the same cannot be told from one, so nothing is tested here.";

/// The level that a comparison must be able to reach.
const ALPHA: f64 = 0.05;

/// Tests and agreement as they are shown.
pub struct Comparisons {
    parts: Vec<Part>,
}

enum Part {
    Heading(String),
    Text(String),
    Note(String),
    Grid(String, Grid),
}

impl Comparisons {
    /// Of an analysis.
    pub fn new(results: &Results) -> Self {
        let mut view = Self { parts: Vec::new() };
        if results.is_inferential() {
            view.friedman(results);
            results.factors.iter().for_each(|factor| view.pairs(factor));
        } else {
            view.parts.push(Part::Note(ONE_PERSON.to_owned()));
        }
        view.agreement(results);
        view
    }

    fn friedman(&mut self, results: &Results) {
        let tested: Vec<_> =
            results.factors.iter().filter_map(|factor| Some((factor, factor.friedman.as_ref()?))).collect();
        if tested.is_empty() {
            self.text("No factor has several levels that were rated differently: there is nothing to test.");
            return;
        }
        self.parts.push(Part::Heading("Friedman's test of each factor".to_owned()));
        self.text("Whether participants' means differ between the levels, by ranks. Kendall's W: 0 no common order, 1 the same order for all.");
        let rows = (tested.iter())
            .map(|(factor, test)| {
                vec![
                    factor.name.clone(),
                    test.subjects.to_string(),
                    test.levels.to_string(),
                    fixed(test.chi_squared, 2),
                    test.df.to_string(),
                    probability(test.p),
                    fixed(test.w, 3),
                ]
            })
            .collect();
        self.grid("friedman", Grid::new(&["factor", "participants", "levels", "χ²", "df", "p", "Kendall's W"], rows));
        for factor in results.factors.iter().filter(|factor| !factor.incomplete.is_empty()) {
            self.parts.push(Part::Note(format!(
                "{}: {} without ratings at every level left out ({}).",
                factor.name,
                many(factor.incomplete.len() as u64, "participant"),
                shortened(&factor.incomplete)
            )));
        }
    }

    fn pairs(&mut self, factor: &FactorResults) {
        let Some(pairs) = factor.pairs.as_ref().filter(|pairs| !pairs.pairs.is_empty()) else { return };
        self.parts.push(Part::Heading(format!("Pairs of {}", factor.name)));
        self.text("Wilcoxon's signed-rank test of participants' means, p corrected by Holm's method.");
        if pairs.cannot_reach(ALPHA) {
            self.parts.push(Part::Note(format!(
                "With so few participants and {}, no p corrected by Holm's method can be below {}: these comparisons cannot find a difference.",
                many(pairs.pairs.len() as u64, "pair"),
                fixed(pairs.least_p, 3)
            )));
        }
        self.grid(&format!("pairs {}", factor.name), pair_grid(pairs));
    }

    fn agreement(&mut self, results: &Results) {
        let repeated: Vec<_> = results.subjects.iter().filter(|subject| subject.retests > 0).collect();
        if results.alpha.is_none() && repeated.is_empty() {
            return;
        }
        self.parts.push(Part::Heading("Agreement".to_owned()));
        let ends = |i: Option<_>| i.map(|i| format!(" ({})", interval(i, 2))).unwrap_or_default();
        if let Some(alpha) = &results.alpha {
            self.text(&format!(
                "Between participants: Krippendorff's ordinal α {}{}, of {} in {} that two or more participants rated.",
                fixed(alpha.alpha, 2),
                ends(alpha.interval),
                many(alpha.ratings, "rating"),
                many(alpha.units as u64, "condition")
            ));
        }
        if let Some((mean, interval)) = results.kappa {
            let whose = if repeated.len() > 1 { "mean " } else { "" };
            self.text(&format!(
                "Of participants with themselves: {whose}weighted κ {}{} of the first and second rating of a condition.",
                fixed(mean, 2),
                ends(interval)
            ));
        }
        if !repeated.is_empty() {
            let rows = (repeated.iter())
                .map(|subject| {
                    vec![subject.group.names[0].clone(), subject.retests.to_string(), maybe(subject.kappa, 2)]
                })
                .collect();
            self.grid("kappa", Grid::new(&["participant", "conditions rated twice", "weighted κ"], rows));
        }
    }

    fn text(&mut self, text: &str) {
        self.parts.push(Part::Text(text.to_owned()));
    }

    fn grid(&mut self, id: &str, grid: Grid) {
        self.parts.push(Part::Grid(id.to_owned(), grid));
    }

    /// Draws them.
    pub fn show(&mut self, ui: &mut egui::Ui) {
        ScrollArea::vertical().id_salt("tests").auto_shrink(false).show(ui, |ui| {
            for part in &mut self.parts {
                match part {
                    Part::Heading(text) => look::heading(ui, text.as_str()),
                    Part::Text(text) => look::text(ui, text.as_str()),
                    Part::Note(text) => look::note(ui, text.as_str()),
                    Part::Grid(id, grid) => grid.show(ui, id),
                }
            }
        });
    }
}

fn pair_grid(pairs: &Pairs) -> Grid {
    let rows = (pairs.pairs.iter())
        .map(|pair| {
            vec![
                pair.level.clone(),
                pair.other.clone(),
                fixed(pair.difference, 2),
                pair.test.n.to_string(),
                fixed(pair.test.v, 1),
                probability(pair.test.p),
                probability(pair.p_holm),
                match pair.test.method {
                    PMethod::Exact => "exact",
                    PMethod::Normal => "normal",
                }
                .to_owned(),
            ]
        })
        .collect();
    Grid::new(&["level", "other", "difference", "n", "V", "p", "p (Holm)", "method"], rows)
}

/// The first few names.
fn shortened(names: &[String]) -> String {
    const MOST: usize = 8;
    let shown = names.iter().take(MOST).map(String::as_str).collect::<Vec<_>>().join(", ");
    if names.len() > MOST { format!("{shown}, …") } else { shown }
}
