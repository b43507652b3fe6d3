//! Tests on the ranks of participants' mean ratings: Friedman's test with Kendall's W, and Wilcoxon's signed-rank test
//! with Holm's correction.

use serde::Serialize;

use super::{
    counts::Counts,
    ordinal::{chi_squared_tail, two_sided},
    summary::category_values,
};

/// Participants' mean ratings at each level of a factor, pooled over all other factors. If all means are over the same
/// number of ratings, they have the same ranks as the sums.
#[derive(Clone, Debug, PartialEq)]
pub struct SubjectMeans {
    pub levels: Vec<String>,
    /// Participants with ratings at every level, each with their means in the order of the levels.
    pub rows: Vec<(String, Vec<f64>)>,
    /// Participants excluded because they did not rate every level.
    pub incomplete: Vec<String>,
}

impl SubjectMeans {
    /// Computes the means at those levels of a factor that have ratings.
    pub fn new(counts: &Counts, factor: usize) -> Self {
        let values = category_values(counts);
        let levels = counts.factors[factor].levels.len();
        let mut cells = vec![vec![(0_u64, 0.0); levels]; counts.subjects.len()];
        for row in &counts.rows {
            if let Some(level) = counts.conditions[row.condition as usize][factor] {
                let cell = &mut cells[row.subject as usize][level as usize];
                cell.0 += row.count;
                cell.1 += row.count as f64 * values[row.rating as usize];
            }
        }
        let used: Vec<usize> = (0..levels).filter(|&level| cells.iter().any(|cells| cells[level].0 > 0)).collect();
        let mut means = Self {
            levels: used.iter().map(|&level| counts.factors[factor].levels[level].clone()).collect(),
            rows: Vec::new(),
            incomplete: Vec::new(),
        };
        for (subject, cells) in counts.subjects.iter().zip(cells) {
            if used.iter().all(|&level| cells[level].0 > 0) {
                let row = used.iter().map(|&level| cells[level].1 / cells[level].0 as f64).collect();
                means.rows.push((subject.clone(), row));
            } else {
                means.incomplete.push(subject.clone());
            }
        }
        means
    }
}

/// Friedman's test of whether all levels are rated alike, and how well participants agree in ranking them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Friedman {
    pub subjects: usize,
    pub levels: usize,
    /// Friedman's χ², corrected for ties.
    pub chi_squared: f64,
    /// Degrees of freedom.
    pub df: usize,
    /// Probability from the χ² distribution.
    pub p: f64,
    /// Kendall's coefficient of concordance W, corrected for ties: 0 is no agreement, and 1 means that all participants
    /// rank the levels alike.
    pub w: f64,
}

/// Performs Friedman's test. Returns `None` if there are fewer than two participants or levels, or if every participant
/// rates all levels alike.
pub fn friedman(means: &SubjectMeans) -> Option<Friedman> {
    let (n, k) = (means.rows.len(), means.levels.len());
    if n < 2 || k < 2 {
        return None;
    }
    let mut sums = vec![0.0; k];
    let mut ties = 0.0;
    for (_, row) in &means.rows {
        let (ranks, tied) = ranks(row);
        ties += tied;
        for (sum, rank) in sums.iter_mut().zip(ranks) {
            *sum += rank;
        }
    }
    let (subjects, levels) = (n as f64, k as f64);
    let squares: f64 = sums.iter().map(|sum| (sum - subjects * (levels + 1.0) / 2.0).powi(2)).sum();
    let most = subjects * levels * (levels + 1.0) / 12.0 - ties / (12.0 * (levels - 1.0));
    if most <= 0.0 {
        return None;
    }
    let chi_squared = squares / most;
    let df = k - 1;
    Some(Friedman {
        subjects: n,
        levels: k,
        chi_squared,
        df,
        p: chi_squared_tail(chi_squared, df),
        w: chi_squared / (subjects * df as f64),
    })
}

/// Returns the mid-ranks, starting at 1, and Σ(t³ − t) over the groups of ties.
pub(crate) fn ranks(values: &[f64]) -> (Vec<f64>, f64) {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|l, r| values[*l].total_cmp(&values[*r]));
    let mut ranks = vec![0.0; values.len()];
    let mut ties = 0.0;
    let mut first = 0;
    for group in order.chunk_by(|l, r| values[*l] == values[*r]) {
        let size = group.len() as f64;
        for &index in group {
            ranks[index] = first as f64 + (size + 1.0) / 2.0;
        }
        ties += size * (size * size - 1.0);
        first += group.len();
    }
    (ranks, ties)
}

/// How a p value was computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum PMethod {
    /// From all possible assignments of signs.
    Exact,
    /// From the normal distribution, corrected for ties and continuity.
    Normal,
}

