"""Stimuli as arrays, and the functions behind them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from os import PathLike
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeVar, Union

import numpy as np
import numpy.typing as npt

from . import _machband
from ._common import Dither, Seed, Table, axes, encoding, flag, number, numbers, options, path, png, suggests, table
from ._common import text, whole, words

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._vision import Prediction
    from .stimuli import Parameters

Codes = npt.NDArray[np.uint8] | npt.NDArray[np.uint16]
Floats = npt.NDArray[np.float64]


Kind = Literal["mach-band", "chevreul", "cornsweet", "vasarely", "kanizsa", "shaded-mesh", "shaded-cylinder"]


class Parameter(NamedTuple):
    """A parameter of a kind of stimulus.

    `default` is its value if it is not given; `unit` is ``1`` for a plain number, and empty if it is not a number;
    `expected` says which values it can have, and `choices` has all of them if they are a few names.
    """

    name: str
    default: float | str
    unit: str
    description: str
    expected: str
    choices: list[str]


class VisualAngle(NamedTuple):
    """Lengths on a screen in three units, and the pixels per degree at its center.

    `deg` is the visual angle in degrees, centered on the line of sight; `cm` are centimeters on the screen; `px` are
    physical pixels.
    """

    deg: float | Floats
    cm: float | Floats
    px: float | Floats
    ppd: float


def _named(kind: object, parameters: Mapping[str, Any]) -> tuple[str, list[tuple[str, str]]]:
    """Return the name of a kind, and parameters as text."""
    return words("kind", kind), [(name, text(name, parameter)) for name, parameter in parameters.items()]


def kinds() -> dict[Kind, str]:
    """Return the kinds of stimulus, with what each shows and who first described it.

    >>> list(kinds())[:2]
    ['mach-band', 'chevreul']
    """
    return dict(_machband.kinds())


@suggests
def parameters(kind: Kind = "mach-band") -> dict[str, Parameter]:
    """Return the parameters of a kind of stimulus, with their defaults, units, meanings and ranges.

    >>> parameters("mach-band")["width"].default
    0.4
    """
    return {found[0]: Parameter(*found) for found in _machband.parameters(words("kind", kind), [])}


@suggests
@dataclass(frozen=True)
class Transfer:
    """How a display turns encoded values into light. The argument `transfer` of any function takes one.

    Attributes
    ----------
    function
        ``srgb`` (IEC 61966-2-1), ``linear``, ``gamma:G`` or ``gog:GAMMA,GAIN,OFFSET``; for separate functions for red,
        green and blue, join three with ``/``.
    display
        In place of a function: a display profile written by ``machband calibrate``.

    Examples
    --------
    >>> round(Transfer.gamma(2.2).encode(0.5), 4)
    0.7297
    """

    function: str | None = "srgb"
    display: str | None = None

    def __post_init__(self) -> None:
        """Check the function, or read the profile."""
        if self.display is not None and self.function not in (None, "srgb"):
            raise _machband.Error(f"function is {self.function!r}, and display {self.display!r}; expected one of them")
        _machband.encode(np.zeros(3), encoding(self), False)

    @classmethod
    def srgb(cls) -> Transfer:
        """Return the function of sRGB."""
        return cls()

    @classmethod
    def gamma(cls, gamma: float) -> Transfer:
        """Return a power function: light is encoded ** `gamma`."""
        return cls(f"gamma:{text('gamma', number('gamma', gamma))}")

    @classmethod
    def gog(cls, gamma: float, gain: float, offset: float) -> Transfer:
        """Return the gain-offset-gamma model of a display."""
        given = {"gamma": gamma, "gain": gain, "offset": offset}
        return cls("gog:" + ",".join(text(name, number(name, one)) for name, one in given.items()))

    @classmethod
    def from_display(cls, profile: str | PathLike[str]) -> Transfer:
        """Return the functions in a display profile."""
        return cls(None, path("profile", profile))

    def encode(self, light: npt.ArrayLike) -> float | Floats:
        """Encode linear light, 0 to 1, relative to the maximum; any shape, (…, 3) if the channels differ."""
        return self._apply("light", light, False)

    def decode(self, encoded: npt.ArrayLike) -> float | Floats:
        """Return the light of encoded values from 0 to 1, such as ``codes / 255``."""
        return self._apply("encoded", encoded, True)

    def _apply(self, name: str, values: npt.ArrayLike, inverse: bool) -> float | Floats:
        given = numbers(name, values)
        if not ((given >= 0) & (given <= 1)).all():
            raise _machband.Error(f"{name} goes from {given.min()} to {given.max()}; expected 0 to 1")
        return _scalar(_machband.encode(given, encoding(self), inverse))


#: How a display turns codes into light; `None` for sRGB.
Encoding = Union[str, Transfer, None]


@suggests
def stimulus(
    kind: Kind = "mach-band",
    *,
    size: int = 1024,
    transfer: str | Transfer | None = None,
    display: str | PathLike[str] | None = None,
    bits: Literal[8, 16] = 8,
    dither: Dither = "none",
    seed: Seed = 1,
    **parameters: Unpack[Parameters],
) -> Codes:
    """Return a stimulus as codes, the same as in the image that ``machband stimulus`` writes.

    By default, it is the one of the built-in experiments: a yellow ramp on an sRGB display. `machband.stimuli` has a
    function for each kind, whose result also knows its light and its visual size; this one is for loops over kinds.

    Parameters
    ----------
    kind
        One of `kinds`.
    size
        Side of the image in pixels.
    transfer
        Transfer function of the display: srgb, linear, gamma:G or gog:GAMMA,GAIN,OFFSET; for separate functions for
        red, green and blue, join three with /.
    display
        Display profile written by `machband calibrate`.
    bits
        Bits per channel.
    dither
        Dither: none, ordered, blue-noise or random; for a specific matrix, ordered:bayer2, 4, 8 or 16, or
        ordered:clustered2 or 3.
    seed
        Seed of the random dither.
    **parameters
        The parameters of the kind, such as ``width``, ``depth``, ``orientation_deg``, ``low``, ``high`` and ``color``;
        see `parameters`. A color is a name such as ``gray`` or ``yellow``, weights of red, green and blue in linear light
        such as ``(1, 1, 0)``, a color of sRGB such as ``"#ffff00"``, or text such as ``hsv:60,1,1`` or
        ``xyY:0.3,0.3,0.5``.

    Returns
    -------
    Codes of shape (size, size, 3), uint8 or uint16.

    Notes
    -----
    The ramp of a Mach band stimulus is I_n of Bangay's *Methods of Reducing the Visibility of Mach Bands during Gouraud
    Shading*, eq. 1.

    Examples
    --------
    >>> stimulus(size=4, color="gray")[0, :, 0].tolist()
    [137, 158, 212, 225]
    """
    return _machband.stimulus(*_named(kind, parameters), options(stimulus, locals()))


@suggests
class Stimulus:
    """A stimulus: its light, its size, and what reproduces it. `machband.stimuli` makes one for each kind.

    NumPy takes it as its light; a notebook shows it.

    Attributes
    ----------
    kind
        One of `kinds`.
    parameters
        All arguments that make it again: ``Stimulus(kind, **parameters)``.
    shape
        Height and width in pixels.
    ppd, visual_size
        Pixels per degree, and degrees of visual angle, each vertical and horizontal.
    """

    def __init__(
        self,
        kind: Kind = "mach-band",
        *,
        size: int | tuple[int, int] | None = None,
        ppd: float | None = None,
        visual_size: float | tuple[float, float] | None = None,
        **parameters: Unpack[Parameters],
    ) -> None:
        """Describe a stimulus.

        Parameters
        ----------
        kind
            One of `kinds`.
        size
            Side in pixels, or height and width [default: `ppd` times `visual_size`, or 1024]. Proportions are those of
            the longer side; a shorter one shows the middle of the square.
        ppd
            Pixels per degree of visual angle.
        visual_size
            Degrees of visual angle of the longer side, or height and width [default: `size` / `ppd`, or 10].
        **parameters
            The parameters of the kind, as in `stimulus`.
        """
        shape = None if size is None else _pair("size", size, _side)
        degrees = None if visual_size is None else _pair("visual_size", visual_size, _positive)
        density = None if ppd is None else _positive("ppd", ppd)
        if degrees and density:
            pixels = (degrees[0] * density, degrees[1] * density)
            wanted = (round(pixels[0]), round(pixels[1]))
            if np.abs(np.subtract(pixels, wanted)).max() > 1e-6 or shape not in (None, wanted):
                expected = "expected whole pixels, and no size or the same"
                raise _machband.Error(f"ppd times visual_size is {_one_or_both(pixels)}, size {size}; {expected}")
            shape = _pair("ppd times visual_size", wanted, _side)
        shape = shape or (1024, 1024)
        longest = max(shape)
        if degrees is None or isinstance(visual_size, (int, float, np.number)):
            longest_deg = degrees[0] if degrees else longest / density if density else 10.0
            degrees = (longest_deg * shape[0] / longest, longest_deg * shape[1] / longest)
        ppds = (shape[0] / degrees[0], shape[1] / degrees[1])
        if abs(ppds[0] - ppds[1]) > 1e-6 * ppds[0]:
            raise _machband.Error(f"visual_size is {visual_size} for {shape[0]} × {shape[1]} pixels; expected square ones")
        # As the library has them, so that two are equal if they mean the same.
        own: dict[str, Any] = {name: found for name, found, *_ in _machband.parameters(*_named(kind, parameters))}
        self.kind: Kind = kind
        self._own = own
        self.shape, self.visual_size, self.ppd = shape, degrees, ppds
        self._size = longest
        self._middle = tuple(slice((longest - side) // 2, (longest + side) // 2) for side in shape)
        sizes = {"size": _one_or_both(shape), "visual_size": _one_or_both(degrees)}
        self.parameters: Mapping[str, Any] = MappingProxyType({**own, **sizes})

    @cached_property
    def light(self) -> npt.NDArray[np.float32]:
        """Light of red, green and blue relative to the screen's maximum, 0 to 1; shape (height, width, 3), read-only."""
        shown = light(self.kind, size=self._size, **self._own)[self._middle]
        shown.flags.writeable = False
        return shown

    def codes(
        self, *, transfer: Encoding = None, bits: Literal[8, 16] = 8, dither: Dither = "none", seed: Seed = 1
    ) -> Codes:
        """Return the codes for a display, as `stimulus` does with these arguments; shape (height, width, 3)."""
        image = options(stimulus, {**locals(), "size": self._size})
        return _machband.stimulus(*_named(self.kind, self._own), image)[self._middle]

    def profile(
        self, *, transfer: Encoding = None, bits: Literal[8, 16] = 8, dither: Dither = "none", seed: Seed = 1
    ) -> Table:
        """Return the luminance profile through the center, as the function `profile` does with these arguments."""
        image = options(profile, {**locals(), "size": self._size})
        return table(*_machband.profile(*_named(self.kind, self._own), image))

    def _square(self) -> int:
        """Return the side of a square."""
        if self.shape != (self._size, self._size):
            raise _machband.Error(f"the shape is {self.shape}; expected a square, as the command draws")
        return self._size

    def predict(
        self,
        *,
        display: str | PathLike[str] | None = None,
        white: float | None = None,
        black: float | None = None,
        criterion: str | PathLike[str] | None = None,
    ) -> Prediction:
        """Predict how visible its bands are at its visual size, as the function `predict` does."""
        from ._vision import predict

        viewing: Any = {"display": display, "white": white, "black": black, "criterion": criterion}
        return predict(self.kind, size=self._square(), window_deg=self.visual_size[0], **viewing, **self._own)

    def to_stimupy(self) -> dict[str, Any]:
        """Return a dict with the keys of stimupy: ``img`` has the light of the strongest channel, 0 to 1."""
        fields = {"img": self.light.max(axis=2).astype(np.float64), "shape": self.shape, "kind": self.kind}
        return {**self._own, **fields, "visual_size": self.visual_size, "ppd": self.ppd}

    def save(
        self,
        file: str | PathLike[str],
        *,
        force: bool = False,
        transfer: Encoding = None,
        bits: Literal[8, 16] = 8,
        dither: Dither = "none",
        seed: Seed = 1,
    ) -> None:
        """Write the image that ``machband stimulus --out`` writes, a PNG with its recipe; with `force`, replace a file."""
        image = options(stimulus, {**locals(), "size": self._square()})
        _machband.save_stimulus(*_named(self.kind, self._own), image, path("file", file), flag("force", force))

    def plot(self, ax: Any = None) -> Any:
        """Draw it on axes of matplotlib, by default new ones, in degrees of visual angle; return them."""
        ax = axes(ax)
        high, wide = (degrees / 2 for degrees in self.visual_size)
        ax.imshow(self.codes(), extent=(-wide, wide, -high, high), interpolation="nearest")
        ax.set(xlabel="degrees", ylabel="degrees")
        return ax

    def __array__(self, dtype: npt.DTypeLike | None = None, copy: bool | None = None) -> npt.NDArray[Any]:
        """Return the light."""
        return np.asarray(self.light, dtype) if copy is None else np.array(self.light, dtype, copy=copy)

    def __setattr__(self, name: str, value: object) -> None:
        """Refuse to change."""
        if "parameters" not in vars(self):
            return super().__setattr__(name, value)
        said = f"expected another stimulus: Stimulus(old.kind, **{{**old.parameters, {name!r}: {value!r}}})"
        raise AttributeError(f"{name} of a stimulus cannot be set; {said}")

    def __eq__(self, other: object) -> bool:
        """Compare what reproduces them."""
        return isinstance(other, Stimulus) and (self.kind, self.parameters) == (other.kind, other.parameters)

    def __hash__(self) -> int:
        """Hash what reproduces it."""
        return hash((self.kind, *self.parameters.values()))

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle what reproduces it."""
        return partial(Stimulus, self.kind, **self.parameters), ()

    def __repr__(self) -> str:
        """Return the call that makes it."""
        given = "".join(f", {name}={value!r}" for name, value in self.parameters.items())
        return f"Stimulus({self.kind!r}{given})"

    def _repr_png_(self) -> bytes:
        return png(self.codes())


N = TypeVar("N", int, float)


def _pair(name: str, given: Any, checked: Callable[[str, Any], N]) -> tuple[N, N]:
    """Return a height and a width, for which one number can stand."""
    if isinstance(given, (str, bytes, set, Mapping)):
        raise TypeError(f"{name} is {given!r}; expected a number, or height and width")
    both = (given, given) if np.ndim(given) == 0 else tuple(given)
    if len(both) != 2:
        raise _machband.Error(f"{name} is {given!r}; expected a number, or height and width")
    return checked(name, both[0]), checked(name, both[1])


def _one_or_both(pair: tuple[N, N]) -> N | tuple[N, N]:
    return pair[0] if pair[0] == pair[1] else pair


def _side(name: str, given: object) -> int:
    """Return a side in pixels."""
    return whole(name, given, 1, _machband.MAX_SIZE)


def _positive(name: str, given: object) -> float:
    found = number(name, given)
    if not 0 < found < np.inf:
        raise _machband.Error(f"{name} is {given!r}; expected a number above 0")
    return found


@suggests
def light(kind: Kind = "mach-band", *, size: int = 1024, **parameters: Unpack[Parameters]) -> npt.NDArray[np.float32]:
    """Return the linear light of a stimulus, before it is converted to codes.

    Parameters
    ----------
    kind, size, **parameters
        As in `stimulus`.

    Returns
    -------
    Light of red, green and blue relative to the screen's maximum, 0 to 1; shape (size, size, 3).

    Examples
    --------
    >>> round(float(light(size=64, low=0.2)[0, 0, 0]), 3)
    0.2
    """
    return _machband.light(*_named(kind, parameters), options(light, locals()))


@suggests
def profile(
    kind: Kind = "mach-band",
    *,
    size: int = 1024,
    transfer: str | Transfer | None = None,
    display: str | PathLike[str] | None = None,
    bits: Literal[8, 16] = 8,
    dither: Dither = "none",
    seed: Seed = 1,
    **parameters: Unpack[Parameters],
) -> Table:
    """Return the luminance profile through the center of a stimulus, along its orientation.

    Parameters
    ----------
    kind, size, bits, transfer, display, dither, seed, **parameters
        As in `stimulus`.

    Returns
    -------
    A table with a row for each of `size` pixels, as ``machband stimulus --profile`` writes it: ``x``, the distance from
    the center in window widths; ``linear``, the light of the strongest channel; ``code_r``, ``code_g``, ``code_b``; and
    ``emitted``, the light that the strongest channel's code emits.
    """
    return table(*_machband.profile(*_named(kind, parameters), options(profile, locals())))


def _scalar(found: Floats) -> float | Floats:
    """Return a number if the array has no dimensions."""
    return found if found.ndim else float(found)


@suggests
def interpolate(u: npt.ArrayLike, depth: float | str = 1) -> float | Floats:
    """Return I_n(u), the interpolation of continuity depth n (Bangay, eq. 1).

    Parameters
    ----------
    u
        Position across the ramp: 0 at its start, 1 at its end; any shape. NaN stays NaN.
    depth
        Continuity depth n, 1 to 32 or ``inf``: n − 1 derivatives vanish at the ends of the ramp.

    Returns
    -------
    Values from 0 to 1, in the shape of `u`.

    Examples
    --------
    >>> interpolate([0.25, 0.5, 0.75], depth=2).tolist()
    [0.15625, 0.5, 0.84375]
    """
    return _scalar(_machband.interpolate(numbers("u", u), text("depth", depth)))


@suggests
def visual_angle(
    *,
    px: npt.ArrayLike | None = None,
    cm: npt.ArrayLike | None = None,
    deg: npt.ArrayLike | None = None,
    screen_px: int,
    screen_cm: float,
    distance_cm: float,
) -> VisualAngle:
    """Convert lengths on a screen between pixels, centimeters and degrees of visual angle.

    Parameters
    ----------
    px, cm, deg
        Lengths in one of these units; give exactly one. Any shape.
    screen_px
        Width of the screen in physical pixels, 16 to 65536.
    screen_cm
        Width of its lit part in centimeters, 5 to 500.
    distance_cm
        Distance from the eye to the screen in centimeters, 10 to 2000.

    Examples
    --------
    >>> view = visual_angle(deg=10, screen_px=1920, screen_cm=53.1, distance_cm=57)
    >>> round(view.px, 1), round(view.ppd, 2)
    (360.6, 35.97)
    """
    lengths = {"px": px, "cm": cm, "deg": deg}
    chosen = [(unit, length) for unit, length in lengths.items() if length is not None]
    if len(chosen) != 1:
        raise TypeError(f"visual_angle() got {len(chosen)} lengths; expected exactly one of px, cm and deg")
    [(unit, length)] = chosen
    given = numbers(unit, length)
    if unit == "deg" and (np.abs(given) >= 180).any():
        raise _machband.Error(f"deg goes up to {np.abs(given).max()}; expected less than 180")
    screen = (whole("screen_px", screen_px, 16, 65536), number("screen_cm", screen_cm))
    found, ppd = _machband.visual_angle(given, unit, screen, number("distance_cm", distance_cm))
    in_deg, in_cm, in_px = map(_scalar, found)
    return VisualAngle(in_deg, in_cm, in_px, ppd)
