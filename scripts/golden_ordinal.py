"""Data and reference values of the ordinal models: tests/golden/ordinal/.

    python3 scripts/golden_ordinal.py data        # simulates tests/golden/ordinal/data.csv
    Rscript scripts/golden_ordinal.R              # models.csv, tests.csv, by R's ordinal
    python3 scripts/golden_ordinal.py statsmodels # statsmodels.csv
    python3 scripts/golden_ordinal.py ranks       # ranks.csv: rank tests and agreement
    python3 scripts/golden_ordinal.py exact       # exact.csv: p-values of rank tests by complete enumeration

Needs numpy, pandas, scipy, statsmodels, krippendorff and scikit-learn; the headers of the files contain the versions
that were used.
"""

import csv
import io
import itertools
import platform
import sys
from collections import Counter
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent.parent / "tests" / "golden" / "ordinal"
DATA = FOLDER / "data.csv"
INF = "inf"


def rate(rng, eta, thresholds, link, scale=1.0):
    """A category from P(Y <= j) = F((theta_j - eta) / scale)."""
    noise = rng.logistic() if link == "logit" else rng.normal()
    return int(np.searchsorted(thresholds, eta + scale * noise))


def write(name, factors, rows, about):
    """Counts of identical rows, in a fixed order."""
    counts = Counter(rows)
    write_counts(name, factors, [(*row, counts[row]) for row in sorted(counts, key=str)], about)


def write_counts(name, factors, rows, about):
    with DATA.open("a", newline="") as file:
        file.write(f"## {name}: {about}\n")
        csv.writer(file, lineterminator="\n").writerows([["subject", *factors, "rating", "count"], *rows])


def bangay(name, seed, sd, about):
    rng = np.random.default_rng(seed)
    widths, depths, orientations = ["0.02", "0.05", "0.1", "0.2", "0.4", "0.8"], ["1", "2", "3", "4", INF], ["0", "45", "90", "135"]
    width_effect = dict(zip(widths, [0, 0.3, 0.7, 0.9, 0.4, -0.5]))
    depth_effect = dict(zip(depths, [0, -1.0, -1.6, -2.0, -2.6]))
    rows = []
    for subject in range(1, 9):
        intercept = sd * rng.normal()
        for width, depth, orientation in itertools.product(widths, depths, orientations):
            for _ in range(2):
                eta = intercept + width_effect[width] + depth_effect[depth]
                rows.append((f"S{subject:03}", width, depth, orientation, rate(rng, eta, [-2.2, -0.7, 0.8], "logit")))
    write(name, ["width", "depth", "orientation_deg"], rows, about)


def unbalanced():
    rng = np.random.default_rng(3)
    shaders, sizes = ["gouraud", "flat", "phong", "exact"], ["1.5", "2.25", "10", "33"]
    effect = {"gouraud": 0.8, "flat": 1.4, "phong": 0.1, "exact": 0.0}
    rows = []
    for subject in range(23):
        intercept = 1.1 * rng.normal()
        # Three participants have only one rating.
        for _ in range(1 if subject % 8 == 5 else int(rng.integers(3, 40))):
            shader, size = shaders[rng.choice(4, p=[0.5, 0.3, 0.15, 0.05])], sizes[rng.integers(4)]
            eta = intercept + effect[shader] - 0.04 * float(size)
            rows.append((f"p{subject}", shader, size, 1 + rate(rng, eta, [-1.6, -0.9, 0.1, 1.3], "probit")))
    write("unbalanced", ["shader", "size"], rows, "23 subjects with 1 to 39 ratings from 1 to 5, texts and numbers, probit, sd 1.1")


def binary():
    rng = np.random.default_rng(4)
    rows = []
    for subject in range(12):
        intercept = 1.5 * rng.normal()
        for contrast in ["-1", "-0.25", "0.5", "4"]:
            for side in ["left", "right"]:
                for _ in range(4):
                    eta = intercept + 0.5 * float(contrast) + (0.6 if side == "right" else 0)
                    rows.append((f"S{subject}", contrast, side, ["no", "yes"][rate(rng, eta, [0.3], "logit")]))
    write("binary", ["contrast", "side"], rows, "Two categories, 12 subjects, sd 1.5")


