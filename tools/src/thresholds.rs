//! The detection model, compared with measured thresholds of people: the fit of its parameters and the tables of
//! `docs/models.md`.

use std::{
    error::Error,
    f64::consts::{PI, TAU},
    path::Path,
};

use machband::vision::{ContrastSpectrum, Eye, Judge, Masking, Sensitivity};
use nalgebra::{DMatrix, DVector};
use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng as _};
use rand_distr::{Distribution as _, StandardNormal};
use rayon::prelude::*;
use serde::Deserialize;
use sha2::{Digest, Sha256};

/// Names, as in [`Sensitivity`], of the parameters that are fitted without noise.
pub const NAMES: [&str; 8] =
    ["gain", "fine_cpd", "fine_power", "coarse_power", "pooling", "fovea_deg", "fovea_power", "bright_power"];
/// Weight of a residual: of ModelFest, whose values are means of 16 observers, relative to a threshold of one paper.
const MODELFEST_WEIGHT: f64 = 2.0;
/// Weight of the two edges without noise.
const EDGE_WEIGHT: f64 = 3.0;
/// Weight of the trapezoidal gratings: people's thresholds double with the width of wide ramps.
const TRAPEZOID_WEIGHT: f64 = 5.0;
/// Weight of the mean error in an octave of frequency: few coarse gratings were measured, and they count as much.
const OCTAVE_WEIGHT: f64 = 2.0;
/// Widths of the ramps that enter the fit, degrees.
const FITTED_WIDTHS: [f64; 3] = [0.5, 1.0, 2.0];
/// Luminances and areas that the model covers, cd/m² and degrees².
const LUMINANCES: [f64; 2] = [1.0, 1000.0];
const AREAS: [f64; 2] = [0.01, 100.0];
/// Lapse rate of the psychometric function of an observer, and the share of correct responses at threshold.
const LAPSES: f64 = 0.01;
const AT_THRESHOLD: f64 = 0.84;
/// Root mean square contrast of the noise.
const NOISE_RMS: f64 = 0.2;
/// Luminance of the field of the edges, cd/m².
const EDGE_CD_M2: f64 = 100.0;
/// Pixels per degree, and side in degrees, of the pictures of edges.
const EDGE_PX_PER_DEG: f64 = 44.0;
const EDGE_DEG: f64 = 4.0;
const EDGE_SIDE: usize = (EDGE_DEG * EDGE_PX_PER_DEG) as usize;
/// Samples of noise for each edge.
const SAMPLES: u64 = 8;
/// A contrast so small that the response is proportional to it.
const FAINT: f64 = 1e-3;

/// A stimulus whose threshold was measured.
pub struct Measured {
    /// `modelfest`, `edges`, or the name of a data set of contrast sensitivity.
    pub set: String,
    /// Describes the stimulus.
    pub label: String,
    /// log10 of the measured contrast sensitivity.
    pub log_sensitivity: f64,
    /// Its frequency, if it is a stimulus of contrast sensitivity that has one.
    frequency_cpd: Option<f64>,
    luminance: f64,
    spectrum: ContrastSpectrum,
}

/// An edge in noise, and the responses of people.
pub struct Edge {
    /// `none`, `white` or `pink`.
    pub noise: String,
    /// Width of the ramps on both sides, degrees.
    pub width_deg: f64,
    /// Contrast, number of correct responses and number of trials.
    pub counts: Vec<[f64; 3]>,
    /// The edge with a root mean square contrast of 1, row by row, and its spectrum.
    contrast: Vec<f64>,
    spectrum: ContrastSpectrum,
}

/// All measurements.
pub struct People {
    /// The stimuli without noise.
    pub measured: Vec<Measured>,
    /// The edges, with and without noise.
    pub edges: Vec<Edge>,
    /// Trapezoidal gratings with the ramps of [`FITTED_WIDTHS`].
    trapezoids: Vec<ContrastSpectrum>,
}

/// Predicts the detection of a spectrum of contrast on a field of a luminance, cd/m².
type Detect<'a> = dyn Fn(&ContrastSpectrum, f64) -> f64 + 'a;

/// The model that machband holds, with these parameters.
fn ours(sensitivity: &Sensitivity) -> impl Fn(&ContrastSpectrum, f64) -> f64 {
    move |spectrum, luminance| spectrum.detection(&Eye { sensitivity: *sensitivity, ..Eye::adapted_to(luminance) })
}

/// A filter whose response is pooled as in our model. Noise has no effect.
fn filter(gain: impl Fn(f64, f64) -> f64) -> impl Fn(&ContrastSpectrum, f64) -> f64 {
    move |spectrum, luminance| spectrum.pooled(&Sensitivity::default(), |frequency| gain(frequency, luminance))
}

