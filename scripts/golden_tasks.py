"""Reference values of the tasks and their analyses: tests/golden/tasks/.

    python3 scripts/golden_tasks.py questplus   # questplus.csv, questplus_configurations.csv
    python3 scripts/golden_tasks.py psignifit   # psignifit.csv, psignifit_data.csv
    python3 scripts/golden_tasks.py pairs       # pairs.csv, pairs_data.csv
    python3 scripts/golden_tasks.py detection   # detection.csv
    python3 scripts/golden_tasks.py generators  # people.csv, simulated

Needs numpy and scipy, and for the first three questplus, psignifit, and choix with statsmodels; the headers of the
files contain the versions that were used. Every random number has a fixed seed.
"""

import csv
import itertools
import platform
import sys
import warnings
from collections import Counter
from importlib.metadata import version
from pathlib import Path

import numpy as np
from scipy.special import gammaln, ndtr, ndtri, xlogy

FOLDER = Path(__file__).resolve().parent.parent / "tests" / "golden" / "tasks"
TRIALS = 32
SEEDS = 100


def write(name, packages, about, columns, rows):
    """A CSV with a header: the script, the versions and the lines of `about`."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    versions = ", ".join(f"{package} {version(package)}" for package in packages)
    with (FOLDER / name).open("w", newline="") as file:
        file.write(f"# By scripts/golden_tasks.py, {versions}, Python {platform.python_version()}.\n")
        for line in about:
            file.write(f"# {line}\n")
        csv.writer(file, lineterminator="\n").writerows([columns, *rows])


def numbers(values):
    return " ".join(repr(float(value)) for value in values)


# QUEST+


def bent(low, high, count, bend):
    """Values from `low` to `high` with unequal steps, so that no two stimuli mirror each other."""
    u = np.linspace(0, 1, count)
    return np.round(low + (high - low) * (u + bend * u * (1 - u)), 4)


# name: function, levels, thresholds (means), slopes (standard deviations), guess rates, lapse rates
CONFIGURATIONS = {
    "weibull-2afc": ("weibull", bent(-3.1, 0.07, 23, 0.3), bent(-2.7, -0.31, 24, 0.2), bent(1.1, 6.7, 7, -0.4), [0.5], [0.02]),
    "weibull-2afc-lapse": ("weibull", bent(-2.6, 0.0, 19, -0.25), bent(-2.2, -0.37, 17, 0.15), bent(1.3, 5.2, 6, -0.3), [0.5], [0.0, 0.013, 0.041]),
    "weibull-2afc-one-slope": ("weibull", bent(-3.3, 0.2, 45, 0.2), bent(-3.0, 0.1, 60, -0.13), [3.5], [0.5], [0.01]),
    "weibull-4afc": ("weibull", bent(-1.9, 0.4, 21, 0.35), bent(-1.6, 0.23, 22, -0.2), bent(0.9, 7.3, 8, -0.5), [0.25], [0.03]),
    "weibull-yes-no": ("weibull", bent(-2.4, 0.3, 20, -0.3), bent(-2.1, 0.12, 18, 0.25), bent(1.2, 5.9, 6, -0.4), [0.0, 0.1, 0.2], [0.01]),
    "weibull-yes-no-lapse": ("weibull", bent(-2.0, 0.5, 17, 0.2), bent(-1.7, 0.36, 15, -0.3), bent(1.4, 4.8, 5, -0.2), [0.01, 0.08, 0.19], [0.0, 0.03]),
    "normal-2afc": ("norm_cdf", bent(-4.3, 7.9, 25, 0.25), bent(-2.9, 6.2, 23, -0.15), bent(0.6, 4.4, 7, -0.35), [0.5], [0.02]),
    "normal-4afc-lapse": ("norm_cdf", bent(0.3, 11.7, 18, -0.2), bent(1.4, 10.1, 16, 0.3), bent(0.5, 3.7, 6, -0.3), [0.25], [0.005, 0.02, 0.06]),
    "normal-yes-no": ("norm_cdf", bent(-6.1, 5.2, 22, -0.35), bent(-4.7, 4.1, 20, 0.2), bent(0.8, 5.1, 6, -0.4), [0.0, 0.1, 0.2], [0.0, 0.035]),
    "normal-no-asymptotes": ("norm_cdf", bent(-1.3, 1.9, 24, 0.3), bent(-1.0, 1.6, 26, -0.1), bent(0.21, 1.15, 8, -0.4), [0.0], [0.0]),
}


def expected_entropies(posterior, likelihoods):
    """The expected entropy of every level; `likelihoods` has the axes answer, level and the parameters."""
    expected = 0.0
    for likelihood in likelihoods:
        joint = posterior * likelihood
        total = joint.reshape(len(joint), -1).sum(axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            share = joint / total.reshape(-1, *[1] * posterior.ndim)
            terms = np.nan_to_num(share * np.log(share), nan=0.0)
        expected = expected - total * terms.reshape(len(joint), -1).sum(axis=1)
    return expected


def questplus_run(quest, parameters, function, levels, thresholds, slopes, guesses, lapses, seed):
    rng = np.random.default_rng(seed)
    inside = lambda values, margin: min(values) + (max(values) - min(values)) * rng.uniform(margin, 1 - margin)
    threshold, slope, guess = inside(thresholds, 0.1), inside(slopes, 0.05), inside(guesses, 0)
    lapse = 0.0 if list(lapses) == [0.0] else rng.uniform(0, 0.05)
    likelihoods = quest.likelihoods.transpose("response", "intensity", *parameters).to_numpy()
    picks, answers, margin = [], "", np.inf
    for _ in range(TRIALS):
        expected = expected_entropies(quest.posterior.transpose(*parameters).to_numpy(), likelihoods)
        least, second = np.sort(expected)[:2]
        stimulus = quest.next_stim
        pick = int(np.flatnonzero(levels == stimulus["intensity"])[0])
        # What the margin is computed from is what the package minimized.
        assert abs(quest.entropy - least) < 1e-11 and expected[pick] - least < 1e-11
        margin = min(margin, second - least)
        z = (levels[pick] - threshold) / slope if function == "norm_cdf" else slope * (levels[pick] - threshold)
        sigmoid = ndtr(z) if function == "norm_cdf" else -np.expm1(-(10.0**z))
        answer = bool(rng.random() < guess + (1 - guess - lapse) * sigmoid)
        quest.update(stim=stimulus, outcome={"response": "yes" if answer else "no"})
        picks.append(pick)
        answers += "01"[answer]
    estimate = quest.param_estimate
    return [seed, " ".join(map(str, picks)), answers, *[repr(float(estimate[name])) for name in parameters], f"{margin:.3e}"]


def questplus():
    from questplus import QuestPlus

    packages = ["questplus", "xarray", "scipy", "numpy"]
    shapes, rows = [], []
    for number, (name, (function, levels, thresholds, slopes, guesses, lapses)) in enumerate(CONFIGURATIONS.items()):
        location, spread = ("mean", "sd") if function == "norm_cdf" else ("threshold", "slope")
        shown = [1 / slope for slope in slopes] if function == "norm_cdf" else slopes
        shapes.append([name, function, *map(numbers, [levels, thresholds, shown, guesses, lapses])])
        domain = {location: thresholds, spread: slopes, "lower_asymptote": guesses, "lapse_rate": lapses}
        for seed in range(1000 * (number + 1), 1000 * (number + 1) + SEEDS):
            quest = QuestPlus(
                stim_domain={"intensity": levels},
                param_domain=domain,
                outcome_domain={"response": ["yes", "no"]},
                func=function,
                stim_scale="linear" if function == "norm_cdf" else "log10",
                stim_selection_method="min_entropy",
                param_estimation_method="mean",
            )
            with warnings.catch_warnings():
                # Where a probability is 0, the package multiplies 0 by the logarithm of 0 and ignores the result.
                warnings.simplefilter("ignore", RuntimeWarning)
                rows.append([name, *questplus_run(quest, list(domain), function, levels, thresholds, slopes, guesses, lapses, seed)])
    write("questplus_configurations.csv", packages, [
        "Grids of the runs in questplus.csv; the prior is uniform over all combinations.",
        "weibull (stim_scale log10): p = 1 - lapse - (1 - guess - lapse) exp(-10^(slope (x - threshold))), x as in levels.",
        "norm_cdf (stim_scale linear): p = guess + (1 - guess - lapse) Phi(slope (x - threshold)). The package takes mean = threshold",
        "and sd = 1 / slope; here slope = 1/sd, in the order of its sd (which rise, so that these slopes fall).",
    ], ["configuration", "function", "levels", "threshold", "slope", "guess", "lapse"], shapes)
    write("questplus.csv", packages, [
        f"{TRIALS} trials a run: stim_selection_method min_entropy, param_estimation_method mean. Answers: numpy.random.default_rng(seed).",
        "picks: indices into levels, from 0. answers: 1 = yes (correct), the package's first outcome.",
        "threshold, slope, guess, lapse: posterior means after the last trial. FOR norm_cdf, SLOPE IS THE MEAN OF sd, not of 1/sd.",
        "margin: the smallest difference, over the trials, of the second-least and the least expected entropy, in nats.",
    ], ["configuration", "seed", "picks", "answers", "threshold", "slope", "guess", "lapse", "margin"], rows)
    margins = [float(row[-1]) for row in rows]
    print(f"{len(rows)} runs, margins below 1e-12, 1e-9, 1e-6:", *[sum(m < limit for m in margins) for limit in (1e-12, 1e-9, 1e-6)])


# psignifit

# The example of the documentation (docs/basic-usage.md of wichmann-lab/python-psignifit): two alternatives.
DOCUMENTED = [
    (0.0010, 45), (0.0015, 50), (0.0020, 44), (0.0025, 44), (0.0030, 52), (0.0035, 53), (0.0040, 62),
    (0.0045, 64), (0.0050, 76), (0.0060, 79), (0.0070, 88), (0.0080, 90), (0.0100, 90),
]
ORDER = ["threshold", "width", "lambda", "gamma", "eta"]
EXPERIMENTS = {"2AFC": 0.5, "4AFC": 0.25, "yes/no": None}
# The width is that from F = 0.05 to F = 0.95.
SCALES = {"norm": 2 * ndtri(0.95), "logistic": 2 * np.log(19), "weibull": np.log(-np.log(0.05)) - np.log(-np.log(0.95))}


def sigmoid(name, x, threshold, width):
    z = (x - threshold) * SCALES[name] / width
    if name == "norm":
        return ndtr(z)
    return 1 / (1 + np.exp(-z)) if name == "logistic" else 1 - 0.5 ** np.exp(z)


def simulated(number):
    """A data set of the given number, 1 to 49: experiment, sigmoid, rows."""
    rng = np.random.default_rng(4000 + number)
    experiment = list(EXPERIMENTS)[number % 3]
    name = list(SCALES)[number // 3 % 3]
    count, trials = int(rng.integers(5, 14)), int(rng.integers(20, 91))
    low, high = (np.log10(0.004), np.log10(0.4)) if name == "weibull" else [(0.0, 10.0), (-5.0, 5.0), (20.0, 60.0)][number % 3]
    span = high - low
    levels = np.sort(low + span * (np.arange(count) + rng.uniform(-0.25, 0.25, count)) / (count - 1))
    levels = np.round(10**levels, 5) if name == "weibull" else np.round(levels, 2)
    threshold, width = low + span * rng.uniform(0.35, 0.65), span * rng.uniform(0.3, 0.7)
    guess, lapse = EXPERIMENTS[experiment], rng.uniform(0, 0.05)
    guess = rng.uniform(0, 0.1) if guess is None else guess
    x = np.log10(levels) if name == "weibull" else levels
    p = guess + (1 - guess - lapse) * sigmoid(name, x, threshold, width)
    if number % 6 == 4:
        # More spread than the binomial distribution has: eta = 0.2.
        p = rng.beta(p * (1 / 0.2**2 - 1), (1 - p) * (1 / 0.2**2 - 1))
    return experiment, name, [(float(level), int(rng.binomial(trials, share)), trials) for level, share in zip(levels, p)]


def posterior(shape, data, bounds):
    """psignifit's log posterior as a function of threshold, width, lambda, gamma and eta, written anew.

    As in the package but for the integrals of the priors and for eta = 0, where the package lacks the prior of eta.
    """
    x, correct, total = np.transpose(data)
    wrong, low, high, nearest = total - correct, x.min(), x.max(), np.diff(np.unique(x)).min()
    span, free_guess = high - low, bounds["gamma"][0] < bounds["gamma"][1]

    def value(threshold, width, lapse, guess, eta):
        outside = max(low - threshold, threshold - high, 0.0)
        prior = (1 + np.cos(2 * np.pi * outside / span)) / 2 if outside <= span / 2 else 0.0
        if width >= span:
            prior *= (1 + np.cos(np.pi / 2 * (width - span) / span)) / 2 if width <= 3 * span else 0.0
        elif width <= 2 * nearest:
            prior *= (1 - np.cos(np.pi * (width - nearest) / nearest)) / 2 if width >= nearest else 0.0
        if prior <= 0 or not (0 <= lapse <= 1 and 0 <= guess <= 1 and 0 <= eta < 1):
            return -np.inf
        result = np.log(prior) + 9 * (np.log1p(-lapse) + np.log1p(-eta) + (np.log1p(-guess) if free_guess else 0))
        p = guess + (1 - guess - lapse) * sigmoid(shape, x, threshold, width)
        if eta**2 <= 1e-9:
            return result + (xlogy(correct, p) + xlogy(wrong, 1 - p)).sum()
        nu = 1 / eta**2 - 1
        a, b = p * nu, (1 - p) * nu
        terms = np.where(correct > 0, gammaln(correct + a) - gammaln(a), 0) + np.where(wrong > 0, gammaln(wrong + b) - gammaln(b), 0)
        return result + (terms + gammaln(nu) - gammaln(total + nu)).sum()

    return value


def highest(value, bounds, start):
    """The maximum of a log posterior to more digits than psignifit's own search, and its value."""
    from scipy.optimize import minimize

    free = [name for name in ORDER[:-1] if bounds[name][0] < bounds[name][1]]
    best = (-np.inf, None)
    for first_eta in [None, 0.03, 0.1, 0.2, 0.4, start["eta"]]:
        searched = free if first_eta is None else [*free, "eta"]
        scale = np.array([bounds[name][1] - bounds[name][0] for name in searched])
        base = np.array([bounds[name][0] for name in searched])
        limits = np.array([(1e-3 if name == "eta" else 0, 1) for name in searched])

        def parameters(u):
            return {"gamma": bounds["gamma"][0], "eta": 0.0, **dict(zip(searched, map(float, base + scale * u)))}

        def loss(u):
            with np.errstate(all="ignore"):
                result = value(*[parameters(u)[name] for name in ORDER])
            return -result if np.isfinite(result) else 1e300

        u = np.clip((np.array([first_eta if name == "eta" else start[name] for name in searched]) - base) / scale, *limits.T)
        for _ in range(8):
            simplex = np.vstack([u, *[np.clip(u + step, *limits.T) for step in np.diag(np.where(u < 0.5, 0.03, -0.03))]])
            options = {"initial_simplex": simplex, "xatol": 1e-9, "fatol": 1e-12, "maxiter": 5000, "maxfev": 5000}
            found = minimize(loss, u, method="Nelder-Mead", bounds=limits, options=options)
            done = np.allclose(found.x, u, rtol=0, atol=1e-8)
            u = found.x
            if done:
                break
        if -found.fun > best[0]:
            best = (-found.fun, parameters(u))
    return best


