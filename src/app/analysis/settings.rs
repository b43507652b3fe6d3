//! What model is to be fitted.

use eframe::egui::{self, ComboBox, DragValue, Key, TextEdit};

use crate::{
    analysis::{
        Link, ModelError, Options, Random,
        counts::Counts,
        quadrature::MOST_NODES,
        terms::{TermError, Terms},
    },
    app::theme,
};

/// The choices as they stand in their controls.
#[derive(Clone, Debug)]
pub struct Settings {
    link: Link,
    random: bool,
    nodes: usize,
    scale: bool,
    /// The terms as they are being typed.
    typed: String,
    /// And as they were when the field was left.
    terms: String,
}

impl Default for Settings {
    fn default() -> Self {
        let options = Options::default();
        Self {
            link: options.link,
            random: true,
            nodes: options.quadrature,
            scale: options.scale,
            typed: String::new(),
            terms: String::new(),
        }
    }
}

impl Settings {
    /// What is to be computed.
    ///
    /// # Errors
    /// Terms that are none.
    pub fn options(&self) -> Result<Options, TermError> {
        let terms = if self.terms.trim().is_empty() { None } else { Some(Terms::parse(&self.terms)?) };
        Ok(Options {
            terms,
            link: self.link,
            random: (!self.random).then_some(Random::None),
            quadrature: self.nodes,
            scale: self.scale,
            ..Options::default()
        })
    }

    /// Draws the controls. `error` is why the last model could not be fitted.
    pub fn show(&mut self, ui: &mut egui::Ui, counts: &Counts, people: usize, error: Option<&ModelError>) {
        self.terms_field(ui, counts, error);
        ui.horizontal_wrapped(|ui| {
            let label = ui.label("Link");
            ComboBox::from_id_salt("link")
                .selected_text(self.link.to_string())
                .width(90.0)
                .show_ui(ui, |ui| {
                    for link in [Link::Logit, Link::Probit] {
                        ui.selectable_value(&mut self.link, link, link.to_string());
                    }
                })
                .response
                .labelled_by(label.id);
        });
        let several = people > 1;
        let mut random = self.random && several;
        let response = ui.add_enabled(several, egui::Checkbox::new(&mut random, "An intercept for each participant"));
        response.on_disabled_hover_text("One participant differs from nobody.");
        if several {
            self.random = random;
        }
        ui.add_enabled_ui(random, |ui| {
            ui.horizontal_wrapped(|ui| {
                let label = ui.label("Quadrature nodes");
                ui.add(DragValue::new(&mut self.nodes).range(1..=MOST_NODES).speed(0.1)).labelled_by(label.id);
                ui.label(theme::quiet(if self.nodes == 1 { "Laplace" } else { "Gauss–Hermite" }));
            });
        });
        ui.checkbox(&mut self.scale, "Test effects on the spread too");
    }

    fn terms_field(&mut self, ui: &mut egui::Ui, counts: &Counts, error: Option<&ModelError>) {
        let varied = counts.factors.iter().filter(|factor| factor.levels.len() > 1);
        let hint = varied.map(|factor| factor.name.as_str()).collect::<Vec<_>>().join(",");
        let label = ui.label("Terms");
        let width = ui.available_width();
        let field = ui.add(TextEdit::singleline(&mut self.typed).hint_text(hint).desired_width(width));
        let field = field.labelled_by(label.id).on_hover_text(
            "Factors by name, num:NAME for a number, a:b for an interaction, a*b for both and their interaction. num:inv_n is 1/depth. Empty: every factor.",
        );
        // Half a name is no name: what is typed counts when the field is left.
        if field.lost_focus() || field.has_focus() && ui.input(|input| input.key_pressed(Key::Enter)) {
            self.terms.clone_from(&self.typed);
        }
        let wrong = self.options().err().map(|error| error.to_string());
        if let Some(text) = wrong.or_else(|| error.filter(|error| is_about_terms(error)).map(ToString::to_string)) {
            theme::fault(ui, text.strip_prefix("--terms ").unwrap_or(&text));
        }
    }

    /// What the terms name that is none of these factors.
    pub fn missing<'a>(&self, known: impl Iterator<Item = &'a str> + Clone) -> Vec<String> {
        let Ok(Options { terms: Some(terms), .. }) = self.options() else { return Vec::new() };
        let mut names: Vec<String> = Vec::new();
        for name in terms.iter().flat_map(|term| &term.variables).map(|variable| variable.name()) {
            let is_there = |wanted: &str| known.clone().any(|other| other == wanted);
            let from_depth = name == "inv_n" && is_there("depth");
            if !is_there(name) && !from_depth && !names.iter().any(|other| other == name) {
                names.push(name.to_owned());
            }
        }
        names
    }
}

/// Whether a model failed because of its terms, so that the field is the place to say it.
fn is_about_terms(error: &ModelError) -> bool {
    matches!(error, ModelError::UnknownFactor { .. } | ModelError::NotANumber { .. } | ModelError::InfiniteDepth { .. })
}
