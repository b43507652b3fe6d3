"""What several modules share: names with suggestions, options of commands, tables, and progress."""

from __future__ import annotations

import difflib
import functools
import inspect
import io
import operator
import os
import re
import struct
import warnings
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, Literal, TypeVar, Union

import numpy as np
import numpy.typing as npt

from . import _machband
from ._machband import Error

F = TypeVar("F", bound=Callable[..., Any])
T = TypeVar("T")

#: A table: a `pandas.DataFrame` if pandas is installed, and otherwise a dict of arrays.
Table = Any


def nearest(*words: str, among: Iterable[str], cutoff: float = 0.6) -> str:
    """Return a question about the name that is nearest to a word, if one is near."""
    near = [one for word in words for one in difflib.get_close_matches(word, [*among], 1, cutoff)]
    return f"; did you mean {near[0]!r}?" if near else ""


def suggests(of: F) -> F:
    """Make a function, or the public methods of a class, name what is nearest to an unknown keyword or value.

    The parameters of the stimulus in ``**parameters`` are known too; the library itself names the nearest of them. Options
    of the command in an error of the library become the arguments that they are here.
    """
    if isinstance(of, type):
        for name, member in [*vars(of).items()]:
            if inspect.isfunction(member) and (name == "__init__" or name[0] != "_"):
                setattr(of, name, suggests(member))
            elif isinstance(member, classmethod) and name[0] != "_":
                setattr(of, name, classmethod(suggests(member.__func__)))
        return of
    signature = inspect.signature(of).parameters
    known = [name for name, one in signature.items() if name not in ("self", "cls") and one.kind is not one.VAR_KEYWORD]
    called = of.__qualname__.removesuffix(".__init__").split(".")[-1]
    is_open = any(one.kind is one.VAR_KEYWORD for one in signature.values())

    def refused(name: str) -> TypeError:
        message = f"{called}() got an unexpected keyword argument {name!r}; expected one of {', '.join(known)}"
        return TypeError(message + nearest(name, among=known))

    @functools.wraps(of)
    def checked(*args: Any, **kwargs: Any) -> Any:
        further = [name for name in kwargs if name not in known]
        if further and not is_open:
            raise refused(further[0])
        try:
            return of(*args, **kwargs)
        except Error as error:
            for name in further:
                if (near := nearest(name, among=known)) and near == nearest(
                    name, among={*known, *_STIMULUS_PARAMETERS}
                ):
                    raise refused(name) from None
            error.args = (in_python(str(error), known),)
            raise

    return checked  # type: ignore[return-value]


def in_python(message: str, known: Iterable[str]) -> str:
    """Return a message of the library with arguments in place of options, and the nearest of the values it expects."""
    argument = {name.replace("_", "-"): name for name in known}
    # The order of levels is an argument of `factors`.
    message = message.replace(", --levels", "").replace("the options of", "the arguments of")
    message = re.sub(r"--([a-z-]+)", lambda found: argument.get(found[1], found[0]), message)
    message = re.sub(r", or the option (\w+)$", r", or \1=True", message)
    if (found := re.search(", such as ([a-z_]+) (\\S+)$", message)) and found[1] in argument.values():
        is_number = re.fullmatch(r"-?[\d.]+", found[2])
        message = f"{message[: found.start()]}, such as {found[1]}={found[2] if is_number else repr(found[2].strip(chr(39)))}"
    if (found := re.search('"([^"]*)" is not known; expected (.*)$', message)) and "did you mean" not in message:
        message += nearest(found[1].lower(), among=re.findall(r"[\w:-]+", found[2]), cutoff=0.65)
    return message


#: The names of the parameters of all kinds of stimulus.
_STIMULUS_PARAMETERS = {parameter[0] for kind, _ in _machband.kinds() for parameter in _machband.parameters(kind, [])}


def whole(name: str, given: object, least: int = 0, most: int = 2**64 - 1) -> int:
    """Return a whole number within a range."""
    try:
        if isinstance(given, (bool, np.bool_)):
            raise TypeError
        number = int(given) if isinstance(given, float) and given.is_integer() else operator.index(given)  # type: ignore[arg-type]
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
    return whole(name, given)


