//! Tests the pages of the window without a display.

#![cfg(feature = "window")]

#[path = "../common/mod.rs"]
mod common;
mod window;

mod analysis;
mod calibration;
mod display;
mod editor;
mod home;
mod names;
mod settings;
mod shading;
mod studies;
