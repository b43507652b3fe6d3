//! Makes one stimulus as a PNG file: `cargo run --example make_stimulus`.

use std::path::Path;

use machband::{
    light::{Bits, Depth, Dither, Transfer},
    stimulus::{MachBand, Stimulus, StimulusColor, recipe::Recipe},
    store::{Writer, image},
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Everything is in linear light: a smooth gray ramp over half the window, rotated by 30°.
    let ramp = MachBand {
        width: 0.5,
        depth: Depth::finite(3)?,
        orientation_deg: 30.0,
        color: StimulusColor::GRAY,
        ..MachBand::default()
    };
    if let Err(faults) = ramp.validate() {
        return Err(faults[0].clone().into());
    }

    // Conversion to display codes. The dither keeps the shallow ramp free of visible steps.
    let recipe = Recipe {
        stimulus: Stimulus::MachBand(ramp),
        size: 512,
        transfers: Transfer::Srgb.into(),
        bits: Bits::Eight,
        dither: Dither::BlueNoise,
        seed: 1,
        display_sha256: None,
    };
    let path = Path::new("stimulus.png");
    image::write_recipe(&Writer::new([], true), path, &recipe, &recipe.quantizer())?;
    println!(
        "{} written; this command writes the same image:\n{}",
        path.display(),
        machband::work::stimulus::command(&recipe)
    );
    Ok(())
}