def psignifit():
    from psignifit import psignifit as fit
    from psignifit._posterior import log_posterior

    sets = {"documentation": ("2AFC", "norm", [(level, correct, 90) for level, correct in DOCUMENTED])}
    sets |= {f"s{number:02}": simulated(number) for number in range(1, 50)}
    sets["overdispersed"] = "2AFC", "norm", [(level, correct, 20) for level, correct in enumerate([15, 8, 8, 20, 20, 20], 1)]
    rows, offsets, noise = [], [], []
    for name, (experiment, shape, data) in sets.items():
        axis = np.array([(np.log10(level) if shape == "weibull" else level, correct, total) for level, correct, total in data])
        result = fit(axis, experiment_type=experiment, sigmoid=shape, debug=True)
        estimate = result.get_parameter_estimate("MAP")
        slope = result.slope(estimate["threshold"], estimate_type="MAP")
        intervals = [result.confidence_intervals[parameter]["0.95"] for parameter in ("threshold", "width")]
        bounds, priors = result.debug["bounds"], result.debug["priors"]
        value = posterior(shape, axis, bounds)
        top, tight = highest(value, bounds, estimate)
        reached = value(*[estimate[parameter] for parameter in ORDER])
        # The log posterior of the package differs from that of this script by the integrals of the priors only. Near eta = 0
        # the package (and this script) loses digits in differences of logarithms of the gamma function.
        change = {"threshold": estimate["threshold"] + 0.3 * (axis[-1, 0] - axis[0, 0]), "width": 1.7 * estimate["width"], "lambda": 0.07}
        offset = []
        for other in [{"eta": 0.1}, {"eta": 0.3}, {**change, "eta": 0.2}, {}]:
            point = {parameter: np.float64(number) for parameter, number in {**estimate, **other}.items()}
            package = log_posterior(axis, result.configuration.make_sigmoid(), priors, point)
            offset.append(float(np.squeeze(package)) - value(*[point[parameter] for parameter in ORDER]))
        offsets.append(np.ptp(offset[:-1]))
        noise.append(abs(offset[-1] - offset[0]))
        assert offsets[-1] < 1e-8 and top > reached - 1e-5 and estimate["eta"] > 0, name
        values = [*[estimate[parameter] for parameter in ORDER], slope, *intervals[0], *intervals[1], *[tight[parameter] for parameter in ORDER]]
        rows.append([name, experiment, shape, *[repr(float(value)) for value in values], f"{top - reached:.3e}"])
    write("psignifit_data.csv", ["psignifit", "numpy"], [
        "documentation: the example of psignifit's documentation (docs/basic-usage.md), two alternatives; the others simulated.",
        "level: in level units, also where the fit is on the logarithm of the level (weibull).",
    ], ["dataset", "level", "correct", "total"],
        [[name, repr(level), correct, total] for name, (_, _, data) in sets.items() for level, correct, total in data])
    write("psignifit.csv", ["psignifit", "scipy", "numpy"], [
        "psignifit(data, experiment_type=experiment, sigmoid=sigmoid), every other option at its default: thresh_PC 0.5, width_alpha 0.05,",
        "beta_prior 10, CI_method 'percentiles', confP (.95, .9, .68), stimulus_range None (least and greatest level), width_min None (least",
        "distance of levels), fixed_parameters None (2AFC: gamma = 1/2, 4AFC: 1/4, yes/no: gamma free), max_bound_value 1e-5, estimate_type MAP.",
        "Axis: norm, logistic: the level. weibull: psignifit's weibull is a Gumbel function of what it is given and takes no logarithm; it was",
        "given log10(level). So weibull's threshold, width, slope and intervals are in decades, not in level units.",
        "threshold: F = 0.5 (also for weibull), F the sigmoid from 0 to 1. width: from F = 0.05 to F = 0.95. lapse, guess: lambda, gamma.",
        "threshold ... eta: get_parameter_estimate('MAP'). slope: result.slope(threshold), (1 - guess - lapse) dF/dx at the threshold.",
        "threshold_low ... width_high: confidence_intervals[...]['0.95'], percentiles of the marginals on psignifit's grid.",
        "The package's search for the MAP (scipy.optimize.fmin) stops at 1e-4, absolute, in parameters and log posterior. tight_...: the maximum of",
        "the same log posterior by this script to about 6 digits, where eta may be 0 (the package's never is). shortfall: by how much the",
        "log posterior at the package's MAP is lower than there.",
    ], ["dataset", "experiment", "sigmoid", "threshold", "width", "lapse", "guess", "eta", "slope",
        "threshold_low", "threshold_high", "width_low", "width_high",
        "tight_threshold", "tight_width", "tight_lapse", "tight_guess", "tight_eta", "shortfall"], rows)
    print(f"greatest difference from the package's log posterior, but for a constant: {max(offsets):.1e}; at its MAP {max(noise):.1e}")


