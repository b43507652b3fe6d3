//! Tests of the command line, run as a user runs it.

#[path = "../common/mod.rs"]
mod common;

mod analyze;
mod basics;
mod calibrate;
mod compare;
#[cfg(target_os = "linux")]
mod limits;
mod outputs;
mod plan;
mod requests;
mod security;
mod shade;
