//! What a file of ratings does not say, and the user is asked: what its columns mean, and the order of its categories.

use std::path::{Path, PathBuf};

use eframe::egui::{self, Button, ScrollArea};

use crate::{
    app::ui::{Field, hint, paragraph, primary, section, show_error, text::name as label},
    store::{
        ratings::{ReadOptions, column_names},
        table::List,
    },
    system::{entries, found},
    work::{Ratings, Study},
};

/// Common names of participant columns; the first match is suggested.
const SUBJECTS: [&str; 6] = ["subject", "participant", "subj", "observer", "person", "id"];
/// Common names of rating columns.
const RESPONSES: [&str; 5] = ["rating", "response", "score", "answer", "resp"];
/// Common names of count columns; these must match the whole name. `n` is not among them, because it may be a factor.
const COUNTS: [&str; 3] = ["count", "freq", "frequency"];

/// A question about files that were read.
pub enum Question {
    Columns(Columns),
    Order(CategoryOrder),
}

impl Question {
    /// Asks what the columns mean, if they are not known. The factors are known only for result files and tables of
    /// counts.
    pub fn of_columns(ratings: &Ratings) -> Option<Self> {
        let form = Columns::of(ratings)?;
        let has = |name: &Option<String>, ours: &str| form.header.iter().any(|h| h == name.as_deref().unwrap_or(ours));
        let known = has(&ratings.how.subject, "subject_id") && has(&ratings.how.response, "rating");
        let with_factors = has(&ratings.how.count, "count") || has(&None, "phase");
        (!known || !with_factors).then_some(Self::Columns(form))
    }

    /// Asks for the order of the categories, if it is not known.
    pub fn of_order(study: &Study, ratings: &Ratings) -> Option<Self> {
        let (shape, counts) = (&study.source.shape, &study.measured.counts);
        let order = || CategoryOrder {
            ratings: ratings.clone(),
            response: shape.response.clone(),
            categories: counts.categories.clone(),
        };
        (!counts.is_ordered(shape.categories.as_deref())).then(|| Self::Order(order()))
    }

    /// Draws the question; returns how to read the files once the user has answered it.
    pub fn show(&mut self, ui: &mut egui::Ui) -> Option<Ratings> {
        match self {
            Self::Columns(form) => form.show(ui),
            Self::Order(list) => list.show(ui),
        }
    }
}

/// The form for the columns of one file.
pub struct Columns {
    /// What is chosen, except the factors.
    ratings: Ratings,
    file: PathBuf,
    /// The names that occur once.
    header: Vec<String>,
    factors: Vec<bool>,
}

impl Columns {
    /// Creates a form for the first CSV file among these paths, filled in with the previous choices; `None` if there is no
    /// such file.
    fn of(ratings: &Ratings) -> Option<Self> {
        let file = ratings.paths.iter().find_map(|path| first_csv(path))?;
        let header = header(&file)?;
        let known = |name: &Option<String>| name.clone().filter(|name| header.contains(name));
        let like = |names: &[&str]| {
            names.iter().find_map(|name| header.iter().find(|column| column.to_lowercase().contains(name))).cloned()
        };
        let count = header.iter().find(|column| COUNTS.contains(&column.to_lowercase().as_str())).cloned();
        let chosen = ratings.how.factors.clone().unwrap_or_default().0;
        let how = ReadOptions {
            subject: known(&ratings.how.subject).or_else(|| like(&SUBJECTS)),
            response: known(&ratings.how.response).or_else(|| like(&RESPONSES)),
            count: known(&ratings.how.count).or(count),
            ..ReadOptions::default()
        };
        let ratings = Ratings { paths: ratings.paths.clone(), how };
        let factors = header.iter().map(|name| chosen.contains(name)).collect();
        Some(Self { ratings, file, header, factors })
    }

