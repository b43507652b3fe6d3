"""Exact p-values of rank tests by complete enumeration: exact.csv.

    python scripts/golden_exact.py > tests/golden/ordinal/exact.csv

friedman: the table contains a row for each participant and a column for each level. The statistic is chi-squared, corrected
for ties. p is the share of all k!^n ways of permuting the values within each row whose statistic is at least as large.

Nothing is approximated, and no symmetry is used. The statistics are also compared with SciPy's.
"""

import csv
import itertools
import platform
import sys

import numpy as np
import scipy
from scipy.stats import friedmanchisquare, rankdata

TOLERANCE = 1e-9

FRIEDMAN = [
    # Without ties.
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

def parse(text):
    return np.array([[float(value) for value in row.split()] for row in text.split(";")])


def friedman(table):
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
    return observed, (statistic(sums) >= observed - TOLERANCE).mean()


def main():
    versions = f"Python {platform.python_version()}, numpy {np.__version__}, scipy {scipy.__version__}"
    print(f"# Exact p-values by complete enumeration, scripts/golden_exact.py, {versions}.")
    out = csv.writer(sys.stdout, lineterminator="\n")
    out.writerow(["test", "table", "statistic", "p"])
    for text in FRIEDMAN:
        table = parse(text)
        statistic, p = friedman(table)
        if table.shape[1] > 2:
            assert abs(friedmanchisquare(*table.T).statistic - statistic) < 1e-9, text
        out.writerow(["friedman", text, f"{statistic:.12g}", f"{p:.15g}"])


if __name__ == "__main__":
    main()
