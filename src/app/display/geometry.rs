//! Size of the screen, viewing distance, and the resulting size of a degree.

use std::path::PathBuf;

use eframe::egui::{self, Stroke, TextEdit, Vec2};

use super::{card::CardHelper, tool::Tool};
use crate::{
    app::ui::{
        Field, Monitor, ScreenFields, Step, describe, note, number, platform::Platform, secondary, show_error,
        theme::ink, tool_page,
    },
    display::{Viewing, geometry::distance_cm},
};

/// Length of the drawn ruler in centimeters.
const RULER_CM: u32 = 10;

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
        Field::new("Width of the display area, cm").show(ui, |ui, label| {
            let assumed = format!("{:.1}", monitor.assumed_width_cm());
            let edit = TextEdit::singleline(&mut fields.screen_width_cm).desired_width(90.0).hint_text(assumed);
            ui.add(edit).labelled_by(label);
            if ui.button("Measure with a card…").clicked() {
                let known = number(&fields.screen_width_cm).unwrap_or_else(|| monitor.assumed_width_cm());
                self.card = Some(CardHelper::new(known, monitor.width_px));
            }
            if let Some(cm) = reported_cm
                && ui
                    .button(format!("The screen reports {cm:.1}"))
                    .on_hover_text("Some screens report an incorrect width; check it with the ruler below.")
                    .clicked()
            {
                fields.screen_width_cm = format!("{cm:.1}");
            }
        });
        if fields.width_is_assumed() {
            let per_inch = monitor.assumed_per_inch();
            note(
                ui,
                format!("This width assumes {per_inch} pixels per inch. Measure it, or check it with the ruler below."),
            );
        }
        Field::new("Viewing distance, cm").width(90.0).text(ui, &mut fields.distance_cm);
        Field::new("Planned stimulus size, degrees").width(90.0).text(ui, &mut self.window_deg);
    }

    fn sentences(&self, ui: &mut egui::Ui, viewing: &Viewing) {
        let screen = viewing.screen();
        let [width, height] = [screen.width_px(), screen.height_px()].map(|side| viewing.deg_from_px(side.into()));
        ui.label(format!(
            "One degree is {:.1} pixels, or {:.2} cm. One pixel is {:.2} arc minutes.",
            viewing.px_per_degree(),
            viewing.px_per_degree() / screen.px_per_cm(),
            60.0 / viewing.px_per_degree(),
        ));
        ui.label(format!(
            "The screen is {:.1} × {:.1} cm and fills {width:.1}° × {height:.1}°.",
            screen.width_cm(),
            screen.height_cm(),
        ));
        let Some(planned) = number(&self.window_deg).filter(|deg| *deg > 0.0 && *deg < 170.0) else {
            show_error(ui, "The planned size is not an angle; expected degrees, such as 10.");
            return;
        };
        let wanted = viewing.px_from_deg(planned);
        let least = f64::from(screen.width_px().min(screen.height_px()));
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
                    distance_cm(planned, screen.width_cm().min(screen.height_cm())).floor()
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
                Ok(viewing) => {
                    self.sentences(ui, &viewing);
                    rulers(ui, &viewing);
                }
                Err(error) => show_error(ui, error.to_string()),
            }
        });
        if let Some(width) = CardHelper::measured(&mut self.card, ui.ctx(), monitor.width_px) {
            fields.screen_width_cm = width.to_string();
        }
        Step::back_if(back)
    }
}

/// Draws a ruler in centimeters and a line that marks degrees, for comparison with a real ruler.
fn rulers(ui: &mut egui::Ui, viewing: &Viewing) {
    let points_per_cm = (viewing.screen().px_per_cm() / f64::from(ui.ctx().pixels_per_point())) as f32;
    ui.add_space(12.0);
    ui.label(secondary("Hold a ruler against the screen to compare. The lower line marks one, five and ten degrees."));
    let degrees = [1.0, 5.0, 10.0].map(|deg| viewing.cm_from_deg(deg) as f32 * points_per_cm);
    let width = (RULER_CM as f32 * points_per_cm).max(degrees[2]);
    let (rect, response) =
        ui.allocate_exact_size(Vec2::new((width + 12.0).min(ui.available_width()), 84.0), egui::Sense::hover());
    describe(&response, "A ruler of ten centimeters");
    let painter = ui.painter_at(rect);
    let ink = ink(ui);
    let stroke = Stroke::new(1.0, ink.text);
    let tick = |x: f32, y: f32, height: f32, text: String| {
        let foot = rect.min + Vec2::new(x + 0.5, y);
        painter.line_segment([foot, foot - Vec2::new(0.0, height)], stroke);
        if !text.is_empty() {
            let align = if x == 0.0 { egui::Align2::LEFT_TOP } else { egui::Align2::CENTER_TOP };
            painter.text(foot, align, text, egui::FontId::proportional(12.0), ink.dim);
        }
    };
    for mm in 0..=10 * RULER_CM {
        let height = if mm % 10 == 0 { 14.0 } else { 7.0 };
        let text = if mm % 10 == 0 { (mm / 10).to_string() } else { String::new() };
        tick(mm as f32 / 10.0 * points_per_cm, 18.0, height, text);
    }
    let foot = rect.min + Vec2::new(0.0, 58.0);
    painter.line_segment([foot, foot + Vec2::new(degrees[2], 0.0)], stroke);
    tick(0.0, 58.0, 10.0, "0°".to_owned());
    for (x, text) in degrees.into_iter().zip(["1°", "5°", "10°"]) {
        tick(x, 58.0, 10.0, text.to_owned());
    }
}