/// Wilcoxon's signed-rank test of paired differences.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Wilcoxon {
    /// Number of differences that are not 0.
    pub n: usize,
    /// Number of differences that are 0. They are excluded (Wilcoxon 1945; the default in R and SciPy).
    pub zeros: usize,
    /// Sum of the ranks of the positive differences, R's V.
    pub v: f64,
    /// Two-sided probability.
    pub p: f64,
    /// How the probability was computed.
    pub method: PMethod,
}

/// The probability is exact for up to this many differences.
pub const EXACT_DIFFERENCES: usize = 50;

/// Performs Wilcoxon's signed-rank test. p is 1 if all differences are 0.
///
/// The exact distribution covers all 2ⁿ assignments of signs to the actual ranks, with mid-ranks for ties. It is
/// computed with the shift algorithm of Streitberg & Röhmel (1986).
pub fn wilcoxon(differences: &[f64]) -> Wilcoxon {
    // Means that differ only by rounding errors count as equal.
    let scale = differences.iter().fold(0.0_f64, |most, difference| most.max(difference.abs()));
    let kept: Vec<f64> = differences.iter().copied().filter(|d| d.abs() > 1e-12 * scale).collect();
    let sizes: Vec<f64> = kept.iter().map(|difference| rounded(difference.abs(), scale)).collect();
    let (ranks, ties) = ranks(&sizes);
    let v: f64 = kept.iter().zip(&ranks).filter(|(difference, _)| **difference > 0.0).map(|(_, rank)| rank).sum();
    let exact = kept.len() <= EXACT_DIFFERENCES;
    Wilcoxon {
        n: kept.len(),
        zeros: differences.len() - kept.len(),
        v,
        p: if exact { exact_probability(&ranks, v) } else { normal_probability(kept.len() as f64, ties, v) },
        method: if exact { PMethod::Exact } else { PMethod::Normal },
    }
}

/// Rounds to 12 digits relative to `scale`, so that equal differences of rounded means are ties.
fn rounded(value: f64, scale: f64) -> f64 {
    (value / scale * 1e12).round()
}

fn exact_probability(ranks: &[f64], v: f64) -> f64 {
    // Mid-ranks are multiples of ½, so doubling makes them whole numbers.
    let doubled: Vec<usize> = ranks.iter().map(|rank| (2.0 * rank).round() as usize).collect();
    let total: usize = doubled.iter().sum();
    let mut ways = vec![0.0_f64; total + 1];
    ways[0] = 1.0;
    for rank in doubled {
        for sum in (rank..=total).rev() {
            ways[sum] += ways[sum - rank];
        }
    }
    let all = 2.0_f64.powi(ranks.len() as i32);
    let at = (2.0 * v).round() as usize;
    let below: f64 = ways[..=at].iter().sum();
    let above: f64 = ways[at..].iter().sum();
    (2.0 * below.min(above) / all).min(1.0)
}

fn normal_probability(n: f64, ties: f64, v: f64) -> f64 {
    let variance = n * (n + 1.0) * (2.0 * n + 1.0) / 24.0 - ties / 48.0;
    let distance = ((v - n * (n + 1.0) / 4.0).abs() - 0.5).max(0.0);
    two_sided(distance / variance.sqrt())
}

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

/// A comparison of two levels.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Pair {
    pub level: String,
    pub other: String,
    /// Mean over participants of the difference in mean rating, first level minus other level.
    pub difference: f64,
    pub test: Wilcoxon,
    /// The probability, corrected for all pairs.
    pub p_holm: f64,
}

/// All pairs of levels.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Pairs {
    pub pairs: Vec<Pair>,
    /// The smallest corrected probability that is possible with this number of participants and pairs.
    pub least_p: f64,
}

impl Pairs {
    /// Returns whether no result could reach a significance level such as 0.05. If so, comparing pairs is pointless.
    pub fn cannot_reach(&self, alpha: f64) -> bool {
        !self.pairs.is_empty() && self.least_p > alpha
    }
}

/// Compares all pairs of levels by Wilcoxon's test, with Holm's correction.
pub fn pairs(means: &SubjectMeans) -> Pairs {
    let mut pairs = Vec::new();
    for first in 0..means.levels.len() {
        for second in first + 1..means.levels.len() {
            let differences: Vec<f64> = means.rows.iter().map(|(_, row)| row[first] - row[second]).collect();
            pairs.push(Pair {
                level: means.levels[first].clone(),
                other: means.levels[second].clone(),
                difference: differences.iter().sum::<f64>() / differences.len().max(1) as f64,
                test: wilcoxon(&differences),
                p_holm: 1.0,
            });
        }
    }
    let corrected = holm(&pairs.iter().map(|pair| pair.test.p).collect::<Vec<_>>());
    for (pair, p) in pairs.iter_mut().zip(corrected) {
        pair.p_holm = p;
    }
    let least = 2.0_f64.powi(1 - means.rows.len().min(1000) as i32);
    Pairs { least_p: (pairs.len() as f64 * least).min(1.0), pairs }
}
