//! Floor 4: every file format, one file each. Errors carry file, line and column.
//!
//! Read: [`definition`], [`profile`], [`observer`] (TOML), [`obj`] (meshes), [`readings`] (CSV). Written while a session runs: [`results`]
//! and [`frames`] (CSV), [`sidecar`] and [`dataset`] (JSON), joined in [`session`], read back in [`recorded`] and proved in [`verify`](mod@verify). Exported: [`mod@export`] (BIDS, Psych-DS, PsychoPy, Parquet), [`image`] (PNG), [`curve`] (CSV) and
//! [`manifest`] (many images).

pub mod check;
pub mod curve;
pub mod dataset;
pub mod definition;
pub mod description;
pub mod export;
mod fault;
mod file;
pub mod frames;
mod hash;
pub mod image;
pub mod manifest;
pub mod matches;
pub mod obj;
pub mod observer;
pub mod picture;
pub mod pictures;
pub mod profile;
pub mod ratings;
pub mod readings;
pub mod recorded;
pub mod results;
pub mod session;
pub mod sidecar;
pub mod spreadsheet;
mod text;
mod toml_reader;
pub mod verify;

pub use fault::{FileFault, FileFaults, StoreError};
pub use file::{write_file, write_json};
