//! The model in numbers: coefficients, thresholds, what terms say, whether odds are proportional.

use eframe::egui::{self, ScrollArea};

use super::{
    grid::Grid,
    look,
    words::{fixed, grouped, many, maybe, probability},
};
use crate::analysis::{Coefficient, Model, Results, TermTest};

/// What is said of a model of one person's ratings.
const ONE_PERSON: &str = "These are the ratings of one participant: the model describes this participant, and says nothing about other people. There are no tests and no p values for that reason.";

/// The model as it is shown.
pub struct ModelView {
    /// Sentences above the tables.
    said: Vec<String>,
    notes: Vec<String>,
    tables: Vec<(&'static str, &'static str, Grid)>,
}

impl ModelView {
    /// Of an analysis.
    pub fn new(results: &Results) -> Self {
        let mut view = Self { said: Vec::new(), notes: Vec::new(), tables: Vec::new() };
        let inferential = results.is_inferential();
        if !inferential {
            view.notes.push(ONE_PERSON.to_owned());
        }
        let report = match &results.model {
            Err(error) => {
                view.notes.push(format!("There is no model: {}.", without_flag(&error.to_string())));
                return view;
            }
            Ok(report) => report,
        };
        let model = &report.model;
        view.said.push(summary(model, &results.spec.terms.to_string()));
        if let Some(random) = &model.random {
            let error = random.se.map(|se| format!(" (standard error {})", fixed(se, 3))).unwrap_or_default();
            view.said.push(format!(
                "Participants' intercepts have a standard deviation of {}{error} on this scale.",
                fixed(random.sd, 3)
            ));
        }
        view.notes.extend(model.notes.iter().map(|note| format!("{}.", capital(&note.to_string()))));
        view.add(
            "Coefficients",
            "How far a level shifts the ratings upwards, compared with the factor's first level.",
            coefficients(&model.coefficients, inferential),
        );
        view.add("Thresholds", "", thresholds(model));
        if !model.scale.is_empty() {
            view.add("Scale", "Effects on the logarithm of the spread.", coefficients(&model.scale, inferential));
        }
        if inferential {
            let groups = [
                ("Likelihood-ratio tests", "Against the model without the term.", &report.terms),
                (
                    "Proportional odds",
                    "Whether a term has the same effect at every threshold; a small p says that it has not.",
                    &report.proportional_odds,
                ),
                ("Spread", "Whether a term also changes the spread of the ratings.", &results.scale),
            ];
            for (title, about, tests) in groups {
                if !tests.is_empty() {
                    view.add(title, about, likelihood(tests));
                }
            }
        }
        if let Some(random) = &model.random {
            let rows = (random.subjects.iter())
                .map(|mode| vec![mode.subject.clone(), fixed(mode.mode, 3), fixed(mode.sd, 3)])
                .collect();
            view.add(
                "Participants' intercepts",
                "Positive: higher ratings than others give under the same conditions.",
                Grid::new(&["participant", "intercept", "conditional sd"], rows),
            );
        }
        view
    }

    fn add(&mut self, title: &'static str, about: &'static str, grid: Grid) {
        self.tables.push((title, about, grid));
    }

    /// Draws it.
    pub fn show(&mut self, ui: &mut egui::Ui) {
        ScrollArea::vertical().id_salt("model").auto_shrink(false).show(ui, |ui| {
            for note in &self.notes {
                look::note(ui, note);
            }
            for text in &self.said {
                look::text(ui, text);
            }
            for (title, about, grid) in &mut self.tables {
                look::heading(ui, *title);
                if !about.is_empty() {
                    look::quiet(ui, *about);
                }
                grid.show(ui, title);
            }
        });
    }
}

fn summary(model: &Model, terms: &str) -> String {
    let method = match model.method.as_str() {
        "clm" => "Cumulative-link model".to_owned(),
        "clmm-laplace" => "Cumulative-link mixed model (Laplace)".to_owned(),
        mixed => match mixed.strip_prefix("clmm-aghq-") {
            Some(nodes) => format!("Cumulative-link mixed model (Gauss–Hermite, {nodes} nodes)"),
            None => mixed.to_owned(),
        },
    };
    let terms = if terms.is_empty() { "no terms".to_owned() } else { terms.replace(',', ", ") };
    format!(
        "{method}, {} link, {terms}. {} of {}; log-likelihood {}, AIC {}; {}.",
        model.link,
        many(model.nobs, "rating"),
        many(model.subjects as u64, "participant"),
        fixed(model.loglik, 3),
        fixed(model.aic(), 1),
        if model.converged() {
            format!("converged in {} iterations", grouped(model.iterations as u64))
        } else {
            "not converged".to_owned()
        }
    )
}

fn coefficients(coefficients: &[Coefficient], inferential: bool) -> Grid {
    let header = ["name", "estimate", "standard error", "z", "p"];
    let columns = if inferential { 5 } else { 3 };
    let rows = (coefficients.iter())
        .map(|coefficient| {
            let mut row = vec![
                coefficient.name.clone(),
                fixed(coefficient.estimate, 3),
                maybe(coefficient.se, 3),
                maybe(coefficient.z, 2),
                coefficient.p.map(probability).unwrap_or_default(),
            ];
            row.truncate(columns);
            row
        })
        .collect();
    Grid::new(&header[..columns], rows)
}

fn thresholds(model: &Model) -> Grid {
    let rows = (model.thresholds.iter())
        .map(|threshold| vec![threshold.name.clone(), fixed(threshold.estimate, 3), maybe(threshold.se, 3)])
        .collect();
    Grid::new(&["between", "estimate", "standard error"], rows)
}

fn likelihood(tests: &[TermTest]) -> Grid {
    let rows = (tests.iter())
        .map(|test| {
            let p = match (test.lr, test.p) {
                (None, _) => "no maximum".to_owned(),
                (_, p) => p.map(probability).unwrap_or_default(),
            };
            vec![test.term.clone(), maybe(test.lr, 2), test.df.to_string(), p]
        })
        .collect();
    Grid::new(&["term", "χ²", "df", "p"], rows)
}

/// A sentence's first letter.
fn capital(text: &str) -> String {
    let mut letters = text.chars();
    // A factor's name stays as it is: it begins a sentence, and is no word of it.
    match letters.next() {
        Some(first)
            if text.starts_with("the ")
                || text.starts_with("no ")
                || text.starts_with("not ")
                || text.starts_with("only ") =>
        {
            first.to_uppercase().chain(letters).collect()
        }
        _ => text.to_owned(),
    }
}

/// A message of the command without the command's option.
fn without_flag(text: &str) -> &str {
    text.strip_prefix("--terms ").unwrap_or(text)
}
