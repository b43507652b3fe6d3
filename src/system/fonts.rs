//! Fonts of the operating system, for characters that the window's own font lacks.

use std::{cmp::Reverse, collections::BTreeSet};

use fontdb::{Database, FaceInfo, Style};
use ttf_parser::Face;
use unicode_script::{Script, UnicodeScript as _};

/// A font of the system.
pub struct SystemFont {
    /// Its name.
    pub name: String,
    /// The content of its file.
    pub data: Vec<u8>,
    /// Its index in the file.
    pub index: u32,
}

/// Returns as few fonts as possible that have as many of these characters as possible, and the characters that no font
/// has. This reads the fonts of the system, which may take a second.
pub fn covering(wanted: &BTreeSet<char>) -> (Vec<SystemFont>, BTreeSet<char>) {
    let (mut fonts, mut missing) = (Vec::new(), wanted.clone());
    if missing.is_empty() {
        return (fonts, missing);
    }
    let mut database = Database::new();
    database.load_system_fonts();
    let region = region(wanted);
    let mut faces: Vec<(&FaceInfo, BTreeSet<char>)> =
        database.faces().map(|face| (face, has(&database, face, wanted))).filter(|(_, has)| !has.is_empty()).collect();
    while !missing.is_empty() {
        faces.iter_mut().for_each(|(_, has)| has.retain(|c| missing.contains(c)));
        let Some((face, has)) = faces.iter().max_by_key(|(face, has)| (has.len(), fitness(face, region))) else {
            break;
        };
        if has.is_empty() {
            break;
        }
        missing.retain(|c| !has.contains(c));
        fonts.extend(database.with_face_data(face.id, |data, index| SystemFont {
            name: face.post_script_name.clone(),
            data: data.to_vec(),
            index,
        }));
    }
    (fonts, missing)
}

/// Returns the characters that a font has.
fn has(database: &Database, face: &FaceInfo, wanted: &BTreeSet<char>) -> BTreeSet<char> {
    let has = database.with_face_data(face.id, |data, index| {
        let face = Face::parse(data, index).ok()?;
        Some(wanted.iter().copied().filter(|c| face.glyph_index(*c).is_some()).collect())
    });
    has.flatten().unwrap_or_default()
}

/// Returns which form of the Han characters fits the other characters. Large fonts name it.
fn region(wanted: &BTreeSet<char>) -> &'static str {
    let has = |scripts: &[Script]| wanted.iter().any(|c| scripts.contains(&c.script()));
    match () {
        () if has(&[Script::Hiragana, Script::Katakana]) => "JP",
        () if has(&[Script::Hangul]) => "KR",
        () => "SC",
    }
}

/// Orders fonts with the same characters: upright, for this region, of regular weight, not monospaced, without serifs.
fn fitness(face: &FaceInfo, region: &str) -> impl Ord + use<> {
    let name = &face.post_script_name;
    let is_regular = Reverse(face.weight.0.abs_diff(400));
    (face.style == Style::Normal, name.contains(region), is_regular, !face.monospaced, name.contains("Sans"))
}
