//! The images of a definition's conditions, and their manifest. An interrupted run can be repeated: images that are intact
//! are not written again.

use std::path::{Path, PathBuf};

use super::{
    FileErrors, StoreError, Writer,
    error::{NotData, io},
    file::{ABANDONED, exists, read_bytes, read_existing, remove_temporary, sha256, sync_folder},
    image,
    open::read_regular,
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
/// Maximum size of an image in bytes; more than the largest stimulus needs without compression.
const MAX_IMAGE: u64 = 2 << 30;

/// Maximum length of a file name without its extension.
const MAX_NAME: usize = 120;

/// A folder of images in progress.
#[derive(Debug)]
pub struct Manifest<'a> {
    writer: &'a Writer,
    folder: PathBuf,
    recipes: &'a [Recipe],
    header: Vec<String>,
    /// File name and factor levels of each image.
    rows: Vec<(String, Vec<String>)>,
    /// Indices of the images to make.
    pub own: Vec<usize>,
}

impl<'a> Manifest<'a> {
    /// Opens or creates a folder for shard `index` of `shards`, counted from 1.
    ///
    /// # Errors
    /// The same errors as [`Writer::write`]: a file that is neither one of these images nor the list of them is replaced
    /// only by a writer that may do so. A list or an image cannot be read.
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
        let own = (index - 1..rows.len()).step_by(shards).collect();
        let manifest = Self { writer, folder: folder.to_owned(), recipes, header, rows, own };
        let list = folder.join(MANIFEST);
        let mut foreign = Vec::new();
        if read_existing(&list, MAX_LIST)?.is_some_and(|text| !manifest.is_own_list(&text)) {
            foreign.push(list);
        }
        for &i in &manifest.own {
            let path = manifest.path(i);
            // Asked first: another run may make the image at any moment, and does so as a whole.
            if exists(&path)? && !manifest.is_made(i)? {
                foreign.push(path);
            }
        }
        writer.check(foreign.iter().map(PathBuf::as_path))?;
        Ok(manifest)
    }

    fn path(&self, i: usize) -> PathBuf {
        self.folder.join(&self.rows[i].0)
    }

    /// Returns whether the file of image `i` says that it is this image.
    fn is_made(&self, i: usize) -> Result<bool, StoreError> {
        let path = self.path(i);
        Ok(image::recipe_text(&path).map_err(io(&path, "read"))? == Some(image::describe(&self.recipes[i])))
    }

    /// Returns the line of image `i` with this hash.
    fn line(&self, i: usize, hash: &str) -> Vec<u8> {
        let (Recipe { bits, transfers, dither, .. }, (file, levels)) = (&self.recipes[i], &self.rows[i]);
        let image = [bits.to_string(), transfers.to_string(), dither.to_string()];
        table::line([file.as_str(), hash].into_iter().chain(levels.iter().chain(&image).map(String::as_str)))
    }

    /// Returns whether a text lists these images, whatever their hashes.
    fn is_own_list(&self, text: &[u8]) -> bool {
        let mut lines = text.split_inclusive(|byte| *byte == b'\n');
        let is_line = |(i, line): (usize, &[u8])| {
            let hash = line.split(|byte| *byte == b',').nth(1).unwrap_or_default();
            i < self.rows.len() && line == self.line(i, &String::from_utf8_lossy(hash))
        };
        lines.next() == Some(&table::line(&self.header)) && lines.enumerate().all(is_line)
    }

    /// Makes image `i`, and returns whether it was not there yet.
    ///
    /// # Errors
    /// The same errors as [`Writer::write`].
    pub fn make(&self, i: usize, quantizer: &Quantizer) -> Result<bool, StoreError> {
        let path = self.path(i);
        let bytes = image::recipe_png(&path, &self.recipes[i], quantizer)?;
        let is_there = || Ok::<bool, StoreError>(content(&path, bytes.len())?.as_ref() == Some(&bytes));
        if is_there()? {
            return Ok(false);
        }
        match self.writer.put(&path, &bytes) {
            // Another run made it a moment ago.
            Err(StoreError::Occupied(_)) if is_there()? => Ok(true),
            put => put.map(|()| true),
        }
    }

    /// Writes `manifest.csv` if every image exists, and returns whether it does. A writer that replaces files leaves images
    /// of other shards that are still to be replaced.
    ///
    /// # Errors
    /// An image cannot be read, or is another one than this command makes; the same errors as [`Writer::write`].
    pub fn finish(&self) -> Result<bool, StoreError> {
        let list = self.folder.join(MANIFEST);
        // Syncing the folder once for all images is much faster than once per image.
        sync_folder(&list)?;
        let mut lines = vec![table::line(&self.header)];
        for i in 0..self.rows.len() {
            let path = self.path(i);
            if !exists(&path)? {
                return Ok(false);
            }
            if !self.is_made(i)? {
                let message = "is another image than this command makes; expected every shard to be made with the same definition and options";
                return if self.writer.force { Ok(false) } else { Err(FileErrors::whole(path, message).into()) };
            }
            lines.push(self.line(i, &sha256(&read_bytes(&path, MAX_IMAGE, "an image")?)));
        }
        self.writer.replacing().write(&list, &lines.concat())?;
        Ok(true)
    }
}

/// Returns the content of an image of at most `most` bytes, or nothing for a larger file; `None` if there is no file.
fn content(path: &Path, most: usize) -> Result<Option<Vec<u8>>, StoreError> {
    match unless_missing(read_regular(path, most as u64)) {
        Err(error) if matches!(NotData::of(&error), Some(NotData::TooLarge { .. })) => Ok(Some(Vec::new())),
        content => content.map_err(io(path, "read")),
    }
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
