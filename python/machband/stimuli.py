"""A function for each kind of stimulus, which returns a `machband.Stimulus`.

Written by scripts/generate_stimuli.py; do not edit.
"""

# ruff: noqa: E501

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, TypedDict

from ._common import suggests
from ._stimulus import Stimulus

__all__ = ["chevreul", "cornsweet", "kanizsa", "mach_band", "shaded_cylinder", "shaded_mesh", "vasarely"]

Shader = Literal["flat", "gouraud", "phong", "quadratic", "fixed", "gradient", "gradient-repaired", "patch", "c1-phong"]
Shape = Literal["cube", "pyramid", "sphere", "uv-sphere", "torus", "jittered-torus", "blob", "terrain", "cylinder", "filleted-cylinder"]


class Parameters(TypedDict, total=False):
    """The parameters of all kinds of stimulus."""

    width: float
    depth: float | Literal["inf"]
    tanh_k: float
    orientation_deg: float
    low: float
    high: float
    color: str | Sequence[float]
    color_high: str | Sequence[float]
    space: Literal["rgb", "hsv", "lab"]
    rounding: float
    nulling: float
    steps: float
    exponent: float
    squares: float
    side: float
    radius: float
    shader: Shader
    boundary: float
    vertex: Literal["off", "printed", "repaired"]
    reweight: Literal["off", "printed", "repaired"]
    mesh: Shape
    vertices: float
    rotate: str | Sequence[float]
    light: str | Sequence[float]
    highlight: float
    background: float
    shading: Literal["flat", "gouraud", "phong"]
    facets: float


@suggests
def mach_band(
    *,
    width: float = 0.4,
    depth: float | Literal["inf"] = 1,
    tanh_k: float = 5,
    orientation_deg: float = 0,
    low: float = 0.25,
    high: float = 0.75,
    color: str | Sequence[float] = "yellow",
    color_high: str | Sequence[float] = "same",
    space: Literal["rgb", "hsv", "lab"] = "rgb",
    rounding: float = 0,
    nulling: float = 0,
    size: int | tuple[int, int] | None = None,
    ppd: float | None = None,
    visual_size: float | tuple[float, float] | None = None,
) -> Stimulus:
    """A ramp between two uniform areas: a bright line appears where it meets the bright area and a dark one where
    it meets the dark area, although neither is in the image. Mach 1865; Bangay §3.1.

    Parameters
    ----------
    width
        Proportion of the window that the ramp fills; 0 is a step. Expected: 0 to 1.
    depth
        Continuity depth n of the ramp: n − 1 derivatives vanish at its ends; inf is a scaled tanh. Expected: a
        whole number from 1 to 32, or inf.
    tanh_k
        Steepness k of a ramp of infinite depth: 5 as printed; 10 leaves no visible step at the ends. Expected:
        a steepness from 0.001 to 100, such as 5.
    orientation_deg
        Orientation, counterclockwise: 0 brightens to the right, 90 upward. Expected: an angle in degrees, such
        as 45.
    low
        Relative luminance of the darker plateau. Expected: 0 to 1.
    high
        Relative luminance of the brighter plateau. Expected: the relative luminance of the brighter plateau,
        not below low, 0 to 1.
    color
        Weights of red, green and blue in linear light. Expected: yellow, gray, red, green, blue, cyan, magenta,
        three numbers R,G,B from 0 to 1, not all 0, linear in light, #RRGGBB of sRGB, or hsv:H,S,V, hls:H,L,S,
        cmy:C,M,Y, cmyk:C,M,Y,K, xyY:x,y,Y, lab:L,a,b or luv:L,u,v.
    color_high
        Color of the brighter plateau; same means the color of the darker one. Expected: same, or any color that
        the darker plateau can have, such as red, 1,0.5,0 or hsv:30,1,1.
    space
        Color space in which the ramp is a straight line; rgb is linear light. Expected: rgb, hsv or lab.
    rounding
        Proportion of the window over which both corners of a ramp of depth 1 are rounded: the ramp is averaged
        over it. Expected: the proportion of the window over which the corners are rounded, 0 to 1.
    nulling
        Amplitude of a dark line at the bright end of the ramp and a bright one at its dark end, as a proportion
        of their difference. Expected: the amplitude of an opposite profile, from -1 to 1, with lines within the
        range of light.
    size
        Side in pixels, or height and width, as in `machband.Stimulus`.
    ppd
        Pixels per degree of visual angle.
    visual_size
        Degrees of visual angle of the longer side, or height and width [default: `size` / `ppd`, or 10].
    """
    return Stimulus("mach-band", width=width, depth=depth, tanh_k=tanh_k, orientation_deg=orientation_deg, low=low,
        high=high, color=color, color_high=color_high, space=space, rounding=rounding, nulling=nulling, size=size,
        ppd=ppd, visual_size=visual_size)


