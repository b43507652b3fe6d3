"""The examples in the docstrings, the recipes and the notebook run and print what they say."""

import doctest
import importlib
import pkgutil
import warnings

import pytest

import machband
from conftest import ROOT, needs

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
