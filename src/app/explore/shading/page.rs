//! The page: lays out the controls and the view, and updates them.

use std::sync::Arc;

use eframe::egui::{self, Key, Label, Pos2, Rect, RichText, UiBuilder};

use super::{
    canvas::{self, ViewSettings},
    comparison::{Comparison, MeshChoice, title},
    controls,
    pictures::{Measured, Picture, Pictures, Scan, Wanted, divided, visible},
};
use crate::{
    app::ui::{
        Bench, Field, FileKind, History, Saving, browse, escaped, hint, say, secondary, text,
        theme::{self, BODY, SECTION, ink},
        work::{Kept, Latest},
    },
    display::DisplayProfile,
    report::document::numbers::whole,
    shading::{Surface, crease},
    stimulus::ViewingConditions,
    store,
};

/// Height of the plots below the picture, points.
const PLOTS: f32 = 190.0;
/// Height of the view in one column, points.
const NARROW_VIEW: f32 = 560.0;
/// Height of the line below the picture, points.
const NOTE: f32 = 26.0;
/// Width of the controls of the zoom, points.
const ZOOM: f32 = 160.0;
/// Height of the first sentence, points: two lines.
const LEAD: f32 = 46.0;

/// The shading demo: two renderers side by side.
#[derive(Default)]
pub struct ShadingPage {
    compared: Comparison,
    display: DisplayProfile,
    /// The earlier comparisons.
    history: History<Comparison>,
    settings: ViewSettings,
    /// The last valid mesh and its surface.
    surface: Option<(MeshChoice, Arc<Surface>)>,
    /// The number of meshes that were loaded.
    loaded: usize,
    pictures: Option<Pictures>,
    /// How visible the differences from the smooth surface are.
    visible: Latest<Wanted, Measured>,
    scan: Kept<(Wanted, [Pos2; 2]), Scan>,
    file: FileField,
    saving: Saving,
    dragging: bool,
}

/// The field for the path of a mesh.
#[derive(Default)]
struct FileField {
    path: String,
    error: Option<String>,
}

impl ShadingPage {
    /// Draws the page; returns whether the user left it.
    pub fn show(&mut self, ui: &mut egui::Ui, display: &DisplayProfile) -> bool {
        self.display.clone_from(display);
        let escaped = escaped(ui);
        let width = (ui.available_width() * 0.36).clamp(272.0, 340.0);
        let (controls, export, view) = (Self::controls, Self::export, Self::sized_view);
        let back = Bench { name: "Shading", width, controls, export, view }.show(ui, self);
        self.history.record(ui, &self.compared);
        back || escaped
    }

    /// Draws the view; in one column, it has a height of its own.
    fn sized_view(&mut self, ui: &mut egui::Ui, is_narrow: bool) {
        if !is_narrow {
            return self.view(ui);
        }
        let plots = if self.settings.scan { PLOTS + 8.0 } else { 0.0 };
        let size = egui::vec2(ui.available_width(), NARROW_VIEW + plots);
        ui.allocate_ui(size, |ui| {
            ui.set_min_size(size);
            self.view(ui);
        });
    }

    fn controls(&mut self, ui: &mut egui::Ui) {
        hint(
            ui,
            "The same surface under the same light, shaded in two ways. The bright and dark lines along the edges of \
                the triangles are Mach bands: the visual system produces them where the slope of the luminance changes \
                abruptly.",
        );
        let mesh = self.compared.mesh.clone();
        self.history.show(ui, &mut self.compared, Comparison::default());
        if self.compared.mesh != mesh {
            // The field has the mesh that came back.
            let file = self.compared.mesh.shape().is_none().then(|| self.compared.mesh.name.display().to_string());
            self.file = FileField { path: file.unwrap_or_default(), ..FileField::default() };
        }
        for (which, side) in self.compared.sides.iter_mut().enumerate() {
            ui.separator();
            controls::side(ui, which, side);
        }
        ui.separator();
        controls::mesh(ui, &mut self.compared);
        self.file_field(ui);
        ui.separator();
        controls::light(ui, &mut self.compared);
        controls::material(ui, &mut self.compared.scene);
    }

    fn file_field(&mut self, ui: &mut egui::Ui) {
        let field = Field::new("Mesh file").hint("OBJ, PLY, glTF or GLB").width(ui.available_width());
        let field = field.text(ui, &mut self.file.path);
        if field.changed() {
            self.file.error = None;
        }
        let mut open = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
        ui.horizontal_wrapped(|ui| {
            open |= ui.button("Open the file").clicked();
            open |= browse(ui, FileKind::Mesh, "Choose a mesh…", &mut self.file.path);
        });
        if let Some(path) = ui.input(|input| input.raw.dropped_files.first().map(|file| file.path().to_owned())) {
            self.file.path = path.display().to_string();
            open = true;
        }
        if open {
            let name = self.file.path.trim().into();
            self.load(ui.ctx(), MeshChoice { name, ..self.compared.mesh });
        }
        // The error has the same room before there is one.
        text::two_lines(ui, self.file.error.as_deref().unwrap_or_default(), ink(ui).bad, 2);
    }

