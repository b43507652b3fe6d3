#!/usr/bin/env python3
"""Light reflected by lit surfaces, computed independently of the program.

Usage: python3 scripts/golden_illumination.py highlights > tests/golden/illumination.csv
       python3 scripts/golden_illumination.py scene > tests/golden/illumination_scene.csv

Columns: n is the normal, l points toward the lamp, v toward the viewer, p is the position of the point; r,g,b is the result.

Plain Python that uses different methods from the program's: Fresnel reflectance from Snell's law and the two amplitudes,
the distribution and geometry of microfacets from angles, and the mirror image of the lamp by rotation about the normal.
"""
import math
import platform
import random
import sys


def dot(a, b):
    return math.fsum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    length = math.hypot(*a)
    return tuple(x / length for x in a)


def angle(a, b):
    return math.atan2(math.hypot(*cross(a, b)), dot(a, b))


def fresnel(theta, index):
    """Mean reflectance of the two polarizations; the index is n_far / n_near."""
    sine = math.sin(theta) / index
    if sine >= 1:
        return 1.0
    inner = math.asin(sine)
    near, far = math.cos(theta), math.cos(inner)
    s = (near - index * far) / (near + index * far)
    p = (index * near - far) / (index * near + far)
    return (s * s + p * p) / 2


def cook_torrance(model, slope, c1, indices, n, l, v):
    """F D G / (pi N.V) for each index."""
    h = unit([a + b for a, b in zip(l, v)])
    tilt, to_v, to_l, half = angle(n, h), angle(n, v), angle(n, l), angle(v, h)
    if max(tilt, to_v, to_l) >= math.pi / 2:
        return [0.0] * len(indices)
    if model == "gaussian":
        density = c1 * math.exp(-((tilt / slope) ** 2))
    else:
        density = math.exp(-((math.tan(tilt) / slope) ** 2)) / (slope**2 * math.cos(tilt) ** 4)
    blocked = 2 * math.cos(tilt) * math.cos(to_v) / math.cos(half)
    shadowed = 2 * math.cos(tilt) * math.cos(to_l) / math.cos(half)
    shape = density * min(1, blocked, shadowed) / (math.pi * math.cos(to_v))
    return [fresnel(half, index) * shape for index in indices]


def direction(rng, least_z):
    """A random direction that rises above least_z."""
    while True:
        a = unit([rng.gauss(0, 1) for _ in range(3)])
        if a[2] > least_z:
            return a


def highlights():
    rng = random.Random(1979)
    print("model,slope,c1,index_r,index_g,index_b," + ",".join(f"{w}{i}" for w in "nlv" for i in "xyz") + ",r,g,b")
    for model in ("gaussian", "beckmann"):
        for slope in (0.05, 0.1, 0.2, 0.35, 0.6, 1.0):
            for indices in ((1.33, 1.5, 2.4), (0.2, 0.8, 25.0)):
                for _ in range(8):
                    l = direction(rng, -0.1)
                    v = direction(rng, -0.1)
                    # Near the highlight, where the result is not 0.
                    h = [a + b for a, b in zip(l, v)]
                    n = unit([a + rng.gauss(0, slope) for a in unit(h)])
                    c1 = rng.uniform(0.5, 3)
                    row = (slope, c1, *indices, *n, *l, *v, *cook_torrance(model, slope, c1, indices, n, l, v))
                    print(model, *map(repr, row), sep=",")


# The scene. The tests contain the same scene.
COLOR, SPECULAR_COLOR = (0.9, 0.5, 0.1), (0.8, 1.0, 0.6)
K_A, K_D, K_S, M = 0.2, 0.55, 0.4, 12.5
AMBIENT = (0.3, 0.5, 0.7)
SLOPE, C1, INDICES = 0.3, 1.7, (1.5, 1.8, 2.2)
DIRECTION, DIRECTION_LIGHT = (2 / 7, 3 / 7, 6 / 7), (0.9, 0.8, 0.7)
POINTS = [  # position, light, c1 c2 c3
    ((1.5, -0.5, 2.0), (1.0, 0.1, 0.4), (0.5, 0.25, 0.125)),
    ((-0.25, 0.5, 0.75), (0.2, 2.0, 0.3), (0.1, 0.2, 0.3)),
]


def mirrored(l, n):
    """l rotated by half a turn about n (Rodrigues)."""
    cosine, along = math.cos(math.pi), dot(n, l)
    return [cosine * a + along * (1 - cosine) * b for a, b in zip(l, n)]


def light(model, position, n, v):
    lamps = [(DIRECTION, DIRECTION_LIGHT)]
    for place, strength, (c1, c2, c3) in POINTS:
        offset = [a - b for a, b in zip(place, position)]
        d = math.hypot(*offset)
        fall = min(1 / (c1 + c2 * d + c3 * d**2), 1)
        lamps.append((unit(offset), [fall * s for s in strength]))
    total = [K_A * a * o for a, o in zip(AMBIENT, COLOR)]
    for l, strength in lamps:
        cosine = math.cos(angle(n, l))
        if cosine <= 0:
            continue
        if model == "phong":
            s = [max(dot(mirrored(l, n), v), 0) ** M] * 3
        elif model == "blinn":
            s = [max(math.cos(angle(n, [a + b for a, b in zip(l, v)])), 0) ** M] * 3
        else:
            s = cook_torrance(model, SLOPE, C1, INDICES, n, l, v)
        for i in range(3):
            total[i] += strength[i] * (K_D * COLOR[i] * cosine + K_S * SPECULAR_COLOR[i] * s[i])
    return total


def scene():
    rng = random.Random(2003)
    print("model," + ",".join(f"{w}{i}" for w in "pnv" for i in "xyz") + ",r,g,b")
    for model in ("phong", "blinn", "gaussian", "beckmann"):
        for _ in range(20):
            v = direction(rng, 0.3)
            n = direction(rng, -0.2)
            position = [rng.uniform(-1, 1) for _ in range(3)]
            print(model, *map(repr, (*position, *n, *v, *light(model, position, n, v))), sep=",")


def main():
    what = sys.argv[1] if len(sys.argv) == 2 else ""
    tables = {"highlights": highlights, "scene": scene}
    if what not in tables:
        sys.exit(__doc__)
    version = platform.python_version()
    print(f"# By scripts/golden_illumination.py {what}, Python {version}.")
    if what == "highlights":
        print("# F D G / (pi N.V) of a microfacet surface for unit vectors N, L, V and indices of red, green, blue.")
    else:
        print("# Linear light of a point p with the normal n toward v, under the lamps that the script lists.")
    tables[what]()


main()
