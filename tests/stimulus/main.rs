//! Light, screen, eye and stimulus: the numbers below every picture.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/eye.rs"]
mod eye;

mod calibrate;
mod catalog;
mod color;
mod dither;
mod draw;
mod images;
mod light;
mod matching;
mod palette;
mod ramp;
mod shot;
mod timing;
mod vision;
