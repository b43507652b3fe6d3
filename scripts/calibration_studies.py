"""Simulated rating studies with known parameters, for checks of tests and intervals.

    python scripts/calibration_studies.py OUT_DIR [--studies 1000] [--seed 20261124] [--only NAME,NAME]

For each design, OUT_DIR/NAME.csv contains the studies as counts of equal ratings (study, subject_id, the factors, rating,
count), sorted by study and participant; in the designs "o", also the place of each trial. OUT_DIR/NAME.json contains the parameters and the expected values in the
population. The random numbers of a study depend only on the seed, the name of the design and the number of the study.

A latent value is x·β + the person's intercept + the person's deviations in the slopes + logistic noise. The rating, from
0 to 3, is the number of thresholds below the latent value. All normal effects of persons are independent. In the designs
"rough", people also have thresholds and a spread of their own, deviations with the tails of Student's t with 3 degrees of
freedom, noise that follows an autoregressive process over the trials (0.3), and a tenth of the cells is missing.

The expected values, superiority and alpha are integrals over the population by Gauss-Hermite quadrature:
    level_means    expected rating at a level in the population: the unweighted mean of the cells with this level
    cell_means     expected rating in a combination of levels (in the order of the factors, joined by commas)
    typical_means  the same for a person with all random effects 0
    superiority    P(rating at the second level > rating at the first) + P(equal) / 2. Within factors: two ratings by the
                   same person, averaged over persons and over the cells of the other factors; between factors: ratings
                   by two persons
    alpha          Krippendorff's ordinal alpha with conditions as units, for infinitely many persons and pairs of ratings
                   by different persons
"""

import argparse
import csv
import itertools
import json
import zlib
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy.special import expit
from scipy.stats import logistic, norm

RATINGS = 4
USUAL = (-1.5, 0.0, 1.5)
FLOOR = (1.5, 3.0, 4.5)


@dataclass
class Design:
    name: str
    text: str
    people: int
    # The factors with their levels; the levels of a numeric factor are numbers.
    factors: dict
    # Trials of a participant in each condition: a number, or a number for every cell.
    trials: object
    effects: dict = field(default_factory=dict)  # factor -> effect of each level, or the slope of a numeric factor
    between: tuple = ()
    sd: float = 1.0
    slope: str = ""  # the factor in whose effect people differ
    # "treatment": a deviation at each level but the first; "levels": at every level; "numeric": a slope of x - 0.5.
    slope_kind: str = ""
    slope_sd: float = 0.0
    thresholds: tuple = USUAL
    rough: bool = False
    # Items, such as pictures, of each level: another sample with an SD of its own. Each person rates every item once.
    items: int = 0
    item_sd: float = 0.0
    # Correlation of the noise of successive trials, whether conditions are shown in blocks, and whether the studies tell the
    # places of the trials.
    autoregression: float = 0.3
    blocked: bool = False
    placed: bool = False
    # The effects of the first factor also differ between people in a way that depends on the second.
    crossed_sd: float = 0.0

    def cells(self):
        return list(itertools.product(*self.factors.values()))

    def trials_of(self, cell):
        return self.trials[cell] if isinstance(self.trials, dict) else self.trials

    def is_numeric(self, factor):
        return not isinstance(self.factors[factor][0], str)

    def null(self):
        return [factor for factor in self.factors if not np.any(self.effects.get(factor, 0))]

    def coefficients(self):
        """The fixed effects with R's names of treatment contrasts."""
        named = {}
        for factor, levels in self.factors.items():
            if self.is_numeric(factor):
                named[factor] = float(self.effects.get(factor, 0))
            else:
                effects = self.effects.get(factor, [0] * len(levels))
                named |= {f"{factor}{level}": float(effect) for level, effect in list(zip(levels, effects))[1:]}
        return named

    def fixed(self):
        """The fixed part of the latent value in every cell."""
        total = np.zeros(len(self.cells()))
        for i, (factor, levels) in enumerate(self.factors.items()):
            for c, cell in enumerate(self.cells()):
                if self.is_numeric(factor):
                    total[c] += self.effects.get(factor, 0) * cell[i]
                elif factor in self.effects:
                    total[c] += self.effects[factor][levels.index(cell[i])]
        return total

    def random(self):
        """The standardized effects of one person by columns: cells × (intercept, deviations), scaled by their SDs."""
        columns = [np.full(len(self.cells()), self.sd)]
        if self.slope:
            i = list(self.factors).index(self.slope)
            values = [cell[i] for cell in self.cells()]
            if self.slope_kind == "numeric":
                columns.append(self.slope_sd * (np.array(values) - 0.5))
            else:
                skipped = 1 if self.slope_kind == "treatment" else 0
                for level in self.factors[self.slope][skipped:]:
                    columns.append(self.slope_sd * np.array([value == level for value in values], float))
        return np.column_stack(columns)


