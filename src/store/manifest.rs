//! The images of a definition's conditions, and their manifest. An interrupted run can be repeated: images that are intact
//! are not written again.

use std::{
    collections::HashMap,
    fs::{self, File, OpenOptions},
    io::{Seek as _, Write as _},
    path::{Path, PathBuf},
    sync::{Mutex, PoisonError},
};

use super::{
    FileErrors, StoreError, Writer,
    error::{NotData, io},
    file::{ABANDONED, exists, lock, read_existing, remove_temporary, sha256, sync_folder},
    image,
    open::{read_at_most, read_regular},
    table,
};
use crate::{
    experiment::{Condition, Protocol},
    light::Quantizer,
    stimulus::recipe::Recipe,
    system::unless_missing,
};

/// Name of the list of all images.
const MANIFEST: &str = "manifest.csv";
/// Maximum size of a list of images in bytes: 100,000 lines of 300 bytes.
const MAX_LIST: u64 = 64 << 20;

/// Maximum length of a file name without its extension.
const MAX_NAME: usize = 120;

/// A folder of images in progress. Until all images exist, each shard lists its own images in a file, one line per
/// image.
#[derive(Debug)]
pub struct Manifest<'a> {
    writer: &'a Writer,
    folder: PathBuf,
    recipes: &'a [Recipe],
    header: Vec<String>,
    /// File name and factor levels of each image.
    rows: Vec<(String, Vec<String>)>,
    shards: usize,
    list: PathBuf,
    file: Mutex<File>,
    /// Indices of the images to make.
    pub own: Vec<usize>,
}

impl<'a> Manifest<'a> {
    /// Opens or creates a folder for shard `index` of `shards`, counted from 1.
    ///
    /// # Errors
    /// The same errors as [`Writer::write`]: a file that is neither one of these images nor a list of them is replaced
    /// only by a writer that may do so. Another run is making the images of this shard. A list or an image cannot be
    /// read.
    pub fn open(
        writer: &'a Writer,
        folder: &Path,
        protocol: &Protocol,
        conditions: &[Condition],
        recipes: &'a [Recipe],
        (index, shards): (usize, usize),
    ) -> Result<Self, StoreError> {
        writer.make_folder(folder)?;
        remove_temporary(folder, |_| true, ABANDONED);
        let names: Vec<&str> = protocol.factors.iter().map(|factor| factor.name.as_str()).collect();
        let digits = conditions.len().to_string().len();
        let row = |(i, condition): (usize, &Condition)| {
            let level = |name: &&str| condition.stimulus.get(name).map_or_else(String::new, |level| level.to_string());
            let levels: Vec<String> = names.iter().map(level).collect();
            (file_name(i + 1, digits, &names, &levels), levels)
        };
        let rows: Vec<_> = conditions.iter().enumerate().map(row).collect();
        let header = ["file", "sha256"].into_iter().chain(names.iter().copied()).chain(["bits", "transfer", "dither"]);
        let header: Vec<String> = header.map(str::to_owned).collect();
        let (list, whole) = (folder.join(list_name(index, shards)), folder.join(MANIFEST));
        let own: Vec<usize> = (index - 1..rows.len()).step_by(shards).collect();
        let mut foreign = Vec::new();
        let names_of_whole = String::from_utf8_lossy(&table::line(&header)).into_owned();
        for (path, names) in [(&whole, &*names_of_whole), (&list, "")] {
            let Some(text) = text_of(path)? else { continue };
            if !text.strip_prefix(names).is_some_and(|lines| are_ours(lines, &rows, recipes)) {
                foreign.push(path.clone());
            }
        }
        for &i in &own {
            let path = folder.join(&rows[i].0);
            // Asked first: another run may make the image at any moment, and does so as a whole.
            if exists(&path)?
                && image::recipe_text(&path).map_err(io(&path, "read"))? != Some(image::describe(&recipes[i]))
            {
                foreign.push(path);
            }
        }
        writer.check(foreign.iter().map(PathBuf::as_path))?;
        let file = locked(writer, &list)?;
        file.set_len(0).map_err(io(&list, "write"))?;
        let (folder, file) = (folder.to_owned(), Mutex::new(file));
        Ok(Self { writer, folder, recipes, header, rows, shards, list, file, own })
    }

