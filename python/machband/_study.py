"""Recorded data: reading, analyzing, verifying and exporting them."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from pathlib import Path
from statistics import NormalDist
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _machband
from ._common import Table, levels, named, options, plotted, progress, suggests, table, text, texts, words
from ._tables import Levels, columns, encoded


class DataWarning(UserWarning):
    """A warning about data that are analyzed anyway, such as missing responses."""


def read_results(folder: str | PathLike[str]) -> Table:
    """Read all sessions in a results folder, or one data file, without losing anything.

    Parameters
    ----------
    folder
        A results folder, the folder of one experiment, or a data file.

    Returns
    -------
    A table with one row for each recorded trial: practice trials, and ratings that were corrected later, are included.
    IDs are text; times of day are UTC; depth is a number and can be infinite. The column ``simulated`` says whether a
    program answered; reports of these rows say so too. In a DataFrame, ``attrs["units"]`` and ``attrs["descriptions"]``
    say what the columns mean. `analyze` uses the rows whose phase is ``main``, and only the last attempt of each trial::

        main = rows[rows.phase == "main"]
        last = main.sort_values("attempt").drop_duplicates(["subject_id", "session_id", "trial"], keep="last")
    """
    with progress("sessions") as show:
        found, described = _machband.read_results(os.fspath(folder), show)
    found["simulated"] = found["simulated"].astype(bool)
    return table(found, described)


class Figure(NamedTuple):
    """A figure of an analysis, which a notebook shows: an SVG drawing, and the same as a PNG, 1600 pixels wide."""

    name: str
    svg: str
    png: bytes

    def __repr__(self) -> str:
        """Name the figure."""
        return f"<Figure {self.name!r}>"

    def _repr_svg_(self) -> str:
        return self.svg

    def plot(self, ax: Any = None) -> Any:
        """Draw the figure on axes of matplotlib, by default new ones, and return them."""
        return plotted(self.png, ax)

    def save(self, path: str | PathLike[str]) -> None:
        """Write the figure to a file, whose name ends in ``.svg`` or ``.png``."""
        path = Path(path)
        if path.suffix not in (".svg", ".png"):
            raise _machband.Error(f"{path} is neither an SVG nor a PNG file; expected a name that ends in .svg or .png")
        path.write_bytes(self.png if path.suffix == ".png" else self.svg.encode())


class Analysis:
    """An analysis of ratings or of the answers to a task, from `analyze`.

    It can be pickled and copied. A notebook shows its summary and figures. The attributes of the model have the names that
    they have in statsmodels; the analysis of a task has no such model, only `tables`.

    Attributes
    ----------
    errors
        What is wrong with the input, one text each. Rows with errors were left out, and the rest was analyzed.
    warnings
        What else a reader should know about the input.
    """

    warnings: list[str]
    errors: list[str]

    def __init__(self, native: _machband.Analysis) -> None:
        """Wrap the results."""
        self._native = native
        self.warnings, self.errors = native.problems()

    def __getstate__(self) -> dict[str, Any]:
        """Pickle everything that can be asked for; the model cannot be fitted again without the data."""
        for name, member in vars(Analysis).items():
            if isinstance(member, cached_property) and (name != "model" or "model.json" in self.files):
                getattr(self, name)
        return {name: kept for name, kept in vars(self).items() if name != "_native"}

    @cached_property
    def tables(self) -> dict[str, Table]:
        """The tables that ``machband analyze`` writes: ``cells``, ``by_FACTOR``, ``tests``, ``thresholds`` of a task, …"""
        return {name: table(found, described) for name, found, described in self._native.tables()}

    @cached_property
    def files(self) -> dict[str, bytes]:
        """The tables, the model and the R script, by their file names, with the bytes that the command writes."""
        return dict(self._native.table_files())

    @cached_property
    def model(self) -> dict[str, Any]:
        """The ordinal model, as in ``model.json``: thresholds, coefficients, their standard errors and p."""
        if "model.json" not in self.files:
            raise _machband.Error(f"a task has no ordinal model; expected one of the tables {', '.join(self.tables)}")
        model: dict[str, Any] = json.loads(self.files["model.json"])
        return model

    @cached_property
    def _covariance(self) -> npt.NDArray[np.float64]:
        return self._native.covariance()

    @cached_property
    def _summaries(self) -> tuple[str, str]:
        return "\n".join(self._native.summary()), self._native.summary_html()

    @cached_property
    def _inputs(self) -> list[str]:
        return [os.fspath(path) for path in self._native.inputs()]

    @cached_property
    def _report_files(self) -> dict[str, bytes]:
        return dict(self._native.report_files())

    @property
    def _rows(self) -> list[dict[str, Any]]:
        return [*self.model["thresholds"], *self.model["coefficients"]]

    def _named(self, key: str) -> Any:
        """Return a property of every threshold and coefficient by name."""
        found = [np.nan if row.get(key) is None else row[key] for row in self._rows]
        return named([row["name"] for row in self._rows], np.array(found, np.float64))

    @property
    def params(self) -> Any:
        """Estimates of the thresholds, such as ``0|1``, and of the coefficients, by name: a Series, or a dict."""
        return self._named("estimate")

    @property
    def bse(self) -> Any:
        """Standard errors of `params`, from the observed information."""
        return self._named("se")

    def cov_params(self) -> Table:
        """Return the covariance of the thresholds, the coefficients and the standard deviation of the random intercept."""
        names = [row["name"] for row in self._rows]
        names += [f"sd {i}" if i else "sd" for i in range(len(self._covariance) - len(names))]
        return named(names, self._covariance, names)

    @property
    def llf(self) -> float:
        """Log-likelihood, without constants that depend only on the counts."""
        return float(self.model["loglik"])

    @property
    def aic(self) -> float:
        """Akaike's information criterion."""
        return float(self.model["aic"])

    @property
    def bic(self) -> float:
        """The Bayesian information criterion with the number of ratings."""
        return float(self.model["bic"])

    @property
    def nobs(self) -> int:
        """Number of ratings."""
        return int(self.model["nobs"])

    @property
    def pvalues(self) -> Any:
        """Two-sided p of `params`, calibrated by simulated studies; NaN for thresholds and where no simulation tests one.

        With few people, Wald's p would be too small; the table ``coefficients`` has it where it is not.
        """
        of_term = {test["term"]: test["p"] for test in self.model["likelihood_ratio"] if test["df"] == 1}
        pairs = {(one["factor"], one["level"], one["other"]): one["p"] for one in self.model["comparisons"] if not one["at"]}
        found = []
        for row in self._rows:
            parts, baseline = row.get("parts", []), {}
            if len(parts) == 1:
                factor = parts[0]["variable"]
                shifted = {part["level"] for other in self.model["coefficients"] for part in other["parts"]}
                baseline = {key[0]: p for key, p in pairs.items() if key[1] == parts[0]["level"] and key[2] not in shifted}
                found.append(of_term.get(row["term"], baseline.get(factor)))
            else:
                found.append(of_term.get(row.get("term")))
        return named([row["name"] for row in self._rows], np.array(found, np.float64))

    def conf_int(self, alpha: float = 0.05) -> Table:
        """Return a table with the ends of the 1 − `alpha` intervals of `params`, ``lower`` and ``upper``.

        At 0.05, those of coefficients are profile-likelihood intervals; all others are Wald's.
        """
        if not 0 < alpha < 1:
            raise _machband.Error(f"alpha is {alpha!r}; expected a number between 0 and 1")
        quantile = NormalDist().inv_cdf(1 - alpha / 2)
        ends = []
        for row in self._rows:
            profile = row.get("interval") if alpha == 0.05 else None
            estimate, se = (np.nan if row[key] is None else row[key] for key in ("estimate", "se"))
            wald = {"low": estimate - quantile * se, "high": estimate + quantile * se}
            ends.append([(profile or wald)[end] for end in ("low", "high")])
        return named([row["name"] for row in self._rows], np.array(ends, np.float64), ["lower", "upper"])

    def predict(self, data: Any) -> Table:
        """Return the probability of each category in the rows of a table, for a person in the middle of the population.

        Parameters
        ----------
        data
            A table as for `analyze`, with a column for each factor in the model. The levels must be among those analyzed;
            terms with ``num:`` take any number. The table ``predictions`` averages over people instead.
        """
        given = columns(data)
        if given is None:
            raise TypeError(f"data is {type(data).__name__}; expected a table")
        rows = max((len(column) for column in given.values()), default=0)
        latent = np.zeros(rows)
        for row in self.model["coefficients"]:
            values = [self._values(part["variable"], part["level"], given) for part in row["parts"]]
            latent += row["estimate"] * np.prod(values, axis=0)
        cdf = np.vectorize(NormalDist().cdf) if self.model["link"] == "probit" else lambda at: 1 / (1 + np.exp(-at))
        below = [cdf(row["estimate"] - latent) for row in self.model["thresholds"]]
        shares = np.diff([np.zeros(rows), *below, np.ones(rows)], axis=0)
        return table(dict(zip(self.model["categories"], shares, strict=True)))

    def _values(self, variable: str, level: str | None, given: Mapping[str, Any]) -> npt.NDArray[np.float64]:
        """Return a variable of the model in each row: a number, or whether a factor has this level."""
        name = variable.removeprefix("num:")
        inverse = name == "inv_n" and name not in given
        name = "depth" if inverse else name
        if name not in given:
            raise _machband.Error(f"the column {name} is missing; expected a column for each factor in the model")
        cells = encoded(name, given[name])
        if level is None:
            numbers = np.array(cells.levels, np.float64)[cells.codes] if isinstance(cells, Levels) else cells.astype(np.float64)
            return 1 / numbers if inverse else numbers
        texts = np.array(cells.levels)[cells.codes] if isinstance(cells, Levels) else np.array([text(name, one) for one in cells])
        known = {one["level"] for one in self.model["margins"] if one["factor"] == name}
        if unknown := set(texts.tolist()) - known:
            raise _machband.Error(f"{name} has {min(unknown)}, which was not analyzed; expected one of {', '.join(sorted(known))}")
        return (texts == level).astype(np.float64)

    def summary(self) -> str:
        """Return the sentences at the beginning of the report."""
        return self._summaries[0]

    @cached_property
    def figures(self) -> dict[str, Figure]:
        """The figures: ``figure4a``, ``figure4b``, …"""
        files = self._report_files
        names = [name.removesuffix(".svg") for name in files if name.endswith(".svg")]
        return {name: Figure(name, files[f"{name}.svg"].decode(), files[f"{name}.png"]) for name in names}

    @property
    def report(self) -> str:
        """The whole report as an HTML page."""
        return self._report_files["report.html"].decode()

    def save(self, folder: str | PathLike[str], *, tables_only: bool = False, force: bool = False) -> list[Path]:
        """Write the tables, figures and report into a folder; with `force`, replace an earlier analysis there."""
        files = {**self.files, **({} if tables_only else self._report_files)}
        return [Path(path) for path in _machband.write_analysis(folder, list(files.items()), self._inputs, force)]

    def __repr__(self) -> str:
        """Return the summary."""
        return self.summary()

    def _repr_html_(self) -> str:
        drawings = (figure.svg[figure.svg.find("<svg") + 4 :] for figure in self.figures.values())
        figures = "".join(f'<div style="flex: 1 1 26em; max-width: 40em"><svg style="width: 100%; height: auto"{drawing}</div>' for drawing in drawings)
        return f'{self._summaries[1]}<div style="display: flex; flex-wrap: wrap">{figures}</div>'