def words(name: str, given: object) -> str | None:
    """Return text, or `None`."""
    if given is None or isinstance(given, str):
        return given
    raise TypeError(f"{name} is {given!r}; expected text")


def name_of(argument: str, given: object) -> str:
    """Return a name, which may be a whole number."""
    if isinstance(given, (int, np.integer)) and not isinstance(given, bool):
        return str(given)
    if isinstance(given, str):
        return given
    raise TypeError(f"{argument} is {given!r}; expected text")


def flag(name: str, given: object) -> bool:
    """Return a truth value."""
    if isinstance(given, (bool, np.bool_)):
        return bool(given)
    raise TypeError(f"{name} is {given!r}; expected True or False")


def value(name: str, given: object) -> float | str:
    """Return a parameter in the form that files use: a number, or text such as ``1,0.5,0``."""
    if isinstance(given, (str, bool)):
        return str(given)
    if isinstance(given, (list, tuple, np.ndarray)) and np.ndim(given) == 1 and len(given) != 1:
        return ",".join(text(name, part) for part in given)
    try:
        if np.ndim(given) > 0 or isinstance(given, (bytes, bytearray)):  # type: ignore[arg-type]
            raise TypeError
        # A number of NumPy is the one that it is written as: 0.2 in 32 bits is not 0.2 in 64.
        return float(str(given) if isinstance(given, np.floating) else given)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        raise TypeError(f"{name} is {given!r}; expected a number or text") from None


def number(name: str, given: object) -> float:
    """Return a number."""
    if isinstance(given, np.ndarray) and given.ndim == 0:
        given = given[()]
    if isinstance(given, (int, float, np.number)) and not isinstance(given, bool):
        return float(given)
    raise TypeError(f"{name} is {given!r}; expected a number")


