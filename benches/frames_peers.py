#!/usr/bin/env python3
"""Compares the frame times of machband and PsychoPy on the same screen.

machband draws the screen of a trial (`machband timing --scene trial`); PsychoPy draws one image of 512 x 512 pixels
(draw + flip). The two alternate, so that a slowdown of the machine affects both. Under Xvfb, nothing waits for a
refresh, so the interval between frames is the cost of a frame.

    Xvfb :20 -screen 0 1920x1080x24 &
    python3 -m venv peers && peers/bin/pip install --no-deps psychopy==2026.2.5
    peers/bin/pip install pyglet==1.5.27 numpy pillow scipy pandas matplotlib packaging pyyaml requests freetype-py \\
        opencv-python-headless json_tricks python-bidi arabic-reshaper openpyxl pyparsing msgpack gevent tables \\
        msgpack-numpy psutil six
    cargo build --release -p tools
    DISPLAY=:20 python3 benches/frames_peers.py --machband target/release/machband --python peers/bin/python \\
        --bare "target/release/tools bare-window"

Prints a line per pair, and then medians, 99th percentiles and ratios. The exit status is 1 if a program fails.
"""

import argparse
import csv
import os
import shlex
import statistics
import subprocess
import sys
import tempfile

PEER = """
import sys, time
from psychopy import core, visual
import numpy as np
size, frames, full = eval(sys.argv[1]), int(sys.argv[2]), sys.argv[3] == "1"
window = visual.Window(size=size, units="pix", fullscr=full, waitBlanking=False, checkTiming=False, screen=0)
image = visual.ImageStim(window, image=np.random.rand(512, 512) * 2 - 1, size=(512, 512), units="pix")
image.draw(); window.flip()
for _ in range(30):
    image.draw(); window.flip()
times = []
last = time.perf_counter()
for _ in range(frames):
    image.draw(); window.flip()
    now = time.perf_counter(); times.append(now - last); last = now
print("RESULT", " ".join(f"{t:.6f}" for t in times))
window.close(); core.quit()
"""


def percentile(values, share):
    values = sorted(values)
    return values[min(len(values) - 1, max(0, int(-(-share * len(values) // 1)) - 1))]


def machband(arguments):
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "intervals.csv")
        command = [arguments.machband, "timing", "--scene", "trial", "--frames", str(arguments.frames), "--out", out]
        command += ["--fullscreen"] if arguments.fullscreen else ["--windowed"]
        done = subprocess.run(command, capture_output=True, text=True, timeout=600)
        if done.returncode != 0:
            sys.exit(f"machband timing failed:\n{done.stderr}")
        with open(out, newline="") as file:
            return [int(row["interval_us"]) * 1e-3 for row in csv.DictReader(file)]


def psychopy(arguments):
    size = arguments.size if arguments.fullscreen else arguments.window
    full = "1" if arguments.fullscreen else "0"
    return measure("PsychoPy", [arguments.python, "-c", PEER, repr(size), str(arguments.frames), full])


def measure(name, command):
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    line = next((line for line in done.stdout.splitlines() if line.startswith("RESULT")), None)
    if line is None:
        sys.exit(f"{name} failed:\n{done.stdout}\n{done.stderr}")
    # The bare window also prints when its first frame was submitted.
    numbers = [float(number) for number in line.split()[1:]]
    return [seconds * 1e3 for seconds in numbers if seconds < 1e6]


def pair(text):
    width, height = text.split("x")
    return int(width), int(height)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--machband", required=True, help="the release binary")
    parser.add_argument("--python", default=sys.executable, help="a Python with PsychoPy installed")
    parser.add_argument("--bare", help="the command of the bare-window tool, to measure the cost of an empty frame")
    parser.add_argument("--frames", type=int, default=300)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--fullscreen", action="store_true", help="needs a window manager for machband")
    parser.add_argument("--size", type=pair, default=(1920, 1080), help="the screen, WIDTHxHEIGHT")
    parser.add_argument("--window", type=pair, default=(1100, 860), help="the window, WIDTHxHEIGHT; the default is machband's own size")
    arguments = parser.parse_args()
    runs = {"machband": [], "PsychoPy": []}
    if arguments.bare:
        runs["bare window"] = []
    for turn in range(arguments.rounds):
        order = list(runs)
        # The programs take turns to run first.
        order = order[turn % len(order) :] + order[: turn % len(order)]
        for name in order:
            if name == "PsychoPy":
                run = psychopy(arguments)
            elif name == "bare window":
                run = measure(name, [*shlex.split(arguments.bare), str(arguments.frames)])
            else:
                run = machband(arguments)
            runs[name].append(run)
            median = statistics.median(run)
            print(f"{turn + 1}  {name:<15} median {median:7.3f} ms  99 % {percentile(run, 0.99):7.3f} ms", flush=True)
    print()
    peer = runs["PsychoPy"]
    for name, found in runs.items():
        medians = [statistics.median(run) for run in found]
        tails = [percentile(run, 0.99) for run in found]
        ratio = statistics.median(statistics.median(run) / statistics.median(other) for run, other in zip(found, peer))
        print(
            f"{name:<15} median {statistics.median(medians):7.3f} ms ({min(medians):.3f} to {max(medians):.3f})"
            f"  99 % {statistics.median(tails):7.3f} ms  of PsychoPy's: {ratio:.2f}"
        )


if __name__ == "__main__":
    main()
