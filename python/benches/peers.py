"""Times machband's functions next to other packages', in pairs, one thread each.

    pip install machband-*.whl pandas statsmodels stimupy git+https://github.com/computational-psychology/multyscale
    RAYON_NUM_THREADS=1 OMP_NUM_THREADS=1 python python/benches/peers.py

Prints the median time of each and their ratio.
"""

import os
import statistics
import time
import warnings

os.environ.setdefault("RAYON_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
import pandas as pd
from multyscale.models import ODOG_RHS2007
from statsmodels.miscmodels.ordinal_model import OrderedModel
from stimupy.components import edges

import machband

SIZE = 1024


def timed(function):
    start = time.perf_counter()
    function()
    return time.perf_counter() - start


def pair(name, ours, theirs, rounds):
    ours(), theirs()
    times = [(timed(ours), timed(theirs)) for _ in range(rounds)]
    mine, other = (statistics.median(column) for column in zip(*times, strict=True))
    print(f"{name:48} {mine * 1e3:10.2f} ms {other * 1e3:10.1f} ms  {other / mine:8.1f} x", flush=True)


def log_gabor_bank(image, ppd):
    """Filter an image with log-Gabors of 7 scales and 6 orientations, as models of brightness do (FLODOG: 7 x 6)."""
    height, width = image.shape
    fy, fx = np.meshgrid(np.fft.fftfreq(height) * ppd, np.fft.fftfreq(width) * ppd, indexing="ij")
    frequency, angle = np.hypot(fx, fy), np.arctan2(fy, fx)
    frequency[0, 0] = 1
    spectrum = np.fft.fft2(image)
    energy = np.zeros_like(image)
    for center in 0.25 * 2.0 ** np.arange(7):
        radial = np.exp(-(np.log(frequency / center) ** 2) / (2 * np.log(0.65) ** 2))
        radial[0, 0] = 0
        for preferred in np.arange(6) * np.pi / 6:
            away = np.arctan2(np.sin(angle - preferred), np.cos(angle - preferred))
            band = spectrum * radial * np.exp(-(away**2) / (2 * (np.pi / 6) ** 2))
            energy += np.abs(np.fft.ifft2(band))
    return energy


shape = {"shape": (SIZE, SIZE), "visual_size": (10, 10)}
given = {"size": SIZE, "color": "gray"}
pair(
    "step, 1024 x 1024, against stimupy",
    lambda: machband.stimulus(width=0, **given),
    lambda: edges.step(**shape),
    41,
)
pair(
    "step at 30 degrees",
    lambda: machband.stimulus(width=0, orientation_deg=30, **given),
    lambda: edges.step(rotation=30, **shape),
    41,
)
pair(
    "Cornsweet edge",
    lambda: machband.stimulus("cornsweet", **given),
    lambda: edges.cornsweet(ramp_width=2, **shape),
    41,
)
pair(
    "Cornsweet edge at 30 degrees",
    lambda: machband.stimulus("cornsweet", orientation_deg=30, **given),
    lambda: edges.cornsweet(ramp_width=2, rotation=30, **shape),
    41,
)
pair("step, linear light", lambda: machband.light(width=0, **given), lambda: edges.step(**shape), 41)

picture = machband.light("kanizsa", size=512)
gray = picture.mean(axis=2, dtype=np.float64)
pair(
    "predict, 512 x 512, against 7 x 6 log-Gabors",
    lambda: machband.predict(picture, window_deg=10),
    lambda: log_gabor_bank(gray, 51.2),
    7,
)
# Its filters are made once, before the time is taken.
odog = ODOG_RHS2007(gray.shape, (-5, 5, -5, 5))
pair(
    "predict, against ODOG of multyscale",
    lambda: machband.predict(picture, window_deg=10),
    lambda: odog.apply(gray),
    7,
)

random = np.random.default_rng(1)
rows = 160_000
frame = pd.DataFrame(
    {
        "subject_id": random.integers(0, 40, rows),
        "width": random.choice([0.1, 0.2, 0.4, 0.8], rows),
        "inv_n": random.choice([1, 0.5, 0.25], rows),
    }
)
latent = -2 * frame.width + 1.5 * frame.inv_n + random.logistic(size=rows)
frame["rating"] = np.digitize(latent, [-0.5, 0.5, 1.5])


def statsmodels():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        model = OrderedModel(frame.rating, frame[["width", "inv_n"]], distr="logit")
        return model.fit(method="bfgs", disp=False)


def ours():
    return machband.analyze(
        frame, subject="subject_id", response="rating", terms=["num:width", "num:inv_n"], random="none", draws=99
    )


with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    mine, other = ours().model, statsmodels()
    print("log-likelihood", mine["loglik"], other.llf)
    print("slopes", [round(c["estimate"], 5) for c in mine["coefficients"]], other.params.iloc[:2].round(5).tolist())
    pair("analyze 160,000 rows, against the fit alone", ours, statsmodels, 3)
