//! Which model is to be fitted.

use eframe::egui::{self, DragValue, Key, TextEdit};

use crate::{
    analysis::{
        Link, MOST_NODES, ModelError, Options, Random,
        counts::Counts,
        terms::{TermError, Terms},
    },
    app::ui::{Field, fault, quiet},
};

/// The choices as they stand in their controls.
#[derive(Clone, Debug, Default)]
pub struct Settings {
    /// Without terms.
    options: Options,
    /// The terms as they are being typed.
    typed: String,
    /// And as they were when the field was left.
    terms: String,
}

impl Settings {
    /// What is to be computed.
    ///
    /// # Errors
    /// The text is not a list of terms.
    pub fn options(&self) -> Result<Options, TermError> {
        let terms = if self.terms.trim().is_empty() { None } else { Some(Terms::parse(&self.terms)?) };
        Ok(Options { terms, ..self.options.clone() })
    }

    /// Draws the controls. `error` is why the last model could not be fitted.
    pub fn show(&mut self, ui: &mut egui::Ui, counts: &Counts, people: usize, error: Option<&ModelError>) {
        self.terms_field(ui, counts, error);
        let options = &mut self.options;
        let links = [Link::Logit, Link::Probit];
        Field::new("Link").width(90.0).choice(ui, &mut options.link, &links, |link| link.to_string());
        let several = people > 1;
        let mut random = several && options.random.is_none();
        let response = ui.add_enabled(several, egui::Checkbox::new(&mut random, "An intercept for each participant"));
        response.on_disabled_hover_text("This takes two participants or more.");
        if several {
            options.random = (!random).then_some(Random::None);
        }
        ui.add_enabled_ui(random, |ui| {
            Field::new("Quadrature nodes").show(ui, |ui, label| {
                ui.add(DragValue::new(&mut options.quadrature).range(1..=MOST_NODES).speed(0.1)).labelled_by(label);
                ui.label(quiet(if options.quadrature == 1 { "Laplace" } else { "Gauss–Hermite" }));
            });
        });
        ui.checkbox(&mut options.scale, "Test effects on the spread too");
    }

    fn terms_field(&mut self, ui: &mut egui::Ui, counts: &Counts, error: Option<&ModelError>) {
        let varied = counts.factors.iter().filter(|factor| factor.levels.len() > 1);
        let hint = varied.map(|factor| factor.name.as_str()).collect::<Vec<_>>().join(",");
        let label = ui.label("Terms");
        let width = ui.available_width();
        let field = ui.add(TextEdit::singleline(&mut self.typed).hint_text(hint).desired_width(width));
        let field = field.labelled_by(label.id).on_hover_text(
            "Factors by name, num:NAME for a number, a:b for an interaction, a*b for both and their interaction. \
             num:inv_n is 1/depth. Empty: every factor.",
        );
        // Half a name is no name: the text counts when the field is left.
        if field.lost_focus() || field.has_focus() && ui.input(|input| input.key_pressed(Key::Enter)) {
            self.terms.clone_from(&self.typed);
        }
        let wrong = self.options().err().map(|error| error.to_string());
        if let Some(text) = wrong.or_else(|| error.filter(|error| is_about_terms(error)).map(ToString::to_string)) {
            fault(ui, text.strip_prefix("--terms ").unwrap_or(&text));
        }
    }

    /// What the terms name that is none of these factors.
    pub fn missing(&self, known: &[&str]) -> Vec<String> {
        let Ok(Options { terms: Some(terms), .. }) = self.options() else { return Vec::new() };
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

/// Whether a model failed because of its terms, so that the field is the place to say it.
fn is_about_terms(error: &ModelError) -> bool {
    matches!(error, ModelError::UnknownFactor { .. } | ModelError::NotANumber { .. } | ModelError::InfiniteDepth { .. })
}
