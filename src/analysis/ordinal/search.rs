//! The search for the maximum of a mixed model's likelihood and for the observed information at the maximum.
//!
//! The likelihood does not depend on the sign of a standard deviation, if the effects that belong to it change sign too, so
//! the search needs no bounds, and it may end at either sign: a deviation whose best value is 0 arrives there, is then held
//! at exactly 0, and is finally checked by moving it away again.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::{
    clm::{Fit, FitEnd, halved, positive_definite},
    clmm::{ClmmData, Evaluation, Modes},
};
use crate::system::checkpoint;

/// A standard deviation below this counts as 0.
const NO_SIGMA: f64 = 1e-4;
/// A parameter above this counts as having no finite estimate. Columns are standardized to a size of 1.
const MAX_PARAMETER: f64 = 60.0;

/// A search over the free parameters; all others keep their starting values.
struct Search<'a> {
    data: &'a ClmmData,
    free: Vec<usize>,
    modes: Modes,
    at: DVector<f64>,
    value: Evaluation,
    /// The approximate inverse of the information of the free parameters, as far as the steps have told it.
    inverse: DMatrix<f64>,
}

/// What a search needs to know besides the data.
#[derive(Clone, Copy)]
pub(super) struct Task<'a> {
    /// The fit of the model without random effects (θ and β). Its free parameters and ψ may change.
    pub plain: &'a Fit,
    /// Where to start (θ, β and ψ), with the modes; `None` tries a few standard deviations.
    pub start: Option<(&'a DVector<f64>, &'a Modes)>,
    /// The information of the free parameters in a similar fit.
    pub information: Option<&'a DMatrix<f64>>,
    /// Whether a deviation that arrives at 0 stays there, and the likelihood is needed to four decimals only.
    pub rough: bool,
    /// The largest gradient that counts as zero.
    pub tolerance: f64,
    /// Whether to compute the information. Without it, the gradient is only as small as the likelihood needs.
    pub errors: bool,
}

/// Fits a mixed model.
pub(super) fn fit(data: &ClmmData, task: Task<'_>) -> Option<Fit> {
    let tolerance = task.tolerance;
    let mut search = Search::begin(data, task)?;
    let mut end = search.climb(task);
    // Each pass holds at least one more deviation at 0, or the search ends.
    for _ in 0..=data.loadings.parameters {
        if !search.hold_zeros(task.rough) {
            break;
        }
        end = search.climb(task);
    }
    let is_zero = |parameter: &usize| search.at[data.first_psi() + parameter] == 0.0;
    if data.loadings.independent && data.loadings.deviations.iter().all(is_zero) {
        search.move_to_boundary(task.plain)?;
        return Some(search.finish(FitEnd::Converged, task.plain.information.clone()));
    }
    if end == FitEnd::Diverged || (!task.errors && end == FitEnd::Converged) {
        return Some(search.finish(end, DMatrix::zeros(0, 0)));
    }
    let information = search.polish(tolerance)?;
    let end = if search.gradient() <= 1e3 * tolerance { FitEnd::Converged } else { FitEnd::Stalled };
    Some(search.finish(end, information))
}

impl<'a> Search<'a> {
    /// Starts where the task says, or at the most likely of a few standard deviations with all other parameters from
    /// the fit without random effects.
    fn begin(data: &'a ClmmData, task: Task<'_>) -> Option<Self> {
        let mut best: Option<Self> = None;
        let at = |(intercept, slope): (f64, f64)| {
            let mut at = task.plain.parameters.clone().resize_vertically(data.parameters(), 0.0);
            for (place, &parameter) in data.loadings.deviations.iter().enumerate() {
                at[data.first_psi() + parameter] = if place == 0 { intercept } else { slope };
            }
            at
        };
        let starts: Vec<DVector<f64>> = match task.start {
            Some((start, _)) => vec![start.clone()],
            None => {
                let several = if data.loadings.effects() > 1 { &[(0.6, 1.5), (1.2, 3.0)][..] } else { &[] };
                [(0.25, 0.3), (0.6, 0.3), (1.2, 0.3), (3.0, 0.3)].iter().chain(several).copied().map(at).collect()
            }
        };
        for at in starts {
            let first = || task.start.map_or_else(|| data.modes(), |(_, modes)| modes.clone());
            let mut modes = best.as_ref().map_or_else(first, |best| best.modes.clone());
            if let Some(value) = data.evaluate(&at, &mut modes)
                && best.as_ref().is_none_or(|best| value.loglik > best.value.loglik)
            {
                let free = task.plain.free.iter().copied().chain(data.first_psi()..data.parameters()).collect();
                best = Some(Self { data, free, modes, at, value, inverse: DMatrix::zeros(0, 0) });
            }
        }
        let mut best = best?;
        let similar = task.information.and_then(positive_definite);
        best.inverse = similar.or_else(|| positive_definite(&best.first_information(task.plain)))?.inverse();
        Some(best)
    }

