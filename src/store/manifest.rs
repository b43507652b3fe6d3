//! The images of a definition's conditions, and the list of them. An interrupted run can be resumed: images that are still
//! as they were written are not made again.

use std::{
    collections::HashMap,
    fs::{self, File, OpenOptions},
    io::Write as _,
    path::{Path, PathBuf},
    sync::Mutex,
};

use super::{
    StoreError,
    fault::io,
    file::{sha256, write_whole},
    image, table,
};
use crate::{
    experiment::{Condition, Protocol},
    light::Quantizer,
    stimulus::recipe::Recipe,
};

/// Longest part of a file name that is made of levels.
const NAME_MAX: usize = 120;

/// A folder of images being made.
#[derive(Debug)]
pub struct Manifest<'a> {
    folder: PathBuf,
    recipes: &'a [Recipe],
    /// File name and factor levels of each image.
    rows: Vec<(String, Vec<String>)>,
    header: Vec<String>,
    shard: (usize, usize),
    /// Hash of each image that is there.
    made: Mutex<HashMap<usize, String>>,
    journal: Mutex<File>,
}

impl<'a> Manifest<'a> {
    /// Opens a folder, making it if need be, and looks which images are already there.
    ///
    /// # Errors
    /// The folder cannot be made or written.
    pub fn open(
        folder: &Path,
        protocol: &Protocol,
        conditions: &[Condition],
        recipes: &'a [Recipe],
        shard: (usize, usize),
    ) -> Result<Self, StoreError> {
        fs::create_dir_all(folder).map_err(io(folder, "make the folder"))?;
        let names: Vec<&str> = protocol.factors.iter().map(|factor| factor.name.as_str()).collect();
        let digits = conditions.len().to_string().len();
        let rows: Vec<_> = conditions
            .iter()
            .enumerate()
            .map(|(i, condition)| {
                let levels: Vec<String> = names
                    .iter()
                    .map(|name| condition.stimulus.get(name).map_or_else(String::new, |level| level.to_string()))
                    .collect();
                (file_name(i + 1, digits, &names, &levels), levels)
            })
            .collect();
        let header = ["file", "sha256"].into_iter().chain(names).chain(["bits", "transfer", "dither"]);
        let path = folder.join(journal_name(shard));
        let noted = noted_hashes(folder, &path, shard);
        let journal = OpenOptions::new().append(true).create(true).open(&path).map_err(io(&path, "open"))?;
        let manifest = Self {
            folder: folder.to_owned(),
            recipes,
            header: header.map(str::to_owned).collect(),
            shard,
            made: Mutex::default(),
            journal: Mutex::new(journal),
            rows,
        };
        for (i, (file, _)) in manifest.rows.iter().enumerate() {
            if let Some(hash) = noted.get(file)
                && manifest.is_intact(i, hash)
            {
                lock(&manifest.made).insert(i, hash.clone());
            }
        }
        Ok(manifest)
    }

    /// Whether an image is there, with the hash it was written with and the recipe it should have.
    fn is_intact(&self, i: usize, hash: &str) -> bool {
        let path = self.folder.join(&self.rows[i].0);
        let same_recipe = image::recipe_text(&path).is_some_and(|text| text == image::describe(&self.recipes[i]));
        same_recipe && fs::read(&path).is_ok_and(|bytes| sha256(&bytes) == hash)
    }

    /// Whether image `i` need not be made.
    pub fn is_made(&self, i: usize) -> bool {
        lock(&self.made).contains_key(&i)
    }

    /// Makes image `i`.
    ///
    /// # Errors
    /// The system's refusal.
    pub fn make(&self, i: usize, quantizer: &Quantizer) -> Result<(), StoreError> {
        let file = &self.rows[i].0;
        let bytes = image::write_recipe(&self.folder.join(file), &self.recipes[i], quantizer)?;
        let hash = sha256(&bytes);
        // One write a line: a line of a killed run is whole or the last.
        let noted = lock(&self.journal).write_all(format!("{file},{hash}\n").as_bytes());
        noted.map_err(io(&self.folder.join(journal_name(self.shard)), "write"))?;
        lock(&self.made).insert(i, hash);
        Ok(())
    }

