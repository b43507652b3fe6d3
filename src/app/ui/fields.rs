//! Labeled controls.

use std::ops::RangeInclusive;

use eframe::{
    egui::{self, Align, ComboBox, Id, Label, Layout, Response, Slider, TextEdit, Ui, Widget},
    emath::{Numeric, format_with_decimals_in_range},
};

use super::{
    dialog::{FileKind, browse},
    text,
    theme::{GAP, MESSAGE, SMALL_GAP, focus_ring, outline_wrong},
};

/// On a page narrower than this many times the width of the label column, the labels are above the controls.
const NARROW: f32 = 2.0;
/// Width reserved for a slider's number, points.
const NUMBER: f32 = 62.0;
/// Minimum remaining width on a line for a slider and its number, points.
const SLIDER: f32 = 190.0;
/// Width reserved for the button after a path, and minimum width of a path on its line, points.
const BROWSE: f32 = 116.0;
const PATH: f32 = 120.0;

/// A control with its label. They are on one line that wraps, or the label is in a column of labels.
#[derive(Clone, Copy)]
pub struct Field<'a> {
    label: &'a str,
    name: Option<&'a str>,
    hint: &'a str,
    suffix: &'a str,
    error: &'a str,
    note: (&'a str, bool),
    width: Option<f32>,
    column: Option<f32>,
    slot: bool,
    log: bool,
}

impl<'a> Field<'a> {
    /// Creates a field on one line.
    pub fn new(label: &'a str) -> Self {
        let (name, hint, suffix, error, note) = Default::default();
        Self { label, name, hint, suffix, error, note, width: None, column: None, slot: false, log: false }
    }

    /// Puts the label in a column of this width, points.
    pub fn column(self, width: f32) -> Self {
        Self { column: Some(width), ..self }
    }

    /// Sets the name for screen readers, if it differs from the label.
    pub fn named(self, name: &'a str) -> Self {
        Self { name: Some(name), ..self }
    }

    /// Sets the hint in an empty text field.
    pub fn hint(self, hint: &'a str) -> Self {
        Self { hint, ..self }
    }

    /// Sets the unit after a slider's number.
    pub fn suffix(self, suffix: &'a str) -> Self {
        Self { suffix, ..self }
    }

    /// Makes a slider logarithmic.
    pub fn log(self) -> Self {
        Self { log: true, ..self }
    }

    /// Sets the error to show below the control; empty for none.
    pub fn error(self, error: &'a str) -> Self {
        Self { error, ..self }
    }

    /// Sets what is said below the control while it has no error, and whether that deserves attention; empty for nothing.
    pub fn note(self, note: &'a str, warns: bool) -> Self {
        Self { note: (note, warns), ..self }
    }

    /// Keeps room for a line below the control, so that an error shifts nothing.
    pub fn slot(self) -> Self {
        Self { slot: true, ..self }
    }

    /// Sets the width of the control, points.
    pub fn width(self, width: f32) -> Self {
        Self { width: Some(width), ..self }
    }

    /// Draws the label and its control. `add` gets the label's ID for [`Response::labelled_by`].
    pub fn show<R>(self, ui: &mut Ui, add: impl FnOnce(&mut Ui, Id) -> R) -> R {
        let add = |ui: &mut Ui, label| {
            if !self.error.is_empty() {
                outline_wrong(ui);
            }
            add(ui, label)
        };
        let Some(column) = self.column else {
            let line = |ui: &mut Ui| {
                let label = ui.label(self.label).id;
                add(ui, label)
            };
            let added = ui.horizontal_wrapped(line).inner;
            self.show_errors(ui);
            return added;
        };
        let add = |ui: &mut Ui, label| {
            let added = add(ui, label);
            self.show_errors(ui);
            added
        };
        if ui.available_width() < NARROW * column {
            let label = ui.label(self.label).id;
            return ui.vertical(|ui| add(ui, label)).inner;
        }
        ui.horizontal_top(|ui| {
            let size = egui::vec2(column, ui.spacing().interact_size.y);
            let label = ui.allocate_ui_with_layout(size, Layout::left_to_right(Align::Center), |ui| {
                ui.set_min_width(column);
                ui.add(Label::new(self.label).wrap()).id
            });
            ui.vertical(|ui| add(ui, label.inner)).inner
        })
        .inner
    }

    fn show_errors(self, ui: &mut Ui) {
        let tell = |ui: &mut Ui| match self.note {
            (note, warns) if self.error.is_empty() && !note.is_empty() => {
                if warns {
                    text::note(ui, note)
                } else {
                    text::hint(ui, note)
                }
            }
            _ => text::errors(ui, self.error),
        };
        if self.slot {
            // Two lines of a message fit, without the space that otherwise separates fields.
            let height = MESSAGE + 2.0 * SMALL_GAP;
            ui.allocate_ui(egui::vec2(ui.available_width(), height), |ui| {
                ui.set_min_height(height);
                tell(ui);
            });
            ui.add_space(-ui.spacing().item_spacing.y);
        } else {
            tell(ui);
        }
    }

