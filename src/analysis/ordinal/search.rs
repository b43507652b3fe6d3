//! The search for the maximum of a mixed model's likelihood and for the observed information at the maximum.

use nalgebra::{DMatrix, DVector};

use super::{
    clm::positive_definite,
    clmm::{ClmmData, Evaluation, Modes},
};

/// A standard deviation below this counts as 0.
const NO_SIGMA: f64 = 1e-4;
/// A parameter above this counts as having no finite estimate. Columns are standardized to a size of 1.
const MAX_PARAMETER: f64 = 60.0;

/// How a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MixedFitEnd {
    /// The gradient is small.
    Converged,
    /// The standard deviation is 0.
    Boundary,
    /// The standard deviation, or an effect within participants, grows without bound.
    Diverged,
    /// The search could not continue.
    Stalled,
}

/// A maximum of a mixed model's likelihood.
#[derive(Clone, Debug)]
pub(super) struct MixedFit {
    /// θ, β and σ ≥ 0.
    pub parameters: DVector<f64>,
    pub loglik: f64,
    /// Largest absolute element of the gradient over the free parameters.
    pub gradient: f64,
    /// Observed information of the free parameters.
    pub information: DMatrix<f64>,
    pub modes: Modes,
    pub iterations: usize,
    pub end: MixedFitEnd,
}

/// A search over the free parameters; all others keep their starting values.
struct Search<'a> {
    data: &'a ClmmData,
    free: &'a [usize],
    modes: Modes,
    at: DVector<f64>,
    value: Evaluation,
}

/// Fits a mixed model, starting from the estimates of the model without a random intercept (θ and β). `free` lists the
/// indices of the parameters that may change, in order; the last is σ. Without `errors`, there is no information
/// matrix, and the gradient is only as small as the likelihood needs.
pub(super) fn fit(
    data: &ClmmData,
    start: &DVector<f64>,
    free: &[usize],
    tolerance: f64,
    errors: bool,
) -> Option<MixedFit> {
    let mut search = Search::begin(data, start, free)?;
    let (iterations, end) = search.climb(tolerance);
    let sigma = data.parameters() - 1;
    if search.at[sigma].abs() < NO_SIGMA {
        search.move_to_boundary(start)?;
        return search.finish(iterations, MixedFitEnd::Boundary, DMatrix::zeros(0, 0));
    }
    if end == MixedFitEnd::Diverged {
        return search.finish(iterations, end, DMatrix::zeros(0, 0));
    }
    if !errors && end == MixedFitEnd::Converged {
        return search.finish(iterations, end, DMatrix::zeros(0, 0));
    }
    let information = search.polish(tolerance)?;
    let end = if search.gradient() <= 1e3 * tolerance { MixedFitEnd::Converged } else { MixedFitEnd::Stalled };
    search.finish(iterations, end, information)
}

impl<'a> Search<'a> {
    /// Starts at the most likely of a few standard deviations; all other parameters start from the fit without a random
    /// intercept.
    fn begin(data: &'a ClmmData, start: &DVector<f64>, free: &'a [usize]) -> Option<Self> {
        let mut best: Option<Self> = None;
        for sigma in [0.25, 0.6, 1.2, 3.0] {
            let at = start.clone().insert_row(start.len(), sigma);
            let mut modes = best.as_ref().map_or_else(|| data.modes(), |best| best.modes.clone());
            if let Some(value) = data.evaluate(&at, &mut modes)
                && best.as_ref().is_none_or(|best| value.loglik > best.value.loglik)
            {
                best = Some(Self { data, free, modes, at, value });
            }
        }
        best
    }

