#!/usr/bin/env python3
"""Values of the reduced Clough-Tocher cubic of the patch shader, found without its Bezier form.

Usage: python3 scripts/golden_patch.py > tests/golden/patch.csv

SciPy triangulates random points. In each triangle, three cubics with ten powers of x and y each must have the given
values and gradients at the corners, must agree in value and slope where they meet, and must have a slope across each
outer edge that changes linearly along it. These conditions are written as linear equations and solved by least squares
with numpy, which must leave no residue. SciPy's own CloughTocher2DInterpolator meets the same conditions with another
direction across the edges, the line between centroids; with `--scipy`, the script uses that direction and checks that
its solution equals SciPy's. Needs numpy and scipy.
"""
import sys

import numpy
import scipy
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
print(f"# Reduced Clough-Tocher cubic with slopes that are linear across the perpendicular of each edge, solved as linear")
print(f"# equations with numpy {numpy.__version__} by scripts/golden_patch.py; points and triangles from scipy {scipy.__version__}. vertex: x, y,")
print("# light of r g b, gradient x y of r g b; triangle: three vertices; sample: triangle, two barycentric weights, light.")
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