    /// Draws the label and any control.
    pub fn add(self, ui: &mut Ui, control: impl Widget) -> Response {
        self.show(ui, |ui, label| {
            let response = ui.add(control);
            self.labeled(ui, response, label)
        })
    }

    /// Draws a single-line text field.
    pub fn text(self, ui: &mut Ui, value: &mut String) -> Response {
        let width = self.width.unwrap_or(ui.spacing().text_edit_width);
        // Errors that appear on the page change the IDs of what follows; a field must keep its focus.
        let edit = TextEdit::singleline(value).id_salt(("field", self.name.unwrap_or(self.label)));
        self.add(ui, edit.desired_width(width).hint_text(self.hint))
    }

    /// Draws a field for a path and the button that browses for it, whose name is `name`; it is below a field that
    /// would be too short. Also returns whether a path was chosen.
    pub fn path(self, ui: &mut Ui, path: &mut String, (kind, name): (FileKind, &str)) -> (Response, bool) {
        let mut line = |ui: &mut Ui, label| {
            let room = ui.available_width() - BROWSE;
            let width = self.width.unwrap_or(if room < PATH { ui.available_width() - GAP } else { room });
            let edit = TextEdit::singleline(path).id_salt(("field", self.label));
            let field = ui.add(edit.desired_width(width).hint_text(self.hint)).labelled_by(label);
            (field, browse(ui, kind, name, path))
        };
        self.show(ui, |ui, label| ui.horizontal_wrapped(|ui| line(ui, label)).inner)
    }

    /// Draws a slider. The value keeps all its digits until the slider is moved.
    pub fn slider<N: Numeric>(self, ui: &mut Ui, value: &mut N, range: RangeInclusive<N>, step: f64) -> Response {
        let decimals = (-step.log10()).ceil().max(0.0);
        let scale = 10_f64.powf(decimals);
        self.show(ui, |ui, label| {
            match self.column {
                Some(_) => {
                    let room = self.width.unwrap_or(f32::INFINITY).min(ui.available_width());
                    ui.spacing_mut().slider_width = (room - NUMBER).max(60.0);
                }
                None if ui.available_size_before_wrap().x < SLIDER => ui.end_row(),
                None => {}
            }
            // A slider rounds its value and would report this as a change.
            let mut shown = (value.to_f64() * scale).round() / scale;
            let slider = Slider::new(&mut shown, range.start().to_f64()..=range.end().to_f64())
                .step_by(step)
                .logarithmic(self.log)
                .max_decimals(decimals as usize)
                .custom_formatter(|value, decimals| text::signed(&format_with_decimals_in_range(value, decimals)))
                .custom_parser(|typed| number(&typed.replace('−', "-")))
                .suffix(self.suffix);
            let response = ui.add(slider);
            focus_ring(ui, &response);
            if response.changed() {
                *value = N::from_f64(shown);
            }
            self.labeled(ui, response, label)
        })
    }

    /// Draws a drop-down list.
    pub fn choice<T: Clone + PartialEq>(
        self,
        ui: &mut Ui,
        value: &mut T,
        all: &[T],
        text: impl Fn(&T) -> String,
    ) -> Response {
        self.show(ui, |ui, label| {
            let width = self.width.or(self.column.map(|_| ui.available_width()));
            let style = ui.style().clone();
            let list = ComboBox::from_id_salt(self.name.unwrap_or(self.label)).selected_text(text(value)).height(400.0);
            let list = match width {
                Some(width) => list.width(width).truncate(),
                None => list,
            };
            let list = list.show_ui(ui, |ui| {
                ui.set_style(style);
                for one in all {
                    if entry(ui, value == one, text(one)).clicked() {
                        *value = one.clone();
                    }
                }
            });
            self.labeled(ui, list.response, label)
        })
    }

    /// Draws radio buttons, with all options visible.
    pub fn radio<T: Clone + PartialEq>(self, ui: &mut Ui, value: &mut T, all: &[(T, &str)]) {
        self.show(ui, |ui, _| {
            ui.horizontal_wrapped(|ui| {
                for (one, text) in all {
                    ui.radio_value(value, one.clone(), *text);
                }
            });
        });
    }

    fn labeled(self, ui: &Ui, response: Response, label: Id) -> Response {
        match self.name {
            Some(name) => {
                text::name(ui, &response, name);
                response
            }
            None => response.labelled_by(label),
        }
    }
}

/// Draws an entry of a drop-down list, which it closes, also with Enter.
pub fn entry(ui: &mut Ui, is_chosen: bool, text: impl Into<String>) -> Response {
    let entry = ui.selectable_label(is_chosen, text.into());
    if entry.clicked() {
        ui.close();
    }
    entry
}

/// Parses a typed number; `None` if the text is not a number.
pub fn number(text: &str) -> Option<f64> {
    // Many countries use a decimal comma.
    text.trim().replace(',', ".").parse().ok().filter(|value: &f64| value.is_finite())
}
