"""How visible the bands of a stimulus are, and the difference between two pictures."""

from __future__ import annotations

import inspect
import json
from collections.abc import Callable
from dataclasses import dataclass, field
from os import PathLike
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from . import _machband
from ._common import Fields, options, path, suggests, unmasked
from ._stimulus import Kind, Transfer, _named

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .stimuli import Parameters


@dataclass(frozen=True)
class Prediction:
    """What the model of vision predicts, in times threshold: at 1, people just see the difference.

    Attributes
    ----------
    band_bright, band_dark
        The ramp's difference from the nearest smooth edge, on its light and on its dark side; `None` for other kinds.
    detection
        Contrast of the whole picture.
    difference
        For a shaded mesh: the largest difference from the smooth surface behind it, if that is known. Otherwise `None`.
    predicted_rating
        Mean rating by the criterion; `None` without one.
    blur_deg
        For a ramp: the Gaussian blur, σ in degrees, of the nearest smooth edge. Otherwise `None`.
    at_deg
        For a ramp: the places of the bright and of the dark band, in degrees along the orientation from the middle of the
        stimulus. Otherwise `None`.
    """

    band_bright: float | None
    band_dark: float | None
    detection: float
    difference: float | None
    predicted_rating: float | None
    blur_deg: float | None
    at_deg: tuple[float, float] | None


@suggests
def predict(
    kind: Kind = "mach-band",
    *,
    display: str | PathLike[str] | None = None,
    size: int | None = None,
    ppd: float | None = None,
    white: float | None = None,
    black: float | None = None,
    window_deg: float | None = None,
    criterion: str | PathLike[str] | None = None,
    **parameters: Unpack[Parameters],
) -> Prediction:
    """Predict how visible the Mach bands of a stimulus are, as ``machband predict`` does.

    Parameters
    ----------
    kind
        One of `kinds`.
    display
        Display profile written by `machband calibrate`, for its white and black; stimuli have the primaries of sRGB.
    size
        Side of the stimulus in pixels [default: 512, or 1024 if it varies in one direction only].
    window_deg
        Width of the stimulus in degrees of visual angle [default: 10].
    criterion
        File with the thresholds between ratings, fitted to people by ``machband predict``, to predict ratings.
    ppd, white, black
        As in `compare`.
    **parameters
        The parameters of the stimulus, as in `stimulus`.

    Notes
    -----
    ``docs/models.md`` of the project describes the model and the data with which it was compared.

    Examples
    --------
    >>> predict(width=0.1).band_bright > predict(width=0.1, depth=3).band_bright
    True
    """
    ramp, *others = _machband.predict(options(predict, locals()), *_named(kind, parameters))
    bright, dark, *places = ramp or [None] * 4
    return Prediction(bright, dark, *others, *places)


class Place(NamedTuple):
    """A place where the difference between two pictures is visible: the column and the row of the pixel, from 0, and the
    difference for a gaze there, in times threshold."""

    x: int
    y: int
    times_threshold: float


@dataclass(frozen=True, eq=False)
class Comparison:
    """How visible the difference between two pictures is, in times threshold: at 1, people just tell them apart.

    Attributes
    ----------
    times_threshold
        For a gaze at the place where the difference is most visible.
    center
        For a gaze at the middle of the picture.
    places
        Up to ten places where it is most visible, the most visible first.
    light
        What the codes of the pictures mean, and what says so.
    mean_ratio
        Mean luminance of the picture over that of the reference, which is not part of the difference; a warning says if
        it is far from 1.
    map
        Times threshold for a gaze at each pixel, shape (height, width).
    """

    times_threshold: float
    center: float
    places: list[Place]
    light: str
    mean_ratio: float
    map: npt.NDArray[np.float64] = field(repr=False)


@suggests
def compare(
    picture: npt.ArrayLike | PathLike[str] | str,
    reference: npt.ArrayLike | PathLike[str] | str,
    *,
    window_deg: float | None = None,
    ppd: float | None = None,
    white: float | None = None,
    black: float | None = None,
    transfer: str | Transfer | None = None,
    display: str | PathLike[str] | None = None,
    mask: str | PathLike[str] | None = None,
    large: bool = False,
) -> Comparison:
    """Judge how visible the difference of a picture from a reference is, as ``machband compare`` does.

    Parameters
    ----------
    picture, reference
        Two paths of opaque PNG files; or two arrays of shape (height, width) or (height, width, 3) with codes as uint8 or
        uint16, or with linear light relative to the screen's maximum, 0 to 1, as floats.
    window_deg
        Width of the picture in degrees of visual angle; required, unless there are pixels per degree.
    ppd
        Pixels per degree of visual angle, in place of the width.
    white
        Luminance of white in cd/m², without that of black [default: the display profile's, or 100].
    black
        Luminance of black in cd/m², with what the screen reflects [default: the display profile's, or 0.2].
    transfer
        Transfer function of the display: srgb, linear, gamma:G or gog:GAMMA,GAIN,OFFSET; for separate functions for
        red, green and blue, join three with /.
    display
        Display profile written by `machband calibrate`.
    mask
        Picture of the same size that is white where differences count, and black where they do not.
    large
        Also accept pictures of more than 4096 × 4096 pixels. This needs more time and memory.

    Notes
    -----
    Only luminance is judged. The pictures must be registered: a shift by one pixel is a visible difference.

    Examples
    --------
    >>> ramp = stimulus(width=0.1, size=256)
    >>> compare(ramp, ramp, window_deg=5).times_threshold
    0.0
    """
    request = options(compare, locals())
    given = _given(request, picture=picture, reference=reference)
    if given and "transfer" in request and all(one.dtype.kind == "f" for one in given):
        raise _machband.Error("transfer is for codes, and floats are light; expected uint8 or uint16, or no transfer")
    found, map = _machband.compare(request, given)
    return _made(Comparison, found, map=map)


