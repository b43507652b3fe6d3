//! A stimulus' luminance profile as CSV.

use std::path::Path;

use super::{StoreError, fault::io};
use crate::{light::Quantizer, stimulus::Stimulus};

/// Writes `x, linear, code_r, code_g, code_b, emitted` for `size` samples at pixel centres across the ramp, through
/// the centre. `linear` is the light asked of the strongest channel and `emitted` the light of its code.
///
/// # Errors
/// The system's refusal.
pub fn write_profile(path: &Path, stimulus: &Stimulus, size: u32, quantizer: &Quantizer) -> Result<(), StoreError> {
    let strongest = stimulus.strongest_channel();
    let failed = |error: csv::Error| io(path, "write")(std::io::Error::other(error));
    let file = std::fs::File::create(path).map_err(io(path, "create"))?;
    let mut writer = csv::Writer::from_writer(std::io::BufWriter::new(file));
    writer.write_record(["x", "linear", "code_r", "code_g", "code_b", "emitted"]).map_err(failed)?;
    for i in 0..size {
        let x = (2.0 * f64::from(i) + 1.0 - f64::from(size)) / (2.0 * f64::from(size));
        let light = stimulus.light_at(x);
        let codes = light.map(|linear| quantizer.code(linear));
        writer
            .write_record([
                x.to_string(),
                light[strongest].to_string(),
                codes[0].to_string(),
                codes[1].to_string(),
                codes[2].to_string(),
                quantizer.linear(codes[strongest]).to_string(),
            ])
            .map_err(failed)?;
    }
    writer.flush().map_err(io(path, "write"))
}
