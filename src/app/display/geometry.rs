//! Size of the screen, viewing distance, and the resulting size of a degree.

use std::path::PathBuf;

use eframe::egui;

use super::{calibrate::LABELS, card::CardHelper, tool::Tool};
use crate::{
    app::ui::{
        Field, Monitor, ScreenFields, Step, number, platform::Platform, show_error, text, theme::ink, tool_page,
    },
    display::{Viewing, geometry::distance_cm},
};

pub struct GeometryPage {
    window_deg: String,
    /// The width in cm that the screen reports, if any; `None` until it is queried.
    reported_cm: Option<Option<f64>>,
    card: Option<CardHelper>,
}

impl GeometryPage {
    /// Creates the page; `window_deg` is the planned stimulus size in degrees.
    pub fn new(window_deg: f64) -> Self {
        Self { window_deg: window_deg.to_string(), reported_cm: None, card: None }
    }

    fn fields(&mut self, ui: &mut egui::Ui, monitor: &Monitor, fields: &mut ScreenFields) {
        let reported_cm = *self.reported_cm.get_or_insert_with(|| Platform::of(monitor).width_cm);
        let field = |label| Field::new(label).column(LABELS);
        field("Width of the display area, cm").show(ui, |ui, label| {
            ui.horizontal_wrapped(|ui| {
                CardHelper::field(&mut self.card, ui, label, fields, monitor);
                let Some(reported) = reported_cm.map(|cm| format!("{cm:.1}")) else { return };
                let button = ui.button(format!("The screen reports {reported}"));
                let button = button.on_hover_text("Some screens report an incorrect width; check it with a card.");
                if button.clicked() {
                    fields.screen_width_cm = reported;
                }
            });
        });
        // The note has the same room without its text.
        let assumed = if fields.width_is_assumed() { monitor.assumption() + "." } else { String::new() };
        text::two_lines(ui, &assumed, ink(ui).warn, 2);
        field("Viewing distance, cm").width(90.0).text(ui, &mut fields.distance_cm);
        field("Planned stimulus size, degrees").width(90.0).text(ui, &mut self.window_deg);
    }

    fn sentences(&self, ui: &mut egui::Ui, viewing: &Viewing) {
        let screen = viewing.screen();
        let [width, height] = [screen.width_px, screen.height_px].map(|side| viewing.deg_from_px(side.into()));
        ui.label(format!(
            "One degree is {:.1} pixels, or {:.2} cm. One pixel is {:.2} arc minutes.",
            viewing.px_per_degree(),
            viewing.px_per_degree() / screen.px_per_cm(),
            60.0 / viewing.px_per_degree(),
        ));
        ui.label(format!(
            "The screen is {:.1} × {:.1} cm and fills {width:.1}° × {height:.1}°.",
            screen.width_cm,
            screen.height_cm(),
        ));
        let Some(planned) = number(&self.window_deg).filter(|deg| *deg > 0.0 && *deg < 170.0) else {
            show_error(ui, "The planned size is not an angle; expected degrees, such as 10.");
            return;
        };
        let wanted = viewing.px_from_deg(planned);
        let least = f64::from(screen.width_px.min(screen.height_px));
        if wanted <= least {
            ui.label(format!(
                "The {planned}° stimulus needs {wanted:.0} × {wanted:.0} pixels. It fits and spans {:.0} % of the \
                    screen's shorter side.",
                100.0 * wanted / least
            ));
        } else {
            show_error(
                ui,
                format!(
                    "The {planned}° stimulus needs {wanted:.0} × {wanted:.0} pixels; only {:.0} % of its width fits. It \
                        fits at a viewing distance of {:.0} cm or less.",
                    100.0 * least / wanted,
                    distance_cm(planned, screen.width_cm.min(screen.height_cm())).floor()
                ),
            );
        }
    }
}

impl Tool for GeometryPage {
    fn show(&mut self, ui: &mut egui::Ui, monitor: &Monitor, fields: &mut ScreenFields) -> Step<PathBuf> {
        let back = tool_page(ui, "Size and distance", |ui| {
            ui.label("Visual angles are correct only if the screen's width and the viewing distance are correct.");
            ui.add_space(8.0);
            self.fields(ui, monitor, fields);
            ui.add_space(12.0);
            match fields.viewing(monitor) {
                Ok(viewing) => self.sentences(ui, &viewing),
                Err(error) => show_error(ui, error),
            }
        });
        CardHelper::measure(&mut self.card, ui.ctx(), fields, monitor);
        Step::back_if(back)
    }
}
