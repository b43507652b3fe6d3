//! What the maxima mean: estimates on the scale of the data, their errors, and notes.

use nalgebra::{DMatrix, DVector};

use super::{
    clm::End,
    counts::Counts,
    design::Design,
    fitting::{Fitted, fit_frame},
    mixed::{MixedEnd, MixedFit},
    model::{Coefficient, Model, ModelSpec, Random, RandomEffect, SubjectMode, Threshold},
    outcome::{ModelError, Note},
    standard,
};

/// Fits a model.
///
/// # Errors
/// Data or terms about which nothing can be said. Everything else that is wrong with the data is a note of the model.
pub fn fit(counts: &Counts, spec: &ModelSpec) -> Result<Model, ModelError> {
    Ok(report(&fit_frame(counts, spec)?))
}

/// The model that a fit means, on the scale of the data.
pub(super) fn report(fitted: &Fitted) -> Model {
    let mut notes = fitted.notes.clone();
    let mixed = fitted.mixed.as_ref().filter(|mixed| mixed.end != MixedEnd::Runaway);
    note_design(fitted, &mut notes);
    note_separation(fitted, &mut notes);
    note_mixed(fitted, &mut notes);
    let gradient = mixed.map_or(fitted.clm.gradient, |mixed| mixed.gradient);
    let stalled = match mixed {
        Some(mixed) => mixed.end == MixedEnd::Stalled,
        None => fitted.clm.end == End::Stalled,
    };
    if stalled {
        notes.push(Note::NotConverged { gradient });
    }
    let (estimates, covariance) = estimates(fitted, mixed);
    if covariance.is_none() {
        notes.push(Note::Flat);
    }
    let size = estimates.len();
    let boundary = mixed.is_some_and(|mixed| mixed.end == MixedEnd::Boundary);
    let covariance = covariance.unwrap_or_else(|| DMatrix::from_element(size, size, f64::NAN));
    let se = |index: usize| Some(covariance[(index, index)].sqrt()).filter(|se| se.is_finite());
    let thresholds = fitted.frame.categories.len() - 1;
    let coefficients = |design: &Design, first: usize| -> Vec<Coefficient> {
        (0..design.columns.len())
            .map(|column| {
                let (estimate, se) = (estimates[first + column], se(first + column));
                let z = se.map(|se| estimate / se);
                Coefficient {
                    name: design.columns[column].name.clone(),
                    term: fitted.term_name(design, column),
                    estimate,
                    se,
                    z,
                    p: z.map(two_sided),
                }
            })
            .collect()
    };
    let first_zeta = thresholds + fitted.x.columns.len();
    Model {
        link: fitted.spec.link,
        method: method(mixed.is_some(), fitted.spec.quadrature),
        nobs: fitted.frame.total(),
        subjects: fitted.frame.subjects.len(),
        loglik: mixed.map_or(fitted.clm.loglik, |mixed| mixed.loglik),
        gradient,
        iterations: mixed.map_or(fitted.clm.iterations, |mixed| mixed.iterations),
        parameters: size + usize::from(boundary),
        thresholds: (fitted.frame.categories.windows(2).enumerate())
            .map(|(j, pair)| Threshold { name: pair.join("|"), estimate: estimates[j], se: se(j) })
            .collect(),
        coefficients: coefficients(&fitted.x, thresholds),
        scale: coefficients(&fitted.scale, first_zeta),
        random: mixed.map(|mixed| random_effect(fitted, mixed, (!boundary).then(|| se(first_zeta)).flatten())),
        categories: fitted.frame.categories.clone(),
        notes,
        covariance,
    }
}

fn method(mixed: bool, nodes: usize) -> String {
    match (mixed, nodes) {
        (false, _) => "clm".to_owned(),
        (true, 1) => "clmm-laplace".to_owned(),
        (true, nodes) => format!("clmm-aghq-{nodes}"),
    }
}

fn random_effect(fitted: &Fitted, mixed: &MixedFit, se: Option<f64>) -> RandomEffect {
    let sd = mixed.parameters[mixed.parameters.len() - 1];
    let subjects = fitted.frame.subjects.iter().zip(mixed.modes.u.iter().zip(&mixed.modes.curvature));
    RandomEffect {
        sd,
        se,
        subjects: subjects
            .map(|(subject, (u, curvature))| SubjectMode {
                subject: subject.clone(),
                mode: sd * u,
                sd: sd / curvature.sqrt(),
            })
            .collect(),
    }
}

