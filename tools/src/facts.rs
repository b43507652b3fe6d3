//! What the model of vision says about ramps, edges and kinks, and how far that depends on each of its constants.

use std::error::Error;

use machband::{
    light::{Depth, TANH_K},
    vision::{Eye, Judge, Masking, RampBands, Sensitivity},
    work::criterion::rank_correlation,
};
use rayon::prelude::*;
use tools::thresholds::{CSF, NAMES, People, parameters, with};

const PX_PER_DEG: f64 = 64.0;
/// Half the length of the lines, degrees.
const HALF_DEG: f64 = 9.0;

/// The constants of the model.
#[derive(Clone, Copy)]
struct Model {
    sensitivity: Sensitivity,
    masking: Masking,
}

impl Model {
    /// The model in the code, and every model in which one constant is 20 % smaller or larger.
    fn all() -> Vec<(String, Model)> {
        let held = Model { sensitivity: Sensitivity::default(), masking: Masking::default() };
        let mut all = vec![("as in the code".to_owned(), held)];
        for factor in [0.8, 1.2] {
            for (k, name) in NAMES.iter().enumerate() {
                let mut values = parameters(&held.sensitivity);
                values[k] *= factor;
                all.push((format!("{name} × {factor}"), Model { sensitivity: with(&values), ..held }));
            }
            let Masking { adaptation_deg, ratio, half } = held.masking;
            for (name, masking) in [
                ("adaptation_deg", Masking { adaptation_deg: adaptation_deg * factor, ..held.masking }),
                // The ratio's logarithm is the bandwidth.
                ("bandwidth", Masking { ratio: ratio.powf(factor), ..held.masking }),
                ("half", Masking { half: half * factor, ..held.masking }),
            ] {
                all.push((format!("{name} × {factor}"), Model { masking, ..held }));
            }
        }
        all
    }

    fn judge(&self, luminance: f64) -> Result<Judge, Box<dyn Error>> {
        let eye = Eye { luminance, sensitivity: self.sensitivity, masking: self.masking };
        Ok(Judge::of_lines((2.0 * HALF_DEG * PX_PER_DEG) as usize, PX_PER_DEG, 0.0, eye)?)
    }
}

/// A line of light, averaged over each pixel; positions are in degrees from its middle.
fn line(light: impl Fn(f64) -> f64) -> Vec<f64> {
    let at = |i: u32| (f64::from(i) + 0.5) / 8.0 / PX_PER_DEG - HALF_DEG;
    let pixel = |i: u32| (8 * i..8 * i + 8).map(|k| light(at(k))).sum::<f64>() / 8.0;
    (0..(2.0 * HALF_DEG * PX_PER_DEG) as u32).map(pixel).collect()
}

/// A ramp of this contrast around 50 cd/m².
fn ramp(depth: u8, width: f64, contrast: f64) -> Vec<f64> {
    let of = |x: f64| Depth::Finite(depth).interpolation(x / width + 0.5, TANH_K);
    line(|x| 50.0 * (1.0 + contrast * (2.0 * of(x) - 1.0)))
}

/// The figures, in the order of [`ROWS`].
const ROWS: [&str; 15] = [
    "bright band of a linear ramp of 1°, ¼ to ¾",
    "its dark band",
    "bright band at n = 2",
    "bright band at n = 3",
    "bright band of a step (people: none)",
    "of blurred edges, σ 0.05 to 1° (people: none)",
    "of an edge more pointed than a Gaussian, exponential with 0.2° (people: none)",
    "width of the strongest bright band, degrees (Bangay's people: 0.5 to 1)",
    "contrast from 20 % to 80 %: bright band × (Wallis & Georgeson 2012: little)",
    "rank correlation of the widths 0.2 to 4° with twice the size (the same: little)",
    "widths of 0.1 to 8° at which a larger n has a stronger band, of 60",
    "a bar of +20 %, 0.1° wide, 0.2° beside the band: bright band × (Ratliff et al. 1983: below 1)",
    "the same bar of −20 %",
    "isolated kink, per contrast/degree, rounded within 4°",
    "within 8°",
];