# Paired comparisons


def pair_sets():
    """Data sets of comparisons: name to {(winner, loser): count}."""
    sets = {}

    def add(name, seed, items, spread, pairs, trials, link):
        rng = np.random.default_rng(seed)
        values = spread * rng.normal(size=items)
        counts = Counter()
        for i, j in pairs:
            n = trials if isinstance(trials, int) else int(rng.integers(*trials))
            p = 1 / (1 + np.exp(values[j] - values[i])) if link == "logit" else ndtr(values[i] - values[j])
            wins = int(rng.binomial(n, p))
            counts[i, j] += wins
            counts[j, i] += n - wins
        sets[name] = {pair: count for pair, count in sorted(counts.items()) if count}

    def some(seed, items, share):
        """A chain, so that all items are connected, and a share of the other pairs."""
        rng = np.random.default_rng(seed)
        return [(i, j) for i, j in itertools.combinations(range(items), 2) if j == i + 1 or rng.random() < share]

    everything = lambda items: list(itertools.combinations(range(items), 2))
    add("three", 51, 3, 0.7, everything(3), 20, "logit")
    add("four", 52, 4, 0.8, everything(4), 12, "probit")
    add("five-unequal", 53, 5, 1.0, everything(5), (4, 30), "logit")
    add("six", 54, 6, 0.6, everything(6), 40, "probit")
    add("seven-few", 55, 7, 0.9, everything(7), 5, "logit")
    add("eight", 56, 8, 1.2, everything(8), 25, "probit")
    add("ten", 57, 10, 0.8, everything(10), 15, "logit")
    add("ten-many", 58, 10, 0.5, everything(10), 400, "probit")
    add("chain-five", 59, 5, 0.7, some(0, 5, 0), 30, "logit")
    add("chain-nine", 60, 9, 0.4, some(0, 9, 0), 60, "probit")
    add("random-eight", 61, 8, 0.7, some(71, 8, 0.3), 20, "logit")
    add("random-ten", 62, 10, 0.8, some(72, 10, 0.4), (6, 40), "probit")
    # Item 0 always beats item 2 and wins against 1 all but once: strongly connected by one answer.
    sets["barely"] = {(0, 1): 19, (1, 0): 1, (0, 2): 20, (1, 2): 17, (2, 1): 3}
    return sets