def gaps():
    rng = np.random.default_rng(5)
    rows = []
    for subject in range(6):
        intercept = 0.5 * rng.normal()
        for width, depth in itertools.product(["0.1", "0.4", "0.80"], ["1", "2", "10", INF]):
            if (width, depth) == ("0.4", "2"):
                continue
            for repetition in range(5):
                eta = intercept + float(width) - (0 if depth == INF else 1.5 / float(depth))
                rating = [0, 1, 3][rate(rng, eta, [-1, 1], "logit")]
                shown = "" if (subject, repetition, depth) == (2, 0, "1") else width
                rows.append((f"S{subject}", shown, depth, "a" if depth == INF else "b", rating))
    write("gaps", ["width", "depth", "bound"], rows,
          "No rating is 2, width 0.4 never with depth 2, three widths missing, bound follows from depth")


def strong():
    rng = np.random.default_rng(6)
    rows = []
    for subject in range(30):
        intercept = 2.5 * rng.normal()
        for x in ["0", "1", "2"]:
            for _ in range(2):
                rows.append((f"S{subject:02}", x, rate(rng, intercept + 0.7 * float(x), [-4, -2.5, -1, 0.5, 2, 4], "logit")))
    write("strong", ["x"], rows, "Seven categories, 30 subjects with 6 ratings, sd 2.5: Laplace and quadrature differ")


def spread():
    rng = np.random.default_rng(7)
    rows = []
    for subject in range(10):
        for group, x in itertools.product(["a", "b", "c"], ["0", "1", "2", "5"]):
            for _ in range(6):
                scale = {"a": 1.0, "b": 1.6, "c": 0.7}[group]
                eta = 0.3 * float(x) + {"a": 0, "b": 0.5, "c": -0.5}[group]
                rows.append((f"S{subject}", group, x, rate(rng, eta, [-1, 0.2, 1.4], "logit", scale)))
    write("spread", ["group", "x"], rows, "The spread of ratings depends on the group: odds are not proportional")


def large():
    rng = np.random.default_rng(8)
    rows = []
    for subject in range(9):
        intercept = 0.8 * rng.normal()
        for year in [1998, 2001, 2003, 2010, 2024]:
            eta = intercept + 0.05 * (year - 2003)
            below = 1 / (1 + np.exp(-(np.array([-1.5, 0.0, 2.0, np.inf]) - eta)))
            for rating, count in enumerate(rng.multinomial(11111, np.diff(below, prepend=0))):
                rows.append([f"S{subject}", year, rating, count])
    write_counts("large", ["year"], rows, "Half a million ratings as counts, a covariate far from 0.")


def coders():
    rng = np.random.default_rng(9)
    rows = []
    for unit in range(30):
        truth = rng.integers(0, 5)
        for subject in range(5):
            if rng.random() < 0.8:
                rows.append((f"C{subject}", f"u{unit}", int(np.clip(truth + rng.choice([-1, 0, 0, 0, 1, 2]), 0, 4))))
    write("coders", ["unit"], rows, "Five coders rate 30 units once, with a fifth of the ratings missing")


def data():
    FOLDER.mkdir(parents=True, exist_ok=True)
    DATA.write_text(f"# Simulated by scripts/golden_ordinal.py, numpy {np.__version__}, Python {platform.python_version()}.\n")
    bangay("bangay", 1, 0.6, "The design of bangay2003, 8 subjects, sd 0.6")
    bangay("alike", 2, 0.0, "The design of bangay2003, 8 subjects who do not differ")
    unbalanced()
    binary()
    gaps()
    strong()
    spread()
    large()
    coders()


def read(name):
    import pandas

    section = DATA.read_text().split(f"## {name}: ")[1].split("\n", 1)[1].split("## ")[0]
    frame = pandas.read_csv(io.StringIO(section), dtype=str, keep_default_na=False)
    frame["count"] = frame["count"].astype(int)
    return frame.loc[frame.index.repeat(frame["count"])].reset_index(drop=True)


def natural(levels):
    try:
        return sorted(set(levels), key=float)
    except ValueError:
        return sorted(set(levels))


