#!/usr/bin/env bash
# Makes a data set that contains everything an export must handle, exports it in every format, and runs the validators:
# `scripts/validate_exports.sh [FOLDER]`. Needs Python 3 with venv; installs the BIDS validator in target/validators.
set -euo pipefail
cd "$(dirname "$0")/.."

folder=${1:-$(mktemp -d)}
mkdir -p "$folder"
results=$folder/results
# PROGRAMS names a folder that contains the programs machband and tools; if it is not set, Cargo builds both.
run() {
    local program=$1
    shift
    if [ -n "${PROGRAMS:-}" ]; then
        "$PROGRAMS/$program" "$@"
    else
        cargo run --quiet --package "$program" -- "$@"
    fi
}

# Eight simulated participants with practice trials. S001 corrects a response, is interrupted while a row is written,
# and resumes. In another task, S001 has answered questions.
run tools sample-study "$results"
run machband simulate quick --participants 8 --results "$results" --resume
run machband simulate examples/quick-ja.toml --participants 1 --results "$results" --resume
grep -q $'^sub-S001\t27\tother\t' "$results/quick-ja/participants.tsv"
# A task with shaded meshes.
run machband simulate shaders --participants 1 --results "$results"
# Every other task.
run machband simulate threshold-width --participants 2 --results "$results"
run machband simulate pairs-shaders --participants 1 --results "$results"
for task in yes-no nulling slider; do
    run machband simulate "examples/tasks/$task.toml" --participants 2 --results "$results"
done
for format in bids psych-ds; do
    run machband export "$results" --format "$format" --out "$folder/$format"
done
run machband verify "$folder/psych-ds"

venv=${CARGO_TARGET_DIR:-target}/validators
if ! "$venv/bin/bids-validator-deno" --version >/dev/null 2>&1; then
    python3 -m venv "$venv"
    "$venv/bin/pip" install --quiet 'bids-validator-deno==3.0.*'
fi
echo '--- BIDS'
# Fails on any error, and on any warning that docs/data.md does not explain.
status=0
NO_COLOR=1 "$venv/bin/bids-validator-deno" "$folder/bids" >"$folder/bids.txt" || status=$?
cat "$folder/bids.txt"
if [ "$status" != 0 ]; then
    echo 'error: the BIDS data set is not valid' >&2
    exit 1
fi
explained='JSON_KEY_RECOMMENDED|SIDECAR_KEY_RECOMMENDED|NO_AUTHORS|TOO_FEW_AUTHORS'
if grep -E '\[WARNING\]' "$folder/bids.txt" | grep -vE "\] ($explained) "; then
    echo 'error: the BIDS validator gives a warning that docs/data.md does not explain' >&2
    exit 1
fi

echo '--- Psych-DS'
python3 scripts/check_psych_ds.py "$results"/* "$folder"/psych-ds/*
python3 scripts/check_psych_ds.py --self-test "$folder/psych-ds/quick"
