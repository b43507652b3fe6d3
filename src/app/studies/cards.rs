//! The greeting, the cards beside the grid, and the selected session below it.

use eframe::egui::{self, Align, Color32, Frame, Layout, Panel, RichText, Ui};

use super::{
    actions::open_file,
    grid::{self, Cell},
    page::{Destination, Now, Open, Studies},
};
use crate::{
    app::ui::{
        self, Place, action, pixels,
        theme::{self, Icon, KEY, LARGE_GAP, SECTION, ink},
    },
    experiment::{Factor, Protocol},
    light::{Bits, Quantizer, Transfer},
    report::{document::numbers::count, names},
    stimulus::{MachBand, ParameterValue, Stimulus},
    store::{definition, session::overview::SessionState},
};

/// Side of the example image, physical pixels.
const PICTURE_PX: u32 = 88;
/// In a place lower than this, in points, there is no card of the selected session.
const ROOM_FOR_DETAIL: f32 = 160.0;

impl Studies {
    /// Shows a newcomer what a Mach band is.
    pub(super) fn greeting(&mut self, ui: &mut Ui, shown: &mut bool) -> Option<Destination> {
        let mut next = None;
        let frame = theme::card(ui).outer_margin(egui::Margin { bottom: LARGE_GAP as i8, ..Default::default() });
        Panel::top("greeting").resizable(false).show_separator_line(false).frame(frame).show(ui, |ui| {
            ui.horizontal(|ui| {
                let texture = self.picture.get_or_insert_with(|| {
                    let stimulus = Stimulus::MachBand(MachBand::default());
                    let quantizer = Quantizer::new(&Transfer::Srgb, Bits::Eight);
                    pixels::texture(ui.ctx(), "example", &stimulus.codes(PICTURE_PX, &quantizer))
                });
                pixels::picture(ui, texture, "A dark area and a bright area with a linear ramp between them");
                ui.vertical(|ui| {
                    ui.label(RichText::new("Do you see a bright line?").strong().size(SECTION));
                    ui::paragraph(
                        ui,
                        "It is where the ramp meets the bright area, but it is not in the image: it is a Mach band. \
                            In a session, participants rate how visible it is.",
                    );
                    ui.horizontal(|ui| {
                        if ui.button("See more stimuli").clicked() {
                            next = Some(Destination::Place(Place::Stimuli));
                        }
                        if ui.button("Hide").on_hover_text("Does not show this again.").clicked() {
                            *shown = false;
                        }
                    });
                });
            });
        });
        next
    }