def statsmodels_values():
    import pandas
    import scipy
    import statsmodels
    from statsmodels.miscmodels.ordinal_model import OrderedModel

    fits = [
        ("bangay", "logit", "width,depth,orientation_deg"),
        ("bangay", "probit", "width,depth"),
        ("unbalanced", "probit", "shader,num:size"),
        ("spread", "logit", "group,num:x"),
        ("strong", "logit", "num:x"),
    ]
    with (FOLDER / "statsmodels.csv").open("w", newline="") as file:
        file.write(f"# statsmodels {statsmodels.__version__} OrderedModel (scipy {scipy.__version__}, numpy {np.__version__}, ")
        file.write(f"Python {platform.python_version()}), by scripts/golden_ordinal.py.\n")
        file.write("# Its thresholds are the first one and the logarithms of the differences: here the thresholds, with standard errors by the delta method.\n")
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["data", "link", "terms", "quantity", "name", "value"])
        for name, link, terms in fits:
            frame = read(name)
            columns = {}
            for term in terms.split(","):
                if term.startswith("num:"):
                    columns[term[4:]] = frame[term[4:]].astype(float)
                else:
                    for level in natural(frame[term])[1:]:
                        columns[f"{term}{level}"] = (frame[term] == level).astype(float)
            ratings = natural(frame["rating"])
            y = frame["rating"].map(ratings.index)
            model = OrderedModel(y, pandas.DataFrame(columns), distr=link)
            result = model.fit(method="bfgs", disp=False, maxiter=2000, gtol=1e-8)
            result = model.fit(start_params=result.params, method="newton", disp=False, tol=1e-12)
            parameters, covariance, p = result.params.to_numpy(), np.asarray(result.cov_params()), len(columns)
            steps = parameters[p:].copy()
            steps[1:] = np.exp(steps[1:])
            jacobian = np.tril(np.ones((len(steps), len(steps)))) * np.concatenate([[1], steps[1:]])
            theta, theta_covariance = np.cumsum(steps), jacobian @ covariance[p:, p:] @ jacobian.T
            row = lambda quantity, label, value: out.writerow([name, link, terms, quantity, label, f"{value:.12g}"])
            row("loglik", "", result.llf)
            for j, (below, above) in enumerate(itertools.pairwise(ratings)):
                row("threshold", f"{below}|{above}", theta[j])
                row("threshold_se", f"{below}|{above}", np.sqrt(theta_covariance[j, j]))
            for j, label in enumerate(columns):
                row("coefficient", label, parameters[j])
                row("coefficient_se", label, np.sqrt(covariance[j, j]))


def alpha_by_pairs(frame, factors):
    """Ordinal alpha from every pair of ratings by different participants, one pair at a time."""
    ratings = sorted(frame["rating"].astype(int).unique())
    coincidences = np.zeros((len(ratings), len(ratings)))
    for _, unit in frame.groupby(factors):
        rows = list(zip(unit["subject"], unit["rating"].astype(int).map(ratings.index)))
        pairs = [(a, b) for (s, a), (t, b) in itertools.product(rows, rows) if s != t]
        if pairs:
            for a, b in pairs:
                coincidences[a, b] += len(rows) / len(pairs)
    n_c = coincidences.sum(axis=0)
    n = n_c.sum()
    delta = lambda c, k: (n_c[min(c, k) : max(c, k) + 1].sum() - (n_c[c] + n_c[k]) / 2) ** 2
    cells = list(itertools.product(range(len(ratings)), repeat=2))
    observed = sum(coincidences[c, k] * delta(c, k) for c, k in cells) / n
    expected = sum(n_c[c] * n_c[k] * delta(c, k) for c, k in cells) / (n * (n - 1))
    return 1 - observed / expected


def rank_values():
    from importlib.metadata import version

    import krippendorff
    from sklearn.metrics import cohen_kappa_score

    with (FOLDER / "ranks.csv").open("w", newline="") as file:
        file.write(f"# krippendorff {version('krippendorff')}, scikit-learn ")
        file.write(f"{version('scikit-learn')} (cohen_kappa_score), by scripts/golden_ordinal.py. alpha_pairs: from its definition, pair by pair.\n")
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["test", "data", "name", "value", "p"])
        row = lambda test, data, name, value, p="": out.writerow([test, data, name, f"{value:.12g}", p if p == "" else f"{p:.12g}"])
        frame = read("coders")
        table = frame.assign(rating=frame["rating"].astype(float)).pivot(index="subject", columns="unit", values="rating")
        row("alpha", "coders", "unit", krippendorff.alpha(table.to_numpy(), level_of_measurement="ordinal"))
        row("alpha_pairs", "coders", "unit", alpha_by_pairs(frame, ["unit"]))
        row("alpha_pairs", "bangay", "", alpha_by_pairs(read("bangay"), ["width", "depth", "orientation_deg"]))
        frame = read("spread")
        row("alpha_pairs", "spread", "", alpha_by_pairs(frame, ["group", "x"]))
        first = [(i * 7 + i * i) % 5 for i in range(60)]
        second = [min(4, max(0, value + (i * 5) % 3 - 1)) for i, value in enumerate(first)]
        for weights in ["linear", "quadratic"]:
            row("kappa", "", weights, cohen_kappa_score(first, second, weights=weights))


