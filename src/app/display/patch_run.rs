//! Shows the patches one at a time, with a line for typing the photometer reading.

use std::path::{Path, PathBuf};

use eframe::egui::{
    self, Color32, Key, Rect, RichText, TextEdit, UiBuilder, Vec2,
    emath::GuiRounding as _,
    text::{CCursor, CCursorRange},
};

use crate::{
    app::{
        display::calibrate::{Findings, Run},
        ui::{Monitor, Step, describe, number, paragraph, theme::ink},
    },
    display::photometer::{Patch, is_same_level},
    report::names::capitalized,
    store::{StoreError, Writer, readings},
    system::found,
};

/// Height of the line at the bottom, where readings are typed, in points.
const LINE: f32 = 96.0;
/// Color of the text on the line: dim, so that it does not affect the photometer.
const DIM: Color32 = Color32::from_gray(0x70);
/// A reading below this fraction of the reading at a lower level indicates a typing error rather than noise.
const MIN_PLAUSIBLE_RATIO: f64 = 0.95;

/// A run of patches and their readings.
pub struct PatchRun {
    patches: Vec<Patch>,
    readings: Vec<Option<f64>>,
    /// The index of the patch on the screen; the number of patches once all are read.
    at: usize,
    path: PathBuf,
    /// Settling time in seconds; earlier readings are rejected.
    settle_s: f64,
    /// Heights of the patches in percent of the screen's height, which repeat.
    percents: Vec<u32>,
    /// The color around the patch.
    around: Color32,
    entry: String,
    /// Whether the line should take keyboard focus with its text selected, so that typing replaces it.
    select: bool,
    /// The window's time at which the displayed patch appeared, seconds.
    since: Option<f64>,
    message: Option<String>,
    /// An implausible reading that the user must confirm by entering it again.
    unconfirmed: Option<f64>,
}

impl PatchRun {
    /// Begins a run, or resumes one from its file.
    ///
    /// # Errors
    /// If the file belongs to other settings or cannot be written.
    pub fn begin(
        patches: Vec<Patch>,
        path: &Path,
        settle_s: f64,
        percents: Vec<u32>,
        around: Color32,
    ) -> Result<Box<dyn Run>, String> {
        let mut readings = vec![None; patches.len()];
        let is_known = found(path).map_err(|error| format!("{}: {error}", path.display()))?.is_some();
        if is_known {
            for one in readings::open_incomplete(path).map_err(|errors| errors.to_string())? {
                let same =
                    |patch: &Patch| patch.channel == one.channel && is_same_level(patch.reading(0.0).level, one.level);
                let free = (0..readings.len()).find(|at| readings[*at].is_none() && same(&patches[*at]));
                let Some(free) = free else {
                    return Err(format!(
                        "{}: has a reading of {} at level {} that these settings do not include; expected another file, or \
                            the original settings",
                        path.display(),
                        one.channel,
                        one.level
                    ));
                };
                readings[free] = Some(one.luminance_cd_m2);
            }
        }
        let run = Self {
            patches,
            at: first_unread(&readings),
            readings,
            path: path.to_owned(),
            settle_s,
            percents,
            around,
            entry: String::new(),
            select: true,
            since: None,
            message: None,
            unconfirmed: None,
        };
        // The file is written before the first reading, so that an unwritable file is reported now. A complete one stays
        // as it is.
        if run.at < run.patches.len() {
            run.write(is_known).map_err(|error| error.to_string())?;
        }
        Ok(Box::new(run))
    }

    fn write(&self, replaces: bool) -> Result<(), StoreError> {
        let patches = self.patches.iter().zip(&self.readings);
        let read = patches.filter_map(|(patch, value)| Some(patch.reading((*value)?)));
        readings::write(&Writer::new([], replaces), &self.path, &read.collect::<Vec<_>>())
    }

    fn line(&mut self, ui: &mut egui::Ui, at: usize, remaining_s: f64) -> Step<Option<Findings>> {
        ui.visuals_mut().override_text_color = Some(DIM);
        let patch = self.patches[at];
        let mut accept = false;
        let mut previous = false;
        let mut pause = ui.input(|input| input.key_pressed(Key::Escape));
        ui.horizontal_wrapped(|ui| {
            let label = ui.label(format!("{} {} · cd/m²", patch.channel, patch.code));
            let empty = self.entry.is_empty();
            if std::mem::take(&mut self.select) {
                select_all(ui.ctx(), &self.entry);
            }
            let field = TextEdit::singleline(&mut self.entry).id(field_id()).desired_width(110.0);
            let field = ui.add(field).labelled_by(label.id);
            accept = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
            previous = empty && field.has_focus() && ui.input(|input| input.key_pressed(Key::Backspace));
            // The line takes keyboard focus, because there is nothing else to type into.
            if ui.memory(|memory| memory.focused().is_none()) {
                field.request_focus();
            }
            accept |= ui.button("Next").clicked();
            previous |= ui.add_enabled(at > 0, egui::Button::new("Previous")).clicked();
            pause |= ui.button("Pause").clicked();
            let (done, all) = (self.readings.iter().flatten().count(), self.readings.len());
            let settling = if remaining_s > 0.0 { format!(" · settling, {remaining_s:.1} s") } else { String::new() };
            ui.label(format!("{done} of {all} read{settling} · Enter: next · Backspace: previous · Esc: pause"));
        });
        if let Some(message) = &self.message {
            paragraph(ui, RichText::new(message).small().color(ink(ui).warn.gamma_multiply(0.7)));
        }
        if accept {
            self.select = true;
            self.message = self.accept(at, remaining_s).err();
        } else if previous && at > 0 {
            self.show_patch(at - 1);
        }
        match () {
            () if pause => Step::Back,
            () if self.at == self.patches.len() => Step::Next(None),
            () => Step::Stay,
        }
    }