    fn show(&mut self, ui: &mut egui::Ui) -> Option<Ratings> {
        section(ui, "What do the columns mean?");
        let name = self.file.file_name().unwrap_or(self.file.as_os_str()).to_string_lossy().into_owned();
        hint(ui, format!("{name} was not written by machband. Identify its columns."));
        let columns: Vec<Option<String>> = std::iter::once(None).chain(self.header.iter().cloned().map(Some)).collect();
        let mut choice = |label, chosen: &mut Option<String>, all: &[Option<String>], none: &str| {
            let text = |name: &Option<String>| name.clone().unwrap_or_else(|| none.to_owned());
            Field::new(label).column(150.0).width(300.0).choice(ui, chosen, all, text);
        };
        let ReadOptions { subject, response, count, .. } = &mut self.ratings.how;
        choice("Participant", subject, &columns[1..], "choose…");
        choice("Rating", response, &columns[1..], "choose…");
        choice("Number of trials", count, &columns, "one per row");
        let ReadOptions { subject, response, count, .. } = &self.ratings.how;
        // A column with another meaning is not a factor.
        let is_factor = |name: &&String| ![subject, response, count].into_iter().flatten().any(|other| other == *name);
        ui.label("Factors");
        hint(ui, "Select the columns that define the conditions.");
        ScrollArea::vertical().id_salt("factors").max_height(200.0).show(ui, |ui| {
            ui.horizontal_wrapped(|ui| {
                for (name, checked) in self.header.iter().zip(&mut self.factors).filter(|(name, _)| is_factor(name)) {
                    let response = ui.checkbox(checked, name);
                    label(ui, &response, &format!("Factor {name}"));
                }
            });
        });
        ui.add_space(4.0);
        let same = subject.is_some() && [response, count].contains(&subject) || response.is_some() && response == count;
        if same {
            show_error(ui, "One column is used twice. Choose a different column for each.");
        }
        let ready = subject.is_some() && response.is_some() && !same;
        let hint = if ready { "" } else { "Choose at least the participant and the rating." };
        primary(ui, "Read these columns", ready, hint).then(|| {
            let checked = self.header.iter().zip(&self.factors).filter(|(_, checked)| **checked).map(|(name, _)| name);
            let mut ratings = self.ratings.clone();
            ratings.how.factors = Some(List(checked.filter(is_factor).cloned().collect()));
            ratings
        })
    }
}

/// Returns the file itself, or the first CSV file of a folder; `None` also if it cannot be accessed, because reading it
/// says why.
fn first_csv(path: &Path) -> Option<PathBuf> {
    let is_file = |path: &Path| found(path).is_ok_and(|found| found.is_some_and(|found| found.is_file()));
    if is_file(path) {
        return Some(path.to_owned());
    }
    let is_csv = |path: &PathBuf| {
        let name = path.to_string_lossy().to_lowercase();
        [".csv", ".csv.gz"].iter().any(|ending| name.ends_with(ending))
    };
    entries(path).ok()?.into_iter().find(|path| is_csv(path) && is_file(path))
}

/// Returns the names in a file's first row that occur once; none if that row does not contain names. A column of row
/// numbers has no name.
fn header(file: &Path) -> Option<Vec<String>> {
    let mut names = column_names(file).ok()?;
    names.retain(|name| !name.is_empty());
    let is_single = |name: &&String| names.iter().filter(|other| other == name).count() == 1;
    (names.len() > 1).then(|| names.iter().filter(is_single).cloned().collect())
}

/// The list of categories that the user puts in order.
pub struct CategoryOrder {
    /// How the categories were read.
    ratings: Ratings,
    response: String,
    categories: Vec<String>,
}

impl CategoryOrder {
    fn show(&mut self, ui: &mut egui::Ui) -> Option<Ratings> {
        section(ui, "What is the order of the ratings?");
        hint(
            ui,
            format!(
                "The ratings in the column {} are words, so their order is not known. Move them into order, lowest first.",
                self.response
            ),
        );
        let last = self.categories.len() - 1;
        let mut moved = None;
        for (at, category) in self.categories.iter().enumerate() {
            // The ID belongs to the category, so that a button keeps keyboard focus when its category moves.
            ui.push_id(category, |ui| {
                ui.horizontal(|ui| {
                    for (way, to) in [("Up", at.checked_sub(1)), ("Down", (at < last).then_some(at + 1))] {
                        let button = ui.add_enabled(to.is_some(), Button::new(way));
                        label(ui, &button, &format!("{way}: {category}"));
                        if button.clicked() {
                            moved = to.map(|to| (at, to));
                        }
                    }
                    let end = match at {
                        0 => " (lowest)",
                        _ if at == last => " (highest)",
                        _ => "",
                    };
                    paragraph(ui, format!("{}. {category}{end}", at + 1));
                });
            });
        }
        if let Some((from, to)) = moved {
            self.categories.swap(from, to);
        }
        primary(ui, "Analyze in this order", true, "").then(|| {
            let mut ratings = self.ratings.clone();
            ratings.how.categories = Some(List(self.categories.clone()));
            ratings
        })
    }
}
