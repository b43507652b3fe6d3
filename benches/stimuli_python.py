#!/usr/bin/env python3
"""The comparison for `machband stimuli` in benches/README.md: 1,000 ramps of 1024 x 1024 pixels with numpy and Pillow, in
one process per core.

Usage: python3 benches/stimuli_python.py OUT_FOLDER [COUNT]     (pip install numpy pillow)

Also writes OUT_FOLDER/stimuli.toml, the definition of the same images: machband stimuli OUT_FOLDER/stimuli.toml --out FOLDER
"""
import itertools
import math
import os
import sys
from multiprocessing import Pool

import numpy as np
from PIL import Image

SIZE = 1024
WIDTHS = [0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.6, 0.8]
ORIENTATIONS = [*range(0, 360, 15), 359]
DEFINITION = f"""schema = 1
name = "stimuli"

[stimulus]
kind = "mach-band"

[factors]
width = {WIDTHS}
depth = [1, 2, 3, 4, "inf"]
orientation_deg = {ORIENTATIONS}
"""


def interpolation(depth, u):
    u = np.clip(u, 0, 1)
    if depth == 0:
        return np.where(u >= 1, 1, (1 + np.tanh(5 * (u - 0.5))) / 2)
    return {1: u, 2: u**2 * (3 - 2 * u), 3: u**3 * (10 - 15 * u + 6 * u**2),
            4: u**4 * (35 - 84 * u + 70 * u**2 - 20 * u**3)}[depth]


def encode(light):
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)


def make(job):
    number, width, depth, degrees, folder = job
    axis = (np.arange(SIZE) + 0.5) / SIZE - 0.5
    x = axis[None, :] * math.cos(math.radians(degrees)) - axis[:, None] * math.sin(math.radians(degrees))
    light = 0.25 + 0.5 * interpolation(depth, x / width + 0.5)
    codes = np.round(encode(light) * 255).astype(np.uint8)
    image = np.zeros((SIZE, SIZE, 3), np.uint8)
    image[..., 0] = image[..., 1] = codes
    Image.fromarray(image).save(os.path.join(folder, f"{number:04}.png"))


def main():
    folder, count = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 1000
    os.makedirs(folder, exist_ok=True)
    with open(os.path.join(folder, "stimuli.toml"), "w") as file:
        file.write(DEFINITION)
    cells = itertools.product(WIDTHS, [1, 2, 3, 4, 0], ORIENTATIONS)
    jobs = [(i, w, n, t, folder) for i, (w, n, t) in enumerate(itertools.islice(cells, count))]
    with Pool(os.cpu_count()) as pool:
        pool.map(make, jobs, chunksize=8)


if __name__ == "__main__":
    main()
