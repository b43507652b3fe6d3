"""Predicted visibility of bands."""

from __future__ import annotations

import difflib
import re
from dataclasses import dataclass, field
from os import PathLike
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _machband
from ._common import Fields, options, path
from ._stimulus import _parameters

Floats = npt.NDArray[np.float64]


class Band(NamedTuple):
    """A band of a stimulus that varies in one direction.

    `at_deg` is its position in degrees along the orientation, from the center; `visibility` is 1 if it is just visible;
    `bright` says whether it is bright or dark.
    """

    at_deg: float
    visibility: float
    bright: bool


@dataclass(frozen=True, eq=False)
class Prediction:
    """What the model of vision predicts.

    Attributes
    ----------
    visibility
        Visibility of the strongest band: 0 means no band, 1 a band that is just visible, like a thin line at its
        threshold.
    detection
        Contrast of the whole picture, in multiples of the threshold of an average person.
    predicted_rating
        Mean rating on the scale from 0 to 3 that an average observer would give.
    bands
        Visibility of the strongest bright band, and of the strongest dark band.
    lines
        Visibility of the strongest bright line and of the strongest dark line that are in the light itself.
    along
        For a stimulus that varies in one direction: its bands with a visibility of at least 0.01, the strongest first.
        Otherwise `None`.
    map
        For any other picture: the visibility of bright bands, and of dark bands, at each pixel. Otherwise `None`.
    """

    visibility: float
    detection: float
    predicted_rating: float
    bands: tuple[float, float]
    lines: tuple[float, float]
    along: list[Band] | None
    map: tuple[Floats, Floats] | None = field(repr=False)


def _prediction(found: dict[str, Any]) -> Prediction:
    along = found["along"]
    return Prediction(**{**found, "along": along if along is None else [Band(*band) for band in along]})


def predict(
    image_or_kind: npt.ArrayLike | str | PathLike[str] = "mach-band",
    *,
    large: bool = False,
    transfer: str | None = None,
    display: str | PathLike[str] | None = None,
    size: int | None = None,
    window_deg: float | None = None,
    ppd: float | None = None,
    white: float | None = None,
    **parameters: Any,
) -> Prediction:
    """Predict how visible the Mach bands in a stimulus or an image are, as ``machband predict`` does.

    Parameters
    ----------
    image_or_kind
        One of `kinds`; or an image: the path of an opaque PNG file, or an array of shape (height, width) or (height,
        width, 3) with codes as uint8 or uint16, or with linear light relative to the screen's maximum, 0 to 1, as
        floats.
    large
        Also accept more than 500 conditions (100 if each has a rendered picture), an image of more than 3840 × 2160
        pixels, and ratings beyond the limits of `analyze`. This needs more time and memory.
    transfer
        Transfer function of the display: srgb, linear, gamma:G or gog:GAMMA,GAIN,OFFSET; for separate functions for
        red, green and blue, join three with /.
    display
        Display profile written by `machband calibrate`.
    size
        Side of the stimulus in pixels [default: 512, or 1024 if it varies in one direction only].
    window_deg
        Width of the stimulus or image in degrees of visual angle [default: the width in the rated sessions, otherwise
        in the definition, otherwise 10].
    ppd
        Pixels per degree of visual angle, in place of the width.
    white
        Luminance of white in cd/m² [default: the display profile's, or 100].
    **parameters
        The parameters of the stimulus, as in `stimulus`.

    Returns
    -------
    A `Prediction`: the visibility of the bands, their map or their positions, detection, and a mean rating.

    Notes
    -----
    A kind that varies in one direction is predicted as if it continued beyond the picture: its orientation does not
    matter. An image ends at its border, near which the coarse channels do not count, so bands that are wide for the size
    of the image are predicted weaker than those of the kind.

    ``docs/models.md`` of the project describes the model and compares it with human thresholds.

    Examples
    --------
    >>> predict(width=0.1).visibility > predict(width=0.1, depth=3).visibility
    True
    """
    if window_deg is not None and ppd is not None:
        raise TypeError("predict() got window_deg and ppd; expected one of them")
    for name, number in [("window_deg", window_deg), ("ppd", ppd), ("white", white)]:
        if not (number is None or isinstance(number, (int, float, np.number))):
            raise TypeError(f"{name} is {number!r}; expected a number")
    view = options(predict, locals())
    pixels: Fields = {"size": view.pop("size")} if "size" in view else {}
    codes_mean: Fields = {"transfer": view.pop("transfer")} if "transfer" in view else {}
    is_file = isinstance(image_or_kind, PathLike) or (
        isinstance(image_or_kind, str) and bool(re.search(r"[/\\]|\.\w+$", image_or_kind))
    )
    if isinstance(image_or_kind, str) and not is_file:
        if transfer is not None:
            raise TypeError("predict() got transfer, which means something only for the codes of an image")
        return _prediction(_machband.predict({**view, **pixels}, (image_or_kind, _parameters(parameters))))
    if parameters or size is not None:
        name = next(iter(parameters), "size")
        near = difflib.get_close_matches(name, ["window_deg", "ppd", "white", "display", "transfer", "large"], 1)
        question = f"; did you mean {near[0]!r}?" if near else ""
        raise TypeError(f"predict() got {name!r}, which an image does not have{question}")
    coded = {**view, **codes_mean}
    if is_file:
        return _prediction(_machband.predict({**coded, "image": path("image", image_or_kind)}, None))
    if isinstance(image_or_kind, np.ma.MaskedArray):
        raise TypeError("the image is a masked array, and every pixel counts; expected an array without a mask")
    image = np.asarray(image_or_kind)
    if image.ndim == 0:
        raise TypeError(f"{type(image_or_kind).__name__} is no picture; expected a kind, a path or an array")
    if image.ndim == 2:
        image = np.repeat(image[:, :, np.newaxis], 3, axis=2)
    if image.ndim != 3 or image.shape[2] != 3:
        raise _machband.Error(f"the image has shape {image.shape}; expected (height, width) or (height, width, 3)")
    height, width = image.shape[:2]
    if width == 0 or height == 0:
        raise _machband.Error(f"the image has shape {image.shape}; expected at least one pixel")
    if image.dtype.kind == "u" and image.dtype.itemsize <= 2:
        codes = np.ascontiguousarray(image, image.dtype.newbyteorder("=")).ravel()
        return _prediction(_machband.predict(coded, (codes, (height, width))))
    if image.dtype.kind != "f":
        raise TypeError(f"the image has dtype {image.dtype}; expected uint8, uint16 or floats")
    if transfer is not None:
        raise TypeError("predict() got transfer, but floats are linear light; expected codes")
    if image.max() > 1:
        raise _machband.Error(f"the light goes up to {image.max()}; expected 0 to 1, such as codes / 255 decoded by transfer")
    linear = np.ascontiguousarray(image, dtype=np.float32).ravel()
    return _prediction(_machband.predict(view, (linear, (height, width))))
