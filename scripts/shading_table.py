#!/usr/bin/env python3
"""How visible the errors of shaders are on meshes that machband does not know: an independent check of docs/shaders.md.

Nothing here comes from machband but the pictures of the shaders. The surfaces, their meshes, the camera, the light, the
smooth truth at each pixel, the decimation and the estimates of normals are computed here. The difference between a
picture and the truth is filtered by Barten's contrast sensitivity (1999) at 100 cd/m² and 10°; its root mean square
inside the outline is divided by Gouraud's. Prints Markdown tables.

    pip install numpy scipy
    python3 scripts/shading_table.py --machband target/release/machband [--out DIR]        # about five minutes
"""

import argparse
import subprocess
import tempfile
import zlib
from pathlib import Path

import numpy as np
from scipy.fft import irfft2, rfft2
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

SIDE, WINDOW_DEG, FILL, EROSION = 512, 10.0, 0.9, 4
AMBIENT, DIFFUSE, EXPONENT = 0.1, 0.6, 20
# Name, direction of the lamp, k_s: the scenes of docs/shaders.md.
SCENES = [
    ("highlight, lamp aside", (0.5, 0.5, 0.7), 0.3),
    ("the default scene", (0.36, 0.48, 0.8), 0.2),
    ("matte, lamp at the eye", (0.0, 0.0, 1.0), 0.0),
]
ROUND, FLAT = (25, -35, 0), (-35, 10, 20)


def unit(v):
    return v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-300)


def dot(a, b):
    return (a * b).sum(-1)


# Surfaces. A vertex has coordinates q: its position on an implicit surface, (u, v) on a parametric one.


class Implicit:
    """The points at which `f` is 0; slopes are central differences, exact to about ten digits."""

    def __init__(self, f):
        self.f = f

    def place(self, q):
        return q

    def slope(self, p, h=1e-5):
        return np.stack([(self.f(p + h * axis) - self.f(p - h * axis)) / (2 * h) for axis in np.eye(3)], -1)

    def normal(self, q):
        return unit(self.slope(q))

    def onto(self, q):
        """Moves points to the surface along the slope of `f`."""
        for _ in range(8):
            g = self.slope(q)
            q = q - (self.f(q) / np.maximum(dot(g, g), 1e-9))[..., None] * g
        return q

    def nearest(self, q, p):
        return self.onto(p)

    def hit(self, q, turn, aim):
        """Returns the point near `q` at which the line of sight through `aim` meets the surface, and if it does."""
        q = q + (aim - q @ turn[:2].T) @ turn[:2]
        for _ in range(14):
            rate = self.slope(q) @ turn[2]
            rate = np.where(np.abs(rate) < 1e-3, np.copysign(1e-3, rate), rate)
            q = q - np.clip(self.f(q) / rate, -0.03, 0.03)[:, None] * turn[2]
        return q, np.abs(self.f(q)) < 1e-8


class Parametric:
    """The points `p(u, v)`."""

    def __init__(self, p):
        self.p = p

    def place(self, q):
        return np.stack(np.broadcast_arrays(*self.p(q[..., 0], q[..., 1])), -1)

    def tangents(self, q, h=1e-6):
        return [(self.place(q + h * axis) - self.place(q - h * axis)) / (2 * h) for axis in np.eye(2)]

    def normal(self, q):
        return unit(np.cross(*self.tangents(q)))

    def onto(self, q):
        return q

    def nearest(self, q, p):
        for _ in range(6):
            a, b = self.tangents(q)
            off = p - self.place(q)
            aa, ab, bb, ao, bo = dot(a, a), dot(a, b), dot(b, b), dot(a, off), dot(b, off)
            step = np.stack([bb * ao - ab * bo, aa * bo - ab * ao], -1)
            q = q + np.clip(step / np.maximum(aa * bb - ab * ab, 1e-9)[:, None], -0.05, 0.05)
        return q

    def hit(self, q, turn, aim):
        for _ in range(14):
            off = self.place(q) @ turn[:2].T - aim
            (ax, ay), (bx, by) = [(t @ turn[:2].T).T for t in self.tangents(q)]
            area = ax * by - ay * bx
            area = np.where(np.abs(area) < 1e-6, 1e-6, area)
            step = np.stack([off[:, 0] * by - off[:, 1] * bx, ax * off[:, 1] - ay * off[:, 0]], -1) / area[:, None]
            q = q - np.clip(step, -0.05, 0.05)
        return q, np.abs(self.place(q) @ turn[:2].T - aim).max(-1) < 1e-8


def superellipsoid(p):
    return (np.abs(p / np.array([1.0, 0.8, 0.6])) ** 3.5).sum(-1) ** (1 / 3.5) - 1


def gyroid(p):
    x, y, z = np.moveaxis(3 * p, -1, 0)
    return (np.sin(x) * np.cos(y) + np.sin(y) * np.cos(z) + np.sin(z) * np.cos(x)) / 3


def metaballs(p):
    balls = [(-0.6, -0.1, 0, 4), (0.5, 0.35, 0.1, 5), (0.3, -0.5, 0.3, 7), (0, 0.2, -0.5, 8)]
    return 0.4 - sum(np.exp(-k * ((p - np.array(c)) ** 2).sum(-1)) for *c, k in balls)


def ripple(p):
    r = np.hypot(p[..., 0], p[..., 1] + 0.2)
    return p[..., 2] - 0.16 * np.cos(8 * r) / (1 + r * r)


def rounded_box(p, half=(0.8, 0.6, 0.5), r=0.1):
    return np.linalg.norm(np.maximum(np.abs(p) - (np.array(half) - r), 0), axis=-1) - r


