//! Undo and redo.

use eframe::egui::{Button, Id, Key, KeyboardShortcut, Modifiers, Ui, util::undoer::Undoer};

const UNDO: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::Z);
const REDO: [KeyboardShortcut; 2] = [
    KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::Z),
    KeyboardShortcut::new(Modifiers::COMMAND, Key::Y),
];

/// The earlier states of the settings of a page. A drag, or the text typed into a field, counts as one change.
#[derive(Clone, Debug, Default)]
pub struct History<T: Clone + PartialEq> {
    states: Undoer<T>,
    /// What had the focus before.
    focused: Option<Id>,
    /// Whether the focus has moved since the last state: typing into one field has ended, perhaps in another one.
    has_moved: bool,
}

impl<T: Clone + PartialEq> History<T> {
    /// Creates a history that begins with this state.
    pub fn new(state: T) -> Self {
        let mut states = Undoer::default();
        states.add_undo(&state);
        Self { states, focused: None, has_moved: false }
    }

    /// Draws the buttons and follows the keys. *Reset* sets the state to `initial` and can be undone, too.
    pub fn show(&mut self, ui: &mut Ui, state: &mut T, initial: T) {
        // In a text field, these keys undo typing.
        let typing = ui.ctx().text_edit_focused();
        let mut pressed = |key| !typing && ui.input_mut(|input| input.consume_shortcut(&key));
        // Shift is ignored in the shortcut for undo, so the shortcuts for redo come first.
        let [mut redo, mut undo] = [REDO.into_iter().any(&mut pressed), pressed(UNDO)];
        ui.horizontal(|ui| {
            let mut button = |text, enabled, explanation| {
                ui.add_enabled(enabled, Button::new(text)).on_hover_text(explanation).clicked()
            };
            undo |= button("Undo", self.states.has_undo(state), "Undoes the last change (Ctrl+Z).");
            redo |= button("Redo", self.states.has_redo(state), "Redoes the change that was undone (Ctrl+Shift+Z).");
            if button("Reset", *state != initial, "Sets everything here to its initial value. This can be undone.") {
                self.settle(state);
                state.clone_from(&initial);
            }
        });
        let found = match () {
            () if undo => self.states.undo(state),
            () if redo => self.states.redo(state),
            () => None,
        };
        if let Some(found) = found {
            state.clone_from(found);
        }
    }

    /// Records the state if it has changed and the user is not in the middle of a drag or of typing.
    pub fn record(&mut self, ui: &Ui, state: &T) {
        let focused = ui.memory(|memory| memory.focused());
        self.has_moved |= focused != self.focused;
        self.focused = focused;
        if !ui.input(|input| input.pointer.any_down()) && (self.has_moved || !ui.ctx().text_edit_focused()) {
            self.settle(state);
            self.has_moved = false;
        }
    }

    fn settle(&mut self, state: &T) {
        // egui records a state that has not changed for a while, so it sees the same state twice, long apart.
        self.states.feed_state(0.0, state);
        self.states.feed_state(f64::INFINITY, state);
    }
}
