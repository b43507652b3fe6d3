"""Tables that come in: from pandas, polars, pyarrow, DuckDB, structured arrays and dicts of columns."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime, timezone
from importlib.util import find_spec
from typing import Any, NamedTuple, Union

import numpy as np
import numpy.typing as npt

from ._common import text
from ._machband import Error

Whole = npt.NDArray[np.int64]


class Levels(NamedTuple):
    """A column of text: the different texts, and for each row the index of its text, or −1 if it is missing.

    `is_ordered` says whether the order of the texts means something.
    """

    levels: list[str]
    codes: Whole
    is_ordered: bool = False


#: A column as whole numbers, as numbers, of which missing ones are NaN, or as texts.
Cells = Union[Whole, npt.NDArray[np.float64], Levels]


def columns(data: Any) -> list[tuple[str, Any]] | None:
    """Return the columns of a table, and named index levels of pandas; or `None` if `data` is not a table."""
    if (found := _columns(data)) is None:
        return None
    named = [(_text("the name of a column", name), column) for name, column in found]
    for name, column in named:
        if not hasattr(column, "__len__") or isinstance(column, (str, bytes)) or getattr(column, "ndim", 1) == 0:
            raise TypeError(f"column {name!r} is {column!r}; expected a list or an array")
        if len(column) != (rows := len(named[0][1])):
            raise Error(f"{name} has length {len(column)}; expected {rows}, as {named[0][0]} has")
    return named


def _columns(data: Any) -> list[tuple[Any, Any]] | None:
    if hasattr(data, "__arrow_c_stream__") and not hasattr(data, "reset_index"):
        if not (find_spec("pandas") and find_spec("pyarrow")):
            if hasattr(data, "get_columns"):
                # A DataFrame of polars needs neither.
                return [(column.name, column) for column in data.get_columns()]
            raise TypeError(f"{type(data).__name__} needs pyarrow and pandas, which are not installed")
        import pyarrow

        try:
            kinds = [str(kind) for kind in getattr(data, "types", ())]
            data = pyarrow.table(data).to_pandas(ignore_metadata=True, integer_object_nulls=True)
            # DuckDB does not say in Arrow that an ENUM has an order.
            enums = [name for name, kind in zip(data.columns, kinds) if kind.startswith("ENUM")]
            data = data.assign(**{name: data[name].cat.as_ordered() for name in enums})
        except (ValueError, NotImplementedError) as error:
            # A single column has no table.
            if not hasattr(data, "columns"):
                return None
            expected = "expected columns that Arrow has"
            raise Error(f"{type(data).__name__} cannot be read: {error}; {expected}") from None
    if hasattr(data, "reset_index") and hasattr(data, "columns"):
        if data.columns.nlevels > 1:
            raise Error(f"the columns have {data.columns.nlevels} levels; expected one, such as after droplevel")
        named = [level for level, name in enumerate(data.index.names) if name is not None and name not in data.columns]
        data = data.reset_index(level=named) if named else data
        return [(name, data.iloc[:, place]) for place, name in enumerate(data.columns)]
    if hasattr(data, "collect"):
        raise TypeError(f"{type(data).__name__} is not computed yet; expected a DataFrame, such as from its .collect()")
    names = data if isinstance(data, Mapping) else getattr(getattr(data, "dtype", None), "names", None)
    return None if names is None else [(name, data[name]) for name in names]


def encoded(name: str, column: Any) -> Cells:
    """Return the cells of a column. True is 1, and False 0."""
    dtype: Any = getattr(column, "dtype", None)
    if hasattr(dtype, "categories") and hasattr(dtype, "ordered"):
        codes = np.asarray(getattr(column, "cat", column).codes, np.int64)
        return Levels(listed(name, np.asarray(dtype.categories)), codes, bool(dtype.ordered))
    if hasattr(column, "to_physical") and type(dtype).__name__ == "Enum":
        return Levels(dtype.categories.to_list(), column.to_physical().cast(int).fill_null(-1).to_numpy(), True)
    if getattr(dtype, "tz", None) is not None:
        column = column.dt.tz_convert(None)
    if getattr(dtype, "kind", "") in "iu" and getattr(column, "hasnans", False):
        column = column.astype(object)
    masked: Any = np.broadcast_to(column.mask, column.shape) if isinstance(column, np.ma.MaskedArray) else None
    array = np.asarray(column)
    if array.ndim != 1:
        raise Error(f"column {name!r} has shape {array.shape}; expected one dimension")
    is_whole = array.dtype.kind in "ib" or (array.dtype.kind == "u" and array.dtype.itemsize < 8)
    if is_whole and (masked is None or not masked.any()):
        return np.ascontiguousarray(array, np.int64)
    if is_whole or array.dtype.kind == "f":
        numbers = np.ascontiguousarray(array, np.float64)
        if array.dtype.kind == "f" and array.dtype.itemsize < 8:
            # Each is the number that it is written as: 0.2 in 32 bits is not 0.2 in 64.
            different, codes = np.unique(array, return_inverse=True)
            numbers = different.astype(str).astype(np.float64)[codes]
        return numbers if masked is None else np.where(masked, np.nan, numbers)
    codes, found = _factorized(name, array)
    if masked is not None:
        codes = np.where(masked, -1, codes)
    kinds = {type(level) for level in found}
    if kinds and kinds <= {bool, np.bool_}:
        return np.ascontiguousarray(np.array([*found, np.nan])[codes], np.float64)
    if kinds and all(issubclass(kind, (datetime, np.datetime64)) for kind in kinds):
        return Levels(_times(found), codes)
    return Levels([_text(name, level) for level in found], codes)


def labeled(name: str, cells: Cells) -> Levels:
    """Return a column as texts, also if it has numbers."""
    if isinstance(cells, Levels):
        return cells
    found, codes = np.unique(cells, return_inverse=True)
    return Levels([text(name, one) for one in found], np.where(np.isnan(cells), -1, codes))


def listed(name: str, array: npt.NDArray[Any], missing: str = "") -> list[str]:
    """Return the text of each value; that of a missing one is `missing`."""
    levels, codes, _ = labeled(name, encoded(name, array))
    return [levels[code] if code >= 0 else missing for code in codes]


def _factorized(name: str, array: npt.NDArray[Any]) -> tuple[Whole, Any]:
    """Return the index of each value among the different ones, −1 for a missing one, and these."""
    try:
        if array.dtype.kind == "M":
            found, codes = np.unique(array, return_inverse=True)
            return np.where(np.isnat(array), -1, codes), found[~np.isnat(found)]
        if find_spec("pandas") is None:
            index: dict[Any, int] = {}
            cells = array.tolist()
            numbers = [-1 if cell is None or cell != cell else index.setdefault(cell, len(index)) for cell in cells]
            return np.array(numbers, np.int64), list(index)
        import pandas

        codes, found = pandas.factorize(array.astype(object))
        return codes.astype(np.int64), found
    except (TypeError, ValueError):
        kinds = sorted({type(cell).__name__ for cell in array if type(cell).__hash__ is None} or {"mixed values"})
        raise TypeError(f"column {name!r} has cells of {', '.join(kinds)}; expected numbers, texts or times") from None


def _times(moments: Any) -> list[str]:
    """Return times in UTC as texts: dates if all are at midnight, otherwise as precise as they are, from 1 ms on."""
    utc = [
        one.astimezone(timezone.utc).replace(tzinfo=None) if getattr(one, "tzinfo", None) else one for one in moments
    ]
    times = np.array([getattr(one, "to_datetime64", lambda one=one: np.datetime64(one))() for one in utc])
    unit = next(unit for unit in ("D", "ms", "us", "ns", "as") if (times == times.astype(f"M8[{unit}]")).all())
    return [one if unit == "D" else f"{one}Z" for one in times.astype(f"M8[{unit}]").astype(str).tolist()]


def _text(name: str, level: object) -> str:
    """Return the text of a level."""
    is_number = isinstance(level, (int, float, np.number)) and not isinstance(level, bool)
    try:
        found = text(name, level) if is_number else level.decode() if isinstance(level, bytes) else str(level)
        found.encode()
    except UnicodeError:
        raise Error(f"{name} has {level!a}; expected text in Unicode, of which bytes are UTF-8") from None
    return found
