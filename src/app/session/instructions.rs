//! The pages that participants read before and between trials. Each page continues to the next. The instructions also
//! lead back; the pause page also leads to the instructions and out of the session.

use eframe::egui::{self, Key, ProgressBar, TextureHandle};

use crate::{
    app::ui::{self, Step, pixels, theme, work::Kept},
    experiment::{Category, Phase, Progress, Protocol, Texts},
    light::{Depth, Quantizer},
    stimulus::{MachBand, Stimulus},
};

/// Number of pages before the first trial: one about the task and one about the categories.
pub const INSTRUCTION_PAGES: usize = 2;

/// Maximum side of a category's picture, points.
const PICTURE: f32 = 150.0;

/// Width and depth of an example ramp for each of the paper's four categories; other scales and stimuli have no pictures.
/// Most people see its brighter band as the category describes. The examples are drawn in the colors of the session. They
/// are illustrations, not correct answers; their order follows the findings of Bangay §3.2.
const EXAMPLES: [(f64, Depth); 4] =
    [(0.9, Depth::Finite(4)), (0.9, Depth::Finite(2)), (0.6, Depth::Finite(1)), (0.12, Depth::Finite(1))];

/// Pictures of the categories, by their side in physical pixels.
pub type CategoryPictures = Kept<u32, Vec<TextureHandle>>;

/// Draws a page of the instructions, counted from 0. `back` says whether a page is before it.
pub fn instructions(
    ui: &mut egui::Ui,
    (page, back): (usize, bool),
    protocol: &Protocol,
    resumed: Option<Progress>,
    pictures: &mut CategoryPictures,
    quantizer: &Quantizer,
) -> Step<()> {
    let texts = &protocol.instructions;
    ui::page(ui, |ui| {
        if page == 0 {
            ui.heading(&texts.welcome);
            if let Some(progress) = resumed {
                ui.label(egui::RichText::new(fill(&texts.resumed, &progress)).color(theme::ink(ui).warn));
            }
            ui.add_space(8.0);
            for paragraph in texts.task.split("\n\n") {
                ui.label(paragraph);
                ui.add_space(4.0);
            }
            ui::hint(ui, &texts.light);
        } else {
            ui.heading(&texts.categories);
            ui.label(&protocol.response.question);
            ui.add_space(8.0);
            let has_examples = protocol.task.is_default() && protocol.response.categories.len() == EXAMPLES.len();
            match &protocol.stimulus {
                Stimulus::MachBand(band) if has_examples => {
                    examples(ui, &protocol.response.categories, (pictures, band), quantizer);
                }
                _ => key_list(ui, protocol),
            }
            ui.add_space(8.0);
            ui.label(protocol.response.fill_keys(&texts.keys));
        }
        ui.add_space(theme::LARGE_GAP);
        next_or_back(ui, texts, back)
    })
}

/// Draws an example of each category above its key and its label.
fn examples(
    ui: &mut egui::Ui,
    categories: &[Category],
    (pictures, band): (&mut CategoryPictures, &MachBand),
    quantizer: &Quantizer,
) {
    let gap = ui.spacing().item_spacing.x;
    let side = ((ui.available_width() - 3.0 * gap) / 4.0).clamp(40.0, PICTURE);
    let size = (side * ui.ctx().pixels_per_point()).floor() as u32;
    let drawn = |(i, (width, depth)): (usize, (f64, Depth))| {
        let example = Stimulus::MachBand(MachBand { width, depth, orientation_deg: 0.0, ..band.clone() });
        pixels::texture(ui.ctx(), &format!("category{i}"), &example.codes(size, quantizer))
    };
    let shown = pictures.get(size, || EXAMPLES.into_iter().enumerate().map(drawn).collect());
    ui.horizontal_top(|ui| {
        for (category, texture) in categories.iter().zip(shown) {
            ui.vertical(|ui| {
                ui.set_width(side);
                pixels::picture(ui, texture, &category.label);
                ui.label(egui::RichText::new(category.key_name()).size(theme::TITLE).strong());
                ui::paragraph(ui, &category.label);
            });
        }
    });
}

