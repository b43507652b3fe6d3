"""Recorded data: reading, analyzing, verifying and exporting them."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from . import _machband
from ._analysis import Analysis
from ._common import Seed, Table, levels, options, path, progress, suggests, table, texts, words
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
        found, described = _machband.read_results(path("folder", folder), show)
    found["simulated"] = found["simulated"].astype(bool)
    return table(found, described)


def _paths(data: object) -> Iterator[str]:
    if isinstance(data, (str, os.PathLike)):
        yield os.fspath(data)
    elif isinstance(data, Sequence):
        for one in data:
            yield from _paths(one)
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
    seed: Seed = 1,
    level: str | None = None,
    correct: str | None = None,
    total: str | None = None,
    guess: float | str | None = None,
    function: Literal["weibull", "logistic", "normal"] | None = None,
    easier: Literal["high", "low"] | None = None,
    log: bool = False,
    factors: str | Sequence[str] | Mapping[str, Sequence[Any]] | None = None,
    on_error: Literal["raise", "drop"] = "raise",
) -> Analysis:
    """Analyze ratings, as ``machband analyze`` does: descriptive statistics, ordinal mixed model, tests, figures.

    Parameters
    ----------
    data
        A table: a DataFrame of pandas, whose named index levels count as columns, or of polars; a table of pyarrow or a
        relation of DuckDB, through the Arrow C stream, which needs pyarrow; a structured array, or a dict of columns. Or
        result files, folders, tables of counts, or any CSV files. Answers to a task are read from their folder. Ordered
        categories (`Categorical`, `Enum`) say which values a column has, and their order. A masked value is missing. The
        scale of a table that is not from `read_results` is the one that its responses show.
    subject
        Column with the participant ID [default: subject_id, or the only column participant, participant_id, subject or
        subject_nr].
    response
        Column with the ordered response [default: rating, 0–3].
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
    level
        Column with the levels of a psychometric function: the table has answers at levels instead of ratings.
    correct
        Column with the number of right answers, or of answers yes; without --total, 1 or 0.
    total
        Column with the number of trials [default: each row is one trial].
    guess
        Probability of a right answer by guessing, such as 0.5 of two alternatives; free if it is estimated, as of
        answers yes.
    function
        Shape of the psychometric function [default: normal].
    easier
        The end of the levels that is easier to see [default: high].
    log
        Fit the function to the decadic logarithms of the levels.
    factors
        Columns with the factors [default: the factors of the definition or of the terms]. A dict gives the order of
        their levels, of which the first is the baseline: ``{"dose": ["none", "little", "lots"]}``.
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
        ratings = found.get("rating")
        if response is None and "task" in found and isinstance(ratings, np.ndarray) and np.isnan(ratings).all():
            raise _machband.Error("the rows answer a task and have no rating; expected the folder of their sessions")
        cells = [(name, cell[:2] if isinstance(cell, Levels) else cell) for name, cell in found.items()]
    if categories is not None and response is None and wide is None:
        response = "rating"
    given = options(analyze, locals(), "factors", "on_error")
    if isinstance(factors, Mapping):
        orders.update({factor: order for factor, order in factors.items() if len(order)})
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
        sessions, errors = _machband.verify(path("folder", folder), show)
    return Verification({Path(file): found for file, found in sessions}, errors)


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
    fields = {"folder": path("folder", folder), "out": path("out", out), "format": words("format", format) or ""}
    experiments, counts = _machband.export({**options(export, locals()), **fields})
    return Exported(experiments, *counts)
