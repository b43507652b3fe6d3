//! The pictures that a study brings itself: files beside its definition, and a table of their levels.

use std::{
    collections::HashMap,
    path::{Path, PathBuf},
    sync::Arc,
};

use rayon::prelude::*;
use serde_json::{Map, Value};

use super::{
    FileErrors, StoreError,
    file::{read_bytes, read_text, sha256},
    image::{self, parse_picture},
    table::{self, separator, with_point},
    toml::TableReader,
};
use crate::{
    experiment::{DefinitionErrors, is_reserved, task::OptionReader as _},
    light::{Bits, Dither, Quantizer, Transfer},
    stimulus::{
        ParameterValue,
        picture::{Gallery, Picture, PictureContent, PictureFile},
    },
    system::found,
    text::names::natural,
};

/// The table of the pictures' levels, in their folder.
const TABLE: &str = "pictures.csv";
/// Its column with the names of the files.
const FILE: &str = "file";
/// Maximum number of pictures of a study, and of bytes of a file.
const MAX_PICTURES: usize = 1000;
const MAX_FILE: u64 = 256 << 20;
/// Maximum number of pixels of a picture. No screen has more.
const MAX_PIXELS: u64 = 8192 * 8192;

/// Where a definition's pictures are.
#[derive(Clone, Copy)]
pub(super) struct Place<'a> {
    /// The folder of the definition.
    pub folder: &'a Path,
    /// Pictures of this folder that were read before.
    pub known: Option<&'a Gallery>,
}

/// Reads what a definition says about its pictures, and the pictures, unless they are known. `reference` is the one that
/// a task compares with the others.
pub(super) fn gallery(
    table: Map<String, Value>,
    Place { folder, known }: Place<'_>,
    reference: Option<&str>,
    background: f64,
    errors: &mut DefinitionErrors,
) -> Gallery {
    let read: Gallery = TableReader { path: "stimulus", table, taken: Vec::new(), errors }.read();
    let mut gallery = Gallery { background, ..read };
    let is_known = |known: &&Gallery| {
        known.files == gallery.files && known.references.iter().map(|picture| picture.file.as_str()).eq(reference)
    };
    if let Some(known) = known.filter(is_known) {
        let Gallery { factors, pictures, references, .. } = known.clone();
        return Gallery { factors, pictures, references, ..gallery };
    }
    if gallery.files.is_empty() {
        errors.add("stimulus", "stimulus.files is missing; expected files = \"pictures/*.png\"");
        return gallery;
    }
    let mut failed = |error: String| errors.add("stimulus.files", error);
    let table = levels(folder, &gallery.files).map_err(|error| failed(error.to_string()));
    let Ok((factors, levels)) = table else { return gallery };
    let files = matching(folder, &gallery.files).map_err(|error| failed(error.to_string())).unwrap_or_default();
    if files.len() < 2 || files.len() > MAX_PICTURES {
        let (pattern, count) = (&gallery.files, files.len());
        failed(format!("the number of files that {pattern} stands for is {count}; expected 2 to {MAX_PICTURES}"));
    }
    let (references, shown): (Vec<String>, _) = files.into_iter().partition(|file| Some(file.as_str()) == reference);
    let missing = reference.into_iter().map(str::to_owned).filter(|file| !references.contains(file));
    let references: Vec<String> = references.iter().cloned().chain(missing).collect();
    let read: Vec<_> = shown.par_iter().chain(&references).map(|file| picture(folder, file)).collect();
    let read = read.into_iter().filter_map(|picture| picture.map_err(|error| failed(error.to_string())).ok());
    let mut all: Vec<PictureFile> = read.collect();
    for picture in all.iter_mut().take(shown.len()).filter(|_| !factors.is_empty()) {
        let name = picture.file.rsplit('/').next().unwrap_or_default();
        match levels.get(name) {
            Some(own) => picture.levels.clone_from(own),
            None => failed(format!("{TABLE} has no row with the {FILE} {name}; expected one for each picture")),
        }
    }
    gallery.references = all.split_off(shown.len().min(all.len()));
    (gallery.pictures, gallery.factors) = (all, factors);
    gallery
}

