//! The parametric bootstrap: the distribution of likelihood ratios over studies that the fitted model would give.
//!
//! With few participants, a likelihood ratio does not have a χ² distribution. Studies are therefore simulated from the
//! fitted model with the same participants, conditions and numbers of ratings, and in each one the ratio is computed at
//! the coefficients that generated it. The same distribution calibrates the test of a term and the profile intervals of
//! its coefficients (Davison & Hinkley 1997, Bootstrap Methods and their Application, ch. 4 and 5; Halekoh & Højsgaard
//! 2014, J. Stat. Softw. 59(9), for mixed models). Random numbers come from ChaCha8 with one stream per simulated study.

use std::collections::BTreeSet;

use clap::Args;
use nalgebra::DVector;
use rand::RngExt;
use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};
use rand_distr::{Binomial, Distribution, StandardNormal};
use rayon::prelude::*;
use serde::Serialize;

use super::{
    clm::Fit,
    clmm::ClmmData,
    design::Design,
    estimates::finite_estimates,
    fitting::{Fitted, How, Layout, lay_out},
    likelihood_ratios::is_decided,
    link::Link,
    terms::Term,
};
use crate::{
    analysis::{counts::CountRow, frame::Frame},
    text::number::whole,
};

/// Settings of the parametric bootstrap. The same settings give the same results on every machine.
// With 99, 199, … studies, a test at the level 0.05 is exact if the distribution of the ratio does not depend on the
// parameters.
#[derive(Clone, Copy, Debug, PartialEq, Args, Serialize)]
pub struct Resampling {
    /// Maximum number of simulated studies that calibrate tests and intervals, 99 to 1,000,000. Simulation ends earlier when
    /// more studies would not change a conclusion.
    #[arg(long, value_name = "N", default_value_t = Self::default().draws,
          value_parser = whole::<u32>(99..=1_000_000))]
    pub draws: u32,
    /// Seed of the simulated studies.
    #[arg(long, value_name = "N", default_value_t = Self::default().seed, value_parser = whole(0..=u64::MAX))]
    pub seed: u64,
}

impl Default for Resampling {
    fn default() -> Self {
        Self { draws: 999, seed: 1 }
    }
}

/// Number of studies after which a simulation may end.
const BATCH: u32 = 100;

/// Simulates studies from a fit and returns the ratios for each of the terms that are tested, each given with its observed
/// ratio; not finite where a study allows no fit. The ratios of a term end when its observed ratio is decided (Besag &
/// Clifford 1991, Biometrika 78, 301). `progress` is called after each study.
pub(super) fn simulate(
    full: &Fitted,
    recoded: Option<&Fitted>,
    tested: &[(&Term, f64)],
    settings: Resampling,
    progress: &(dyn Fn() + Sync),
) -> Vec<Vec<f64>> {
    let simulator = Simulator::new(full, true);
    let held = |(term, _): &(&Term, f64)| {
        let model = recoded.filter(|_| full.spec.terms.is_marginal(term)).unwrap_or(full);
        let estimates = finite_estimates(model);
        let thresholds = model.frame.categories.len() - 1;
        let own = (0..model.x.columns.len()).filter(|&column| model.term_of(column) == *term);
        let own: Vec<(usize, f64)> = own.map(|column| (column, estimates[thresholds + column])).collect();
        (model.x.held(&model.standard, &own), model)
    };
    let held: Vec<Held> = tested.iter().map(held).collect();
    let mut open = vec![true; tested.len()];
    let of_study = |study: u32, open: &[bool]| {
        let designs: Vec<Option<&Held>> = held.iter().zip(open).map(|(held, open)| open.then_some(held)).collect();
        let ratios = simulator.study(settings.seed, study.into()).map(|frame| ratios(full, frame, &designs));
        progress();
        ratios.unwrap_or_else(|| vec![f64::NAN; tested.len()])
    };
    let mut all = vec![Vec::new(); tested.len()];
    let mut next = 0;
    while next < settings.draws && open.contains(&true) {
        // With 99, 199, … studies, a quantile at the level 0.05 is one of the ratios.
        let end = settings.draws.min((next + 1) / BATCH * BATCH + BATCH - 1);
        for study in (next..end).into_par_iter().map(|study| of_study(study, &open)).collect::<Vec<_>>() {
            let places = all.iter_mut().zip(study).zip(&open);
            places.filter(|(_, open)| **open).for_each(|((ratios, ratio), _)| ratios.push(ratio));
        }
        next = end;
        let places = all.iter().zip(tested).zip(&mut open);
        places.for_each(|((ratios, (_, own)), open)| *open = *open && !is_decided(ratios, *own));
    }
    all
}

