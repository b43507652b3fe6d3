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
from typing import Any, Literal, NamedTuple

import numpy as np

from . import _machband
from ._common import Table, options, progress, suggests, table, words


def read_results(folder: str | PathLike[str]) -> Table:
    """Read all sessions in a results folder, or one data file, without losing anything.

    Parameters
    ----------
    folder
        A results folder, the folder of one experiment, or a data file.

    Returns
    -------
    A table with one row for each recorded trial: practice trials, and ratings that were corrected later, are included.
    IDs are text; times of day are UTC; depth is a number and can be infinite. In a DataFrame, ``attrs["units"]`` and
    ``attrs["descriptions"]`` say what the columns mean, and ``attrs["simulated"]`` whether any rating is simulated;
    pandas drops ``attrs`` in some operations, such as a merge. `analyze` uses the rows whose phase is ``main``, and only
    the last attempt of each trial::

        main = rows[rows.phase == "main"]
        last = main.sort_values("attempt").drop_duplicates(["subject_id", "session_id", "trial"], keep="last")
    """
    with progress("sessions") as show:
        columns, described, simulated = _machband.read_results(os.fspath(folder), show)
    return table(columns, described, simulated)


class Figure(NamedTuple):
    """A figure of an analysis, which a notebook shows: an SVG drawing, and the same as a PNG, 1600 pixels wide."""

    name: str
    svg: str
    png: bytes

    def _repr_svg_(self) -> str:
        return self.svg

    def save(self, path: str | PathLike[str]) -> None:
        """Write the figure to a file, whose name ends in ``.svg`` or ``.png``."""
        path = Path(path)
        if path.suffix not in (".svg", ".png"):
            raise _machband.Error(f"{path} is neither an SVG nor a PNG file; expected a name that ends in .svg or .png")
        path.write_bytes(self.png if path.suffix == ".png" else self.svg.encode())