def capsule(p):
    return np.linalg.norm(p - np.clip(p, [0, -0.7, 0], [0, 0.7, 0]), axis=-1) - 0.5


def cyclide(p, a=1.0, b=0.97, d=0.42):
    x, y, z = np.moveaxis(p, -1, 0)
    return ((x * x + y * y + z * z + b * b - d * d) ** 2 - 4 * (a * x - (a * a - b * b) ** 0.5 * d) ** 2 - 4 * b * b * y * y) / 3


def bumpy(p):
    x, y, z = np.moveaxis(p, -1, 0)
    return np.linalg.norm(p, axis=-1) - 1 - 0.1 * np.sin(5 * x + 1) * np.sin(4 * y) * np.cos(4 * z - 1)


def saddle(p):
    x, y, z = np.moveaxis(p, -1, 0)
    return z - 0.35 * (x**3 - 3 * x * y * y) + 0.1 * y * y


def enneper(u, v):
    return u - u**3 / 3 + u * v * v, v - v**3 / 3 + v * u * u, u * u - v * v


def knot(u, v):
    """A tube around a trefoil."""
    a, b = 2 * np.pi * u, 2 * np.pi * v
    path = lambda t: np.stack([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -1.2 * np.sin(3 * t)], -1)
    along = unit(path(a + 1e-4) - path(a - 1e-4))
    out = unit(np.cross(along, [0.0, 0.0, 1.0]))
    return tuple(np.moveaxis(path(a) + 0.5 * (np.cos(b)[..., None] * out + np.sin(b)[..., None] * np.cross(along, out)), -1, 0))


# The outline of a turned body from the bottom of its axis: lengths, and the angles in degrees by which arcs turn.
OUTLINE = np.array([(0.6, 0), (0.2, 90), (0.3, 0), (0.15, 50), (0.5, 0), (0.2, -50), (0.4, 0), (0.15, -50), (0.35, 0), (0.15, 50),
                    (0.2, 0), (0.2, 90), (0.46465, 0)])
ENDS = np.cumsum(np.append(0, OUTLINE[:, 0]))


def outline(v):
    """The radius and height after the length v."""
    start, angle, found = np.zeros(2), 0.0, np.zeros(np.shape(v) + (2,))
    for (length, turn), begin in zip(OUTLINE, ENDS):
        bend, s = np.radians(turn) / length, np.clip(v - begin, 0, None)
        # The integral of (cos, sin) of the angle at each length.
        along = lambda s: s[..., None] * np.sinc(bend * s / (2 * np.pi))[..., None] * np.stack(
            [np.cos(angle + bend * s / 2), np.sin(angle + bend * s / 2)], -1)
        found = np.where((v >= begin)[..., None], start + along(s), found)
        start, angle = start + along(np.array(length)), angle + np.radians(turn)
    return found


def lathe(u, v):
    r, y = np.moveaxis(outline(v), -1, 0)
    return r * np.sin(2 * np.pi * u), y, r * np.cos(2 * np.pi * u)


def detailed(f, amount, unit_length):
    """Adds waves of random directions, 0.1 to 0.45 long, as scans have; `amount` is the height of the longest."""
    random, lengths = np.random.default_rng(5), np.geomspace(0.1, 0.45, 14)
    waves = 2 * np.pi * unit(random.normal(size=(14, 3))) / lengths[:, None] / unit_length
    heights, phases = amount * (lengths / 0.45) ** 1.5, random.uniform(0, 2 * np.pi, 14)
    return lambda p: f(p) + sum(h * np.sin(p @ w + s) for w, h, s in zip(waves, heights, phases))


# Meshes: coordinates and triangles.


def grid(us, vs, jitter=0.0):
    """Triangles over a grid; diagonals alternate; `jitter` moves inner points by a share of a cell."""
    random = np.random.default_rng(3)
    q = np.stack(np.meshgrid(us, vs, indexing="ij"), -1)
    cell = np.array([us[1] - us[0], vs[1] - vs[0]])
    q[1:-1, 1:-1] += random.uniform(-jitter, jitter, q[1:-1, 1:-1].shape) * cell
    at = np.arange(len(us) * len(vs)).reshape(len(us), len(vs))
    a, b, c, d = (x.ravel() for x in (at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]))
    even = (np.add.outer(np.arange(len(us) - 1), np.arange(len(vs) - 1)) % 2 == 0).ravel()[:, None]
    first, second = np.where(even, np.stack([a, b, c], 1), np.stack([a, b, d], 1)), np.where(even, np.stack([a, c, d], 1), np.stack([b, c, d], 1))
    return q.reshape(-1, 2), np.concatenate([first, second])


def icosphere(times):
    t = (1 + 5**0.5) / 2
    p = unit(np.array([(-1, t, 0), (1, t, 0), (-1, -t, 0), (1, -t, 0), (0, -1, t), (0, 1, t), (0, -1, -t), (0, 1, -t),
                       (t, 0, -1), (t, 0, 1), (-t, 0, -1), (-t, 0, 1)]))
    f = np.array([(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2),
                  (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11),
                  (6, 2, 10), (8, 6, 7), (9, 8, 1)])
    for _ in range(times):
        p, f = split(p, f)
        p = unit(p)
    return p, f


def split(q, f):
    """Cuts each triangle into four, at the middles of the edges."""
    pairs = np.sort(f[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), 1)
    edges, which = np.unique(pairs, axis=0, return_inverse=True)
    x, y, z = (len(q) + which.reshape(-1, 3)).T
    a, b, c = f.T
    return np.concatenate([q, q[edges].mean(1)]), np.concatenate(
        [np.stack(t, 1) for t in [(a, x, z), (b, y, x), (c, z, y), (x, y, z)]])


