#!/usr/bin/env python3
"""The light of every catalog entry and variant, computed independently of the program.

Usage: python3 scripts/golden_catalog.py > tests/golden/catalog.csv

Evaluates the documented formulas at pixel centers in plain Python. Pixels near an edge that is not aligned with the pixel
grid are averaged over a fine grid of points, which gives the proportion of the area.
"""
import math
import platform

SIZE = 96
FINE = 160  # points per side within a pixel


def smooth(n, u):
    """I_n for n = 1, 3 (polynomials) and inf (printed tanh)."""
    if u < 0:
        return 0.0
    if u >= 1:
        return 1.0
    if n == "inf":
        return (1 + math.tanh(5 * (u - 0.5))) / 2
    return {1: u, 3: 10 * u**3 - 15 * u**4 + 6 * u**5}[n]


def mach_band(width=0.4, depth=1, low=0.25, high=0.75):
    return lambda x, y: low + (high - low) * smooth(depth, x / width + 0.5)


def chevreul(steps=5, low=0.25, high=0.75):
    def light(x, y):
        k = min(max(math.floor((x + 0.5) * steps), 0), steps - 1)
        return low + (high - low) * k / (steps - 1)
    return light


def cornsweet(width=0.2, exponent=1.0, low=0.4, high=0.6):
    def light(x, y):
        rest = max(0.0, 1 - abs(x) / width)
        return (low + high) / 2 + math.copysign((high - low) / 2 * rest**exponent, x)
    return light


def vasarely(squares=12, low=0.1, high=0.9):
    def light(x, y):
        k = min(max(math.floor(squares * (1 - 2 * max(abs(x), abs(y)))), 0), squares - 1)
        return low + (high - low) * k / (squares - 1)
    return light


def kanizsa(side=0.6, radius=0.15, low=0.1, high=0.75):
    corners = [(side / math.sqrt(3) * math.cos(math.radians(a)), side / math.sqrt(3) * math.sin(math.radians(a)))
               for a in (90, 210, 330)]

    def light(x, y):
        inside = True
        for (ax, ay), (bx, by) in zip(corners, corners[1:] + corners[:1]):
            inside &= (bx - ax) * (y - ay) - (by - ay) * (x - ax) >= 0
        disc = any(math.hypot(x - cx, y - cy) < radius for cx, cy in corners)
        return low if disc and not inside else high
    return light


def cylinder(shading="gouraud", facets=6, low=0.25, high=0.75):
    arc = math.radians(60)
    angles = [arc * (2 * i / facets - 1) for i in range(facets + 1)]
    places = [math.sin(a) / (2 * math.sin(arc)) for a in angles]

    def lit(cosine):
        return low + (high - low) * (cosine - 0.5) / 0.5

    def light(x, y):
        x = min(max(x, -0.5), 0.5)
        i = max(j for j in range(facets) if j == 0 or places[j] <= x)
        t = (x - places[i]) / (places[i + 1] - places[i])
        a, b = angles[i], angles[i + 1]
        if shading == "flat":
            return lit(math.cos((a + b) / 2))
        if shading == "gouraud":
            return (1 - t) * lit(math.cos(a)) + t * lit(math.cos(b))
        c, s = (1 - t) * math.cos(a) + t * math.cos(b), (1 - t) * math.sin(a) + t * math.sin(b)
        return lit(c / math.hypot(c, s))
    return light


# kind, variant, formula, orientation, sharp edges, averaged at the edges at any orientation
CASES = [
    ("mach-band", 0, mach_band(), 0, False),
    ("mach-band", 1, mach_band(0.1, 3), 33, False),
    ("mach-band", 2, mach_band(0.8, "inf"), 90, False),
    ("chevreul", 0, chevreul(), 0, False),
    ("chevreul", 1, chevreul(9), 30, True),
    ("chevreul", 2, chevreul(3), 90, False),
    ("cornsweet", 0, cornsweet(), 0, False),
    ("cornsweet", 1, cornsweet(exponent=2.75), 45, True),
    ("cornsweet", 2, cornsweet(0.4, low=0.3, high=0.7), 0, False),
    ("vasarely", 0, vasarely(), 0, False),
    ("vasarely", 1, vasarely(24), 20, True),
    ("vasarely", 2, vasarely(6, 0.9, 0.9), 0, False),
    ("kanizsa", 0, kanizsa(), 0, True),
    ("kanizsa", 1, kanizsa(0.4, 0.1), 30, True),
    ("kanizsa", 2, kanizsa(radius=0.25), 0, True),
    ("shaded-cylinder", 0, cylinder(), 0, False),
    ("shaded-cylinder", 1, cylinder("flat"), 15, True),
    ("shaded-cylinder", 2, cylinder("phong", 12), 0, False),
]


def pixel(light, degrees, ix, iy, averaged):
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))

    def at(px, py):
        return light(px * c + py * s, -px * s + py * c)

    center = ((ix + 0.5) / SIZE - 0.5, 0.5 - (iy + 0.5) / SIZE)
    if not averaged:
        return at(*center)
    total = 0.0
    for i in range(FINE):
        for j in range(FINE):
            total += at(center[0] + ((i + 0.5) / FINE - 0.5) / SIZE, center[1] + ((j + 0.5) / FINE - 0.5) / SIZE)
    return total / FINE**2


def main():
    print(f"# Light of the strongest channel, {SIZE} px a side, by scripts/golden_catalog.py, Python {platform.python_version()}.")
    print(f"# Averaged pixels: {FINE} x {FINE} points; tolerance 3e-3 there, 1e-6 elsewhere.")
    print("kind,variant,x,y,averaged,light")
    for kind, variant, light, degrees, averaged in CASES:
        for n in range(40):
            # A fixed scatter of pixels that includes the middle rows.
            ix, iy = (n * 37 + 11) % SIZE, (n * 53 + 5 + n // 7) % SIZE
            value = pixel(light, degrees, ix, iy, averaged)
            print(f"{kind},{variant},{ix},{iy},{int(averaged)},{value:.9f}")


main()
