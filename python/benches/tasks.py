"""Does ten tasks with machband and with other packages, and prints the lines that each needs and the median of its times.

    pip install machband-*.whl pandas matplotlib pillow statsmodels stimupy
    pip install --no-deps psychopy pyglet==1.5.27
    RAYON_NUM_THREADS=1 OMP_NUM_THREADS=1 xvfb-run -a python python/benches/tasks.py
"""

import os
import statistics
import tempfile
import time
import warnings

SETUP = """
import machband, matplotlib, numpy as np, pandas as pd
from machband.psychopy import MachBandStim
from PIL import Image
from psychopy import data, visual
from statsmodels.miscmodels.ordinal_model import OrderedModel
from stimupy.components import edges
from stimupy.utils import plot_stim
matplotlib.use("Agg")
random = np.random.default_rng(1)
window = visual.Window((600, 600), units="pix", allowGUI=False, checkTiming=False)
frame = pd.DataFrame({"person": np.repeat(np.arange(12), 40), "dose": np.tile(["none", "little", "lots", "max"], 120)})
frame["rating"] = random.binomial(4, frame.dose.map({"none": .3, "little": .4, "lots": .5, "max": .6}))
levels = ["none", "little", "lots", "max"]
ramp = {"ppd": 64, "visual_size": 8}
ours = machband.analyze(frame, subject="person", factors={"dose": levels}, random="none", draws=99)
dummies = pd.get_dummies(pd.Categorical(frame.dose, levels), drop_first=True, dtype=float)
theirs = OrderedModel(frame.rating, dummies, distr="logit").fit(method="bfgs", disp=False)
"""

#: The peer, the task, and the code of machband and of the peer.
TASKS = [
    ("stimupy", "a Cornsweet edge as light", "machband.stimuli.cornsweet(**ramp).light",
     "edges.cornsweet(ramp_width=1.6, exponent=1, intensity_edges=(0.4, 0.6), **ramp)['img']"),
    ("stimupy", "its codes for an sRGB display", "machband.stimuli.cornsweet(**ramp).codes()", """
light = edges.cornsweet(ramp_width=1.6, exponent=1, intensity_edges=(0.4, 0.6), **ramp)["img"]
encoded = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
codes = np.round(255 * np.repeat(encoded[:, :, np.newaxis], 3, axis=2)).astype(np.uint8)
"""),
    ("stimupy", "a ramp at 30° without kinks, n = 3", "machband.stimuli.mach_band(width=0.3, depth=3, orientation_deg=30, **ramp).light", """
y, x = np.mgrid[:512, :512] / 512 + 0.5 / 512 - 0.5
u = np.clip((x * np.cos(np.pi / 6) - y * np.sin(np.pi / 6)) / 0.3 + 0.5, 0, 1)
light = 0.25 + 0.5 * u ** 3 * (6 * u ** 2 - 15 * u + 10)
"""),
    ("stimupy", "a step in a plot with degrees", "machband.stimuli.mach_band(width=0, color='gray', **ramp).plot()",
     "plot_stim(edges.step(**ramp))"),
    ("statsmodels", "an ordinal model of ratings by doses in their order",
     "machband.analyze(frame, subject='person', factors={'dose': levels}, random='none', draws=99)", """
x = pd.get_dummies(pd.Categorical(frame.dose, levels), drop_first=True, dtype=float)
OrderedModel(frame.rating, x, distr="logit").fit(method="bfgs", disp=False)
"""),
    ("statsmodels", "probabilities of the ratings for each dose", "ours.predict({'dose': levels})",
     "theirs.model.predict(theirs.params, exog=np.eye(4)[:, 1:])"),
    ("statsmodels", "estimates with intervals in a table", "ours.conf_int().assign(estimate=ours.params)",
     "theirs.conf_int().assign(estimate=theirs.params)"),
    ("PsychoPy", "ten trials of ramps of two widths in random order", """
stim = MachBandStim(window, size=512, color="gray")
trials = machband.Definition.from_dict({"schema": 1, "name": "widths", "stimulus": {"kind": "mach-band"},
    "factors": {"width": [0.1, 0.4]}, "design": {"repetitions": 5}}).schedule("P001", seed=1)
for width in trials.width:
    stim.width = width
    stim.draw()
    window.flip()
""", """
x = (np.arange(512) + 0.5) / 512 - 0.5
images = {}
for width in [0.1, 0.4]:
    light = 0.25 + 0.5 * np.clip(x / width + 0.5, 0, 1)
    codes = np.round(255 * (1.055 * light ** (1 / 2.4) - 0.055)).astype(np.uint8)
    image = Image.fromarray(np.tile(codes, (512, 1)))
    images[width] = visual.ImageStim(window, image, size=512, interpolate=False)
trials = data.TrialHandler([{"width": 0.1}, {"width": 0.4}], 5, seed=1)
for trial in trials:
    images[trial["width"]].draw()
    window.flip()
"""),
    ("PsychoPy", "the pixels that were drawn, compared with the stimulus", """
stim = MachBandStim(window, size=512, color="gray")
stim.draw()
shown = np.asarray(window.getMovieFrame(buffer="back"))[44:556, 44:556]
machband.compare(shown, stim.codes(), ppd=64).times_threshold
""", """
codes = np.tile(np.linspace(100, 200, 512).astype(np.uint8), (512, 1))
visual.ImageStim(window, Image.fromarray(codes), size=512, interpolate=False).draw()
shown = np.asarray(window.getMovieFrame(buffer="back"))[44:556, 44:556, 0]
np.abs(shown.astype(int) - codes).max()
"""),
    ("PsychoPy", "two thresholds, each from 40 simulated trials (QUEST+; QUEST)", "machband.simulate('threshold-width')", """
for orientation in [0, 90]:
    quest = data.QuestHandler(0.3, 0.2, pThreshold=0.82, gamma=0.5, nTrials=40, minVal=0, maxVal=0.8)
    for width in quest:
        quest.addResponse(int(random.random() < 1 - 0.5 * np.exp(-(width / 0.3) ** 3)))
"""),
]


def lines(code):
    return sum(1 for line in code.splitlines() if line.strip())


def timed(code, names):
    start = time.perf_counter()
    exec(code, names)
    return 1e3 * (time.perf_counter() - start)


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    os.chdir(tempfile.mkdtemp())
    names = {}
    exec(SETUP, names)
    print("| task | lines | time | peer | lines | time |\n|---|---:|---:|---|---:|---:|")
    for peer, task, ours, theirs in TASKS:
        for code in (ours, theirs):
            timed(code, names)
        rounds = [(timed(ours, names), timed(theirs, names)) for _ in range(7)]
        mine, other = (statistics.median(column) for column in zip(*rounds, strict=True))
        print(f"| {task} | {lines(ours)} | {mine:.1f} ms | {peer} | {lines(theirs)} | {other:.1f} ms |", flush=True)
