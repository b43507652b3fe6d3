//! The studies to choose from: one row each, with a picture of its stimulus.

use std::path::Path;

use eframe::egui::{
    self, Button, Color32, Rect, Response, ScrollArea, TextFormat, TextStyle, Ui, Vec2, text::LayoutJob,
};

use crate::{
    app::ui::{
        self,
        fonts::TextFonts,
        page::filled_with,
        pixels::{self, Drawn},
        theme::{GAP, LARGE_GAP, SMALL_GAP, ink},
    },
    experiment::Protocol,
    report::document::numbers::count,
    store::definition::{self, BUILT_IN},
};

/// Side of a picture, points.
const PICTURE: f32 = 40.0;

/// The rows, in the order in which they are shown.
#[derive(Default)]
pub struct StudyList {
    /// The files that have a row, before the built-in definitions.
    files: Vec<String>,
    rows: Vec<Row>,
    /// The study that was chosen when the list was last drawn.
    shown: String,
    /// The fonts for the titles.
    fonts: TextFonts,
}

struct Row {
    /// Name of a built-in definition, or path of a file.
    experiment: String,
    /// The definition, or the number of errors in it.
    protocol: Result<Protocol, usize>,
    picture: Drawn<u32>,
}

impl StudyList {
    /// Reads the definitions if these are not the files that have a row.
    pub fn update(&mut self, ctx: &egui::Context, files: &[String]) {
        if self.files != files || self.rows.is_empty() {
            self.read(files);
        }
        self.fonts.find(ctx, self.rows.iter().filter_map(|row| Some(&*row.protocol.as_ref().ok()?.title)));
    }

    /// Reads the built-in definitions and these files again, because they may have changed. Pictures of definitions
    /// that have not changed stay.
    pub fn read(&mut self, files: &[String]) {
        let mut before = std::mem::take(&mut self.rows);
        self.files = files.to_vec();
        let names = files.iter().map(String::as_str).chain(BUILT_IN.iter().map(|built_in| built_in.name));
        for experiment in names {
            let protocol = definition::open(experiment).map_err(|errors| errors.0.len());
            let known = before.iter().position(|row| row.experiment == experiment && row.protocol == protocol);
            self.rows.push(match known {
                Some(index) => before.swap_remove(index),
                None => Row { experiment: experiment.to_owned(), protocol, picture: Drawn::default() },
            });
        }
    }

    /// Draws the list; returns the study that was clicked. `about` says how many people took part in the study with a
    /// name.
    pub fn show(&mut self, ui: &mut Ui, chosen: &str, about: impl Fn(&str) -> String) -> Option<String> {
        let mut clicked = None;
        ScrollArea::vertical().id_salt("studies").auto_shrink([false, true]).show(ui, |ui| {
            ui.spacing_mut().item_spacing.y = SMALL_GAP;
            ui.spacing_mut().button_padding = Vec2::new(GAP, 6.0);
            for index in 0..self.rows.len() {
                if index == self.files.len() {
                    ui.add_space(if index > 0 { LARGE_GAP } else { 0.0 });
                    ui.horizontal(|ui| {
                        ui.add_space(GAP);
                        ui::hint(ui, "Built in. Run one, or copy it to make it yours.");
                    });
                }
                let row = &mut self.rows[index];
                let response = row.show(ui, row.experiment == chosen, &about);
                if row.experiment == chosen && self.shown != chosen {
                    chosen.clone_into(&mut self.shown);
                    response.scroll_to_me(None);
                }
                if response.clicked() {
                    clicked = Some(row.experiment.clone());
                }
            }
        });
        clicked
    }
}

impl Row {
    /// Returns the title and one line about the study.
    fn texts(&self, about: impl Fn(&str) -> String) -> (String, String) {
        let built_in = BUILT_IN.iter().any(|built_in| built_in.name == self.experiment);
        let name = Path::new(&self.experiment).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        match &self.protocol {
            Ok(protocol) => {
                let took_part = about(&protocol.name);
                let more = match (took_part.is_empty(), built_in) {
                    (false, _) => took_part,
                    (true, true) => format!("{} min", protocol.minutes()),
                    (true, false) => "no sessions yet".to_owned(),
                };
                (protocol.title.clone(), format!("{name} · {more}"))
            }
            // The page of the study lists them.
            Err(errors) => (format!("{name}.toml"), count(*errors as u64, "error")),
        }
    }

    fn show(&mut self, ui: &mut Ui, chosen: bool, about: impl Fn(&str) -> String) -> Response {
        let (title, line) = self.texts(about);
        let ink = ink(ui);
        let title_color = if chosen { ink.ink } else { ink.text };
        let line_color = if self.protocol.is_err() { ink.bad } else { ink.dim };
        let mut text = LayoutJob::default();
        for (said, style, color) in
            [(format!("{title}\n"), TextStyle::Body, title_color), (line.clone(), TextStyle::Small, line_color)]
        {
            text.append(&said, 0.0, TextFormat::simple(style.resolve(ui.style()), color));
        }
        let place = egui::IdSalt::new("picture");
        let picture = egui::Atom::custom(place, Vec2::splat(PICTURE));
        let fill = if chosen { ink.raised } else { Color32::TRANSPARENT };
        let button = filled_with(Button::new((picture, text, egui::Atom::grow())), fill);
        let shown = button.wrap().gap(GAP).min_size(Vec2::new(ui.available_width(), 0.0)).atom_ui(ui);
        if let Some(rect) = shown.rect(place) {
            self.draw_picture(ui, rect);
        }
        let label = format!("{title}: {line}");
        shown.response.widget_info(|| egui::WidgetInfo::selected(egui::Role::RadioButton, true, chosen, &label));
        shown.response.on_hover_text(&self.experiment)
    }

    fn draw_picture(&mut self, ui: &Ui, rect: Rect) {
        let Ok(protocol) = &self.protocol else { return };
        let px = (rect.width() * ui.ctx().pixels_per_point()).floor().max(1.0) as u32;
        let middle = || {
            let conditions = protocol.conditions();
            let middle = conditions.get(conditions.len() / 2);
            vec![middle.map_or(&protocol.stimulus, |middle| &middle.stimulus).clone()]
        };
        if let Some((_, drawn)) = self.picture.get(ui.ctx(), px, px, middle) {
            drawn.iter().for_each(|texture| pixels::draw_centered(ui, texture, rect));
        }
    }
}
