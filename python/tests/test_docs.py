"""The examples in the docstrings, the recipes and the notebook run and print what they say; and what type checkers and
completion know about the package."""

import doctest
import importlib
import pkgutil
import subprocess
import sys
import typing
import warnings

import pytest

import machband
from conftest import ROOT, needs
from machband import _stimulus

MODULES = [f"machband.{module.name}" for module in pkgutil.iter_modules(machband.__path__)]


@pytest.mark.parametrize("name", [name for name in MODULES if not name.endswith(("__main__", "_machband"))])
def test_docstrings(name):
    if name.endswith(".psychopy"):
        # Its own warnings do not matter here.
        warnings.simplefilter("ignore")
        needs("psychopy")
    module = importlib.import_module(name)
    assert doctest.testmod(module, globs={**vars(machband), **vars(module)}).failed == 0


def test_every_public_function_is_documented():
    for name, member in vars(machband).items():
        assert name.startswith("_") or member.__doc__, name


def test_the_recipes(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = doctest.testfile(str(ROOT.parent / "docs" / "python.md"), module_relative=False, encoding="utf-8",
                            optionflags=doctest.NORMALIZE_WHITESPACE)
    assert done.failed == 0 and done.attempted > 20


def test_the_notebook(tmp_path):
    needs("nbclient")
    import nbclient
    import nbformat

    book = nbformat.read(ROOT / "examples" / "tour.ipynb", as_version=4)
    nbclient.NotebookClient(book, timeout=300, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}}).execute()
    outputs = [output for cell in book.cells if cell.cell_type == "code" for output in cell.outputs]
    kinds = [kind for output in outputs for kind in output.get("data", {})]
    assert kinds.count("image/png") >= 3 and "image/svg+xml" in kinds and "text/html" in kinds
    assert not [output for output in outputs if output.output_type == "error"]


MISTAKES = [
    "stimuli.mach_band(wdith=0.2)",
    'stimuli.mach_band(width="0.2")',
    'stimuli.mach_band(space="hvs")',
    'stimuli.shaded_mesh(shader="phnog")',
    "stimuli.chevreul().codes(bits=12)",
    'machband.stimulus(dither="blue_noise")',
    'machband.analyze({}, link="probt")',
    'machband.shade("blob", highlight="fong")',
    'machband.shade("blob", shader="phnog")',
    'machband.export("a", "b", "bdis")',
    'machband.parameters("mach_band")',
    "machband.stimulus(wdith=0.2)",
    'machband.predict("mach-band", space="hvs")',
]


@pytest.mark.parametrize("checker", ["mypy", "pyright"])
def test_typical_mistakes_are_found(checker, tmp_path):
    needs(checker)
    file = tmp_path / "mistakes.py"
    right = ["stimuli.mach_band(width=0.2, depth='inf')", "machband.stimulus('kanizsa', size=64, side=0.5)",
             "machband.analyze({}, missing=-99, categories=[1, 2, 3], exclude=range(3))",
             "machband.analyze({}, categories=machband.mesh()[1], only={'a': machband.mesh()[0]})",
             "[machband.light(kind, **stimuli.mach_band().parameters) for kind in machband.kinds()]"]
    file.write_text("\n".join(["import machband", "from machband import stimuli", *MISTAKES, *right, ""]))
    words = ["--pythonpath", sys.executable] if checker == "pyright" else []
    done = subprocess.run([sys.executable, "-m", checker, *words, str(file)], cwd=tmp_path, capture_output=True, text=True)
    lines = {int(line.split(".py:")[1].split(":")[0]) for line in done.stdout.splitlines() if "error:" in line or "- error" in line}
    assert lines == set(range(3, 3 + len(MISTAKES))), done.stdout + done.stderr


def test_completion_offers_the_parameters():
    needs("jedi")
    import jedi

    for code, name in [("mach_band(wi", "width="), ("mach_band().codes(di", "dither=")]:
        found = jedi.Script(f"import machband\nmachband.stimuli.{code}").complete(2, len(f"machband.stimuli.{code}"))
        assert [one.name for one in found] == [name]


def test_the_stimuli_are_those_of_the_library():
    script = ROOT.parent / "scripts" / "generate_stimuli.py"
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, check=True)
    assert done.stdout == (ROOT / "machband" / "stimuli.py").read_text(), "run scripts/generate_stimuli.py"
    assert set(typing.get_args(_stimulus.Kind)) == set(machband.kinds())
    for kind in machband.kinds():
        made = getattr(machband.stimuli, kind.replace("-", "_"))(size=32)
        assert made == machband.Stimulus(kind, size=32)