def pairs():
    import choix
    import statsmodels.api as sm
    from scipy.sparse.csgraph import connected_components

    data_rows, rows, worst = [], [], [0.0, 0.0]
    for name, counts in pair_sets().items():
        items = 1 + max(max(pair) for pair in counts)
        matrix = np.zeros((items, items))
        for (winner, loser), count in counts.items():
            matrix[winner, loser] = count
            data_rows.append([name, winner, loser, count])
        assert connected_components(matrix, directed=True, connection="strong")[0] == 1, name
        trials = [pair for pair, count in counts.items() for _ in range(count)]
        logits = choix.ilsr_pairwise(items, trials, alpha=0, max_iter=100000, tol=1e-12)
        logits -= logits.mean()
        compared = [(i, j) for i, j in itertools.combinations(range(items), 2) if matrix[i, j] + matrix[j, i] > 0]
        design = np.zeros((len(compared), items))
        for row, (i, j) in enumerate(compared):
            design[row, i], design[row, j] = 1, -1
        wins = np.array([[matrix[i, j], matrix[j, i]] for i, j in compared])
        family = sm.families.Binomial(link=sm.families.links.Probit())
        model = sm.GLM(wins, design[:, 1:], family=family)
        with warnings.catch_warnings():
            # A chain is fitted perfectly, which statsmodels takes for separation.
            warnings.simplefilter("ignore")
            result = model.fit(tol=1e-12, tol_criterion="params", maxiter=1000)
        assert result.converged, name
        probits = np.concatenate([[0], result.params])
        probits -= probits.mean()
        # At the maximum both scores are 0.
        p = 1 / (1 + np.exp(-design @ logits))
        worst[0] = max(worst[0], np.abs(design.T @ (wins[:, 0] - wins.sum(axis=1) * p)).max())
        worst[1] = max(worst[1], np.abs(model.score(result.params)).max())
        for item in range(items):
            rows.append([name, item, repr(float(logits[item])), repr(float(probits[item]))])
    print("greatest score: Bradley-Terry %.1e, Thurstone %.1e" % tuple(worst))
    write("pairs_data.csv", ["numpy"], [
        "Simulated comparisons of two items, by their numbers from 0; pairs without a win are absent. Every data set is strongly connected.",
        "chain-...: only neighbors were compared; random-...: neighbors and some other pairs; barely: written by hand.",
    ], ["dataset", "winner", "loser", "count"], data_rows)
    write("pairs.csv", ["choix", "statsmodels", "scipy", "numpy"], [
        "Maximum likelihood without a prior, both with mean 0 over the items of a data set.",
        "bradley_terry: choix.ilsr_pairwise, alpha 0, tol 1e-12; P(i beats j) = 1/(1 + exp(-(v_i - v_j))), v in logits.",
        "thurstone: Case V by statsmodels GLM, binomial, probit link, tol 1e-12 on the parameters; P(i beats j) = Phi(v_i - v_j), v in probits of",
        "the difference: the unit is the standard deviation of a difference (that of one item is 1/sqrt(2)).",
    ], ["dataset", "item", "bradley_terry", "thurstone"], rows)