    /// Accepts the typed text as the reading of a patch, in memory and on disk, or says why not.
    fn accept(&mut self, at: usize, remaining_s: f64) -> Result<(), String> {
        let wrong = || format!("{:?} is not a luminance; expected cd/m², 0 or more, such as 12.3", self.entry.trim());
        let value = number(&self.entry).ok_or_else(wrong)?;
        self.patches[at].reading(value).check().map_err(|(_, message)| capitalized(&message))?;
        if remaining_s > 0.0 {
            return Err("The patch has not settled yet. Read it again, then press Enter.".to_owned());
        }
        if let Some(warning) = self.implausible(at, value).filter(|_| self.unconfirmed != Some(value)) {
            self.unconfirmed = Some(value);
            return Err(warning);
        }
        let before = self.readings[at].replace(value);
        if let Err(error) = self.write(true) {
            // The typed text stays in the line, so that the user can try again.
            self.readings[at] = before;
            return Err(error.to_string());
        }
        self.show_patch(first_unread(&self.readings));
        Ok(())
    }

    /// Shows a patch. The line is empty, or contains the patch's previous reading.
    fn show_patch(&mut self, at: usize) {
        let before = self.readings.get(at).copied().flatten();
        self.entry = before.map_or_else(String::new, |value| value.to_string());
        (self.at, self.select) = (at, true);
        (self.since, self.message, self.unconfirmed) = (None, None, None);
    }

    /// Returns the reason why a reading may be a typing error: it is below the reading of a lower level or above that
    /// of a higher level.
    fn implausible(&self, at: usize, value: f64) -> Option<String> {
        let patch = self.patches[at];
        let others = self.patches.iter().zip(&self.readings).enumerate();
        let known = others.filter(|(index, (other, _))| *index != at && other.channel == patch.channel);
        let mut known = known.filter_map(|(_, (other, reading))| Some((other, (*reading)?)));
        let (other, read) = known.find(|(other, read)| {
            other.code < patch.code && value < read * MIN_PLAUSIBLE_RATIO
                || other.code > patch.code && *read < value * MIN_PLAUSIBLE_RATIO
        })?;
        Some(format!(
            "{value} does not fit {} {}, which gave {read}: luminance must rise with the code. To keep it, press Enter \
                again. To go back one patch, clear the line and press Backspace.",
            other.channel, other.code
        ))
    }
}

impl Run for PatchRun {
    fn show(&mut self, ui: &mut egui::Ui, _: &Monitor) -> Step<Option<Findings>> {
        let at = self.at;
        if at == self.patches.len() {
            return Step::Next(None);
        }
        let now = ui.input(|input| input.time);
        let remaining_s = self.settle_s - (now - *self.since.get_or_insert(now));
        if remaining_s > 0.0 {
            ui.ctx().request_repaint();
        }
        egui::CentralPanel::default()
            .frame(egui::Frame::NONE.fill(self.around))
            .show(ui, |ui| {
                let area = ui.max_rect();
                draw(ui, &self.patches[at], area, self.percents[at % self.percents.len()]);
                let line = Rect::from_min_max(egui::pos2(area.left(), area.bottom() - LINE), area.max);
                ui.painter().rect_filled(line, 0.0, Color32::BLACK);
                let inner = line.shrink2(Vec2::new(16.0, 8.0));
                ui.scope_builder(UiBuilder::new().max_rect(inner), |ui| self.line(ui, at, remaining_s)).inner
            })
            .inner
    }
}

/// Returns the index of the first patch without a reading; the number of patches if there is none.
fn first_unread(readings: &[Option<f64>]) -> usize {
    readings.iter().position(Option::is_none).unwrap_or(readings.len())
}

/// Returns the ID of the line, which is the same for all patches.
fn field_id() -> egui::Id {
    egui::Id::unique("reading of the photometer")
}

/// Gives the line keyboard focus and selects its text. Must be called before the line is drawn, so that text typed in
/// the same frame also replaces the selection.
fn select_all(ctx: &egui::Context, text: &str) {
    ctx.memory_mut(|memory| memory.request_focus(field_id()));
    let mut state = TextEdit::load_state(ctx, field_id()).unwrap_or_default();
    let end = CCursor::new(text.chars().count());
    state.cursor.set_char_range(Some(CCursorRange::two(CCursor::default(), end)));
    TextEdit::store_state(ctx, field_id(), state);
}

/// Draws the patch in the middle of the screen, aligned to whole pixels.
fn draw(ui: &mut egui::Ui, patch: &Patch, area: Rect, percent: u32) {
    let height = (area.height() * percent as f32 / 100.0).min(area.height() - 2.0 * LINE).max(16.0);
    let middle = Rect::from_center_size(area.center(), Vec2::splat(height));
    let rect = middle.round_to_pixels(ui.ctx().pixels_per_point());
    let [red, green, blue] = patch.channel.rgb(patch.code);
    ui.painter().rect_filled(rect, 0.0, Color32::from_rgb(red, green, blue));
    let name = format!("Patch {} {}", patch.channel, patch.code);
    let response = ui.interact(rect, ui.scope_id().with("patch"), egui::Sense::hover());
    if response.hovered() {
        ui.ctx().set_cursor_icon(egui::CursorIcon::None);
    }
    describe(&response, &name);
}
