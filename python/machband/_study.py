"""Recorded data: reading, analyzing, verifying and exporting them."""

from __future__ import annotations

import csv
import inspect
import json
import os
import re
import warnings
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _machband
from ._analysis import Analysis
from ._common import Listed, Seed, Table, Texts, options, path, progress, suggests, table, texts, typed, words
from ._machband import DataError, Error
from ._tables import Cells, Levels, columns, encoded, labeled, listed


class DataWarning(UserWarning):
    """A warning about data that are analyzed anyway, such as missing responses."""


@suggests
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
    say what the columns mean, ``attrs["categories"]`` what the scale is, and ``attrs["simulated"]`` whether a program
    answered all rows. `analyze` uses the rows whose phase is ``main``, and only the last attempt of each trial::

        main = rows[rows.phase == "main"]
        last = main.sort_values("attempt").drop_duplicates(["subject_id", "session_id", "trial"], keep="last")
    """
    with progress("sessions") as show:
        found, described = _machband.read_results(path("folder", folder), show)
    found["simulated"] = found["simulated"].astype(bool)
    rows = table(found, described)
    if hasattr(rows, "attrs"):
        definitions = [json.loads(file.read_bytes())["definition"] for file in _sidecars(folder)]
        scales = {len(one["response"]["labels"]) for one in definitions if not one.get("task")}
        rows.attrs["simulated"] = bool(found["simulated"].all())
        if len(scales) == 1:
            rows.attrs["categories"] = list(range(*scales))
    return rows


def _sidecars(data: Any) -> Iterator[Path]:
    """Return the sidecars of a data file or of those in a folder, which have their definitions."""
    root = Path(data)
    found = [root.with_suffix(".json")] if root.is_file() else root.rglob("*_data.json")
    return (file for file in found if file.is_file())


def _paths(data: object) -> list[str]:
    expected = "paths, or one DataFrame or dict of columns"
    paths = data if isinstance(data, (list, tuple)) else [data]
    return [str(os.fspath(typed("data", one, (str, os.PathLike), expected))) for one in paths]


def _levels(argument: str, given: Any) -> list[str]:
    """Return factors, each with the texts of its levels in the order given."""
    factors: Any = typed(argument, given, Mapping, "a dict of factors with lists of levels")
    found = []
    for factor, order in factors.items():
        name = f"{argument}[{factor!r}]"
        if isinstance(order, (str, bytes, set, frozenset, Mapping)) or not isinstance(order, Iterable):
            raise TypeError(f"{name} is {order!r}; expected a list of levels, which has an order")
        levels = listed(name, np.fromiter(order, object), "NA")
        twice = [level for level in levels if levels.count(level) > 1]
        if twice or not levels:
            has = f"has {twice[0]} twice" if twice else "has no level"
            raise Error(f"{name} {has}; expected each level once")
        quoted = str(factor).strip().replace('"', '""')
        found.append(f'"{quoted}"={texts(name, levels)}')
    return found


def _plain(value: Any) -> Any:
    """Return a value whose `repr` can be pasted: without arrays and scalars of NumPy."""
    if isinstance(value, Mapping):
        return {_plain(key): _plain(one) for key, one in value.items()}
    value = getattr(value, "tolist", lambda: value)()
    return [_plain(one) for one in value] if isinstance(value, (list, tuple)) else value


def _located(error: Error, responses: list[Cells]) -> Error:
    """Return an error with the rows of its numbers if they look like codes for a missing answer, such as -99."""
    if isinstance(error, DataError) or not (codes := re.search(", such as missing '?([^']+)'?$", str(error))):
        return error
    texts = [labeled("", cells) for cells in responses]
    # The last one stands for missing values, whose index is -1.
    is_code = [np.append(np.isin(one.levels, codes[1].split(",")), False)[one.codes] for one in texts]
    located = DataError(str(error))
    located.rows = np.flatnonzero(np.any(is_code, axis=0))
    return located


@suggests
def analyze(
    data: Any,
    *,
    subject: str | None = None,
    wide: Texts | None = None,
    categories: Texts | None = None,
    count: str | None = None,
    direction: Texts | None = None,
    exclude: Texts | None = None,
    only: Mapping[str, Listed] | None = None,
    complete_only: bool = False,
    order: str | None = None,
    time: str | None = None,
    min_time: float | None = None,
    max_time: float | None = None,
    terms: Texts | None = None,
    link: Literal["logit", "probit"] = "logit",
    slopes: Literal["none", "independent", "correlated"] = "independent",
    large: bool = False,
    random: Literal["none", "subject"] | None = None,
    covariate: Texts | None = None,
    items: str | None = None,
    draws: int = 999,
    seed: Seed = 1,
    correct: str | None = None,
    total: str | None = None,
    guess: float | str | None = None,
    function: Literal["weibull", "logistic", "normal"] | None = None,
    easier: Literal["high", "low"] | None = None,
    log: bool = False,
    response: str | None = None,
    missing: float | Texts | None = None,
    level: str | None = None,
    factors: Texts | Mapping[str, Listed] | None = None,
    on_error: Literal["raise", "drop"] = "raise",
) -> Analysis:
    """Analyze ratings, as ``machband analyze`` does: descriptive statistics, ordinal mixed model, tests, figures.

    Parameters
    ----------
    data
        A table: a DataFrame of pandas, whose named index levels count as columns, or of polars; a table of pyarrow or a
        relation of DuckDB, through the Arrow C stream, which needs pyarrow and pandas; a structured array, or a dict of
        columns. Or result files, folders, tables of counts, or any tables (CSV or Excel). Answers to a task are read from
        their folder. Ordered categories (`Categorical`, `Enum`) say which values a column has, and their order. A masked
        value is missing; True is 1, and False 0. A DataFrame from `read_results` or `simulate` knows its scale by its
        attributes, which a selection keeps and a merge may lose; any other table or file without a definition has the
        scale that its responses show.
    subject
        Column with the participant ID [default: subject_id, or the only column participant, participant_id, subject or
        subject_nr].
    wide
        Columns with the ordered responses at each level of a factor, which is named condition unless NAME= says
        otherwise.
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
        with *, or with : beside its parts [default: every factor that varies].
    link
        Link function of the cumulative model.
    slopes
        Random slopes: for each term that varies within participants, where the design supports it (independent), or
        with all their correlations (correlated).
    large
        Also analyze a study that is larger than usual: more than 10 factors, 120 levels of a factor, 5,000 conditions,
        20,000 participants or 120 coefficients, or names of more than 200 bytes. The time grows with their square or
        cube.
    random
        Random intercept for each participant [default: subject if there are at least two participants].
    covariate
        Numbers that describe participants: each has one slope in the model, and no levels [default: numbers that are
        the same in all ratings of each participant].
    items
        Column that names the stimuli of which the study shows a sample, such as pictures: each has a random intercept,
        beside those of the participants, so that conclusions hold for other stimuli.
    draws
        Maximum number of simulated studies that calibrate tests and intervals, 99 to 1,000,000. Simulation ends earlier
        when more studies would not change a conclusion.
    seed
        Seed of the simulated studies.
    correct
        Column with the number of correct answers, or of yes answers; 1 or 0 if each row is one trial.
    total
        Column with the number of trials [default: each row is one trial].
    guess
        Probability of a correct answer by guessing, such as 0.5 for two alternatives; free to estimate it, as for yes
        answers.
    function
        Shape of the psychometric function [default: normal].
    easier
        The end of the levels that is easier to see [default: high].
    log
        Fit the function to the base-10 logarithms of the levels.
    response
        Column with the ordered response [default: rating].
    missing
        Numbers or texts that mean a missing response, such as -99, in addition to an empty cell, NA and similar words.
    level
        Column with the levels of a psychometric function: the table has answers at levels instead of ratings.
    factors
        Columns with the factors [default: the factors of the definition or of the terms]. A dict gives the order of
        their levels, of which the first is the baseline: ``{"dose": ["none", "little", "lots"]}``. Levels that are not
        named follow.
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
        raise Error(f"on_error is {on_error!r}; expected 'raise' or 'drop'")
    if level is not None and categories is not None:
        raise Error("categories does not apply to answers at levels; expected ratings, or no categories")
    found: dict[str, Cells] = {}
    orders: dict[str, list[str]] = {}
    given_columns = columns(data)
    if given_columns is None:
        cells: list[str] | list[tuple[str, Any]] = _paths(data)
    else:
        recorded = getattr(data, "attrs", {})
        if recorded.get("simulated") and "simulated" not in dict(given_columns):
            given_columns.append(("simulated", np.ones(len(data), np.int64)))
        found = {name: encoded(name, column) for name, column in given_columns}
        # The library refuses a name that two columns have if it is used.
        cells = [(name, one[:2] if isinstance(one := found[name], Levels) else one) for name, _ in given_columns]
        orders = {name: one.levels for name, one in found.items() if isinstance(one, Levels) and one.is_ordered}
    is_ours = response is None and wide is None
    if is_ours and level is None and (found or categories is not None or not any(map(any, map(_sidecars, cells)))):
        # Without a name, the library would assume a scale from 0 to 3, also of data without a definition.
        response = "rating"
    asked = [str(response)] if wide is None else next(csv.reader([texts("wide", wide).split("=", 1)[-1]]))
    answers = [found[name] for name in asked if name in found]
    no_rating = all(isinstance(one, np.ndarray) and np.isnan(one).all() for one in answers)
    if is_ours and response and "task" in found and no_rating:
        raise Error("the rows answer a task and have no rating; expected the folder of their sessions")
    scales = [orders.pop(name, None) for name in asked]
    if categories is None and found and level is None:
        if is_ours and all(isinstance(one, np.ndarray) for one in answers):
            categories = recorded.get("categories")
        elif asked and all(scale == scales[0] for scale in scales):
            categories = scales[0]
    given = options(analyze, locals(), "factors", "only", "on_error")
    # A generator draws another one each time.
    seed = int(str(given["seed"]))
    usual, own = options(analyze, {}, "factors", "only", "on_error"), locals()
    call = "".join(f", {name}={_plain(own[name])!r}" for name, one in given.items() if one != usual.get(name))
    call += "".join(f", {name}={_plain(own[name])!r}" for name in ("factors", "only") if own[name] is not None)
    if factors is not None:
        given["factors"] = texts("factors", [*factors] if isinstance(factors, Mapping) else factors)
    if isinstance(factors, Mapping):
        given["levels"] = _levels("factors", factors)
    if only is not None:
        given["only"] = _levels("only", only)
    with progress("simulated studies") as show:
        try:
            native = _machband.analyze(given, cells, [*orders.items()], on_error == "drop", call, show)
        except Error as error:
            raise _located(error, answers) from None
    paths = [one for one in cells if isinstance(one, str)]
    analysis = Analysis(native, paths, inspect.signature(analyze).parameters)
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


@suggests
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
    if not sessions and not os.path.exists(folder):
        raise Error(errors[0])
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
    format: Literal["bids", "psych-ds"] = "bids",
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
    fields = {"folder": path("folder", folder), "out": path("out", out), "format": words("format", format)}
    experiments, counts = _machband.export({**options(export, locals()), **fields})
    return Exported(experiments, *counts)
