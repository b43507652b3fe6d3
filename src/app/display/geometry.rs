//! Geometry: how large the screen is, from where it is seen, and what a degree is then.

use eframe::egui::{self, Color32, Key, Stroke, Vec2};

use super::{
    ToolGo,
    card::{CardHelper, CardOutcome},
    tool,
};
use crate::{
    app::{Monitor, form::parse, platform::Platform, theme},
    display::{Geometry, GeometryError, Screen, Viewing},
};

/// Centimetres of the ruler that is drawn.
const RULER_CM: u32 = 10;

/// The page.
pub struct GeometryPane {
    width_cm: String,
    distance_cm: String,
    window_deg: String,
    /// What the screen itself says, once it was asked.
    told_cm: Option<Option<f64>>,
    card: Option<CardHelper>,
}

impl GeometryPane {
    /// With what is known so far; `window_deg` is the size that the experiment plans.
    pub fn new(width_cm: String, distance_cm: String, window_deg: f64) -> Self {
        Self { width_cm, distance_cm, window_deg: window_deg.to_string(), told_cm: None, card: None }
    }

    /// Width of the screen and distance, both cm, as typed.
    pub fn typed(&self) -> (&str, &str) {
        (&self.width_cm, &self.distance_cm)
    }

    /// Draws the page.
    pub fn show(&mut self, ui: &mut egui::Ui, monitor: &Monitor) -> ToolGo {
        let told = *self.told_cm.get_or_insert_with(|| Platform::of(monitor).width_cm);
        let viewing = self.viewing(monitor);
        let mut back = false;
        tool(ui, "Size and distance", &mut back, |ui| {
            ui.label("Visual angles are true only where the screen's width and the distance of the eye are.");
            ui.add_space(8.0);
            self.fields(ui, monitor, told);
            ui.add_space(12.0);
            match &viewing {
                Ok(viewing) => {
                    self.sentences(ui, viewing);
                    rulers(ui, viewing);
                }
                Err(error) => theme::fault(ui, &error.to_string()),
            }
        });
        self.card(ui.ctx(), monitor);
        let escaped = self.card.is_none() && ui.input(|input| input.key_pressed(Key::Escape));
        if back || escaped { ToolGo::Back } else { ToolGo::Stay }
    }

    fn viewing(&self, monitor: &Monitor) -> Result<Viewing, GeometryError> {
        // What is no number is outside every range.
        let number = |text: &str| parse(text).unwrap_or(f64::NAN);
        Viewing::new(
            Screen::new(monitor.width_px, monitor.height_px, number(&self.width_cm))?,
            number(&self.distance_cm),
        )
    }

    fn fields(&mut self, ui: &mut egui::Ui, monitor: &Monitor, told: Option<f64>) {
        ui.horizontal_wrapped(|ui| {
            let label = ui.label("Width of the lit part, cm");
            ui.add(egui::TextEdit::singleline(&mut self.width_cm).desired_width(90.0)).labelled_by(label.id);
            if ui.button("Measure with a card…").clicked() {
                let known = parse(&self.width_cm).unwrap_or_else(|| monitor.assumed_width_cm());
                self.card = Some(CardHelper::new(known, monitor.width_px));
            }
            if let Some(cm) = told
                && ui
                    .button(format!("The screen says {cm:.1}"))
                    .on_hover_text("Some screens say it wrongly: compare the ruler.")
                    .clicked()
            {
                self.width_cm = format!("{cm:.1}");
            }
        });
        if self.width_cm.trim() == format!("{:.1}", monitor.assumed_width_cm()) {
            let text = "This width is assumed from 96 pixels an inch: measure it, or compare the ruler below.";
            ui.add(egui::Label::new(egui::RichText::new(text).small().color(theme::NOTE)).wrap());
        }
        ui.horizontal_wrapped(|ui| {
            let label = ui.label("Distance from eye to screen, cm");
            ui.add(egui::TextEdit::singleline(&mut self.distance_cm).desired_width(90.0)).labelled_by(label.id);
        });
        ui.horizontal_wrapped(|ui| {
            let label = ui.label("Planned size of the stimulus, degrees");
            ui.add(egui::TextEdit::singleline(&mut self.window_deg).desired_width(90.0)).labelled_by(label.id);
        });
    }

