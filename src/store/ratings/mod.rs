//! Reads ratings from files: machband's own result files and tables of counts, folders of these, or any CSV file in
//! long format if its columns are specified.
//!
//! Rows are streamed twice: first to find out which rows count and what the columns contain, then to pass the ratings
//! on. Only eight bytes are kept for each row of a result file, in order to find the last attempt at each trial. Practice rows of a result file are excluded, only the last attempt at each trial counts, and the ratings
//! of an unfinished session count by default. [`Source`] reports all of this.

mod files;
mod reader;
mod row;
mod selection;
mod source;
mod survey;
mod trials;

pub use files::{column_names, data_files, with_files};
pub use reader::{read, read_columns};
pub use source::{FileRead, Layout, ReadOptions, SessionRead, Shape, Source};