/// Draws the page before practice or before the main trials. `back` says whether it leads back to the instructions.
pub fn phase_start(ui: &mut egui::Ui, phase: Phase, protocol: &Protocol, progress: &Progress, back: bool) -> Step<()> {
    let texts = &protocol.instructions;
    ui::page(ui, |ui| {
        let (text, scale) = match phase {
            Phase::Practice => (&texts.practice, &texts.practice_scale),
            Phase::Main => (&texts.main, &texts.main_scale),
        };
        [text, scale].into_iter().filter(|text| !text.is_empty()).for_each(|text| _ = ui.label(text));
        ui.add_space(theme::GAP);
        if phase == Phase::Main {
            draw_progress(ui, progress, texts);
        } else {
            key_list(ui, protocol);
        }
        ui.add_space(theme::LARGE_GAP);
        next_or_back(ui, texts, back)
    })
}

/// Lists the keys and what they mean; of a slider, the ends.
fn key_list(ui: &mut egui::Ui, protocol: &Protocol) {
    if protocol.task.dial().is_some() {
        let ends: Vec<&str> = protocol.response.categories.iter().map(|end| end.label.as_str()).collect();
        if ends.iter().any(|end| !end.is_empty()) {
            ui.label(ends.join("  —  "));
        }
        return;
    }
    ui.scope(|ui| {
        // Eleven lines fit on the screen of a laptop.
        ui.spacing_mut().interact_size.y = theme::SECTION;
        for category in &protocol.response.categories {
            ui.horizontal(|ui| {
                ui.label(egui::RichText::new(category.key_name()).strong());
                ui::paragraph(ui, &category.label);
            });
        }
    });
}

/// Draws the page during a break.
pub fn rest(ui: &mut egui::Ui, progress: &Progress, texts: &Texts) -> Step<()> {
    ui::page(ui, |ui| {
        ui.heading(&texts.pause_heading);
        draw_progress(ui, progress, texts);
        ui.add_space(theme::LARGE_GAP);
        if next(ui, texts) { Step::Next(()) } else { Step::Stay }
    })
}

/// Where the pause page leads.
pub enum PauseChoice {
    Resume,
    Reread,
    Leave,
}

/// Draws the pause page. `why` says that the window became too small; `None` if the participant paused.
pub fn paused(ui: &mut egui::Ui, progress: &Progress, protocol: &Protocol, why: Option<&str>) -> Option<PauseChoice> {
    let texts = &protocol.instructions;
    ui::page(ui, |ui| {
        ui.heading(&texts.paused);
        ui.label(&texts.paused_text);
        if let Some(why) = why {
            ui::show_error(ui, why);
        }
        ui.add_space(theme::GAP);
        draw_progress(ui, progress, texts);
        ui.add_space(theme::GAP);
        ui.label(protocol.response.fill_keys(&texts.keys));
        ui.add_space(theme::LARGE_GAP);
        let resume = next(ui, texts).then_some(PauseChoice::Resume);
        ui.add_space(theme::GAP);
        let other = ui.horizontal_wrapped(|ui| {
            let reread = ui.button(&texts.reread).clicked().then_some(PauseChoice::Reread);
            let leave = ui.button(&texts.leave).clicked().then_some(PauseChoice::Leave);
            reread.or(leave)
        });
        other.inner.or(resume)
    })
}

fn draw_progress(ui: &mut egui::Ui, progress: &Progress, texts: &Texts) {
    ui.label(fill(&texts.break_progress, progress));
    ui.add(ProgressBar::new(progress.done as f32 / progress.total.max(1) as f32).desired_height(14.0));
}

/// Draws the button to the next page and, if there is a page before, the button back.
fn next_or_back(ui: &mut egui::Ui, texts: &Texts, back: bool) -> Step<()> {
    let next = next(ui, texts);
    let keys = [Key::Backspace, Key::ArrowLeft];
    let is_back = back && {
        ui.add_space(theme::SMALL_GAP);
        ui::keyed(ui, &texts.previous, &texts.previous_key) || keys.into_iter().any(|key| ui::shortcut(ui, key))
    };
    if next { Step::Next(()) } else { Step::back_if(is_back) }
}

/// Draws the button that continues; returns whether the participant does.
fn next(ui: &mut egui::Ui, texts: &Texts) -> bool {
    // A control with keyboard focus handles Space and Enter itself.
    let key = [Key::Space, Key::Enter].into_iter().any(|key| ui::shortcut(ui, key));
    ui::neutral_primary(ui, &texts.next, true, &texts.next_key) || key
}

fn fill(text: &str, progress: &Progress) -> String {
    let minutes = format!("{:.0}", (progress.remaining.as_secs_f64() / 60.0).ceil());
    text.replace("{done}", &progress.done.to_string())
        .replace("{total}", &progress.total.to_string())
        .replace("{minutes}", &minutes)
}