    /// Shows another mesh. If it cannot be created, the current mesh stays.
    fn load(&mut self, ctx: &egui::Context, choice: MeshChoice) {
        self.file.error = match choice.mesh() {
            Ok(file) => {
                if let Some(note) = file.note(&choice.name) {
                    say(ctx, note);
                }
                self.compared.mesh = choice.clone();
                self.loaded += 1;
                self.surface = Some((choice, Arc::new(Surface::new(file.mesh))));
                None
            }
            Err(error) => {
                if let Some((valid, _)) = &self.surface {
                    self.compared.mesh.clone_from(valid);
                }
                Some(error.to_string())
            }
        };
    }

    fn view(&mut self, ui: &mut egui::Ui) {
        self.lead(ui);
        self.toolbar(ui);
        self.explain(ui);
        let titles = self.compared.sides.each_ref().map(title);
        self.titles(ui, &titles);
        let below = NOTE + if self.settings.scan { PLOTS + 8.0 } else { 0.0 };
        let rest = ui.available_rect_before_wrap();
        let room = Rect::from_min_max(rest.min, rest.max - egui::vec2(0.0, below.min(rest.height() * 0.6)));
        let (rect, size) = canvas::whole_pixels(ui.ctx(), room);
        let label = format!("Surface: {} on the left, {} on the right", titles[0], titles[1]);
        self.dragging = canvas::interact(ui, rect, &mut self.compared, &mut self.settings, &label);
        self.update(ui.ctx(), size);
        self.draw(ui, rect);
        canvas::draw_marks(ui, rect, &self.settings);
        let lower = Rect::from_min_max(egui::pos2(rest.left(), rect.bottom() + 6.0), rest.max);
        let mut lower = ui.new_child(UiBuilder::new().max_rect(lower));
        if let Some(pictures) = &self.pictures {
            let triangles = whole(pictures.frame.triangles.len() as u64);
            let side = ViewingConditions::WINDOW_DEG;
            hint(
                &mut lower,
                format!("Predicted for a shorter side of {side}°. {triangles} triangles face the viewer."),
            );
        }
        if let Some(scan) = self.scan.last().filter(|_| self.settings.scan) {
            scan.show(&mut lower, &titles);
        }
    }

    /// Says first what the comparison shows. The sentence has the same room before it is known.
    fn lead(&self, ui: &mut egui::Ui) {
        let text = self.pictures.as_ref().map_or_else(String::new, |_| self.sentence());
        let (rect, _) = ui.allocate_exact_size(egui::vec2(ui.available_width(), LEAD), egui::Sense::hover());
        // Its size never changes that of the picture, for which it would have to be computed again.
        let size = if rect.width() < theme::COLUMN { BODY } else { SECTION };
        let mut room = ui.new_child(UiBuilder::new().max_rect(rect));
        room.set_clip_rect(rect);
        room.add(Label::new(RichText::new(text).strong().size(size)).wrap());
    }

    fn toolbar(&mut self, ui: &mut egui::Ui) {
        let settings = &mut self.settings;
        let group = |ui: &mut egui::Ui, text: &str| ui.add(Label::new(secondary(text)).extend());
        ui.horizontal_wrapped(|ui| {
            ui.checkbox(&mut settings.maps, "Visibility");
            ui.checkbox(&mut settings.scan, "Scan line");
            // What belongs to the zoom stays on one line.
            if ui.available_size_before_wrap().x < ZOOM {
                ui.end_row();
                // The label is in the middle of a line that is as high as its buttons.
                ui.allocate_exact_size(egui::vec2(0.0, ui.spacing().interact_size.y), egui::Sense::hover());
                ui.add_space(-ui.spacing().item_spacing.x);
            }
            group(ui, "Zoom");
            let step = |ui: &mut egui::Ui, text: &str, name: &str, to: Option<f32>| {
                let button = ui.add_enabled(to.is_some(), egui::Button::new(text));
                text::name(ui, &button, name);
                to.filter(|_| button.on_hover_text(name).clicked())
            };
            let less = step(ui, "−", "Zoom out", settings.next_zoom(false));
            ui.add(Label::new(format!("{:.0} %", settings.zoom * 100.0)).extend());
            let more = step(ui, "+", "Zoom in", settings.next_zoom(true));
            settings.zoom = less.or(more).unwrap_or(settings.zoom);
        });
    }

    /// Says what the colors of the maps mean or, above the images themselves, what dragging does. The line has the same
    /// height for both, so that the picture keeps its size.
    fn explain(&self, ui: &mut egui::Ui) {
        let drag = if self.settings.scan {
            "Drag across the picture to draw the scan line; the arrow keys move it."
        } else {
            "Drag or press the arrow keys to rotate the mesh. The right button moves the light, the middle button the \
                enlarged picture; the wheel zooms."
        };
        ui.horizontal(|ui| {
            ui.set_min_height(2.0 * ui.text_style_height(&egui::TextStyle::Small));
            if !self.settings.maps {
                return text::two_lines(ui, drag, ink(ui).dim, 2);
            }
            let most = self.measured().map_or_else(|_| String::new(), |known| format!("{:.1} ", known.full_scale));
            canvas::key(ui, "as the smooth surface", crease::color, &format!("{most}times the threshold"));
        });
    }

