#!/usr/bin/env python3
"""Light reflected by lit surfaces, and values of the cubic of the patch shader, computed independently of the program.

Usage: python3 scripts/golden_shading.py > tests/golden/shading.csv     # needs numpy and scipy

Plain Python that uses different methods from the program's: Fresnel reflectance from Snell's law and the two amplitudes,
the distribution and geometry of microfacets from angles, and the mirror image of the lamp by rotation about the normal.
"""
import math
import platform
import random
import sys

import numpy
import scipy


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
                    print("highlight", model, *map(repr, row), sep=",")


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
    for model in ("phong", "blinn", "gaussian", "beckmann"):
        for _ in range(20):
            v = direction(rng, 0.3)
            n = direction(rng, -0.2)
            position = [rng.uniform(-1, 1) for _ in range(3)]
            print("scene", model, *map(repr, (*position, *n, *v, *light(model, position, n, v))), sep=",")


def patch():
    """Values of the reduced Clough-Tocher cubic of the patch shader, found without its Bezier form.

    SciPy triangulates random points. In each triangle, three cubics with ten powers of x and y each must have the given
    values and gradients at the corners, must agree in value and slope where they meet, and must have a slope across each
    outer edge that changes linearly along it. These conditions are written as linear equations and solved by least squares
    with numpy, which must leave no residue. SciPy's own CloughTocher2DInterpolator meets the same conditions with another
    direction across the edges, the line between centroids; with `--scipy`, the script uses that direction and checks that
    its solution equals SciPy's.
    """
    from scipy.interpolate import CloughTocher2DInterpolator

    POINTS = 14
    SAMPLES = 120

    POWERS = [(i, j) for i in range(4) for j in range(4 - i)]


    def value(p):
        return numpy.array([p[0] ** i * p[1] ** j for i, j in POWERS])


    def slope(p, d):
        x = [i * p[0] ** max(i - 1, 0) * p[1] ** j for i, j in POWERS]
        y = [j * p[0] ** i * p[1] ** max(j - 1, 0) for i, j in POWERS]
        return d[0] * numpy.array(x) + d[1] * numpy.array(y)


    def solve(corners, values, gradients, across):
        """The 3 x 10 coefficients, in coordinates from the centroid, of the part at the edge opposite each corner."""
        rows, right = [], []

        def equation(terms, result):
            row = numpy.zeros(30)
            for part, coefficients in terms:
                row[10 * part : 10 * part + 10] += coefficients
            rows.append(row)
            right.append(result)

        for k in range(3):
            for corner in [(k + 1) % 3, (k + 2) % 3]:
                equation([(k, value(corners[corner]))], values[corner])
                for axis in range(2):
                    equation([(k, slope(corners[corner], numpy.eye(2)[axis]))], gradients[corner][axis])
            # The slope across the outer edge is quadratic along it; at the middle, it is the mean of its ends.
            a, b = corners[(k + 1) % 3], corners[(k + 2) % 3]
            unit = across[k] / numpy.linalg.norm(across[k])
            middle = slope((a + b) / 2, unit) - (slope(a, unit) + slope(b, unit)) / 2
            equation([(k, middle)], 0.0)
            # The parts k and k + 1 meet on the line from the centroid to corner k + 2.
            end = corners[(k + 2) % 3]
            for t in numpy.linspace(0.0, 1.0, 5):
                equation([(k, value(t * end)), ((k + 1) % 3, -value(t * end))], 0.0)
                for axis in numpy.eye(2):
                    equation([(k, slope(t * end, axis)), ((k + 1) % 3, -slope(t * end, axis))], 0.0)
        matrix, result = numpy.array(rows), numpy.array(right)
        found = numpy.zeros(30)
        # The second solution corrects the first one's rounding errors.
        for _ in range(2):
            found += numpy.linalg.lstsq(matrix, result - matrix @ found, rcond=None)[0]
        residue = abs(matrix @ found - result).max()
        assert residue < 1e-11, residue
        return found.reshape(3, 10)


    random = numpy.random.default_rng(5)
    places = random.uniform(0.0, 100.0, (POINTS, 2))
    # Three fields, one per channel.
    lights = random.uniform(0.0, 1.0, (POINTS, 3))
    gradients = random.normal(0.0, 0.02, (POINTS, 3, 2))

    cubic = CloughTocher2DInterpolator(places, lights)
    # Shape: points, fields, x and y.
    assert cubic.grad.shape == (POINTS, 3, 2)
    cubic.grad[...] = gradients
    triangles = cubic.tri.simplices


    def directions(t, is_scipy):
        """The direction across each edge, in pixels."""
        centers = places[triangles].mean(axis=1)
        for k in range(3):
            along = places[triangles[t][(k + 2) % 3]] - places[triangles[t][(k + 1) % 3]]
            neighbor = cubic.tri.neighbors[t][k]
            if not is_scipy:
                yield numpy.array([along[1], -along[0]])
            elif neighbor >= 0:
                yield centers[neighbor] - centers[t]
            else:
                yield centers[t] - places[triangles[t]][[(k + 1) % 3, (k + 2) % 3]].mean(axis=0)


    def at(t, weights, is_scipy):
        corners = places[triangles[t]]
        center = corners.mean(axis=0)
        size = abs(corners - center).max()
        local = (corners - center) / size
        part = int(numpy.argmin(weights))
        result = []
        for field in range(3):
            slopes = gradients[triangles[t], field] * size
            found = solve(local, lights[triangles[t], field], slopes, list(directions(t, is_scipy)))
            result.append(found[part] @ value((weights @ corners - center) / size))
        return result


    def line(kind, *values):
        print(",".join([kind] + [repr(v) for v in values]))


    is_check = "--scipy" in sys.argv
    for place, light, gradient in zip(places, lights, gradients):
        line("vertex", *place.tolist(), *light.tolist(), *gradient.ravel().tolist())
    for triangle in triangles:
        line("triangle", *triangle.tolist())
    for sample in range(SAMPLES):
        t = sample % len(triangles)
        weights = random.dirichlet([1.0, 1.0, 1.0])
        place = weights @ places[triangles[t]]
        assert cubic.tri.find_simplex(place) == t
        light = [float(v) for v in at(t, weights, is_check)]
        if is_check:
            assert numpy.allclose(light, cubic(place).ravel(), rtol=0, atol=1e-9), (light, cubic(place))
        line("sample", t, *weights[:2].tolist(), *light)


HEAD = f"""\
# By scripts/golden_shading.py, Python {platform.python_version()}, numpy {numpy.__version__}, points and triangles of the cubic from scipy {scipy.__version__}.
# highlight: model, slope, c1, index of refraction of r g b, n, l, v, F D G / (pi N.V) of a microfacet surface for r g b.
# scene: model, p, n, v, linear light of r g b of a point under the lamps that the script lists. n is the normal, l points
# toward the lamp, v toward the viewer, p is the position of the point.
# Reduced Clough-Tocher cubic with slopes that are linear across the perpendicular of each edge, solved as linear equations.
# vertex: x, y, light of r g b, gradient x y of r g b; triangle: three vertices; sample: triangle, two barycentric weights,
# light."""

print(HEAD)
highlights()
scene()
patch()
