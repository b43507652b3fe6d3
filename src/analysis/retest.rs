//! Agreement of a subject with themselves: weighted κ between first and second ratings.

/// First against second ratings: how often each pair of categories occurred.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Retest {
    categories: usize,
    counts: Vec<u64>,
}

impl Retest {
    /// An empty table for a number of categories.
    pub fn new(categories: usize) -> Self {
        Self { categories, counts: vec![0; categories * categories] }
    }

    /// Adds a condition's first and second rating, categories from 0; false if one of them is none of the table's.
    pub fn add(&mut self, first: usize, second: usize) -> bool {
        let inside = first < self.categories && second < self.categories;
        if inside {
            self.counts[first * self.categories + second] += 1;
        }
        inside
    }

    /// Pairs in the table.
    pub fn pairs(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// Cohen's κ (1968) with quadratic weights: 1 perfect agreement, 0 what chance gives. None without pairs, or where all
    /// ratings are the same category.
    pub fn kappa(&self) -> Option<f64> {
        let k = self.categories;
        let row = |i: usize| self.counts[i * k..(i + 1) * k].iter().sum::<u64>() as f64;
        let column = |j: usize| (0..k).map(|i| self.counts[i * k + j]).sum::<u64>() as f64;
        let n = self.pairs() as f64;
        let (mut observed, mut expected) = (0.0, 0.0);
        for i in 0..k {
            for j in 0..k {
                let weight = (i.abs_diff(j) as f64).powi(2);
                observed += weight * self.counts[i * k + j] as f64;
                expected += weight * row(i) * column(j) / n;
            }
        }
        (expected > 0.0).then(|| 1.0 - observed / expected)
    }
}
