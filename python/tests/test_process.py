"""The package as a guest in a process: threads, forks, Ctrl+C, memory, and what is not installed."""

import gc
import multiprocessing
import os
import re
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import machband
from conftest import needs

on_linux = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc and sends signals of Linux")


def test_eight_threads_at_once():
    work = [
        lambda: machband.stimulus(size=256, dither="random").tobytes(),
        lambda: machband.stimulus("shaded-mesh", size=96).tobytes(),
        lambda: machband.predict("kanizsa", size=128).detection,
        lambda: machband.shade("torus", size=64).metrics["crease_rms"],
        lambda: machband.simulate("quick", seed=2).rating.tolist(),
        lambda: machband.Definition("bangay2003").schedule(seed=4).condition.tolist(),
        lambda: machband.analyze({"subject_id": [1, 1, 2, 2] * 9, "rating": [0, 1, 2, 3] * 9, "a": [1, 2] * 18},
                                 factors=["a"], draws=99).files["cells.csv"],
        lambda: machband.interpolate(np.linspace(0, 1, 1000), 5).tolist(),
    ]
    alone = [job() for job in work]
    with ThreadPoolExecutor(8) as threads:
        for _ in range(4):
            assert [future.result() for future in [threads.submit(job) for job in work]] == alone


def test_other_threads_run_meanwhile():
    thread = threading.Thread(target=lambda: machband.steps(machband.stimulus(size=1024), window_deg=20))
    longest, last = 0.0, time.perf_counter()
    thread.start()
    while thread.is_alive():
        time.sleep(0.001)
        longest, last = max(longest, time.perf_counter() - last), time.perf_counter()
    # The lock is never held for the whole computation, which takes seconds.
    assert longest < 1


def test_a_forked_process_works():
    machband.analyze(machband.simulate("quick", participants=2), draws=99)
    if "fork" not in multiprocessing.get_all_start_methods():
        pytest.skip("this system cannot fork")
    child = os.fork()
    if child == 0:
        found = machband.predict("kanizsa", size=64).detection >= 0 and len(machband.simulate("quick")) == 28
        os._exit(0 if found else 1)
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            assert status == 0
            return
        time.sleep(0.05)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    pytest.fail("the child process hangs")


@on_linux
@pytest.mark.parametrize("delay", [0.4, 1.2, 2.4])
def test_ctrl_c_stops_a_large_picture_at_once(delay):
    code = (
        "import machband, time\nprint('ready', flush=True)\n"
        "try:\n    [machband.shade('torus', size=8192, metrics=False) for _ in range(9)]\n"
        "except KeyboardInterrupt:\n    print(time.monotonic())"
    )
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "ready\n"
    time.sleep(delay)
    start = time.monotonic()
    process.send_signal(signal.SIGINT)
    # On a busy machine, this takes longer than the 0.2 s that it takes alone.
    assert float(process.communicate(timeout=60)[0]) - start < 1


@on_linux
@pytest.mark.parametrize(
    "work",
    [
        "machband.analyze(machband.simulate('bangay2003', participants=8), draws=1_000_000)",
        "machband.simulate('bangay2003', participants=1_000_000)",
        "[machband.steps(machband.stimulus(size=2048), window_deg=30) for _ in range(100)]",
        "[machband.stimulus('kanizsa', size=16384) for _ in range(100)]",
        "[machband.shade('blob', n_vertices=20000, size=4096) for _ in range(100)]",
    ],
)
def test_ctrl_c_stops_long_work(work, tmp_path):
    code = (
        "import machband, time\n"
        f"print('ready', flush=True)\ntry:\n    {work}\n"
        "except KeyboardInterrupt:\n    before = time.process_time(); time.sleep(1)\n"
        "    print(time.process_time() - before)"
    )
    environment = {**os.environ, "TMPDIR": str(tmp_path)}
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, cwd=tmp_path, env=environment)
    assert process.stdout.readline() == b"ready\n"
    time.sleep(2)
    start = time.monotonic()
    process.send_signal(signal.SIGINT)
    busy, _ = process.communicate(timeout=60)
    assert process.returncode == 0 and time.monotonic() - start < 15
    # No thread continues the work.
    assert float(busy) < 0.5
    # Nothing is left behind.
    assert not list(tmp_path.iterdir())


@on_linux
def test_ctrl_c_stops_a_large_array():
    start = time.perf_counter()
    machband.interpolate(values := np.full(20_000_000, 0.5), 9)
    whole = time.perf_counter() - start
    signal.signal(signal.SIGALRM, signal.default_int_handler)
    signal.setitimer(signal.ITIMER_REAL, whole / 4)
    with pytest.raises(KeyboardInterrupt):
        machband.interpolate(values, 9)
    assert time.perf_counter() - start < 1.8 * whole


def resident():
    """Return the memory of this process in MB."""
    return int(re.search(r"VmRSS:\s+(\d+)", Path("/proc/self/status").read_text())[1]) / 1024


