//! Tests of light, screen, eye and stimulus: the numbers behind every picture.

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
    light::{LinearImage, Transfer, TransferTable},
    stimulus::{MachBand, Stimulus},
};

/// Returns the rows of a golden file: the text in the first column (empty if that is a number) and the numbers.
fn golden(file: &str) -> Vec<(String, Vec<f64>)> {
    let path = format!("{}/tests/golden/{file}", env!("CARGO_MANIFEST_DIR"));
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(path).unwrap();
    let rows = reader.records().map(|row| {
        let row = row.unwrap();
        let named = row[0].parse::<f64>().is_err();
        let numbers = row.iter().skip(usize::from(named)).map(|field| field.parse().unwrap()).collect();
        (if named { row[0].to_owned() } else { String::new() }, numbers)
    });
    rows.collect()
}

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