/// A design in which the coefficients of a term have their estimates, and the fit that it is of.
type Held<'a> = (Design, &'a Fitted<'a>);

/// Returns the ratio of each design, if there is one, in a simulated study; NaN if the study allows no fit.
fn ratios(full: &Fitted, frame: Frame, designs: &[Option<&Held>]) -> Vec<f64> {
    let how = How { rough: true, ..How::default() };
    let free = full.refit(frame, full.x.clone(), how);
    let fixed = |(x, model): &Held| {
        let near = if std::ptr::eq(*model, full) && free.mixed.is_some() { &free } else { *model };
        free.ratio(&near.refit(free.frame.clone(), x.clone(), How { informed: Some(model), ..how }))
    };
    designs.iter().map(|held| held.and_then(fixed).unwrap_or(f64::NAN)).collect()
}

/// Corrects the standard deviations of independent effects for the means over participants that are estimated, as
/// restricted maximum likelihood does: with n participants, the estimated variance of an effect and its sampling variance
/// together are too small by the factor (n − p)/n. Otherwise, a deviation that is small or 0 by chance would make
/// simulated studies less variable than real ones. The median of a variance with ν degrees of freedom is smaller than its
/// mean by about 2/3 of a degree, so the correction makes the median right.
fn correct_deviations(fitted: &Fitted, data: &ClmmData, mixed: &Fit, parameters: &mut DVector<f64>) {
    if fitted.random.correlated {
        return;
    }
    let sampling = data.sampling_variances(&mixed.parameters, &mixed.modes);
    for (component, sampling) in sampling.into_iter().enumerate() {
        let (all, free) = fitted.degrees(component);
        let deviation = &mut parameters[data.first_psi() + component];
        let factor = all / (free - 2.0 / 3.0).max(0.5);
        *deviation = ((*deviation * *deviation + sampling) * factor - sampling).max(0.0).sqrt();
    }
}

/// A fitted model, laid out to simulate ratings.
pub(super) struct Simulator<'a> {
    frame: &'a Frame<'a>,
    link: Link,
    thresholds: Vec<f64>,
    /// The location of each condition for a participant whose effects are 0.
    location: Vec<f64>,
    /// The effects that matter in each condition, with their weights.
    weights: Vec<Vec<(usize, f64)>>,
    /// The effects of each participant and then the conditions, each in the order in which random numbers are drawn. It does
    /// not depend on the order of factors and terms.
    drawn: (Vec<usize>, Vec<usize>),
    /// The number of effects that all participants share.
    shared: usize,
}

/// Returns the order in which the `own` effects of a participant are drawn, and the place of each condition in the order in
/// which ratings are drawn: conditions by the names of their factors and levels, and effects by the variables of their term.
fn order_of_draws(fitted: &Fitted, weights: &[Vec<(usize, f64)>], own: usize) -> (Vec<usize>, Vec<usize>) {
    let Frame { counts, .. } = &fitted.frame;
    let mut factors: Vec<usize> = (0..counts.factors.len()).collect();
    factors.sort_by_key(|&factor| &counts.factors[factor].name);
    let key = |condition: usize| factors.iter().map(|&f| counts.conditions[condition][f]).collect::<Vec<_>>();
    let mut conditions: Vec<usize> =
        fitted.frame.conditions().into_iter().map(|condition| condition as usize).collect();
    conditions.sort_by_cached_key(|&condition| key(condition));
    let mut places = vec![0; counts.conditions.len()];
    conditions.iter().enumerate().for_each(|(place, &condition)| places[condition] = place);
    // Each slot of a condition belongs to a component.
    let mut slots: Vec<usize> = (0..fitted.random.components.len()).collect();
    slots.sort_by_cached_key(|&slot| {
        let variables = fitted.random.components[slot].term.variables.iter();
        variables.map(ToString::to_string).collect::<BTreeSet<String>>()
    });
    let mut effects: Vec<usize> = Vec::with_capacity(own);
    for (slot, &condition) in slots.iter().flat_map(|slot| conditions.iter().map(move |condition| (*slot, condition))) {
        let effect = weights[condition][slot].0;
        if effect < own && !effects.contains(&effect) {
            effects.push(effect);
        }
    }
    (effects, places)
}