#[derive(Deserialize)]
struct ModelFestRow {
    id: String,
    kind: String,
    frequency_cpd: Option<f64>,
    frequency2_cpd: Option<f64>,
    sigma_across_bars_deg: f64,
    sigma_along_bars_deg: f64,
    orientation: String,
    mean_log10_sensitivity: f64,
}

#[derive(Deserialize)]
struct CsfRow {
    dataset: String,
    frequency_cpd: f64,
    luminance_cd_m2: f64,
    sigma_deg: f64,
    area_deg2: f64,
    log10_sensitivity: f64,
}

#[derive(Deserialize)]
struct EdgeRow {
    noise: String,
    ramp_width_deg: f64,
    rms_contrast: f64,
    correct: f64,
    trials: f64,
}

/// The folder with the measurements.
fn folder() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/golden/human"))
}

const FILES: [&str; 3] = ["modelfest.csv", "csf.csv", "edges.csv"];

fn rows<T: serde::de::DeserializeOwned>(file: &str) -> Result<Vec<T>, Box<dyn Error>> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(folder().join(file))?;
    Ok(reader.deserialize().collect::<Result<_, _>>()?)
}

/// Samples a pattern of contrast on `side` × `side` pixels; positions are in degrees from the middle, right and up.
fn sampled(side: usize, px_per_deg: f64, pattern: impl Fn(f64, f64) -> f64 + Sync) -> Vec<f64> {
    // The middle is a pixel: ModelFest's line is one pixel wide.
    let at = |i: usize| (i as f64 - (side / 2) as f64) / px_per_deg;
    (0..side * side).into_par_iter().map(|i| pattern(at(i % side), -at(i / side))).collect()
}

/// The value of a Gaussian of peak 1.
fn gauss(x: f64, sigma: f64) -> f64 {
    (-0.5 * (x / sigma).powi(2)).exp()
}

/// Pixels per side and per degree of ModelFest's pictures.
const MODELFEST: (usize, f64) = (256, 120.0);

fn modelfest(row: &ModelFestRow) -> Result<Measured, Box<dyn Error>> {
    let wave = |frequency: Option<f64>, x: f64| (TAU * frequency.unwrap_or(0.0) * x).cos();
    let (f, f2) = (row.frequency_cpd, row.frequency2_cpd);
    let (across, along) = (row.sigma_across_bars_deg, row.sigma_along_bars_deg);
    let (side, px_per_deg) = MODELFEST;
    let window = |x: f64, y: f64| gauss(y, across) * gauss(x, along);
    let of = |pattern: &(dyn Fn(f64, f64) -> f64 + Sync)| sampled(side, px_per_deg, pattern);
    let mut contrast = match (row.kind.as_str(), row.orientation.as_str()) {
        ("gabor", "horizontal bars") => of(&|x, y| window(x, y) * wave(f, y)),
        ("gabor", "vertical bars") => of(&|x, y| window(y, x) * wave(f, x)),
        ("compound gabor", _) => of(&|x, y| window(x, y) * 0.5 * (wave(f, y) + wave(f2, y))),
        ("gaussian", _) => of(&window),
        ("edge", _) => of(&|x, y| window(x, y) * if y >= 0.0 { 1.0 } else { -1.0 }),
        ("line", _) => of(&|x, y| if y.abs() < 0.5 / px_per_deg { gauss(x, along) } else { 0.0 }),
        ("gabor string", _) => of(&|x, y| {
            (-2..=2).map(|k| gauss(x - 5.0 * along * f64::from(k), along)).sum::<f64>() * gauss(y, across) * wave(f, y)
        }),
        ("plaid", "0 and 90 degrees") => of(&|x, y| window(x, y) * 0.5 * (wave(f, x) + wave(f, y))),
        ("plaid", _) => of(&|x, y| window(x, y) * 0.5 * (wave(f, (x + y) / 2_f64.sqrt()) + wave(f, y))),
        ("checkerboard", _) => of(&|x, y| {
            // The fundamental runs along the diagonals.
            let sign = |x: f64| (PI * 2_f64.sqrt() * f.unwrap_or(0.0) * x + 1e-9).sin().signum();
            window(x, y) * sign(x) * sign(y)
        }),
        (kind, orientation) => return Err(format!("{kind}, {orientation}: unknown stimulus").into()),
    };
    // The threshold is that of the picture with its own mean, as `machband predict --image` sees it.
    let mean = contrast.iter().sum::<f64>() / contrast.len() as f64;
    contrast.iter_mut().for_each(|value| *value -= mean);
    Ok(Measured {
        set: "modelfest".into(),
        label: format!("{} {}", row.id, row.kind),
        log_sensitivity: row.mean_log10_sensitivity,
        frequency_cpd: None,
        luminance: 30.0,
        spectrum: ContrastSpectrum::of(&contrast, [side; 2], px_per_deg),
    })
}

