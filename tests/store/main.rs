//! Tests of definitions, sessions and all files that they write.

#[path = "../common/mod.rs"]
mod common;

mod absence;
mod definitions;
mod drafts;
mod edits;
mod export;
mod folder;
mod frame_files;
mod fuzz_corpus;
mod integrity;
mod participants;
mod reading;
mod recording;
mod session;
mod tasks;
mod verify;