    fn sentences(&self, ui: &mut egui::Ui, viewing: &Viewing) {
        let screen = viewing.screen();
        let [width, height] = [screen.width_px(), screen.height_px()].map(|side| viewing.deg_from_px(side.into()));
        ui.label(format!(
            "A degree is {:.1} pixels, or {:.2} cm. A pixel is {:.2} arc minutes.",
            viewing.px_per_degree(),
            viewing.px_per_degree() / screen.px_per_cm(),
            60.0 / viewing.px_per_degree(),
        ));
        ui.label(format!(
            "The screen is {:.1} × {:.1} cm and fills {width:.1}° × {height:.1}°.",
            screen.width_cm(),
            screen.height_cm(),
        ));
        let Some(planned) = parse(&self.window_deg).filter(|deg| *deg > 0.0 && *deg < 170.0) else {
            theme::fault(ui, "The planned size is no angle; expected degrees, such as 10.");
            return;
        };
        let wanted = viewing.px_from_deg(planned);
        let least = f64::from(screen.width_px().min(screen.height_px()));
        let share = 100.0 * (least / wanted).min(1.0);
        if wanted <= least {
            ui.label(format!(
                "A stimulus of {planned}° is {wanted:.0} pixels a side: all of it fits, and fills {:.0} % of the screen's height.",
                100.0 * wanted / least
            ));
        } else {
            theme::fault(
                ui,
                &format!(
                    "A stimulus of {planned}° would be {wanted:.0} pixels a side: only {share:.0} % of that fits. {}",
                    farthest(viewing, planned)
                ),
            );
        }
    }

    fn card(&mut self, ctx: &egui::Context, monitor: &Monitor) {
        let Some(card) = &mut self.card else { return };
        match card.show(ctx, monitor.width_px) {
            CardOutcome::Open => return,
            CardOutcome::Closed => {}
            CardOutcome::Measured(width) => self.width_cm = width.to_string(),
        }
        self.card = None;
    }
}

/// From where the planned angle would just fit.
fn farthest(viewing: &Viewing, planned_deg: f64) -> String {
    let screen = viewing.screen();
    let least_cm = screen.width_cm().min(screen.height_cm());
    match Geometry::resolve(Some(planned_deg), Some(least_cm), None) {
        Ok(fits) => format!("It fits from {:.0} cm or less.", fits.distance_cm().floor()),
        Err(_) => String::new(),
    }
}

/// A ruler and the length of a degree, to be held against real ones.
fn rulers(ui: &mut egui::Ui, viewing: &Viewing) {
    let points_per_cm = (viewing.screen().px_per_cm() / f64::from(ui.ctx().pixels_per_point())) as f32;
    ui.add_space(12.0);
    ui.label(theme::quiet("Hold a ruler against the screen. The lower line is one degree, five, and ten."));
    let degrees = [1.0, 5.0, 10.0].map(|deg| viewing.cm_from_deg(deg) as f32 * points_per_cm);
    let width = (RULER_CM as f32 * points_per_cm).max(degrees[2]);
    let (rect, response) =
        ui.allocate_exact_size(Vec2::new((width + 12.0).min(ui.available_width()), 84.0), egui::Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "A ruler of ten centimetres"));
    let painter = ui.painter_at(rect);
    let stroke = Stroke::new(1.0, Color32::from_gray(0xec));
    let tick = |x: f32, y: f32, height: f32, text: String| {
        let foot = rect.min + Vec2::new(x + 0.5, y);
        painter.line_segment([foot, foot - Vec2::new(0.0, height)], stroke);
        if !text.is_empty() {
            let align = if x == 0.0 { egui::Align2::LEFT_TOP } else { egui::Align2::CENTER_TOP };
            painter.text(foot, align, text, egui::FontId::proportional(12.0), theme::QUIET);
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
