"""Predicted visibility of bands."""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _machband
from ._stimulus import _parameters

Floats = npt.NDArray[np.float64]

#: Maximum number of pixels of an image, unless the caller allows more: those of a 4K screen.
MAX_PIXELS = 3840 * 2160


@dataclass(frozen=True, eq=False)
class Prediction:
    """What the model of vision predicts."""

    #: Visibility of the strongest band: 0 means no band, 1 a band that is just visible, like a thin line at its
    #: threshold.
    visibility: float
    #: How many times the contrast of the whole picture stands above the threshold of an average person.
    detection: float
    #: Mean rating on the scale from 0 to 3 that an average observer would give.
    predicted_rating: float
    #: Visibility of the strongest bright band, and of the strongest dark band.
    bands: tuple[float, float]
    #: Visibility of the strongest bright and dark lines that are in the light itself.
    lines: tuple[float, float]
    #: For a stimulus that varies in one direction: for each band with a visibility of at least 0.01, the strongest
    #: first, its position in degrees along the orientation from the center, its visibility, and whether it is bright.
    #: Otherwise `None`.
    along: list[tuple[float, float, bool]] | None
    #: For any other picture: the visibility of bright bands, and of dark bands, at each pixel. Otherwise `None`.
    map: tuple[Floats, Floats] | None


def predict(
    image_or_kind: npt.ArrayLike | str = "mach-band",
    *,
    window_deg: float | None = None,
    ppd: float | None = None,
    white: float | None = None,
    display: str | PathLike[str] | None = None,
    size: int | None = None,
    transfer: str | None = None,
    large: bool = False,
    **parameters: Any,
) -> Prediction:
    """Predict how visible the Mach bands in a stimulus or an image are, as ``machband predict`` does.

    Parameters
    ----------
    image_or_kind
        One of `kinds`; or an image of shape (height, width) or (height, width, 3): codes as uint8 or uint16, or linear
        light relative to white as floats.
    window_deg
        Width of the picture in degrees of visual angle; 10 if neither this nor `ppd` is given.
    ppd
        Pixels per degree, in place of `window_deg`.
    white
        Luminance of white in cd/m²; by default that of `display`, or 100.
    display
        Path of a display profile, which says what the codes of an image mean and how bright white is.
    size
        Side of the stimulus in pixels, from 16; by default 1024 if it varies in one direction only, otherwise 512.
    transfer
        What the codes of an image mean, as in `stimulus`.
    large
        Also accept an image of more than 3840 × 2160 pixels. Each pixel takes about 110 bytes of memory.
    **parameters
        The parameters of the stimulus, as in `stimulus`.

    Notes
    -----
    ``docs/predict.md`` of the project describes the model, and holds it against measured thresholds of people.

    Examples
    --------
    >>> predict(width=0.1).visibility > predict(width=0.1, depth=3).visibility
    True
    """
    if window_deg is not None and ppd is not None:
        raise TypeError("predict() got window_deg and ppd; expected one of them")
    if isinstance(image_or_kind, str):
        if transfer is not None:
            raise TypeError("predict() got transfer, which means something only for the codes of an image")
        given = _parameters(parameters)
        return Prediction(**_machband.predict_stimulus(image_or_kind, given, size, (window_deg, ppd, white, display)))
    if parameters or size is not None:
        name = next(iter(parameters), "size")
        raise TypeError(f"predict() got {name}, which means something only for a stimulus, not for an image")
    image = np.asarray(image_or_kind)
    if image.ndim == 2:
        image = np.repeat(image[:, :, np.newaxis], 3, axis=2)
    if image.ndim != 3 or image.shape[2] != 3:
        raise ValueError(f"the image has shape {image.shape}; expected (height, width) or (height, width, 3)")
    height, width = image.shape[:2]
    if width == 0 or height == 0:
        raise ValueError(f"the image has shape {image.shape}; expected at least one pixel")
    if height * width > MAX_PIXELS and not large:
        raise ValueError(f"the image has {width} × {height} pixels; expected at most {MAX_PIXELS}, or large=True")
    view = (window_deg, ppd, white, display)
    if image.dtype in (np.uint8, np.uint16):
        codes = np.ascontiguousarray(image).ravel()
        return Prediction(**_machband.predict_codes(codes, (height, width), transfer, view))
    if image.dtype.kind != "f":
        raise TypeError(f"the image has dtype {image.dtype}; expected uint8, uint16 or floats")
    if transfer is not None:
        raise TypeError("predict() got transfer, but floats are linear light; expected codes")
    linear = np.ascontiguousarray(image, dtype=np.float32).ravel()
    return Prediction(**_machband.predict_light(linear, (height, width), view))
