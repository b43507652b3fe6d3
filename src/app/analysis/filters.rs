//! Whose ratings, and of which levels: check lists of the participants and of every factor's levels.

use eframe::egui::{self, CollapsingHeader, ScrollArea};

use crate::{
    analysis::counts::{Counts, Measured},
    app::ui::text::name,
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
        let is_checked = |(levels, level): (&Levels, &Option<u32>)| match level {
            Some(level) => levels.checked[*level as usize],
            None => levels.missing != Some(false),
        };
        measured.filtered(
            |subject| self.people[subject as usize],
            |condition| self.factors.iter().zip(condition).all(is_checked),
        )
    }

    /// What is left, as a phrase; empty where nothing is left out.
    pub fn sentence(&self, counts: &Counts) -> String {
        let mut parts = Vec::new();
        if self.people.contains(&false) {
            parts.push(format!("{} of {} participants", self.people(), self.people.len()));
        }
        for (levels, factor) in self.factors.iter().zip(&counts.factors).filter(|(levels, _)| levels.is_narrowed()) {
            let checked = factor.levels.iter().zip(&levels.checked).filter(|(_, checked)| **checked);
            let mut kept: Vec<&str> = checked.map(|(name, _)| name.as_str()).collect();
            kept.extend((levels.missing == Some(true)).then_some("missing"));
            let kept = if kept.is_empty() { "none".to_owned() } else { kept.join(", ") };
            parts.push(format!("{} {kept}", factor.name));
        }
        parts.join("; ")
    }

    /// Draws the lists.
    pub fn show(&mut self, ui: &mut egui::Ui, counts: &Counts) {
        let title = format!("Participants: {} of {}", self.people(), self.people.len());
        list(ui, "participants", &title, |ui| {
            if let Some(all) = all_or_none(ui, "participants") {
                self.people.fill(all);
                ui.ctx().request_repaint();
            }
            // A long list in a box of its own, of which only the visible part is drawn.
            let height = ui.spacing().interact_size.y;
            let area = ScrollArea::vertical().id_salt("people").max_height(190.0);
            area.show_rows(ui, height, self.people.len(), |ui, rows| {
                ui.set_width(ui.available_width());
                for row in rows {
                    check(ui, &mut self.people[row], "Participant", &counts.subjects[row]);
                }
            });
        });
        for (levels, factor) in self.factors.iter_mut().zip(&counts.factors) {
            let missing = levels.missing.iter();
            let checked = levels.checked.iter().chain(missing.clone()).filter(|checked| **checked).count();
            let all = levels.checked.len() + missing.count();
            list(ui, &factor.name, &format!("{}: {checked} of {all} levels", factor.name), |ui| {
                if let Some(all) = all_or_none(ui, &factor.name) {
                    levels.checked.fill(all);
                    levels.missing = levels.missing.map(|_| all);
                }
                ui.horizontal_wrapped(|ui| {
                    for (checked, level) in levels.checked.iter_mut().zip(&factor.levels) {
                        check(ui, checked, &factor.name, level);
                    }
                    if let Some(missing) = &mut levels.missing {
                        check(ui, missing, &factor.name, "missing");
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
}

/// A list that folds away. Its title may change, its place does not.
fn list(ui: &mut egui::Ui, id: &str, title: &str, add: impl FnOnce(&mut egui::Ui)) {
    CollapsingHeader::new(title).id_salt(("filter", id)).show(ui, add);
}

fn check(ui: &mut egui::Ui, checked: &mut bool, of: &str, text: &str) {
    let response = ui.checkbox(checked, text);
    name(ui, &response, &format!("{of} {text}"));
}

/// The two buttons over a list.
fn all_or_none(ui: &mut egui::Ui, what: &str) -> Option<bool> {
    ui.horizontal(|ui| {
        let buttons = [("All", format!("All {what}"), true), ("None", format!("None of {what}"), false)];
        let clicked = |(text, label, all): (&str, String, bool)| {
            let button = ui.small_button(text);
            name(ui, &button, &label);
            button.clicked().then_some(all)
        };
        buttons.map(clicked).into_iter().flatten().next()
    })
    .inner
}
