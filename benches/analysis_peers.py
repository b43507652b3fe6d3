#!/usr/bin/env python3
"""Times whole processes: machband's analysis, compared with R's ordinal package and DuckDB's CSV reader.

    python3 benches/analysis_peers.py [--machband target/release/machband] [--runs 7] [--only clm,clmm,rows] [--slow]

The programs of each pair alternate. The script prints median wall times and the median ratio over runs. Needs numpy and
duckdb (PyPI), and Rscript with the package ordinal. --slow adds R's clmm on 160,000 rows, which takes minutes.
"""

import argparse
import os
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

import numpy as np

WIDTHS = {"0.02": 0.0, "0.05": 0.3, "0.1": 0.7, "0.2": 0.9, "0.4": 0.4, "0.8": -0.5}
DEPTHS = {"1": 0.0, "2": -1.0, "3": -1.6, "4": -2.0, "inf": -2.6}
ANGLES = {"0": 0.0, "45": -0.2, "90": 0.0, "135": -0.2}
THRESHOLDS = np.array([-2.2, -0.7, 0.8])

R_READ = """
suppressPackageStartupMessages(library(ordinal))
d <- read.csv(commandArgs(TRUE)[1], colClasses = "character")
d$rating <- factor(d$rating, levels = c("0", "1", "2", "3"), ordered = TRUE)
for (v in c("subject_id", "width", "depth", "orientation_deg")) d[[v]] <- factor(d[[v]])
"""
R_CLM = R_READ + "print(summary(clm(rating ~ width + depth + orientation_deg, data = d)))"
R_CLMM = R_READ + """print(summary(clmm(rating ~ width + depth + orientation_deg + (1 | subject_id), data = d)))"""
DUCKDB = """
import duckdb, sys
duckdb.sql("SET threads = 2")
duckdb.sql(f"COPY (SELECT subject_id, width, depth, orientation_deg, rating, count(*) AS count FROM read_csv('{sys.argv[1]}') {sys.argv[3]} GROUP BY ALL) TO '{sys.argv[2]}' (HEADER)")
"""


def study(path, rows, subjects, seed):
    """A long CSV: every subject's ratings in the design of bangay2003, from an ordered logit with a normal intercept."""
    rng = np.random.default_rng(seed)
    per_subject = rows // subjects
    intercepts = 0.6 * rng.standard_normal(subjects)
    cells = [(w, d, o, a + b + c) for w, a in WIDTHS.items() for d, b in DEPTHS.items() for o, c in ANGLES.items()]
    text = np.array([f"{w},{d},{o}," for w, d, o, _ in cells])
    effect = np.array([cell[3] for cell in cells])
    with open(path, "w") as file:
        file.write("subject_id,width,depth,orientation_deg,rating\n")
        for subject in range(subjects):
            cell = np.arange(per_subject) % len(cells)
            latent = effect[cell] + intercepts[subject] + rng.logistic(size=per_subject)
            rating = (latent[:, None] > THRESHOLDS).sum(axis=1)
            head = f"S{subject + 1:03},"
            file.write("".join(f"{head}{t}{r}\n" for t, r in zip(text[cell], rating)))


def results(path, rows, subjects, seed):
    """The same in the columns of a result file, in sessions of 12 practice trials and 240 main trials."""
    rng = np.random.default_rng(seed)
    cells = [(w, d, o) for w in WIDTHS for d in DEPTHS for o in ANGLES]
    header = ("row_id,experiment,subject_id,session_id,phase,block,trial,attempt,repetition,stimulus,width,depth,"
              "orientation_deg,low,high,color,rating,response_time_s,onset_s,recovery_s,frames,dropped_frames,"
              "started_at,sitting,seed\n")
    with open(path, "w") as file:
        file.write(header)
        written = session = 0
        while written < rows:
            who, visit = f"S{session % subjects + 1:03}", session // subjects + 1
            lines = []
            for i, (rating, seconds) in enumerate(zip(rng.integers(0, 4, 252), rng.lognormal(0.5, 0.4, 252))):
                phase, trial = ("practice", i + 1) if i < 12 else ("main", i - 11)
                w, d, o = cells[i % len(cells)]
                onset = 4.0 * i
                lines.append(
                    f"{who}_{visit}_{phase}_{trial:04}_1,bangay2003,{who},{visit},{phase},1,{trial},1,1,mach-band,{w},{d},{o},"
                    f"0.25,0.75,yellow,{rating},{seconds:.4f},{onset:.4f},2.0000,96,0,2026-01-31T09:30:00.000Z,1,7\n")
            file.write("".join(lines))
            written += 252
            session += 1


