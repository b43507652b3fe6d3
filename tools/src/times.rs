//! Times models of vision on an image of a linear ramp between plateaus, for `benches/odog_peers.py`.

use std::{error::Error, path::Path, time::Instant};

use machband::vision::{Eye, Picture};
use tools::baselines::Odog;

/// The median time of `runs` runs, in seconds.
fn median(runs: usize, mut run: impl FnMut() -> Result<(), Box<dyn Error>>) -> Result<f64, Box<dyn Error>> {
    let mut times = Vec::new();
    for _ in 0..runs {
        let began = Instant::now();
        run()?;
        times.push(began.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    Ok(times[runs / 2])
}

/// One row of the ramp.
fn ramp(size: usize) -> impl Iterator<Item = f64> {
    (0..size).map(move |x| 0.25 + 0.5 * ((x as f64 / size as f64 - 0.4) / 0.2).clamp(0.0, 1.0))
}

/// Times ODOG: prints the seconds for the filters and the median of five runs. Writes the response to `file` as float32,
/// row by row.
pub fn odog(size: usize, px_per_deg: f64, file: Option<&Path>) -> Result<(), Box<dyn Error>> {
    let light = ramp(size).map(|light| light as f32).collect::<Vec<_>>().repeat(size);
    let began = Instant::now();
    let filters = Odog::default().filters(size, size, px_per_deg).ok_or("a picture without pixels")?;
    let construct_s = began.elapsed().as_secs_f64();
    let mut response = Vec::new();
    let run_s = median(5, || {
        response = filters.respond(&light);
        Ok(())
    })?;
    println!("construct_s {construct_s:.6} run_s {run_s:.6}");
    if let Some(path) = file {
        std::fs::write(path, response.iter().flat_map(|value| value.to_ne_bytes()).collect::<Vec<_>>())?;
    }
    Ok(())
}

/// Times machband's own model: prints the median of seven runs. There is nothing to construct.
pub fn picture(size: usize, px_per_deg: f64) -> Result<(), Box<dyn Error>> {
    let light = ramp(size).collect::<Vec<_>>().repeat(size);
    let picture = Picture { light: &light, width: size, height: size, px_per_deg, mask: None };
    let run_s = median(7, || {
        std::hint::black_box(picture.predict(&Eye::default())?);
        Ok(())
    })?;
    println!("construct_s 0.000000 run_s {run_s:.6}");
    Ok(())
}
