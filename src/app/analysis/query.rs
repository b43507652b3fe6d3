//! The selection of participants and levels, and the choice of model.

use eframe::egui::{self, CollapsingHeader, Key, ScrollArea, TextEdit};

use crate::{
    analysis::{
        Link, ModelError, Options, Random, Slopes,
        counts::{Counts, Factor, Measured},
        find_factor, level_number,
        terms::{Terms, Variable},
    },
    app::ui::{Field, show_error, text::name},
};

/// Width of the column of labels, points.
const LABELS: f32 = 124.0;
/// Seconds without a key after which typed terms are used.
const PAUSE_S: f64 = 0.4;

/// Checklists of the participants and of the levels of every factor.
#[derive(Clone, Debug, PartialEq)]
pub struct Filters {
    people: Vec<bool>,
    /// The levels of each factor. If some conditions have no value, an extra last level represents them.
    factors: Vec<Vec<bool>>,
}

impl Filters {
    /// Selects everything.
    pub fn new(counts: &Counts) -> Self {
        let factors = counts.factors.iter().enumerate().map(|(index, factor)| {
            let missing = counts.conditions.iter().any(|levels| levels[index].is_none());
            vec![true; factor.levels.len() + usize::from(missing)]
        });
        Self { people: vec![true; counts.subjects.len()], factors: factors.collect() }
    }

    /// Returns whether anything is excluded.
    pub fn is_narrowed(&self) -> bool {
        self.people.contains(&false) || self.factors.iter().any(|levels| levels.contains(&false))
    }

    /// Returns the number of selected participants.
    pub fn people(&self) -> usize {
        checked(&self.people)
    }

    /// Returns the selected part of a study.
    pub fn apply(&self, measured: &Measured) -> Measured {
        let is_checked = |(levels, level): (&Vec<bool>, &Option<u32>)| {
            level.map_or(levels.last(), |level| levels.get(level as usize)) == Some(&true)
        };
        measured.filtered(
            |subject| self.people[subject as usize],
            |condition| self.factors.iter().zip(condition).all(is_checked),
        )
    }

    /// Checks that the terms name factors, or columns that can become factors, and use as numbers only selected levels
    /// that are numbers.
    fn check(&self, terms: &Terms, counts: &Counts, is_column: &dyn Fn(&str) -> bool) -> Result<(), ModelError> {
        for variable in terms.iter().flat_map(|term| &term.variables) {
            let (index, inverse) = match find_factor(counts, variable) {
                Ok(found) => found,
                Err(_) if is_column(variable.name()) => continue,
                Err(error) => return Err(error),
            };
            let factor = &counts.factors[index];
            let selected = factor.levels.iter().zip(&self.factors[index]).filter(|(_, selected)| **selected);
            if let Variable::Number(_) = variable {
                selected
                    .map(|(level, _)| level)
                    .try_for_each(|level| level_number(factor, level, inverse).map(drop))?;
            }
        }
        Ok(())
    }

    /// Returns the selection as a phrase; empty if nothing is excluded.
    pub fn sentence(&self, counts: &Counts) -> String {
        let mut parts = Vec::new();
        if self.people.contains(&false) {
            parts.push(format!("{} of {} participants", self.people(), self.people.len()));
        }
        for (levels, factor) in self.factors.iter().zip(&counts.factors).filter(|(levels, _)| levels.contains(&false)) {
            let kept: Vec<&str> = names(factor).zip(levels).filter(|(_, kept)| **kept).map(|(name, _)| name).collect();
            let kept = if kept.is_empty() { "none".to_owned() } else { kept.join(", ") };
            parts.push(format!("{} {kept}", factor.name));
        }
        parts.join("; ")
    }

    /// Draws the checklists.
    pub fn show(&mut self, ui: &mut egui::Ui, counts: &Counts) {
        let title = format!("Participants: {} of {}", self.people(), self.people.len());
        list(ui, "participants", &title, &mut self.people, |ui, people| {
            // A long list has its own scroll area; only the visible part is drawn.
            let height = ui.spacing().interact_size.y;
            let area = ScrollArea::vertical().id_salt("people").max_height(190.0);
            area.show_rows(ui, height, people.len(), |ui, rows| {
                ui.set_width(ui.available_width());
                for row in rows {
                    check(ui, &mut people[row], "Participant", &counts.subjects[row]);
                }
            });
        });
        for (levels, factor) in self.factors.iter_mut().zip(&counts.factors) {
            let title = format!("{}: {} of {} levels", factor.name, checked(levels), levels.len());
            list(ui, &factor.name, &title, levels, |ui, levels| {
                ui.horizontal_wrapped(|ui| {
                    for (checked, level) in levels.iter_mut().zip(names(factor)) {
                        check(ui, checked, &factor.name, level);
                    }
                });
            });
        }
    }
}

fn checked(list: &[bool]) -> usize {
    list.iter().filter(|checked| **checked).count()
}

/// Returns the levels of a factor, and the label for conditions without a level.
fn names(factor: &Factor) -> impl Iterator<Item = &str> {
    factor.levels.iter().map(String::as_str).chain(["missing"])
}