ABC = {"level": ["a", "b", "c"]}
ABCD = {"level": ["a", "b", "c", "d"]}
AB = {"level": ["a", "b"]}
GROUP = {"group": ["a", "b"]}
CROSSED = {"level": ["a", "b", "c"], "side": ["l", "r"]}
UNEVEN = {("a", "l"): 6, ("a", "r"): 2, ("b", "l"): 4, ("b", "r"): 4, ("c", "l"): 2, ("c", "r"): 6}
STEPS = {"level": [0.0, 1.0, 2.0]}
TREATMENT = {"slope": "level", "slope_kind": "treatment", "slope_sd": 0.3}
LEVELS = {"slope": "level", "slope_kind": "levels", "slope_sd": 0.3}

DESIGNS = [
    Design("w8x12", "8 people rate 3 levels 4 times; no effect.", 8, ABC, 4),
    Design("w4x12", "4 people rate 3 levels 4 times; no effect.", 4, ABC, 4),
    Design("w8x3", "8 people rate 3 levels once; no effect.", 8, ABC, 1),
    Design("w4x3", "4 people rate 3 levels once; no effect.", 4, ABC, 1),
    Design("b8", "Two groups of 4 people, 12 ratings each; no effect of the group.", 8, GROUP, 12, between=("group",)),
    Design("b4", "Two groups of 2 people, 12 ratings each; no effect of the group.", 4, GROUP, 12, between=("group",)),
    Design("s8x240", "8 people rate 4 levels 60 times; the mean effect is 0, but people differ in the contrasts with the first level.",
           8, ABCD, 60, **TREATMENT),
    Design("s8x240two", "8 people rate 2 levels 120 times; the mean effect is 0, but people differ in it.", 8, AB, 120, **TREATMENT),
    Design("s8x240cs", "8 people rate 4 levels 60 times; the mean effect is 0, but people deviate at every level.",
           8, ABCD, 60, **LEVELS),
    Design("s4x240", "4 people rate 4 levels 60 times; the mean effect is 0, but people deviate at every level.",
           4, ABCD, 60, **LEVELS),
    Design("s12x48", "12 people rate 4 levels 12 times; the mean effect is 0, but people deviate at every level.",
           12, ABCD, 12, **(LEVELS | {"slope_sd": 0.5})),
    Design("t4", "4 people rate 2 levels 6 times; no effect.", 4, AB, 6),
    Design("t5", "5 people rate 2 levels 6 times; no effect.", 5, AB, 6),
    Design("e8x12", "8 people rate 3 levels 4 times; the effects are 0, 1 and 2 logits.", 8, ABC, 4, STEPS),
    Design("e4x12", "4 people rate 3 levels 4 times; the effects are 0, 1 and 2 logits.", 4, ABC, 4, STEPS),
    Design("f8x12", "8 people rate 3 levels 4 times; most ratings are 0; no effect.", 8, ABC, 4, thresholds=FLOOR),
    Design("f4x12", "4 people rate 3 levels 4 times; most ratings are 0; no effect.", 4, ABC, 4, thresholds=FLOOR),
    Design("c8", "8 people rate 3 levels on 2 sides twice; no effects.", 8, CROSSED, 2),
    Design("c6", "6 people rate 3 levels on 2 sides twice; no effects.", 6, CROSSED, 2),
    Design("u8", "8 people rate 3 levels on 2 sides, with level and side correlated in the numbers of trials; the side has an effect of "
           "1.5 logits, the level none.", 8, CROSSED, UNEVEN, {"side": [0.0, 1.5]}),
    Design("n8", "8 people rate 5 values of x 3 times; the mean slope is 0, but people differ in it.",
           8, {"x": [0, 0.25, 0.5, 0.75, 1]}, 3, slope="x", slope_kind="numeric", slope_sd=0.5),
    Design("h6", "6 people who differ much rate 3 levels 4 times; no effect.", 6, ABC, 4, sd=2.0),
    *[
        Design(f"r{people}x{len(levels['level'])}", f"{people} people rate {len(levels['level'])} levels 12 times; the mean effect is 0; rough.",
               people, levels, 12, **(LEVELS | {"slope_sd": 0.5}), rough=True)
        for people in (3, 4, 6, 8, 11, 12, 16, 20, 40)
        for levels in (AB, ABCD)
    ],
    *[
        Design(f"i{people}", f"{people} people rate 3 levels on 2 sides 6 times; effects of 2 logits, but no interaction; rough.",
               people, CROSSED, 6, {"level": [0.0, 1.0, 2.0], "side": [0.0, 2.0]}, **(LEVELS | {"slope_sd": 0.5}), rough=True, crossed_sd=0.5)
        for people in (3, 6, 8, 12, 20, 40)
    ],
    *[
        Design(f"k{people}x{items}", f"{people} people rate 2 levels of {items} items each once; the mean effect is 0; people differ in it; "
               "rough.", people, AB, items, **(LEVELS | {"slope_sd": 0.3}), rough=True, items=items, item_sd=0.8)
        for people, items in ((6, 8), (12, 6), (12, 12), (20, 12))
    ],
    *[
        Design(f"o{people}{'b' * blocked}{'a' * (ar > 0)}", f"{people} {'people' if people > 1 else 'person'} rate 2 levels 24 times, "
               f"{'in blocks' if blocked else 'in random order'}; no effect; the noise of successive trials is correlated by {ar}; rough.",
               people, AB, 24, **(LEVELS | {"slope_sd": 0.3}), rough=True, autoregression=ar, blocked=blocked, placed=True)
        for people, blocked, ar in ((1, False, 0.0), (1, True, 0.0), (8, False, 0.0), (8, True, 0.0), (8, True, 0.3), (16, False, 0.0))
    ],
    Design("p1", "1 person rates 3 levels 20 times; no effect.", 1, ABC, 20),
]