    fn free_gradient(&self) -> DVector<f64> {
        DVector::from_iterator(self.free.len(), self.free.iter().map(|&index| self.value.gradient[index]))
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
        let mut factor = 1.0;
        for _ in 0..40 {
            let to = self.moved(&(step * factor));
            let mut modes = self.modes.clone();
            if let Some(value) = self.data.evaluate(&to, &mut modes)
                && value.loglik >= self.value.loglik + 1e-4 * factor * slope - slack
            {
                (self.at, self.value, self.modes) = (to, value, modes);
                return Some(factor);
            }
            factor /= 2.0;
        }
        None
    }

    /// Takes quasi-Newton steps (Broyden, Fletcher, Goldfarb, Shanno), starting from the approximate information.
    fn climb(&mut self, tolerance: f64) -> (usize, MixedFitEnd) {
        const MAX_ITERATIONS: usize = 300;
        let rough = self.data.rough_information(&self.at, &self.modes).select_rows(self.free).select_columns(self.free);
        let Some(factor) = positive_definite(&rough) else { return (0, MixedFitEnd::Stalled) };
        let mut inverse = factor.inverse();
        for iteration in 0..MAX_ITERATIONS {
            // Newton's method takes over near the maximum.
            if self.gradient() <= 1e3 * tolerance {
                return (iteration, MixedFitEnd::Converged);
            }
            if self.at.amax() > MAX_PARAMETER {
                return (iteration, MixedFitEnd::Diverged);
            }
            let before = self.free_gradient();
            let mut step = &inverse * &before;
            // Limit how far a parameter can jump: a bound that moves by 3 has crossed most of the scale.
            step *= (3.0 / step.amax()).min(1.0);
            let Some(factor) = self.take(&step) else { return (iteration, MixedFitEnd::Stalled) };
            step *= factor;
            let change = before - self.free_gradient();
            update_inverse(&mut inverse, &step, &change);
        }
        (MAX_ITERATIONS, MixedFitEnd::Stalled)
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
        let rough = self.data.rough_information(&self.at, &self.modes).select_rows(self.free).select_columns(self.free);
        let factor = positive_definite(&rough)?.unpack();
        let size = self.free.len();
        let directions = factor.transpose().solve_upper_triangular(&DMatrix::identity(size, size))?;
        let mut changes = DMatrix::zeros(size, size);
        for (index, direction) in directions.column_iter().enumerate() {
            let direction = direction.clone_owned();
            let change = self.change(&direction, 1e-3).or_else(|| self.change(&direction, 1e-6))?;
            changes.set_column(index, &change);
        }
        let alike = factor.solve_lower_triangular(&changes)?;
        let alike = (&alike + alike.transpose()) / 2.0;
        Some(&factor * alike * factor.transpose())
    }

    /// Returns the negative change of the gradient along a direction, per unit of that direction.
    fn change(&self, direction: &DVector<f64>, distance: f64) -> Option<DVector<f64>> {
        let gradient = |sign: f64| {
            let to = self.moved(&(direction * (sign * distance)));
            let value = self.data.evaluate(&to, &mut self.modes.clone())?;
            Some(DVector::from_iterator(self.free.len(), self.free.iter().map(|&index| value.gradient[index])))
        };
        Some((gradient(-1.0)? - gradient(1.0)?) / (2.0 * distance))
    }

    /// Sets σ to 0 and all other parameters to the estimates of the model without a random intercept.
    fn move_to_boundary(&mut self, start: &DVector<f64>) -> Option<()> {
        self.at = start.clone().insert_row(start.len(), 0.0);
        self.value = self.data.evaluate(&self.at, &mut self.modes)?;
        Some(())
    }

    fn finish(mut self, iterations: usize, end: MixedFitEnd, information: DMatrix<f64>) -> Option<MixedFit> {
        let sigma = self.at.len() - 1;
        if self.at[sigma] < 0.0 {
            self.at[sigma] = -self.at[sigma];
            self.modes.u.iter_mut().for_each(|u| *u = -*u);
        }
        let gradient = self.gradient();
        let Self { modes, at, value, .. } = self;
        Some(MixedFit { parameters: at, loglik: value.loglik, gradient, information, modes, iterations, end })
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