# Detection

COUNTS = [
    (40, 10, 10, 40), (30, 20, 15, 35), (45, 5, 25, 25), (20, 30, 5, 45), (25, 25, 25, 25), (18, 2, 3, 17), (7, 3, 2, 8),
    (50, 0, 0, 50), (0, 50, 50, 0), (50, 0, 50, 0), (0, 50, 0, 50), (50, 0, 12, 38), (31, 19, 0, 50), (10, 40, 40, 10),
    (1, 0, 0, 1), (0, 1, 1, 0), (90, 10, 3, 197), (3, 1, 60, 140), (999, 1, 1, 999), (100000, 0, 0, 100000), (613, 387, 244, 756),
    (5, 0, 7, 33),
]


def detection():
    rows = []
    for hits, misses, false_alarms, rejections in COUNTS:
        z_hit = ndtri((hits + 0.5) / (hits + misses + 1))
        z_false = ndtri((false_alarms + 0.5) / (false_alarms + rejections + 1))
        values = [z_hit - z_false, -(z_hit + z_false) / 2 + 0.0]
        rows.append([hits, misses, false_alarms, rejections, *[repr(float(value)) for value in values]])
    write("detection.csv", ["scipy", "numpy"], [
        "Log-linear correction (Hautus 1995), in every row: H = (hits + 0.5)/(hits + misses + 1), F likewise; scipy.special.ndtri is z.",
        "d_prime = z(H) - z(F); criterion = -(z(H) + z(F))/2.",
    ], ["hits", "misses", "false_alarms", "correct_rejections", "d_prime", "criterion"], rows)


