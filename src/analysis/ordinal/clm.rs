//! The cumulative-link model P(Y ≤ j) = F(θ_j − x·β), fitted to counts by Newton's method.
//!
//! β shifts the scale (McCullagh 1980). The signs are those of R's `ordinal` and of `statsmodels`: a positive β means
//! higher ratings. The log-likelihood is concave (Pratt 1981).

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::link::Link;

/// Counts by design row and category, and the design matrix.
#[derive(Clone, Debug)]
pub(super) struct ClmData {
    pub link: Link,
    /// Location; one row per distinct condition.
    pub x: DMatrix<f64>,
    /// A known part of the location.
    pub offset: DVector<f64>,
    /// Number of ratings in each row and category.
    pub counts: DMatrix<f64>,
}

/// How the search for a maximum ended.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum FitEnd {
    /// The gradient is small.
    Converged,
    /// The likelihood keeps rising in this direction, without a maximum: the ratings are separated.
    Separated(DVector<f64>),
    /// A standard deviation, or an effect within participants, grows without bound.
    Diverged,
    /// The search could not continue.
    Stalled,
}

/// A maximum of the likelihood, with or without random effects.
#[derive(Clone, Debug)]
pub(super) struct Fit {
    /// θ, β and, with random effects, ψ, in this order; a deviation may be negative, with the effects that belong to it.
    pub parameters: DVector<f64>,
    pub loglik: f64,
    /// Largest absolute element of the gradient.
    pub gradient: f64,
    /// The indices of the parameters to which the information belongs: those that have finite estimates other than a
    /// standard deviation of 0.
    pub free: Vec<usize>,
    /// Observed information of the free parameters; empty if it was not needed.
    pub information: DMatrix<f64>,
    /// The modes of the participants' effects; none without random effects.
    pub modes: Vec<DVector<f64>>,
    pub end: FitEnd,
}

/// Log-likelihood, gradient and negative Hessian.
struct Derivatives {
    loglik: f64,
    gradient: DVector<f64>,
    information: DMatrix<f64>,
}

/// Returns the largest gradient that counts as zero. Up to 10,000 ratings, it can and must fall below 1e-9; beyond, rounding
/// errors grow with the number of ratings.
pub(super) fn tolerance(ratings: f64) -> f64 {
    1e-9 * (ratings / 1e4).max(1.0)
}

impl ClmData {
    pub fn categories(&self) -> usize {
        self.counts.ncols()
    }

    pub fn thresholds(&self) -> usize {
        self.categories() - 1
    }

    pub fn parameters(&self) -> usize {
        self.thresholds() + self.x.ncols()
    }

    pub fn ratings(&self) -> f64 {
        self.counts.sum()
    }

    /// Returns starting values: thresholds that reproduce the pooled ratings, and 0 for everything else.
    fn start(&self) -> DVector<f64> {
        let mut parameters = DVector::zeros(self.parameters());
        let total = self.ratings();
        let mut below = 0.0;
        for j in 0..self.thresholds() {
            below += self.counts.column(j).sum();
            parameters[j] = self.link.quantile(below / total);
        }
        parameters
    }

    /// Returns θ_j − x·β for each row and threshold: the bounds of the categories, without the known part of the location.
    fn shifts(&self, parameters: &DVector<f64>) -> DMatrix<f64> {
        let location = &self.x * parameters.rows(self.thresholds(), self.x.ncols());
        DMatrix::from_fn(self.x.nrows(), self.thresholds(), |row, j| parameters[j] - location[row])
    }

    /// Returns the log-likelihood, which is not finite if a rating that occurs has no probability, and its derivatives.
    fn derivatives(&self, parameters: &DVector<f64>) -> Derivatives {
        let (rows, thresholds) = (self.x.nrows(), self.thresholds());
        let shifts = self.shifts(parameters);
        let mut loglik = 0.0;
        let mut information = DMatrix::zeros(self.parameters(), self.parameters());
        // The derivative with respect to each bound, and the information on each bound together with all others.
        let (mut slopes, mut weights) = (DMatrix::zeros(rows, thresholds), DMatrix::zeros(rows, thresholds));
        for row in 0..rows {
            let bounds: Vec<f64> = shifts.row(row).iter().map(|shift| shift - self.offset[row]).collect();
            for k in 0..self.categories() {
                let count = self.counts[(row, k)];
                if count <= 0.0 {
                    continue;
                }
                let (a, b) = category_bounds(&bounds, k);
                let cell = self.link.cell(a, b);
                loglik += count * cell.log_p;
                let is_inner = k > 0 && k < thresholds;
                let mixed = if is_inner { count * cell.ab } else { 0.0 };
                for (j, first, second) in [(k, cell.a, cell.aa), (k.wrapping_sub(1), cell.b, cell.bb)] {
                    if j < thresholds {
                        slopes[(row, j)] += count * first;
                        information[(j, j)] -= count * second;
                        weights[(row, j)] -= count * second + mixed;
                    }
                }
                if is_inner {
                    information[(k, k - 1)] -= mixed;
                    information[(k - 1, k)] -= mixed;
                }
            }
        }
        let whole = weights.column_sum();
        let weighted = DMatrix::from_fn(rows, self.x.ncols(), |row, column| whole[row] * self.x[(row, column)]);
        let cross = -weights.tr_mul(&self.x);
        information.columns_range_mut(thresholds..).rows_range_mut(..thresholds).copy_from(&cross);
        information.columns_range_mut(..thresholds).rows_range_mut(thresholds..).tr_copy_from(&cross);
        let own = self.x.tr_mul(&weighted);
        information.columns_range_mut(thresholds..).rows_range_mut(thresholds..).copy_from(&own);
        let by_location = -self.x.tr_mul(&slopes.column_sum());
        let gradient = slopes.row_sum().iter().chain(by_location.iter()).copied().collect::<Vec<f64>>().into();
        Derivatives { loglik, gradient, information }
    }

