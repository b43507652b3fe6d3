#!/usr/bin/env python3
"""Values of SciPy's Clough-Tocher cubic, for the tests of the patch shader.

Usage: python3 scripts/golden_patch.py > tests/golden/patch.csv

SciPy's CloughTocher2DInterpolator is another implementation of the reduced Clough-Tocher cubic whose slope toward the
neighbor's centroid is linear along an edge. This script replaces SciPy's estimated gradients and its triangulation with
fixed ones, so that the test compares only the cubics. Needs numpy and scipy.
"""
import numpy
import scipy
from scipy.interpolate import CloughTocher2DInterpolator

POINTS = 14
SAMPLES = 120

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

print(f"# Reduced Clough-Tocher cubic of scipy {scipy.__version__}, numpy {numpy.__version__}: CloughTocher2DInterpolator with its")
print("# gradients replaced, by scripts/golden_patch.py. vertex: x, y, light of r g b, gradient x y of r g b; triangle: three")
print("# vertices; sample: triangle, two barycentric weights, light of r g b.")


def line(kind, *values):
    print(",".join([kind] + [repr(v) for v in values]))


for place, light, gradient in zip(places, lights, gradients):
    line("vertex", *place.tolist(), *light.tolist(), *gradient.ravel().tolist())
for triangle in triangles:
    line("triangle", *triangle.tolist())
for sample in range(SAMPLES):
    triangle = sample % len(triangles)
    weights = random.dirichlet([1.0, 1.0, 1.0])
    place = weights @ places[triangles[triangle]]
    assert cubic.tri.find_simplex(place) == triangle
    line("sample", triangle, *weights[:2].tolist(), *cubic(place).ravel().tolist())
