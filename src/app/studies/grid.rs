//! The participants of a study and their sessions, as a grid.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::{Path, PathBuf},
};

use eframe::egui::{
    self, Color32, FocusDirection, Id, Key, Modifiers, Popup, Rect, RichText, ScrollArea, Sense, Shape, Stroke,
    StrokeKind, TextStyle, Ui, UiBuilder, Vec2,
};

use crate::{
    app::ui::{
        describe,
        theme::{CONTROL, GAP, ICON, Icon, Ink, ROW, ink},
        work::Latest,
    },
    experiment::{Identity, Plan},
    store::session::overview::{Overview, SessionState},
    text::names::natural,
};

/// Width of the column of participants, and minimum and maximum width of their answers, points.
const NAMES: f32 = 96.0;
const ANSWERS: [f32; 2] = [136.0, 208.0];
/// Minimum and maximum width of a cell, points.
const CELL: [f32; 2] = [88.0, 280.0];
/// Length of a dash around the next session, points.
const DASH: f32 = 3.0;

/// The sessions in a results folder, which are read on a separate thread.
#[derive(Default)]
pub struct Sessions {
    /// Increased to read the folder again.
    edition: u64,
    /// What was read last stays until the folder has been read again.
    read: Latest<(PathBuf, u64), Overview>,
}

impl Sessions {
    /// Reads the folder again, because it may have changed.
    pub fn refresh(&mut self) {
        self.edition += 1;
    }

    /// Updates what is known about the folder.
    pub fn update(&mut self, ui: &Ui, results: &Path) {
        self.read.want(ui.ctx(), (results.to_owned(), self.edition), || {
            let results = results.to_owned();
            move || Ok(Overview::of(&results))
        });
    }

    fn all(&self) -> Option<&Overview> {
        self.read.last()?.as_ref().ok()
    }

    /// Returns the errors of sessions and folders that cannot be read.
    pub fn errors(&self) -> &[String] {
        self.all().map_or(&[], |all| &all.errors)
    }

    /// Returns the sessions of an experiment.
    pub fn of<'a>(&'a self, experiment: &'a str) -> impl Iterator<Item = &'a SessionState> {
        self.all().into_iter().flat_map(|all| &all.sessions).filter(move |session| session.experiment == experiment)
    }

    /// Returns how many people took part in an experiment.
    pub fn participants(&self, experiment: &str) -> usize {
        self.of(experiment).map(|session| session.identity.subject()).collect::<BTreeSet<_>>().len()
    }
}

/// A participant and a session.
#[derive(Clone, Debug, Default, Hash, PartialEq, Eq, PartialOrd, Ord)]
pub struct Cell {
    pub subject: String,
    pub session: String,
}

impl Cell {
    pub fn of(identity: &Identity) -> Self {
        Self { subject: identity.subject().to_owned(), session: identity.session().to_owned() }
    }

    /// Returns the first session of a participant.
    pub fn first(subject: &str) -> Self {
        Self { subject: subject.to_owned(), session: "1".to_owned() }
    }

    pub fn title(&self) -> String {
        format!("{}, session {}", self.subject, self.session)
    }

    fn id(&self) -> Id {
        Id::unique(("session", self))
    }

    /// Returns whether keys go to the grid in which this cell is selected: no other control has the focus.
    fn has_keys(&self, ui: &Ui) -> bool {
        ui.memory(|memory| {
            memory.focused().is_none_or(|id| id == self.id()) && memory.allows_interaction(ui.layer_id())
        }) && !Popup::is_any_open(ui.ctx())
    }
}

/// What the user does with a cell of the grid, which is then selected.
#[derive(Debug)]
pub enum Action {
    Select,
    /// Resumes, begins or opens its session.
    Enter,
    /// Removes its session.
    Remove,
}

/// The grid of a study.
pub struct Grid<'a> {
    sessions: BTreeMap<Cell, &'a SessionState>,
    subjects: Vec<String>,
    columns: Vec<String>,
    next: Cell,
    /// The data files in which a check found errors.
    wrong: &'a BTreeSet<PathBuf>,
}

