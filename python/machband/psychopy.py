"""Stimuli in PsychoPy, with exactly the codes that machband itself would show."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from PIL import Image
from psychopy.tools.monitorunittools import convertToPix
from psychopy.visual import GratingStim, ImageStim
from psychopy.visual.basevisual import MinimalStim

from . import _machband
from ._common import _STIMULUS_PARAMETERS, Dither, Seed, nearest
from ._stimulus import Codes, Kind, Stimulus, Transfer, _positive, stimulus

__all__ = ["MachBandStim"]


class _Aligned(ImageStim):  # type: ignore[misc]
    """An image whose texels are whole pixels of the window, unless it is turned by a fraction of a right angle."""

    def _updateVertices(self) -> None:
        super()._updateVertices()
        if self.ori % 90 == 0:
            corners = self.__dict__["verticesPix"]
            # The origin is the middle of the window, between two pixels only if its size is even.
            shown = corners.min(axis=0) + np.asarray(self.win.size) / 2
            self.__dict__["verticesPix"] = corners + np.round(shown) - shown


class _Drawer(MinimalStim):  # type: ignore[misc]
    """Draws a stimulus on every flip. To PsychoPy, ``depth`` is a place in the order of drawing, and not that of a ramp."""

    def __init__(self, stim: MachBandStim) -> None:
        super().__init__(autoLog=False)
        self.stim, self.win, self.depth = stim, stim.win, 0

    def draw(self, win: Any = None) -> None:
        self.stim.draw(win)


class MachBandStim(MinimalStim):  # type: ignore[misc]
    """A stimulus whose parameters can change from trial to trial: ``stim.width = 0.2``, ``stim.set(low=0.1, high=0.2)``.

    It is drawn at one texel per pixel, without interpolation if `ori` is a multiple of 90.

    Parameters
    ----------
    win
        The PsychoPy window. If PsychoPy linearizes the display (the monitor or the window has a gamma), the stimulus is
        drawn in linear light, and any other `transfer` is refused: it would be encoded twice.
    kind
        One of `machband.kinds`.
    size
        Side in `units` [default: 512 pixels].
    units
        Units of PsychoPy for `size` and `pos` [default: the window's].
    pos, ori, opacity, name, autoLog
        As for any stimulus of PsychoPy: center, clockwise rotation in degrees, 0 to 1, name in the log, whether changes are
        logged. They can be set, too.
    transfer, dither, seed, **parameters
        As in `machband.stimulus`.
    """

    _own = ("size", "transfer", "dither", "seed")
    _images = ("pos", "ori", "opacity", "units")

    def __init__(
        self,
        win: Any,
        kind: Kind = "mach-band",
        *,
        size: float | None = None,
        units: str = "",
        pos: Sequence[float] = (0, 0),
        ori: float = 0,
        opacity: float = 1,
        transfer: str | Transfer | None = None,
        dither: Dither = "none",
        seed: Seed = 1,
        name: str | None = None,
        autoLog: bool | None = None,
        **parameters: Any,
    ) -> None:
        """Make a stimulus for a window."""
        super().__init__(name=name, autoLog=False)
        self.win = win
        self.kind: Kind = kind
        self._drawer = _Drawer(self)
        self.__dict__.update(size=_side(size), transfer=transfer, dither=dither, seed=seed, parameters={}, _image=None)
        self.set(**parameters)
        self.__dict__["_image"] = _Aligned(
            win, units=units or win.units, pos=pos, ori=ori, opacity=opacity, name=name, autoLog=autoLog
        )
        self._transfer()

    def set(self, **parameters: Any) -> None:
        """Change parameters of the stimulus, several at once if one depends on another."""
        if wrong := {"kind", *_VIEW} & {*parameters}:
            raise TypeError(f"{wrong.pop()} is not a parameter; expected size and units, or another MachBandStim")
        found = Stimulus(self.kind, **{**self.parameters, **parameters}).parameters
        self.__dict__["parameters"] = {name: value for name, value in found.items() if name not in _VIEW}
        self._transfer()

    @property
    def autoDraw(self) -> bool:
        """Whether it is drawn on every flip."""
        return bool(self._drawer.autoDraw)

    @autoDraw.setter
    def autoDraw(self, value: bool) -> None:
        self._drawer.autoDraw = value

    @property
    def size_px(self) -> int:
        """Side in whole pixels."""
        if self.size is None:
            return 512
        [[side, _]] = convertToPix(np.array([[self.size, self.size]]), (0, 0), self._image.units, self.win)
        return max(1, round(float(side)))

    def codes(self) -> Codes:
        """Return the codes that are drawn, shape (size, size, 3), uint8."""
        transfer = self.transfer
        if self.win.gamma is not None:
            if transfer not in (None, "linear", Transfer("linear")):
                problem = f"the window linearizes the display (gamma {self.win.gamma})"
                raise _machband.Error(f"transfer is {transfer!r}, and {problem}; expected 'linear'")
            transfer = "linear"
        coding: Any = {"transfer": transfer, "dither": self.dither, "seed": self.seed}
        return stimulus(self.kind, size=self.size_px, **coding, **self.parameters)

    def _transfer(self) -> None:
        """Give the codes to the graphics card, so that the next frame only draws them."""
        if self._image is not None:
            # An image keeps its codes. An array of floats would be scaled twice.
            self._image.image = Image.fromarray(self.codes())
            self.__dict__["_drawn"] = state = (self.size_px, self.win.gamma is None)
            self._image.setSize((state[0], state[0]), units="pix")

    def draw(self, win: Any = None) -> None:
        """Draw the stimulus into the back buffer of its window, or of another one."""
        if self._drawn != (self.size_px, self.win.gamma is None):
            self._transfer()
        self._image.interpolate = self.ori % 90 != 0
        self._image.draw(win)

    def __getattr__(self, name: str) -> Any:
        """Return a parameter of the stimulus, or an attribute of the image."""
        if name in type(self)._images:
            return getattr(self._image, name)
        parameters = self.__dict__.get("parameters", {})
        known = [*self._own, *self._images, *parameters]
        # PsychoPy's experiments call setters, too.
        if (own := name[3:4].lower() + name[4:]) in known and name.startswith("set"):
            return lambda value, *_, **__: setattr(self, own, value)
        if name not in parameters:
            raise AttributeError(f"{name!r} is not known; expected one of {', '.join(known)}")
        return parameters[name]

    def __setattr__(self, name: str, value: Any) -> None:
        """Set a parameter of the stimulus, or an attribute of the image."""
        parameters = self.__dict__.get("parameters", {})
        if name in parameters:
            self.set(**{name: value})
        elif name in self._images:
            setattr(self._image, name, value)
            self._transfer()
        elif name in self._own:
            before = self.__dict__[name]
            self.__dict__[name] = _side(value) if name == "size" else value
            try:
                self._transfer()
            except Exception:
                self.__dict__[name] = before
                raise
        else:
            # What PsychoPy notes about any stimulus, such as its status, can be set.
            near = nearest(name, among=parameters, cutoff=0.75) if not hasattr(self, name) else ""
            others = {"bits", "display", "image", "kind", "parameters", *_VIEW, *_STIMULUS_PARAMETERS}
            is_other = name in others or (hasattr(GratingStim, name) and not hasattr(MinimalStim, name))
            if parameters and (near or is_other):
                settable = ", ".join([*self._own, *self._images, *parameters])
                raise AttributeError(f"{name!r} cannot be set; expected one of {settable}{near}")
            super().__setattr__(name, value)


def _side(given: float | None) -> float | None:
    """Return a side above 0, or `None`."""
    return None if given is None else _positive("size", given)


#: What a stimulus of its own has, and one in a window has not.
_VIEW = ("size", "visual_size", "ppd")
