"""What several modules share: names with suggestions, options of commands, tables, and progress."""

from __future__ import annotations

import difflib
import functools
import inspect
import operator
import os
import re
import struct
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib.util import find_spec
from typing import Any, Literal, TypeVar, Union

import numpy as np
import numpy.typing as npt

from . import _machband
from ._machband import Error

F = TypeVar("F", bound=Callable[..., Any])
T = TypeVar("T")

#: A table: a `pandas.DataFrame` if pandas is installed, and otherwise a dict of arrays.
Table = Any

#: Values in an order.
Listed = Union[Sequence[Any], npt.NDArray[Any]]

#: Texts or numbers, or one line of CSV with them.
Texts = Union[str, Sequence[Union[str, float]], npt.NDArray[Any]]

#: A seed, from 0 to 2^64 − 1, or a generator that draws one.
Seed = Union[int, np.random.Generator, np.random.SeedSequence]

#: How a value between two codes is assigned to one of them.
Dither = Literal[
    "none",
    "random",
    "blue-noise",
    "ordered",
    "ordered:bayer2",
    "ordered:bayer4",
    "ordered:bayer8",
    "ordered:bayer16",
    "ordered:clustered2",
    "ordered:clustered3",
]

Fields = dict[str, "str | bool | list[str]"]


def nearest(word: str, among: Iterable[str], cutoff: float = 0.6) -> str:
    """Return a question about the name that is nearest to a word, if one is near."""
    near = difflib.get_close_matches(word, [*among], 1, cutoff)
    return f"; did you mean {near[0]!r}?" if near else ""


#: The names of the parameters of all kinds of stimulus.
_STIMULUS_PARAMETERS = {parameter[0] for kind, _ in _machband.kinds() for parameter in _machband.parameters(kind, [])}


def suggests(of: F) -> F:
    """Make a function, or the public methods of a class, name what is nearest to an unknown keyword.

    The parameters of the stimulus in ``**parameters`` are known too; the library itself names the nearest of them. Options
    of the command in an error of the library become the arguments that they are here.
    """
    if isinstance(of, type):
        for name, member in [*vars(of).items()]:
            if inspect.isfunction(member) and (name == "__init__" or name[0] != "_"):
                setattr(of, name, suggests(member))
            elif isinstance(member, classmethod):
                setattr(of, name, classmethod(suggests(member.__func__)))
        return of
    signature = inspect.signature(of).parameters
    known = [name for name, one in signature.items() if name not in ("self", "cls") and one.kind is not one.VAR_KEYWORD]
    is_open = any(one.kind is one.VAR_KEYWORD for one in signature.values())
    called = of.__qualname__.removesuffix(".__init__").split(".")[-1]

    @functools.wraps(of)
    def checked(*args: Any, **kwargs: Any) -> Any:
        for name in kwargs.keys() - known - (_STIMULUS_PARAMETERS if is_open else set()):
            near = nearest(name, among=known)
            if not is_open or (near and near == nearest(name, among={*known, *_STIMULUS_PARAMETERS})):
                expected = f"expected one of {', '.join(known)}{near}"
                raise TypeError(f"{called}() got an unexpected keyword argument {name!r}; {expected}")
        try:
            return of(*args, **kwargs)
        except Error as error:
            error.args = (in_python(str(error), known),)
            raise

    return checked  # type: ignore[return-value]


def in_python(message: str, known: Iterable[str]) -> str:
    """Return a message of the library with arguments in place of options, and the nearest of the values it expects."""
    argument = {name.removesuffix("_deg").replace("_", "-"): name for name in known}
    message = message.replace(", --levels", "").replace("the options of", "the arguments of")
    message = re.sub(r" <[^>]*>|^(\w+) \S+: (?=\1 )", "", message.replace("<FILE|DIR>...", "data"))
    message = re.sub(r"the option (ppd|transfer)\b", r"\1", message)
    message = re.sub(r"--([a-z-]+)", lambda found: argument.get(found[1], found[0]), message)
    message = re.sub(r", or the option (\w+)$", r", or \1=True", message)
    renamed = {"vertices": "n_vertices", "screen width": "screen_cm", "distance": "distance_cm"}
    if (found := re.match(r"([a-z ]+?)(:| [-\d]| NaN| inf)", message)) and (name := renamed.get(found[1])) in argument.values():
        message = f"{name}{message[found.end(1) :]}"
    message = re.sub(r", such as (missing|categories) '?([^']+)'?$", r", such as \1='\2'", message)
    if (found := re.search('"([^"]*)" is not known; expected (.*)$', message)) and "did you mean" not in message:
        message += nearest(found[1].lower(), among=re.findall(r"[\w:-]+", found[2]), cutoff=0.65)
    return message