impl<'a> Grid<'a> {
    /// Arranges the sessions of a study, and those that are planned. `next` is the next new participant.
    pub fn new(
        sessions: impl Iterator<Item = &'a SessionState>,
        plan: Plan,
        next: Cell,
        wrong: &'a BTreeSet<PathBuf>,
    ) -> Self {
        let sessions: BTreeMap<_, _> = sessions.map(|session| (Cell::of(&session.identity), session)).collect();
        let mut subjects: Vec<String> = sessions.keys().map(|cell| cell.subject.clone()).collect();
        let mut columns: Vec<String> = sessions.keys().map(|cell| cell.session.clone()).collect();
        columns.extend((1..=plan.sessions).map(|number| number.to_string()));
        columns.push(next.session.clone());
        for list in [&mut subjects, &mut columns] {
            list.sort_by(|a, b| natural(a, b));
            list.dedup();
        }
        let before = subjects.len();
        if !subjects.contains(&next.subject) && !next.subject.is_empty() {
            subjects.push(next.subject.clone());
        }
        let missing = (plan.participants.unwrap_or_default() as usize).saturating_sub(subjects.len());
        let free = (1..).map(|number| format!("P{number:03}")).filter(|id| !subjects.contains(id));
        subjects.extend(free.take(missing).collect::<Vec<_>>());
        subjects[before..].sort_by(|a, b| natural(a, b));
        Self { sessions, subjects, columns, next, wrong }
    }

