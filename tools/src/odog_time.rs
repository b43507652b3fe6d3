//! How long ODOG takes, for `benches/odog_peers.py`.
//!
//! The picture is a linear ramp between plateaus. Prints the seconds for the filters and the median of five runs; writes
//! the response, float32 row by row, to FILE.

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use tools::baselines::Odog;

pub fn run(size: usize, px_per_deg: f64, file: Option<&Path>) -> Result<(), Box<dyn Error>> {
    let row = (0..size).map(|x| 0.25 + 0.5 * ((x as f32 / size as f32 - 0.4) / 0.2).clamp(0.0, 1.0));
    let light = row.collect::<Vec<_>>().repeat(size);

    let began = Instant::now();
    let filters = Odog::default().filters(size, size, px_per_deg).ok_or("no such picture")?;
    let construct_s = began.elapsed().as_secs_f64();
    let mut times = Vec::new();
    let mut response = Vec::new();
    for _ in 0..5 {
        let began = Instant::now();
        response = filters.respond(&light);
        times.push(began.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    println!("construct_s {construct_s:.6} run_s {:.6}", times[2]);
    if let Some(path) = file {
        std::fs::write(path, response.iter().flat_map(|value| value.to_ne_bytes()).collect::<Vec<_>>())?;
    }
    Ok(())
}