    /// Makes image `i`, and returns whether it was not there yet.
    ///
    /// # Errors
    /// The same errors as [`Writer::write`].
    pub fn make(&self, i: usize, quantizer: &Quantizer) -> Result<bool, StoreError> {
        let path = self.folder.join(&self.rows[i].0);
        let bytes = image::recipe_png(&path, &self.recipes[i], quantizer)?;
        let found = content(&path, bytes.len())?;
        let is_new = found.as_ref() != Some(&bytes);
        if is_new {
            match self.writer.put(&path, &bytes) {
                // A run that divides the work differently made it a moment ago.
                Err(StoreError::Occupied(_))
                    if found.is_none() && content(&path, bytes.len())?.as_ref() == Some(&bytes) => {}
                Err(StoreError::Occupied(_)) if found.is_none() => return Err(in_use(&path)),
                put => put?,
            }
        }
        let line = line(&self.rows[i], &sha256(&bytes), &self.recipes[i]);
        // A panic on another thread leaves the file valid. Because each line is a single write, only the last line of a
        // killed run can be incomplete.
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        file.write_all(&line).map_err(io(&self.list, "write"))?;
        Ok(is_new)
    }

    /// If every image exists, joins the lists of all shards into `manifest.csv`. Returns whether it lists every image.
    ///
    /// # Errors
    /// A list cannot be read; the same errors as [`Writer::write`].
    pub fn finish(self) -> Result<bool, StoreError> {
        // Syncing the folder once for all images is much faster than once per image.
        sync_folder(&self.list)?;
        let mut file = self.file.into_inner().unwrap_or_else(PoisonError::into_inner);
        let own = file.rewind().and_then(|()| read_at_most(&mut file, MAX_LIST)).map_err(io(&self.list, "read"))?;
        let lists: Vec<PathBuf> =
            (1..=self.shards).map(|index| self.folder.join(list_name(index, self.shards))).collect();
        let mut texts = vec![String::from_utf8_lossy(&own).into_owned()];
        for list in lists.iter().filter(|list| **list != self.list) {
            let Some(text) = text_of(list)? else { continue };
            if !are_ours(&text, &self.rows, self.recipes) {
                let message = "lists other images than this command makes; expected every shard to be made with the same definition and options";
                return Err(FileErrors::whole(list, message).into());
            }
            texts.push(text);
        }
        // Each line begins with its image's number, so sorting restores the order. A line that another shard is still
        // writing has no line end yet and is skipped.
        let mut lines: Vec<&str> = texts.iter().flat_map(|text| text.split_inclusive('\n')).collect();
        lines.retain(|line| line.ends_with('\n'));
        lines.sort_unstable();
        let (path, header) = (self.folder.join(MANIFEST), table::line(&self.header));
        if is_whole(&lines, &self.rows, self.recipes) {
            // The runs of other shards may have had another definition or other options.
            for ((file, _), recipe) in self.rows.iter().zip(self.recipes).filter(|_| self.shards > 1) {
                let path = self.folder.join(file);
                if image::recipe_text(&path).map_err(io(&path, "read"))? != Some(image::describe(recipe)) {
                    let message = "is another image than this command makes; expected every shard to be made with the same definition and options";
                    return Err(FileErrors::whole(path, message).into());
                }
            }
            self.writer.replacing().write(&path, &[header, lines.concat().into_bytes()].concat())?;
        } else {
            // Another shard may have joined the lists, this one's too, and removed them.
            let joined = text_of(&path)?.unwrap_or_default();
            let joined: Vec<&str> = joined.split_inclusive('\n').skip(1).collect();
            if !is_whole(&joined, &self.rows, self.recipes) {
                return Ok(false);
            }
        }
        for list in lists {
            // A leftover file does no harm.
            let _ = fs::remove_file(list);
        }
        Ok(true)
    }
}

