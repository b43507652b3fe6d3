//! Floor 6: what machband can do. One file per operation: a request goes in, a typed outcome comes out, and nothing is
//! printed.
//!
//! The commands, the window and the Python package are skins over this room. A [`Request`] is one struct, made
//! [from names](from_names) or by clap, and written back as [words]; a [`Watcher`] learns how far an operation is and
//! may end it. What an operation writes goes through the [`Writer`](crate::store::Writer) that its caller made.

mod analyze;
pub mod calibrate;
mod check;
pub mod compare;
pub mod criterion;
mod export;
mod findings;
mod image;
pub mod plan;
mod precision;
pub mod predict;
mod repair;
mod request;
pub mod shade;
pub mod simulate;
pub mod stimuli;
pub mod stimulus;
mod study;
pub mod verify;

pub use crate::system::today;
pub use analyze::{Analyze, Model, Ratings};
pub use check::Check;
pub use export::Export;
pub use image::{Drawn, Encoded, Encoding, Image, Luminances, outdated};
pub use repair::Repair;
pub use request::{
    FittedPath, Found, NewFolder, OutPath, Request, RequestError, Watcher, command, from_names, told, words,
};
pub use study::Study;
