//! Reads ratings from files: machband's own result files and tables of counts, folders of these, or any table
//! (CSV or Excel, long or wide) if its columns are specified. [`answers`] are read from such files, too.
//!
//! Each file is read once, into columns in which equal texts are stored once. What a column means is decided when all rows
//! are in memory. Practice rows of a result file are excluded, only the last attempt at each trial counts, and the ratings
//! of an unfinished session count by default. [`Source`] reports all of this.

pub mod answers;
mod cells;
mod files;
mod reader;
mod rows;
mod selection;
mod source;

pub use files::{Listed, column_names, files, with_files};
pub use reader::{read, read_columns};
pub use source::{FileRead, Levels, ReadOptions, Reason, SessionRead, Shape, Source, TimeLimits};