    /// Holds the deviations that are close to 0 at 0, and moves those away again at which another value is better.
    /// Returns whether the search must continue.
    fn hold_zeros(&mut self, rough: bool) -> bool {
        if !self.data.loadings.independent {
            return false;
        }
        let first = self.data.first_psi();
        let indices: Vec<usize> = self.data.loadings.deviations.iter().map(|parameter| first + parameter).collect();
        let is_close = |i: &usize| self.at[*i] != 0.0 && self.at[*i].abs() < NO_SIGMA;
        let close: Vec<usize> = indices.iter().copied().filter(is_close).collect();
        for &index in &close {
            let mut to = self.at.clone();
            to[index] = 0.0;
            if !self.move_to(to) {
                return false;
            }
            if let Ok(place) = self.free.binary_search(&index) {
                self.free.remove(place);
                self.inverse = self.inverse.clone().remove_row(place).remove_column(place);
            }
        }
        let zeros: Vec<usize> = indices.into_iter().filter(|&i| !rough && self.at[i] == 0.0).collect();
        let mut moved = false;
        for index in zeros {
            for sigma in [0.05, 0.5] {
                let before = self.value.loglik;
                let kept = (self.at.clone(), self.value.clone(), self.modes.clone());
                let mut to = self.at.clone();
                to[index] = sigma;
                if self.move_to(to) && self.value.loglik > before + 1e-7 {
                    moved = true;
                    if let Err(place) = self.free.binary_search(&index) {
                        self.free.insert(place, index);
                        self.inverse = self.inverse.clone().insert_row(place, 0.0).insert_column(place, 0.0);
                        self.inverse[(place, place)] = self.effects().recip();
                    }
                    break;
                }
                (self.at, self.value, self.modes) = kept;
            }
        }
        moved || (!close.is_empty() && self.gradient() > 0.0)
    }

    /// Moves to a point; returns whether the likelihood could be computed there.
    fn move_to(&mut self, to: DVector<f64>) -> bool {
        let mut modes = self.modes.clone();
        let Some(value) = self.data.evaluate(&to, &mut modes) else { return false };
        (self.at, self.value, self.modes) = (to, value, modes);
        true
    }

    fn free_gradient(&self) -> DVector<f64> {
        self.value.gradient.select_rows(&self.free)
    }

    fn gradient(&self) -> f64 {
        self.free_gradient().amax()
    }

    fn moved(&self, step: &DVector<f64>) -> DVector<f64> {
        let mut to = self.at.clone();
        for (&index, change) in self.free.iter().zip(step.iter()) {
            to[index] += change;
        }
        to
    }

    /// Tries the full step and then repeatedly halves it. Takes the first step that raises the likelihood enough and
    /// returns the factor by which it was shortened.
    fn take(&mut self, step: &DVector<f64>) -> Option<f64> {
        let slope = self.free_gradient().dot(step);
        let slack = 1e-13 * self.value.loglik.abs();
        halved(|factor| {
            let (to, mut modes) = (self.moved(&(step * factor)), self.modes.clone());
            let value = self.data.evaluate(&to, &mut modes)?;
            let is_enough = value.loglik >= self.value.loglik + 1e-4 * factor * slope - slack;
            is_enough.then(|| {
                (self.at, self.value, self.modes) = (to, value, modes);
                factor
            })
        })
    }

    /// Returns the mean number of effects of a component: about the information on its standard deviation.
    fn effects(&self) -> f64 {
        let loadings = &self.data.loadings;
        (loadings.effects() * self.data.subjects.len()) as f64 / loadings.deviations.len() as f64
    }

    /// Returns the information with which a search begins: that of the model without random effects and, for each ψ, the
    /// number of effects.
    fn first_information(&self, plain: &Fit) -> DMatrix<f64> {
        let mut information = DMatrix::identity(self.free.len(), self.free.len()) * self.effects();
        information.view_mut((0, 0), plain.information.shape()).copy_from(&plain.information);
        information
    }