/// Returns whether the lines of a list are those of all images, one each.
fn is_whole(lines: &[&str], rows: &[(String, Vec<String>)], recipes: &[Recipe]) -> bool {
    let is_of = |((text, row), recipe): ((&&str, _), _)| {
        text.split(',').nth(1).is_some_and(|hash| text.as_bytes() == line(row, hash, recipe))
    };
    lines.len() == rows.len() && lines.iter().zip(rows).zip(recipes).all(is_of)
}

/// Opens a shard's list and locks it for as long as it is open.
fn locked(writer: &Writer, list: &Path) -> Result<File, StoreError> {
    writer.replacing().check([list])?;
    let file =
        OpenOptions::new().read(true).write(true).create(true).truncate(false).open(list).map_err(io(list, "open"))?;
    match lock(&file, list) {
        Err(StoreError::InUse(path)) => Err(in_use(&path)),
        locked => locked.map(|_| file),
    }
}

fn in_use(path: &Path) -> StoreError {
    let what = "another run is making these images; expected it to end first: wait, and run the command again";
    FileErrors::whole(path, what).into()
}

/// Returns whether the lines of a list are those of images. A line that someone changed is not one of ours.
fn are_ours(lines: &str, rows: &[(String, Vec<String>)], recipes: &[Recipe]) -> bool {
    let images: HashMap<&str, _> = rows.iter().zip(recipes).map(|image| (&*image.0.0, image)).collect();
    let is_ours = |text: &str| {
        let mut cells = text.split(',');
        let image = cells.next().and_then(|name| images.get(name));
        image.zip(cells.next()).is_some_and(|((row, recipe), hash)| line(row, hash, recipe) == text.as_bytes())
    };
    // The last line of a killed run can be incomplete.
    lines.split_inclusive('\n').filter(|line| line.ends_with('\n')).all(is_ours)
}

/// Returns the text of a list of images; `None` if there is none.
fn text_of(path: &Path) -> Result<Option<String>, StoreError> {
    let bytes = read_existing(path, MAX_LIST)?;
    // What is not text lists nothing of ours.
    Ok(bytes.map(|bytes| String::from_utf8(bytes).unwrap_or_else(|_| "\u{fffd}\n".to_owned())))
}

/// Returns the content of an image of at most `most` bytes, or nothing for a larger file; `None` if there is no file.
fn content(path: &Path, most: usize) -> Result<Option<Vec<u8>>, StoreError> {
    match unless_missing(read_regular(path, most as u64)) {
        Err(error) if matches!(NotData::of(&error), Some(NotData::TooLarge { .. })) => Ok(Some(Vec::new())),
        content => content.map_err(io(path, "read")),
    }
}

fn line((file, levels): &(String, Vec<String>), hash: &str, recipe: &Recipe) -> Vec<u8> {
    let image = [recipe.bits.to_string(), recipe.transfers.to_string(), recipe.dither.to_string()];
    table::line([file.as_str(), hash].into_iter().chain(levels.iter().chain(&image).map(String::as_str)))
}

/// Returns a file name such as `007_width-0.02_depth-1.png`. The number makes it unique; the levels are meant for
/// people.
fn file_name(number: usize, digits: usize, names: &[&str], levels: &[String]) -> String {
    let levels = names.iter().copied().zip(levels.iter().cloned());
    labeled(format!("{number:0digits$}"), levels, MAX_NAME) + ".png"
}

/// Returns a name followed by levels of factors, at most `most` characters.
pub(super) fn labeled<'a>(mut name: String, levels: impl Iterator<Item = (&'a str, String)>, most: usize) -> String {
    for (factor, level) in levels {
        let clean = level.chars().map(|c| if c.is_ascii_alphanumeric() || "._-".contains(c) { c } else { '-' });
        name += &format!("_{factor}-{}", clean.collect::<String>());
    }
    name.truncate(most);
    name
}

fn list_name(index: usize, shards: usize) -> String {
    format!("manifest-{index}-of-{shards}.csv")
}
