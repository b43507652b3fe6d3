//! What the columns of somebody else's CSV file mean.

use std::path::{Path, PathBuf};

use eframe::egui::{self, ScrollArea};

use crate::{
    app::ui::{Field, fault, hint, primary, section, text::name as label},
    store::ratings::ReadOptions,
};

/// Names that a column of participants often has; the first that fits is suggested.
const SUBJECTS: [&str; 6] = ["subject", "participant", "subj", "observer", "person", "id"];
/// Of ratings.
const RESPONSES: [&str; 5] = ["rating", "response", "score", "answer", "resp"];
/// Of counts; these as a whole name.
const COUNTS: [&str; 4] = ["count", "n", "freq", "frequency"];

/// The form.
#[derive(Clone, Debug)]
pub struct Columns {
    file: PathBuf,
    header: Vec<String>,
    subject: Option<usize>,
    response: Option<usize>,
    count: Option<usize>,
    factors: Vec<bool>,
}

impl Columns {
    /// A form about the first CSV file among these paths; none where there is no such file, or where it has a header of
    /// ours and needs no form.
    pub fn needed(paths: &[PathBuf], read_options: &ReadOptions) -> Option<Self> {
        let form = Self::of(paths, read_options)?;
        let has = |name: &Option<String>, ours: &str| form.header.iter().any(|h| h == name.as_deref().unwrap_or(ours));
        let known = has(&read_options.subject, "subject_id") && has(&read_options.response, "rating");
        (!known).then_some(form)
    }

    /// A form about the first CSV file among these paths, as far as it was filled in before.
    pub fn of(paths: &[PathBuf], read_options: &ReadOptions) -> Option<Self> {
        let file = paths.iter().find_map(|path| first_csv(path))?;
        let header = header(&file)?;
        let place = |name: &Option<String>| name.as_ref().and_then(|name| header.iter().position(|h| h == name));
        let like =
            |names: &[&str]| names.iter().find_map(|name| header.iter().position(|h| h.to_lowercase().contains(name)));
        let count = header.iter().position(|h| COUNTS.contains(&h.to_lowercase().as_str()));
        let chosen = read_options.factors.clone().unwrap_or_default();
        Some(Self {
            subject: place(&read_options.subject).or_else(|| like(&SUBJECTS)),
            response: place(&read_options.response).or_else(|| like(&RESPONSES)),
            count: place(&read_options.count).or(count),
            factors: header.iter().map(|name| chosen.contains(name)).collect(),
            file,
            header,
        })
    }

    /// Draws the form; how to read, when that is asked for.
    pub fn show(&mut self, ui: &mut egui::Ui) -> Option<ReadOptions> {
        section(ui, "What do the columns mean?");
        let name = self.file.file_name().unwrap_or(self.file.as_os_str()).to_string_lossy().into_owned();
        hint(ui, format!("{name} was not written by machband. Name its columns."));
        choice(ui, "Participant", &mut self.subject, &self.header, None);
        choice(ui, "Rating", &mut self.response, &self.header, None);
        choice(ui, "Number of trials", &mut self.count, &self.header, Some("one in each row"));
        ui.label("Factors");
        hint(ui, "Check the columns that say under which condition a rating was given.");
        let taken = [self.subject, self.response, self.count];
        ScrollArea::vertical().id_salt("factors").max_height(200.0).show(ui, |ui| {
            ui.horizontal_wrapped(|ui| {
                for (index, (name, checked)) in self.header.iter().zip(&mut self.factors).enumerate() {
                    // A column with another meaning is no factor.
                    if !taken.contains(&Some(index)) {
                        let response = ui.checkbox(checked, name);
                        label(ui, &response, &format!("Factor {name}"));
                    }
                }
            });
        });
        ui.add_space(4.0);
        let same = self.subject.is_some() && [self.response, self.count].contains(&self.subject)
            || self.response.is_some() && self.response == self.count;
        if same {
            fault(ui, "One column is chosen twice; expected a different column for each.");
        }
        let ready = self.subject.is_some() && self.response.is_some() && !same;
        let hint = if ready { "" } else { "Choose at least the participant and the rating." };
        primary(ui, "Read these columns", ready, hint).then(|| self.reading())
    }

    fn reading(&self) -> ReadOptions {
        let name = |index: Option<usize>| index.map(|index| self.header[index].clone());
        let taken = [self.subject, self.response, self.count];
        let factors = (self.header.iter().zip(&self.factors).enumerate())
            .filter(|(index, (_, checked))| **checked && !taken.contains(&Some(*index)))
            .map(|(_, (name, _))| name.clone())
            .collect();
        ReadOptions {
            subject: name(self.subject),
            response: name(self.response),
            count: name(self.count),
            factors: Some(factors),
            ..ReadOptions::default()
        }
    }
}

fn choice(ui: &mut egui::Ui, label: &str, chosen: &mut Option<usize>, header: &[String], none: Option<&str>) {
    let mut all: Vec<Option<usize>> = Vec::new();
    all.extend(none.map(|_| None));
    all.extend((0..header.len()).map(Some));
    let text =
        |index: &Option<usize>| index.map_or(none.unwrap_or("choose…"), |index| header[index].as_str()).to_owned();
    Field::new(label).column(150.0).width(300.0).choice(ui, chosen, &all, text);
}

/// The file itself, or the first CSV file of a folder.
fn first_csv(path: &Path) -> Option<PathBuf> {
    if path.is_file() {
        return Some(path.to_owned());
    }
    let is_csv = |path: &PathBuf| path.extension().is_some_and(|ext| ext.eq_ignore_ascii_case("csv"));
    let mut files: Vec<PathBuf> = path
        .read_dir()
        .ok()?
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.is_file() && is_csv(path))
        .collect();
    files.sort();
    files.into_iter().next()
}

/// The names in a file's first row; none where that is no row of names.
fn header(file: &Path) -> Option<Vec<String>> {
    let mut reader = csv::ReaderBuilder::new().flexible(true).from_path(file).ok()?;
    let names: Vec<String> = reader.headers().ok()?.iter().map(|name| name.trim().to_owned()).collect();
    (names.len() > 1 && names.iter().all(|name| !name.is_empty())).then_some(names)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_suggested_by_their_names_and_ours_need_no_form() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            vec![path]
        };
        let read_options = ReadOptions::default();
        let paths = file("b.csv", "Participant,contrast,Response_03,freq\nA,1,2,3\n");
        let form = Columns::needed(&paths, &read_options).unwrap();
        assert_eq!((form.subject, form.response, form.count), (Some(0), Some(2), Some(3)));
        let reading = Columns { factors: vec![true; 4], ..form }.reading();
        assert_eq!(reading.factors, Some(vec!["contrast".to_owned()]));
        assert!(Columns::needed(&paths, &reading).is_none(), "named, and there");
        assert!(Columns::needed(&file("c.csv", "subject_id,width,rating,count\n"), &read_options).is_none());
        assert!(Columns::needed(&file("d.txt", "prose"), &read_options).is_none());
        assert!(Columns::of(&[folder.path().to_owned()], &read_options).is_some());
    }
}