/// Draws a collapsible list below two buttons that select all or none. Its state belongs to `id`, so its title may
/// change.
fn list(ui: &mut egui::Ui, id: &str, title: &str, list: &mut [bool], add: impl FnOnce(&mut egui::Ui, &mut [bool])) {
    CollapsingHeader::new(title).id_salt(("filter", id)).show(ui, |ui| {
        ui.horizontal(|ui| {
            for (text, label, all) in [("All", format!("All {id}"), true), ("None", format!("None of {id}"), false)] {
                let button = ui.small_button(text);
                name(ui, &button, &label);
                if button.clicked() {
                    list.fill(all);
                    ui.ctx().request_repaint();
                }
            }
        });
        add(ui, list);
    });
}

fn check(ui: &mut egui::Ui, checked: &mut bool, of: &str, text: &str) {
    let response = ui.checkbox(checked, text);
    name(ui, &response, &format!("{of} {text}"));
}

/// The values of the controls.
#[derive(Clone, Debug, Default)]
pub struct Settings {
    /// All options except the terms.
    options: Options,
    /// The terms as they are being typed.
    typed: String,
    /// When they were last changed, seconds.
    changed_s: f64,
    /// The last valid terms, which are used; `None` for all factors.
    terms: Option<Terms>,
}

impl Settings {
    /// Returns the requested analysis.
    pub fn options(&self) -> Options {
        Options { terms: self.terms.clone(), ..self.options.clone() }
    }

    /// Draws the controls. `is_column` says whether the files have a column that is not a factor yet.
    pub fn show(&mut self, ui: &mut egui::Ui, counts: &Counts, filters: &Filters, is_column: &dyn Fn(&str) -> bool) {
        self.terms_field(ui, counts, filters, is_column);
        let people = filters.people();
        let options = &mut self.options;
        let links = [Link::Logit, Link::Probit];
        Field::new("Link").column(LABELS).width(130.0).choice(ui, &mut options.link, &links, |link| link.to_string());
        let several = people > 1;
        let mut random = several && options.random.is_none();
        let response = ui.add_enabled(several, egui::Checkbox::new(&mut random, "Random intercept per participant"));
        response.on_disabled_hover_text("This requires at least two participants.");
        if several {
            options.random = (!random).then_some(Random::None);
        }
        ui.add_enabled_ui(random, |ui| {
            let slopes = [Slopes::Independent, Slopes::Correlated, Slopes::None];
            Field::new("Random slopes")
                .column(LABELS)
                .width(130.0)
                .choice(ui, &mut options.slopes, &slopes, |slopes| slopes.to_string())
                .on_hover_text("How much the effects of the terms may differ between participants.");
        });
    }

    fn terms_field(&mut self, ui: &mut egui::Ui, counts: &Counts, filters: &Filters, is_column: &dyn Fn(&str) -> bool) {
        let varied = counts.factors.iter().filter(|factor| factor.levels.len() > 1);
        let hint = varied.map(|factor| factor.name.as_str()).collect::<Vec<_>>().join(",");
        let label = ui.label("Terms");
        let width = ui.available_width();
        let field = ui.add(TextEdit::singleline(&mut self.typed).hint_text(hint).desired_width(width));
        let field = field.labelled_by(label.id).on_hover_text(
            "List factors by name. Use num:NAME for a numeric factor, a:b for an interaction, and a*b for both factors \
             and their interaction. num:inv_n is 1/depth. If this is empty, the model uses every factor.",
        );
        let now = ui.input(|input| input.time);
        if field.changed() {
            self.changed_s = now;
        }
        // Every prefix of a list of terms would be analyzed without a pause.
        let left = self.changed_s + PAUSE_S - now;
        let entered = field.lost_focus() || field.has_focus() && ui.input(|input| input.key_pressed(Key::Enter));
        match self.parsed(counts, filters, is_column) {
            Ok(terms) if terms == self.terms => {}
            Ok(terms) if left <= 0.0 || entered => self.terms = terms,
            Ok(_) => ui.ctx().request_repaint_after_secs(left as f32),
            Err(error) => show_error(ui, error),
        }
    }

    /// Returns the typed terms, or what is wrong with them.
    fn parsed(
        &self,
        counts: &Counts,
        filters: &Filters,
        is_column: &dyn Fn(&str) -> bool,
    ) -> Result<Option<Terms>, String> {
        if self.typed.trim().is_empty() {
            return Ok(None);
        }
        let plain = |error: String| error.strip_prefix("--terms ").map_or(error.clone(), ToOwned::to_owned);
        let terms = Terms::parse(&self.typed).map_err(|error| plain(error.to_string()))?;
        match filters.check(&terms, counts, is_column) {
            Ok(()) => Ok(Some(terms)),
            Err(ModelError::UnknownFactor { name, known }) => {
                Err(format!("There is no factor {name}. Enter some of {}.", known.join(", ")))
            }
            Err(error) => Err(plain(error.to_string())),
        }
    }

    /// Returns the names in the terms that are not among these factors.
    pub fn missing(&self, known: &[&str]) -> Vec<String> {
        let Some(terms) = &self.terms else { return Vec::new() };
        let mut names: Vec<String> = Vec::new();
        for name in terms.iter().flat_map(|term| &term.variables).map(|variable| variable.name()) {
            let from_depth = name == "inv_n" && known.contains(&"depth");
            if !known.contains(&name) && !from_depth && !names.iter().any(|other| other == name) {
                names.push(name.to_owned());
            }
        }
        names
    }
}