def whole(name: str, given: Any, least: float = -np.inf, most: float = np.inf) -> int:
    """Return a whole number within a range; the library knows that of its fields."""
    try:
        if isinstance(given, (bool, np.bool_)):
            raise TypeError
        number = int(given) if isinstance(given, float) and given.is_integer() else operator.index(given)
    except TypeError:
        raise TypeError(f"{name} is {given!r}; expected a whole number") from None
    if not least <= number <= most:
        raise Error(f"{name} {number} is outside {least}…{most}; expected a whole number in this range")
    return number


def seed_of(name: str, given: object) -> int:
    """Return a seed, from 0 to 2^64 − 1: a number, or one that a generator of NumPy draws."""
    if isinstance(given, np.random.Generator):
        return int(given.integers(2**64, dtype=np.uint64))
    if isinstance(given, np.random.SeedSequence):
        return int(given.generate_state(1, np.uint64)[0])
    return whole(name, given, 0, 2**64 - 1)


def typed(name: str, given: Any, of: type | tuple[type, ...], expected: str) -> Any:
    """Return a value of one of these types."""
    if isinstance(given, of):
        return given
    raise TypeError(f"{name} is {given!r}; expected {expected}")


def words(name: str, given: object) -> str:
    """Return text."""
    return str(typed(name, given, str, "text"))


def plain(given: Any) -> Any:
    """Return the value of an array without dimensions, and anything else as it is."""
    return given[()] if isinstance(given, np.ndarray) and given.ndim == 0 else given


def flag(name: str, given: object) -> bool:
    """Return a truth value."""
    return bool(typed(name, given, (bool, np.bool_), "True or False"))


def path(name: str, given: object) -> str:
    """Return a path."""
    return str(os.fspath(typed(name, given, (str, os.PathLike), "a path")))


def text(name: str, given: Any) -> str:
    """Return a value as the text that commands and files use: text, a number, or numbers such as ``1,0.5,0``."""
    given = plain(given)
    if isinstance(given, str):
        return str(given)
    if isinstance(given, (list, tuple, np.ndarray)) and np.ndim(given) == 1 and len(given) != 1:
        return ",".join(text(name, part) for part in given)
    try:
        if np.ndim(given) > 0 or isinstance(given, (bytes, bytearray, bool, np.bool_)):
            raise TypeError
        if isinstance(given, (int, np.integer)):
            # A seed may have more digits than a float.
            return str(int(given))
        # A number of NumPy is the one that it is written as: 0.2 in 32 bits is not 0.2 in 64.
        number = float(str(given) if isinstance(given, np.floating) else given)
    except (TypeError, ValueError):
        raise TypeError(f"{name} is {given!r}; expected a number or text") from None
    return str(int(number)) if number.is_integer() else repr(number)


def number(name: str, given: object) -> float:
    """Return a number."""
    given = plain(given)
    if isinstance(given, (int, float, np.integer, np.floating)) and not isinstance(given, bool):
        return float(text(name, given))
    raise TypeError(f"{name} is {given!r}; expected a number")


