"""Tables that come in: from pandas, polars, pyarrow, DuckDB, structured arrays and dicts of columns."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from contextlib import suppress
from datetime import datetime, timezone
from typing import Any, NamedTuple, Union

import numpy as np
import numpy.typing as npt

from ._common import nearest, text
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
    found = _columns(data)
    if found is None:
        return None
    names = [_text("the name of a column", name if isinstance(name, bytes) else str(name)) for name, _ in found]
    for name, (_, column) in zip(names, found, strict=True):
        if not hasattr(column, "__len__") or isinstance(column, (str, bytes)) or getattr(column, "ndim", 1) == 0:
            raise TypeError(f"column {name!r} is {column!r}; expected a list or an array")
    rows = [len(column) for _, column in found]
    for name, count in zip(names, rows, strict=True):
        if count != rows[0]:
            raise Error(f"{name} has length {count}; expected {rows[0]}, as {names[0]} has")
    return [(name, column) for name, (_, column) in zip(names, found, strict=True)]


def _columns(data: Any) -> list[tuple[Any, Any]] | None:
    if hasattr(data, "reset_index") and hasattr(data, "columns"):
        if data.columns.nlevels > 1:
            raise Error(f"the columns have {data.columns.nlevels} levels; expected one, such as after droplevel")
        named = [level for level, name in enumerate(data.index.names) if name is not None and name not in data.columns]
        data = data.reset_index(level=named) if named else data
        return [(name, data.iloc[:, place]) for place, name in enumerate(data.columns)]
    if getattr(getattr(data, "dtype", None), "names", None):
        return [(name, data[name]) for name in data.dtype.names]
    if hasattr(data, "collect") and not hasattr(data, "__arrow_c_stream__"):
        raise TypeError(f"{type(data).__name__} is not computed yet; expected a DataFrame, such as from its .collect()")
    if hasattr(data, "__arrow_c_stream__"):
        try:
            import pyarrow
        except ImportError:
            if not isinstance(data, Mapping) and not hasattr(data, "get_column"):
                raise TypeError(
                    f"{type(data).__name__} needs pyarrow, which is not installed; expected a DataFrame"
                ) from None
        else:
            try:
                arrow = pyarrow.table(data)
            except pyarrow.ArrowInvalid as error:
                if hasattr(data, "columns"):
                    message = f"{type(data).__name__} cannot be read: {error}; expected columns that Arrow has"
                    raise Error(message) from None
                # A single column.
                return None
            for place, kind in enumerate(map(str, getattr(data, "types", ()))):
                if kind.startswith("ENUM"):
                    # DuckDB does not say in Arrow that it has an order.
                    column = arrow[place].combine_chunks()
                    column = pyarrow.DictionaryArray.from_arrays(column.indices, column.dictionary, ordered=True)
                    arrow = arrow.set_column(place, arrow.field(place).name, pyarrow.chunked_array([column]))
            return [*zip(arrow.column_names, arrow.columns, strict=True)]
    if isinstance(data, Mapping) or (hasattr(data, "columns") and hasattr(data, "__getitem__")):
        return [(name, data[name]) for name in (data if isinstance(data, Mapping) else data.columns)]
    return None


def encoded(name: str, column: Any) -> Cells:
    """Return the cells of a column. True is 1, and False 0."""
    if hasattr(column, "combine_chunks"):
        column = _of_arrow(name, column)
    if isinstance(column, Levels):
        return column
    dtype: Any = getattr(column, "dtype", None)
    if str(dtype).startswith("Enum(") and hasattr(column, "to_physical"):
        codes = column.to_physical().cast(int).fill_null(-1)
        return Levels(list(dtype.categories), np.asarray(codes, np.int64), True)
    if hasattr(dtype, "categories") and hasattr(dtype, "ordered"):
        codes = np.asarray(getattr(column, "cat", column).codes, np.int64)
        return Levels(_texts(name, dtype.categories), codes, bool(dtype.ordered))
    if getattr(dtype, "tz", None) is not None:
        column = column.dt.tz_convert(None)
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


def _texts(name: str, values: Any) -> list[str]:
    """Return the text of each value; it is empty if the value is missing."""
    levels, codes, _ = labeled(name, encoded(name, np.asarray(values)))
    return [levels[code] if code >= 0 else "" for code in codes]


def ordered(factor: str, listed: Any, cells: Cells | None, is_complete: bool) -> list[Any]:
    """Return the texts of a factor's levels in the order given, if its column is known to have no others.

    With `is_complete`, all that the column has must be there.
    """
    if isinstance(listed, (str, bytes, set, frozenset)) or not isinstance(listed, Iterable):
        raise TypeError(f"factors[{factor!r}] is {listed!r}; expected a list of levels, which has an order")
    array = np.fromiter(listed, object)
    if cells is None:
        return [*array]
    levels, codes, _ = labeled(factor, encoded(f"factors[{factor!r}]", array))
    texts = [levels[code] if code >= 0 else "NA" for code in codes]

    def key(level: str) -> object:
        # A number can be written in several ways.
        with suppress(ValueError):
            return level.strip() if isinstance(cells, Levels) else float(level)
        return level

    levels, codes, _ = labeled(factor, cells)
    occurring = [levels[code] for code in np.unique(codes) if code >= 0]
    known = {key(level): level for level in occurring if level.strip() not in MISSING}
    keys = [key(level) for level in texts]
    wrong = [level for level, its in zip(texts, keys, strict=True) if its not in known]
    problems = [f"{level!r}, which is not one of its levels" for level in wrong]
    problems += [f"{level!r} twice" for place, level in enumerate(texts) if keys[place] in keys[:place]]
    problems += [f"no {level!r}" for its, level in known.items() if is_complete and its not in keys]
    if keys and known and problems:
        expected = f"expected {', '.join([*known.values()][:20])}, each once"
        raise Error(f"factors[{factor!r}] has {problems[0]}; {expected}{nearest(*wrong[:1], among=known.values())}")
    return texts


#: Texts that mean a missing value.
MISSING = {"", "NA", "NaN", "nan", "NULL", "#N/A", "N/A", "n/a"}


def _of_arrow(name: str, column: Any) -> Any:
    """Return a column of Arrow as an array of numbers, or as texts."""
    import pyarrow

    kind = column.type
    if pyarrow.types.is_null(kind):
        return np.full(len(column), np.nan)
    if pyarrow.types.is_nested(kind):
        raise TypeError(f"column {name!r} has cells of type {kind}; expected numbers, texts or times")
    if not pyarrow.types.is_dictionary(kind):
        if not (
            pyarrow.types.is_string(kind) or pyarrow.types.is_large_string(kind) or pyarrow.types.is_string_view(kind)
        ):
            return column.to_numpy()
        column = column.cast(pyarrow.large_string()).dictionary_encode()
    chunks = column.unify_dictionaries().chunks
    found = chunks[0].dictionary if chunks else pyarrow.nulls(0)
    codes = [np.asarray(chunk.indices.cast(pyarrow.int64()).fill_null(-1)) for chunk in chunks]
    cells = np.concatenate([np.empty(0, np.int64), *codes])
    # A dictionary may have a missing value among its levels.
    cells[np.isin(cells, np.flatnonzero(found.is_null()))] = -1
    return Levels(_texts(name, found), cells, bool(column.type.ordered))


def _factorized(name: str, array: npt.NDArray[Any]) -> tuple[Whole, Any]:
    """Return the index of each value among the different ones, −1 for a missing one, and these."""
    try:
        if array.dtype.kind == "M":
            found, codes = np.unique(array, return_inverse=True)
            return np.where(np.isnat(array), -1, codes), found[~np.isnat(found)]
        try:
            import pandas
        except ImportError:
            index: dict[Any, int] = {}
            cells = array.tolist()
            numbers = [-1 if cell is None or cell != cell else index.setdefault(cell, len(index)) for cell in cells]
            return np.array(numbers, np.int64), list(index)
        codes, found = pandas.factorize(array.astype(object))
        return codes.astype(np.int64), found
    except TypeError:
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