# Tables with a row for each participant and a column for each level, first without ties.
FRIEDMAN = [
    "1 2 3;1 2 3;1 2 3;1 2 3",
    "1 2 3;1 3 2;1 2 3;2 1 3",
    "0.5 1.25 2;1.75 1 2.5;0.25 0.75 3;1 2 1.5",
    "3 1 2;1 2 3;2 3 1;1 3 2",
    "1 2 3 4;2 1 3 4;1 3 2 4",
    "1 2 3 4;4 3 2 1;2 1 4 3",
    "1 2 3 4;1 2 3 4;1 2 3 4",
    "1 2;1 2;1 2;1 2;1 2;1 2",
    "1 2;2 1;1 2;1 2;1 2;1 2",
    "1 2;2 1;2 1;1 2;1 2;2 1",
    "1 2 3;3 2 1",
    "1 2 3;1 2 3",
    "1.5 2.25 0.25;1 2 3;0.5 2.75 1.75;0 3 2;1 1.25 1.5;0.25 2 1",
    "1 2 4 3;2 1 3 4;1 2 3 4;1 4 2 3",
    "1 2 3 4 5;2 1 3 5 4;1 3 2 4 5",
    # With ties.
    "0 1 1;0 0 1;1 2 3;0 2 2;1 0 3",
    "1 1 1;0 1 2;2 2 3;0 0 1;1 3 3",
    "0 0 3;0 0 3;0 0 3;0 0 3;0 0 3",
    "0 1 1;1 0 1;1 1 0;0 1 1",
    "1.5 1.5 2;0.25 1 1;0.75 0.75 0.75;2 2.5 1",
    "0 1 1 2;0 0 1 1;1 1 1 3",
    "0 0 0 1;1 1 0 2;2 3 3 3",
    "1 1;1 2;1 2;2 1;1 1;1 2",
    "0 1;0 1;0 1;1 1;0 0;0 1",
    "0 0 1;2 2 2",
    "0 1 1;0 1 2;1 1 2;0 0 2;1 2 2;0 3 1",
    "0 0 1 1;0 1 1 2;0 1 2 3;1 1 0 2",
    "0 0 1 1 2;0 1 1 1 3;2 0 1 3 3",
]


def friedman(table):
    """Chi-squared, corrected for ties, and the share of all k!^n ways of permuting the values within each row whose
    statistic is at least as large. Nothing is approximated, and no symmetry is used."""
    from scipy.stats import rankdata

    people, levels = table.shape
    ranks = np.array([rankdata(row) for row in table])
    within = ((ranks - (levels + 1) / 2) ** 2).sum()

    def statistic(sums):
        return (levels - 1) * ((sums - people * (levels + 1) / 2) ** 2).sum(axis=-1) / within

    observed = statistic(ranks.sum(axis=0))
    sums = np.zeros((1, levels))
    for row in ranks:
        orders = np.array(list(itertools.permutations(row)))
        sums = (sums[:, None, :] + orders[None, :, :]).reshape(-1, levels)
    return observed, (statistic(sums) >= observed - 1e-9).mean()


def exact_values():
    import scipy
    from scipy.stats import friedmanchisquare

    with (FOLDER / "exact.csv").open("w", newline="") as file:
        versions = f"Python {platform.python_version()}, numpy {np.__version__}, scipy {scipy.__version__}"
        file.write(f"# Exact p-values by complete enumeration, scripts/golden_ordinal.py, {versions}.\n")
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["test", "table", "statistic", "p"])
        for text in FRIEDMAN:
            table = np.array([[float(value) for value in row.split()] for row in text.split(";")])
            statistic, p = friedman(table)
            if table.shape[1] > 2:
                assert abs(friedmanchisquare(*table.T).statistic - statistic) < 1e-9, text
            out.writerow(["friedman", text, f"{statistic:.12g}", f"{p:.15g}"])


if __name__ == "__main__":
    {"data": data, "statsmodels": statsmodels_values, "ranks": rank_values, "exact": exact_values}[sys.argv[1]]()
