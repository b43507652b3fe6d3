"""Stimuli in PsychoPy, with exactly the codes that machband itself would show."""

from __future__ import annotations

from os import PathLike
from typing import Any

from ._stimulus import stimulus

__all__ = ["stim"]


def stim(
    win: Any,
    kind: str = "mach-band",
    *,
    size: int = 512,
    transfer: str | None = None,
    display: str | PathLike[str] | None = None,
    dither: str = "none",
    seed: int = 1,
    pos: tuple[float, float] = (0, 0),
    name: str | None = None,
    **parameters: Any,
) -> Any:
    """Return an `ImageStim` of a stimulus, one texel for each pixel.

    Parameters
    ----------
    win
        The PsychoPy window. Its monitor must have no gamma calibration, because the codes are already for the display.
        If PsychoPy linearizes the display, pass ``transfer="linear"``.
    kind, size, transfer, display, dither, seed, **parameters
        As in `machband.stimulus`. `size` is in physical pixels.
    pos
        Position of the center in pixels. If the window's or the stimulus's size is odd and the other's is even, shift it
        by half a pixel to keep the pixels aligned.
    name
        Name of the stimulus in PsychoPy's log.

    Returns
    -------
    A `psychopy.visual.ImageStim` in units of pixels, not interpolated.
    """
    from PIL import Image
    from psychopy.visual import ImageStim

    codes = stimulus(
        kind, size=size, transfer=transfer, display=display, dither=dither, seed=seed, **parameters
    )
    # An image keeps its codes. An array of floats would be scaled twice.
    return ImageStim(
        win, image=Image.fromarray(codes), units="pix", size=(size, size), pos=pos, interpolate=False, name=name
    )
