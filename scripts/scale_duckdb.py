#!/usr/bin/env python3
"""Fifty million ratings in Parquet, reduced by DuckDB to the counts that `machband analyze` reads; see docs/scale.md.

    python3 scripts/scale_duckdb.py [--machband target/release/machband] [--rows 50000000]

Needs duckdb (PyPI). DuckDB draws the ratings from an ordered logit model with known effects. The script compares the true
effects with the estimates.
"""

import argparse
import json
import math
import os
import subprocess
import tempfile
import time

import duckdb

# The table to reduce has one row per trial. Every SQL dialect supports this query.
QUERY = """
SELECT subject_id, width, depth, orientation_deg, rating, count(*) AS count
FROM ratings
WHERE phase = 'main'
GROUP BY subject_id, width, depth, orientation_deg, rating
"""

GENERATE = """
COPY (
    SELECT 'S' || lpad((i % 500)::VARCHAR, 4, '0') AS subject_id,
           CASE WHEN i % 21 = 0 THEN 'practice' ELSE 'main' END AS phase,
           width, depth, orientation_deg,
           (latent > -2.2)::INT + (latent > -0.7)::INT + (latent > 0.8)::INT AS rating
    FROM (
        SELECT i, width, depth, orientation_deg,
               effect + 0.5 * sin(i % 500) + ln(u / (1 - u)) AS latent
        FROM (
            SELECT i, random() * 0.9999998 + 0.0000001 AS u,
                   [0.02, 0.1, 0.4, 0.8][i // 500 % 4 + 1] AS width,
                   ['1', '2', '3', 'inf'][i // 2000 % 4 + 1] AS depth,
                   [0, 45, 90, 135][i // 8000 % 4 + 1] AS orientation_deg,
                   [0.0, 0.7, 0.4, -0.5][i // 500 % 4 + 1] + [0.0, -1.0, -1.6, -2.6][i // 2000 % 4 + 1] AS effect
            FROM range({rows}) t(i)
        )
    )
) TO '{path}' (FORMAT parquet)
"""


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--machband", default="target/release/machband")
    parser.add_argument("--rows", type=int, default=50_000_000)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as work:
        parquet, counts = f"{work}/ratings.parquet", f"{work}/counts.csv"
        timed("generate", lambda: duckdb.sql(GENERATE.format(rows=options.rows, path=parquet)))
        print(f"{options.rows:,} rows, {os.path.getsize(parquet) / 2**20:.0f} MiB of Parquet")
        view = f"CREATE VIEW ratings AS SELECT * FROM '{parquet}'"
        duckdb.sql(view)
        timed("reduce", lambda: duckdb.sql(f"COPY ({QUERY}) TO '{counts}' (HEADER)"))
        print(f"{sum(1 for _ in open(counts)) - 1:,} rows of counts, {os.path.getsize(counts) / 2**20:.1f} MiB")
        command = [options.machband, "analyze", counts, "--out", f"{work}/analysis"]
        timed("analyze", lambda: subprocess.run(command, check=True))
        model = json.load(open(f"{work}/analysis/model.json"))
        total = duckdb.sql("SELECT count(*) FROM ratings WHERE phase = 'main'").fetchall()[0][0]
        print(f"ratings: {total:,} in Parquet, {model['nobs']:,} in the model")
        # A level may be written in more than one way: 0.1 is 0.10.
        truth = {"width": {0.02: 0, 0.1: 0.7, 0.4: 0.4, 0.8: -0.5}, "depth": {1: 0, 2: -1.0, 3: -1.6, math.inf: -2.6},
                 "orientation_deg": {0: 0, 45: 0, 90: 0, 135: 0}}
        assert model["nobs"] == total and model["coefficients"]
        for coefficient in model["coefficients"]:
            part, (estimate, se) = coefficient["parts"][0], (coefficient["estimate"], coefficient["se"])
            true = truth[part["variable"]][float(part["level"])]
            print(f"{coefficient['name']:20} true {true:5.2f}  estimate {estimate:8.4f} ± {se:.4f}")
            assert abs(estimate - true) < 5 * se, coefficient


def timed(what, work):
    begun = time.perf_counter()
    work()
    print(f"{what}: {time.perf_counter() - begun:.1f} s", flush=True)


main()