def _paths(data: object) -> Iterator[str]:
    if isinstance(data, (str, os.PathLike)):
        yield os.fspath(data)
    elif isinstance(data, Sequence):
        for path in data:
            yield from _paths(path)
    else:
        raise TypeError(f"{type(data).__name__} is not a path; expected paths, or one DataFrame or dict of columns")


@suggests
def analyze(
    data: Any,
    *,
    subject: str | None = None,
    response: str | None = None,
    wide: str | Sequence[str] | None = None,
    missing: str | Sequence[str] | None = None,
    categories: str | Sequence[str] | None = None,
    count: str | None = None,
    factors: str | Sequence[str] | Mapping[str, Sequence[Any]] | None = None,
    direction: str | Sequence[str] | None = None,
    exclude: str | Sequence[str] | None = None,
    only: Mapping[str, Sequence[Any]] | None = None,
    complete_only: bool = False,
    order: str | None = None,
    time: str | None = None,
    min_time: float | None = None,
    max_time: float | None = None,
    terms: str | Sequence[str] | None = None,
    link: Literal["logit", "probit"] = "logit",
    slopes: Literal["none", "independent", "correlated"] = "independent",
    large: bool = False,
    random: Literal["none", "subject"] | None = None,
    covariate: str | Sequence[str] | None = None,
    items: str | None = None,
    draws: int = 999,
    seed: int = 1,
    on_error: Literal["raise", "drop"] = "raise",
) -> Analysis:
    """Analyze ratings, as ``machband analyze`` does: descriptive statistics, ordinal mixed model, tests, figures.

    Parameters
    ----------
    data
        A table: a DataFrame of pandas, whose named index levels count as columns, or of polars; a table of pyarrow or a
        relation of DuckDB, through the Arrow C stream, which needs pyarrow; a structured array, or a dict of columns. Or
        result files, folders, tables of counts, or any CSV files. Answers to a task are read from their folder. Ordered
        categories (`Categorical`, `Enum`) say which values a column has, and their order. A masked value is missing.
    subject
        Column with the participant ID [default: subject_id, or the only column participant, participant_id, subject or
        subject_nr].
    response
        Column with the ordered response [default: rating; 0–3 in result files].
    wide
        Columns with the ordered responses at each level of a factor, which is named condition unless NAME= says
        otherwise.
    missing
        Texts that mean a missing response, such as -99, in addition to an empty cell, NA and similar words.
    categories
        Categories of the response, lowest first, if they are not numbers. Quote a category that contains a comma, as in
        CSV: 'low,"medium, mostly",high'.
    count
        Column with the number of trials per row [default: count, if present].
    factors
        Columns with the factors [default: the factors of the definition or of the terms]. A dict gives the order of
        their levels, of which the first is the baseline: ``{"dose": ["none", "little", "lots"]}``.
    direction
        Factors that are directions, which are circular [default: stimulus parameters that are directions].
    exclude
        Participants to exclude.
    only
        Analyze only these levels of a factor; NA means a missing value. Several factors can be given.
    complete_only
        Exclude sessions with unrated trials.
    order
        Column with the place of each row in its session: numbers that increase from trial to trial. The report then
        describes drift, and how much successive ratings are related [default: the number of the trial in result files].
    time
        Column with the response time in seconds [default: response_time_s, if present].
    min_time
        Exclude trials that were answered faster, in seconds.
    max_time
        Exclude trials that were answered more slowly, in seconds.
    terms
        Terms of the model: names of factors. Prefix a numeric term with num:, and join the factors of an interaction
        with : or * [default: every factor that varies].
    link
        Link function of the cumulative model.
    slopes
        Random slopes: for each term that varies within participants, as far as the design supports it (independent), or
        with all their correlations (correlated).
    large
        Also analyze a study that is larger than usual: more than 10 factors, 120 levels of a factor, 5,000 conditions,
        20,000 participants, 120 coefficients or 5 minutes of simulated studies, or names of more than 200 bytes. The
        time grows with their square or cube.
    random
        Random intercept for each participant [default: subject if there are at least two participants].
    covariate
        Numbers that describe participants: each has one slope in the model, and no levels [default: numbers that are
        the same in all ratings of each participant].
    items
        Column that names the stimuli of which the study shows a sample, such as pictures: each has a random intercept,
        beside those of the participants, so that conclusions hold for other stimuli.
    draws
        Maximum number of simulated studies that calibrate tests and intervals. Simulation ends earlier when more
        studies would not change a conclusion.
    seed
        Seed of the simulated studies.
    on_error
        What to do with rows that are wrong, such as a rating that is not on the scale: ``raise`` a `DataError`, whose
        `rows` are their positions, or ``drop`` them with a warning, if they are at most 2 % of the rows.

    Returns
    -------
    The results. What a reader should know about the data is a `DataWarning`; the results list it too.

    Examples
    --------
    >>> ratings = simulate("quick", participants=4, seed=3)
    >>> analyze(ratings, draws=99).tables["by_width"]["width"].tolist()
    [0.02, 0.1, 0.4, 0.8]
    """
    if on_error not in ("raise", "drop"):
        raise _machband.Error(f"on_error is {on_error!r}; expected 'raise' or 'drop'")
    orders: dict[str, Sequence[Any]] = {}
    given_columns = columns(data)
    if given_columns is None:
        cells: list[str] | list[tuple[str, Any]] = list(_paths(data))
        if not cells:
            raise _machband.Error("there are no paths; expected at least one")
    else:
        found = {name: encoded(name, column) for name, column in given_columns.items()}
        if not found:
            raise _machband.Error("the table has no columns; expected at least a participant, a rating and a factor")
        orders = {name: cells.levels for name, cells in found.items() if isinstance(cells, Levels) and cells.is_ordered}
        scale = orders.pop(response or "rating", None)
        if categories is None and wide is None:
            categories = scale
        if getattr(data, "attrs", {}).get("simulated") and "simulated" not in found:
            found["simulated"] = np.ones(len(data), np.int64)
        cells = [(name, cell[:2] if isinstance(cell, Levels) else cell) for name, cell in found.items()]
    if categories is not None and response is None and wide is None:
        response = "rating"
    given = options(analyze, locals(), "factors", "on_error")
    if isinstance(factors, Mapping):
        orders.update(factors)
    if factors is not None:
        given["factors"] = texts("factors", factors)
    if orders:
        given["levels"] = levels("factors", orders)
    with progress("simulated studies") as show:
        analysis = Analysis(_machband.analyze(given, cells, on_error == "drop", show))
    for problem in [*analysis.warnings, *analysis.errors]:
        warnings.warn(problem, DataWarning, stacklevel=3)
    return analysis


