#!/usr/bin/env python3
"""Compares machband's ODOG (Blakeslee & McCourt 1999) with multyscale's on the same image.

multyscale (computational-psychology/multyscale, MIT license) constructs the model's filters, `ODOG_RHS2007(shape, extent)`,
and then runs the model, `.apply(picture)`. machband does the same two steps. The image is a linear ramp between plateaus,
512 x 512 pixels at 32 pixels per degree. The two alternate, so that a slowdown of the machine affects both. Each run is a
separate process. The first round also compares the responses, if machband writes one.

    python3 -m venv peers && peers/bin/pip install numpy scipy
    git clone https://github.com/computational-psychology/multyscale && git -C multyscale checkout 5d29c68e49ed   # 0.2.0
    peers/bin/pip install --no-deps ./multyscale
    cargo build --release -p tools
    python3 benches/odog_peers.py --python peers/bin/python \\
        --machband-command "target/release/tools odog {size} {ppd} {out}"

The script fills in {size}, {ppd} and {out} in the command. The command prints `construct_s SECONDS run_s SECONDS`; if it does
not, its wall time counts as the sum of both. If it uses {out}, it writes its response there as float32 in native byte
order, row by row. Set `OPENBLAS_NUM_THREADS` and similar variables in the environment; this script sets none.

Prints a line per run, and then medians and ratios. The exit status is 1 if a program fails.
"""

import argparse
import array
import os
import re
import shlex
import statistics
import subprocess
import sys
import tempfile
import time

PEER = """
import sys, time
import numpy as np
import multyscale
size, ppd, out = int(sys.argv[1]), float(sys.argv[2]), sys.argv[3]
half = (size - 1) / 2 / ppd
ramp = np.clip((np.arange(size) / size - 0.4) / 0.2, 0, 1)
picture = np.tile(0.25 + 0.5 * ramp, (size, 1))
began = time.perf_counter()
model = multyscale.models.ODOG_RHS2007((size, size), (-half, half, -half, half))
made = time.perf_counter()
response = model.apply(picture)
done = time.perf_counter()
response.astype(np.float32).tofile(out)
print("construct_s", made - began, "run_s", done - made)
"""

TIMES = re.compile(r"construct_s\s+(\S+)\s+run_s\s+(\S+)")


def timed(name, command):
    """Seconds to construct (None if the program does not report it) and to run."""
    began = time.perf_counter()
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=1800)
    except (OSError, subprocess.TimeoutExpired) as error:
        sys.exit(f"{name} failed: {error}")
    wall = time.perf_counter() - began
    if done.returncode != 0:
        sys.exit(f"{name} failed:\n{done.stdout}\n{done.stderr}")
    times = TIMES.search(done.stdout)
    return (float(times[1]), float(times[2])) if times else (None, wall)


def response(path):
    values = array.array("f")
    with open(path, "rb") as file:
        values.frombytes(file.read())
    return values


def compare(ours, peer):
    """The correlation, and the largest difference as a fraction of multyscale's range."""
    if len(ours) != len(peer):
        return f"different sizes: {len(ours)} and {len(peer)} values"
    spread = max(peer) - min(peer)
    worst = max(abs(a - b) for a, b in zip(ours, peer)) / spread
    return f"correlation {statistics.correlation(ours, peer):.9f}, largest difference {worst:.2e} of the range"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--machband-command", required=True, help="a command with {size}, {ppd} and, to compare responses, {out}")
    parser.add_argument("--python", default=sys.executable, help="a Python with multyscale installed")
    parser.add_argument("--size", type=int, default=512, help="pixels per side")
    parser.add_argument("--px-per-deg", type=float, default=32.0)
    parser.add_argument("--rounds", type=int, default=5)
    arguments = parser.parse_args()
    runs = {"machband": [], "multyscale": []}
    with tempfile.TemporaryDirectory() as folder:
        out = {name: os.path.join(folder, name) for name in runs}
        filled = {"size": arguments.size, "ppd": arguments.px_per_deg, "out": shlex.quote(out["machband"])}
        size, ppd = str(arguments.size), str(arguments.px_per_deg)
        commands = {
            "machband": shlex.split(arguments.machband_command.format(**filled)),
            "multyscale": [arguments.python, "-c", PEER, size, ppd, out["multyscale"]],
        }
        for turn in range(arguments.rounds):
            # The programs take turns to run first.
            for name in list(runs) if turn % 2 == 0 else list(runs)[::-1]:
                construct, run = timed(name, commands[name])
                runs[name].append((construct, run))
                made = "" if construct is None else f"construct {construct:8.3f} s  "
                print(f"{turn + 1}  {name:<10} {made}run {run:8.3f} s", flush=True)
            if turn == 0 and os.path.exists(out["machband"]):
                print("   " + compare(response(out["machband"]), response(out["multyscale"])), flush=True)
    print()
    peers = runs["multyscale"]
    for name, found in runs.items():
        steps = [("construct", 0), ("run", 1)]
        if any(construct is None for construct, _ in found):
            steps = [("wall", 1)]
        for step, at in steps:
            times = [run[at] for run in found]
            theirs = [sum(run) if step == "wall" else run[at] for run in peers]
            ratio = statistics.median(other / own for own, other in zip(times, theirs))
            print(
                f"{name:<10} {step:<9} median {statistics.median(times):8.3f} s"
                f" ({min(times):.3f} to {max(times):.3f})  multyscale takes {ratio:.1f} times as long"
            )


if __name__ == "__main__":
    main()