@suggests
def chevreul(
    *,
    steps: float = 5,
    orientation_deg: float = 0,
    low: float = 0.25,
    high: float = 0.75,
    color: str | Sequence[float] = "gray",
    size: int | tuple[int, int] | None = None,
    ppd: float | None = None,
    visual_size: float | tuple[float, float] | None = None,
) -> Stimulus:
    """Uniform bands that look scalloped: each looks brighter next to its darker neighbor and darker next to its
    brighter neighbor. Chevreul 1839.

    Parameters
    ----------
    steps
        Number of uniform bands. Expected: a whole number of bands, 2 to 256.
    orientation_deg
        Direction in which the bands brighten, counterclockwise from the right. Expected: an angle in degrees,
        such as 45.
    low
        Relative luminance of the darkest band. Expected: 0 to 1.
    high
        Relative luminance of the brightest band. Expected: the relative luminance of the brightest band, not
        below low, 0 to 1.
    color
        Weights of red, green and blue in linear light. Expected: yellow, gray, red, green, blue, cyan, magenta,
        three numbers R,G,B from 0 to 1, not all 0, linear in light, #RRGGBB of sRGB, or hsv:H,S,V, hls:H,L,S,
        cmy:C,M,Y, cmyk:C,M,Y,K, xyY:x,y,Y, lab:L,a,b or luv:L,u,v.
    size
        Side in pixels, or height and width, as in `machband.Stimulus`.
    ppd
        Pixels per degree of visual angle.
    visual_size
        Degrees of visual angle of the longer side, or height and width [default: `size` / `ppd`, or 10].
    """
    return Stimulus("chevreul", steps=steps, orientation_deg=orientation_deg, low=low, high=high, color=color,
        size=size, ppd=ppd, visual_size=visual_size)


@suggests
def cornsweet(
    *,
    width: float = 0.2,
    exponent: float = 1,
    orientation_deg: float = 0,
    low: float = 0.4,
    high: float = 0.6,
    color: str | Sequence[float] = "gray",
    size: int | tuple[int, int] | None = None,
    ppd: float | None = None,
    visual_size: float | tuple[float, float] | None = None,
) -> Stimulus:
    """Two areas of the same luminance; the edge between them makes one look brighter. Cover the edge with a finger
    to see that they are equal. Cornsweet 1970.

    Parameters
    ----------
    width
        Proportion of the window that the ramp fills on each side of the edge. Expected: the proportion of the
        window that each ramp fills, 0 to 0.5.
    exponent
        Exponent of the return to the mean: 1 is linear; larger values are steeper at the edge. Expected: an
        exponent such as 1 or 2.75, 0.1 to 20.
    orientation_deg
        Direction from the dark to the bright side of the edge, counterclockwise from the right. Expected: an
        angle in degrees, such as 45.
    low
        Relative luminance on the dark side of the edge. Expected: 0 to 1.
    high
        Relative luminance on the bright side of the edge. Expected: the relative luminance on the bright side,
        not below low, 0 to 1.
    color
        Weights of red, green and blue in linear light. Expected: yellow, gray, red, green, blue, cyan, magenta,
        three numbers R,G,B from 0 to 1, not all 0, linear in light, #RRGGBB of sRGB, or hsv:H,S,V, hls:H,L,S,
        cmy:C,M,Y, cmyk:C,M,Y,K, xyY:x,y,Y, lab:L,a,b or luv:L,u,v.
    size
        Side in pixels, or height and width, as in `machband.Stimulus`.
    ppd
        Pixels per degree of visual angle.
    visual_size
        Degrees of visual angle of the longer side, or height and width [default: `size` / `ppd`, or 10].
    """
    return Stimulus("cornsweet", width=width, exponent=exponent, orientation_deg=orientation_deg, low=low,
        high=high, color=color, size=size, ppd=ppd, visual_size=visual_size)