def peak_mib(command):
    """Wall time in seconds and peak memory of a process."""
    begun = time.perf_counter()
    child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    _, status, usage = os.wait4(child.pid, 0)
    seconds = time.perf_counter() - begun
    if status != 0:
        sys.exit(f"error: {' '.join(command)}: {child.stderr.read().decode()}")
    return seconds, usage.ru_maxrss / 1024


def pair(name, ours, peer, runs):
    peak_mib(ours)
    mine, theirs, ratios, memory = [], [], [], []
    for _ in range(runs):
        seconds, mib = peak_mib(ours)
        mine.append(seconds)
        memory.append(mib)
        if peer:
            seconds, mib = peak_mib(peer)
            theirs.append(seconds)
            ratios.append(seconds / mine[-1])
    line = f"{name:58} machband {1000 * statistics.median(mine):8.1f} ms, {statistics.median(memory):5.0f} MiB"
    if peer:
        line += f"; peer {1000 * statistics.median(theirs):8.1f} ms, {mib:5.0f} MiB; ratio {statistics.median(ratios):6.1f}"
    print(line, flush=True)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--machband", default="target/release/machband")
    parser.add_argument("--runs", type=int, default=7)
    parser.add_argument("--only", default="clm,clmm,rows")
    parser.add_argument("--rows", type=int, default=10_000_000)
    parser.add_argument("--slow", action="store_true")
    options = parser.parse_args()
    only = options.only.split(",")
    work = tempfile.mkdtemp()
    machband = os.path.abspath(options.machband)

    def analyze(csv, *more):
        named = ["--subject", "subject_id", "--response", "rating", "--terms", "width,depth,orientation_deg"]
        return [machband, "analyze", csv, *named, "--out", f"{work}/out", *more]

    def script(name, text):
        path = f"{work}/{name}"
        with open(path, "w") as file:
            file.write(text)
        return path

    r_clm, r_clmm, duck = script("clm.R", R_CLM), script("clmm.R", R_CLMM), script("duck.py", DUCKDB)
    small, large = f"{work}/1600.csv", f"{work}/160000.csv"
    try:
        study(small, 1_600, 8, 1)
        study(large, 160_000, 8, 2)
        if "clm" in only:
            r = ["Rscript", r_clm, large]
            pair("clm, 160,000 rows, everything", analyze(large, "--random", "none"), r, options.runs)
            pair("clm, 160,000 rows, tables and model", analyze(large, "--random", "none", "--tables-only"), r, options.runs)
        if "clmm" in only:
            r, ours = ["Rscript", r_clmm, small], ["--random", "subject"]
            pair("clmm, 1,600 rows, everything", analyze(small, *ours), r, options.runs)
            pair("clmm, 1,600 rows, tables and model", analyze(small, *ours, "--tables-only"), r, options.runs)
            r = ["Rscript", r_clmm, large] if options.slow else None
            pair("clmm, 160,000 rows of 8 subjects, everything", analyze(large, "--random", "subject"), r, 1 if r else options.runs)
        if "rows" in only:
            for name, make, where, named in [
                ("long", study, "", ["--subject", "subject_id", "--response", "rating", "--factors", "width,depth,orientation_deg"]),
                ("result", results, "WHERE phase = 'main'", []),
            ]:
                path = f"{work}/{name}.csv"
                make(path, options.rows, 200, 3)
                size = os.path.getsize(path) / 2**20
                ours = [machband, "counts", path, *named, "--out", f"{work}/ours.csv"]
                peer = [sys.executable, duck, path, f"{work}/theirs.csv", where]
                pair(f"{options.rows:,} rows, {name} layout, {size:.0f} MiB", ours, peer, options.runs)
                os.remove(path)
    finally:
        shutil.rmtree(work)


main()