def numbers(name: str, given: Any) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Return an array of numbers."""
    given = unmasked(name, given)
    try:
        array = np.asarray(given)
        if array.dtype.kind in "USc":
            raise TypeError
        return array.astype(np.float64, copy=False)
    except (TypeError, ValueError):
        raise TypeError(f"{name} is {given!r}; expected numbers") from None


def unmasked(name: str, given: T) -> T:
    """Return an array that has no mask."""
    if isinstance(given, np.ma.MaskedArray):
        raise TypeError(f"{name} is a masked array; expected an array without a mask")
    return given


def text(name: str, given: object) -> str:
    """Return a value as the text that commands and files use."""
    if isinstance(given, (int, np.integer)) and not isinstance(given, bool):
        # A seed may have more digits than a float.
        return str(int(given))
    number = value(name, given)
    if isinstance(number, float):
        return str(int(number)) if number.is_integer() else repr(number)
    return number


def texts(name: str, given: object) -> str:
    """Return a list of names as one line of CSV; text is such a line already."""
    if isinstance(given, str):
        return given
    try:
        cells = [_cell(name, one) for one in given]  # type: ignore[attr-defined]
        # Terms have quotes of their own, such as those of the name "near:far".
        return ",".join(one if name == "terms" and '"' in one else _quoted(one) for one in cells)
    except TypeError:
        raise TypeError(f"{name} is {given!r}; expected a list of texts") from None


def _quoted(text: str) -> str:
    """Return a cell of CSV."""
    is_plain = text and text == text.strip() and not set(text) & {",", '"', "\n"}
    return text if is_plain else '"' + text.replace('"', '""') + '"'


def _cell(name: str, given: object) -> str:
    """Return the text of a level; what is missing is ``NA``."""
    return "NA" if given is None or given != given else text(name, given)


def levels(name: str, given: object) -> list[str]:
    """Return factors with the levels to keep."""
    if isinstance(given, Mapping):
        return [f"{factor}={texts(name, kept)}" for factor, kept in given.items()]
    raise TypeError(f"{name} is {given!r}; expected a dict of factors with lists of levels")


def path(name: str, given: object) -> str:
    """Return a path."""
    if isinstance(given, (str, os.PathLike)):
        return os.fspath(given)
    raise TypeError(f"{name} is {given!r}; expected a path")


Fields = dict[str, "str | bool | list[str]"]

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


def encoding(given: Any) -> Fields:
    """Return the fields of a request that say how codes become light: a `Transfer`, or the text of one."""
    display: str | None = getattr(given, "display", None)
    if display is not None:
        return {"display": display}
    function = words("transfer", getattr(given, "function", given))
    return {} if function is None else {"transfer": function}


#: What makes a field of an argument with this type in the signature; any other becomes text.
_CONVERSIONS: dict[str, Callable[[str, Any], str | bool | int | list[str] | None]] = {
    "bool": flag,
    "int": whole,
    "float": lambda name, given: text(name, number(name, given)),
    "Seed": seed_of,
    "str": words,
    "Dither": words,
    "Shader": words,
    "str | PathLike[str]": path,
    "Texts": texts,
    "float | Texts": texts,
    "Mapping[str, Listed]": levels,
}


def options(function: Callable[..., Any], given: Mapping[str, Any], *but: str) -> Fields:
    """Return the fields of the request that a function makes from its keyword-only arguments except `but`.

    Arguments that are `None` have defaults.
    """
    fields: Fields = {}
    for name, parameter in inspect.signature(function).parameters.items():
        if parameter.kind is parameter.KEYWORD_ONLY and name not in but:
            if given[name] is None:
                if not parameter.annotation.endswith("None"):
                    raise TypeError(f"{name} is None; expected a value, such as {parameter.default!r}")
                continue
            kind = parameter.annotation.removesuffix(" | None")
            if kind == "str | Transfer":
                if "display" in (coding := encoding(given[name])) and given.get("display") is not None:
                    raise Error("transfer and display are both a display profile; expected one of them")
                fields.update(coding)
                continue
            # Annotations are texts; those of choices have either words or numbers.
            convert = (
                whole
                if re.match(r"Literal\[\d", kind)
                else words
                if "Literal[" in kind
                else _CONVERSIONS.get(kind, text)
            )
            field = convert(name, given[name])
            fields[name] = str(field) if isinstance(field, int) and not isinstance(field, bool) else field  # type: ignore[assignment]
    return fields


def table(columns: Mapping[str, np.ndarray[Any, Any]], described: list[tuple[str, str, str]] | None = None) -> Table:
    """Return columns as a table. What is known about them goes into `DataFrame.attrs`."""
    try:
        import pandas
    except ImportError:
        return dict(columns)
    frame = pandas.DataFrame(dict(columns), copy=False)
    for name, column in columns.items():
        if column.dtype.kind == "M":
            frame[name] = frame[name].dt.tz_localize("UTC")
    if described is not None:
        frame.attrs["units"] = {name: unit for name, unit, _ in described if unit}
        frame.attrs["descriptions"] = {name: description for name, _, description in described if description}
    return frame


def named(names: list[str], values: np.ndarray[Any, Any], columns: list[str] | None = None) -> Any:
    """Return named rows: a `pandas.Series`, or a `DataFrame` if rows have columns; without pandas, a dict."""
    try:
        import pandas
    except ImportError:
        return dict(zip(names, values.tolist(), strict=True))
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

    if ax is not None and not hasattr(ax, "imshow"):
        raise TypeError(f"ax is {ax!r}; expected axes of matplotlib")
    return pyplot.subplots()[1] if ax is None else ax


def plotted(png: bytes, ax: Any) -> Any:
    """Draw an image on axes of matplotlib, by default new ones, and return them."""
    from matplotlib import image

    ax = axes(ax)
    ax.imshow(image.imread(io.BytesIO(png), format="png"))
    ax.set_axis_off()
    return ax


@contextmanager
def progress(unit: str) -> Iterator[Callable[[int, int], None] | None]:
    """Provide a function that shows the work done and the total in a bar, if tqdm is installed."""
    try:
        with warnings.catch_warnings():
            # A notebook without widgets shows the bar as text.
            warnings.simplefilter("ignore")
            from tqdm.auto import tqdm
    except ImportError:
        tqdm = None
    bar: Any = None

    def show(done: int, total: int) -> None:
        nonlocal bar
        if bar is None:
            bar = tqdm(total=total, unit=f" {unit}", leave=False)
        bar.total = total
        bar.update(done - bar.n)

    try:
        yield show if tqdm else None
    finally:
        if bar is not None:
            bar.close()