    /// Draws the card of the selected session at the lower edge.
    pub(super) fn detail(&mut self, ui: &mut Ui, cell: &Cell, now: &mut Now<'_>) -> Option<Destination> {
        let session = self.recorded(cell);
        let mut next = None;
        let panel = Panel::bottom("detail").resizable(false).show_separator_line(false).frame(Frame::NONE);
        let is_low = ui.available_height() < ROOM_FOR_DETAIL;
        panel.show(ui, |ui| {
            for error in &self.sessions.all.errors {
                ui::show_error(ui, error.lines().next().unwrap_or_default());
            }
            if let Some(error) = &self.error
                && self.open.is_none()
            {
                ui::show_error(ui, error);
            }
            let name = now.checked.protocol.as_ref().map_or("", |protocol| &protocol.name);
            // In a low window, the grid needs the room.
            if is_low {
                return;
            }
            if self.sessions.of(name).next().is_some() {
                grid::key(ui);
            } else if self.sessions.all.errors.is_empty() {
                ui::hint(ui, format!("No sessions yet. They are saved in {}.", self.folder().display()));
                ui.add_space(theme::SMALL_GAP);
            }
            theme::card(ui).show(ui, |ui| {
                ui.set_min_width(ui.available_width());
                ui.set_min_height(theme::CONTROL);
                ui.horizontal_wrapped(|ui| {
                    ui.label(RichText::new(cell.title()).strong().size(SECTION));
                    let Some(session) = &session else {
                        Icon::Play.show(ui, ink(ui).text);
                        let is_filled_in = self.form.participant == cell.subject && self.form.session == cell.session;
                        let enter = match (cell.has_keys(ui), is_filled_in) {
                            (false, _) => "",
                            (true, true) => " Enter begins it.",
                            (true, false) => " Enter opens New session for it.",
                        };
                        ui::hint(ui, format!("Not begun.{enter}"));
                        return;
                    };
                    if !session.is_readable {
                        Icon::Warn.show(ui, ink(ui).bad);
                        ui.label(RichText::new("Its files cannot be read.").small().color(ink(ui).bad));
                        return;
                    }
                    let SessionState { rated, planned, complete, .. } = session;
                    let (icon, color, note) = match complete {
                        true if session.is_damaged() => {
                            (Icon::Warn, ink(ui).bad, "; it was finished, so check its file")
                        }
                        true => (Icon::Done, ink(ui).text, ""),
                        false => (Icon::Part, ink(ui).warn, ""),
                    };
                    icon.show(ui, color);
                    let text =
                        format!("{rated} of {planned} trials (with practice), last used on {}{note}", session.day());
                    ui.label(RichText::new(text).small().color(color));
                    if !complete && action(ui, Icon::Resume, "Resume").clicked() {
                        next = self.resume(ui, session, now);
                    }
                    if ui.button("Open the file").clicked() {
                        open_file(ui, session);
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
        let finished =
            self.sessions.of(&protocol.name).filter(|session| session.complete && !session.is_damaged()).count();
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
            let begun = self.sessions.of(&protocol.name).count();
            let all = planned.map_or(begun, |planned| (planned * protocol.plan.sessions) as usize);
            if planned.is_some() {
                let share = finished as f32 / all.max(1) as f32;
                let fill = if finished > 0 { ink(ui).dim } else { Color32::TRANSPARENT };
                ui.add(egui::ProgressBar::new(share).desired_height(4.0).fill(fill));
            }
            if all > 0 {
                ui::hint(ui, format!("{finished} of {} finished.", count(all as u64, "session")));
            }
            let simulated = self.sessions.of(&protocol.name).filter(|session| session.simulated).count();
            if simulated > 0 {
                ui::note(ui, format!("Simulated (a program answered): {}.", count(simulated as u64, "session")));
            }
            let hash = definition::hash(protocol);
            let others = self
                .sessions
                .of(&protocol.name)
                .filter(|session| session.is_readable && session.definition_sha256 != hash)
                .count();
            if others > 0 {
                let others = count(others as u64, "session");
                ui::note(
                    ui,
                    format!(
                        "Recorded with another definition of this name: {others}. Only one definition is analyzed at a time."
                    ),
                );
            }
            if planned.is_none() {
                let find =
                    if protocol.task.is_default() || protocol.adaptive.is_some() { "; Plan… finds one" } else { "" };
                ui::hint(ui, format!("The definition does not plan a number of participants{find}."));
            }
        });
        let found = self.found.clone().filter(|found| found.folder == self.folder());
        card(ui, &mut |ui| {
            ui.horizontal(|ui| {
                ui.label(RichText::new("Check").strong().size(SECTION));
                let Some(found) = &found else { return };
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    let (text, color, icon) = match found.errors.len() as u64 {
                        0 => ("no errors".to_owned(), ink(ui).good, Icon::Check),
                        n => (count(n, "error"), ink(ui).bad, Icon::Warn),
                    };
                    ui.label(RichText::new(text).small().color(color));
                    icon.show(ui, color);
                });
            });
            match &found {
                None => ui::hint(ui, "Check renders every picture again and compares every row with the seed."),
                Some(found) if found.errors.is_empty() => {
                    let sessions = count(found.sessions as u64, "session");
                    ui::hint(ui, format!("{sessions}: every row follows from its seed, and no file was changed."));
                }
                Some(found) => {
                    found.errors.iter().take(3).for_each(|error| ui::show_error(ui, error));
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
