//! The selection of participants and levels, and the choice of model.

use std::collections::HashSet;

use eframe::egui::{self, CollapsingHeader, ScrollArea};

use crate::{
    analysis::{
        Link, Random, Slopes,
        counts::{Counts, Exclusions},
        terms::Terms,
    },
    app::ui::{Field, folded, text::name},
    report::names,
    work::Analyze,
};

/// Width of the column of labels, points.
const LABELS: f32 = 124.0;

/// What is excluded, drawn as checklists of the participants and of the levels of every factor.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Filters(pub Exclusions);

impl Filters {
    /// Returns the number of participants who are left.
    pub fn people(&self, counts: &Counts) -> usize {
        counts.subjects.len() - self.0.exclude.len()
    }

    /// Returns the levels of a factor that are left; `None` if all are.
    fn kept(&self, factor: &str) -> Option<&[String]> {
        self.0.only.iter().find(|(name, _)| name == factor).map(|(_, kept)| &kept[..])
    }

    /// Draws the checklists. `label` returns the name of a factor as it is read.
    pub fn show(&mut self, ui: &mut egui::Ui, counts: &Counts, label: impl Fn(&str) -> String) {
        people(ui, &counts.subjects, &mut self.0.exclude);
        let mut only = Vec::new();
        for (index, factor) in counts.factors.iter().enumerate() {
            let names = counts.selectable_levels(index);
            let kept = self.kept(&factor.name);
            let levels: Vec<(String, bool)> =
                names.iter().map(|name| (shown(name), kept.is_none_or(|kept| kept.contains(name)))).collect();
            let levels = checklist(ui, [&factor.name; 2], [&label(&factor.name), " levels"], levels);
            if levels.contains(&false) {
                let kept = names.into_iter().zip(levels).filter(|(_, kept)| *kept).map(|(name, _)| name);
                only.push((factor.name.clone(), kept.collect()));
            }
        }
        self.0.only = only;
    }
}

/// Draws the checklist of the participants.
pub fn people(ui: &mut egui::Ui, all: &[String], excluded: &mut Vec<String>) {
    let out: HashSet<&str> = excluded.iter().map(String::as_str).collect();
    let people = all.iter().map(|id| (id.clone(), !out.contains(&**id))).collect();
    let people = checklist(ui, ["participants", "Participant"], ["Participants", ""], people);
    *excluded = all.iter().zip(people).filter(|(_, kept)| !kept).map(|(id, _)| id.clone()).collect();
}

/// Draws a list that can be folded away, below two buttons that check all or none; returns what is checked. Its state
/// belongs to `id`, because its title tells how many are checked. `of` precedes an entry in its name.
fn checklist(
    ui: &mut egui::Ui,
    [id, of]: [&str; 2],
    [title, unit]: [&str; 2],
    mut list: Vec<(String, bool)>,
) -> Vec<bool> {
    let checked = list.iter().filter(|(_, checked)| *checked).count();
    let title = format!("{title}: {checked} of {}{unit}", list.len());
    folded(ui, CollapsingHeader::new(title).id_salt(("filter", id)), |ui| {
        ui.horizontal(|ui| {
            for (text, label, all) in [("All", format!("All {id}"), true), ("None", format!("None of {id}"), false)] {
                let button = ui.small_button(text);
                name(ui, &button, &label);
                if button.clicked() {
                    list.iter_mut().for_each(|(_, checked)| *checked = all);
                    ui.ctx().request_repaint();
                }
            }
        });
        // A long list has its own scroll area; only the visible part is drawn.
        let height = ui.spacing().interact_size.y;
        let area = ScrollArea::vertical().id_salt(id).max_height(190.0);
        area.show_rows(ui, height, list.len(), |ui, rows| {
            ui.set_width(ui.available_width());
            for (text, checked) in &mut list[rows] {
                let response = ui.checkbox(checked, &**text);
                name(ui, &response, &format!("{of} {text}"));
            }
        });
    });
    list.into_iter().map(|(_, checked)| checked).collect()
}

/// Returns a level as it is read, such as ∞.
fn shown(level: &str) -> String {
    names::level(names::Known::None, "", level).to_string()
}

/// The values of the controls.
#[derive(Clone, Debug, Default)]
pub struct ModelControls {
    /// What is requested, except the ratings; the terms are the last valid ones, or `None` for all factors.
    pub request: Analyze,
    /// The terms as they are being typed.
    typed: String,
}

impl ModelControls {
    /// Draws the controls; `refused` says why the terms in use are not possible, if so.
    pub fn show(&mut self, ui: &mut egui::Ui, counts: &Counts, filters: &Filters, refused: &str) {
        self.terms_field(ui, counts, refused);
        let people = filters.people(counts);
        let request = &mut self.request;
        let field = |label| Field::new(label).column(LABELS).width(130.0);
        let links = [Link::Logit, Link::Probit];
        field("Link").choice(ui, &mut request.model.link, &links, |link| link.to_string());
        let several = people > 1;
        let mut random = several && request.random.is_none();
        let response = ui.add_enabled(several, egui::Checkbox::new(&mut random, "Random intercept per participant"));
        response.on_disabled_hover_text("This requires at least two participants.");
        if several {
            request.random = (!random).then_some(Random::None);
        }
        ui.add_enabled_ui(random, |ui| {
            let slopes = [Slopes::Independent, Slopes::Correlated, Slopes::None];
            field("Random slopes")
                .choice(ui, &mut request.model.slopes, &slopes, |slopes| slopes.to_string())
                .on_hover_text("How much the effects of the terms may differ between participants.");
            let items: Vec<Option<String>> =
                std::iter::once(None).chain(counts.factors.iter().map(|factor| Some(factor.name.clone()))).collect();
            field("Items")
                .choice(ui, &mut request.items, &items, |items| items.clone().unwrap_or_else(|| "none".to_owned()))
                .on_hover_text("The factor whose levels are a sample of stimuli, such as pictures.");
        });
        request.items.take_if(|items| !random || counts.factor(items).is_none());
    }

    fn terms_field(&mut self, ui: &mut egui::Ui, counts: &Counts, refused: &str) {
        let varied = counts.factors.iter().filter(|factor| factor.levels.len() > 1);
        let hint = varied.map(|factor| factor.name.as_str()).collect::<Vec<_>>().join(",");
        let parsed = self.parsed();
        let error = parsed.as_ref().err().map_or(refused, String::as_str);
        let is_used = parsed.as_ref().is_ok_and(|terms| *terms == self.request.model.terms);
        let note = if is_used { "" } else { "Press Enter to use these terms." };
        let field = Field::new("Terms").hint(&hint).width(ui.available_width()).slot().error(error).note(note, false);
        let field = field.text(ui, &mut self.typed);
        let field = field.on_hover_text(
            "List factors by name. Use num:NAME for a numeric factor, a:b for an interaction, and a*b for both factors \
             and their interaction. num:inv_n is 1/depth. If this is empty, the model uses every factor.",
        );
        // While they are typed, every prefix of the list would be analyzed.
        if let Some(terms) = parsed.ok().filter(|_| !field.has_focus()) {
            self.request.model.terms = terms;
        }
    }

    /// Returns the typed terms, or what is wrong with them.
    fn parsed(&self) -> Result<Option<Terms>, String> {
        if self.typed.trim().is_empty() { Ok(None) } else { self.typed.parse().map(Some) }
    }
}