    /// Writes the list of the images `mine`; the last shard to finish joins all lists into `manifest.csv`. Gives whether
    /// that is there now.
    ///
    /// # Errors
    /// The system's refusal.
    pub fn finish(self, mine: &[usize]) -> Result<bool, StoreError> {
        let of = self.shard.1;
        let hashes = lock(&self.made).clone();
        let lines: Vec<(usize, String)> =
            mine.iter().filter_map(|&i| Some((i, self.line(i, hashes.get(&i)?)))).collect();
        let journal = self.folder.join(journal_name(self.shard));
        if of == 1 {
            self.write_whole_list(&lines)?;
        } else {
            let part: String = lines.iter().map(|(_, line)| line.as_str()).collect();
            let path = self.folder.join(part_name(self.shard));
            write_whole(&path, part.as_bytes(), false)?;
            let parts: Option<Vec<String>> =
                (1..=of).map(|index| fs::read_to_string(self.folder.join(part_name((index, of)))).ok()).collect();
            let Some(parts) = parts else {
                // Another shard may have joined them all meanwhile.
                let _ = fs::remove_file(&journal);
                return Ok(false);
            };
            let mut joined: Vec<(usize, String)> = Vec::with_capacity(self.rows.len());
            for (first, part) in parts.iter().enumerate() {
                joined
                    .extend(part.split_inclusive('\n').enumerate().map(|(n, line)| (first + n * of, line.to_owned())));
            }
            joined.sort_by_key(|(i, _)| *i);
            self.write_whole_list(&joined)?;
            for index in 1..=of {
                let _ = fs::remove_file(self.folder.join(part_name((index, of))));
            }
        }
        // Both are of no more use; left behind they do no harm.
        let _ = fs::remove_file(&journal);
        Ok(true)
    }

    fn write_whole_list(&self, lines: &[(usize, String)]) -> Result<(), StoreError> {
        let mut text = csv_text(&self.header);
        text.extend(lines.iter().map(|(_, line)| line.as_str()));
        write_whole(&self.folder.join("manifest.csv"), text.as_bytes(), true)
    }

    fn line(&self, i: usize, hash: &str) -> String {
        let (file, levels) = &self.rows[i];
        let recipe = &self.recipes[i];
        let mut cells = vec![file.clone(), hash.to_owned()];
        cells.extend(levels.iter().cloned());
        cells.extend([recipe.bits.to_string(), recipe.transfers.to_string(), recipe.dither.to_string()]);
        csv_text(&cells)
    }
}

/// Hashes that an earlier run noted: of the whole list, of this shard's, and of a run that was interrupted.
fn noted_hashes(folder: &Path, journal: &Path, shard: (usize, usize)) -> HashMap<String, String> {
    let mut noted = HashMap::new();
    for path in [folder.join("manifest.csv"), folder.join(part_name(shard)), journal.to_owned()] {
        let text = fs::read_to_string(path).unwrap_or_default();
        for line in text.lines() {
            let mut cells = line.split(',');
            if let (Some(file), Some(hash)) = (cells.next(), cells.next()) {
                noted.insert(file.to_owned(), hash.to_owned());
            }
        }
    }
    noted
}

/// `007_width-0.02_depth-1.png`: the number makes it unique, the levels are for people.
fn file_name(number: usize, digits: usize, names: &[&str], levels: &[String]) -> String {
    let mut name = format!("{number:0digits$}");
    for (factor, level) in names.iter().zip(levels) {
        let clean = level.chars().map(|c| if c.is_ascii_alphanumeric() || "._-".contains(c) { c } else { '-' });
        name += &format!("_{factor}-{}", clean.collect::<String>());
    }
    name.truncate(NAME_MAX);
    name + ".png"
}

fn part_name((index, of): (usize, usize)) -> String {
    format!("manifest-{index}-of-{of}.csv")
}

fn journal_name((index, of): (usize, usize)) -> String {
    format!("manifest-{index}-of-{of}.partial")
}

fn csv_text(cells: &[String]) -> String {
    String::from_utf8_lossy(&table::line(cells)).into_owned()
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    // A panic elsewhere leaves the map and the file as valid as before.
    mutex.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}