@suggests
def vasarely(
    *,
    squares: float = 12,
    orientation_deg: float = 0,
    low: float = 0.1,
    high: float = 0.9,
    color: str | Sequence[float] = "gray",
    size: int | tuple[int, int] | None = None,
    ppd: float | None = None,
    visual_size: float | tuple[float, float] | None = None,
) -> Stimulus:
    """Squares of graded luminance whose corners appear to form bright diagonals. Vasarely; Bangay fig. 1 j.

    Parameters
    ----------
    squares
        Number of nested squares. Expected: a whole number of squares, 2 to 256.
    orientation_deg
        Rotation of the squares, counterclockwise. Expected: an angle in degrees, such as 45.
    low
        Relative luminance of the outermost square. Expected: 0 to 1.
    high
        Relative luminance of the innermost square. Expected: the relative luminance of the innermost square,
        not below low, 0 to 1.
    color
        Weights of red, green and blue in linear light. Expected: yellow, gray, red, green, blue, cyan, magenta,
        three numbers R,G,B from 0 to 1, not all 0, linear in light, #RRGGBB of sRGB, or hsv:H,S,V, hls:H,L,S,
        cmy:C,M,Y, cmyk:C,M,Y,K, xyY:x,y,Y, lab:L,a,b or luv:L,u,v.
    size
        Side in pixels, or height and width, as in `machband.Stimulus`.
    ppd
        Pixels per degree of visual angle.
    visual_size
        Degrees of visual angle of the longer side, or height and width [default: `size` / `ppd`, or 10].
    """
    return Stimulus("vasarely", squares=squares, orientation_deg=orientation_deg, low=low, high=high, color=color,
        size=size, ppd=ppd, visual_size=visual_size)


@suggests
def kanizsa(
    *,
    side: float = 0.6,
    radius: float = 0.15,
    orientation_deg: float = 0,
    low: float = 0.1,
    high: float = 0.75,
    color: str | Sequence[float] = "gray",
    size: int | tuple[int, int] | None = None,
    ppd: float | None = None,
    visual_size: float | tuple[float, float] | None = None,
) -> Stimulus:
    """Three notched discs: a triangle seems to lie on top of them, brighter than the background. Kanizsa 1955.

    Parameters
    ----------
    side
        Side of the triangle as a proportion of the window. Expected: 0.05 to 1.
    radius
        Radius of the discs as a proportion of the window, at most half the triangle's side. Expected: 0.01 to
        0.5.
    orientation_deg
        Rotation of the triangle, counterclockwise. Expected: an angle in degrees, such as 45.
    low
        Relative luminance of the discs. Expected: 0 to 1.
    high
        Relative luminance of the background. Expected: the relative luminance of the background, not below low,
        0 to 1.
    color
        Weights of red, green and blue in linear light. Expected: yellow, gray, red, green, blue, cyan, magenta,
        three numbers R,G,B from 0 to 1, not all 0, linear in light, #RRGGBB of sRGB, or hsv:H,S,V, hls:H,L,S,
        cmy:C,M,Y, cmyk:C,M,Y,K, xyY:x,y,Y, lab:L,a,b or luv:L,u,v.
    size
        Side in pixels, or height and width, as in `machband.Stimulus`.
    ppd
        Pixels per degree of visual angle.
    visual_size
        Degrees of visual angle of the longer side, or height and width [default: `size` / `ppd`, or 10].
    """
    return Stimulus("kanizsa", side=side, radius=radius, orientation_deg=orientation_deg, low=low, high=high,
        color=color, size=size, ppd=ppd, visual_size=visual_size)


