//! Undo and redo.

use eframe::egui::{Button, Key, KeyboardShortcut, Modifiers, Ui};

/// The number of changes that can be undone.
const MAX_CHANGES: usize = 200;
const UNDO: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::Z);
const REDO: [KeyboardShortcut; 2] = [
    KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::Z),
    KeyboardShortcut::new(Modifiers::COMMAND, Key::Y),
];

/// The earlier states of the settings of a page. A drag, or the text typed into a field, counts as one change.
#[derive(Clone, Debug, Default)]
pub struct History<T> {
    past: Vec<T>,
    /// The last recorded state.
    settled: T,
    /// The undone states; the next one to redo is last.
    future: Vec<T>,
}

impl<T: Clone + PartialEq> History<T> {
    /// Creates a history that begins with this state.
    pub fn new(state: T) -> Self {
        Self { past: Vec::new(), settled: state, future: Vec::new() }
    }

    /// Draws the buttons and follows the keys. *Reset* sets the state to `initial` and can be undone, too.
    pub fn show(&mut self, ui: &mut Ui, state: &mut T, initial: T) {
        // In a text field, these keys undo typing.
        let typing = ui.ctx().text_edit_focused();
        let mut pressed = |key| !typing && ui.input_mut(|input| input.consume_shortcut(&key));
        // Shift is ignored in the shortcut for undo, so the shortcuts for redo come first.
        let [mut redo, mut undo] = [REDO.into_iter().any(&mut pressed), pressed(UNDO)];
        let (is_changed, is_undone) = (*state != self.settled, !self.future.is_empty());
        ui.horizontal(|ui| {
            let mut button = |text, enabled, explanation| {
                ui.add_enabled(enabled, Button::new(text)).on_hover_text(explanation).clicked()
            };
            undo |= button("Undo", is_changed || !self.past.is_empty(), "Undoes the last change (Ctrl+Z).");
            redo |= button("Redo", is_undone && !is_changed, "Repeats the change that was undone (Ctrl+Shift+Z).");
            if button("Reset", *state != initial, "Sets everything here to its initial value. This can be undone.") {
                self.settle(state);
                state.clone_from(&initial);
            }
        });
        if undo {
            self.undo(state);
        } else if redo {
            self.redo(state);
        }
    }

    /// Records the state, unless it is still changing. Call this once a frame.
    pub fn record(&mut self, ui: &Ui, state: &T) {
        if !ui.input(|input| input.pointer.any_down()) && !ui.ctx().text_edit_focused() {
            self.settle(state);
        }
    }

    fn settle(&mut self, state: &T) {
        if *state == self.settled {
            return;
        }
        self.past.push(std::mem::replace(&mut self.settled, state.clone()));
        if self.past.len() > MAX_CHANGES {
            self.past.remove(0);
        }
        self.future.clear();
    }

    fn undo(&mut self, state: &mut T) {
        self.settle(state);
        if let Some(before) = self.past.pop() {
            self.future.push(std::mem::replace(&mut self.settled, before));
            state.clone_from(&self.settled);
        }
    }

    fn redo(&mut self, state: &mut T) {
        self.settle(state);
        if let Some(after) = self.future.pop() {
            self.past.push(std::mem::replace(&mut self.settled, after));
            state.clone_from(&self.settled);
        }
    }
}
