//! The page that asks about the participant before the first page of a session.

use eframe::egui::{self, Key, Modifiers, Ui};

use crate::{
    app::ui::{self, Field, Step, theme, today},
    experiment::{Answers, FieldKind, MAX_ANSWER, ParticipantField, Texts},
};

/// Width of the column of labels, points.
const LABELS: f32 = 220.0;

/// The questions of a definition and the answers so far.
pub struct ParticipantPage {
    fields: Vec<ParticipantField>,
    texts: Texts,
    /// The answers as typed or chosen, one for each field.
    typed: Vec<String>,
    /// Whether the participant has tried to continue, so that every error is shown.
    tried: bool,
    /// The field that gets the keyboard focus in the next frame.
    focus: Option<usize>,
    /// Whether a choice has the keyboard focus: Space chooses, and Enter continues as in every other field.
    on_choice: bool,
}

impl ParticipantPage {
    pub fn new(fields: &[ParticipantField], texts: &Texts) -> Self {
        let typed = vec![String::new(); fields.len()];
        Self { fields: fields.to_vec(), texts: texts.clone(), typed, tried: false, focus: Some(0), on_choice: false }
    }

    /// Draws the page; returns the answers once they are complete. `refused` says why the session could not begin.
    pub fn show(&mut self, ui: &mut Ui, refused: Option<&str>) -> Step<Answers> {
        let back = ui::escaped(ui);
        let entered = ui::entered(ui.ctx())
            || self.on_choice && ui.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Enter));
        self.on_choice = false;
        let (proceed, left) = ui::page_from(ui, 0.06, |ui| {
            ui.heading(&self.texts.about_you);
            ui::paragraph(ui, &self.texts.about_you_text);
            ui.add_space(theme::GAP);
            let focus = self.focus.take();
            for (at, (field, typed)) in self.fields.iter().zip(&mut self.typed).enumerate() {
                let error = match field.answer(typed, &self.texts) {
                    // An empty field is not an error before the participant tries to continue.
                    Err(error) if self.tried || !typed.trim().is_empty() => error,
                    _ => "",
                };
                let first = draw(ui, field, typed, &self.texts, error, &mut self.on_choice);
                if let Some(control) = first.filter(|_| focus == Some(at)) {
                    control.request_focus();
                    control.scroll_to_me(None);
                }
                ui.add_space(theme::GAP);
            }
            if let Some(refused) = refused {
                ui::show_error(ui, refused);
            }
            let proceed = ui::neutral_primary(ui, &self.texts.next, true, "Enter");
            ui.add_space(theme::SMALL_GAP);
            let left = ui::keyed(ui, &self.texts.previous, "Esc");
            (proceed || entered, left || back)
        });
        if left {
            return Step::Back;
        }
        if !proceed {
            return Step::Stay;
        }
        match self.answers() {
            Ok(answers) => Step::Next(answers),
            Err(at) => {
                (self.tried, self.focus) = (true, Some(at));
                ui.ctx().request_repaint();
                Step::Stay
            }
        }
    }

    /// Returns all answers, or the first field whose answer is not accepted.
    fn answers(&self) -> Result<Answers, usize> {
        let mut answers = Answers::new();
        for (at, (field, typed)) in self.fields.iter().zip(&self.typed).enumerate() {
            if let Some(answer) = field.answer(typed, &self.texts).map_err(|_| at)? {
                answers.insert(field.name.clone(), answer);
            }
        }
        Ok(answers)
    }
}

/// Draws a field; returns its first control.
fn draw(
    ui: &mut Ui,
    field: &ParticipantField,
    typed: &mut String,
    texts: &Texts,
    error: &str,
    on_choice: &mut bool,
) -> Option<egui::Response> {
    let mark = if field.required { " *" } else { "" };
    let label = field.label() + mark;
    if let Some(text) = &field.text {
        let tick = agreement(ui, &label, text, typed, &format!("{}{mark}", texts.agree), error);
        *on_choice |= tick.has_focus();
        return Some(tick);
    }
    let form = Field::new(&label).column(LABELS).slot().error(error);
    if field.kind() != FieldKind::Choice {
        let width = if field.kind() == FieldKind::Number { 90.0 } else { 300.0 };
        let edit = egui::TextEdit::singleline(typed).desired_width(width).char_limit(MAX_ANSWER);
        return Some(form.add(ui, edit));
    }
    form.show(ui, |ui, _| {
        let mut first = None;
        ui.horizontal_wrapped(|ui| {
            let none = (!field.required).then_some(("", texts.no_answer.as_str()));
            for (choice, shown) in field.options().into_iter().chain(none) {
                let radio = ui.radio(typed == choice, shown);
                if radio.clicked() {
                    choice.clone_into(typed);
                }
                *on_choice |= radio.has_focus();
                first.get_or_insert(radio);
            }
        });
        first
    })
}

/// Draws a text with a box to agree to it. The answer is the day.
fn agreement(ui: &mut Ui, label: &str, text: &str, typed: &mut String, agree: &str, error: &str) -> egui::Response {
    ui.label(egui::RichText::new(label).strong());
    theme::card(ui).show(ui, |ui| {
        ui.set_width(ui.available_width());
        text.split("\n\n").for_each(|paragraph| ui::paragraph(ui, paragraph));
    });
    let mut agreed = !typed.is_empty();
    let tick = ui.checkbox(&mut agreed, agree);
    if tick.changed() {
        *typed = if agreed { today().to_string() } else { String::new() };
    }
    // The error has the same room before there is one.
    ui::text::two_lines(ui, error, theme::ink(ui).bad, 2);
    tick
}