/// Estimates and covariance of all parameters on the scale of the data; what has no finite estimate is infinite, with
/// NaN for its covariances.
fn estimates(fitted: &Fitted, mixed: Option<&MixedFit>) -> (DVector<f64>, Option<DMatrix<f64>>) {
    let thresholds = fitted.frame.categories.len() - 1;
    let (parameters, information) = match mixed {
        Some(mixed) if mixed.end != MixedEnd::Boundary => (mixed.parameters.clone(), mixed.information.clone()),
        _ => (fitted.clm.parameters.clone(), finite_part(fitted, &fitted.clm.information)),
    };
    let size = parameters.len();
    let back = standard::back(&fitted.standards.0, &fitted.standards.1, thresholds, size);
    let free: Vec<usize> = (0..size).filter(|&index| !fitted.is_infinite(index)).collect();
    let covariance = information.cholesky().map(|factor| {
        let inverse = factor.inverse();
        let mut whole = DMatrix::zeros(size, size);
        for (row, &i) in free.iter().enumerate() {
            for (column, &j) in free.iter().enumerate() {
                whole[(i, j)] = inverse[(row, column)];
            }
        }
        let mut covariance = &back * whole * back.transpose();
        for index in (0..size).filter(|&index| fitted.is_infinite(index)) {
            covariance.row_mut(index).fill(f64::NAN);
            covariance.column_mut(index).fill(f64::NAN);
        }
        covariance
    });
    let mut estimates = back * parameters;
    if let Some(direction) = fitted.direction() {
        for index in (0..size).filter(|&index| fitted.is_infinite(index)) {
            estimates[index] = direction[index] * f64::INFINITY;
        }
    }
    (estimates, covariance)
}

/// The information of the parameters that have a finite estimate.
fn finite_part(fitted: &Fitted, information: &DMatrix<f64>) -> DMatrix<f64> {
    let free: Vec<usize> = (0..information.nrows()).filter(|&index| !fitted.is_infinite(index)).collect();
    information.select_rows(&free).select_columns(&free)
}

fn note_design(fitted: &Fitted, notes: &mut Vec<Note>) {
    for design in [&fitted.x, &fitted.scale] {
        for (index, term) in design.terms.iter().enumerate() {
            if !design.columns.iter().any(|column| column.term == index) {
                notes.push(Note::AliasedTerm { term: term.to_string() });
            } else {
                let dropped = design.dropped.iter().filter(|column| column.term == index);
                notes.extend(dropped.map(|column| Note::Aliased { column: column.name.clone() }));
            }
        }
    }
}

fn note_separation(fitted: &Fitted, notes: &mut Vec<Note>) {
    let Some(direction) = fitted.direction() else { return };
    let thresholds = fitted.frame.categories.len() - 1;
    for index in fitted.infinite_thresholds() {
        let threshold = fitted.frame.categories[index..index + 2].join("|");
        notes.push(Note::SeparatedThreshold { threshold });
    }
    for column in (0..fitted.x.columns.len()).filter(|column| fitted.is_infinite(thresholds + column)) {
        notes.push(Note::Separation {
            coefficient: fitted.x.columns[column].name.clone(),
            term: fitted.term_name(&fitted.x, column),
            positive: direction[thresholds + column] > 0.0,
        });
    }
}

fn note_mixed(fitted: &Fitted, notes: &mut Vec<Note>) {
    if fitted.spec.random == Random::None {
        return;
    }
    notes.extend(match fitted.mixed.as_ref().map(|mixed| mixed.end) {
        Some(MixedEnd::Boundary) => Some(Note::NoSubjectVariance),
        Some(MixedEnd::Runaway) => Some(Note::RunawayVariance),
        Some(MixedEnd::Converged | MixedEnd::Stalled) => None,
        None => Some(Note::NoMixedModel),
    });
}

/// The two-sided probability of a standard normal z.
fn two_sided(z: f64) -> f64 {
    statrs::function::erf::erfc(z.abs() * std::f64::consts::FRAC_1_SQRT_2)
}