    /// Returns what a key does in the grid.
    fn keyed(&self, ui: &Ui, selected: &Cell) -> Option<(Cell, Action)> {
        let presses = |key| ui.input(|input| input.num_presses(key));
        // A dialog that opens in this frame must not take Enter for its answer.
        if ui.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Enter)) {
            return Some((selected.clone(), Action::Enter));
        }
        if presses(Key::Delete) > 0 {
            return Some((selected.clone(), Action::Remove));
        }
        let [up, down, left, right] =
            [Key::ArrowUp, Key::ArrowDown, Key::ArrowLeft, Key::ArrowRight].map(|key| presses(key) as isize);
        // Without participants, as in a folder that cannot be read, there is nowhere to go.
        if up + down + left + right == 0 || self.subjects.is_empty() {
            return None;
        }
        let moved = |list: &[String], id: &String, by: isize| {
            let at = list.iter().position(|other| other == id).unwrap_or_default();
            list[at.saturating_add_signed(by).min(list.len() - 1)].clone()
        };
        let subject = moved(&self.subjects, &selected.subject, down - up);
        let cell = Cell { subject, session: moved(&self.columns, &selected.session, right - left) };
        ui.memory_mut(|memory| {
            memory.request_focus(cell.id());
            memory.move_focus(FocusDirection::None);
        });
        Some((cell, Action::Select))
    }

    /// Draws the grid in the available room; returns what the user did. `has_keys`: no dialog is open.
    pub fn show(&self, ui: &mut Ui, selected: &Cell, has_keys: bool) -> Option<(Cell, Action)> {
        let has_answers = self.sessions.values().any(|session| !session.answers.is_empty());
        let columns = self.columns.len() as f32;
        let room = ui.available_width() - NAMES - GAP;
        let is_wide = has_answers && ui.available_width() > 560.0;
        let answers = if is_wide { (room - columns * (CELL[1] + GAP)).clamp(ANSWERS[0], ANSWERS[1]) } else { 0.0 };
        let room = room - answers;
        let width = (room / columns - GAP).clamp(CELL[0], CELL[1]).floor();
        let has_keys = has_keys && selected.has_keys(ui);
        let mut chosen = if has_keys { self.keyed(ui, selected) } else { None };
        let selected = &chosen.as_ref().map_or(selected, |(cell, _)| cell).clone();
        let (id, now) = (ui.scope_id().with("selected"), Some((selected.id(), ui.available_height().to_bits())));
        let is_new = ui.data_mut(|data| std::mem::replace(data.get_temp_mut_or_default(id), now)) != now;
        ui.spacing_mut().item_spacing = Vec2::new(GAP, 1.0);
        let (head, _) = ui.allocate_exact_size(Vec2::new(ui.available_width(), CONTROL), Sense::hover());
        // What scrolls later, in the next pass, would scroll twice if that pass asks for it as well.
        let scrolled = ScrollArea::both().id_salt("grid").auto_shrink(true).animated(false).show(ui, |ui| {
            for subject in &self.subjects {
                ui.horizontal(|ui| {
                    let cell = |session: &String| Cell { subject: subject.clone(), session: session.clone() };
                    let here = || self.columns.iter().filter_map(|session| self.sessions.get(&cell(session)));
                    let color = if here().next().is_none() { ink(ui).off } else { ink(ui).text };
                    text(ui, NAMES, RichText::new(subject).color(color));
                    if answers > 0.0 {
                        let told = here().map(|session| session.answers.as_str()).find(|told| !told.is_empty());
                        text(ui, answers - GAP, RichText::new(told.unwrap_or_default()).small().color(ink(ui).dim));
                    }
                    for cell in self.columns.iter().map(cell) {
                        let ring = (*selected == cell).then_some(has_keys);
                        let (rect, done) = self.cell(ui, &cell, width, ring);
                        if is_new && ring.is_some() {
                            ui.scroll_to_rect(rect, None);
                        }
                        chosen = done.or(chosen.take());
                    }
                });
            }
        });
        // The head stays where it is while the rows scroll.
        let head_at = head.translate(Vec2::new(-scrolled.state.clamped_offset().x, 0.0));
        let ui = &mut ui.new_child(UiBuilder::new().max_rect(head_at));
        ui.shrink_clip_rect(head);
        ui.horizontal(|ui| self.head(ui, answers, width));
        chosen
    }

    fn head(&self, ui: &mut Ui, answers: f32, width: f32) {
        let dim = ink(ui).dim;
        let mut head = |width: f32, title: &str| text(ui, width, RichText::new(title).small().color(dim));
        head(NAMES, "Participants");
        if answers > 0.0 {
            head(answers - GAP, "Answers");
        }
        self.columns.iter().for_each(|session| head(width, &format!("Session {session}")));
    }

    /// Draws a cell. The selected one, the only cell that Tab reaches, has a ring, which tells whether keys go to the grid.
    /// Also returns its place.
    fn cell(&self, ui: &mut Ui, cell: &Cell, width: f32, ring: Option<bool>) -> (Rect, Option<(Cell, Action)>) {
        let (rect, _) = ui.allocate_exact_size(Vec2::new(width, CONTROL - 1.0), Sense::hover());
        let is_selected = ring.is_some();
        let response = ui.interact(rect, cell.id(), if is_selected { Sense::click() } else { Sense::CLICK });
        let ink = ink(ui);
        let session = self.sessions.get(cell);
        let is_next = session.is_none() && *cell == self.next;
        let (icon, color, said) = match session {
            Some(session) => told(session, self.wrong, ink),
            None if is_next => (Icon::Play, ink.text, "next".to_owned()),
            None => (Icon::None, ink.off, "not begun".to_owned()),
        };
        let text = match session {
            Some(session) if !session.is_readable => "unreadable".to_owned(),
            Some(SessionState { rated, planned, .. }) if rated < planned => format!("{rated} of {planned}"),
            Some(session) => session.rated.to_string(),
            None => if is_next { "next" } else { "" }.to_owned(),
        };
        let name = format!("{}: {said}", cell.title());
        response.widget_info(|| egui::WidgetInfo::selected(egui::Role::Button, true, is_selected, &name));
        if ui.is_rect_visible(rect) {
            let painter = ui.painter();
            let fill = match (is_selected, response.hovered(), session.is_some()) {
                (true, ..) => ink.raised,
                (_, true, _) => ink.hover,
                (.., true) => ink.card,
                _ => Color32::TRANSPARENT,
            };
            painter.rect_filled(rect, 4.0, fill);
            let outline = rect.shrink(0.5);
            if let Some(has_keys) = ring {
                let ring = if has_keys { Stroke::new(2.0, ink.ink) } else { Stroke::new(1.0, ink.edge) };
                painter.rect_stroke(rect, 4.0, ring, StrokeKind::Inside);
            } else if is_next {
                let [top, bottom] = [outline.top(), outline.bottom()]
                    .map(|y| [outline.left(), outline.right()].map(|x| egui::pos2(x, y)));
                let around = [top[0], top[1], bottom[1], bottom[0], top[0]];
                painter.extend(Shape::dashed_line(&around, Stroke::new(1.0, ink.edge), DASH, DASH));
            } else if session.is_none() {
                painter.rect_stroke(rect, 4.0, Stroke::new(1.0, ink.line), StrokeKind::Inside);
            }
            let square =
                Rect::from_min_size(egui::pos2(rect.left() + GAP, rect.center().y - ICON / 2.0), Vec2::splat(ICON));
            icon.paint(painter, square, color);
            let at = egui::pos2(square.right() + GAP, rect.center().y);
            painter.text(at, egui::Align2::LEFT_CENTER, text, TextStyle::Body.resolve(ui.style()), color);
        }
        if response.double_clicked() {
            return (rect, Some((cell.clone(), Action::Enter)));
        }
        // Enter on the selected cell also counts as a click.
        let clicked = response.clicked_by(egui::PointerButton::Primary) && !is_selected;
        let selects = || {
            response.request_focus();
            (cell.clone(), Action::Select)
        };
        (rect, clicked.then(selects))
    }
}

