//! Floor 4: every file format. Faults carry file, line and column.
//!
//! | what | where |
//! |---|---|
//! | a session's data set, rows, frames and sidecar: writing, resuming, reading, verifying | [`session`] |
//! | any table of ratings | [`ratings`] |
//! | recorded sessions as BIDS or Psych-DS | [`mod@export`] |
//! | images (PNG), and many of them | [`image`], [`manifest`] |
//! | meshes (OBJ) | [`mesh`] |
//! | definitions, display profiles, simulated observers (TOML) | [`definition`], [`profile`], [`observer`] |
//! | photometer readings, matches by eye, profiles of a stimulus (CSV) | [`readings`], [`mod@matches`], [`curve`] |
//! | identifying any file and finding all its faults | [`check`](mod@check) |
//!
//! Below these: atomic and append-only files, and tables and TOML with locations.

pub mod check;
pub mod curve;
pub mod definition;
pub mod export;
mod fault;
mod file;
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
mod toml;

pub use fault::{FileFault, FileFaults, StoreError};
pub use file::{write_file, write_json};
pub use session::{dataset, frames, recorded, results, sidecar, verify};
