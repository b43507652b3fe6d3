//! Ratings from files: our result files and counts, folders of them, or any long-format CSV with given columns.
//!
//! Rows are streamed. Only eight bytes are kept for each row of a result file, to find the last attempt of each trial.
//! Practice rows of a result file are excluded, only the last attempt of each trial counts, and the ratings of an
//! unfinished session count by default; [`Source`] reports all of this.

mod files;
mod reader;
mod row;
mod selection;
mod source;
mod trials;

pub use files::data_files;
pub use reader::read;
pub use source::{FileRead, Layout, ReadOptions, SessionRead, Shape, Source};
