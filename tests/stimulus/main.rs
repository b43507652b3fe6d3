//! Light, screen, eye and stimulus: the numbers below every picture.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/eye.rs"]
mod eye;

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
    light::{CodeImage, LinearImage, Quantizer},
    stimulus::{MachBand, Stimulus},
};

/// A Mach band drawn without saying each time that it is a stimulus.
trait Draw {
    fn linear(&self, size: u32) -> LinearImage;
    fn codes(&self, size: u32, quantizer: &Quantizer) -> CodeImage;
}

impl Draw for MachBand {
    fn linear(&self, size: u32) -> LinearImage {
        Stimulus::from(self.clone()).linear(size)
    }

    fn codes(&self, size: u32, quantizer: &Quantizer) -> CodeImage {
        Stimulus::from(self.clone()).codes(size, quantizer)
    }
}
