//! Documents consist of sections of blocks. A document is built once and can be shown by every skin; [`numbers`]
//! formats its numbers as in a paper.

pub mod numbers;

pub use numbers::{
    Shown, count, either, fixed, list, mean, p_is, percent, probability, range, ratio, short_list, significant, times,
    unit, whole, whole_percent, with_interval,
};

use crate::{report::figures::Figure, store::FileError};

#[derive(Clone, Debug, PartialEq)]
pub struct Document {
    pub title: String,
    /// The line below the title.
    pub subtitle: String,
    /// Sections, in reading order.
    pub sections: Vec<Section>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// Anchor within the document.
    pub id: &'static str,
    pub heading: &'static str,
    pub blocks: Vec<Block>,
}

/// A part of a section.
#[derive(Clone, Debug, PartialEq)]
pub enum Block {
    /// A heading within a section.
    Heading(String),
    /// A paragraph.
    Text(String),
    /// A paragraph of secondary importance.
    Note(String),
    /// A paragraph that readers must not miss.
    Warning(String),
    /// Items of equal rank.
    List(Vec<String>),
    /// Text to copy verbatim.
    Code(String),
    Table(TextTable),
    /// A chart.
    Figure(Figure),
}

/// A table of formatted values.
#[derive(Clone, Debug, PartialEq)]
pub struct TextTable {
    /// What it shows.
    pub caption: String,
    /// Names of the columns.
    pub header: Vec<String>,
    /// Number of columns, from the left, that contain text; the others contain numbers.
    pub texts: usize,
    /// Cells, one per column.
    pub rows: Vec<Vec<Shown>>,
}

/// A table that is made of columns, each with its heading and the cell of every row: first those of text, then those of
/// numbers.
pub struct TableOf<'a, R> {
    rows: &'a [R],
    table: TextTable,
}

impl<'a, R> TableOf<'a, R> {
    /// Begins a table of these rows.
    pub fn new(caption: impl Into<String>, rows: &'a [R]) -> Self {
        let cells = vec![Vec::new(); rows.len()];
        Self { rows, table: TextTable { caption: caption.into(), header: Vec::new(), texts: 0, rows: cells } }
    }

    /// Adds a column of text.
    pub fn text<C: Into<Shown>>(mut self, heading: impl Into<String>, cell: impl Fn(&'a R) -> C) -> Self {
        self.table.texts += 1;
        self.number(heading, cell)
    }

    /// Adds a column of numbers.
    pub fn number<C: Into<Shown>>(mut self, heading: impl Into<String>, cell: impl Fn(&'a R) -> C) -> Self {
        self.table.header.push(heading.into());
        self.table.rows.iter_mut().zip(self.rows).for_each(|(cells, row)| cells.push(cell(row).into()));
        self
    }

    /// Adds the table to a section.
    pub fn add_to(self, section: &mut Section) {
        section.blocks.push(Block::Table(self.into()));
    }
}

impl<R> From<TableOf<'_, R>> for TextTable {
    fn from(table: TableOf<'_, R>) -> Self {
        table.table
    }
}

impl Section {
    /// Creates a section without blocks.
    pub fn new(id: &'static str, heading: &'static str) -> Self {
        Self { id, heading, blocks: Vec::new() }
    }

    pub fn heading(&mut self, text: impl Into<String>) {
        self.blocks.push(Block::Heading(text.into()));
    }

    pub fn text(&mut self, text: impl Into<String>) {
        self.blocks.push(Block::Text(text.into()));
    }

    pub fn note(&mut self, text: impl Into<String>) {
        self.blocks.push(Block::Note(text.into()));
    }

    pub fn warning(&mut self, text: impl Into<String>) {
        self.blocks.push(Block::Warning(text.into()));
    }

    pub fn code(&mut self, text: impl Into<String>) {
        self.blocks.push(Block::Code(text.into()));
    }

    /// Adds a list, unless it is empty.
    pub fn list(&mut self, items: Vec<String>) {
        if !items.is_empty() {
            self.blocks.push(Block::List(items));
        }
    }

    /// Adds a table of names and their values.
    pub fn facts<S: Into<Shown>, V: Into<Shown>>(&mut self, caption: &str, rows: impl IntoIterator<Item = (S, V)>) {
        let rows: Vec<[Shown; 2]> = rows.into_iter().map(|(name, value)| [name.into(), value.into()]).collect();
        let table = TableOf::new(caption, &rows);
        table.text("What", |[name, _]| name.clone()).text("Value", |[_, value]| value.clone()).add_to(self);
    }

    /// Lists what is wrong with the files, and what should be known about them.
    pub fn problems(&mut self, errors: &[FileError], warnings: &[FileError]) {
        for (problems, what) in [
            (errors, "Rows or sessions with errors were left out; the rest was analyzed."),
            (warnings, "These files were analyzed despite the following warnings."),
        ] {
            if !problems.is_empty() {
                self.warning(what);
                self.list(problems.iter().map(ToString::to_string).collect());
            }
        }
    }

    /// Adds the charts with these names, in this order.
    pub fn figures(&mut self, figures: &[Figure], names: &[&str]) {
        let named = names.iter().filter_map(|name| figures.iter().find(|figure| figure.name == *name));
        self.blocks.extend(named.cloned().map(Block::Figure));
    }
}
