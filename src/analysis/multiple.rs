//! Correction of probabilities for multiple testing.

/// Corrects probabilities for multiple testing by Holm's method (1979). The results are in the order of
/// `probabilities`.
pub fn holm(probabilities: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..probabilities.len()).collect();
    order.sort_by(|l, r| probabilities[*l].total_cmp(&probabilities[*r]));
    let mut corrected = vec![0.0; probabilities.len()];
    let mut most: f64 = 0.0;
    for (rank, index) in order.into_iter().enumerate() {
        most = most.max((probabilities.len() - rank) as f64 * probabilities[index]).min(1.0);
        corrected[index] = most;
    }
    corrected
}
