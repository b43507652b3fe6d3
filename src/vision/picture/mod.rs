//! Prediction for an image, wherever its bands are and whichever way they run.

mod clear;
mod field;
mod image;
mod predict;
mod ridge;
mod spectrum;

pub use image::{BandMap, Picture, PictureView};
