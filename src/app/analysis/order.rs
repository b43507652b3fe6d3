//! Asks for the order of ratings in words.

use eframe::egui::{self, Button, Frame};

use crate::{
    app::ui::{hint, paragraph, primary, section, text::name as label},
    report::Study,
    store::table::List,
    work::Ratings,
};

/// The list of categories that the user puts in order.
#[derive(Clone, Debug)]
pub struct CategoryOrder {
    /// How the categories were read.
    pub ratings: Ratings,
    response: String,
    categories: Vec<String>,
}

impl CategoryOrder {
    /// Creates the list if the order of the categories is unknown.
    pub fn needed(study: &Study, ratings: &Ratings) -> Option<Self> {
        let (shape, counts) = (&study.source.shape, &study.measured.counts);
        (!counts.is_ordered(shape.categories.as_deref())).then(|| Self {
            ratings: ratings.clone(),
            response: shape.response.clone(),
            categories: counts.categories.clone(),
        })
    }

    /// Draws the list; returns how to read the files once the user confirms the order.
    pub fn show(&mut self, ui: &mut egui::Ui) -> Option<Ratings> {
        section(ui, "What is the order of the ratings?");
        hint(
            ui,
            format!(
                "The ratings in the column {} are words, so their order is not known. Drag them into order, lowest first, \
                 or move them with the buttons.",
                self.response
            ),
        );
        let last = self.categories.len() - 1;
        let mut moved = None;
        for (at, category) in self.categories.iter().enumerate() {
            // The ID belongs to the category, so that a button keeps keyboard focus when its category moves.
            ui.push_id(category, |ui| {
                let drag = ui.scope_id().with("drag");
                let (_, dropped) = ui.dnd_drop_zone::<usize, _>(Frame::NONE.inner_margin(2.0), |ui| {
                    ui.horizontal(|ui| {
                        let ways = [("Up", at.checked_sub(1)), ("Down", (at < last).then_some(at + 1))];
                        for (way, to) in ways {
                            let button = ui.add_enabled(to.is_some(), Button::new(way));
                            label(ui, &button, &format!("{way}: {category}"));
                            if button.clicked() {
                                moved = to.map(|to| (at, to));
                            }
                        }
                        let end = match at {
                            0 => " (lowest)",
                            _ if at == last => " (highest)",
                            _ => "",
                        };
                        ui.dnd_drag_source(drag, at, |ui| paragraph(ui, format!("{}. {category}{end}", at + 1)));
                    });
                });
                if let Some(from) = dropped {
                    moved = Some((*from, at));
                }
            });
        }
        if let Some((from, to)) = moved {
            let category = self.categories.remove(from);
            self.categories.insert(to, category);
        }
        let categories = || Some(List(self.categories.clone()));
        let confirmed = primary(ui, "Analyze in this order", true, "");
        confirmed.then(|| Ratings { categories: categories(), ..self.ratings.clone() })
    }
}
