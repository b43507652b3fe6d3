//! Shading: one surface, one light, two shaders beside each other.

mod bands;
mod canvas;
mod card;
mod comparison;
mod controls;
mod export;
mod look;
mod metric;
mod painters;
mod presets;
mod render;
mod scan;

use eframe::{
    egui::{self, Key, Rect, RichText, TextureHandle, UiBuilder},
    egui_wgpu::RenderState,
};

use crate::{
    app::{
        Go,
        dialog::{Ask, Dialog},
        theme,
    },
    light::CodeImage,
};
use bands::Bands;
use look::{Hand, Look, Show};
use metric::Metric;
use painters::Painters;
use render::{Difference, Model, Picture, Pictures};
use scan::Scan;

pub use comparison::{Comparison, MeshChoice, Side};

/// Height of the plots below the picture, points.
const PLOTS: f32 = 170.0;
/// A window narrower than this has the view above the controls, so high.
const NARROW: f32 = 640.0;
const NARROW_VIEW: f32 = 560.0;
/// Narrower than this, creases and predicted bands have a table each.
const TWO_TABLES: f32 = 600.0;

/// The page.
pub struct ShadingPage {
    compared: Comparison,
    look: Look,
    preset: &'static str,
    model: Option<Model>,
    painters: Option<Painters>,
    pictures: Option<Pictures>,
    metric: Option<Metric>,
    bands: Bands,
    scan: Option<Scan>,
    difference: Option<Difference>,
    file: FileField,
    export: export::Export,
    dragging: bool,
    /// Turned from outside since the last frame.
    turning: bool,
    /// What the last timing found.
    times: Vec<String>,
}

/// The OBJ file.
#[derive(Default)]
struct FileField {
    path: String,
    dialog: Dialog,
    fault: Option<String>,
}

impl Default for ShadingPage {
    fn default() -> Self {
        Self {
            compared: Comparison::default(),
            look: Look::default(),
            preset: presets::all()[0].name,
            model: None,
            painters: None,
            pictures: None,
            metric: None,
            bands: Bands::default(),
            scan: None,
            difference: None,
            file: FileField::default(),
            export: export::Export::default(),
            dragging: false,
            turning: false,
            times: Vec::new(),
        }
    }
}

impl ShadingPage {
    /// Turns the mesh about the upright axis, as a hand that drags it does.
    pub(in crate::app) fn turn(&mut self, degrees: f64) {
        self.compared.turn(degrees, 0.0);
        self.turning = true;
    }

