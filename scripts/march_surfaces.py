#!/usr/bin/env python3
"""An independent check of docs/shaders.md: how far shaders are from smooth surfaces that machband does not know.

Nothing here comes from machband but the pictures of the shaders. The surfaces are implicit functions; their meshes are
OBJ files with the functions' gradients as normals; the truth is marched along each pixel's line of sight and lit by
Phong's formula; the difference is filtered by the contrast sensitivity of Mannos and Sakrison (1974). Prints the root
mean square of the filtered difference relative to Gouraud's, for each mesh and scene.

    pip install numpy pypng
    python3 scripts/march_surfaces.py [target/release/machband]        # about two minutes
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import png

MACHBAND = sys.argv[1] if len(sys.argv) > 1 else "target/release/machband"
SIDE, WINDOW_DEG, FILL = 512, 10.0, 0.9
SHADERS = ["gouraud", "phong", "patch", "c1-phong"]
AMBIENT, DIFFUSE, EXPONENT = 0.1, 0.6, 20
# Name, direction of the lamp, k_s.
SCENES = [
    ("highlight, lamp aside", (0.5, 0.5, 0.7), 0.3),
    ("the default scene", (0.36, 0.48, 0.8), 0.3),
    ("matt, lamp at the eye", (0.0, 0.0, 1.0), 0.0),
]
ROUND, FLAT = (25, -35, 0), (-35, 10, 20)


def peanut(p):
    x, y, z = np.moveaxis(p, -1, 0)
    return ((x - 0.7) ** 2 + y**2 + z**2) * ((x + 0.7) ** 2 + y**2 + z**2) - 0.66


def ellipsoid(p):
    return ((p / np.array([1.0, 0.5, 0.35])) ** 2).sum(-1) - 1


def bumpy(p):
    x, y, z = np.moveaxis(p, -1, 0)
    return np.linalg.norm(p, axis=-1) - 1 - 0.12 * np.sin(4 * x + 1) * np.sin(5 * y) * np.cos(3 * z)


def sphere(p):
    return np.linalg.norm(p, axis=-1) - 1


def torus(p):
    return np.hypot(np.hypot(p[..., 0], p[..., 2]) - 1, p[..., 1]) - 0.4


def hills(p):
    x, y, z = np.moveaxis(p, -1, 0)
    return z - 0.16 * np.sin(3.1 * x + 0.4) * np.cos(2.7 * y) - 0.07 * np.sin(5 * x + 3 * y)


def slope(f, p, h=1e-5):
    return np.stack([(f(p + h * axis) - f(p - h * axis)) / (2 * h) for axis in np.eye(3)], -1)


def normal(f, p):
    g = slope(f, p)
    return g / np.linalg.norm(g, axis=-1, keepdims=True)


def onto(f, p):
    """Moves points onto the surface."""
    for _ in range(60):
        g = slope(f, p)
        p = p - (f(p) / (g * g).sum(-1))[..., None] * g
    return p


def icosphere(times):
    t = (1 + 5**0.5) / 2
    points = [np.array(p) / np.hypot(1, t) for p in [
        (-1, t, 0), (1, t, 0), (-1, -t, 0), (1, -t, 0), (0, -1, t), (0, 1, t),
        (0, -1, -t), (0, 1, -t), (t, 0, -1), (t, 0, 1), (-t, 0, -1), (-t, 0, 1)]]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6),
             (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10),
             (8, 6, 7), (9, 8, 1)]
    for _ in range(times):
        middles, finer = {}, []

        def middle(a, b):
            key = (min(a, b), max(a, b))
            if key not in middles:
                p = points[a] + points[b]
                middles[key] = len(points)
                points.append(p / np.linalg.norm(p))
            return middles[key]

        for a, b, c in faces:
            x, y, z = middle(a, b), middle(b, c), middle(c, a)
            finer += [(a, x, z), (b, y, x), (c, z, y), (x, y, z)]
        faces = finer
    return np.array(points), faces


def grid(columns, rows, place, closed, jitter=0.0):
    """A grid of places over u and v; diagonals alternate."""
    random = np.random.default_rng(3)
    steps = (columns, rows) if closed else (columns - 1, rows - 1)
    points, faces = [], []
    for j in range(rows):
        for i in range(columns):
            is_inside = closed or (0 < i < columns - 1 and 0 < j < rows - 1)
            du, dv = random.uniform(-jitter, jitter, 2) * is_inside
            points.append(place((i + du) / steps[0], (j + dv) / steps[1]))
    for j in range(steps[1]):
        for i in range(steps[0]):
            a, b = j * columns + i, j * columns + (i + 1) % columns
            d, c = (j + 1) % rows * columns + i, (j + 1) % rows * columns + (i + 1) % columns
            faces += [(a, b, c), (a, c, d)] if (i + j) % 2 else [(a, b, d), (b, c, d)]
    return np.array(points), faces


def uv_sphere(columns, rows):
    def at(i, j):
        a, b = 2 * np.pi * i / columns, np.pi * j / rows
        return np.sin(b) * np.cos(a), np.cos(b), np.sin(b) * np.sin(a)

    points = [(0, 1, 0), *(at(i, j) for j in range(1, rows) for i in range(columns)), (0, -1, 0)]
    of = lambda i, j: 0 if j == 0 else len(points) - 1 if j == rows else 1 + (j - 1) * columns + i % columns
    quads = [(of(i, j), of(i + 1, j), of(i + 1, j + 1), of(i, j + 1)) for j in range(rows) for i in range(columns)]
    faces = [t for a, b, c, d in quads for t in [(a, b, c), (a, c, d)] if len(set(t)) == 3]
    return np.array(points, float), faces


def on_torus(u, v):
    a, b = 2 * np.pi * u, 2 * np.pi * v
    return (1 + 0.4 * np.cos(b)) * np.cos(a), 0.4 * np.sin(b), (1 + 0.4 * np.cos(b)) * np.sin(a)


def on_hills(u, v):
    p = np.array([2 * u - 1, 2 * v - 1, 0.0])
    return p - [0, 0, hills(p)]


def meshes():
    fine, coarse = icosphere(3), icosphere(2)
    yield "peanut", peanut, (onto(peanut, 1.1 * fine[0]), fine[1]), ROUND
    yield "ellipsoid", ellipsoid, (onto(ellipsoid, coarse[0] * [1, 0.5, 0.35]), coarse[1]), ROUND
    yield "bumpy sphere", bumpy, (onto(bumpy, fine[0]), fine[1]), ROUND
    yield "UV sphere 96 × 8", sphere, uv_sphere(96, 8), ROUND
    yield "torus, jittered 40 × 16", torus, grid(40, 16, on_torus, True, 0.3), (50, -35, 0)
    yield "torus 96 × 8", torus, grid(96, 8, on_torus, True), (50, -35, 0)
    yield "hills 24 × 14", hills, grid(24, 14, on_hills, False), FLAT
    yield "hills, jittered 17 × 17", hills, grid(17, 17, on_hills, False, 0.3), FLAT


def rotation(degrees):
    (cx, cy, cz), (sx, sy, sz) = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return z @ y @ x


def march(f, points, degrees):
    """Returns where the surface is seen, its normals and its height toward the eye, for each pixel."""
    low, high = points.min(0), points.max(0)
    center = (low + high) / 2
    radius, turned = np.linalg.norm(points - center, axis=1).max(), rotation(degrees)
    across = (np.arange(SIDE) + 0.5 - SIDE / 2) / (SIDE * FILL / 2)
    x, y = np.meshgrid(across, -across)
    place = lambda z: np.stack([x, y, np.broadcast_to(z, x.shape)], -1) @ turned * radius + center
    seen, height = np.zeros(x.shape, bool), np.zeros(x.shape)
    steps = np.linspace(1.3, -1.3, 1600)
    before = f(place(steps[0]))
    for z, last in zip(steps[1:], steps):
        here = place(z)
        now = f(here)
        new = ~seen & (before * now <= 0)
        if f is hills:
            new &= (np.abs(here[..., :2]) <= 1).all(-1)
        seen |= new
        height[new] = last
        before = now
    near, far = height.copy(), height + (steps[1] - steps[0])
    sign = np.sign(f(place(near)))
    for _ in range(40):
        middle = (near + far) / 2
        is_same = np.sign(f(place(middle))) == sign
        near, far = np.where(is_same, middle, near), np.where(is_same, far, middle)
    normals = normal(f, place(near)) @ turned.T
    return seen, np.where(normals[..., 2:] < 0, -normals, normals), near


def lit(normals, lamp, specular):
    toward = np.array(lamp) / np.linalg.norm(lamp)
    cosine = normals @ toward
    mirrored = 2 * normals * cosine[..., None] - toward
    highlight = specular * np.clip(mirrored[..., 2], 0, None) ** EXPONENT
    return AMBIENT + np.where(cosine > 0, DIFFUSE * cosine + highlight, 0), cosine > 0


def filtered(difference):
    size = 2 * SIDE
    axis = np.fft.fftfreq(size) * SIDE / WINDOW_DEG
    frequency = np.hypot(*np.meshgrid(axis, axis))
    gain = 2.6 * (0.0192 + 0.114 * frequency) * np.exp(-((0.114 * frequency) ** 1.1))
    spectrum = np.fft.fft2(difference, (size, size)) * gain / gain.max()
    return np.real(np.fft.ifft2(spectrum))[:SIDE, :SIDE]


def eroded(mask, times):
    for _ in range(times):
        padded = np.pad(mask, 1)
        mask = mask & padded[2:, 1:-1] & padded[:-2, 1:-1] & padded[1:-1, 2:] & padded[1:-1, :-2]
    return mask


def jumps(values):
    """The pixels that differ from the one before or above."""
    out = np.zeros(values.shape, bool)
    out[:, 1:] |= np.abs(np.diff(values, axis=1)) > 0.05
    out[1:] |= np.abs(np.diff(values, axis=0)) > 0.05
    return out


def drawn(folder, obj, shader, degrees, lamp, specular):
    out = Path(folder, "picture.png")
    listed = lambda values: ",".join(map(str, values))
    subprocess.run([MACHBAND, "shade", "--mesh", obj, "--shader", shader, "--rotate", listed(degrees), "--light",
                    listed(lamp), "--specular", str(specular), "--background", "0", "--size", str(SIDE), "--bits", "16",
                    "--transfer", "linear", "--out", out, "--force"], check=True, capture_output=True)
    _, _, rows, info = png.Reader(str(out)).read()
    return np.array([row[:: info["planes"]] for row in map(np.array, rows)]) / 65535


def main():
    for name, f, (points, faces), degrees in meshes():
        faces, normals = np.array(faces), normal(f, points)
        a, b, c = points[faces.T]
        inward = (np.cross(b - a, c - a) * normals[faces[:, 0]]).sum(1) < 0
        faces[inward] = faces[inward][:, [0, 2, 1]]
        seen, marched, height = march(f, points, degrees)
        with tempfile.TemporaryDirectory() as folder:
            obj = Path(folder, "mesh.obj")
            lines = ["v %.17g %.17g %.17g" % tuple(p) for p in points] + ["vn %.17g %.17g %.17g" % tuple(n) for n in normals]
            lines += ["f " + " ".join(f"{v + 1}//{v + 1}" for v in face) for face in faces]
            obj.write_text("\n".join(lines) + "\n")
            for title, lamp, specular in SCENES:
                truth, is_lit = lit(marched, lamp, specular)
                pictures = {shader: drawn(folder, obj, shader, degrees, lamp, specular) for shader in SHADERS}
                # Not at outlines, terminators, and where the surface turns away by more than 72.5°.
                mask = seen & (marched[..., 2] > 0.3) & ~jumps(height) & ~jumps(is_lit.astype(float))
                mask = eroded(mask & (pictures["gouraud"] > 0.05), 3)
                rms = {shader: np.sqrt((filtered(np.where(mask, picture - truth, 0))[mask] ** 2).mean())
                       for shader, picture in pictures.items()}
                over = [f"{rms[shader] / rms['gouraud']:.3f}" for shader in SHADERS[1:]]
                print(f"| {name}, {len(faces)} | {title} | " + " | ".join(over) + " |", flush=True)


if __name__ == "__main__":
    main()
