//! A Mach band drawn without saying each time that it is a stimulus.

use machband::{
    light::{CodeImage, LinearImage, Quantizer},
    stimulus::{MachBand, Stimulus},
};

pub trait Draw {
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