    /// Draws the page.
    pub(in crate::app) fn show(&mut self, ui: &mut egui::Ui, state: Option<&RenderState>) -> Go {
        let painters = self.painters.take().unwrap_or_else(|| Painters::new(state));
        self.painters = Some(painters);
        let mut back = false;
        // Escape closes an open list first.
        let listing = egui::Popup::is_any_open(ui.ctx());
        let width = (ui.available_width() * 0.36).clamp(272.0, 340.0);
        let frame = egui::Frame::NONE.inner_margin(12.0);
        self.take_files(ui.ctx());
        if ui.available_width() < NARROW {
            egui::CentralPanel::default().frame(frame).show(ui, |ui| {
                egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                    theme::compact(ui);
                    ui.set_max_width(ui.available_width() - 6.0);
                    back = theme::heading(ui, "Shading");
                    let size =
                        egui::vec2(ui.available_width(), NARROW_VIEW + if self.look.scan { PLOTS + 8.0 } else { 0.0 });
                    ui.allocate_ui(size, |ui| {
                        ui.set_min_size(size);
                        self.view(ui);
                    });
                    ui.separator();
                    self.controls(ui);
                });
            });
        } else {
            egui::Panel::left("demo").resizable(false).exact_size(width).frame(frame).show(ui, |ui| {
                egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                    theme::compact(ui);
                    // Room for the scroll bar.
                    ui.set_max_width(ui.available_width() - 6.0);
                    back = theme::heading(ui, "Shading");
                    self.controls(ui);
                });
            });
            egui::CentralPanel::default().frame(frame).show(ui, |ui| {
                theme::compact(ui);
                self.view(ui);
            });
        }
        let typing = ui.ctx().memory(|memory| memory.focused().is_some());
        if back || !typing && !listing && ui.input(|input| input.key_pressed(Key::Escape)) {
            Go::Back
        } else {
            Go::Stay
        }
    }

    fn controls(&mut self, ui: &mut egui::Ui) {
        ui.add(
            egui::Label::new(theme::quiet(
                "The same surface under the same light, shaded in two ways. The bright and dark lines along the edges of the triangles are Mach bands: the eye makes them where the slope of the light jumps.",
            ))
            .wrap(),
        );
        controls::preset(ui, &mut self.compared, &mut self.look, &mut self.preset);
        for which in 0..2 {
            ui.separator();
            controls::side(ui, which, &mut self.compared.sides[which]);
        }
        ui.add(
            egui::Label::new(theme::quiet(
                "A strip only a few pixels wide turns Exact's matched slope into a ripple: widen b, or take Cut or Patch.",
            ))
            .wrap(),
        );
        ui.separator();
        let mut compared = self.compared.clone();
        controls::mesh(ui, &mut compared);
        self.file_field(ui, &mut compared);
        ui.separator();
        controls::light(ui, &mut compared);
        controls::material(ui, &mut compared.scene);
        controls::transfer(ui, &mut compared);
        self.compared = compared;
        if let Some(painters) = &mut self.painters {
            controls::painter(ui, painters);
            if ui.button("Time both sides").clicked()
                && let Some(pictures) = &self.pictures
            {
                self.times = painters.time(&pictures.frame, pictures.compared());
            }
            for time in &self.times {
                ui.add(egui::Label::new(theme::quiet(time)).wrap());
            }
        }
        ui.separator();
        self.take_along(ui);
    }

    fn file_field(&mut self, ui: &mut egui::Ui, compared: &mut Comparison) {
        let label = ui.label("OBJ file");
        let field = egui::TextEdit::singleline(&mut self.file.path)
            .hint_text("path of an .obj, or drop one here")
            .desired_width(ui.available_width());
        let field = ui.add(field).labelled_by(label.id);
        let entered = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
        ui.horizontal(|ui| {
            if ui.button("Open the file").clicked() || entered {
                self.open_file(compared);
            }
            let browse = ui.button("Browse…");
            browse.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, "Choose an OBJ file…"));
            if browse.clicked() {
                self.file.dialog.open(ui.ctx(), Ask::Obj);
            }
        });
        if self.file.dialog.is_missing() {
            theme::fault(ui, "No file dialog opened on this system: type the path, or drop a file on this window.");
        }
        if let Some(fault) = &self.file.fault {
            theme::fault(ui, fault);
        }
    }

    /// A mesh that cannot be read leaves the one before.
    fn open_file(&mut self, compared: &mut Comparison) {
        let choice = MeshChoice::File(self.file.path.trim().to_owned());
        // Before anything is drawn there is no mesh to leave, and nothing to choose.
        let Some(model) = &mut self.model else { return };
        match model.load(&choice) {
            Ok(()) => {
                compared.mesh = choice;
                self.file.fault = None;
            }
            Err(fault) => self.file.fault = Some(fault),
        }
    }

    fn take_files(&mut self, ctx: &egui::Context) {
        let dropped = ctx.input(|input| input.raw.dropped_files.first().map(|file| file.path().to_owned()));
        if let Some(path) = self.file.dialog.take().or(dropped) {
            self.file.path = path.display().to_string();
            let mut compared = self.compared.clone();
            self.open_file(&mut compared);
            self.compared = compared;
        }
    }

    fn view(&mut self, ui: &mut egui::Ui) {
        self.toolbar(ui);
        let titles = self.compared.sides.map(|side| side.title());
        self.titles(ui, &titles);
        let status = if ui.available_width() < TWO_TABLES { 176.0 } else { 104.0 };
        let below = status + if self.look.scan { PLOTS + 8.0 } else { 0.0 };
        let rest = ui.available_rect_before_wrap();
        let room = Rect::from_min_max(rest.min, rest.max - egui::vec2(0.0, below.min(rest.height() * 0.6)));
        let (rect, size) = canvas::whole_pixels(ui.ctx(), room);
        let label = format!("The surface: {} on the left, {} on the right", titles[0], titles[1]);
        let dragged = canvas::interact(ui, rect, &mut self.compared, &mut self.look, &label);
        self.dragging = dragged || std::mem::take(&mut self.turning);
        self.refresh(ui.ctx(), size);
        self.draw(ui, rect, size);
        canvas::draw_marks(ui, rect, &self.compared, &self.look);
        let mut lower = ui.new_child(
            UiBuilder::new().max_rect(Rect::from_min_max(egui::pos2(rest.left(), rect.bottom() + 6.0), rest.max)),
        );
        self.numbers(&mut lower);
        if self.look.scan
            && let Some(scan) = &self.scan
        {
            scan.show(&mut lower, &titles);
        }
    }

    fn toolbar(&mut self, ui: &mut egui::Ui) {
        // Where rows break anywhere, lines between groups would stand alone.
        let lines = ui.available_width() >= TWO_TABLES;
        ui.horizontal_wrapped(|ui| {
            word(ui, "Show");
            for (show, name) in [
                (Show::Split, "Split"),
                (Show::Difference, "Difference"),
                (Show::Creases, "Creases"),
                (Show::Bands, "Predicted bands"),
            ] {
                ui.selectable_value(&mut self.look.show, show, name);
            }
            if lines {
                ui.separator();
            }
            word(ui, "Drag moves");
            for (hand, name) in [(Hand::Mesh, "the mesh"), (Hand::Light, "the light"), (Hand::Line, "a scan line")] {
                if ui.selectable_value(&mut self.look.hand, hand, name).clicked() && hand == Hand::Line {
                    self.look.scan = true;
                }
            }
            if lines {
                ui.separator();
            }
            if ui.checkbox(&mut self.look.scan, "Scan line").changed() && !self.look.scan {
                self.look.hand = if self.look.hand == Hand::Line { Hand::Mesh } else { self.look.hand };
            }
        });
    }

    /// The shaders' names over their halves.
    fn titles(&mut self, ui: &mut egui::Ui, titles: &[String; 2]) {
        let text = |i: usize| egui::RichText::new(&titles[i]).strong().color(canvas::COLORS[i]);
        ui.horizontal(|ui| {
            ui.set_min_height(ui.spacing().interact_size.y);
            if self.look.show == Show::Difference {
                ui.label(text(0));
                ui.label("minus");
                ui.label(text(1));
                let label = ui.label("in codes, amplified ×");
                controls::factor(ui, &mut self.look.factor, label.id);
                return;
            }
            let half =
                egui::vec2((ui.available_width() - ui.spacing().item_spacing.x) / 2.0, ui.spacing().interact_size.y);
            let sides = [egui::Layout::left_to_right, egui::Layout::right_to_left];
            let seen = [self.look.divider > 0.0, self.look.divider < 1.0];
            for (i, layout) in sides.into_iter().enumerate() {
                ui.allocate_ui_with_layout(half, layout(egui::Align::Center), |ui| {
                    ui.set_min_width(half.x);
                    if seen[i] {
                        ui.add(egui::Label::new(text(i)).truncate());
                    }
                });
            }
        });
    }

    /// Computes what has changed.
    fn refresh(&mut self, ctx: &egui::Context, size: [u32; 2]) {
        let followed = match &mut self.model {
            Some(model) => model.follow(&self.compared.mesh),
            None => Model::new(&self.compared.mesh).map(|model| self.model = Some(model)),
        };
        if let Err(fault) = followed {
            self.file.fault = Some(fault);
        }
        let (Some(model), Some(painters)) = (&self.model, &mut self.painters) else { return };
        let pictures = Pictures::refreshed(ctx, self.pictures.take(), painters, model, &self.compared, size);
        if !self.dragging || self.metric.is_none() {
            self.metric = Some(Metric::refreshed(self.metric.take(), &pictures));
        }
        if !self.dragging {
            self.bands.want(ctx, &pictures, model.surface());
        }
        if self.look.scan {
            self.scan = Some(Scan::refreshed(self.scan.take(), &pictures, &self.look));
        }
        self.pictures = Some(pictures);
    }

    fn draw(&mut self, ui: &egui::Ui, rect: Rect, size: [u32; 2]) {
        let Some(pictures) = &self.pictures else { return };
        let textures = match self.look.show {
            Show::Split => pictures.sides.each_ref().map(Picture::id),
            Show::Difference => {
                self.difference = Difference::refreshed(ui.ctx(), self.difference.take(), pictures, self.look.factor);
                let Some(difference) = &self.difference else { return };
                [difference.texture.id(); 2]
            }
            Show::Creases => match &mut self.metric {
                Some(metric) => metric.pictures(ui.ctx(), &pictures.frame).each_ref().map(|(_, texture)| texture.id()),
                None => return,
            },
            Show::Bands => match self.bands.textures(ui.ctx(), pictures.edition) {
                Some(textures) => textures.each_ref().map(TextureHandle::id),
                // The pictures themselves, until the maps are there.
                None => pictures.sides.each_ref().map(Picture::id),
            },
        };
        canvas::draw(ui, rect, textures, size, &self.look);
        if self.look.show == Show::Bands
            && let Some(lack) = self.bands.lack(pictures.edition)
        {
            canvas::draw_note(ui, rect, &lack);
        }
    }

    /// Creases, predicted bands and times.
    fn numbers(&self, ui: &mut egui::Ui) {
        let Some(pictures) = &self.pictures else { return };
        if ui.available_width() < TWO_TABLES {
            self.table(ui, pictures, [true, false]);
            self.table(ui, pictures, [false, true]);
        } else {
            self.table(ui, pictures, [true; 2]);
        }
        let [left, right] = [0, 1].map(|i| pictures.sides[i].ms);
        let triangles = pictures.frame.triangles.len();
        let by = self.painters.as_ref().map_or_else(String::new, Painters::sentence);
        let degrees = bands::SHORTER_SIDE_DEG;
        for text in [
            format!(
                "A visibility of 1 is just seen; the picture's shorter side is taken to be {degrees}° of the eye's field."
            ),
            format!(
                "{by} {triangles} triangles seen. Vertices {:.1} ms, left {left:.1} ms, right {right:.1} ms.",
                pictures.frame_ms
            ),
        ] {
            ui.add(egui::Label::new(theme::quiet(text)).wrap());
        }
    }

    /// A row for each side, with its creases and its predicted bands where they are wanted.
    fn table(&self, ui: &mut egui::Ui, pictures: &Pictures, [creases, bands]: [bool; 2]) {
        let heads = [("creases, light per pixel", creases), ("rms", creases), ("p95", creases), ("× Gouraud", creases)];
        let seen = [("", bands && !creases), ("predicted visibility", bands), ("× Gouraud", bands)];
        let heads: Vec<&str> =
            heads.into_iter().chain(seen).filter(|(_, wanted)| *wanted).map(|(head, _)| head).collect();
        // What the numbers leave of the width.
        let longest = (ui.available_width() - if creases && bands { 440.0 } else { 240.0 }).max(150.0);
        ui.spacing_mut().interact_size.y = 14.0;
        egui::Grid::new(("numbers", creases, bands)).num_columns(heads.len()).spacing([12.0, 2.0]).show(ui, |ui| {
            for head in heads {
                ui.label(theme::quiet(head));
            }
            ui.end_row();
            for (which, side) in pictures.compared().sides.iter().enumerate() {
                ui.scope(|ui| {
                    ui.set_max_width(longest);
                    let title = RichText::new(side.title()).small().color(canvas::COLORS[which]);
                    ui.add(egui::Label::new(title).truncate());
                });
                if let Some(metric) = self.metric.as_ref().filter(|_| creases) {
                    metric.cells(ui, which, self.dragging);
                }
                if bands {
                    self.bands.cells(ui, which, pictures.edition);
                }
                ui.end_row();
            }
        });
    }

    /// The pixels of the view as they are on the screen, marks aside.
    fn pixels(&self) -> Option<CodeImage> {
        let pictures = self.pictures.as_ref()?;
        let split = |left: &CodeImage, right: &CodeImage| render::split(left, right, self.look.column(left.width));
        Some(match self.look.show {
            Show::Split => split(&pictures.sides[0].codes()?, &pictures.sides[1].codes()?),
            Show::Difference => self.difference.as_ref()?.codes.clone(),
            Show::Creases => {
                let [left, right] = self.metric.as_ref()?.drawn()?;
                split(&left.0, &right.0)
            }
            Show::Bands => {
                let [left, right] = self.bands.codes(pictures.edition)?;
                split(left, right)
            }
        })
    }

    fn take_along(&mut self, ui: &mut egui::Ui) {
        let mut export = std::mem::take(&mut self.export);
        if let Some(pictures) = &self.pictures {
            let compared = pictures.compared();
            let by = self.painters.as_ref().map_or_else(String::new, Painters::drawn_by);
            export.show(ui, compared, &self.look, || {
                let image = self.pixels()?;
                let most = self.bands.seen(pictures.edition).map(|seen| seen.most);
                let parameters = export::parameters(compared, &self.look, [image.width, image.height], &by, most);
                Some((image, parameters))
            });
        }
        self.export = export;
    }
}

/// A word before its controls, in one piece.
fn word(ui: &mut egui::Ui, text: &str) {
    ui.add(egui::Label::new(theme::quiet(text)).extend());
}