@dataclass(frozen=True)
class Verification:
    """What `verify` found. It is true if nothing is wrong.

    `sessions` has the path of each data file with a sentence about it; `errors` has everything that is wrong.
    """

    sessions: dict[Path, str]
    errors: list[str]

    def __bool__(self) -> bool:
        """Return whether nothing is wrong."""
        return not self.errors


def verify(folder: str | PathLike[str]) -> Verification:
    """Verify recorded sessions, as ``machband verify`` does.

    Every row is checked against the definition and the seed, every picture that was shown is rendered again and its hash
    compared, and every file is compared with the hash that was recorded at the end of the session.

    Parameters
    ----------
    folder
        A results folder, the folder of one experiment, or a data file.

    Returns
    -------
    A `Verification`, which is true if nothing is wrong.
    """
    with progress("sessions") as show:
        sessions, errors = _machband.verify(os.fspath(folder), show)
    return Verification({Path(path): found for path, found in sessions}, errors)


class Exported(NamedTuple):
    """What `export` wrote."""

    experiments: list[str]
    sessions: int
    rows: int
    pictures: int


@suggests
def export(
    folder: str | PathLike[str],
    out: str | PathLike[str],
    format: str = "bids",
    *,
    complete_only: bool = False,
    accept_changes: bool = False,
) -> Exported:
    """Export recorded sessions as a data set that passes the standard's validator, as ``machband export`` does.

    Parameters
    ----------
    folder
        A results folder, or the folder of one experiment.
    out
        A new or empty folder outside the data.
    format
        ``bids`` or ``psych-ds``.
    complete_only
        Exclude sessions with unrated trials.
    accept_changes
        Also export files that were changed after their session ended; the export then names them.

    Returns
    -------
    What was written: the names of the experiments, and the numbers of sessions, rows and pictures.
    """
    fields = {"folder": os.fspath(folder), "out": os.fspath(out), "format": words("format", format) or ""}
    experiments, counts = _machband.export({**options(export, locals()), **fields})
    return Exported(experiments, *counts)
