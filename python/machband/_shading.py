"""Shaded meshes."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from os import PathLike
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _machband
from ._common import flag, options, suggests, whole
from ._stimulus import Codes

Triple = Sequence[float]


class Mesh(NamedTuple):
    """A mesh of triangles, as `shade` takes it.

    `vertices` are positions of shape (n, 3): x right, y up, z toward the viewer. `triangles` are the indices of their
    corners, shape (m, 3), counterclockwise as seen from outside. `normals` are the unit normals at the vertices, (n, 3).
    """

    vertices: npt.NDArray[np.float64]
    triangles: npt.NDArray[np.uint32]
    normals: npt.NDArray[np.float64]


class Shaded(NamedTuple):
    """A shaded mesh.

    `image` has codes of shape (size, size, 3), uint8 or uint16. `metrics` has what ``machband shade --metrics`` writes:
    the change of slope across the edges (``crease_rms``, …), the visibility of the bands (``visibility``, …), and the
    difference from the smooth surface (``residual``), each also relative to Gouraud's; `None` if it was not wanted.
    """

    image: Codes
    metrics: dict[str, Any] | None


@suggests
def mesh(
    name_or_path: str | PathLike[str] = "blob",
    *,
    n_vertices: int = 313,
    crease: float = 180.0,
) -> Mesh:
    """Return a built-in shape, or a mesh from an OBJ, PLY, glTF or GLB file.

    Parameters
    ----------
    name_or_path
        ``cube``, ``pyramid``, ``sphere``, ``uv-sphere``, ``torus``, ``jittered-torus``, ``blob``, ``terrain``,
        ``cylinder``, ``filleted-cylinder``, or the path of a file.
    n_vertices
        Number of vertices of a shape; exact for a blob, approximate for other round shapes.
    crease
        Angle in degrees above which the edge between two faces of a file is a crease.

    Examples
    --------
    >>> mesh("blob", n_vertices=313).triangles.shape
    (622, 3)
    """
    given = options(
        mesh=os.fspath(name_or_path), vertices=whole("n_vertices", n_vertices), crease=crease, shader="phong"
    )
    return Mesh(*_machband.mesh(given))


def _rows(name: str, given: npt.ArrayLike, dtype: type) -> npt.NDArray[Any]:
    array = np.asarray(given)
    if array.ndim != 2 or array.shape[1] != 3:
        raise _machband.Error(f"{name} has shape {array.shape}; expected (n, 3)")
    if dtype is np.uint32:
        if array.dtype.kind not in "iu":
            raise TypeError(f"{name} has dtype {array.dtype}; expected integers")
        if array.size and (array.min() < 0 or array.max() > np.iinfo(np.uint32).max):
            raise _machband.Error(f"{name} has a negative or huge index; expected indices of vertices")
    return np.ascontiguousarray(array, dtype=dtype)


@suggests
def shade(
    vertices: npt.ArrayLike | Mesh | str | PathLike[str] = "blob",
    triangles: npt.ArrayLike | None = None,
    normals: npt.ArrayLike | str | None = None,
    *,
    shader: str | None = "c1-phong",
    depth: int | str = 1,
    boundary: float | None = None,
    vertex: str = "off",
    reweight: str = "off",
    gradients: str = "curvature",
    truth: bool | str | PathLike[str] = False,
    n_vertices: int = 313,
    crease: float = 180.0,
    rotate: Triple = (25, -35, 0),
    light: Triple = (0.36, 0.48, 0.8),
    color: str | Triple = "gray",
    ambient: float | None = None,
    diffuse: float | None = None,
    specular: float | None = None,
    highlight: str = "phong",
    shininess: float | None = None,
    background: float | None = None,
    distance: float = float("inf"),
    naive: bool = False,
    size: int = 1024,
    bits: int = 8,
    transfer: str | None = None,
    display: str | PathLike[str] | None = None,
    window_deg: float = 10.0,
    white: float | None = None,
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
        Normals at the vertices, shape (n, 3), of any length above 0; without them, they are averaged over the faces. Or
        how to estimate them from the triangles: ``averaged``, ``max`` (Max 1999) or ``cubic``.
    shader
        ``flat``, ``gouraud``, ``phong``, ``c1-phong``, ``fixed``, ``gradient``, ``gradient-repaired``, ``patch``
        or ``quadratic``; `None`, with `truth`, for the smooth surface alone.
    depth, boundary
        Continuity depth n of the strips at the edges, 1 to 32 or ``inf``, and their width as a barycentric weight.
    vertex, reweight
        Corrections of Bangay's eq. 7 and eq. 9: ``off``, ``printed`` or ``repaired``.
    gradients
        How ``patch`` and ``c1-phong`` compute their slopes: ``curvature``, ``ring`` or ``quadric``.
    truth
        Compare with the smooth surface: `True` for the one behind a built-in shape, or the path of a finer mesh.
    n_vertices, crease
        As in `mesh`.
    rotate
        Rotation of the mesh about x, then y, then z, in degrees.
    light
        Direction toward the lamp, of any length: x right, y up, z toward the viewer.
    color
        Color of the surface: a name, or linear weights of red, green and blue.
    ambient, diffuse, specular, highlight, shininess, background
        The lighting: linear light from 0 to 1 (by default 0.1, 0.6, 0.2, and 0.05 behind the mesh); the model of the
        highlight, ``phong``, ``blinn``, ``torrance-sparrow`` or ``cook-torrance``; and its exponent, by default 20.
    distance
        Distance of the eye in radii of the mesh, from 1.05; infinite for a parallel projection.
    naive
        Interpolate encoded values, like a renderer that ignores gamma.
    size, bits, transfer, display
        As in `stimulus`.
    window_deg, white
        Width of the picture in degrees of visual angle, and luminance of white in cd/m², for the visibility of bands.
    metrics
        Whether to measure, which takes longer than to draw.

    Examples
    --------
    >>> gouraud = shade("blob", shader="gouraud", size=256).metrics
    >>> ours = shade("blob", shader="c1-phong", size=256).metrics
    >>> ours["visibility"] < gouraud["visibility"]
    True
    """
    if isinstance(vertices, Mesh):
        if triangles is not None:
            raise TypeError("shade() got a Mesh and triangles; expected a Mesh alone, or arrays")
        positions, triangles, own_normals = vertices
        vertices, normals = positions, own_normals if normals is None else normals
    if shader is None and not truth:
        raise TypeError("shade() got neither shader nor truth; expected at least one of them")
    estimated = normals if isinstance(normals, str) else None
    given = options(
        crease=crease,
        normals=estimated,
        shader=shader,
        truth=truth if isinstance(truth, bool) else os.fspath(truth),
        depth=depth,
        boundary=boundary,
        vertex=vertex,
        reweight=reweight,
        gradients=gradients,
        rotate=rotate,
        light=light,
        color=color,
        ambient=ambient,
        diffuse=diffuse,
        specular=specular,
        highlight=highlight,
        shininess=shininess,
        background=background,
        distance=distance,
        naive=flag("naive", naive),
        window_deg=window_deg,
        white=white,
    )
    image = options(size=whole("size", size), bits=whole("bits", bits), transfer=transfer, display=display)
    if isinstance(vertices, (str, os.PathLike)):
        path = os.fspath(vertices)
        if triangles is not None:
            raise TypeError(f"shade() got triangles for the mesh {path!r}; expected only arrays or only a name")
        if normals is not None and estimated is None:
            raise TypeError(f"shade() got normals for the mesh {path!r}; expected only arrays or only a name")
        if path.endswith(".toml"):
            return Shaded(*_machband.shade({"scene": path, **image}, None, False))
        fields = {**options(mesh=path, vertices=whole("n_vertices", n_vertices)), **given, **image}
        codes, measured = _machband.shade(fields, None, flag("metrics", metrics) and shader is not None)
    else:
        if triangles is None:
            raise TypeError("shade() got vertices without triangles; expected both")
        positions = _rows("vertices", vertices, np.float64)
        own = None if normals is None or estimated else _rows("normals", normals, np.float64)
        if own is not None and len(own) != len(positions):
            raise _machband.Error(f"normals has {len(own)} rows; expected {len(positions)}, one for each vertex")
        arrays = (positions, _rows("triangles", triangles, np.uint32), own, crease)
        codes, measured = _machband.shade({"mesh": "arrays", **given, **image}, arrays, metrics and shader is not None)
    found = None if measured is None else json.loads(measured)
    if found and found["mesh"] == "arrays":
        found.update(vertices=len(np.asarray(vertices)), normals=estimated or ("averaged" if normals is None else "given"))
    return Shaded(codes, found)
