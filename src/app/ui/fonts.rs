//! Fonts of the system for texts with characters that the window's own font lacks.

use std::collections::BTreeSet;

use eframe::egui::{
    Context, FontData, FontFamily, FontId,
    epaint::text::{FontInsert, FontPriority, InsertFontFamily},
};

use super::work::{BackgroundTask, Progress};
use crate::system::fonts::{self, SystemFont};

/// The fonts for the texts of a session. They are looked for on another thread, and only if a character needs them.
#[derive(Default)]
pub struct TextFonts {
    state: State,
}

#[derive(Default)]
enum State {
    #[default]
    New,
    Searching(BackgroundTask<(Vec<SystemFont>, BTreeSet<char>)>),
    /// The characters that no font has.
    Done(BTreeSet<char>),
}

impl TextFonts {
    /// Looks for the fonts for these texts; returns the characters that no font has, once that is known.
    pub fn find<'t>(&mut self, ctx: &Context, texts: impl Iterator<Item = &'t str>) -> Option<&BTreeSet<char>> {
        match &self.state {
            State::New => {
                let lacking = lacking(ctx, texts);
                self.state = if lacking.is_empty() {
                    State::Done(lacking)
                } else {
                    State::Searching(BackgroundTask::start(ctx, move || fonts::covering(&lacking)))
                };
            }
            State::Searching(task) => match task.poll() {
                Progress::Running => {}
                Progress::Done((fonts, missing)) => {
                    fonts.into_iter().for_each(|font| install(ctx, font));
                    self.state = State::Done(missing);
                    // The new fonts are in use from the next frame on.
                    ctx.request_repaint();
                    return None;
                }
                Progress::Lost => self.state = State::Done(BTreeSet::new()),
            },
            State::Done(_) => {}
        }
        if let State::Done(missing) = &self.state { Some(missing) } else { None }
    }
}

/// Returns the characters that the installed fonts lack.
fn lacking<'t>(ctx: &Context, texts: impl Iterator<Item = &'t str>) -> BTreeSet<char> {
    let all: BTreeSet<char> = texts.flat_map(str::chars).filter(|c| !c.is_control()).collect();
    let font = FontId::proportional(16.0);
    ctx.fonts_mut(|fonts| all.into_iter().filter(|c| !fonts.has_glyph(&font, *c)).collect())
}

/// Adds a font after all others, so that texts in other scripts keep their look.
fn install(ctx: &Context, SystemFont { name, data, index }: SystemFont) {
    let families = [FontFamily::Proportional, FontFamily::Monospace];
    let families = families.map(|family| InsertFontFamily { family, priority: FontPriority::Lowest });
    let data = FontData { index, ..FontData::from_owned(data) };
    ctx.add_font(FontInsert { name: format!("system {name}"), data, families: families.to_vec() });
}
