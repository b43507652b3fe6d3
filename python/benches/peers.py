"""Times machband's functions next to other packages', in pairs, one thread each.

    pip install machband-*.whl pandas statsmodels stimupy flip-evaluator
    RAYON_NUM_THREADS=1 OMP_NUM_THREADS=1 python python/benches/peers.py

Prints the median time of each and their ratio.
"""

import os
import statistics
import time
import warnings

os.environ.setdefault("RAYON_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import flip_evaluator
import numpy as np
import pandas as pd
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

# The same pair of pictures, as FLIP takes them.
pictures = [machband.light(width=0.1, depth=depth, size=512) for depth in (1, 3)]
pair(
    "compare, 512 x 512, against FLIP",
    lambda: machband.compare(*pictures, window_deg=10),
    lambda: flip_evaluator.evaluate(*pictures, "LDR", inputsRGB=False, applyMagma=False, parameters={"ppd": 51.2}),
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
