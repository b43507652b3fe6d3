//! Floor 4: every file format, one file each. Errors carry file, line and column.
//!
//! Read: [`definition`], [`profile`], [`observer`] (TOML), [`mesh`] (OBJ), [`readings`] (CSV). Written while a session runs: [`results`]
//! and [`frames`] (CSV), [`sidecar`] and [`dataset`] (JSON), joined in [`session`], read back in [`recorded`] and proved in [`verify`](mod@verify). Exported: [`mod@export`] (BIDS, Psych-DS), [`image`] (PNG), [`curve`] (CSV) and
//! [`manifest`] (many images).

pub mod check;
pub mod curve;
pub mod definition;
pub mod export;
mod fault;
mod file;
mod hash;
pub mod image;
pub mod manifest;
pub mod matches;
pub mod mesh;
pub mod observer;
pub mod profile;
pub mod ratings;
pub mod readings;
pub mod session;
pub mod table;
mod text;
mod toml;

pub use fault::{FileFault, FileFaults, StoreError};
pub use file::{write_file, write_json};
pub use session::{dataset, description, frames, pictures, recorded, results, sidecar, verify};
