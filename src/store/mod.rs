//! Floor 4: every file format. Errors include the file, line and column.
//!
//! | contents | module |
//! |---|---|
//! | writes, resumes, reads and verifies a session: its data set, rows, frames and sidecar | [`session`] |
//! | reads any table of ratings, or of answers at levels | [`ratings`], [`answers`] |
//! | exports recorded sessions as BIDS or Psych-DS | [`mod@export`] |
//! | PNG images, and folders of images | [`image`], [`manifest`] |
//! | OBJ, PLY and glTF meshes | [`mesh`] |
//! | edits a definition and keeps its comments | [`draft`] |
//! | definitions, display profiles and simulated observers (TOML) | [`definition`], [`profile`], [`observer`] |
//! | what the window remembers (TOML) | [`settings`] |
//! | photometer readings and visual matches (CSV) | [`readings`], [`mod@matches`] |
//! | identifies any file and finds all errors in it | [`check`](mod@check) |
//!
//! [`Writer`] writes every file that the user named. Private modules provide atomic and append-only files, and readers
//! of tables and TOML that keep track of locations.

pub mod check;
mod columns;
pub mod definition;
pub mod draft;
mod error;
pub mod export;
mod file;
pub mod image;
pub mod manifest;
mod mat;
pub mod matches;
pub mod mesh;
pub mod observer;
mod open;
mod output;
mod pictures;
pub mod profile;
pub mod ratings;
pub mod readings;
pub mod scene;
pub mod session;
pub mod settings;
pub mod table;
mod toml;

pub use columns::Columns;
pub use error::{FileError, FileErrors, StoreError};
pub use output::Writer;
pub use ratings::answers;
pub use session::{dataset, recorded, results, sidecar};
