//! The images of a definition's conditions, and their manifest. An interrupted run can be resumed: images that are
//! intact are not made again.

use std::{
    collections::HashMap,
    fs::{self, File, OpenOptions},
    io::Write as _,
    path::{Path, PathBuf},
    sync::Mutex,
};

use super::{
    StoreError,
    error::io,
    file::{make_folder, sha256, write_whole},
    image, table,
};
use crate::{
    experiment::{Condition, Protocol},
    light::Quantizer,
    stimulus::recipe::Recipe,
};

/// Maximum length of a file name without its extension.
const MAX_NAME: usize = 120;

/// A folder of images in progress. Until all images exist, each shard lists its own images in a file, one line per
/// image.
#[derive(Debug)]
pub struct Manifest<'a> {
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
    /// The folder cannot be created or written.
    pub fn open(
        folder: &Path,
        protocol: &Protocol,
        conditions: &[Condition],
        recipes: &'a [Recipe],
        (index, shards): (usize, usize),
    ) -> Result<Self, StoreError> {
        make_folder(folder)?;
        let names: Vec<&str> = protocol.factors.iter().map(|factor| factor.name.as_str()).collect();
        let digits = conditions.len().to_string().len();
        let row = |(i, condition): (usize, &Condition)| {
            let level = |name: &&str| condition.stimulus.get(name).map_or_else(String::new, |level| level.to_string());
            let levels: Vec<String> = names.iter().map(level).collect();
            (file_name(i + 1, digits, &names, &levels), levels)
        };
        let rows: Vec<_> = conditions.iter().enumerate().map(row).collect();
        let header = ["file", "sha256"].into_iter().chain(names.iter().copied()).chain(["bits", "transfer", "dither"]);
        let list = folder.join(list_name(index, shards));
        // Hashes recorded by earlier runs.
        let mut known = HashMap::new();
        for path in [&folder.join("manifest.csv"), &list] {
            for line in fs::read_to_string(path).unwrap_or_default().lines() {
                let mut cells = line.split(',').map(str::to_owned);
                known.extend(cells.next().zip(cells.next()));
            }
        }
        let is_intact = |i: &usize| {
            let path = folder.join(&rows[*i].0);
            let same_recipe = image::recipe_text(&path).is_some_and(|text| text == image::describe(&recipes[*i]));
            same_recipe && fs::read(&path).is_ok_and(|bytes| known.get(&rows[*i].0) == Some(&sha256(&bytes)))
        };
        let (intact, missing): (Vec<usize>, Vec<usize>) = (index - 1..rows.len()).step_by(shards).partition(is_intact);
        let kept = intact.len();
        let line = |i: usize| line(&rows[i], &known[&rows[i].0], &recipes[i]);
        write_whole(&list, &intact.into_iter().flat_map(line).collect::<Vec<u8>>(), false)?;
        let file = OpenOptions::new().append(true).open(&list).map_err(io(&list, "open"))?;
        let (folder, header, file) = (folder.to_owned(), header.map(str::to_owned).collect(), Mutex::new(file));
        Ok(Self { folder, recipes, header, rows, shards, list, file, kept, missing })
    }

    /// Makes image `i`.
    ///
    /// # Errors
    /// I/O errors.
    pub fn make(&self, i: usize, quantizer: &Quantizer) -> Result<(), StoreError> {
        let bytes = image::write_recipe(&self.folder.join(&self.rows[i].0), &self.recipes[i], quantizer)?;
        let line = line(&self.rows[i], &sha256(&bytes), &self.recipes[i]);
        // A panic on another thread leaves the file valid. Because each line is a single write, only the last line of a
        // killed run can be incomplete.
        let mut file = self.file.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        file.write_all(&line).map_err(io(&self.list, "write"))
    }

    /// If every image exists, joins the lists of all shards into `manifest.csv`. Returns whether it did.
    ///
    /// # Errors
    /// I/O errors.
    pub fn finish(self) -> Result<bool, StoreError> {
        let lists: Vec<PathBuf> =
            (1..=self.shards).map(|index| self.folder.join(list_name(index, self.shards))).collect();
        let texts: Vec<String> = lists.iter().map(|path| fs::read_to_string(path).unwrap_or_default()).collect();
        // Each line begins with its image's number, so sorting restores the order. A line that another shard is still
        // writing has no line end yet and is skipped.
        let mut lines: Vec<&str> = texts.iter().flat_map(|text| text.split_inclusive('\n')).collect();
        lines.retain(|line| line.ends_with('\n'));
        lines.sort_unstable();
        if lines.len() < self.rows.len() {
            return Ok(false);
        }
        let manifest = [table::line(&self.header), lines.concat().into_bytes()].concat();
        write_whole(&self.folder.join("manifest.csv"), &manifest, true)?;
        for list in lists {
            // A leftover file does no harm.
            let _ = fs::remove_file(list);
        }
        Ok(true)
    }
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
