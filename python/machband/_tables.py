"""Tables that come in: from pandas, polars, pyarrow, DuckDB, structured arrays and dicts of columns."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

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


def columns(data: Any) -> dict[str, Any] | None:
    """Return the columns of a table, and named index levels of pandas; or `None` if `data` is not a table."""
    if hasattr(data, "reset_index") and hasattr(data, "columns"):
        if data.columns.nlevels > 1:
            raise Error(f"the columns have {data.columns.nlevels} levels; expected one, such as after droplevel")
        if twice := data.columns[data.columns.duplicated()].tolist():
            raise Error(f"two columns are named {twice[0]!r}; expected a different name for each")
        named = [level for level, name in enumerate(data.index.names) if name is not None and name not in data.columns]
        data = data.reset_index(level=named) if named else data
        return {str(name): data[name] for name in data.columns}
    if getattr(getattr(data, "dtype", None), "names", None):
        return {name: data[name] for name in data.dtype.names}
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
            except pyarrow.ArrowInvalid:
                # A single column.
                return None
            return dict(zip(arrow.column_names, arrow.columns, strict=True))
    if isinstance(data, Mapping) or (hasattr(data, "columns") and hasattr(data, "__getitem__")):
        return {str(name): data[name] for name in (data if isinstance(data, Mapping) else data.columns)}
    return None


def encoded(name: str, column: Any) -> Whole | npt.NDArray[np.float64] | Levels:
    """Return a column as whole numbers, as numbers, of which missing ones are NaN, or as texts."""
    if hasattr(column, "combine_chunks"):
        column = _of_arrow(column)
        if isinstance(column, Levels):
            return column
    dtype: Any = getattr(column, "dtype", None)
    if str(dtype).startswith("Enum(") and hasattr(column, "to_physical"):
        codes = column.to_physical().cast(int).fill_null(-1)
        return Levels(list(dtype.categories), np.asarray(codes, np.int64), True)
    if hasattr(dtype, "categories") and hasattr(dtype, "ordered"):
        codes = np.asarray(getattr(column, "cat", column).codes, np.int64)
        return Levels([_text(name, level) for level in dtype.categories], codes, bool(dtype.ordered))
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
        return numbers if masked is None else np.where(masked, np.nan, numbers)
    if array.dtype.kind == "M":
        times = np.char.add(np.datetime_as_string(array, "ms"), "Z").astype(object)
        times[np.isnat(array)] = None
        array = times
    codes, found = _factorized(array)
    if masked is not None:
        codes = np.where(masked, -1, codes)
    return Levels([_text(name, level) for level in found], codes)


def _of_arrow(column: Any) -> Any:
    """Return a column of Arrow as an array of numbers, or as texts."""
    import pyarrow

    kind = column.type
    if pyarrow.types.is_null(kind):
        return np.full(len(column), np.nan)
    if not pyarrow.types.is_dictionary(kind):
        if not (
            pyarrow.types.is_string(kind) or pyarrow.types.is_large_string(kind) or pyarrow.types.is_string_view(kind)
        ):
            return column.to_numpy()
        column = column.cast(pyarrow.large_string()).dictionary_encode()
    chunks = column.unify_dictionaries().chunks
    levels = [_text("column", level) for level in chunks[0].dictionary.to_pylist()] if chunks else []
    codes = [np.asarray(chunk.indices.cast(pyarrow.int64()).fill_null(-1)) for chunk in chunks]
    return Levels(levels, np.concatenate([np.empty(0, np.int64), *codes]), bool(column.type.ordered))


def _factorized(array: npt.NDArray[Any]) -> tuple[Whole, Any]:
    """Return the index of each value among the different ones, −1 for a missing one, and these."""
    try:
        import pandas
    except ImportError:
        index: dict[Any, int] = {}
        cells = array.tolist()
        codes = [-1 if cell is None or cell != cell else index.setdefault(cell, len(index)) for cell in cells]
        return np.array(codes, np.int64), list(index)
    codes, found = pandas.factorize(array.astype(object))
    return codes.astype(np.int64), found


def _text(name: str, level: object) -> str:
    is_number = isinstance(level, (int, float, np.number)) and not isinstance(level, bool)
    return text(name, level) if is_number else str(level)