    /// Draws the names of the renderers above their halves.
    fn titles(&mut self, ui: &mut egui::Ui, titles: &[String; 2]) {
        let sides = ink(ui).sides();
        let text = |i: usize| RichText::new(&titles[i]).strong().color(sides[i]);
        let height = ui.spacing().interact_size.y;
        ui.horizontal(|ui| {
            ui.set_min_height(height);
            let layouts = [egui::Layout::left_to_right, egui::Layout::right_to_left];
            let is_shown = [self.settings.divider > 0.0, self.settings.divider < 1.0];
            ui.columns(2, |columns| {
                for i in (0..2).filter(|i| is_shown[*i]) {
                    let label = Label::new(text(i)).truncate();
                    columns[i].with_layout(layouts[i](egui::Align::Center), |ui| ui.add(label));
                }
            });
        });
    }

    /// Redraws and measures again whatever has changed.
    fn update(&mut self, ctx: &egui::Context, size: [u32; 2]) {
        if self.surface.as_ref().is_none_or(|(choice, _)| *choice != self.compared.mesh) {
            self.load(ctx, self.compared.mesh.clone());
        }
        let Some((_, surface)) = &self.surface else { return };
        // What turns with the pointer is drawn with a quarter of the pixels, so that it keeps up.
        let size = match &self.pictures {
            Some(drawn) if self.dragging && !self.settings.scan => {
                let is_turned = drawn.wanted.compared != self.compared;
                if is_turned { size.map(|side| side.div_ceil(2)) } else { drawn.wanted.size }
            }
            _ => size,
        };
        let (compared, transfers) = (self.compared.clone(), self.display.transfers.clone());
        let wanted = Wanted { compared, loaded: self.loaded, transfers, size };
        let drawn = self.pictures.take().filter(|drawn| drawn.wanted == wanted);
        let pictures = drawn.unwrap_or_else(|| Pictures::new(ctx, surface, wanted.clone()));
        if !self.dragging {
            self.visible.want(ctx, wanted.clone(), || {
                let (ctx, surface, wanted) = (ctx.clone(), surface.clone(), wanted.clone());
                move || visible(&ctx, &surface, &wanted)
            });
        }
        if self.settings.scan {
            let line = self.settings.line;
            self.scan.get((wanted, line), || Scan::new(&pictures, line));
        }
        self.pictures = Some(pictures);
    }

    /// Returns how visible the differences are, or why that is not known.
    fn measured(&self) -> Result<&Measured, String> {
        match self.pictures.as_ref().and_then(|pictures| self.visible.get(&pictures.wanted)) {
            None => Err("computing…".to_owned()),
            Some(Err(error)) => Err(format!("not available: {error}.")),
            Some(Ok(measured)) => Ok(measured),
        }
    }

    /// Returns the maps if they are shown. Until they are ready, the images themselves are shown.
    fn maps(&self) -> Option<&Measured> {
        self.measured().ok().filter(|_| self.settings.maps)
    }

    fn shown<'a>(&'a self, pictures: &'a Pictures) -> &'a [Picture; 2] {
        self.maps().map_or(&pictures.sides, |measured| &measured.maps)
    }

    fn draw(&self, ui: &egui::Ui, rect: Rect) {
        let Some(pictures) = &self.pictures else { return };
        let textures = self.shown(pictures).each_ref().map(Picture::id);
        canvas::draw(ui, rect, textures, pictures.wanted.size, &self.settings);
    }

    /// Says how visible the differences from the smooth surface are.
    fn sentence(&self) -> String {
        let visible = match self.measured() {
            Ok(measured) => measured,
            Err(status) => return format!("Difference from the smooth surface: {status}"),
        };
        let ([a, b], [left, right]) = (self.compared.sides.each_ref().map(title), visible.largest);
        format!("{a} differs from the smooth surface by {left:.1} times what people can just see; {b} by {right:.1}.")
    }

    /// Draws the controls that save the view as PNG.
    fn export(&mut self, ui: &mut egui::Ui) {
        let Some(pictures) = &self.pictures else { return };
        let mut saving = std::mem::take(&mut self.saving);
        if saving.typed.is_empty() {
            saving = Saving::to("shading.png");
        }
        saving.field(ui, Field::new("Export to").width(ui.available_width()));
        saving.export(ui, "Export", &["png"], |writer, path, _| {
            // As on the screen, but without overlays.
            let sides = self.shown(pictures).each_ref().map(|side| &side.codes);
            let image = divided(sides, self.settings.column(sides[0].width));
            store::image::write_codes(writer, path, &image, &pictures.wanted.transfers, None)
        });
        saving.show(ui);
        self.saving = saving;
    }
}