impl<'a> Simulator<'a> {
    /// Lays out a fit. If `corrected`, standard deviations are corrected for the means that are estimated.
    pub fn new(fitted: &'a Fitted<'a>, corrected: bool) -> Self {
        let Layout { data, .. } = lay_out(fitted, fitted.random.is_crossed());
        let mut parameters = fitted.searched(&data);
        if !fitted.random.correlated {
            // A seed gives the same studies, whatever the signs.
            parameters.iter_mut().skip(data.first_psi()).for_each(|deviation| *deviation = deviation.abs());
        }
        if let Some(mixed) = fitted.usable().filter(|_| corrected) {
            correct_deviations(fitted, &data, mixed, &mut parameters);
        }
        let Layout { data, row_of } = lay_out(fitted, false);
        let (location, weights) = (data.location(&parameters), data.weights(&parameters));
        let slots = data.loadings.slots_per_row;
        let effects_of = |row: &usize| weights[row * slots..(row + 1) * slots].to_vec();
        let weights: Vec<Vec<(usize, f64)>> = row_of.iter().map(effects_of).collect();
        let (own, shared) = fitted.random.effects();
        let drawn = order_of_draws(fitted, &weights, own);
        Self {
            drawn,
            shared,
            frame: &fitted.frame,
            link: fitted.spec.link,
            thresholds: parameters.as_slice()[..data.thresholds()].to_vec(),
            location: row_of.iter().map(|row| location[*row]).collect(),
            weights,
        }
    }

    /// Simulates a study with the same participants, conditions and numbers of ratings. `None` if all ratings are the
    /// same.
    pub fn study(&self, seed: u64, study: u64) -> Option<Frame<'a>> {
        let mut rows = self.ratings(seed, study);
        rows.sort_unstable();
        self.frame.with_ratings(rows)
    }

    /// Simulates the ratings of a study, in any order, with the categories numbered as in the frame.
    pub fn ratings(&self, seed: u64, study: u64) -> Vec<CountRow> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(study);
        let mut rows = Vec::with_capacity(self.frame.rows.len());
        let (effects, places) = &self.drawn;
        let mut u: Vec<f64> = vec![0.0; effects.len()];
        u.extend((0..self.shared).map(|_| rng.sample::<f64, _>(StandardNormal)));
        for of_subject in self.frame.rows.chunk_by(|l, r| l.subject == r.subject) {
            effects.iter().for_each(|&effect| u[effect] = StandardNormal.sample(&mut rng));
            let mut cells: Vec<&[CountRow]> = of_subject.chunk_by(|l, r| l.condition == r.condition).collect();
            cells.sort_by_key(|cell| places[cell[0].condition as usize]);
            for cell in cells {
                let condition = cell[0].condition as usize;
                let effect: f64 = self.weights[condition].iter().map(|(effect, weight)| weight * u[*effect]).sum();
                let location = self.location[condition] + effect;
                let n = cell.iter().map(|row| row.count).sum();
                let counts = self.categories(n, location, &mut rng);
                let given = (0..).zip(counts).filter(|(_, count)| *count > 0);
                rows.extend(given.map(|(rating, count)| CountRow { rating, count, ..cell[0] }));
            }
        }
        rows
    }

    /// Draws the number of ratings in each category.
    fn categories(&self, n: u64, location: f64, rng: &mut ChaCha8Rng) -> Vec<u64> {
        const ONE_BY_ONE: u64 = 16;
        let below = |j: usize| self.link.cdf(self.thresholds[j] - location);
        let categories = self.thresholds.len() + 1;
        let mut counts = vec![0; categories];
        if n <= ONE_BY_ONE {
            for _ in 0..n {
                let uniform: f64 = rng.random();
                counts[(0..categories - 1).take_while(|&j| uniform >= below(j)).count()] += 1;
            }
            return counts;
        }
        let (mut left, mut before) = (n, 0.0);
        for (j, count) in counts.iter_mut().take(categories - 1).enumerate() {
            let share = ((below(j) - before) / (1.0 - before)).clamp(0.0, 1.0);
            *count = Binomial::new(left, share).map_or(0, |binomial| binomial.sample(rng));
            left -= *count;
            before = below(j);
        }
        counts[categories - 1] = left;
        counts
    }
}
