"""Stimuli as arrays, and the functions behind them."""

from __future__ import annotations

from os import PathLike
from typing import Any, Literal, NamedTuple, overload

import numpy as np
import numpy.typing as npt

from . import _machband
from ._common import Table, flag, name_of, options, suggests, table, value, whole

Codes = npt.NDArray[np.uint8] | npt.NDArray[np.uint16]
Floats = npt.NDArray[np.float64]


class Parameter(NamedTuple):
    """A parameter of a kind of stimulus.

    `default` is its value if it is not given; `unit` is ``1`` for a plain number, and empty if it is not a number;
    `expected` says which values it can have.
    """

    name: str
    default: float | str
    unit: str
    description: str
    expected: str


class VisualAngle(NamedTuple):
    """Lengths on a screen in three units, and the pixels per degree at its center.

    `deg` is the visual angle in degrees, centered on the line of sight; `cm` are centimeters on the screen; `px` are
    physical pixels.
    """

    deg: float | Floats
    cm: float | Floats
    px: float | Floats
    ppd: float


def _parameters(given: dict[str, Any]) -> list[tuple[str, float | str]]:
    return [(name, value(name, parameter)) for name, parameter in given.items()]


def kinds() -> dict[str, str]:
    """Return the kinds of stimulus, with what each shows and who first described it.

    >>> list(kinds())[:2]
    ['mach-band', 'chevreul']
    """
    return dict(_machband.kinds())


def parameters(kind: str = "mach-band") -> dict[str, Parameter]:
    """Return the parameters of a kind of stimulus, with their defaults, units, meanings and ranges.

    >>> parameters("mach-band")["width"].default
    0.4
    """
    return {found[0]: Parameter(*found) for found in _machband.parameters(name_of("kind", kind))}


@overload
def stimulus(
    kind: str = "mach-band",
    *,
    size: int = 1024,
    transfer: str | None = None,
    display: str | PathLike[str] | None = None,
    bits: int = 8,
    dither: str = "none",
    seed: int = 1,
    as_dict: Literal[False] = False,
    window_deg: float = 10.0,
    **parameters: Any,
) -> Codes: ...


@overload
def stimulus(
    kind: str = "mach-band",
    *,
    size: int = 1024,
    transfer: str | None = None,
    display: str | PathLike[str] | None = None,
    bits: int = 8,
    dither: str = "none",
    seed: int = 1,
    as_dict: Literal[True],
    window_deg: float = 10.0,
    **parameters: Any,
) -> dict[str, Any]: ...


def stimulus(
    kind: str = "mach-band",
    *,
    size: int = 1024,
    transfer: str | None = None,
    display: str | PathLike[str] | None = None,
    bits: int = 8,
    dither: str = "none",
    seed: int = 1,
    as_dict: bool = False,
    window_deg: float = 10.0,
    **parameters: Any,
) -> Codes | dict[str, Any]:
    """Return a stimulus as codes, the same as in the image that ``machband stimulus`` writes.

    By default, it is the one of the built-in experiments: a yellow ramp on an sRGB display.

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
    as_dict
        Return a dict with stimupy's keys: ``img``, the codes of three channels, where stimupy has one channel of floats;
        ``light``, as from `light`; ``mask``; ``visual_size``, height and width in degrees; ``ppd``, pixels per degree,
        vertical and horizontal; ``shape``; ``kind``; and every parameter. The mask numbers the regions of uniform light
        from the darkest (1) to the brightest; where the light varies, it is 0.
    window_deg
        Width of the image in degrees of visual angle; used only with `as_dict`.
    **parameters
        The parameters of the kind, such as ``width``, ``depth``, ``orientation_deg``, ``low``, ``high`` and ``color``;
        see `parameters`. A color is a name such as ``gray`` or ``yellow``, weights of red, green and blue such as
        ``(1, 1, 0)``, or text such as ``hsv:60,1,1`` or ``xyY:0.3,0.3,0.5``.

    Returns
    -------
    Codes of shape (size, size, 3), uint8 or uint16; or a dict.

    Notes
    -----
    The ramp of a Mach band stimulus is I_n of Bangay's *Methods of Reducing the Visibility of Mach Bands during Gouraud
    Shading*, eq. 1.

    Examples
    --------
    >>> stimulus(size=4, color="gray")[0, :, 0].tolist()
    [137, 158, 212, 225]
    """
    given = _parameters(parameters)
    if not (0 < window_deg < np.inf):
        raise _machband.Error(f"window_deg is {window_deg!r}; expected degrees above 0")
    coding = options(stimulus, locals(), "as_dict", "window_deg")
    codes: Codes = _machband.stimulus(name_of("kind", kind), given, coding)
    if not flag("as_dict", as_dict):
        return codes
    shown = light(kind, size=size, **parameters)
    described = {name: found.default for name, found in _known(kind).items()}
    return {
        "img": codes,
        "light": shown,
        "mask": _mask(shown),
        "visual_size": (window_deg, window_deg),
        "ppd": (size / window_deg, size / window_deg),
        "shape": (size, size),
        "kind": kind,
        **described,
        **parameters,
    }