/// Returns the files that a pattern names, relative to `folder`, in natural order.
fn matching(folder: &Path, pattern: &str) -> Result<Vec<String>, StoreError> {
    let (place, name) = pattern.rsplit_once('/').unwrap_or(("", pattern));
    let parts: Vec<&str> = name.split('*').collect();
    let fits = |path: &PathBuf| {
        let name = path.file_name()?.to_str()?;
        let rest = name.strip_prefix(parts[0])?;
        let fits = if let [_, last] = parts[..] { rest.ends_with(last) } else { rest.is_empty() };
        fits.then(|| if place.is_empty() { name.to_owned() } else { format!("{place}/{name}") })
    };
    let mut files: Vec<String> = image::listed(&folder.join(place))?.iter().filter_map(fits).collect();
    files.sort_by(|a, b| natural(a, b));
    Ok(files)
}

fn picture(folder: &Path, file: &str) -> Result<PictureFile, StoreError> {
    let path = folder.join(file);
    let bytes = read_bytes(&path, MAX_FILE, "a picture")?;
    let picture = parse_picture(&path.display().to_string(), &bytes, None, MAX_PIXELS)?;
    let light = picture.codes.light(&picture.transfers);
    let is_fine = picture.codes.bytes().is_none();
    let codes = if is_fine {
        let srgb = Transfer::Srgb.into();
        Quantizer::new(&srgb, Bits::Eight).quantize_with(&picture.codes.light(&srgb), Dither::BlueNoise, 0)
    } else {
        picture.codes
    };
    let content = Some(Arc::new(PictureContent { codes, light, is_fine }));
    Ok(PictureFile { file: file.to_owned(), sha256: sha256(&bytes), levels: Vec::new(), content })
}

/// Names of factors, and the levels of each file.
type Levels = (Vec<String>, HashMap<String, Vec<ParameterValue>>);

/// Reads the table of levels, if there is one.
fn levels(folder: &Path, pattern: &str) -> Result<Levels, StoreError> {
    let path = folder.join(pattern.rsplit_once('/').map_or("", |(place, _)| place)).join(TABLE);
    if found(&path).map_err(|error| StoreError::io(&path, "access", error))?.is_none() {
        return Ok(Levels::default());
    }
    let fail = |message: String| StoreError::from(FileErrors::whole(&path, message));
    let (file, text) = (path.display().to_string(), read_text(&path)?);
    let header = |found: &[&str]| {
        let names: Vec<String> = found.iter().map(|name| name.trim().to_owned()).collect();
        let missing = || (0, format!("has no column {FILE:?}; expected the name of each picture in it"));
        let place = names.iter().position(|name| name == FILE).ok_or_else(missing)?;
        Ok((names, place))
    };
    let (separator, mut levels) = (separator(text.lines().next().unwrap_or_default().as_bytes()), HashMap::new());
    let read = |(_, place): &(Vec<String>, usize), cells: &[&str]| {
        let mut cells: Vec<String> = cells.iter().map(|cell| with_point(cell.trim(), separator).into_owned()).collect();
        let name = cells.remove(*place);
        // Another pattern may match the file.
        let picture = found(&path.with_file_name(&name))
            .map_err(|error| (0, format!("{name:?} cannot be accessed: {error}; expected a picture for each row")))?;
        if name.is_empty() || picture.is_none() {
            return Err((0, format!("there is no file {name:?}; expected a picture for each row")));
        }
        match levels.insert(name.clone(), cells) {
            Some(_) => Err((0, format!("{name} appears twice; expected one row for each picture"))),
            None => Ok(()),
        }
    };
    let ((mut names, place), _) = table::parse(&file, text.as_bytes(), separator, header, read)?;
    names.remove(place);
    for (at, name) in names.iter().enumerate() {
        let problem = if *name == Picture::PICTURE || is_reserved(name) {
            "has the name of a column of the data"
        } else if names[..at].contains(name) {
            "appears twice"
        } else if name.is_empty() || !name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
            "has other characters than letters, digits and _"
        } else {
            continue;
        };
        return Err(fail(format!("the column {name:?} {problem}; expected another name")));
    }
    // A number is one only if nothing is lost: 007 and 7, or 1 and 1.0, are different levels.
    let number =
        |cell: &String| cell.parse().ok().filter(|number: &f64| number.is_finite() && number.to_string() == *cell);
    let are_numbers: Vec<bool> =
        (0..names.len()).map(|at| levels.values().all(|cells| number(&cells[at]).is_some())).collect();
    let level = |(cell, is_number): (String, &bool)| {
        number(&cell).filter(|_| *is_number).map_or_else(|| ParameterValue::Text(cell), ParameterValue::Number)
    };
    let typed = |cells: Vec<String>| cells.into_iter().zip(&are_numbers).map(level).collect();
    Ok((names, levels.into_iter().map(|(file, cells)| (file, typed(cells))).collect()))
}