    /// Takes quasi-Newton steps (Broyden, Fletcher, Goldfarb, Shanno).
    fn climb(&mut self, task: Task<'_>) -> FitEnd {
        const MAX_ITERATIONS: usize = 300;
        // Twice the distance of the log-likelihood from its maximum that is as good as none.
        let small = if task.rough { 1e-4 } else { 1e-9 };
        for iteration in 0..MAX_ITERATIONS {
            checkpoint();
            // Newton's method takes over near the maximum.
            if self.gradient() <= 1e3 * task.tolerance {
                return FitEnd::Converged;
            }
            if self.at.amax() > MAX_PARAMETER {
                return FitEnd::Diverged;
            }
            let before = self.free_gradient();
            let mut step = &self.inverse * &before;
            if !task.errors && iteration > 0 && before.dot(&step) < small {
                return FitEnd::Converged;
            }
            // Limit how far a parameter can jump: a bound that moves by 3 has crossed most of the scale.
            step *= (3.0 / step.amax()).min(1.0);
            let Some(factor) = self.take(&step) else { return FitEnd::Stalled };
            step *= factor;
            let change = before - self.free_gradient();
            update_inverse(&mut self.inverse, &step, &change);
        }
        FitEnd::Stalled
    }

    /// Takes Newton steps with the observed information and returns that information.
    fn polish(&mut self, tolerance: f64) -> Option<DMatrix<f64>> {
        let mut information = self.information()?;
        for _ in 0..5 {
            if self.gradient() <= tolerance {
                break;
            }
            let gradient = self.gradient();
            let step = positive_definite(&information)?.solve(&self.free_gradient());
            let far = step.amax() > 1e-3;
            let kept = (self.at.clone(), self.value.clone());
            if self.take(&step).is_none() || self.gradient() >= gradient {
                // The limit of precision is reached.
                (self.at, self.value) = kept;
                break;
            }
            if far {
                information = self.information()?;
            }
        }
        Some(information)
    }

    /// Returns the observed information: the negative differences of the gradient.
    ///
    /// The differences are taken along directions in which the likelihood changes equally fast. With many ratings, a
    /// single threshold is known a thousand times more precisely than all thresholds together with the participants'
    /// mean, so no single step size would suit both.
    fn information(&self) -> Option<DMatrix<f64>> {
        let size = self.free.len();
        let factor = positive_definite(&self.inverse)?.unpack();
        let change = |index: usize| {
            let direction = factor.column(index).clone_owned();
            self.change(&direction, 3e-4).or_else(|| self.change(&direction, 1e-6))
        };
        let changes: Vec<DVector<f64>> = (0..size).into_par_iter().map(change).collect::<Option<_>>()?;
        let alike = factor.tr_mul(&DMatrix::from_columns(&changes));
        let alike = (&alike + alike.transpose()) / 2.0;
        let back = factor.solve_lower_triangular(&DMatrix::identity(size, size))?;
        Some(back.tr_mul(&alike) * back)
    }

    /// Returns the negative change of the gradient along a direction, per unit of that direction.
    fn change(&self, direction: &DVector<f64>, distance: f64) -> Option<DVector<f64>> {
        let gradient = |sign: f64| {
            let to = self.moved(&(direction * (sign * distance)));
            let value = self.data.evaluate(&to, &mut self.modes.clone())?;
            Some(value.gradient.select_rows(&self.free))
        };
        Some((gradient(-1.0)? - gradient(1.0)?) / (2.0 * distance))
    }

    /// Sets ψ to 0 and all other parameters to the estimates of the model without random effects.
    fn move_to_boundary(&mut self, plain: &Fit) -> Option<()> {
        self.at = plain.parameters.clone().resize_vertically(self.data.parameters(), 0.0);
        self.value = self.data.evaluate(&self.at, &mut self.modes)?;
        self.free.clone_from(&plain.free);
        Some(())
    }

    fn finish(self, end: FitEnd, information: DMatrix<f64>) -> Fit {
        let gradient = self.gradient();
        let Self { free, modes, at, value, .. } = self;
        Fit { parameters: at, loglik: value.loglik, gradient, free, information, modes, end }
    }
}

/// Updates the inverse of a positive definite matrix from a step and the change of the gradient along it.
fn update_inverse(inverse: &mut DMatrix<f64>, step: &DVector<f64>, change: &DVector<f64>) {
    let curvature = step.dot(change);
    if curvature <= 1e-12 * step.norm() * change.norm() {
        return;
    }
    let product = &*inverse * change;
    let factor = (1.0 + change.dot(&product) / curvature) / curvature;
    inverse.ger(factor, step, step, 1.0);
    inverse.ger(-1.0 / curvature, &product, step, 1.0);
    inverse.ger(-1.0 / curvature, step, &product, 1.0);
}