@dataclass(frozen=True, eq=False)
class Steps:
    """How visible the steps between the codes of a picture are, in times threshold.

    Attributes
    ----------
    steps
        The visible difference from the smoothest picture with these codes.
    rounded
        The visible difference of a picture of 16 bits from itself in 8 bits without dither; `None` for one of 8 bits.
    dithered
        The same with blue-noise dither, whose grain is a visible difference too.
    light
        What the codes of the picture mean, and what says so.
    picture
        The dithered picture, shape (height, width, 3), uint8. A picture of 8 bits is smoothed first.
    """

    steps: float
    rounded: float | None
    dithered: float
    light: str
    picture: npt.NDArray[np.uint8] = field(repr=False)


@suggests
def steps(
    picture: npt.ArrayLike | PathLike[str] | str,
    *,
    window_deg: float | None = None,
    ppd: float | None = None,
    white: float | None = None,
    black: float | None = None,
    transfer: str | Transfer | None = None,
    display: str | PathLike[str] | None = None,
    large: bool = False,
) -> Steps:
    """Judge how visible the steps between a picture's own codes are, as ``machband compare --steps`` does.

    Parameters
    ----------
    picture
        The path of an opaque PNG file, or an array of codes as in `compare`.
    window_deg, ppd, white, black, transfer, display, large
        As in `compare`.

    Examples
    --------
    >>> found = steps(stimulus(width=0.9, low=0.1, high=0.11, size=256), window_deg=10)
    >>> found.steps > 0
    True
    """
    request = {**options(steps, locals()), "steps": True}
    given = _given(request, picture=picture)
    if given and given[0].dtype.kind == "f":
        raise _machband.Error("picture is light, which has no codes; expected codes as uint8 or uint16")
    found, dithered = _machband.compare(request, given)
    return _made(Steps, found, picture=dithered)


T = TypeVar("T")


def _made(of: Callable[..., T], found: str, **more: Any) -> T:
    """Return a record with the values of the same names in the JSON of the command, and with more."""
    values = {**json.loads(found, object_hook=lambda one: Place(**one) if "x" in one else one), **more}
    return of(**{name: values[name] for name in inspect.signature(of).parameters})


def _given(request: Fields, **pictures: Any) -> list[npt.NDArray[Any]]:
    """Return pictures as arrays, or, if all of them are paths, no arrays; add their names or paths to a request."""
    if all(isinstance(one, (str, PathLike)) for one in pictures.values()):
        request |= {name: path(name, one) for name, one in pictures.items()}
        return []
    request |= {name: name for name in pictures}
    return [_pixels(name, one) for name, one in pictures.items()]


def _pixels(name: str, given: Any) -> npt.NDArray[Any]:
    """Return an image as an array of red, green and blue."""
    if isinstance(given, (str, PathLike)):
        raise TypeError(f"{name} is a path, and the other is not; expected two paths or two arrays")
    image = np.asarray(unmasked(name, given))
    if image.ndim == 0:
        raise TypeError(f"{name} is {type(given).__name__}; expected a path or an array")
    if image.ndim == 2:
        image = np.repeat(image[:, :, np.newaxis], 3, axis=2)
    if image.ndim != 3 or image.shape[2] != 3 or not image.size:
        expected = "expected (height, width) or (height, width, 3), and at least one pixel"
        raise _machband.Error(f"{name} has shape {image.shape}; {expected}")
    if image.dtype.kind == "u" and image.dtype.itemsize <= 2:
        return np.ascontiguousarray(image, image.dtype.newbyteorder("="))
    if image.dtype.kind != "f":
        raise TypeError(f"{name} has dtype {image.dtype}; expected uint8, uint16 or floats")
    if not (is_light := (image >= 0) & (image <= 1)).all():
        place = np.unravel_index(is_light.argmin(), image.shape)
        expected = "expected 0 to 1, such as codes / 255 decoded by a Transfer"
        raise _machband.Error(f"{name} has light {image[place]} in row {place[0]}, column {place[1]}; {expected}")
    return np.ascontiguousarray(image, dtype=np.float32)
