//! Ratings from files: our result files and counts, folders of them, or any long CSV whose columns are named.
//!
//! Rows stream by. What is kept of them here is eight bytes for each row of a result file, to know which attempt of a
//! trial is the last. Of a result file the practice rows are left out, of every trial only the last attempt counts, and
//! the ratings of an unfinished session count unless told otherwise; all of it is reported in [`Source`].

mod files;
mod reader;
mod row;
mod selection;
mod source;
mod trials;

pub use files::data_files;
pub use reader::read;
pub use source::{FileRead, Layout, ReadOptions, SessionRead, Shape, Source};