_known = parameters


def _mask(shown: npt.NDArray[np.float32]) -> npt.NDArray[np.intp]:
    """Number the regions of uniform light from the darkest to the brightest; elsewhere, return 0."""
    # Only the order of the levels counts, so the channels may be added.
    level = shown.sum(axis=2, dtype=np.float64)
    padded = np.pad(level, 1, mode="edge")
    neighbors = (padded[:-2, 1:-1], padded[2:, 1:-1], padded[1:-1, :-2], padded[1:-1, 2:])
    uniform = np.logical_and.reduce([level == neighbor for neighbor in neighbors])
    levels = np.unique(level[uniform])
    if not levels.size:
        return np.zeros(level.shape, np.intp)
    found = np.searchsorted(levels, level).clip(0, levels.size - 1)
    return np.where(levels[found] == level, found + 1, 0)


def light(kind: str = "mach-band", *, size: int = 1024, **parameters: Any) -> npt.NDArray[np.float32]:
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
    return _machband.light(name_of("kind", kind), _parameters(parameters), {"size": str(whole("size", size))})


def profile(
    kind: str = "mach-band",
    *,
    size: int = 1024,
    transfer: str | None = None,
    display: str | PathLike[str] | None = None,
    bits: int = 8,
    dither: str = "none",
    seed: int = 1,
    **parameters: Any,
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
    coding = options(profile, locals())
    return table(_machband.profile(name_of("kind", kind), _parameters(parameters), coding))


def _like(given: Floats, found: Floats, scalar: bool) -> float | Floats:
    return float(found[0]) if scalar else found.reshape(given.shape)


def _flat(values: npt.ArrayLike) -> tuple[Floats, Floats, bool]:
    given = np.asarray(values, dtype=np.float64)
    return given, np.ascontiguousarray(given).ravel(), given.ndim == 0


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
    given, flat, scalar = _flat(u)
    return _like(given, _machband.interpolate(flat, value("depth", depth)), scalar)


@suggests
def transfer(values: npt.ArrayLike, function: str = "srgb", *, inverse: bool = False) -> float | Floats:
    """Encode light for a display, or decode encoded values.

    Parameters
    ----------
    values
        Linear light relative to the maximum, 0 to 1; with `inverse`, encoded values from 0 to 1, such as ``codes / 255``.
        Any shape.
    function
        ``srgb`` (IEC 61966-2-1), ``linear``, ``gamma:G`` or ``gog:GAMMA,GAIN,OFFSET``.
    inverse
        Decode.

    Returns
    -------
    Encoded values, or light, in the shape of `values`.

    Examples
    --------
    >>> round(transfer(0.5), 4)
    0.7354
    """
    given, flat, scalar = _flat(values)
    if np.isnan(flat).any():
        raise _machband.Error("values contains NaN; expected 0 to 1")
    if flat.size and not (flat.min() >= 0 and flat.max() <= 1):
        raise _machband.Error(f"values go from {flat.min()} to {flat.max()}; expected 0 to 1, such as codes / 255")
    return _like(given, _machband.encode(flat, function, inverse), scalar)


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
    given, flat, scalar = _flat(length)
    if unit == "deg" and flat.size and not (np.abs(flat).max() < 180):
        raise _machband.Error(f"deg goes up to {np.abs(flat).max()}; expected less than 180")
    found, ppd = _machband.visual_angle(flat, unit, (whole("screen_px", screen_px), screen_cm), distance_cm)
    in_deg, in_cm, in_px = (_like(given, one, scalar) for one in found)
    return VisualAngle(in_deg, in_cm, in_px, ppd)