def numbers(name: str, given: Any) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Return an array of numbers."""
    given = unmasked(name, given)
    try:
        array = np.asarray(given)
        if array.dtype.kind not in "iufO" or (array.dtype.kind == "O" and None in array.ravel().tolist()):
            raise TypeError
        return array.astype(np.float64, copy=False)
    except (TypeError, ValueError):
        raise TypeError(f"{name} is {given!r}; expected numbers") from None


def unmasked(name: str, given: T) -> T:
    """Return an array that has no mask."""
    if isinstance(given, np.ma.MaskedArray):
        raise TypeError(f"{name} is a masked array; expected an array without a mask")
    return given


def texts(name: str, given: Any) -> str:
    """Return a list of names as one line of CSV, in which a missing one is ``NA``; text is such a line already."""
    if isinstance(given, str):
        return given
    try:
        cells = ["NA" if one is None or one != one else text(name, one) for one in given]
        if isinstance(given, (bytes, set, frozenset, Mapping)) or (name == "categories" and "NA" in cells):
            raise TypeError
        # Terms have quotes of their own, such as those of the name "near:far".
        return ",".join(one if name == "terms" and '"' in one else _quoted(one) for one in cells)
    except TypeError:
        raise TypeError(f"{name} is {given!r}; expected a list of texts") from None


def _quoted(text: str) -> str:
    """Return a cell of CSV."""
    is_plain = text and text == text.strip() and not set(text) & {",", '"', "\n"}
    return text if is_plain else '"' + text.replace('"', '""') + '"'


def encoding(given: Any) -> Fields:
    """Return the fields of a request that say how codes become light: a `Transfer`, or the text of one."""
    display: str | None = getattr(given, "display", None)
    function = given if isinstance(given, type) else getattr(given, "function", given)
    return {"display": display} if display else {"transfer": words("transfer", function)}


#: What makes a field of an argument with this type in the signature; any other becomes text.
_CONVERSIONS: dict[str, Callable[[str, Any], str | bool | int | list[str]]] = {
    "bool": flag,
    "int": whole,
    "Literal[8, 16]": whole,
    "float": lambda name, given: text(name, number(name, given)),
    "Seed": seed_of,
    "str": words,
    "str | PathLike[str]": path,
    "Texts": texts,
    "float | Texts": lambda name, given: texts(name, [given] if isinstance(plain(given), (int, float, np.number)) else given),
}


def options(function: Callable[..., Any], given: Mapping[str, Any], *but: str) -> Fields:
    """Return the fields of the request that a function makes from its keyword-only arguments except `but`.

    Arguments that are not given, or are `None`, have defaults.
    """
    fields: Fields = {}
    for name, parameter in inspect.signature(function).parameters.items():
        one = given.get(name, parameter.default)
        if parameter.kind is not parameter.KEYWORD_ONLY or name in but:
            continue
        # Annotations are texts.
        kind = parameter.annotation.removesuffix(" | None")
        if one is None:
            if kind == parameter.annotation:
                raise TypeError(f"{name} is None; expected a value, such as {parameter.default!r}")
        elif kind == "str | Transfer":
            fields |= encoding(one)
            if "display" in fields and given.get("display") is not None:
                raise Error("transfer and display are both a display profile; expected one of them")
        else:
            convert: Callable[[str, Any], Any] = _CONVERSIONS.get(kind, text)
            field = convert(name, one)
            fields[name] = str(field) if type(field) is int else field
    return fields


def table(columns: Mapping[str, np.ndarray[Any, Any]], described: Iterable[tuple[str, str, str]] = ()) -> Table:
    """Return columns as a table. What is known about them goes into `DataFrame.attrs`."""
    if find_spec("pandas") is None:
        return dict(columns)
    import pandas

    frame = pandas.DataFrame(dict(columns), copy=False)
    for name, column in columns.items():
        if column.dtype.kind == "M":
            frame[name] = frame[name].dt.tz_localize("UTC")
    frame.attrs["units"] = {name: unit for name, unit, _ in described if unit}
    frame.attrs["descriptions"] = {name: description for name, _, description in described if description}
    return frame


def named(names: list[str], values: np.ndarray[Any, Any], columns: list[str] | None = None) -> Any:
    """Return named rows: a `pandas.Series`, or a `DataFrame` if rows have columns; without pandas, a dict."""
    if find_spec("pandas") is None:
        return dict(zip(names, values.tolist(), strict=True))
    import pandas

    return pandas.Series(values, names) if values.ndim == 1 else pandas.DataFrame(values, names, columns)


def png(codes: np.ndarray[Any, Any]) -> bytes:
    """Return an image of codes as a PNG file."""
    height, width = codes.shape[:2]
    rows = np.ascontiguousarray(codes, codes.dtype.newbyteorder(">")).view(np.uint8).reshape(height, -1)
    head = struct.pack(">IIBBBBB", width, height, 8 * codes.dtype.itemsize, 2, 0, 0, 0)
    chunks = [(b"IHDR", head), (b"IDAT", zlib.compress(np.insert(rows, 0, 0, axis=1).tobytes())), (b"IEND", b"")]
    parts = [struct.pack(">I", len(of)) + kind + of + struct.pack(">I", zlib.crc32(kind + of)) for kind, of in chunks]
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)


def axes(ax: Any) -> Any:
    """Return axes of matplotlib, by default new ones."""
    from matplotlib import pyplot

    if ax is not None and not hasattr(ax, "set_axis_off"):
        raise TypeError(f"ax is {ax!r}; expected axes of matplotlib")
    return pyplot.subplots()[1] if ax is None else ax


@contextmanager
def progress(unit: str) -> Iterator[Callable[[int, int], None] | None]:
    """Provide a function that shows the work done and the total in a bar, if tqdm is installed."""
    if find_spec("tqdm") is None:
        yield None
        return
    from tqdm import tqdm

    with tqdm(unit=f" {unit}", leave=False, delay=0.1) as bar:

        def show(done: int, total: int) -> None:
            bar.total = total
            bar.update(done - bar.n)

        yield show
