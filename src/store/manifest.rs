//! The images of a definition's conditions, and their manifest. An interrupted run can be resumed: images that are
//! intact are not made again.

use std::{
    collections::{HashMap, HashSet},
    fs::{self, File, OpenOptions},
    io::Write as _,
    path::{Path, PathBuf},
    sync::Mutex,
    time::Duration,
};

use super::{
    StoreError, Writer,
    error::io,
    file::{remove_temporary, sha256, sync_folder},
    image,
    open::read_regular,
    table,
};
use crate::{
    experiment::{Condition, Protocol},
    light::Quantizer,
    stimulus::recipe::Recipe,
};

/// Minimum age of the temporary files that are removed because a killed run left them. Another shard may be using newer
/// ones.
const TEMPORARY_AGE: Duration = Duration::from_secs(60);
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
    /// Number of this shard's images that already exist.
    pub kept: usize,
    /// Indices of the images to make.
    pub missing: Vec<usize>,
}

impl<'a> Manifest<'a> {
    /// Opens or creates a folder for shard `index` of `shards`, counted from 1, and determines which of the shard's
    /// images already exist.
    ///
    /// # Errors
    /// The same errors as [`Writer::write`]: a file that is neither one of these images nor a list of them is replaced
    /// only by a writer that may do so.
    pub fn open(
        writer: &'a Writer,
        folder: &Path,
        protocol: &Protocol,
        conditions: &[Condition],
        recipes: &'a [Recipe],
        (index, shards): (usize, usize),
    ) -> Result<Self, StoreError> {
        writer.make_folder(folder)?;
        remove_temporary(folder, |_| true, TEMPORARY_AGE);
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
        // Hashes recorded by earlier runs.
        let mut known = HashMap::new();
        for path in [&whole, &list] {
            for line in text_of(path).unwrap_or_default().lines() {
                let mut cells = line.split(',').map(str::to_owned);
                known.extend(cells.next().zip(cells.next()));
            }
        }
        let is_of_recipe = |i: &usize| {
            let text = image::recipe_text(&folder.join(&rows[*i].0));
            text.is_some_and(|text| text == image::describe(&recipes[*i]))
        };
        let is_intact = |i: &usize| {
            let is_known = |bytes: Vec<u8>| known.get(&rows[*i].0) == Some(&sha256(&bytes));
            is_of_recipe(i) && read_regular(&folder.join(&rows[*i].0), u64::MAX).is_ok_and(is_known)
        };
        let (intact, missing): (Vec<usize>, Vec<usize>) = (index - 1..rows.len()).step_by(shards).partition(is_intact);
        let kept = intact.len();
        // A killed run may have made an image without listing it, so an image of the same recipe may stay.
        let foreign = missing.iter().filter(|i| !is_of_recipe(i)).map(|i| folder.join(&rows[*i].0));
        let foreign: Vec<_> = foreign.chain(foreign_lists(&whole, &list, &header, &rows)).collect();
        writer.check(foreign.iter().map(PathBuf::as_path))?;
        let line = |i: usize| line(&rows[i], &known[&rows[i].0], &recipes[i]);
        writer.replacing().write(&list, &intact.into_iter().flat_map(line).collect::<Vec<u8>>())?;
        let file = OpenOptions::new().append(true).open(&list).map_err(io(&list, "open"))?;
        let (folder, file) = (folder.to_owned(), Mutex::new(file));
        Ok(Self { writer, folder, recipes, header, rows, shards, list, file, kept, missing })
    }

    /// Makes image `i`.
    ///
    /// # Errors
    /// The same errors as [`Writer::write`].
    pub fn make(&self, i: usize, quantizer: &Quantizer) -> Result<(), StoreError> {
        let path = self.folder.join(&self.rows[i].0);
        let bytes = image::recipe_png(&path, &self.recipes[i], quantizer)?;
        if !read_regular(&path, bytes.len() as u64).is_ok_and(|found| found == bytes) {
            self.writer.put(&path, &bytes)?;
        }
        let line = line(&self.rows[i], &sha256(&bytes), &self.recipes[i]);
        // A panic on another thread leaves the file valid. Because each line is a single write, only the last line of a
        // killed run can be incomplete.
        let mut file = self.file.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        file.write_all(&line).map_err(io(&self.list, "write"))
    }