/// Contrast at a place in degrees from the middle, right and up.
type Pattern = Box<dyn Fn(f64, f64) -> f64 + Sync>;

/// A stimulus of a data set of contrast sensitivity. Gabors are in sine phase, so that their mean is that of the field;
/// gratings fill a square and have whole cycles.
fn csf(row: &CsfRow) -> Measured {
    let CsfRow { frequency_cpd: f, sigma_deg, area_deg2, .. } = *row;
    let (side_deg, px_per_deg, pattern): (f64, f64, Pattern) = match row.dataset.as_str() {
        "hdr_csf_disc" => {
            let radius = (area_deg2 / PI).sqrt();
            let px_per_deg = (64.0 / radius).clamp(24.0, 60.0);
            (2.2 * radius, px_per_deg, Box::new(move |x, y| ((radius - x.hypot(y)) * px_per_deg + 0.5).clamp(0.0, 1.0)))
        }
        "hdr_csf" => {
            let pattern = move |x: f64, y: f64| gauss(x.hypot(y), sigma_deg) * (TAU * f * y).sin();
            (7.0 * sigma_deg, (8.0 * f).max(16.0).max(6.0 / sigma_deg), Box::new(pattern))
        }
        _ => {
            let side = (area_deg2.sqrt() * f).round().max(1.0) / f;
            let px_per_deg = (6.0 * f).max(12.0).max(8.0 / side);
            // Half a pixel, because the square is centered between pixels.
            (side, px_per_deg, Box::new(move |_, y| (TAU * f * (y - 0.5 / px_per_deg)).sin()))
        }
    };
    let side = 2 * ((0.5 * side_deg * px_per_deg).round() as usize).max(4);
    Measured {
        set: row.dataset.clone(),
        label: format!("{f} c/°, {} cd/m², {area_deg2} deg²", row.luminance_cd_m2),
        log_sensitivity: row.log10_sensitivity,
        frequency_cpd: Some(f).filter(|f| *f > 0.0),
        luminance: row.luminance_cd_m2,
        spectrum: ContrastSpectrum::of(&sampled(side, px_per_deg, pattern), [side; 2], px_per_deg),
    }
}

/// An edge of this width, half a degree above the middle, with a root mean square contrast of 1.
fn edge(width_deg: f64) -> Vec<f64> {
    let mut contrast = sampled(EDGE_SIDE, EDGE_PX_PER_DEG, |_, y| {
        let y = y - 0.5 / EDGE_PX_PER_DEG - 0.5;
        if y.abs() < width_deg { y.signum() * (1.0 - y.abs() / width_deg) } else { 0.0 }
    });
    let rms = (contrast.iter().map(|value| value * value).sum::<f64>() / contrast.len() as f64).sqrt();
    contrast.iter_mut().for_each(|value| *value /= rms);
    contrast
}

fn edge_spectrum(contrast: &[f64]) -> ContrastSpectrum {
    ContrastSpectrum::of(contrast, [EDGE_SIDE; 2], EDGE_PX_PER_DEG)
}

