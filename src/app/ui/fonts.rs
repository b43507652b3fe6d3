//! Fonts of the system for texts with characters that the window's own font lacks.

use std::collections::BTreeSet;

use eframe::egui::{
    Context, FontData, FontFamily, FontId,
    epaint::text::{FontInsert, FontPriority, InsertFontFamily},
};

use super::work::Latest;
use crate::system::fonts::{self, SystemFont};

/// The fonts for the texts of a page. They are looked for on another thread, and only if a character needs them.
#[derive(Default)]
pub struct TextFonts {
    /// The fonts for the characters that are looked for.
    search: Latest<BTreeSet<char>, Vec<SystemFont>>,
    /// The characters that were looked for. No font has those of them that are still lacking.
    searched: BTreeSet<char>,
}

impl TextFonts {
    /// Looks for the fonts for these texts; returns the characters that no font has, once that is known.
    pub fn find<'t>(&mut self, ctx: &Context, texts: impl IntoIterator<Item = &'t str>) -> Option<BTreeSet<char>> {
        let lacking = lacking(ctx, texts);
        let wanted: BTreeSet<char> = lacking.difference(&self.searched).copied().collect();
        if wanted.is_empty() {
            return Some(lacking);
        }
        self.search.want(ctx, wanted.clone(), || {
            let characters = wanted.clone();
            move || Ok(fonts::covering(&characters).0)
        });
        let found = self.search.get(&wanted)?;
        found.iter().flatten().for_each(|font| install(ctx, font));
        self.searched.extend(wanted);
        // The new fonts are in use from the next frame on.
        ctx.request_repaint();
        None
    }
}

/// Returns the characters that the installed fonts lack.
fn lacking<'t>(ctx: &Context, texts: impl IntoIterator<Item = &'t str>) -> BTreeSet<char> {
    let is_foreign = |c: &char| !c.is_ascii() && !c.is_control();
    let all: BTreeSet<char> = texts.into_iter().flat_map(str::chars).filter(is_foreign).collect();
    let font = FontId::proportional(16.0);
    ctx.fonts_mut(|fonts| all.into_iter().filter(|c| !fonts.has_glyph(&font, *c)).collect())
}

/// Adds a font after all others, so that texts in other scripts keep their look.
fn install(ctx: &Context, SystemFont { name, data, index }: &SystemFont) {
    let families = [FontFamily::Proportional, FontFamily::Monospace];
    let families = families.map(|family| InsertFontFamily { family, priority: FontPriority::Lowest });
    let data = FontData { index: *index, ..FontData::from_owned(data.clone()) };
    ctx.add_font(FontInsert { name: format!("system {name}"), data, families: families.to_vec() });
}
