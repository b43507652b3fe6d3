//! The cards beside the grid, and the selected session below it.

use eframe::egui::{self, Align, Color32, Frame, Layout, Panel, RichText, Ui};

use super::{
    actions::open,
    grid::{self, Cell},
    page::{Destination, Now, Open, Studies},
};
use crate::{
    app::ui::{
        self, action,
        theme::{self, Icon, KEY, LARGE_GAP, SECTION, ink},
    },
    experiment::{Factor, Protocol},
    report::{document::numbers::count, names},
    stimulus::ParameterValue,
    store::{definition, session::overview::SessionState},
};

/// In a card at least this wide, in points, a session and its buttons need one line.
const ONE_LINE: f32 = 800.0;

impl Studies {
    /// Draws the card of the selected session at the lower edge.
    pub(super) fn detail(&mut self, ui: &mut Ui, cell: &Cell, now: &mut Now<'_>) -> Option<Destination> {
        let session = self.recorded(cell);
        let mut next = None;
        let panel = Panel::bottom("detail").resizable(false).show_separator_line(false).frame(Frame::NONE);
        panel.show(ui, |ui| {
            for error in self.sessions.errors() {
                ui::show_error(ui, error.lines().next().unwrap_or_default());
            }
            if let Some(error) = &self.error
                && self.open.is_none()
            {
                ui::show_error(ui, error);
            }
            let name = now.checked.protocol.as_ref().map_or("", |protocol| &protocol.name);
            if self.sessions.of(name).next().is_some() {
                grid::key(ui);
            } else if self.sessions.errors().is_empty() {
                ui::hint(ui, format!("No sessions yet. They are saved in {}.", self.folder().display()));
                ui.add_space(theme::SMALL_GAP);
            }
            theme::card(ui).show(ui, |ui| {
                ui.set_min_width(ui.available_width());
                // A session that needs a second line must not move what is above.
                let lines = if ui.available_width() < ONE_LINE { 2.0 } else { 1.0 };
                ui.set_min_height(lines * (theme::CONTROL + theme::SMALL_GAP) - theme::SMALL_GAP);
                ui.horizontal_wrapped(|ui| {
                    ui.label(RichText::new(cell.title()).strong().size(SECTION));
                    let Some(session) = &session else {
                        Icon::Play.show(ui, ink(ui).text);
                        ui::hint(ui, "Not begun.");
                        return;
                    };
                    let (icon, color, told) = grid::told(session, &self.found.1.wrong, ink(ui));
                    icon.show(ui, color);
                    // An unreadable session has no date.
                    let day = session.started_at.get(..10).map(|day| format!(" (last used on {day})"));
                    ui.label(RichText::new(told + &day.unwrap_or_default()).small().color(color));
                    if !session.complete && action(ui, Icon::Resume, "Resume").clicked() {
                        next = self.resume(ui, session, now);
                    }
                    if ui.button("Open the file").clicked() {
                        open(ui, &session.csv);
                    }
                    if session.is_empty() && ui.button("Remove…").clicked() {
                        self.open = Some(Open::Removal(Box::new(session.clone())));
                    }
                });
            });
        });
        next
    }

    /// Draws what is planned against what is there, the last check, and the stimuli.
    pub(super) fn cards(&mut self, ui: &mut Ui, protocol: &Protocol) {
        let people = self.sessions.participants(&protocol.name);
        let sessions: Vec<_> = self.sessions.of(&protocol.name).collect();
        let number = |of: &dyn Fn(&SessionState) -> bool| sessions.iter().filter(|session| of(session)).count();
        let card = |ui: &mut Ui, add: &mut dyn FnMut(&mut Ui)| {
            theme::card(ui).show(ui, |ui| {
                ui.set_width(ui.available_width());
                add(ui);
            });
            ui.add_space(LARGE_GAP - ui.spacing().item_spacing.y);
        };
        card(ui, &mut |ui| {
            let planned = protocol.plan.participants;
            let whose = match planned {
                Some(planned) => format!("of {planned} participants planned"),
                None if people == 1 => "participant".to_owned(),
                None => "participants".to_owned(),
            };
            ui.horizontal_wrapped(|ui| {
                ui.label(RichText::new(people.to_string()).strong().size(KEY));
                ui.label(RichText::new(whose).weak());
            });
            let finished = number(&|session| session.complete && !session.is_damaged());
            let all = planned.map_or(sessions.len(), |planned| (planned * protocol.plan.sessions) as usize);
            if planned.is_some() {
                let share = finished as f32 / all.max(1) as f32;
                let fill = if finished > 0 { ink(ui).dim } else { Color32::TRANSPARENT };
                ui.add(egui::ProgressBar::new(share).desired_height(4.0).fill(fill));
            }
            if all > 0 {
                ui::hint(ui, format!("{finished} of {} finished.", count(all as u64, "session")));
            }
            let hash = definition::hash(protocol);
            let simulated = number(&|session| session.simulated);
            let others = number(&|session| session.is_readable && session.definition_sha256 != hash);
            for (n, what, note) in [
                (simulated, "Simulated (a program answered)", ""),
                (others, "Recorded with another definition of this name", " Only one is analyzed at a time."),
            ] {
                if n > 0 {
                    ui::note(ui, format!("{what}: {}.{note}", count(n as u64, "session")));
                }
            }
        });
        let found = Some(&self.found).filter(|(folder, _)| *folder == self.folder()).map(|(_, found)| found);
        card(ui, &mut |ui| {
            ui.horizontal(|ui| {
                ui.label(RichText::new("Check").strong().size(SECTION));
                let Some(found) = found else { return };
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    let (text, color, icon) = match found.errors.len() as u64 {
                        0 => ("no errors".to_owned(), ink(ui).good, Icon::Check),
                        n => (count(n, "error"), ink(ui).bad, Icon::Warn),
                    };
                    ui.label(RichText::new(text).small().color(color));
                    icon.show(ui, color);
                });
            });
            match found {
                None => ui::hint(ui, "Check renders every picture again and compares every row with the seed."),
                Some(found) if found.errors.is_empty() => {
                    let sessions = count(found.files.len() as u64, "session");
                    ui::hint(ui, format!("{sessions}: every row follows from its seed, and no file was changed."));
                }
                Some(found) => {
                    found.errors.iter().take(3).for_each(|error| ui::show_error(ui, error.to_string()));
                    if found.errors.len() > 3 {
                        ui::hint(ui, format!("and {} more", found.errors.len() - 3));
                    }
                }
            }
        });
        card(ui, &mut |ui| {
            ui.label(RichText::new("Stimuli").strong().size(SECTION));
            self.thumbnails.strip(ui, protocol);
            let known = Some(protocol.stimulus.parameters());
            let levels = |factor: &Factor| {
                let level = |level: &ParameterValue| names::level(known, &factor.name, &level.to_string()).to_string();
                let levels = match factor.levels.as_slice() {
                    [first, _, .., last] => format!("{} to {}", level(first), level(last)),
                    few => few.iter().map(level).collect::<Vec<_>>().join(" and "),
                };
                format!("{} {levels}", names::factor(known, &factor.name))
            };
            let factors: Vec<String> = protocol.factors.iter().map(levels).collect();
            let conditions = count(protocol.conditions().len() as u64, "condition");
            ui::hint(ui, if factors.is_empty() { conditions } else { format!("{conditions}: {}", factors.join(", ")) });
        });
    }
}
