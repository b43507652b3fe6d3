"""Shaded meshes."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from os import PathLike
from types import NoneType
from typing import Any, Literal, NamedTuple, Union

import numpy as np
import numpy.typing as npt

from . import _machband
from ._common import Dither, Fields, Seed, flag, numbers, options, path, png, suggests, unmasked, whole
from ._stimulus import Codes, Transfer
from .stimuli import Shader, Shape

Triple = Union[Sequence[float], npt.NDArray[Any]]


class Mesh(NamedTuple):
    """A mesh of triangles, as `shade` takes it.

    `vertices` are positions of shape (n, 3): x right, y up, z toward the viewer. `triangles` are the indices of their
    corners, shape (m, 3), counterclockwise as seen from outside. `normals` are the unit normals at the vertices, (n, 3).
    """

    vertices: npt.NDArray[np.float64]
    triangles: npt.NDArray[np.uint32]
    normals: npt.NDArray[np.float64]

    def __repr__(self) -> str:
        """Tell the size."""
        return f"<Mesh: {len(self.vertices)} vertices, {len(self.triangles)} triangles>"


class Shaded(NamedTuple):
    """A shaded mesh.

    `image` has codes of shape (size, size, 3), uint8 or uint16. `metrics` has what ``machband shade --metrics`` writes:
    the change of slope across the edges (``crease_rms``, …), and the difference from the smooth surface in times
    threshold (``difference``) and in light (``residual``), each also relative to Gouraud's; `None` if it was not wanted.
    """

    image: Codes
    metrics: dict[str, Any] | None

    def __repr__(self) -> str:
        """Tell the size."""
        height, width = self.image.shape[:2]
        return f"<Shaded: {width} × {height} pixels, {self.image.dtype}{'' if self.metrics is None else ', measured'}>"

    def _repr_png_(self) -> bytes:
        return png(self.image)


@suggests
def mesh(name_or_path: Shape | str | PathLike[str] = "blob", *, n_vertices: int = 313, crease: float = 180.0) -> Mesh:
    """Return a built-in shape, or a mesh from an OBJ, PLY, glTF or GLB file.

    Parameters
    ----------
    name_or_path
        ``cube``, ``pyramid``, ``sphere``, ``uv-sphere``, ``torus``, ``jittered-torus``, ``blob``, ``terrain``,
        ``cylinder``, ``filleted-cylinder``, or the path of a file.
    n_vertices
        Number of vertices of a shape; exact for a blob, approximate for other round shapes.
    crease
        Angle in degrees above which the edge between two faces of a file without normals is a crease.

    Examples
    --------
    >>> mesh("blob", n_vertices=313).triangles.shape
    (622, 3)
    """
    given = {**options(mesh, locals(), "n_vertices"), **_named(name_or_path, n_vertices), "shader": "phong"}
    return Mesh(*_machband.mesh(given))


def _named(name_or_path: str | PathLike[str], n_vertices: int) -> Fields:
    return {"mesh": path("name_or_path", name_or_path), "vertices": str(whole("n_vertices", n_vertices))}


def _rows(name: str, given: npt.ArrayLike) -> npt.NDArray[np.float64]:
    array = numbers(name, given)
    if array.ndim != 2 or array.shape[1] != 3:
        raise _machband.Error(f"{name} has shape {array.shape}; expected (n, 3)")
    return np.ascontiguousarray(array)


@suggests
def shade(
    vertices: npt.ArrayLike | Mesh | Shape | str | PathLike[str] = "blob",
    triangles: npt.ArrayLike | None = None,
    normals: npt.ArrayLike | Literal["given", "averaged", "best"] | None = None,
    *,
    crease: float = 180,
    depth: float | str = 1,
    boundary: float = 0.2,
    vertex: Literal["off", "printed", "repaired"] = "off",
    reweight: Literal["off", "printed", "repaired"] = "off",
    rotate: Triple = (25, -35, 0),
    light: Triple = (0.36, 0.48, 0.8),
    color: str | Triple = "gray",
    ambient: float = 0.1,
    diffuse: float = 0.6,
    specular: float = 0.2,
    highlight: Literal["phong", "blinn", "torrance-sparrow", "cook-torrance"] = "phong",
    shininess: float = 20,
    facet_slope: float | None = None,
    facet_c1: float | None = None,
    facet_index: float | None = None,
    background: float = 0.05,
    distance: float = float("inf"),
    window_deg: float = 10,
    size: int = 1024,
    transfer: str | Transfer | None = None,
    display: str | PathLike[str] | None = None,
    bits: Literal[8, 16] = 8,
    dither: Dither = "none",
    seed: Seed = 1,
    white: float | None = None,
    black: float | None = None,
    shader: Shader | None = "c1-phong",
    truth: bool | str | PathLike[str] = False,
    n_vertices: int = 313,
    metrics: bool = True,
) -> Shaded:
    """Shade a mesh, and measure how smooth its edges are and how visible its bands, as ``machband shade`` does.

    Parameters
    ----------
    vertices
        Positions of shape (n, 3). Or a whole `Mesh`, the name of a built-in shape, the path of a mesh, or the path of a
        scene (``.toml``) with several meshes and lamps, which has no metrics.
    triangles
        Indices of the corners, shape (m, 3), counterclockwise as seen from outside.
    normals
        Normals at the vertices, shape (n, 3), of any length above 0. Or how to estimate them from the triangles:
        ``averaged``, or ``best``, between a mean and the slope of a cubic that is fitted to the neighbors, the default for
        vertices without normals; ``given`` takes those of a file.
    crease
        Angle in degrees above which the edge between two faces of a file without normals is a crease.
    depth
        Continuity depth n of the strips at the edges, 1 to 32 or inf; used by fixed, gradient and the corrections.
    boundary
        Width b of the strips, as a barycentric weight, 0 to 1; values above 1/3 act as 1/3.
    vertex
        Vertex shading correction (Bangay, eq. 7).
    reweight
        Intensity reweighting correction (Bangay, eq. 9).
    rotate
        Rotation of the mesh about x, then y, then z, in degrees.
    light
        Direction toward the lamp: x right, y up, z toward the viewer.
    color
        Color of the surface: gray, yellow, red, green, blue, R,G,B (linear weights), hsv:H,S,V or xyY:x,y,Y.
    ambient
        Ambient light, 0 to 1.
    diffuse
        Diffuse light at normal incidence, 0 to 1.
    specular
        Strength of the highlight, 0 to 1: what phong and blinn add at its center; torrance-sparrow and cook-torrance
        may add more or less.
    highlight
        Highlight model.
    shininess
        Exponent of the highlight.
    facet_slope
        Root mean square slope m of the small mirrors of torrance-sparrow and cook-torrance, 0.001 to 10; without it,
        the highlight is as sharp as Blinn's.
    facet_c1
        Constant c1 of torrance-sparrow, 0 to 1e6; without it, as many mirrors face along the normal as in cook-torrance.
    facet_index
        Index of refraction of the small mirrors, 1 to 1000; they reflect ((index - 1) / (index + 1))^2 of the light at
        normal incidence [default: 3].
    background
        Background light, 0 to 1.
    distance
        Distance of the eye in mesh radii, 1.05 to 1e6; inf for a parallel projection.
    window_deg
        Width of the image in degrees of visual angle, for the difference from the smooth surface, 0.5 to 170.
    size, transfer, display, bits, dither, seed
        As in `stimulus`.
    white, black
        As in `compare`.
    shader
        ``flat``, ``gouraud``, ``phong``, ``quadratic``, ``fixed``, ``gradient``, ``gradient-repaired``, ``patch`` or
        ``c1-phong``; `None`, with `truth`, for the smooth surface alone.
    truth
        `True`, with ``shader=None``, draws the smooth surface behind a built-in shape. The path of a finer mesh: the
        surface to compare with, or, with ``shader=None``, to draw.
    n_vertices
        As in `mesh`.
    metrics
        Whether to measure, which takes longer than to draw.

    Examples
    --------
    >>> gouraud = shade("blob", shader="gouraud", size=256).metrics
    >>> ours = shade("blob", shader="c1-phong", size=256).metrics
    >>> ours["difference"]["largest"] < gouraud["difference"]["largest"]
    True
    """
    if isinstance(vertices, Mesh):
        if triangles is not None:
            raise TypeError("shade() got a Mesh and triangles; expected a Mesh alone, or arrays")
        normals = vertices.normals if normals is None else normals
        vertices, triangles = vertices[:2]
    given = options(shade, locals(), "truth", "n_vertices", "metrics")
    if not isinstance(truth, (bool, np.bool_)):
        given["truth"] = path("truth", truth)
    elif truth:
        given["truth"] = True
    elif shader is None:
        raise TypeError("shade() got neither shader nor truth; expected at least one of them")
    arrays = None
    if isinstance(vertices, (str, os.PathLike)):
        if triangles is not None or not isinstance(normals, (str, NoneType)):
            what = "triangles" if triangles is not None else "normals"
            raise TypeError(f"shade() got {what} for the mesh {vertices!r}; expected only arrays or only a name")
        given |= _named(vertices, n_vertices)
        if str(vertices).endswith(".toml"):
            given["scene"] = given.pop("mesh")
            metrics = False
            if shader == "c1-phong":
                del given["shader"]
    elif triangles is None:
        raise TypeError("shade() got vertices without triangles; expected both")
    elif n_vertices != 313:
        raise TypeError("shade() got n_vertices for arrays; expected it only for the name of a shape")
    else:
        given["mesh"] = "arrays"
        positions, corners = _rows("vertices", vertices), _rows("triangles", triangles)
        if not ((corners >= 0) & (corners < 2**32) & (corners % 1 == 0)).all():
            raise _machband.Error("triangles has a negative or huge index, or a fraction; expected indices of vertices")
        own = None if isinstance(normals, (str, NoneType)) else _rows("normals", normals)
        if own is not None and len(own) != len(positions):
            raise _machband.Error(f"normals has length {len(own)}; expected {len(positions)}, one for each vertex")
        arrays = (positions, corners.astype(np.uint32), own, crease)
    if isinstance(normals, str):
        if normals == "given" and arrays:
            raise TypeError("normals is 'given', which is for files; expected an array, or a way to estimate them")
        given["normals"] = normals
    codes, measured = _machband.shade(given, arrays, flag("metrics", metrics) and shader is not None)
    found = None if measured is None else json.loads(measured)
    if found and arrays:
        used = normals if isinstance(normals, str) else "averaged" if normals is None else "given"
        found.update(vertices=len(positions), normals=used)
    return Shaded(codes, found)