def radial(f, directions):
    """Moves points of a star-shaped surface's directions onto it."""
    low, high = np.full(len(directions), 0.01), np.full(len(directions), 3.0)
    for _ in range(50):
        middle = (low + high) / 2
        inside = f(directions * middle[:, None]) < 0
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    return directions * low[:, None]


def marched(f, low, high, step):
    """Marching tetrahedra over a box."""
    axes = [np.arange(a, b + step / 2, step) for a, b in zip(low, high)]
    places = np.stack(np.meshgrid(*axes, indexing="ij"), -1)
    shape, values = places.shape[:3], f(places).ravel()
    at = np.arange(values.size).reshape(shape)
    corner = lambda i: at[tuple(slice(1, None) if i >> k & 1 else slice(None, -1) for k in range(3))].ravel()
    tetra = np.concatenate([np.stack([corner(i) for i in (0, a, b, 7)], 1)
                            for a, b in [(1, 3), (3, 2), (2, 6), (6, 4), (4, 5), (5, 1)]])
    order = np.argsort(values[tetra], axis=1, kind="stable")
    tetra, inside = np.take_along_axis(tetra, order, 1), (values[tetra] < 0).sum(1)
    cut = {1: [[(0, 1), (0, 2), (0, 3)]], 3: [[(0, 3), (1, 3), (2, 3)]],
           2: [[(0, 2), (0, 3), (1, 3)], [(0, 2), (1, 3), (1, 2)]]}
    corners = np.concatenate([tetra[inside == n][:, t] for n, ts in cut.items() for t in ts])
    ends, which = np.unique(np.sort(corners.reshape(-1, 2), 1), axis=0, return_inverse=True)
    a, b = values[ends].T
    share = np.clip(a / (a - b), 0.02, 0.98)[:, None]
    p = places.reshape(-1, 3)
    p = p[ends[:, 0]] * (1 - share) + p[ends[:, 1]] * share
    faces = which.reshape(-1, 3)
    outward = dot(face_normals(p, faces), Implicit(f).slope(p[faces].mean(1))) > 0
    faces[~outward] = faces[~outward][:, [0, 2, 1]]
    return p, faces


def face_normals(p, f):
    a, b, c = p[f[:, 0]], p[f[:, 1]], p[f[:, 2]]
    return np.cross(b - a, c - a)


def compact(p, f):
    used, f = np.unique(f, return_inverse=True)
    return p[used], f.reshape(-1, 3)


def edges_of(f):
    pairs = np.sort(f[:, [[1, 2], [2, 0], [0, 1]]].reshape(-1, 2), 1)
    return np.unique(pairs, axis=0, return_inverse=True, return_counts=True)