fn figures(model: &Model) -> Result<Vec<f64>, Box<dyn Error>> {
    let judge = model.judge(50.0)?;
    let bands = |light: &[f64]| RampBands::of(&judge, light);
    let one = bands(&ramp(1, 1.0, 0.5))?;
    let bright = |depth, width, contrast| Ok::<f64, Box<dyn Error>>(bands(&ramp(depth, width, contrast))?.bright);
    let normal = |x: f64| 0.5 * (1.0 + statrs::function::erf::erf(x / std::f64::consts::SQRT_2));
    let mut blurred: f64 = 0.0;
    for sigma in [0.05, 0.1, 0.2, 0.5, 1.0] {
        blurred = blurred.max(bands(&line(|x| 25.0 + 50.0 * normal(x / sigma)))?.bright);
    }
    let pointed = bands(&line(|x| 50.0 + 25.0 * x.signum() * -(-x.abs() / 0.2).exp_m1()))?.bright;
    let widths: Vec<f64> = (0..60).map(|k| 0.1 * 80_f64.powf(f64::from(k) / 59.0)).collect();
    let at = |depth: u8| widths.iter().map(|width| bright(depth, *width, 0.5)).collect::<Result<Vec<f64>, _>>();
    let (first, others) = (at(1)?, [at(2)?, at(3)?, at(4)?]);
    let best = (0..60).max_by(|a, b| first[*a].total_cmp(&first[*b])).unwrap_or(0);
    let pairs = [(&first, &others[0]), (&others[0], &others[1]), (&others[1], &others[2])];
    let stronger = (0..60).filter(|i| pairs.iter().any(|(lower, higher)| higher[*i] > lower[*i])).count();
    let sizes = |scale: f64| {
        let widths = [0.2, 0.4, 0.8, 1.2, 1.6, 2.4, 4.0].map(|width| scale * width);
        widths.iter().map(|width| bright(1, *width, 0.5)).collect::<Result<Vec<f64>, _>>()
    };
    let rho = rank_correlation(&sizes(1.0)?, &sizes(2.0)?).unwrap_or(f64::NAN);
    // The bar is in both pictures, so that it only masks.
    let edge = |blur: f64| move |x: f64| 25.0 + 50.0 * normal(x / blur);
    let barred = |amount: f64| {
        let bar = |x: f64| if (0.7..0.8).contains(&x) { amount } else { 0.0 };
        let ramp = line(|x| 50.0 * (1.0 + 0.5 * (2.0 * (x + 0.5).clamp(0.0, 1.0) - 1.0)) * (1.0 + bar(x)));
        let reference = line(|x| edge(one.blur_deg)(x) * (1.0 + bar(x)));
        let part = |x: f64, response: f64| if x > 0.5 { response.max(0.0) } else { 0.0 };
        Ok::<f64, Box<dyn Error>>(judge.difference(&ramp, &reference, None)?.map_of(part).largest())
    };
    let plain = barred(0.0)?;
    let kink = |reach: f64| {
        const SLOPE: f64 = 0.001;
        let rounded = |x: f64| {
            let t = ((x / reach + 1.0) / 2.0).max(0.0);
            if t < 1.0 { reach * t * t } else { x }
        };
        let (sharp, smooth) =
            (line(|x| 50.0 * (1.0 + SLOPE * x.max(0.0))), line(|x| 50.0 * (1.0 + SLOPE * rounded(x))));
        Ok::<f64, Box<dyn Error>>(judge.difference(&sharp, &smooth, None)?.map().largest() / SLOPE)
    };
    Ok(vec![
        one.bright,
        one.dark,
        bright(2, 1.0, 0.5)?,
        bright(3, 1.0, 0.5)?,
        bands(&line(|x| if x < 0.0 { 25.0 } else { 75.0 }))?.bright,
        blurred,
        pointed,
        widths[best],
        bright(1, 1.0, 0.8)? / bright(1, 1.0, 0.2)?,
        rho,
        stronger as f64,
        barred(0.2)? / plain,
        barred(-0.2)? / plain,
        kink(4.0)?,
        kink(8.0)?,
    ])
}

/// Prints each figure with its range over the models in which one constant is 20 % smaller or larger.
///
/// # Errors
/// Returns an error if the measurements of people cannot be read.
pub fn run() -> Result<(), Box<dyn Error>> {
    let people = People::read()?;
    let all = Model::all();
    let found: Vec<Vec<f64>> = all
        .par_iter()
        .map(|(_, model)| {
            let errors = people.errors(&model.sensitivity);
            let edges = people.edges(&model.sensitivity, &model.masking);
            let squares: Vec<f64> = edges.iter().map(|(error, _)| error * error).collect();
            let mut all = figures(model).map_err(|error| error.to_string())?;
            all.extend([people.rms(&errors, &["modelfest"]), people.rms(&errors, &CSF)]);
            all.push((squares.iter().sum::<f64>() / squares.len() as f64).sqrt());
            Ok(all)
        })
        .collect::<Result<_, String>>()?;
    let thresholds = ["ModelFest, rms log10", "contrast sensitivity, rms log10", "eight edges, rms log10"];
    println!("| figure | as in the code | one constant ± 20 % | most by |\n|---|--:|--:|---|");
    for (row, name) in ROWS.iter().chain(&thresholds).enumerate() {
        let values: Vec<f64> = found.iter().map(|of| of[row]).collect();
        let (low, high) =
            (values.iter().copied().fold(f64::MAX, f64::min), values.iter().copied().fold(f64::MIN, f64::max));
        let most =
            (0..values.len()).max_by(|a, b| (values[*a] - values[0]).abs().total_cmp(&(values[*b] - values[0]).abs()));
        let most = most.filter(|i| values[*i] != values[0]).map_or("–", |i| all[i].0.as_str());
        println!("| {name} | {:.3} | {low:.3}…{high:.3} | {most} |", values[0]);
    }
    Ok(())
}
