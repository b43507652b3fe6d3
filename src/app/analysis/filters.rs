//! Whose ratings, and of which levels: check lists of the participants and of every factor's levels.

use eframe::egui::{self, CollapsingHeader, ScrollArea};

use super::look;
use crate::{
    analysis::{counts::Counts, measured::Measured},
    app::theme,
};

/// What is checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Filters {
    people: Vec<bool>,
    factors: Vec<Levels>,
}

/// The levels of a factor that are checked.
#[derive(Clone, Debug, PartialEq)]
struct Levels {
    checked: Vec<bool>,
    /// Conditions without a value of this factor; none where every condition has one.
    missing: Option<bool>,
}

impl Filters {
    /// Everything checked.
    pub fn new(counts: &Counts) -> Self {
        let factors = (counts.factors.iter().enumerate())
            .map(|(index, factor)| {
                let missing = counts.conditions.iter().any(|levels| levels[index].is_none());
                Levels { checked: vec![true; factor.levels.len()], missing: missing.then_some(true) }
            })
            .collect();
        Self { people: vec![true; counts.subjects.len()], factors }
    }

    /// Whether anything is left out.
    pub fn is_narrowed(&self) -> bool {
        self.people.contains(&false) || self.factors.iter().any(Levels::is_narrowed)
    }

    /// Participants that are checked.
    pub fn people(&self) -> usize {
        self.people.iter().filter(|checked| **checked).count()
    }

    /// What is left of a study.
    pub fn apply(&self, measured: &Measured) -> Measured {
        let level = |(levels, level): (&Levels, &Option<u32>)| match level {
            Some(level) => levels.checked[*level as usize],
            None => levels.missing != Some(false),
        };
        measured.filtered(
            |subject| self.people[subject as usize],
            |condition| self.factors.iter().zip(condition).all(level),
        )
    }

    /// What is left out, in words; empty where nothing is.
    pub fn words(&self, counts: &Counts) -> String {
        let mut parts = Vec::new();
        if self.people.contains(&false) {
            parts.push(format!("{} of {} participants", self.people(), self.people.len()));
        }
        for (levels, factor) in self.factors.iter().zip(&counts.factors).filter(|(levels, _)| levels.is_narrowed()) {
            let mut kept: Vec<&str> = (factor.levels.iter().zip(&levels.checked))
                .filter(|(_, checked)| **checked)
                .map(|(name, _)| name.as_str())
                .collect();
            kept.extend((levels.missing == Some(true)).then_some("missing"));
            parts.push(format!(
                "{} {}",
                factor.name,
                if kept.is_empty() { "none".to_owned() } else { kept.join(", ") }
            ));
        }
        parts.join("; ")
    }

    /// Draws the lists.
    pub fn show(&mut self, ui: &mut egui::Ui, counts: &Counts) {
        let title = format!("Participants: {} of {}", self.people(), self.people.len());
        list(ui, "participants", &title, |ui| {
            if all_or_none(ui, "participants").inspect(|all| self.people.fill(*all)).is_some() {
                ui.ctx().request_repaint();
            }
            // A long list in a box of its own, of which only what is seen is drawn.
            let height = ui.spacing().interact_size.y;
            ScrollArea::vertical().id_salt("people").max_height(190.0).show_rows(
                ui,
                height,
                self.people.len(),
                |ui, rows| {
                    ui.set_width(ui.available_width());
                    for row in rows {
                        let name = &counts.subjects[row];
                        let response = ui.checkbox(&mut self.people[row], name);
                        look::named(ui, &response, &format!("Participant {name}"));
                    }
                },
            );
        });
        for (levels, factor) in self.factors.iter_mut().zip(&counts.factors) {
            let title = format!("{}: {} of {} levels", factor.name, levels.number(), levels.most());
            list(ui, &factor.name, &title, |ui| {
                if let Some(all) = all_or_none(ui, &factor.name) {
                    levels.checked.fill(all);
                    levels.missing = levels.missing.map(|_| all);
                }
                ui.horizontal_wrapped(|ui| {
                    for (checked, name) in levels.checked.iter_mut().zip(&factor.levels) {
                        let response = ui.checkbox(checked, name);
                        look::named(ui, &response, &format!("{} {name}", factor.name));
                    }
                    if let Some(missing) = &mut levels.missing {
                        let response = ui.checkbox(missing, "missing");
                        look::named(ui, &response, &format!("{} missing", factor.name));
                    }
                });
            });
        }
    }
}

impl Levels {
    fn is_narrowed(&self) -> bool {
        self.checked.contains(&false) || self.missing == Some(false)
    }

    fn number(&self) -> usize {
        self.checked.iter().filter(|checked| **checked).count() + usize::from(self.missing == Some(true))
    }

    fn most(&self) -> usize {
        self.checked.len() + usize::from(self.missing.is_some())
    }
}

/// A list that folds away. Its title may change, its place does not.
fn list(ui: &mut egui::Ui, id: &str, title: &str, add: impl FnOnce(&mut egui::Ui)) {
    CollapsingHeader::new(title).id_salt(("filter", id)).show(ui, add);
}

/// The two buttons over a list.
fn all_or_none(ui: &mut egui::Ui, what: &str) -> Option<bool> {
    ui.horizontal(|ui| {
        let all = ui.small_button("All");
        look::named(ui, &all, &format!("All {what}"));
        let none = ui.small_button("None");
        look::named(ui, &none, &format!("None of {what}"));
        match (all.clicked(), none.clicked()) {
            (true, _) => Some(true),
            (_, true) => Some(false),
            _ => None,
        }
    })
    .inner
}

/// A word where nothing is left.
pub fn nothing_left(ui: &mut egui::Ui) {
    theme::fault(ui, "Nothing is left to analyse: check at least one participant, and a level of every factor.");
}
