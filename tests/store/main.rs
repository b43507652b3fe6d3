//! Tests of definitions, sessions and all files that they write.

#[path = "../common/mod.rs"]
mod common;

mod absence;
mod definitions;
mod edits;
mod export;
mod folder;
mod integrity;
mod participants;
mod reading;
mod recording;
mod session;
mod tasks;
