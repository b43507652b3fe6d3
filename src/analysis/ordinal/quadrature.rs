//! Gauss–Hermite quadrature for the adaptive integration over a normal random effect.

use nalgebra::DMatrix;

/// The most nodes: far more than any likelihood here needs.
pub const MOST_NODES: usize = 100;

/// A node z and its weight w, such that ∫ f(z) dz ≈ √(2π) Σ w f(z) for f near the standard normal density: the
/// weight includes the inverse of the density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// Position, in standard deviations.
    pub z: f64,
    /// Weight; 1 for the only node of the Laplace approximation.
    pub weight: f64,
}

/// The rule with this many nodes, by ascending position, symmetric to the last bit.
///
/// The eigenvalues of the Jacobi matrix (Golub & Welsch 1969) start Newton's iteration on the orthonormal Hermite
/// functions, whose values give the weights without overflow.
pub fn gauss_hermite(nodes: usize) -> Vec<Node> {
    let jacobi = DMatrix::from_fn(nodes, nodes, |row, column| match row.abs_diff(column) {
        1 => (row.max(column) as f64 / 2.0).sqrt(),
        _ => 0.0,
    });
    let mut roots: Vec<f64> = jacobi.symmetric_eigenvalues().iter().copied().collect();
    roots.sort_by(f64::total_cmp);
    let half = nodes / 2;
    let mut rule = vec![Node { z: 0.0, weight: 0.0 }; nodes];
    for index in half..nodes {
        let middle = nodes % 2 == 1 && index == half;
        let root = if middle { 0.0 } else { polish(roots[index], nodes) };
        let (_, before) = hermite_function(root, nodes);
        // ∫ f dx ≈ Σ f(x) / (N ψ²) for ψ the function of degree N − 1; x = z/√2.
        let weight = 1.0 / (nodes as f64 * before * before * std::f64::consts::PI.sqrt());
        rule[index] = Node { z: root * std::f64::consts::SQRT_2, weight };
        rule[nodes - 1 - index] = Node { z: -root * std::f64::consts::SQRT_2, weight };
    }
    rule
}

fn polish(mut root: f64, degree: usize) -> f64 {
    for _ in 0..4 {
        let (value, before) = hermite_function(root, degree);
        root -= value / ((2.0 * degree as f64).sqrt() * before);
    }
    root
}

/// The orthonormal Hermite functions of a degree and of the one before it.
fn hermite_function(x: f64, degree: usize) -> (f64, f64) {
    let mut before = 0.0;
    let mut value = std::f64::consts::PI.powf(-0.25) * (-x * x / 2.0).exp();
    for n in 0..degree {
        let n = n as f64;
        let next = x * (2.0 / (n + 1.0)).sqrt() * value - (n / (n + 1.0)).sqrt() * before;
        before = value;
        value = next;
    }
    (value, before)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rule_of_n_nodes_integrates_the_even_moments_below_2n() {
        for nodes in [1, 2, 5, 10, 31, 100] {
            let rule = gauss_hermite(nodes);
            let mut moment = 1.0;
            for power in 0..nodes.min(12) {
                let sum: f64 =
                    rule.iter().map(|n| n.weight * (-n.z * n.z / 2.0).exp() * n.z.powi(2 * power as i32)).sum();
                assert!((sum / moment - 1.0).abs() < 1e-12, "{nodes} nodes, moment {}: {sum} {moment}", 2 * power);
                moment *= 2.0 * power as f64 + 1.0;
            }
        }
    }
}