@suggests
def shaded_mesh(
    *,
    shader: Shader = "gouraud",
    depth: float | Literal["inf"] = 3,
    boundary: float = 0.2,
    vertex: Literal["off", "printed", "repaired"] = "off",
    reweight: Literal["off", "printed", "repaired"] = "off",
    mesh: Shape = "blob",
    vertices: float = 313,
    rotate: str | Sequence[float] = "25,-35,0",
    light: str | Sequence[float] = "0.36,0.48,0.8",
    highlight: float = 0.2,
    background: float = 0.05,
    low: float = 0.1,
    high: float = 0.7,
    color: str | Sequence[float] = "gray",
    size: int | tuple[int, int] | None = None,
    ppd: float | None = None,
    visual_size: float | tuple[float, float] | None = None,
) -> Stimulus:
    """A faceted surface that is shaded to look smooth: Gouraud shading produces Mach bands at the edges; other
    shaders change the luminance there to avoid them. Gouraud 1971; Bangay §4.

    Parameters
    ----------
    shader
        Shader. Expected: one of flat, gouraud, phong, quadratic, fixed, gradient, gradient-repaired, patch,
        c1-phong.
    depth
        Continuity depth n of the strips at the edges. Expected: a whole number from 1 to 32, or inf.
    boundary
        Width b of the strips at the edges, as a barycentric weight. Expected: a width from 0 to 1; values above
        1/3 act as 1/3.
    vertex
        Vertex shading, Bangay eq. 7. Expected: one of off, printed, repaired.
    reweight
        Intensity reweighting, Bangay eq. 9. Expected: one of off, printed, repaired.
    mesh
        Mesh. Expected: one of cube, pyramid, sphere, uv-sphere, torus, jittered-torus, blob, terrain, cylinder,
        filleted-cylinder.
    vertices
        Number of vertices; exact for a blob, approximate for other round shapes. Expected: a whole number from
        4 to 20000.
    rotate
        Rotation about x, then y, then z. Expected: three angles in degrees, such as 25,-35,0.
    light
        Direction toward the lamp: right, up, toward the viewer. Expected: a vector with a length from 1e-6 to
        1e6, such as 0.36,0.48,0.8.
    highlight
        Relative luminance added in the middle of a highlight. Expected: a relative luminance, 0 to 1.
    background
        Relative luminance of the background. Expected: a relative luminance, 0 to 1.
    low
        Relative luminance where only ambient light reaches the surface. Expected: 0 to 1.
    high
        Relative luminance where the lamp's light is at normal incidence. Expected: a relative luminance, not
        below low, 0 to 1.
    color
        Weights of red, green and blue in linear light. Expected: yellow, gray, red, green, blue, cyan, magenta,
        three numbers R,G,B from 0 to 1, not all 0, linear in light, #RRGGBB of sRGB, or hsv:H,S,V, hls:H,L,S,
        cmy:C,M,Y, cmyk:C,M,Y,K, xyY:x,y,Y, lab:L,a,b or luv:L,u,v.
    size
        Side in pixels, or height and width, as in `machband.Stimulus`.
    ppd
        Pixels per degree of visual angle.
    visual_size
        Degrees of visual angle of the longer side, or height and width [default: `size` / `ppd`, or 10].
    """
    return Stimulus("shaded-mesh", shader=shader, depth=depth, boundary=boundary, vertex=vertex, reweight=reweight,
        mesh=mesh, vertices=vertices, rotate=rotate, light=light, highlight=highlight, background=background,
        low=low, high=high, color=color, size=size, ppd=ppd, visual_size=visual_size)


@suggests
def shaded_cylinder(
    *,
    shading: Literal["flat", "gouraud", "phong"] = "gouraud",
    facets: float = 6,
    orientation_deg: float = 0,
    low: float = 0.25,
    high: float = 0.75,
    color: str | Sequence[float] = "gray",
    size: int | tuple[int, int] | None = None,
    ppd: float | None = None,
    visual_size: float | tuple[float, float] | None = None,
) -> Stimulus:
    """A faceted cylinder under flat, Gouraud or Phong shading: the source of Chevreul's scallops and Mach bands in
    computer graphics. Bangay fig. 1 c, f.

    Parameters
    ----------
    shading
        How the facets are shaded: flat, gouraud or phong. Expected: flat, gouraud or phong.
    facets
        Number of facets across the window. Expected: a whole number of facets, 1 to 256.
    orientation_deg
        Direction across the facets, counterclockwise from the right. Expected: an angle in degrees, such as 45.
    low
        Relative luminance of the rims. Expected: 0 to 1.
    high
        Relative luminance of the middle. Expected: the relative luminance of the middle, not below low, 0 to 1.
    color
        Weights of red, green and blue in linear light. Expected: yellow, gray, red, green, blue, cyan, magenta,
        three numbers R,G,B from 0 to 1, not all 0, linear in light, #RRGGBB of sRGB, or hsv:H,S,V, hls:H,L,S,
        cmy:C,M,Y, cmyk:C,M,Y,K, xyY:x,y,Y, lab:L,a,b or luv:L,u,v.
    size
        Side in pixels, or height and width, as in `machband.Stimulus`.
    ppd
        Pixels per degree of visual angle.
    visual_size
        Degrees of visual angle of the longer side, or height and width [default: `size` / `ppd`, or 10].
    """
    return Stimulus("shaded-cylinder", shading=shading, facets=facets, orientation_deg=orientation_deg, low=low,
        high=high, color=color, size=size, ppd=ppd, visual_size=visual_size)