    /// If the likelihood keeps rising along a step, without a maximum, returns its direction, with ±1 as its largest element:
    /// no rating's upper bound falls, no lower bound rises, and at least one bound moves (Albert & Anderson 1984, for ordered
    /// categories).
    fn recession(&self, step: &DVector<f64>) -> Option<DVector<f64>> {
        const SLACK: f64 = 1e-3;
        let direction = (step / step.amax()).map(|element| if element.abs() < 1e-2 { 0.0 } else { element });
        let (mut least, mut most): (f64, f64) = (0.0, 0.0);
        let moves = self.shifts(&direction);
        for row in 0..self.counts.nrows() {
            for k in (0..self.categories()).filter(|k| self.counts[(row, *k)] > 0.0) {
                for (j, sign) in [(k.wrapping_sub(1), -1.0), (k, 1.0)] {
                    if let Some(bound) = moves.get((row, j)) {
                        (least, most) = (least.min(sign * bound), most.max(sign * bound));
                    }
                }
            }
        }
        (most > 0.1 && least > -SLACK * most).then_some(direction)
    }

    /// Finds the maximum of the likelihood by Newton's method with step halving.
    pub fn fit(&self) -> Fit {
        const MAX_ITERATIONS: usize = 200;
        let tolerance = tolerance(self.ratings());
        let mut parameters = self.start();
        let mut current = self.derivatives(&parameters);
        let mut end = FitEnd::Stalled;
        for _ in 0..MAX_ITERATIONS {
            if !current.loglik.is_finite() {
                break;
            }
            // Newton's step, or that of steepest ascent.
            let factor = positive_definite(&current.information);
            let step = factor.map_or_else(|| current.gradient.clone(), |factor| factor.solve(&current.gradient));
            let (gradient, reach) = (current.gradient.amax(), self.shifts(&step).amax());
            if gradient <= tolerance && reach < 1e-6 {
                end = FitEnd::Converged;
                break;
            }
            if gradient < 10.0 * tolerance
                && reach > 1e-3
                && let Some(direction) = self.recession(&step)
            {
                end = FitEnd::Separated(direction);
                break;
            }
            let slack = 1e-13 * current.loglik.abs();
            // The first point that does not lower the likelihood.
            let next = halved(|factor| {
                let candidate = &parameters + &step * factor;
                let there = (candidate != parameters).then(|| self.derivatives(&candidate))?;
                (there.loglik >= current.loglik - slack).then_some((candidate, there))
            });
            let Some(next) = next else {
                // Rounding errors limit the precision; this is the best possible.
                if gradient < 1e3 * tolerance {
                    end = FitEnd::Converged;
                }
                break;
            };
            (parameters, current) = next;
        }
        let is_finite = |index: &usize| !matches!(&end, FitEnd::Separated(direction) if direction[*index] != 0.0);
        let free: Vec<usize> = (0..parameters.len()).filter(is_finite).collect();
        Fit {
            loglik: current.loglik,
            gradient: current.gradient.amax(),
            information: current.information.select_rows(&free).select_columns(&free),
            free,
            modes: Vec::new(),
            parameters,
            end,
        }
    }
}

/// Tries the factor 1 of a step and then repeatedly half of it, and returns the first result.
pub(super) fn halved<T>(of: impl FnMut(f64) -> Option<T>) -> Option<T> {
    std::iter::successors(Some(1.0), |factor| Some(factor / 2.0)).take(40).find_map(of)
}

/// Returns the upper and the lower bound of a category.
#[inline]
pub(super) fn category_bounds(bounds: &[f64], category: usize) -> (f64, f64) {
    let upper = bounds.get(category).copied().unwrap_or(f64::INFINITY);
    let lower = if category == 0 { f64::NEG_INFINITY } else { bounds[category - 1] };
    (upper, lower)
}

/// Returns the Cholesky factor of a matrix. If the matrix has none, its diagonal is increased by as little as possible.
/// Returns `None` if an element is not a number.
pub(super) fn positive_definite(matrix: &DMatrix<f64>) -> Option<Cholesky<f64, Dyn>> {
    let largest = matrix.diagonal().amax().max(f64::MIN_POSITIVE);
    let mut ridge = 0.0;
    while ridge <= 10.0 * largest {
        let raised = matrix + DMatrix::identity(matrix.nrows(), matrix.nrows()) * ridge;
        if let Some(factor) = raised.cholesky() {
            return Some(factor);
        }
        ridge = if ridge == 0.0 { 1e-14 * largest } else { ridge * 10.0 };
    }
    None
}