def decimated(p, f, target):
    """Collapses the edges with the least quadric error (Garland and Heckbert 1997), many that are apart at a time."""
    p, f = p.copy(), f.copy()
    n = face_normals(p, f)
    area = np.linalg.norm(n, axis=1) / 2
    plane = np.concatenate([unit(n), -dot(unit(n), p[f[:, 0]])[:, None]], 1)
    quadrics = np.zeros((len(p), 4, 4))
    each = area[:, None, None] * plane[:, :, None] * plane[:, None]
    for k in range(3):
        np.add.at(quadrics, f[:, k], each)
    edges, which, count = edges_of(f)
    # A plane through each border edge, perpendicular to its face, keeps the border in place.
    for e in np.flatnonzero(count[which] == 1):
        a, b = p[edges[which[e]]]
        m = unit(np.cross(b - a, n[e // 3]))
        row = np.append(m, -m @ a)
        for v in edges[which[e]]:
            quadrics[v] += 10 * ((b - a) @ (b - a)) * np.outer(row, row)
    banned, stuck = np.zeros(0, np.int64), 0
    while len(f) > target:
        edges, which, count = edges_of(f)
        a, b = edges.T
        both, middle = quadrics[a] + quadrics[b], p[edges].mean(1)
        weak = 1e-3 * np.trace(both[:, :3, :3], axis1=1, axis2=2)[:, None, None] * np.eye(3)
        place = np.linalg.solve(both[:, :3, :3] + weak, (weak @ middle[..., None])[..., 0][..., None] - both[:, :3, 3:])[..., 0]
        full = np.append(place, np.ones((len(a), 1)), 1)
        cost = np.einsum("ei,eij,ej->e", full, both, full)
        adjacent = coo_matrix((np.ones(len(a)), (a, b)), (len(p), len(p))).tocsr()
        adjacent = adjacent + adjacent.T
        common = np.asarray((adjacent @ adjacent)[a, b]).ravel()
        allowed = (common == count) & ~np.isin(a * len(p) + b, banned)
        rank = np.empty(len(a))
        rank[np.argsort(np.where(allowed, cost, np.inf), kind="stable")] = np.arange(len(a))
        least = np.full(len(p), np.inf)
        np.minimum.at(least, a, rank)
        np.minimum.at(least, b, rank)
        ring = least.copy()
        np.minimum.at(ring, a, least[b])
        np.minimum.at(ring, b, least[a])
        chosen = allowed & (rank <= np.minimum(ring[a], ring[b])) & (rank < 0.25 * len(a))
        chosen = np.flatnonzero(chosen)
        chosen = chosen[np.argsort(rank[chosen])][: max(1, (len(f) - target + 1) // 2)]
        if not len(chosen):
            if not len(banned) or len(f) == stuck:
                break
            banned, stuck = banned[:0], len(f)
            continue
        # No face may turn over or become a needle.
        moved, of = p.copy(), np.full(len(p), -1)
        for end in (a, b):
            moved[end[chosen]], of[end[chosen]] = place[chosen], chosen
        owner = of[f].max(1)
        stays = (of[f] == owner[:, None]).sum(1) == 1
        before, after = face_normals(p, f), face_normals(moved, f)
        width = [np.linalg.norm(n, axis=1) / sum(((at[f[:, k]] - at[f[:, k - 1]]) ** 2).sum(1) for k in range(3))
                 for at, n in [(p, before), (moved, after)]]
        bad = (dot(unit(before), unit(after)) < 0.2) | (width[1] < np.minimum(0.015, 0.5 * width[0]))
        refused = np.unique(owner[(owner >= 0) & stays & bad])
        banned = np.append(banned, a[refused] * len(p) + b[refused])
        good = np.setdiff1d(chosen, refused)
        p[a[good]] = place[good]
        quadrics[a[good]] = both[good]
        to = np.arange(len(p))
        to[b[good]] = a[good]
        f = to[f]
        f = f[(f[:, 0] != f[:, 1]) & (f[:, 1] != f[:, 2]) & (f[:, 2] != f[:, 0])]
    return compact(p, f)


# Camera, light and pictures.


def rotation(degrees):
    (cx, cy, cz), (sx, sy, sz) = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return z @ y @ x


class View:
    """Parallel projection; the sphere around the box of `p` fills 0.9 of the picture."""

    def __init__(self, p, degrees):
        self.center = (p.min(0) + p.max(0)) / 2
        self.radius = np.linalg.norm(p - self.center, axis=1).max()
        self.degrees, self.turn = degrees, rotation(degrees)

    def eye(self, p):
        return (p - self.center) @ self.turn.T / self.radius

    def aims(self):
        """What the pixels show, as places along the first two axes of the rotation, in mesh units."""
        across = (np.arange(SIDE) + 0.5 - SIDE / 2) / (SIDE * FILL / 2)
        xy = np.stack(np.meshgrid(across, -across), -1)
        return xy * self.radius + self.turn[:2] @ self.center

    def raster(self, p, f):
        """The triangle that each pixel shows (−1 for none), its weights there, and the depth toward the eye."""
        e = self.eye(p)
        s = np.stack([SIDE / 2 + e[:, 0] * SIDE * FILL / 2, SIDE / 2 - e[:, 1] * SIDE * FILL / 2], 1)
        seen, depth, weights = np.full((SIDE, SIDE), -1), np.full((SIDE, SIDE), -np.inf), np.zeros((SIDE, SIDE, 3))
        corners, heights = s[f], e[f, 2]
        low = np.clip(np.ceil(corners.min(1) - 0.5).astype(int), 0, SIDE)
        high = np.clip(np.floor(corners.max(1) - 0.5).astype(int) + 1, 0, SIDE)
        area = np.cross(np.pad(corners[:, 1] - corners[:, 0], ((0, 0), (0, 1))), np.pad(corners[:, 2] - corners[:, 0], ((0, 0), (0, 1))))[:, 2]
        for t in np.flatnonzero(((high - low).min(1) > 0) & (np.abs(area) > 1e-12)):
            (x0, y0), (x1, y1), (a, b, c) = low[t], high[t], corners[t]
            x, y = np.arange(x0, x1)[None] + 0.5, np.arange(y0, y1)[:, None] + 0.5
            wb = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / area[t]
            wc = ((y - a[1]) * (b[0] - a[0]) - (x - a[0]) * (b[1] - a[1])) / area[t]
            wa = 1 - wb - wc
            z = wa * heights[t, 0] + wb * heights[t, 1] + wc * heights[t, 2]
            box = np.s_[y0:y1, x0:x1]
            new = (wa >= 0) & (wb >= 0) & (wc >= 0) & (z > depth[box])
            seen[box][new], depth[box][new] = t, z[new]
            weights[box][new] = np.stack([wa, wb, wc], -1)[new]
        return seen, weights, depth

    def lit(self, normals, scene):
        """The light from points with these normals, which are turned toward the eye."""
        n = normals @ self.turn.T
        n = np.where(n[..., 2:] < 0, -n, n)
        _, lamp, specular = scene
        lamp = unit(np.array(lamp))
        cosine = n @ lamp
        mirrored = 2 * n[..., 2] * cosine - lamp[2]
        return AMBIENT + np.where(cosine > 0, DIFFUSE * cosine + specular * np.clip(mirrored, 0, None) ** EXPONENT, 0)


class Truth:
    """The surface seen through each pixel, found from a fine mesh (q, f) of it."""

    def __init__(self, surface, q, f, view):
        seen, weights, depth = view.raster(surface.place(q), f)
        self.inside = seen >= 0
        start = (q[f[seen[self.inside]]] * weights[self.inside][..., None]).sum(1)
        found, good = surface.hit(start, view.turn, view.aims()[self.inside])
        self.normals, self.depth = np.zeros((SIDE, SIDE, 3)), np.full((SIDE, SIDE), -9.0)
        self.normals[self.inside] = surface.normal(found)
        self.depth[self.inside] = view.eye(surface.place(found))[:, 2]
        self.inside[self.inside] = good & (np.abs(self.depth - depth)[self.inside] < 0.05)
        self.view = view

    def mask(self, seen, depth):
        """Pixels that are neither near an outline of the mesh or the surface nor where one hides itself."""
        mask = self.inside & (seen >= 0) & (np.abs(depth - self.depth) < 0.1)
        for axis in (0, 1):
            jump = np.abs(np.diff(self.depth, axis=axis)) > 0.06
            mask &= ~np.pad(jump, [(1, 0) if a == axis else (0, 0) for a in (0, 1)])
        for _ in range(EROSION):
            near = np.pad(mask, 1)
            mask = mask & near[2:, 1:-1] & near[:-2, 1:-1] & near[1:-1, 2:] & near[1:-1, :-2]
        return mask

    def light(self, scene):
        return self.view.lit(self.normals, scene)


def sensitivity():
    """Barten's formula for 100 cd/m² and a field of 10°, relative to its largest value."""
    size = 2 * SIDE
    u = np.hypot(np.fft.fftfreq(size)[:, None], np.fft.rfftfreq(size)) * SIDE / WINDOW_DEG
    u[0, 0] = 1e-3
    light, field = 100.0, 10.0  # cd/m², degrees
    gain = 5200 * np.exp(-0.0016 * u**2 * (1 + 100 / light) ** 0.08) / np.sqrt(
        (1 + 144 / field**2 + 0.64 * u**2) * (63 / light**0.83 + 1 / (1 - np.exp(-0.02 * u**2))))
    return gain / gain.max()


GAIN = sensitivity()


def residual(picture, truth, mask):
    """The root mean square of the filtered difference, and the 99.9th percentile of the difference itself."""
    difference = np.where(mask, picture - truth, 0)
    filtered = irfft2(rfft2(difference, GAIN.shape[:1] * 2, workers=2) * GAIN, GAIN.shape[:1] * 2, workers=2)[:SIDE, :SIDE]
    return np.sqrt((filtered[mask] ** 2).mean()), np.percentile(np.abs(difference[mask]), 99.9)


def write_obj(path, p, f, normals, view):
    """Writes a mesh, with four invisible specks that make machband fit the same sphere as `view`."""
    speck = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]) * 1e-7 * view.radius
    specks = [view.center + side * axis * view.radius - side * speck for axis in np.eye(3) for side in (1, -1)]
    points = np.concatenate([p, *specks])
    faces = np.concatenate([f, *(len(p) + 4 * i + np.array([(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]) for i in range(6))])
    lines = ["v %.17g %.17g %.17g" % tuple(v) for v in points]
    if normals is not None:
        lines += ["vn %.17g %.17g %.17g" % tuple(n) for n in np.concatenate([normals, np.tile([0.0, 0, 1], (24, 1))])]
    pattern = "f %d//%d %d//%d %d//%d" if normals is not None else "f %d %d %d"
    lines += [pattern % tuple(np.repeat(t + 1, 2 if normals is not None else 1)) for t in faces]
    Path(path).write_text("\n".join(lines) + "\n")


def read_png(data):
    """Returns the values of a gray 16-bit PNG whose rows are stored plain or as the difference from the row above."""
    at, packed, header = 8, b"", None
    while at < len(data):
        length = int.from_bytes(data[at : at + 4], "big")
        body = data[at + 8 : at + 8 + length]
        packed += body if data[at + 4 : at + 8] == b"IDAT" else b""
        header = body if data[at + 4 : at + 8] == b"IHDR" else header
        at += 12 + length
    assert header[8:10] == b"\x10\x00", "not a gray 16-bit PNG"
    rows = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(int.from_bytes(header[4:8], "big"), -1)
    kinds, values = rows[:, 0], rows[:, 1:].copy()
    assert np.isin(kinds, (0, 2)).all(), "unknown filter"
    for y in np.flatnonzero(kinds == 2):
        values[y] += values[y - 1] if y else 0
    return values.reshape(len(rows), -1, 2) @ np.array([256, 1]) / 65535


class Program:
    def __init__(self, path, folder):
        self.path, self.folder = Path(path).resolve(), Path(folder)

    def draw(self, obj, shader, scene, view, normals="given"):
        out, listed = self.folder / "picture.png", lambda values: ",".join(map(str, values))
        _, lamp, specular = scene
        words = [self.path, "shade", "--mesh", obj, "--shader", shader, "--normals", normals, "--rotate", listed(view.degrees),
                 "--light", listed(lamp), "--ambient", AMBIENT, "--diffuse", DIFFUSE, "--specular", specular, "--shininess",
                 EXPONENT, "--size", SIDE, "--bits", 16, "--transfer", "linear", "--out", out, "--force"]
        subprocess.run(list(map(str, words)), check=True, capture_output=True)
        return read_png(out.read_bytes())


# Estimated normals.


def corner_means(p, f, weight):
    """The normal at each vertex: the sum of a × b over the triangles' sides there, times a weight."""
    sums = np.zeros((len(p), 3))
    for k in range(3):
        a, b = p[f[:, (k + 1) % 3]] - p[f[:, k]], p[f[:, (k + 2) % 3]] - p[f[:, k]]
        n = np.cross(a, b)
        np.add.at(sums, f[:, k], weight(np.linalg.norm(n, axis=1), dot(a, b))[:, None] * n)
    return unit(sums)


by_angle = lambda p, f: corner_means(p, f, lambda area, cosine: np.arctan2(area, cosine) / np.maximum(area, 1e-300))
by_area = lambda p, f: corner_means(p, f, lambda area, _: np.ones_like(area))


def rings(p, f):
    """The neighbors of each vertex, filled up with −1."""
    edges = edges_of(f)[0]
    pairs = np.concatenate([edges, edges[:, ::-1]])
    pairs = pairs[np.argsort(pairs[:, 0], kind="stable")]
    counts = np.bincount(pairs[:, 0], minlength=len(p))
    ring = np.full((len(p), counts.max()), -1)
    ring[pairs[:, 0], np.arange(len(pairs)) - np.repeat(np.cumsum(counts) - counts, counts)] = pairs[:, 1]
    return ring


def weighed(p, f, tolerance=np.radians(4), passes=2):
    """Between the mean by area and a cubic fitted to the neighbors' positions and normals, which counts as far as it
    fits them: by t²/(t² + e²), where e is the root mean square by which it misses the slopes at the neighbors."""
    base, normals, ring = by_area(p, f), by_angle(p, f), rings(p, f)
    known, others = ring >= 0, np.maximum(ring, 0)
    for _ in range(passes):
        side = np.where(np.abs(normals[:, :1]) < 0.7, [[1.0, 0, 0]], [[0, 1.0, 0]])
        right = unit(np.cross(normals, side))
        up = np.cross(normals, right)
        frame = np.stack([right, up, normals], 1)
        steps = np.einsum("vij,vmj->vmi", frame, p[others] - p[:, None])
        facing = np.einsum("vij,vmj->vmi", frame, normals[others])
        size = np.sqrt(((steps[..., :2] ** 2).sum(-1) * known).sum(1) / known.sum(1))
        used = known & (facing[..., 2] > 0.2)
        x, y, z = np.moveaxis(steps / size[:, None, None], -1, 0)
        d, o, i = np.maximum(np.hypot(x, y), 1e-6), np.zeros_like(x), np.ones_like(x)
        slopes = -facing[..., :2] / np.where(used, facing[..., 2], 1)[..., None]
        rows = np.stack([np.stack([x, y, x * x, x * y, y * y, x**3, x * x * y, x * y * y, y**3], -1),
                         np.stack([i, o, 2 * x, y, o, 3 * x * x, 2 * x * y, y * y, o], -1),
                         np.stack([o, i, o, x, 2 * y, o, x * x, 2 * x * y, 3 * y * y], -1)], 2)
        weights = np.stack([d**-3, d**-2, d**-2], -1) * used[..., None]
        values = np.stack([z, slopes[..., 0], slopes[..., 1]], -1)
        matrix = np.einsum("vmri,vmr,vmrj->vij", rows, weights**2, rows, optimize=True)
        spread = np.linalg.eigvalsh(matrix)
        solvable = (used.sum(1) >= 4) & (spread[:, 0] > 1e-10 * spread[:, -1])
        right_side = np.einsum("vmri,vmr->vi", rows, values * weights**2)
        solved = np.linalg.solve(np.where(solvable[:, None, None], matrix, np.eye(9)), right_side[..., None])[..., 0]
        missed = ((values - np.einsum("vmri,vi->vmr", rows, solved))[..., 1:] ** 2).sum(-1)
        error = (missed * used).sum(1) / np.maximum(used.sum(1), 1)
        share = np.where(solvable, tolerance**2 / (tolerance**2 + error), 0)[:, None]
        cubic = unit(normals - right * solved[:, :1] - up * solved[:, 1:2])
        normals = unit(share * cubic + (1 - share) * base)
    return normals


# The surfaces and meshes of the tables.


def welded(p, f):
    """Merges vertices in one place; returns which ones stay, and the triangles that keep an area."""
    pairs = cKDTree(p).query_pairs(1e-4 * np.ptp(p, axis=0).max(), output_type="ndarray")
    _, label = connected_components(coo_matrix((np.ones(len(pairs)), pairs.T), (len(p), len(p))), directed=False)
    _, first = np.unique(label, return_index=True)
    f = label[f]
    return first, f[(f[:, 0] != f[:, 1]) & (f[:, 1] != f[:, 2]) & (f[:, 2] != f[:, 0])]


class Sampled:
    """A mesh whose vertices lie on a surface, refined `times` times on it."""

    def __init__(self, surface, q, f, times=0):
        for _ in range(times):
            q, f = split(q, f)
            q = surface.onto(q)
        self.surface, self.q, self.f = surface, q, f

    def solid(self):
        """Positions, triangles and normals for a file."""
        first, f = welded(self.surface.place(self.q), self.f)
        p, n = self.surface.place(self.q[first]), self.surface.normal(self.q[first])
        faces = face_normals(p, f)
        if isinstance(self.surface, Implicit):
            f = np.where((dot(faces, n[f].sum(1)) < 0)[:, None], f[:, [0, 2, 1]], f)
        elif (edges_of(f)[2] == 2).all() and dot(p[f[:, 0]], faces).sum() < 0:
            f = f[:, [0, 2, 1]]
        return p, f, n * np.where(dot(n, by_area(p, f)) < 0, -1, 1)[:, None]


def lifted(f):
    """Height fields: puts points of the plane onto the surface z = h(x, y)."""
    return lambda q: np.stack([q[:, 0], q[:, 1], -f(np.append(q, np.zeros((len(q), 1)), 1))], 1)


BOXES = {superellipsoid: 1.1, gyroid: 1.0, metaballs: 1.5, rounded_box: 0.9, capsule: 1.3, cyclide: 1.95, bumpy: 1.3, ripple: 1.0}


def dense(f, shape=None):
    """40,000 to 70,000 triangles of a surface in BOXES, or of `shape`, which lies near it."""
    high = np.full(3, BOXES[f]) * {cyclide: [1, 1, 0.5], ripple: [1, 1, 0.5]}.get(f, 1)
    is_cut = f in (gyroid, ripple)
    high = high if is_cut else high + 0.06
    p, faces = marched(shape or f, -high, high, 0.05 if f is cyclide else BOXES[f] / 28)
    return (p if is_cut else Implicit(shape or f).onto(p)), faces


def box_mesh(parts=4, half=(0.8, 0.6, 0.5), r=0.1):
    """As in three.js: `parts` cells across each rounding, and one across each flat side."""
    line = np.append(np.linspace(-1, 0, parts + 1), np.linspace(0, 1, parts + 1))
    signs = np.append(-np.ones(parts + 1), np.ones(parts + 1))
    index, f = grid(np.arange(2.0 * parts + 2), np.arange(2.0 * parts + 2))
    index, points, faces = index.astype(int), [], []
    for axis in range(3):
        for side in (-1, 1):
            out, sign = np.empty((len(index), 3)), np.empty((len(index), 3))
            for k, column in ((0, axis), (1, (axis + 1) % 3), (2, (axis + 2) % 3)):
                out[:, column] = side if k == 0 else line[index[:, k - 1]]
                sign[:, column] = side if k == 0 else signs[index[:, k - 1]]
            faces.append(f + len(points) * len(index))
            points.append(sign * (np.array(half) - r) + r * unit(out))
    return np.concatenate(points), np.concatenate(faces)


def surfaces():
    """Name, surface, the coordinates and triangles of its mesh, and the rotation."""
    ring = lambda n: np.linspace(0, 1, n + 1)
    sphere, square = icosphere(3), lambda n, size=1: grid(*2 * [np.linspace(-size, size, n)], 0.3)
    for name, f in [("superellipsoid", superellipsoid), ("bumpy sphere", bumpy)]:
        yield name, Implicit(f), (radial(f, sphere[0]), sphere[1]), ROUND
    for name, f in [("gyroid", gyroid), ("metaballs", metaballs)]:
        p, faces = decimated(*dense(f), 1200)
        yield name, Implicit(f), (Implicit(f).onto(p), faces), ROUND
    for name, f, n in [("ripple", ripple, 26), ("monkey saddle", saddle, 18)]:
        q, faces = square(n)
        yield name, Implicit(f), (lifted(f)(q), faces), FLAT
    yield "Enneper", Parametric(enneper), square(24, 1.1), FLAT
    yield "rounded box", Implicit(rounded_box), box_mesh(), ROUND
    yield "knot", Parametric(knot), grid(ring(72), ring(10)), ROUND
    turns = np.linspace(0, np.pi / 2, 6)
    profile = np.array([(0.5 * np.sin(a), 0.7 + 0.5 * np.cos(a)) for a in turns])
    profile = np.concatenate([profile, profile[::-1] * (1, -1)])
    index, faces = grid(np.arange(25.0), np.arange(12.0))
    (r, y), a = profile[index[:, 1].astype(int)].T, 2 * np.pi * index[:, 0] / 24
    yield "capsule", Implicit(capsule), (np.stack([r * np.sin(a), y, r * np.cos(a)], 1), faces), ROUND
    heights = np.concatenate([np.linspace(s, e, 3)[:-1] for s, e in zip(ENDS, ENDS[1:])] + [ENDS[-1:]])
    heights[[0, -1]] += 1e-5, -1e-5
    yield "lathe with bevels", Parametric(lathe), grid(ring(28), heights), ROUND
    q, faces = grid(2 * np.pi * ring(48), 2 * np.pi * ring(14))
    a, b, c, d = 1.0, 0.97, (1 - 0.97**2) ** 0.5, 0.42
    (cu, cv), (su, sv) = np.cos(q).T, np.sin(q).T
    p = np.stack([d * (c - a * cu * cv) + b * b * cu, b * su * (a - d * cv), b * sv * (c * cu - d)], 1) / (a - c * cu * cv)[:, None]
    yield "Dupin cyclide", Implicit(cyclide), (p, faces), ROUND


# The tables.


def span(values):
    values = np.array(values)
    return f"{values.min():.3f}–{values.max():.3f} ({np.median(values):.3f})"


class Drawing:
    """Draws meshes of one surface in one view, and compares the pictures with the truth."""

    def __init__(self, program, truth, p, f):
        self.program, self.truth, self.view = program, truth, truth.view
        self.seen, self.weights, depth = self.view.raster(p, f)
        self.mask = truth.mask(self.seen, depth)

    def judged(self, rows):
        """For each scene and row (a shader, normals, positions, triangles and normals, or the normals of each pixel),
        returns the residual and the percentile."""
        files, results = {}, []
        for scene in SCENES:
            light, of_scene = self.truth.light(scene), {}
            for name, row in rows.items():
                if isinstance(row, np.ndarray):
                    picture = self.view.lit(row, scene)
                else:
                    shader, kind, mesh = row
                    if id(mesh) not in files:
                        files[id(mesh)] = self.program.folder / f"mesh{len(files)}.obj"
                        write_obj(files[id(mesh)], *mesh, self.view)
                    picture = self.program.draw(files[id(mesh)], shader, scene, self.view, kind)
                of_scene[name] = residual(picture, light, self.mask)
            results.append(of_scene)
        return results


def shaders_table(program):
    """Returns the drawings, for the table of normals."""
    found, drawings = [], []
    for name, surface, (q, f), degrees in surfaces():
        fine = Sampled(surface, q, f, 2)
        view = View(surface.place(fine.q), degrees)
        mesh, finer = Sampled(surface, q, f).solid(), Sampled(surface, q, f, 1).solid()
        drawing = Drawing(program, Truth(surface, fine.q, fine.f, view), surface.place(q), f)
        at = drawing.seen >= 0
        baked = np.zeros((SIDE, SIDE, 3))
        between = lambda values: (values[f[drawing.seen[at]]] * drawing.weights[at][..., None]).sum(1)
        baked[at] = surface.normal(surface.nearest(between(q), between(surface.place(q))))
        rows = {"`gouraud`": ("gouraud", "given", mesh), "`phong`": ("phong", "given", mesh),
                "`patch`": ("patch", "given", mesh), "`c1-phong`": ("c1-phong", "given", mesh),
                "`phong`, 4 × the triangles": ("phong", "given", finer),
                "`c1-phong`, 4 × the triangles": ("c1-phong", "given", finer),
                "`phong` with an ideal normal map": baked}
        for scene, results in zip(SCENES, drawing.judged(rows)):
            found.append((f"{name}, {len(mesh[1])}", scene[0], results))
        drawings.append((drawing, mesh[0], mesh[1]))
    names = list(found[0][2])[1:]
    over = lambda results, name, k=0: results[name][k] / results["`gouraud`"][k]
    print("Range (median) of the residual over", len(drawings), "surfaces, relative to Gouraud's:\n")
    print("| shader | " + " | ".join(scene[0] for scene in SCENES) + " | 99.9th percentile, all |\n" + "|---" * 5 + "|")
    for name in names:
        cells = [span([over(r, name) for _, scene, r in found if scene == of[0]]) for of in SCENES]
        print(f"| {name} | " + " | ".join(cells) + f" | {span([over(r, name, 1) for *_, r in found])} |")
    print("\n| mesh, triangles | " + " | ".join(names) + " |\n" + "|---" * (len(names) + 1) + "|")
    for mesh in dict.fromkeys(mesh for mesh, *_ in found):
        cells = [" ".join(f"{over(r, name):.3f}" for of, _, r in found if of == mesh) for name in names]
        print(f"| {mesh} | " + " | ".join(cells) + " |")
    count = lambda test: sum(test(lambda name, k=0: over(r, name, k)) for *_, r in found)
    print(f"\nOf {len(found)} pictures:")
    print("- `c1-phong` leaves less than `phong`, and at the 99.9th percentile:", count(lambda x: x("`c1-phong`") < x("`phong`")),
          count(lambda x: x("`c1-phong`", 1) < x("`phong`", 1)))
    print("- `c1-phong` leaves at most a third of `phong`:", count(lambda x: x("`c1-phong`") <= x("`phong`") / 3))
    for other in (names[3], names[5]):
        print(f"- {other} leaves less than `c1-phong`:", count(lambda x: x(other) < x("`c1-phong`")))
    return drawings


def normals_table(program, drawings):
    kinds = {"sampled": drawings, "sampled, irregular": [], "decimated, weak detail": [], "decimated, strong detail": []}
    for f in BOXES:
        degrees = FLAT if f is ripple else ROUND
        p, faces = dense(f)
        radius = View(p, degrees).radius
        rate = np.linalg.norm(Implicit(f).slope(p), axis=1).mean() * radius
        for kind, amount in zip(list(kinds)[1:], (0, 0.006, 0.015)):
            # Marching gives the flat sides of the box and the capsule's straight side vertices that decimation stalls on.
            if not amount and f in (rounded_box, capsule):
                continue
            shape = detailed(f, amount * rate, radius) if amount else f
            surface = Implicit(shape)
            fine, triangles = dense(f, shape) if amount else (p, faces)
            coarse, few = decimated(fine, triangles, 1500)
            coarse = coarse if amount else surface.onto(coarse)
            truth = Truth(surface, fine, triangles, View(fine, degrees))
            kinds[kind].append((Drawing(program, truth, coarse, few), coarse, few))
    estimates = {"averaged": "averaged", "mean by angle": by_angle, "mean by area": by_area,
                 "mean by area and cubic": weighed}
    print("\nRange (median) over meshes and scenes, relative to Gouraud's with averaged normals:\n")
    print("| normals | shader | " + " | ".join(f"{kind}, {len(of)} meshes" for kind, of in kinds.items()) + " |\n" + "|---" * 6 + "|")
    table = {}
    for kind, meshes in kinds.items():
        for drawing, p, f in meshes:
            bare, rows = (p, f, None), {}
            for name, estimate in estimates.items():
                given = bare if isinstance(estimate, str) else (p, f, estimate(p, f))
                for shader in ("gouraud", "phong", "c1-phong"):
                    rows[name, shader] = (shader, estimate if given is bare else "given", given)
            for results in drawing.judged(rows):
                for row, (rms, _) in results.items():
                    table.setdefault(row, {}).setdefault(kind, []).append(rms / results["averaged", "gouraud"][0])
    for (name, shader), cells in table.items():
        print(f"| {name} | `{shader}` | " + " | ".join(span(cells[kind]) for kind in kinds) + " |")
    ours, mean = (table[name, "c1-phong"] for name in ("mean by area and cubic", "averaged"))
    wins = [f"{sum(a < b for a, b in zip(ours[kind], mean[kind]))} of {len(ours[kind])}" for kind in kinds]
    print("\nPictures in which mean by area and cubic leaves less than averaged under `c1-phong`:", ", ".join(wins))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--machband", default="target/release/machband", help="the program")
    parser.add_argument("--out", help="a folder for the last surface's meshes and picture; a temporary one by default")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        program = Program(given.machband, given.out or folder)
        program.folder.mkdir(parents=True, exist_ok=True)
        normals_table(program, shaders_table(program))


if __name__ == "__main__":
    main()
