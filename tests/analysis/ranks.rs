//! Rank tests and agreement against SciPy, `krippendorff` and scikit-learn; the values and the script that made them,
//! with versions, are in `tests/golden/ordinal/ranks.csv` and `scripts/golden_ordinal.py`.

use machband::analysis::{
    agreement::{Retest, ordinal_alpha},
    bootstrap::Bootstrap,
    rank_tests::{PMethod, SubjectMeans, friedman, holm, pairs, wilcoxon},
};

use crate::golden::{counts, read};

fn close(found: f64, expected: &str, what: &[String]) {
    let expected: f64 = expected.parse().unwrap();
    assert!((found - expected).abs() < 1e-9 * (1.0 + expected.abs()), "{what:?}: {found}");
}

#[test]
fn friedman_and_wilcoxon_are_those_of_scipy() {
    let (_, rows) = read("ranks.csv");
    let mut compared = 0;
    for row in rows.iter().filter(|row| ["friedman", "wilcoxon"].contains(&row[0].as_str())) {
        let counts = counts(&row[1]);
        let name: Vec<&str> = row[2].split(' ').collect();
        let means = SubjectMeans::new(&counts, counts.factor(name[0]).unwrap().0);
        assert!(means.incomplete.is_empty());
        if row[0] == "friedman" {
            let test = friedman(&means).unwrap();
            close(test.chi_squared, &row[3], row);
            close(test.p, &row[4], row);
            assert!((test.w - test.chi_squared / (test.subjects * test.df) as f64).abs() < 1e-15);
        } else {
            let pairs = pairs(&means).pairs;
            let pair = pairs.iter().find(|pair| pair.level == name[1] && pair.other == name[2]).unwrap();
            close(pair.test.v, &row[3], row);
            close(pair.test.p, &row[4], row);
        }
        compared += 1;
    }
    assert!(compared > 40, "{compared}");
}

#[test]
fn many_differences_are_compared_exactly_and_normally() {
    let (_, rows) = read("ranks.csv");
    let row = |name: &str| rows.iter().find(|row| row[0] == name).unwrap();
    let differences: Vec<f64> = (0..70).map(|i| f64::from((i * 37) % 101 - 45) / 4.0).collect();
    let test = wilcoxon(&differences);
    close(test.v, &row("wilcoxon_normal")[3], row("wilcoxon_normal"));
    close(test.p, &row("wilcoxon_normal")[4], row("wilcoxon_normal"));
    assert_eq!((test.method, test.n + test.zeros), (PMethod::Normal, 70));
    let fewer: Vec<f64> = differences.iter().take(45).enumerate().map(|(i, d)| d + i as f64 / 1000.0).collect();
    let test = wilcoxon(&fewer);
    close(test.v, &row("wilcoxon_exact")[3], row("wilcoxon_exact"));
    close(test.p, &row("wilcoxon_exact")[4], row("wilcoxon_exact"));
    assert_eq!(test.method, PMethod::Exact);
}

#[test]
fn agreement_is_that_of_krippendorff_and_scikit_learn() {
    let (_, rows) = read("ranks.csv");
    let mut alphas = 0;
    for row in rows.iter().filter(|row| row[0].starts_with("alpha")) {
        let alpha = ordinal_alpha(&counts(&row[1]), &Bootstrap { replicates: 200, ..Bootstrap::default() }).unwrap();
        close(alpha.alpha, &row[3], row);
        let interval = alpha.interval.unwrap();
        assert!(interval.low < alpha.alpha && alpha.alpha < interval.high, "{row:?} {interval:?}");
        alphas += 1;
    }
    assert_eq!(alphas, 4);
    let mut retest = Retest::new(5);
    for i in 0..60_usize {
        let first = (i * 7 + i * i) % 5;
        assert!(retest.add(first, (first + (i * 5) % 3).saturating_sub(1).min(4)));
    }
    assert!(!retest.add(5, 0));
    for row in rows.iter().filter(|row| row[0] == "kappa" && row[2] == "quadratic") {
        close(retest.kappa().unwrap(), &row[3], row);
    }
    assert_eq!(Retest::new(4).kappa(), None);
}

/// The exact probability, counted over all signs.
#[test]
fn the_exact_distribution_is_that_of_all_signs() {
    for differences in [
        &[1.0, -2.0, 3.0, 4.0, 5.0, 6.0, -0.5, 8.0][..],
        &[1.0, 1.0, -1.0, 2.0, 2.0, 0.0, 3.0, -3.0, 0.5],
        &[0.25; 8],
        &[-0.1, 0.2, 0.3 - 0.1, 0.1],
        &[0.0, 0.0],
        &[],
    ] {
        let test = wilcoxon(differences);
        let sizes: Vec<f64> = differences.iter().filter(|d| **d != 0.0).map(|d| (d.abs() * 1e9).round()).collect();
        let (mut below, mut above) = (0.0, 0.0);
        for signs in 0..1_u32 << sizes.len() {
            let positive = sizes.iter().enumerate().filter(|(i, _)| signs >> i & 1 == 1).map(|(_, size)| size);
            // Mid-ranks: half a rank for each tie, its own among them.
            let rank = |size: &f64| {
                sizes
                    .iter()
                    .map(|s| {
                        if s < size {
                            1.0
                        } else if s == size {
                            0.5
                        } else {
                            0.0
                        }
                    })
                    .sum::<f64>()
                    + 0.5
            };
            let sum: f64 = positive.map(rank).sum();
            below += f64::from(u8::from(sum <= test.v));
            above += f64::from(u8::from(sum >= test.v));
        }
        let expected = (2.0 * f64::min(below, above) / f64::from(1_u32 << sizes.len())).min(1.0);
        assert!((test.p - expected).abs() < 1e-12, "{differences:?}: {test:?}, expected {expected}");
    }
}

#[test]
fn eight_subjects_and_ten_pairs_cannot_reach_five_per_cent() {
    let levels = (0..5).map(|level| level.to_string()).collect();
    let rows = (0..8).map(|s| (s.to_string(), (0..5).map(f64::from).collect())).collect();
    let found = pairs(&SubjectMeans { levels, rows, incomplete: Vec::new() });
    assert_eq!((found.pairs.len(), found.least_p), (10, 10.0 * 2.0 / 256.0));
    assert!(found.cannot_reach(0.05) && !found.cannot_reach(0.1));
    // All subjects agree: the least that is possible.
    assert!(found.pairs.iter().all(|pair| pair.p_holm == found.least_p));
    // `p.adjust(c(0.01, 0.04, 0.03, 0.005), "holm")`, R 4.2.2.
    let corrected = holm(&[0.01, 0.04, 0.03, 0.005]).into_iter().zip([0.03, 0.06, 0.06, 0.02]);
    assert!(corrected.map(|(found, expected)| (found - expected).abs()).fold(0.0, f64::max) < 1e-15);
}
