"""Definitions of experiments, and simulated sessions."""

from __future__ import annotations

import json
import math
import os
import tempfile
from collections.abc import Mapping
from os import PathLike
from typing import Any, Literal

import numpy as np

from . import _machband
from ._common import Seed, Table, options, path, plain, progress, seed_of, suggests, table, text
from ._study import read_results


def _plain(given: object) -> Any:
    """Return a value that JSON can hold; infinity is ``inf``, as in a definition file."""
    given = plain(given)
    if isinstance(given, Mapping):
        return {str(key): _plain(item) for key, item in given.items() if item is not None}
    if isinstance(given, (list, tuple, range, np.ndarray)):
        return [_plain(item) for item in given]
    if isinstance(given, np.generic):
        # A number is the one that it is written as: 0.2 in 32 bits is not 0.2 in 64.
        given = float(str(given)) if isinstance(given, np.floating) else given.item()
    if isinstance(given, float) and not math.isfinite(given):
        return str(given)
    if isinstance(given, (str, int, float)):
        return given
    raise TypeError(f"{given!r} cannot be part of a definition; expected a number, text, a list or a dict")


@suggests
class Definition:
    """The definition of an experiment: its stimuli, design and procedure.

    Examples
    --------
    >>> definition = Definition.load("bangay2003")
    >>> [*definition.to_dict()["factors"]]
    ['width', 'depth', 'orientation_deg']
    """

    _native: _machband.Definition

    def __init__(self, name_or_path: str | PathLike[str]) -> None:
        """Read a definition; the same as `load`."""
        self._native = _machband.Definition.load(path("name_or_path", name_or_path))

    @classmethod
    def load(cls, name_or_path: str | PathLike[str]) -> Definition:
        """Read a built-in definition by its name, such as ``quick`` or ``bangay2003``, or a TOML file."""
        return cls(name_or_path)

    @classmethod
    def from_dict(cls, keys: Mapping[str, Any]) -> Definition:
        """Make a definition from the keys of a definition file.

        >>> Definition.from_dict({
        ...     "schema": 1,
        ...     "name": "widths",
        ...     "stimulus": {"kind": "mach-band", "color": "gray"},
        ...     "factors": {"width": [0.1, 0.2, 0.4]},
        ... }).conditions()["width"].tolist()
        [0.1, 0.2, 0.4]
        """
        if not isinstance(keys, Mapping):
            raise TypeError(f"keys is {keys!r}; expected a dict")
        definition = cls.__new__(cls)
        definition._native = _machband.Definition.from_json(json.dumps(_plain(keys)))
        return definition

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the keys."""
        return Definition.from_dict, (self.to_dict(),)

    def __eq__(self, other: object) -> bool:
        """Compare the content."""
        return isinstance(other, Definition) and self.sha256 == other.sha256

    def __hash__(self) -> int:
        """Hash the content."""
        return hash(self.sha256)

    def save(self, file: str | PathLike[str]) -> None:
        """Write the definition to a new TOML file, which the window and the commands read."""
        try:
            with open(path("file", file), "x", encoding="utf-8") as out:
                out.write(self._native.to_toml())
        except OSError as error:
            raise _machband.Error(f"{file}: {error.strerror}; expected a new file in a folder") from None

    def to_dict(self) -> dict[str, Any]:
        """Return all keys, with their defaults but without default texts; the form in the sidecars."""
        keys: dict[str, Any] = json.loads(self._native.to_json())
        return keys

    @property
    def name(self) -> str:
        """The name, which names the folder of the results."""
        return str(self.to_dict()["name"])

    @property
    def sha256(self) -> str:
        """Hash of the content, as in the sidecars."""
        return self._native.sha256

    def conditions(self) -> Table:
        """Return a table of the conditions: the kind of stimulus, and every parameter."""
        return table(*self._native.conditions())

    def schedule(self, participant: str | int = "S001", session: str | int = "1", seed: Seed = 1) -> Table:
        """Return a table of the trials of a session: phase, block, trial, repetition, condition, and the factors.

        ``condition`` is the row of the table that `conditions` returns, counted from 0. The order is the one that the
        window and the commands use for this participant, session and seed.
        """
        participant, session = text("participant", participant), text("session", session)
        return table(*self._native.schedule(participant, session, seed_of("seed", seed)))

    def __repr__(self) -> str:
        """Name the definition."""
        return f"<Definition {self.name!r}>"


@suggests
def simulate(
    definition: Definition | Mapping[str, Any] | str | PathLike[str],
    *,
    participants: int = 1,
    seed: Seed = 1,
    observer: Literal["paper", "random", "vision"] | None = None,
    observer_file: str | PathLike[str] | None = None,
    resume: bool = False,
    results: str | PathLike[str] | None = None,
) -> Table:
    """Run simulated sessions, with the same program and files as real ones, and return their rows.

    Parameters
    ----------
    definition
        A definition, its keys as a dict, the name of a built-in one, or the path of a file.
    participants
        Number of participants; their IDs start at S001.
    seed
        Seed of the trial order and of the observers.
    observer
        Simulated observer [default: paper for ratings, vision for other tasks].
    observer_file
        Parameters of the paper or vision observer; experiments/observers has the documented defaults.
    resume
        Resume an interrupted run; complete sessions are not changed.
    results
        Folder in which the sessions are kept. Without it, they are deleted after they have been read.

    Returns
    -------
    A table with one row per trial, as from `read_results`.

    Examples
    --------
    >>> len(simulate("quick", participants=2, seed=7))
    56
    """
    if resume and results is None:
        raise _machband.Error(f"resume is {resume!r} without results; expected the folder of the interrupted run")
    if isinstance(definition, Mapping):
        definition = Definition.from_dict(definition)
    if not isinstance(definition, Definition):
        definition = Definition(path("definition", definition))
    with tempfile.TemporaryDirectory(prefix="machband-") as temporary:
        folder = temporary if results is None else path("results", results)
        given = {**options(simulate, locals(), "results"), "results": folder}
        with progress("trials") as show:
            _machband.simulate(definition._native, given, show)
        return read_results(os.path.join(folder, definition.name))
