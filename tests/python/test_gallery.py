"""The notebooks of docs/gallery run: in a kernel where nbclient is installed, else cell by cell."""

import ast
import json
import re

import pytest
from conftest import PROGRAM, ROOT

GALLERY = ROOT / "docs/gallery"
NOTEBOOKS = sorted(GALLERY.glob("*.ipynb"))


@pytest.fixture(autouse=True)
def program(monkeypatch):
    monkeypatch.setenv("ISOSPLAT_PROGRAM", str(PROGRAM))


def code_of(path):
    cells = json.loads(path.read_text())["cells"]
    return ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]


def value_of_last_line(code, names):
    """Runs a cell, and returns what a notebook displays of it."""
    parsed = ast.parse(code)
    last = parsed.body.pop() if isinstance(parsed.body[-1], ast.Expr) else None
    exec(compile(parsed, "cell", "exec"), names)
    return eval(compile(ast.Expression(last.value), "cell", "eval"), names) if last else None


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_every_cell_runs(path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = {}
    shown = [value_of_last_line(code, names) for code in code_of(path)]
    views = [value for value in shown if hasattr(value, "_repr_html_") or hasattr(value, "_esm")]
    assert len(views) == path.read_text().count("isosplat.view(")
    for view in views:
        view.close()


def test_a_notebook_runs_in_a_kernel(tmp_path):
    nbclient = pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    nbformat = pytest.importorskip("nbformat")
    notebook = nbformat.read(NOTEBOOKS[0], as_version=4)
    nbformat.validate(notebook)
    nbclient.NotebookClient(
        notebook, timeout=600, resources={"metadata": {"path": str(tmp_path)}}
    ).execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    assert [output["output_type"] for output in outputs] == ["execute_result"]
    data = outputs[0]["data"]
    assert "<iframe srcdoc=" in data["text/html"] and "sig=" not in data["text/plain"]
    assert (tmp_path / "gyroid.html").stat().st_size > 1_000_000


def test_the_notebooks_are_listed_and_have_no_outputs():
    readme = (GALLERY / "README.md").read_text()
    assert re.findall(r"\((\w+\.ipynb)\)", readme) == [path.name for path in NOTEBOOKS]
    assert len(NOTEBOOKS) == 8
    for path in NOTEBOOKS:
        notebook = json.loads(path.read_text())
        assert (notebook["nbformat"], notebook["nbformat_minor"]) == (4, 5)
        assert all(not cell.get("outputs") for cell in notebook["cells"])
        title = "".join(notebook["cells"][0]["source"]).splitlines()[0].removeprefix("# ")
        assert f"[{title}]({path.name})" in readme
