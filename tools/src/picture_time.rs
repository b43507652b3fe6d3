//! How long the vision model takes for a picture, for `benches/odog_peers.py`.
//!
//! The picture is a linear ramp between plateaus, as in `odog_time.rs`. It prints the median of seven runs; there
//! is nothing to construct.

use std::{error::Error, time::Instant};

use machband::vision::{Eye, Picture};

pub fn run(size: usize, px_per_deg: f64) -> Result<(), Box<dyn Error>> {
    let row = (0..size).map(|x| 0.25 + 0.5 * ((x as f64 / size as f64 - 0.4) / 0.2).clamp(0.0, 1.0));
    let light = row.collect::<Vec<_>>().repeat(size);
    let picture = Picture { light: &light, width: size, height: size, px_per_deg, mask: None };
    let mut times = Vec::new();
    for _ in 0..7 {
        let began = Instant::now();
        std::hint::black_box(picture.see(&Eye::default())?);
        times.push(began.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    println!("construct_s 0.000000 run_s {:.6}", times[3]);
    Ok(())
}