@on_linux
def test_two_thousand_calls_leak_nothing():
    codes = machband.stimulus("kanizsa", size=48)
    definition = machband.Definition("quick")
    mesh = machband.mesh("cube")

    def call():
        machband.stimulus(size=64)
        machband.light(size=32)
        machband.profile(size=64)
        machband.interpolate(np.zeros(1000), 3)
        machband.compare(codes, codes, window_deg=2)
        machband.predict(width=0.1)
        machband.shade(*mesh, size=32, metrics=False)
        definition.schedule()
        with pytest.raises(machband.Error):
            machband.stimulus(wdith=1)

    def calls(number):
        for _ in range(number):
            call()
        gc.collect()
        return resident()

    before = calls(50)
    # Nine calls in each turn. A leak of 3 kB a call is noticed.
    after = calls(200)
    assert after - before < 5, f"{before} MB, then {after} MB"


def test_without_pandas_tables_are_dicts():
    code = (
        "import sys; sys.modules['pandas'] = None; sys.modules['tqdm'] = None\n"
        "import machband, numpy\n"
        "rows = machband.simulate('quick', participants=2)\n"
        "assert type(rows) is dict and rows['width'].dtype == float and rows['started_at'].dtype == 'datetime64[ms]'\n"
        "found = machband.analyze(rows, draws=99)\n"
        "assert type(found.tables['cells']) is dict and 'pandas' not in repr(sys.modules.get('machband'))\n"
        "try: machband.simulate('quick', observer='x')\n"
        "except machband.Error as error: assert error.__context__ is None\n"
        "print(len(rows['rating']))"
    )
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "56\n"


def test_the_command_is_the_program(command):
    assert command("--version").strip() == f"machband {machband.__version__}"
    assert "did you mean" in command("simulate", "qiuck", status=1)
    assert "error:" in command("stimulus", status=2)
    assert "Usage:" in command("--help")


@on_linux
def test_the_command_ends_on_ctrl_c(tmp_path):
    process = subprocess.Popen(
        [sys.executable, "-m", "machband", "simulate", "bangay2003", "--participants", "100000"], cwd=tmp_path,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    time.sleep(3)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130 and b"--resume" in errors


# Its own warnings do not matter here.
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("window_size", [(300, 300), (301, 299)])
def test_psychopy_shows_the_codes(window_size):
    needs("psychopy")
    from psychopy import visual

    from machband.psychopy import MachBandStim

    window = visual.Window(window_size, units="pix", fullscr=False, allowGUI=False, checkTiming=False)
    try:
        for size in [128, 201]:
            stim = MachBandStim(window, size=size, color="gray", units="pix")
            # The graphics card has the picture already.
            assert stim._drawn == (size, True)
            for width in [0.1, 0.4]:
                stim.width = width
                stim.set(low=0.8, high=0.9, orientation_deg=30)
                expected = machband.stimulus(size=size, width=width, low=0.8, high=0.9, orientation_deg=30, color="gray")
                stim.draw()
                frame = np.asarray(window.getMovieFrame(buffer="back"))
                top, left = ((frame.shape[axis] - size) // 2 for axis in (0, 1))
                near = [frame[y : y + size, x : x + size] for y in (top, top + 1) for x in (left, left + 1)]
                assert any(np.array_equal(shown, expected) for shown in near)
                assert min(machband.compare(shown, stim.codes(), ppd=20).times_threshold for shown in near) == 0
                window.flip()
        stim.ori, stim.opacity, stim.pos = 45, 0.5, (3, 4)
        stim.draw()
        assert (stim.ori, stim.opacity, stim.width, tuple(stim.pos)) == (45, 0.5, 0.4, (3, 4))
        stim.set(depth="inf", high=0.85)
        visual.Rect(window, autoDraw=True)
        stim.autoDraw = True
        window.flip()
        assert stim._drawn == (201, True) and stim.depth == "inf"
        stim.setAutoDraw(False)
        stim.setOri(90, log=False)
        assert stim.ori == 90
        with pytest.raises(AttributeError, match="did you mean 'width'"):
            stim.widht = 0.2
        for name in ["contrast", "kind", "parameters", "ppd", "visual_size", "steps", "shader", "colorSpace", "sf", "image", "bits"]:
            with pytest.raises(AttributeError, match=f"'{name}' cannot be set"):
                setattr(stim, name, stim.kind)
        for given in [{"steps": 3}, {"sf": 2}, {"colorSpace": "rgb"}, {"kind": "mach_band"}]:
            with pytest.raises(machband.Error, match="expected one of"):
                MachBandStim(window, **given)
        for given in [{"ppd": 30}, {"visual_size": 5}, {"size": 5}, {"kind": "chevreul"}]:
            with pytest.raises(TypeError, match="is not a parameter; expected size and units"):
                stim.set(**given)
        stim.status, stim.pos = 1, (3, 4)
        with pytest.raises(machband.Error, match="size is -5"):
            stim.size = -5
        with pytest.raises(machband.Error, match='dither "bad" is not known'):
            stim.dither = "bad"
        assert (stim.size, stim.dither) == (201, "none")
        with pytest.raises(machband.Error, match="below low"):
            stim.low = 0.95
        # PsychoPy linearizes the display.
        window.__dict__["gamma"] = [2.2, 2.2, 2.2]
        assert np.array_equal(stim.codes(), machband.stimulus(size=201, transfer="linear", **stim.parameters))
        with pytest.raises(machband.Error, match="the window linearizes the display"):
            stim.transfer = "srgb"
    finally:
        window.close()