/// Noise of this name: `white`, or `pink`, whose amplitude falls with the frequency; row by row.
fn noise(name: &str, seed: u64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut values: Vec<f64> = (0..EDGE_SIDE * EDGE_SIDE).map(|_| StandardNormal.sample(&mut rng)).collect();
    if name == "pink" {
        let white = ContrastSpectrum::of(&values, [EDGE_SIDE; 2], EDGE_PX_PER_DEG);
        values = white.filtered(|frequency| 1.0 / frequency.max(1.0 / EDGE_DEG));
    }
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let rms = (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt();
    // Light is not negative.
    values.iter().map(|value| ((value - mean) / rms * NOISE_RMS).max(-0.95)).collect()
}

impl Edge {
    /// The threshold of our model: in noise, the mean of its logarithm over samples.
    fn threshold(&self, sensitivity: &Sensitivity, masking: &Masking) -> f64 {
        let eye = Eye { sensitivity: *sensitivity, masking: *masking, ..Eye::adapted_to(EDGE_CD_M2) };
        if self.noise == "none" {
            return 1.0 / self.spectrum.detection(&eye);
        }
        let judge = Judge::of_pictures([EDGE_SIDE; 2], EDGE_PX_PER_DEG, eye);
        let log = |seed: u64| {
            let noise = noise(&self.noise, seed);
            let light = |contrast: f64| -> Vec<f64> {
                let sum = noise.iter().zip(&self.contrast).map(|(noise, edge)| 1.0 + noise + contrast * edge);
                sum.map(|light| EDGE_CD_M2 * light.max(0.01)).collect()
            };
            // The response to a difference of this contrast; the threshold is proportional.
            let shown = judge.as_ref().ok().and_then(|judge| judge.difference(&light(FAINT), &light(0.0), None).ok());
            shown.map_or(f64::NAN, |shown| (FAINT / shown.map().largest()).ln())
        };
        let logs: Vec<f64> = (0..SAMPLES).into_par_iter().map(log).collect();
        (logs.iter().sum::<f64>() / SAMPLES as f64).exp()
    }

    /// Twice the difference in log likelihood between the best curve for the measured shares and the curve for this
    /// threshold, with the observers' own slope: 0 if the threshold is theirs.
    fn deviance(&self, threshold: f64, slope: f64) -> f64 {
        let log_likelihood = |share: &dyn Fn(f64, f64) -> f64| {
            let each = self.counts.iter().map(|[contrast, correct, trials]| {
                let p = share(*contrast, correct / trials).clamp(1e-9, 1.0 - 1e-9);
                correct * p.ln() + (trials - correct) * (1.0 - p).ln()
            });
            each.sum::<f64>()
        };
        2.0 * (log_likelihood(&|_, share| share) - log_likelihood(&|contrast, _| correct(contrast, threshold, slope)))
    }

    /// The observers' threshold and slope: those with the smallest deviance.
    fn observed(&self) -> (f64, f64) {
        let of = |k: i32| 1e-3 * 10_f64.powf(f64::from(k) / 500.0);
        let slopes = (10..=60).map(|k| 0.1 * f64::from(k));
        let all = slopes.flat_map(|slope| (0..1000).map(move |k| (of(k), slope)));
        let deviance = |(threshold, slope): &(f64, f64)| self.deviance(*threshold, *slope);
        all.min_by(|a, b| deviance(a).total_cmp(&deviance(b))).unwrap_or((1.0, 3.0))
    }
}

/// The share of correct responses in a choice between two: a Weibull function.
fn correct(contrast: f64, threshold: f64, slope: f64) -> f64 {
    let most = 0.5 - LAPSES;
    let at_threshold = -(1.0 - (AT_THRESHOLD - 0.5) / most).ln();
    0.5 + most * -(-at_threshold * (contrast / threshold).powf(slope)).exp_m1()
}

impl People {
    /// Reads the measurements and draws the stimuli.
    ///
    /// # Errors
    /// Returns an error if a file cannot be read or contains an unknown stimulus.
    pub fn read() -> Result<People, Box<dyn Error>> {
        let mut measured = rows::<ModelFestRow>(FILES[0])?.iter().map(modelfest).collect::<Result<Vec<_>, _>>()?;
        let within = |value: f64, [low, high]: [f64; 2]| (low..=high).contains(&value);
        let covered = |row: &CsfRow| within(row.luminance_cd_m2, LUMINANCES) && within(row.area_deg2, AREAS);
        measured.extend(rows::<CsfRow>(FILES[1])?.iter().filter(|row| covered(row)).map(csf));
        let mut edges: Vec<Edge> = Vec::new();
        for row in rows::<EdgeRow>(FILES[2])? {
            let counts = [row.rms_contrast, row.correct, row.trials];
            match edges.iter_mut().find(|edge| edge.noise == row.noise && edge.width_deg == row.ramp_width_deg) {
                Some(edge) => edge.counts.push(counts),
                None => edges.push(Edge {
                    noise: row.noise,
                    width_deg: row.ramp_width_deg,
                    counts: vec![counts],
                    spectrum: edge_spectrum(&edge(row.ramp_width_deg)),
                    contrast: edge(row.ramp_width_deg),
                }),
            }
        }
        for edge in edges.iter().filter(|edge| edge.noise == "none") {
            measured.push(Measured {
                set: "edges".into(),
                label: format!("edge of {}°", edge.width_deg),
                log_sensitivity: -edge.observed().0.log10(),
                frequency_cpd: None,
                luminance: EDGE_CD_M2,
                spectrum: edge_spectrum(&edge.contrast),
            });
        }
        let trapezoids = FITTED_WIDTHS.into_iter().map(trapezoid).collect();
        Ok(People { measured, edges, trapezoids })
    }

    /// The differences between predicted and measured log10 sensitivity. Each data set of contrast sensitivity has a
    /// gain of its own; ModelFest and the edges have none.
    pub fn errors(&self, sensitivity: &Sensitivity) -> Vec<f64> {
        self.errors_of(&ours(sensitivity))
    }

    fn errors_of(&self, detect: &Detect) -> Vec<f64> {
        let error = |of: &Measured| detect(&of.spectrum, of.luminance).log10() - of.log_sensitivity;
        let mut errors: Vec<f64> = self.measured.iter().map(error).collect();
        for set in CSF {
            let gain = self.mean(&errors, set);
            let own = errors.iter_mut().zip(&self.measured).filter(|(_, of)| of.set == set);
            own.for_each(|(error, _)| *error -= gain);
        }
        errors
    }

    /// The mean of the errors of a data set.
    fn mean(&self, errors: &[f64], set: &str) -> f64 {
        let own: Vec<f64> =
            self.measured.iter().zip(errors).filter(|(of, _)| of.set == set).map(|(_, error)| *error).collect();
        own.iter().sum::<f64>() / own.len() as f64
    }

    /// The root mean square of the errors of these data sets.
    pub fn rms(&self, errors: &[f64], sets: &[&str]) -> f64 {
        let own = self.measured.iter().zip(errors).filter(|(measured, _)| sets.contains(&measured.set.as_str()));
        let squares: Vec<f64> = own.map(|(_, error)| error * error).collect();
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    }

    /// The errors, each with its weight in the fit. The last ones are the means in each octave, and how far the thresholds
    /// for trapezoidal gratings are from being proportional to the width of the ramps.
    fn weighted(&self, sensitivity: &Sensitivity) -> DVector<f64> {
        let weight = |measured: &Measured| match measured.set.as_str() {
            "modelfest" => MODELFEST_WEIGHT,
            "edges" => EDGE_WEIGHT,
            _ => 1.0,
        };
        let errors = self.errors(sensitivity);
        let mut all: Vec<f64> = errors.iter().zip(&self.measured).map(|(error, of)| error * weight(of)).collect();
        all.extend(octaves(self, &errors).into_iter().map(|(_, bias, _)| OCTAVE_WEIGHT * bias));
        let logs: Vec<f64> =
            self.trapezoids.iter().map(|spectrum| log_threshold(spectrum, &ours(sensitivity))).collect();
        let wanted = FITTED_WIDTHS.windows(2).map(|pair| (pair[1] / pair[0]).log10());
        all.extend(logs.windows(2).zip(wanted).map(|(pair, wanted)| TRAPEZOID_WEIGHT * (pair[1] - pair[0] - wanted)));
        DVector::from_vec(all)
    }

    /// The derivatives of the weighted errors with respect to the logarithms of the parameters.
    fn derivatives(&self, sensitivity: &Sensitivity) -> DMatrix<f64> {
        const STEP: f64 = 1e-3;
        let before = self.weighted(sensitivity);
        let column = |k: usize| {
            let mut moved = parameters(sensitivity);
            moved[k] *= STEP.exp();
            (self.weighted(&with(&moved)) - &before) / STEP
        };
        DMatrix::from_columns(&(0..NAMES.len()).map(column).collect::<Vec<_>>())
    }

    /// Fits the parameters with the method of Levenberg and Marquardt, starting from `start`.
    pub fn fit(&self, start: &Sensitivity) -> Sensitivity {
        let (mut best, mut damping) = (*start, 1e-3);
        let mut errors = self.weighted(&best);
        for _ in 0..30 {
            let derivatives = self.derivatives(&best);
            let (normal, slope) = (derivatives.tr_mul(&derivatives), derivatives.tr_mul(&errors));
            let before = errors.norm_squared();
            for _ in 0..8 {
                let damped = &normal + DMatrix::from_diagonal(&(normal.diagonal() * damping));
                let Some(step) = damped.lu().solve(&slope) else { break };
                let moved: Vec<f64> =
                    parameters(&best).iter().zip(step.iter()).map(|(value, step)| value * (-step).exp()).collect();
                let tried = with(&moved);
                let found = self.weighted(&tried);
                if found.norm_squared() < before {
                    (best, errors, damping) = (tried, found, damping * 0.1);
                    break;
                }
                damping *= 10.0;
            }
            if errors.norm_squared() > before * (1.0 - 1e-9) {
                break;
            }
        }
        best
    }

    /// To first order: the root mean square error of ModelFest if each stimulus is predicted by a fit to all the others
    /// (its error divided by one minus its leverage), and the change in the logarithm of each parameter that would still
    /// improve the fit.
    pub fn linearized(&self, sensitivity: &Sensitivity) -> (f64, Vec<f64>) {
        let derivatives = self.derivatives(sensitivity);
        let Some(inverse) = derivatives.tr_mul(&derivatives).try_inverse() else { return (f64::NAN, Vec::new()) };
        let leverage = |i: usize| (derivatives.row(i) * &inverse * derivatives.row(i).transpose())[0];
        let errors = self.errors(sensitivity);
        let all: Vec<f64> = errors.iter().enumerate().map(|(i, error)| error / (1.0 - leverage(i))).collect();
        let step = -(&inverse * derivatives.tr_mul(&self.weighted(sensitivity)));
        (self.rms(&all, &["modelfest"]), step.iter().copied().collect())
    }

    /// log10 of the predicted threshold divided by the observers', and the deviance, for each edge.
    pub fn edges(&self, sensitivity: &Sensitivity, masking: &Masking) -> Vec<(f64, f64)> {
        self.edges_of(&|edge| edge.threshold(sensitivity, masking))
    }

    fn edges_of(&self, threshold: &dyn Fn(&Edge) -> f64) -> Vec<(f64, f64)> {
        let each = self.edges.iter().map(|edge| {
            let (observed, slope) = edge.observed();
            let threshold = threshold(edge);
            ((threshold / observed).log10(), edge.deviance(threshold, slope))
        });
        each.collect()
    }
}

/// The data sets of contrast sensitivity.
pub const CSF: [&str; 3] = ["rovamo1993", "hdr_csf", "hdr_csf_disc"];

/// The fitted parameters in the order of [`NAMES`].
pub fn parameters(of: &Sensitivity) -> [f64; NAMES.len()] {
    [of.gain, of.fine_cpd, of.fine_power, of.coarse_power, of.pooling, of.fovea_deg, of.fovea_power, of.bright_power]
}

/// The parameters with these values, in the order of [`NAMES`].
///
/// # Panics
/// Panics if there are too few.
pub fn with(values: &[f64]) -> Sensitivity {
    Sensitivity {
        gain: values[0],
        fine_cpd: values[1],
        fine_power: values[2],
        coarse_power: values[3],
        pooling: values[4],
        fovea_deg: values[5],
        fovea_power: values[6],
        bright_power: values[7],
    }
}

/// A start far from the result: round numbers.
const START: Sensitivity = Sensitivity {
    gain: 200.0,
    fine_cpd: 1.0,
    fine_power: 0.7,
    coarse_power: 1.5,
    pooling: 2.5,
    fovea_deg: 0.3,
    fovea_power: 0.5,
    bright_power: 0.2,
};

/// The response at which masking is 1/√2: the peak response to ModelFest's Gabor of 4 cycles per degree at its measured
/// threshold, with the fall-off and the pooling left out.
///
/// # Errors
/// Returns an error if the measurements have no such Gabor.
pub fn unit(sensitivity: &Sensitivity) -> Result<f64, Box<dyn Error>> {
    let row =
        rows::<ModelFestRow>(FILES[0])?.into_iter().find(|row| row.kind == "gabor" && row.frequency_cpd == Some(4.0));
    let gabor = modelfest(&row.ok_or("no Gabor of 4 cycles per degree")?)?;
    let response = gabor.spectrum.filtered(|frequency| sensitivity.at(frequency, gabor.luminance));
    Ok(response.into_iter().fold(0.0, f64::max) * 10_f64.powf(-gabor.log_sensitivity))
}

/// The mean error of the three data sets of contrast sensitivity in each octave of frequency from ¼ to 16 cycles per
/// degree, with the center of the octave and the number of stimuli.
pub fn octaves(people: &People, errors: &[f64]) -> Vec<(f64, f64, usize)> {
    let of = |k: i32| {
        let center = 2_f64.powi(k);
        let is_in = |of: &Measured| of.frequency_cpd.is_some_and(|f| (f / center).log2().abs() <= 0.5);
        let own: Vec<f64> = people.measured.iter().zip(errors).filter(|(of, _)| is_in(of)).map(|(_, e)| *e).collect();
        (center, own.iter().sum::<f64>() / own.len() as f64, own.len())
    };
    (-2..=4).map(of).collect()
}

/// Widths of the ramps of the trapezoidal gratings, degrees, 15 % apart.
fn ramp_widths() -> impl Iterator<Item = f64> {
    (0..).map(|k| 0.05 * 1.15_f64.powi(k)).take_while(|width| *width <= 4.0)
}

/// One ramp of a trapezoidal grating. The field is 30° wide and fades out over the outer 10°, so that its outline is not
/// what is detected.
fn trapezoid(width: f64) -> ContrastSpectrum {
    let (side, px_per_deg) = (720, 24.0);
    let fade = |x: f64| {
        let outer = ((x.abs() - 5.0) / 10.0).clamp(0.0, 1.0);
        0.5 + 0.5 * (PI * outer).cos()
    };
    let contrast = sampled(side, px_per_deg, |x, y| {
        let x = x + 0.5 / px_per_deg;
        (x / (0.5 * width)).clamp(-1.0, 1.0) * fade(x) * fade(y)
    });
    ContrastSpectrum::of(&contrast, [side; 2], px_per_deg)
}

/// log10 of the threshold contrast at 100 cd/m².
fn log_threshold(spectrum: &ContrastSpectrum, detect: &Detect) -> f64 {
    -detect(spectrum, 100.0).log10()
}

/// Ramp width in degrees and log10 of the threshold contrast of trapezoidal gratings at 100 cd/m².
pub fn trapezoids(sensitivity: &Sensitivity) -> Vec<(f64, f64)> {
    trapezoids_of(&ours(sensitivity))
}

fn trapezoids_of(detect: &Detect) -> Vec<(f64, f64)> {
    ramp_widths().map(|width| (width, log_threshold(&trapezoid(width), detect))).collect()
}

/// The slope of log threshold over log width for ramps of at least half a degree, and how far the thresholds of narrower
/// ramps are apart, log10 units: 1 and 0 for people (Campbell, Johnstone & Ross 1981, Vis. Res. 21:723).
pub fn trapezoid_summary(thresholds: &[(f64, f64)]) -> [f64; 2] {
    let wide: Vec<[f64; 2]> =
        thresholds.iter().filter(|(width, _)| *width >= 0.5).map(|(width, log)| [width.log10(), *log]).collect();
    let mean = |k: usize| wide.iter().map(|point| point[k]).sum::<f64>() / wide.len() as f64;
    let [x, y] = [mean(0), mean(1)];
    let slope = wide.iter().map(|point| (point[0] - x) * (point[1] - y)).sum::<f64>()
        / wide.iter().map(|point| (point[0] - x).powi(2)).sum::<f64>();
    let narrow = || thresholds.iter().filter(|(width, _)| *width <= 0.5).map(|(_, log)| *log);
    [slope, narrow().fold(f64::MIN, f64::max) - narrow().fold(f64::MAX, f64::min)]
}

/// How far a model is from the measurements: the rows of its column, in the order of [`People::rows`].
struct Column {
    name: &'static str,
    cells: Vec<String>,
}

impl People {
    /// What the rows of the table are.
    fn rows(&self) -> Vec<String> {
        let sets = ["ModelFest, 30 stimuli", "ModelFest, leave-one-out"].map(String::from).into_iter();
        let csf = CSF.into_iter().chain(["all three"]).map(|set| format!("contrast sensitivity, {set}"));
        let edges = self.edges.iter().map(|edge| {
            let noise = if edge.noise == "none" { "no" } else { edge.noise.as_str() };
            format!("edge of {}°, {noise} noise", edge.width_deg)
        });
        let trapezoids = ["trapezoids: slope from 0.5° on (people: 1)", "trapezoids: range below 0.5° (people: 0)"];
        sets.chain(csf).chain(edges).chain(trapezoids.map(String::from)).collect()
    }

    fn column(
        &self,
        name: &'static str,
        errors: &[f64],
        leave_one_out: f64,
        detect: &Detect,
        edges: &[(f64, f64)],
    ) -> Column {
        let [slope, range] = trapezoid_summary(&trapezoids_of(detect));
        let csf = CSF.iter().map(|set| self.rms(errors, &[set])).chain([self.rms(errors, &CSF)]);
        let rms = [self.rms(errors, &["modelfest"]), leave_one_out].into_iter().chain(csf);
        let edges = edges.iter().map(|(ratio, deviance)| format!("{ratio:+.3} ({deviance:.0})"));
        let cells = rms.map(|rms| format!("{rms:.3}")).chain(edges);
        Column { name, cells: cells.chain([format!("{slope:.2}"), format!("{range:.2}")]).collect() }
    }

    /// Our model.
    fn held(&self, name: &'static str, sensitivity: &Sensitivity) -> Column {
        let (errors, edges) = (self.errors(sensitivity), self.edges(sensitivity, &Masking::default()));
        self.column(name, &errors, self.linearized(sensitivity).0, &ours(sensitivity), &edges)
    }

    /// A filter with a gain that fits ModelFest, its only free parameter.
    fn rival(&self, name: &'static str, gain: impl Fn(f64, f64) -> f64) -> Column {
        let gain = &gain;
        let of = |factor: f64| filter(move |frequency, luminance| factor * gain(frequency, luminance));
        let factor = 10_f64.powf(-self.mean(&self.errors_of(&of(1.0)), "modelfest"));
        let errors = self.errors_of(&of(factor));
        let count = self.measured.iter().filter(|of| of.set == "modelfest").count() as f64;
        let edges = self.edges_of(&|edge| 1.0 / of(factor)(&edge.spectrum, EDGE_CD_M2));
        self.column(name, &errors, self.rms(&errors, &["modelfest"]) * count / (count - 1.0), &of(factor), &edges)
    }
}

/// Prints the tables; with `fit`, fits the parameters first.
///
/// # Errors
/// Returns an error if the measurements cannot be read.
pub fn run(fit: bool, verbose: bool) -> Result<(), Box<dyn Error>> {
    let people = People::read()?;
    println!("Inputs, with SHA-256:\n");
    for file in FILES {
        let digest = Sha256::digest(std::fs::read(folder().join(file))?);
        println!("- {file}: {}", digest.iter().map(|byte| format!("{byte:02x}")).collect::<String>());
    }
    let held = Sensitivity::default();
    let fitted = fit.then(|| people.fit(&START));
    println!("\n| parameter | in the code |{}", if fit { " fitted from round numbers |" } else { "" });
    println!("|---|---|{}", if fit { "---|" } else { "" });
    let row = |name: &str, of: &dyn Fn(&Sensitivity) -> f64| {
        let fitted = fitted.as_ref().map_or_else(String::new, |fitted| format!(" {:.5} |", of(fitted)));
        println!("| {name} | {} |{fitted}", of(&held));
    };
    NAMES.iter().enumerate().for_each(|(k, name)| row(name, &|of| parameters(of)[k]));
    println!("\nResponse at which masking is 1/√2: {:.3}", unit(&held)?);
    for (center, bias, number) in octaves(&people, &people.errors(&held)) {
        println!("contrast sensitivity near {center} c/°: bias {bias:+.3} ({number} stimuli)");
    }
    println!();
    let mut columns = vec![people.held("ours", &held)];
    if let Some(fitted) = &fitted {
        println!("The same for the fitted parameters: {:.3}", unit(fitted)?);
        for (center, bias, number) in octaves(&people, &people.errors(fitted)) {
            println!("contrast sensitivity near {center} c/°: bias {bias:+.3} ({number} stimuli)");
        }
        println!();
        columns.push(people.held("ours, as fitted", fitted));
    }
    columns.push(people.rival("Barten 2003", |frequency, luminance| barten(frequency, luminance, 10.0)));
    // Plain root mean square contrast, without a filter.
    columns.push(people.rival("contrast alone", |_, _| 1.0));
    println!("| data | {} |", columns.iter().map(|column| column.name).collect::<Vec<_>>().join(" | "));
    println!("|---|{}", "---|".repeat(columns.len()));
    for (k, row) in people.rows().iter().enumerate() {
        println!(
            "| {row} | {} |",
            columns.iter().map(|column| column.cells[k].as_str()).collect::<Vec<_>>().join(" | ")
        );
    }
    if verbose {
        println!();
        for (measured, error) in people.measured.iter().zip(people.errors(&held)) {
            println!("{:12} {:40} {error:+.3}", measured.set, measured.label);
        }
        trapezoids(&held).iter().for_each(|(width, log)| println!("trapezoid {width:.3}° {log:.3}"));
    }
    Ok(())
}

/// Returns the contrast sensitivity for a grating of `frequency` cycles per degree, above 0, on a field of `luminance`
/// cd/m² whose side is `field_deg` degrees (Barten 2003, *Formula for the contrast sensitivity of the human eye*, Proc.
/// SPIE 5294). It covers the optics, photon and neural noise, and the lateral inhibition that attenuates coarse gratings.
fn barten(frequency: f64, luminance: f64, field_deg: f64) -> f64 {
    let square = frequency * frequency;
    // In dimmer light, the pupil is larger, and so is the blur.
    let optics = (-0.0016 * square * (1.0 + 100.0 / luminance).powf(0.08)).exp();
    let field = 1.0 + 144.0 / (field_deg * field_deg) + 0.64 * square;
    let photons = 63.0 / luminance.powf(0.83);
    let inhibition = -(-0.02 * square).exp_m1();
    5200.0 * optics / (field * (photons + 1.0 / inhibition)).sqrt()
}