/// Returns the sign of a session, its color, and its state in words. In the data files in `wrong`, a check found errors.
pub fn told(session: &SessionState, wrong: &BTreeSet<PathBuf>, ink: &Ink) -> (Icon, Color32, String) {
    let SessionState { csv, rated, planned, complete, is_readable, .. } = session;
    match complete {
        _ if wrong.contains(csv) => (Icon::Warn, ink.bad, "check failed".to_owned()),
        _ if !is_readable => (Icon::Warn, ink.bad, "cannot be read".to_owned()),
        true if session.is_damaged() => {
            (Icon::Warn, ink.bad, format!("was finished, but only {rated} of {planned} trials are left"))
        }
        true => (Icon::Done, ink.text, format!("finished, {rated} trials")),
        false => (Icon::Part, ink.warn, format!("unfinished, {rated} of {planned} trials")),
    }
}

/// Draws what the signs in the grid mean.
pub fn key(ui: &mut Ui) {
    let ink = ink(ui);
    ui.horizontal_wrapped(|ui| {
        ui.set_height(ROW);
        for (icon, color, meaning) in [
            (Icon::Done, ink.text, "finished"),
            (Icon::Part, ink.warn, "unfinished"),
            (Icon::None, ink.off, "not begun"),
            (Icon::Warn, ink.bad, "check failed"),
        ] {
            ui.horizontal(|ui| {
                icon.show(ui, color);
                ui.label(RichText::new(meaning).small().color(ink.dim));
                ui.add_space(GAP);
            });
        }
    });
}

/// Draws text in a column.
fn text(ui: &mut Ui, width: f32, text: RichText) {
    let size = Vec2::new(width, CONTROL - 1.0);
    ui.allocate_ui_with_layout(size, egui::Layout::left_to_right(egui::Align::Center), |ui| {
        ui.set_min_size(size);
        let said = text.text().to_owned();
        let response = ui.add(egui::Label::new(text).truncate());
        if said.is_empty() {
            describe(&response, "no answers");
        }
    });
}
