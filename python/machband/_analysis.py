"""Results of an analysis: its tables, figures and report, and the ordinal model."""

from __future__ import annotations

import io
import json
import os
from collections.abc import Iterable, Mapping
from functools import cached_property
from os import PathLike
from pathlib import Path
from statistics import NormalDist
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _machband
from ._common import Table, axes, flag, in_python, named, nearest, number, suggests, table
from ._common import path as path_of
from ._tables import columns, encoded, labeled


@suggests
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
        from matplotlib import image

        ax = axes(ax)
        ax.imshow(image.imread(io.BytesIO(self.png), format="png"))
        ax.set_axis_off()
        return ax


@suggests
class Analysis:
    """An analysis of ratings or of the answers to a task, from `analyze`.

    It can be pickled and copied. A notebook shows its summary and figures. The attributes of the model are named as in
    statsmodels; the analysis of a task has no such model, only `tables`.

    Attributes
    ----------
    tables
        The tables that ``machband analyze`` writes: ``cells``, ``by_FACTOR``, ``tests``, ``thresholds`` of a task, … In
        ``tests``, the effect of a comparison is the later ``level`` minus the earlier one, ``other``.
    files
        The tables, the model and the R script, by their file names, with the bytes that the command writes.
    errors
        What is wrong with the input, one text each. Rows with errors were left out, and the rest was analyzed.
    warnings
        What else a reader should know about the input.
    """

    def __init__(self, native: _machband.Analysis, given: list[str], known: Iterable[str]) -> None:
        """Wrap the results for the paths given; `known` are the arguments that messages may name."""
        found = native.facts()
        self._native: _machband.Analysis | None = native
        self.warnings, self.errors = ([in_python(one, known) for one in found[name]] for name in ("warnings", "errors"))
        self.tables: dict[str, Table] = {name: table(*described) for name, described in found["tables"]}
        self.files: dict[str, bytes] = dict(found["files"])
        self._summary, self._page, self._covariance = found["summary"], found["page"], found["covariance"]
        self._inputs = [*given, *map(os.fspath, found["inputs"])]

    def __getstate__(self) -> dict[str, Any]:
        """Pickle everything that can be asked for; the report cannot be drawn again without the data."""
        return {**vars(self), "_report_files": self._report_files, "_native": None}

    @cached_property
    def model(self) -> dict[str, Any]:
        """The ordinal model, as in ``model.json``: thresholds, coefficients, their standard errors and p."""
        if "model.json" not in self.files:
            raise _machband.Error(f"a task has no ordinal model; expected one of the tables {', '.join(self.tables)}")
        model: dict[str, Any] = json.loads(self.files["model.json"])
        return model

    @cached_property
    def _report_files(self) -> dict[str, bytes]:
        return dict(self._native.report_files()) if self._native else {}

    @property
    def _fitted(self) -> dict[str, Any]:
        if error := self.model.get("error"):
            raise _machband.Error(f"no model was fitted, because {error}")
        return self.model

    @property
    def _rows(self) -> list[dict[str, Any]]:
        return [*self._fitted["thresholds"], *self._fitted["coefficients"]]

    def _named(self, values: Any, columns: list[str] | None = None) -> Any:
        """Return values of the thresholds and coefficients by name; `None` is NaN."""
        return named([row["name"] for row in self._rows], np.array(values, np.float64), columns)

    @property
    def params(self) -> Any:
        """Estimates of the thresholds, such as ``0|1``, and of the coefficients, by name: a Series, or a dict."""
        return self._named([row["estimate"] for row in self._rows])

    @property
    def bse(self) -> Any:
        """Standard errors of `params`, from the observed information."""
        return self._named([row["se"] for row in self._rows])

    def cov_params(self) -> Table:
        """Return the covariance of `params`, the thresholds and the coefficients."""
        names = [row["name"] for row in self._rows]
        return named(names, self._covariance[: len(names), : len(names)], names)

    @property
    def llf(self) -> float:
        """Log-likelihood, without constants that depend only on the counts."""
        return float(self._fitted["loglik"])

    @property
    def aic(self) -> float:
        """Akaike's information criterion."""
        return float(self._fitted["aic"])

    @property
    def bic(self) -> float:
        """The Bayesian information criterion with the number of ratings."""
        return float(self._fitted["bic"])

    @property
    def nobs(self) -> int:
        """Number of ratings."""
        return int(self.model["nobs"])

    @property
    def pvalues(self) -> Any:
        """Two-sided p of `params`, calibrated by simulated studies; NaN for thresholds and where no simulation tests one.

        With few people, Wald's p would be too small; the table ``coefficients`` has it where it is not.
        """
        of_term = {test["term"]: test["p"] for test in self._fitted["likelihood_ratio"] if test["df"] == 1}
        parts = [part for row in self.model["coefficients"] for part in row["parts"]]
        shifted = {(part["variable"], part["level"]) for part in parts}
        of_level = {}
        for pair in self.model["comparisons"]:
            from_baseline = {(pair["factor"], pair["level"]), (pair["factor"], pair["other"])} & shifted
            if len(from_baseline) == 1 and not pair["at"] and not pair["average"]:
                of_level[from_baseline.pop()] = pair["p"]
        main = {row["name"]: (row["term"], row["parts"][0]["level"]) for row in self.model["coefficients"]}
        found = [of_term.get(row.get("term"), of_level.get(main.get(row["name"], ("", "")))) for row in self._rows]
        return self._named(found)

    def conf_int(self, alpha: float = 0.05) -> Table:
        """Return a table with the ends of the 1 − `alpha` intervals of `params`, ``lower`` and ``upper``.

        At 0.05, those of coefficients are profile-likelihood intervals; all others are Wald's.
        """
        if not 0 < (alpha := number("alpha", alpha)) < 1:
            raise _machband.Error(f"alpha is {alpha!r}; expected a number between 0 and 1")
        reach = NormalDist().inv_cdf(1 - alpha / 2)
        estimates, errors = np.array([[row["estimate"], row["se"]] for row in self._rows], np.float64).T
        ends = np.stack([estimates - reach * errors, estimates + reach * errors], axis=1)
        for end, row in zip(ends, self._rows, strict=True):
            if alpha == 0.05 and row.get("interval"):
                end[:] = row["interval"]["low"], row["interval"]["high"]
        return self._named(ends, ["lower", "upper"])

    def predict(self, data: Any) -> Table:
        """Return the probability of each category in the rows of a table, for a person in the middle of the population.

        Parameters
        ----------
        data
            A table as for `analyze`, with a column for each factor in the model. The levels must be among those analyzed;
            terms with ``num:`` take any number. The table ``predictions`` has the same for the conditions that were rated.
        """
        listed = columns(data)
        if listed is None:
            raise TypeError(f"data is {type(data).__name__}; expected a table")
        names = [name for name, _ in listed]
        given = {name: column for name, column in listed if names.count(name) == 1}
        estimates = np.array([row["estimate"] for row in self._rows], np.float64)[:, np.newaxis]
        thresholds = estimates[: len(self.model["thresholds"])]
        latent = np.zeros(max((len(column) for column in given.values()), default=0))
        for row, estimate in zip(self.model["coefficients"], estimates[len(thresholds) :], strict=True):
            latent += estimate * np.prod([self._variable(part, given) for part in row["parts"]], axis=0)
        logistic = self.model["link"] == "logit"
        below = (
            1 / (1 + np.exp(latent - thresholds)) if logistic else np.vectorize(NormalDist().cdf)(thresholds - latent)
        )
        shares = np.diff(below, axis=0, prepend=0, append=1)
        found = table(dict(zip(self.model["categories"], shares, strict=True)))
        return found.set_axis(data.index) if hasattr(data, "reset_index") else found

    def _variable(self, part: Mapping[str, str | None], given: Mapping[str, Any]) -> npt.NDArray[np.float64]:
        """Return a variable of the model in each row: a number, or whether a factor has a level."""
        level, name = part["level"], str(part["variable"]).removeprefix("num:")
        inverse = name == "inv_n" and name not in given
        name = "depth" if inverse else name
        if name not in given:
            raise _machband.Error(f"the column {name} is missing or appears twice; expected one for each factor in the model")
        texts, codes, _ = labeled(name, encoded(name, given[name]))
        if (codes < 0).any():
            raise _machband.Error(f"{name} is missing in row {codes.argmin()} (counted from 0); expected a level")
        if level is None:
            numbers = np.array(texts, np.float64)[codes]
            return np.reciprocal(numbers) if inverse else numbers
        known = [one["level"] for one in self.model["margins"] if one["factor"] == name]
        if unknown := {texts[code] for code in np.unique(codes)}.difference(known):
            wrong = min(unknown)
            expected = f"expected one of {', '.join(dict.fromkeys(known))}{nearest(wrong, among=known)}"
            raise _machband.Error(f"{name} is {wrong}, which was not analyzed; {expected}")
        return np.array([cell == level for cell in texts], np.float64)[codes]

    def summary(self) -> str:
        """Return the sentences at the beginning of the report."""
        return str(self._summary)

    @property
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
        files = {**self.files, **({} if flag("tables_only", tables_only) else self._report_files)}
        given = path_of("folder", folder), list(files.items()), self._inputs, flag("force", force)
        return [Path(path) for path in _machband.write_analysis(*given)]

    def __repr__(self) -> str:
        """Return the summary."""
        return self.summary()

    def _repr_html_(self) -> str:
        drawings = (figure.svg[figure.svg.find("<svg") + 4 :] for figure in self.figures.values())
        figures = "".join(
            f'<div style="flex: 1 1 26em; max-width: 40em"><svg style="width: 100%; height: auto"{drawing}</div>'
            for drawing in drawings
        )
        return f'{self._page}<div style="display: flex; flex-wrap: wrap">{figures}</div>'
