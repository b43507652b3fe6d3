//! Numerical methods that the analyses of tasks share: a search for the maximum, Gaussian quadrature, and the curvature
//! of a function.

use std::array::from_fn;

use nalgebra::{DMatrix, SMatrix};

/// A search for a maximum ends after this many values of the function.
const MAX_VALUES: usize = 4_000;

/// Returns the highest point that the downhill simplex method of Nelder & Mead (1965, Comput. J. 7, 308) finds from
/// `start`, and its value. A coordinate whose step is 0 stays. The function may be −∞, but not at the start. The search
/// is repeated from its result until that improves by less than `tolerance`, so that a simplex that has become flat does
/// not end it.
pub(super) fn highest<const N: usize>(
    function: impl Fn(&[f64; N]) -> f64,
    start: [f64; N],
    steps: [f64; N],
    tolerance: f64,
) -> ([f64; N], f64) {
    let mut best = (start, function(&start));
    for _ in 0..8 {
        let next = climb(&function, best, steps, tolerance);
        let gain = next.1 - best.1;
        best = next;
        if gain < tolerance {
            break;
        }
    }
    best
}

/// One run of the simplex.
fn climb<const N: usize>(
    function: &impl Fn(&[f64; N]) -> f64,
    start: ([f64; N], f64),
    steps: [f64; N],
    tolerance: f64,
) -> ([f64; N], f64) {
    // NaN, where a function has no value, is lower than everything.
    let valued = |x: [f64; N]| (x, Some(function(&x)).filter(|value| !value.is_nan()).unwrap_or(f64::NEG_INFINITY));
    let free = (0..N).filter(|&axis| steps[axis] != 0.0);
    let mut simplex = vec![start];
    simplex.extend(free.map(|axis| valued(from_fn(|i| start.0[i] + if i == axis { steps[i] } else { 0.0 }))));
    let size = simplex.len() - 1;
    for _ in 0..MAX_VALUES {
        simplex.sort_by(|l, r| r.1.total_cmp(&l.1));
        if size == 0 || simplex[0].1 - simplex[size].1 < tolerance {
            break;
        }
        let center: [f64; N] = from_fn(|i| simplex[..size].iter().map(|(x, _)| x[i]).sum::<f64>() / size as f64);
        let worst = simplex[size];
        let toward = |share: f64| valued(from_fn(|i| center[i] + share * (worst.0[i] - center[i])));
        let reflected = toward(-1.0);
        let next = if reflected.1 > simplex[0].1 {
            Some(toward(-2.0)).filter(|expanded| expanded.1 > reflected.1).or(Some(reflected))
        } else if reflected.1 > simplex[size - 1].1 {
            Some(reflected)
        } else {
            let contracted = toward(if reflected.1 > worst.1 { -0.5 } else { 0.5 });
            Some(contracted).filter(|contracted| contracted.1 > worst.1.max(reflected.1))
        };
        match next {
            Some(next) => simplex[size] = next,
            None => {
                let best = simplex[0].0;
                simplex[1..].iter_mut().for_each(|(x, value)| {
                    (*x, *value) = valued(from_fn(|i| f64::midpoint(best[i], x[i])));
                });
            }
        }
    }
    simplex[0]
}

/// Returns the second derivatives of a function by differences with these steps; 0 for a coordinate whose step is 0.
pub(super) fn curvature<const N: usize>(
    function: impl Fn(&[f64; N]) -> f64,
    at: &[f64; N],
    steps: [f64; N],
) -> SMatrix<f64, N, N> {
    let middle = function(at);
    let shifted = |(i, by): (usize, f64), (j, other): (usize, f64)| {
        let mut x = *at;
        x[i] += by * steps[i];
        x[j] += other * steps[j];
        function(&x)
    };
    SMatrix::from_fn(|i, j| match (steps[i] * steps[j], i == j) {
        (0.0, _) => 0.0,
        (area, true) => (shifted((i, 1.0), (i, 0.0)) - 2.0 * middle + shifted((i, -1.0), (i, 0.0))) / area,
        (area, false) => {
            let [same, other] = [1.0, -1.0].map(|sign| shifted((i, 1.0), (j, sign)) + shifted((i, -1.0), (j, -sign)));
            (same - other) / (4.0 * area)
        }
    })
}

/// Returns the nodes and weights of the Gauss–Legendre rule on 0…1, in ascending order; the weights sum to 1 (Golub &
/// Welsch 1969, Math. Comput. 23, 221).
pub(super) fn legendre(nodes: usize) -> Vec<(f64, f64)> {
    let coefficient = |k: f64| k / (4.0 * k * k - 1.0).sqrt();
    let beside = |i: usize, j: usize| if i.abs_diff(j) == 1 { coefficient(i.max(j) as f64) } else { 0.0 };
    let eigen = DMatrix::from_fn(nodes, nodes, beside).symmetric_eigen();
    let weights = (0..nodes).map(|column| eigen.eigenvectors[(0, column)].powi(2));
    let mut rule: Vec<(f64, f64)> =
        eigen.eigenvalues.iter().map(|node| f64::midpoint(1.0, *node)).zip(weights).collect();
    rule.sort_by(|l, r| l.0.total_cmp(&r.0));
    rule
}