    /// If every image exists, joins the lists of all shards into `manifest.csv`. Returns whether it did.
    ///
    /// # Errors
    /// The same errors as [`Writer::write`].
    pub fn finish(self) -> Result<bool, StoreError> {
        // Syncing the folder once for all images is much faster than once per image.
        sync_folder(&self.list)?;
        let lists: Vec<PathBuf> =
            (1..=self.shards).map(|index| self.folder.join(list_name(index, self.shards))).collect();
        let texts: Vec<String> = lists.iter().filter_map(|path| text_of(path)).collect();
        // Each line begins with its image's number, so sorting restores the order. A line that another shard is still
        // writing has no line end yet and is skipped.
        let mut lines: Vec<&str> = texts.iter().flat_map(|text| text.split_inclusive('\n')).collect();
        lines.retain(|line| line.ends_with('\n'));
        lines.sort_unstable();
        if lines.len() < self.rows.len() {
            return Ok(false);
        }
        let manifest = [table::line(&self.header), lines.concat().into_bytes()].concat();
        self.writer.replacing().write(&self.folder.join(MANIFEST), &manifest)?;
        for list in lists {
            // A leftover file does no harm.
            let _ = fs::remove_file(list);
        }
        Ok(true)
    }
}

/// Returns those of the two lists (of all images, and of one shard) that exist but do not list these images.
fn foreign_lists(whole: &Path, list: &Path, header: &[String], rows: &[(String, Vec<String>)]) -> Vec<PathBuf> {
    let header = String::from_utf8_lossy(&table::line(header)).into_owned();
    let files: HashSet<&str> = rows.iter().map(|(file, _)| file.as_str()).collect();
    let is_ours = |line: &str| line.split(',').next().is_some_and(|name| files.contains(name));
    // The last line of a killed run can be incomplete.
    let lists_ours = |text: &str| text.split_inclusive('\n').all(|line| !line.ends_with('\n') || is_ours(line));
    let whole = (whole, text_of(whole).is_some_and(|text| text.starts_with(&header)));
    let list = (list, text_of(list).is_some_and(|text| lists_ours(&text)));
    let foreign = [whole, list].into_iter().filter(|(path, is_ours)| !is_ours && path.exists());
    foreign.map(|(path, _)| path.to_owned()).collect()
}

/// Returns the text of a list of images, if it can be read.
fn text_of(path: &Path) -> Option<String> {
    read_regular(path, MAX_LIST).ok().and_then(|bytes| String::from_utf8(bytes).ok())
}

fn line((file, levels): &(String, Vec<String>), hash: &str, recipe: &Recipe) -> Vec<u8> {
    let image = [recipe.bits.to_string(), recipe.transfers.to_string(), recipe.dither.to_string()];
    table::line([file.as_str(), hash].into_iter().chain(levels.iter().chain(&image).map(String::as_str)))
}

/// Returns a file name such as `007_width-0.02_depth-1.png`. The number makes it unique; the levels are meant for
/// people.
fn file_name(number: usize, digits: usize, names: &[&str], levels: &[String]) -> String {
    let mut name = format!("{number:0digits$}");
    for (factor, level) in names.iter().zip(levels) {
        let clean = level.chars().map(|c| if c.is_ascii_alphanumeric() || "._-".contains(c) { c } else { '-' });
        name += &format!("_{factor}-{}", clean.collect::<String>());
    }
    name.truncate(MAX_NAME);
    name + ".png"
}

fn list_name(index: usize, shards: usize) -> String {
    format!("manifest-{index}-of-{shards}.csv")
}
