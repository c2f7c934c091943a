"""The code of docs/python.md, block after block, in one folder."""

import os
import re
import subprocess
from pathlib import Path

import h5py
import numpy as np
from conftest import ROOT, sphere

DOCUMENT = (ROOT / "docs/python.md").read_text()


def test_the_code_of_the_document_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    with h5py.File("scan.h5", "w") as file:
        file["volume"] = sphere((40, 40, 40)).astype(np.float32)
    blocks = re.findall(r"```python\n(.*?)```", DOCUMENT, re.DOTALL)
    assert len(blocks) == 7
    names = {"array": sphere((40, 40, 40)) * 10}
    for block in blocks:
        exec(compile(block, "docs/python.md", "exec"), names)
    assert Path("head.glb").stat().st_size > 1000
    assert len(names["at_points"]) == len(names["with_dose"].points(names["isovalue"]).positions)
    assert len(names["positions"]) == len(names["cells"]) > 0
    assert "iframe" in names["view"]._repr_html_() or hasattr(names["view"], "picked")
    assert "100%" in capsys.readouterr().out


def test_the_command_of_the_document_runs():
    commands = re.findall(r"```sh\n(.*?)```", DOCUMENT, re.DOTALL)
    # tests/packages tries the packages that the others install.
    (command,) = [each for each in commands if each.startswith("PYTHONPATH=")]
    # Elsewhere the folder of the build may have another name.
    package = os.environ.get("PYTHONPATH", "").split(":")[0]
    command = command.replace("build/release/native/python/package", package)
    run = subprocess.run(command, shell=True, cwd=ROOT, capture_output=True, text=True)
    assert re.fullmatch(r"\d+\.\d+\.\d+\S*\n", run.stdout), run.stderr