# Simulated studies


def generators():
    rng = np.random.default_rng(20260)
    people, conditions, levels, trials = 12, {"a": 3.0, "b": 3.8, "c": 5.1}, [0.5, 1.5, 2.5, 4.0, 5.5, 7.0, 9.0], 20
    sd, person_sd, cell_sd = 1.5, 0.8, 0.3
    rows, truth = [], []
    for person in range(1, people + 1):
        shift = person_sd * rng.normal()
        thresholds = [mean + shift + cell_sd * rng.normal() for mean in conditions.values()]
        truth.append(f"P{person:02}: " + " ".join(f"{threshold:.4f}" for threshold in thresholds))
        for condition, threshold in zip(conditions, thresholds):
            for level in levels:
                correct = rng.binomial(trials, 0.5 + 0.5 * ndtr((level - threshold) / sd))
                rows.append([f"P{person:02}", condition, level, int(correct), trials])
    write("people.csv", ["numpy", "scipy"], [
        "Simulated: two alternatives, P(correct) = 0.5 + 0.5 Phi((level - threshold)/sd), no lapses, sd = 1.5 for all.",
        "threshold = mean of the condition (a 3.0, b 3.8, c 5.1) + the person's shift (sd 0.8, the same in all) + a share of its own (sd 0.3).",
        "Its true values per person, in the order a, b, c:",
        *truth,
    ], ["person", "condition", "level", "correct", "total"], rows)


if __name__ == "__main__":
    {"questplus": questplus, "psignifit": psignifit, "pairs": pairs, "detection": detection, "generators": generators}[sys.argv[1]]()