class Analysis:
    """An analysis of ratings, from `analyze`. A notebook shows its summary and figures.

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
        self._is_simulated = False
        self.warnings, self.errors = native.problems()

    @cached_property
    def tables(self) -> dict[str, Table]:
        """The tables that ``machband analyze`` writes: ``cells``, ``by_FACTOR``, ``tests``, ``agreement``, …"""
        return {name: table(columns, described) for name, columns, described in self._native.tables()}

    @cached_property
    def files(self) -> dict[str, bytes]:
        """The tables, the model and the R script, by their file names, with the bytes that the command writes."""
        return dict(self._native.table_files())

    @cached_property
    def model(self) -> dict[str, Any]:
        """The ordinal model, as in ``model.json``: thresholds, coefficients, their standard errors and p."""
        model: dict[str, Any] = json.loads(self.files["model.json"])
        return model

    @property
    def coefficients(self) -> Table:
        """The thresholds and the coefficients of the model: estimate, standard error, z and p (NaN for thresholds).

        These are Wald's p. With few people they are too small; the table ``tests`` has p from simulated studies.
        """
        rows = [*self.model["thresholds"], *self.model["coefficients"]]
        numbers = {
            key: np.array([np.nan if row.get(key) is None else row[key] for row in rows], dtype=np.float64)
            for key in ("estimate", "se", "z", "p")
        }
        return table({"name": np.array([row["name"] for row in rows], dtype=object), **numbers})

    @property
    def summary(self) -> str:
        """The sentences at the beginning of the report."""
        first = ["The ratings are simulated."] if self._is_simulated else []
        return "\n".join([*first, *self._native.summary()])

    @cached_property
    def _report_files(self) -> dict[str, bytes]:
        return dict(self._native.report_files())

    @cached_property
    def figures(self) -> dict[str, Figure]:
        """The figures: ``figure4a``, ``figure4b``, …"""
        files = self._report_files
        names = [name.removesuffix(".svg") for name in files if name.endswith(".svg")]
        return {name: Figure(name, files[f"{name}.svg"].decode(), files[f"{name}.png"]) for name in names}

    @cached_property
    def report(self) -> str:
        """The whole report as an HTML page."""
        return self._report_files["report.html"].decode()

    def save(self, folder: str | PathLike[str], *, tables_only: bool = False, force: bool = False) -> list[Path]:
        """Write the tables, figures and report into a folder; with `force`, replace an earlier analysis there."""
        return [Path(path) for path in self._native.save(os.fspath(folder), tables_only, force)]

    def __repr__(self) -> str:
        """Return the summary."""
        return self.summary

    def _repr_html_(self) -> str:
        drawings = (figure.svg[figure.svg.find("<svg") + 4 :] for figure in self.figures.values())
        figures = "".join(f'<div style="flex: 1 1 26em; max-width: 40em"><svg style="width: 100%; height: auto"{drawing}</div>' for drawing in drawings)
        first = "<p>The ratings are simulated.</p>" if self._is_simulated else ""
        return f'{first}{self._native.summary_html()}<div style="display: flex; flex-wrap: wrap">{figures}</div>'


def _columns(data: Any) -> Mapping[str, Any] | None:
    """Return the columns of a table, or `None` if `data` is not a table. Named index levels are columns too."""
    if hasattr(data, "reset_index") and hasattr(data, "columns"):
        if data.columns.nlevels > 1:
            raise _machband.Error(f"the columns have {data.columns.nlevels} levels; expected one, such as after droplevel")
        if twice := data.columns[data.columns.duplicated()].tolist():
            raise _machband.Error(f"two columns are named {twice[0]!r}; expected a different name for each")
        named = [level for level, name in enumerate(data.index.names) if name is not None and name not in data.columns]
        return data.reset_index(level=named) if named else data  # type: ignore[no-any-return]
    if getattr(getattr(data, "dtype", None), "names", None):
        return {name: data[name] for name in data.dtype.names}
    if isinstance(data, Mapping) or (hasattr(data, "columns") and hasattr(data, "__getitem__")):
        columns: Mapping[str, Any] = data
        return columns
    return None


def _cells(data: Mapping[str, Any]) -> list[tuple[str, Any]]:
    """Return the columns of a table with their names: arrays of numbers, or texts, which are empty if missing."""
    if not len(list(data)):
        raise _machband.Error("the table has no columns; expected at least a participant, a rating and a factor")
    columns: list[tuple[str, Any]] = []
    for name in data:
        column = data[name]
        if getattr(getattr(column, "dtype", None), "tz", None) is not None:
            column = column.dt.tz_convert(None)
        array = np.asarray(column)
        if array.ndim != 1:
            raise _machband.Error(f"column {name!r} has shape {array.shape}; expected one dimension")
        cells: Any
        if array.dtype.kind in "ib" or (array.dtype.kind == "u" and array.dtype.itemsize < 8):
            cells = np.ascontiguousarray(array, np.int64)
        elif array.dtype.kind == "f":
            cells = np.ascontiguousarray(array, np.float64)
        elif array.dtype.kind == "M":
            cells = [f"{time}Z" for time in np.datetime_as_string(array, "ms")]
        else:
            missing = np.asarray(column.isna()) if hasattr(column, "isna") else [cell is None for cell in array]
            cells = ["" if gone else str(cell) for gone, cell in zip(missing, array, strict=True)]
        columns.append((str(name), cells))
    return columns


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
    factors: str | Sequence[str] | None = None,
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
) -> Analysis:
    """Analyze ratings, as ``machband analyze`` does: descriptive statistics, ordinal mixed model, tests, figures.

    Parameters
    ----------
    data
        A DataFrame, whose named index levels count as columns, or a dict of columns; or result files, folders, tables of
        counts, or any CSV files. An ordered `Categorical` says which categories the response has, and their order. In
        rows of `read_results` or `simulate`, the factors are the parameters of the stimulus that vary, and every column
        that you added.
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
    factors
        Columns with the factors [default: the factors of the definition or of the terms].
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

    Returns
    -------
    The results. Problems in the data are Python warnings, and `errors` and `warnings` of the results list them; the rest
    is analyzed.

    Examples
    --------
    >>> ratings = simulate("quick", participants=4, seed=3)
    >>> analyze(ratings, draws=99).tables["by_width"]["width"].tolist()
    [0.02, 0.1, 0.4, 0.8]
    """
    columns = _columns(data)
    if columns is not None and categories is None and wide is None and (response or "rating") in list(columns):
        dtype: Any = getattr(columns[response or "rating"], "dtype", None)
        ordered = list(dtype.categories) if getattr(dtype, "ordered", False) else None
        # Our own scale needs no name.
        categories = ordered if response is not None or (ordered and not set(ordered) <= {0, 1, 2, 3}) else None
    if categories is not None and response is None and wide is None:
        response = "rating"
    given = options(analyze, locals())
    ratings = _cells(columns) if columns is not None else list(_paths(data))
    if not ratings:
        raise _machband.Error("there are no paths; expected at least one")
    with progress("simulated studies") as show:
        analysis = Analysis(_machband.analyze(given, ratings, show))
    analysis._is_simulated = bool(getattr(data, "attrs", {}).get("simulated"))
    for problem in [*analysis.warnings, *analysis.errors]:
        warnings.warn(problem, stacklevel=3)
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
