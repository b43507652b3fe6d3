//! Tests on ranks of subjects' mean ratings: Friedman's with Kendall's W, Wilcoxon's signed-rank test with Holm's
//! correction.

use serde::Serialize;

use super::{
    counts::Counts,
    ordinal::{chi_squared_tail, two_sided},
    summary::category_values,
};

/// Subjects' mean ratings at each level of a factor, over everything else. With equally many ratings everywhere these
/// rank as the sums do.
#[derive(Clone, Debug, PartialEq)]
pub struct SubjectMeans {
    /// Names of the levels.
    pub levels: Vec<String>,
    /// Subjects with ratings at every level, and their means in the order of the levels.
    pub rows: Vec<(String, Vec<f64>)>,
    /// Subjects excluded because they did not rate every level.
    pub incomplete: Vec<String>,
}

impl SubjectMeans {
    /// The means at the levels of a factor that have ratings.
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

/// Friedman's test that all levels are rated alike, and how well subjects agree in ranking them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Friedman {
    pub subjects: usize,
    pub levels: usize,
    /// Friedman's χ², corrected for ties.
    pub chi_squared: f64,
    /// Degrees of freedom.
    pub df: usize,
    /// Probability by the χ² distribution.
    pub p: f64,
    /// Kendall's coefficient of concordance W, corrected for ties: 0 no agreement, 1 all the same order.
    pub w: f64,
}

/// Friedman's test; none with fewer than two subjects or levels, or where every subject rates all levels alike.
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

/// Mid-ranks from 1, and Σ(t³ − t) over the groups of ties.
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
    /// From all assignments of signs.
    Exact,
    /// By the normal distribution, corrected for ties and continuity.
    Normal,
}

/// Wilcoxon's signed-rank test of paired differences.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Wilcoxon {
    /// Differences that are not 0.
    pub n: usize,
    /// Differences of 0, which are excluded (Wilcoxon 1945; the default of R and SciPy).
    pub zeros: usize,
    /// Sum of the ranks of the positive differences, R's V.
    pub v: f64,
    /// Two-sided probability.
    pub p: f64,
    /// How it was computed.
    pub method: PMethod,
}

/// Up to how many differences the probability is exact.
pub const EXACT_DIFFERENCES: usize = 50;

/// Wilcoxon's signed-rank test; p is 1 where all differences are 0.
///
/// The exact distribution is that of the ranks at hand, mid-ranks for ties, under all 2ⁿ signs: the shift algorithm of
/// Streitberg & Röhmel (1986).
pub fn wilcoxon(differences: &[f64]) -> Wilcoxon {
    // Means that differ by rounding are the same mean.
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

/// To 12 digits of the scale, so that equal differences of rounded means are ties.
fn rounded(value: f64, scale: f64) -> f64 {
    (value / scale * 1e12).round()
}

fn exact_probability(ranks: &[f64], v: f64) -> f64 {
    // Mid-ranks are halves: doubled, they are whole numbers.
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

/// Probabilities corrected for their number by Holm's method (1979), in the order given.
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

/// Two levels compared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Pair {
    pub level: String,
    pub other: String,
    /// Mean over subjects of the first level's mean rating less the other's.
    pub difference: f64,
    pub test: Wilcoxon,
    /// Its probability corrected for all pairs.
    pub p_holm: f64,
}

/// All pairs of levels.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Pairs {
    /// The comparisons.
    pub pairs: Vec<Pair>,
    /// The smallest corrected probability possible with this number of subjects and pairs.
    pub least_p: f64,
}

impl Pairs {
    /// Whether no result could reach a level such as 0.05, which makes the comparison of pairs meaningless.
    pub fn cannot_reach(&self, alpha: f64) -> bool {
        !self.pairs.is_empty() && self.least_p > alpha
    }
}

/// Compares every level with every other by Wilcoxon's test, with Holm's correction.
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
