"""What the tests share: the command, and a folder of simulated sessions."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import png
import pytest

import machband


@pytest.fixture
def command(tmp_path):
    """Run a command of the program in a temporary folder, and return what it printed."""

    def run(*words, status=0):
        done = subprocess.run(
            [sys.executable, "-m", "machband", *map(str, words)], cwd=tmp_path, capture_output=True, text=True
        )
        assert done.returncode == status, done.stderr
        return done.stdout if status == 0 else done.stderr

    return run


@pytest.fixture
def image(tmp_path):
    """Read an image that a command wrote as an array of codes."""

    def read(name):
        width, height, rows, info = png.Reader(bytes=(tmp_path / name).read_bytes()).read()
        dtype = np.uint16 if info["bitdepth"] == 16 else np.uint8
        codes = np.vstack([np.asarray(row, dtype) for row in rows]).reshape(height, width, info["planes"])
        # A gray image has one channel.
        return np.broadcast_to(codes, (height, width, 3))

    return read


@pytest.fixture(scope="session")
def sessions(tmp_path_factory):
    """Return a folder with the sessions of six simulated participants, and their rows."""
    folder = tmp_path_factory.mktemp("results")
    rows = machband.simulate("quick", participants=6, seed=5, results=folder)
    return folder, rows


def needs(module):
    """Skip a test if a module is missing, aloud; if the environment requires it, fail."""
    try:
        return __import__(module)
    except ImportError as error:
        if os.environ.get("MACHBAND_REQUIRE_" + module.upper()):
            raise
        return pytest.skip(f"{module} is not installed ({error})")


ROOT = Path(__file__).parent.parent
