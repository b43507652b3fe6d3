#!/usr/bin/env bash
# Installs a wheel in a new environment and tests it: scripts/check_python.sh WHEEL
#
# Runs the tests of the package, with the recipes, the notebook and, under Xvfb, PsychoPy; then checks the types. Needs
# Python 3.10 to 3.12 with venv, and xvfb-run.
set -euo pipefail
cd "$(dirname "$0")/.."
wheel=$(realpath "$1")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

python3 -m venv "$work/venv"
python=$work/venv/bin/python
"$python" -m pip install --quiet -r python/tests/requirements.txt "$wheel"
# PsychoPy's own requirements would add a gigabyte of packages for devices and movies.
"$python" -m pip install --quiet --no-deps psychopy pyglet==1.5.27
# Not in python/, where Python would find the package's source without its extension module.
cd python/tests
MACHBAND_REQUIRE_PSYCHOPY=1 MACHBAND_REQUIRE_NBCLIENT=1 xvfb-run -a -s '-screen 0 1024x768x24' \
    "$python" -B -m pytest -q -p no:cacheprovider -c ../pyproject.toml --durations=5 .
cd "$work"
config=$OLDPWD/../pyproject.toml
"$python" -m mypy -p machband --config-file "$config"
# What stubtest cannot compare: aliases of literals; the accessors that PsychoPy adds to its classes; and the list of what
# the extension module exports, which nobody imports with a star.
cat >allowed.txt <<'END'
machband\._common\.Dither
machband\.psychopy\.MachBandStim\..*
machband\._stimulus\.Kind
machband\.stimuli\.(Shader|Shape)
machband\._machband\.__all__
END
xvfb-run -a "$python" -m mypy.stubtest machband --mypy-config-file "$config" --ignore-disjoint-bases --allowlist allowed.txt