def simulate(design, rng):
    """The ratings of one study: counts by participant, cell and rating."""
    cells = design.cells()
    fixed, random = design.fixed(), design.random()
    people = design.people
    draw = rng.standard_normal
    effects = draw((people, random.shape[1])) @ random.T
    if design.rough:
        return simulate_rough(design, fixed, random, rng)
    counts = np.zeros((people, len(cells), RATINGS), int)
    for c, cell in enumerate(cells):
        trials = design.trials_of(cell)
        latent = fixed[c] + effects[:, c, None] + rng.logistic(size=(people, trials))
        ratings = np.searchsorted(design.thresholds, latent)
        for rating in range(RATINGS):
            counts[:, c, rating] = (ratings == rating).sum(axis=1)
    if design.between:
        # The participants are divided evenly and in order among the levels.
        for person in range(people):
            counts[person, np.arange(len(cells)) != person * len(cells) // people] = 0
    return counts


def simulate_rough(design, fixed, random, rng):
    """The ratings of a study of people who differ in every way; see the top of this file."""
    cells = design.cells()
    people = design.people
    deviations = rng.standard_t(3, (people, random.shape[1])) / np.sqrt(3)
    deviations[:, 0] = rng.standard_normal(people)
    effects = deviations @ random.T + design.crossed_sd * rng.standard_normal((people, len(cells)))
    items, places = max(design.items, 1), []
    shifts = design.item_sd * rng.standard_normal((len(cells), items)) if design.items else np.zeros((len(cells), 1))
    counts = np.zeros((people, len(cells) * items, RATINGS), int)
    for person in range(people):
        thresholds = np.sort(np.asarray(design.thresholds) + 0.4 * rng.standard_normal(RATINGS - 1))
        scale = np.exp(0.3 * rng.standard_normal())
        trials = np.repeat(np.arange(len(cells)), [design.trials_of(cell) for cell in cells])
        if design.blocked:
            trials = np.concatenate([trials[trials == c] for c in rng.permutation(len(cells))])
        else:
            rng.shuffle(trials)
        noise = np.empty(len(trials))
        noise[0] = rng.standard_normal()
        for trial in range(1, len(trials)):
            noise[trial] = design.autoregression * noise[trial - 1] + np.sqrt(1 - design.autoregression**2) * rng.standard_normal()
        item = np.zeros(len(trials), int)
        for c in range(len(cells) if design.items else 0):
            item[trials == c] = rng.permutation(items)
        latent = fixed[trials] + effects[person, trials] + shifts[trials, item] + scale * logistic.ppf(norm.cdf(noise))
        ratings = np.searchsorted(thresholds, latent)
        np.add.at(counts, (person, trials * items + item, ratings), 1)
        if design.placed:
            places += [(person, c, rating, place) for place, (c, rating) in enumerate(zip(trials, ratings), 1)]
            continue
        missing = rng.random(counts.shape[1]) < 0.1
        if not missing.all():
            counts[person, missing] = 0
    return places if design.placed else counts


def probabilities(design, eta):
    """The probabilities of the ratings (last axis) at the given latent means."""
    below = expit(np.asarray(design.thresholds) - np.asarray(eta)[..., None])
    edges = np.concatenate([np.zeros_like(below[..., :1]), below, np.ones_like(below[..., :1])], axis=-1)
    return np.diff(edges, axis=-1)


def normal_nodes(count):
    nodes, weights = np.polynomial.hermite_e.hermegauss(count)
    return nodes, weights / weights.sum()


def superiority_of(design, first, second):
    """P(second cell > first cell) + P(equal) / 2."""
    fixed, random = design.fixed(), design.random()[[first, second]]
    covariance = random @ random.T
    if design.between:
        covariance = np.diag(np.diag(covariance))
    values, vectors = np.linalg.eigh(covariance)
    root = vectors * np.sqrt(np.maximum(values, 0))
    nodes, weights = normal_nodes(80)
    grid = np.stack(np.meshgrid(nodes, nodes, indexing="ij"), axis=-1) @ root.T
    low = probabilities(design, fixed[first] + grid[..., 0])
    high = probabilities(design, fixed[second] + grid[..., 1])
    higher = np.einsum("...i,...j,ij->...", low, high, np.triu(np.ones((RATINGS, RATINGS)), 1) + np.eye(RATINGS) / 2)
    return weights @ higher @ weights


def alpha_of(marginal, weights):
    """Ordinal alpha from the distribution of ratings in every unit and the units' shares of the ratings."""
    pooled = weights @ marginal
    cumulative = np.concatenate([[0], np.cumsum(pooled)])
    delta = np.zeros((RATINGS, RATINGS))
    for c, k in itertools.product(range(RATINGS), repeat=2):
        low, high = min(c, k), max(c, k)
        delta[c, k] = (cumulative[high + 1] - cumulative[low] - (pooled[c] + pooled[k]) / 2) ** 2
    observed = np.einsum("u,ui,uj,ij->", weights, marginal, marginal, delta)
    return 1 - observed / (pooled @ delta @ pooled)


def truth(design):
    cells = design.cells()
    names = [",".join(str(level) for level in cell) for cell in cells]
    fixed, random = design.fixed(), design.random()
    nodes, weights = normal_nodes(160)
    spread = np.sqrt((random**2).sum(axis=1) + design.item_sd**2)
    marginal = np.einsum("n,cni->ci", weights, probabilities(design, fixed[:, None] + spread[:, None] * nodes))
    values = np.arange(RATINGS)
    means, typical = marginal @ values, probabilities(design, fixed) @ values
    level_means, superiority = {}, {}
    for i, (factor, levels) in enumerate(design.factors.items()):
        at = {level: [c for c, cell in enumerate(cells) if cell[i] == level] for level in levels}
        level_means[factor] = {str(level): float(means[at[level]].mean()) for level in levels}
        superiority[factor] = {
            f"{a},{b}": float(np.mean([superiority_of(design, first, second) for first, second in zip(at[a], at[b])]))
            for a, b in itertools.combinations(levels, 2)
        }
    trials = np.array([design.trials_of(cell) for cell in cells], float)
    alpha = alpha_of(marginal, trials / trials.sum())
    return {
        "design": design.text,
        "people": design.people,
        "factor kinds": {factor: "between" if factor in design.between else "within" for factor in design.factors},
        "items": "item" if design.items else None,
        "item_sd": design.item_sd,
        "numeric": [factor for factor in design.factors if design.is_numeric(factor)],
        "trials": {name: int(count) for name, count in zip(names, trials)},
        "coefficients": design.coefficients(),
        "subject_sd": design.sd,
        "slope_sd": design.slope_sd,
        "slopes": {design.slope: design.slope_kind} if design.slope else {},
        "thresholds": list(design.thresholds),
        "link": "logit",
        "null": design.null(),
        "level_means": level_means,
        "cell_means": dict(zip(names, means.tolist())),
        "typical_means": dict(zip(names, typical.tolist())),
        "superiority": superiority,
        "alpha": 0.0 if abs(alpha) < 1e-12 else float(alpha),
    }


def write(design, folder, studies, seed):
    cells = design.cells()
    if design.items:
        cells = [(*cell, f"{c}-{item}") for c, cell in enumerate(cells) for item in range(design.items)]
    with (folder / f"{design.name}.csv").open("w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["study", "subject_id", *design.factors, *(["item"] if design.items else []), "rating", "count", *(["trial"] if design.placed else [])])
        for study in range(1, studies + 1):
            rng = np.random.default_rng(np.random.SeedSequence([seed, zlib.crc32(design.name.encode()), study]))
            counts = simulate(design, rng)
            if design.placed:
                out.writerows([study, f"S{person + 1:02}", *cells[c], rating, 1, place] for person, c, rating, place in counts)
                continue
            for person, c, rating in np.argwhere(counts):
                out.writerow([study, f"S{person + 1:02}", *cells[c], rating, counts[person, c, rating]])
    (folder / f"{design.name}.json").write_text(json.dumps(truth(design), indent=2) + "\n")


def main():
    parser = argparse.ArgumentParser(description="Simulates rating studies with known parameters.")
    parser.add_argument("folder", type=Path, metavar="OUT_DIR")
    parser.add_argument("--studies", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=20261124)
    parser.add_argument("--only", default="", help="names of designs, separated by commas")
    arguments = parser.parse_args()
    chosen = [name for name in arguments.only.split(",") if name]
    unknown = set(chosen) - {design.name for design in DESIGNS}
    if unknown:
        parser.error(f"unknown designs: {', '.join(sorted(unknown))}")
    arguments.folder.mkdir(parents=True, exist_ok=True)
    for design in DESIGNS:
        if not chosen or design.name in chosen:
            write(design, arguments.folder, arguments.studies, arguments.seed)


if __name__ == "__main__":
    main()
