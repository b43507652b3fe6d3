//! Tests of light, screen, eye and stimulus: the numbers behind every picture.

#[path = "../common/mod.rs"]
mod common;

mod calibrate;
mod catalog;
mod color;
mod dither;
mod images;
mod light;
mod matching;
mod palette;
mod ramp;
mod timing;
mod vision;

use machband::{
    light::{LinearImage, Transfer, TransferTable},
    stimulus::{MachBand, Stimulus},
};

/// Returns transfer functions of several kinds, with exponents below and above 1.
fn transfers() -> Vec<Transfer> {
    let table = TransferTable::new(vec![0.0, 0.1, 0.35, 0.8, 1.0], vec![0.0, 0.004, 0.11, 0.55, 1.0]).unwrap();
    [Transfer::Linear, Transfer::Srgb, Transfer::Gamma(2.2), Transfer::Gamma(0.45), Transfer::Table(table)].into()
}

/// Draws a Mach band without converting it to a stimulus first.
trait Draw {
    fn linear(&self, size: u32) -> LinearImage;
}

impl Draw for MachBand {
    fn linear(&self, size: u32) -> LinearImage {
        Stimulus::from(self.clone()).linear(size)
    }
}
