"""Hold `machband compare` and `shade --metrics` against pictures that this script makes, and print the tables of docs/models.md.

Needs NumPy and Pillow; the rank correlation with FLIP also needs the package flip-evaluator. Usage:

    python scripts/compare_world.py target/release/machband FOLDER
"""

import io
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
from PIL import Image

PROGRAM, FOLDER = Path(sys.argv[1]).resolve(), Path(sys.argv[2])
FOLDER.mkdir(parents=True, exist_ok=True)
RNG = np.random.default_rng(1)
SIDE = 512


def save(name, codes):
    """Write 8-bit codes."""
    path = FOLDER / f"{name}.png"
    Image.fromarray(np.clip(np.round(codes), 0, 255).astype(np.uint8)).convert("RGB").save(path)
    return path


def run(*words):
    return subprocess.run([PROGRAM, *map(str, words)], check=True, capture_output=True, text=True).stdout


def compare(a, b, window=10):
    return json.loads(run("compare", a, b, "--window", window, "--json"))["times_threshold"]


def steps(path, window):
    found = json.loads(run("compare", path, "--steps", "--window", window, "--json"))
    return found["steps"], found["dithered"]


def dead_leaves():
    """Discs of random size and gray that hide each other, each with a gradient."""
    y, x = np.mgrid[0:SIDE, 0:SIDE]
    picture = np.full((SIDE, SIDE), 120.0)
    for _ in range(400):
        radius = 8 * (1 - RNG.random() * 0.98) ** -0.7
        cx, cy, gray, slope = *RNG.uniform(0, SIDE, 2), RNG.uniform(30, 220), RNG.normal(0, 0.4)
        inside = (x - cx) ** 2 + (y - cy) ** 2 < min(radius, 150) ** 2
        picture[inside] = (gray + slope * (x - cx))[inside]
    return picture


def clouds(power):
    """Noise whose amplitude falls with the frequency."""
    f = np.hypot(*np.meshgrid(np.fft.fftfreq(SIDE), np.fft.fftfreq(SIDE)))
    f[0, 0] = 1
    noise = np.fft.ifft2(np.fft.fft2(RNG.normal(size=(SIDE, SIDE))) / f**power).real
    return 120 + 45 * (noise - noise.mean()) / noise.std()


def jpeg(path, quality):
    buffer = io.BytesIO()
    Image.open(path).save(buffer, "JPEG", quality=quality)
    return save(f"{path.stem}-q{quality}", np.asarray(Image.open(buffer).convert("L"), float))


def pictures():
    print("\n| picture | itself | JPEG 98 | 95 | 90 | 75 | 50 | 20 | shifted by a pixel |\n|---|---|---|---|---|---|---|---|---|")
    for name, codes in [("dead leaves 1", dead_leaves()), ("dead leaves 2", dead_leaves()), ("1/f noise", clouds(1.0)),
                        ("1/f^1.3 noise", clouds(1.3)), ("1/f^1.6 noise", clouds(1.6))]:
        path = save(name.replace(" ", "-").replace("/", "-"), codes)
        row = [compare(path, path)] + [compare(jpeg(path, quality), path) for quality in (98, 95, 90, 75, 50, 20)]
        row.append(compare(save(path.stem + "-shifted", np.roll(np.asarray(Image.open(path).convert("L"), float), 1, 1)), path))
        print(f"| {name} | " + " | ".join(f"{times:.2f}" for times in row) + " |")
        assert row[0] == 0 and all(a < b for a, b in zip(row[1:], row[2:7])), "not in order"


def gradients():
    print("\n| gradient of codes | window | steps | blue-noise dither |\n|---|---|---|---|")
    for low, high in [(13, 38), (118, 128)]:
        for window in (2, 8, 30):
            line = np.linspace(low, high, 1024)
            path = save(f"gradient-{low}-{high}", np.tile(line, (256, 1)))
            own, dithered = steps(path, window)
            print(f"| {low}…{high} | {window}° | {own:.2f} | {dithered:.2f} |")


MESHES = {"blob": 313, "sphere": 642, "terrain": 289, "torus": 768, "jittered-torus": 400, "filleted-cylinder": 194, "uv-sphere": 674}
SHADERS = ["flat", "gouraud", "phong", "patch", "c1-phong"]


def meshes():
    print("\n| mesh | " + " | ".join(SHADERS) + " |\n|---|" + "---|" * len(SHADERS))
    ours, theirs = [], []
    for mesh, vertices in MESHES.items():
        common = ["shade", "--mesh", mesh, "--vertices", vertices, "--size", SIDE, "--force"]
        run(*common, "--truth", "--out", FOLDER / "truth.png")
        row = []
        for shader in SHADERS:
            run(*common, "--shader", shader, "--out", FOLDER / "own.png", "--metrics", FOLDER / "own.json")
            row.append(json.loads((FOLDER / "own.json").read_text())["difference"]["largest"])
            theirs.append(flip(FOLDER / "truth.png", FOLDER / "own.png"))
        ours += row
        print(f"| {mesh} | " + " | ".join(f"{times:.2f}" for times in row) + " |")
        ordered = row[0] > row[1] > max(row[2:4]) and min(row[2:4]) > row[4]
        print("" if ordered else f"not in order: {mesh}", end="")
    if None not in theirs:
        rank = [np.argsort(np.argsort(values)) for values in (ours, theirs)]
        print(f"\nRank correlation with FLIP (its mean over the surface): {np.corrcoef(*rank)[0, 1]:.3f}")


def flip(reference, test):
    try:
        import flip_evaluator
    except ImportError:
        return None
    a, b = [np.asarray(Image.open(path).convert("RGB"), np.float32) / 255 for path in (reference, test)]
    error, _, _ = flip_evaluator.evaluate(a, b, "LDR", applyMagma=False, parameters={"ppd": SIDE / 10})
    background = np.all(a == a[0, 0], axis=2)
    # Away from the outline.
    inside = ~background
    for axis in (0, 1):
        for shift in range(1, 13):
            inside &= np.roll(~background, shift, axis) & np.roll(~background, -shift, axis)
    return float(np.asarray(error).reshape(SIDE, SIDE)[inside].mean())


pictures()
gradients()
meshes()
