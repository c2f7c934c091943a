"""The types that the package declares: checked by mypy."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import isosplat
import pytest

PACKAGE = Path(isosplat.__file__).parent

USE = """
from pathlib import Path
import numpy as np
import isosplat

store: isosplat.Store = isosplat.build(np.zeros((4, 4, 4)), Path("a.isosplat"), spacing=(1, 2, 3))
positions, normals = store.points(5)
first: np.float64 = positions[0, 0]
mesh = isosplat.open(b"a.isosplat").mesh(5, components=1)
mesh.save("a.glb")
values = store.read(level=1, box=((0, 0, 0), (2, 2, 2)), dtype=np.float64)
depth, height, width = store.lattice(1).shape
address: str = isosplat.serve([store, "b.isosplat"], options=["--cors", "none"]).address
pixel: np.uint8 = store.render([5, 6], camera=isosplat.Camera(zoom=2), size=(8, 8))[0, 0, 0]
area: float = store.area(5)
scene: isosplat.Scene = isosplat.build_labels(np.zeros((4, 4, 4), int), "a/", labels={1: "a", 2: ("b", "#fff")})
layer = isosplat.build_scene([store.read()], "b/", channels=["a"]).layer("a")
again: isosplat.Store = layer.store(step=0)
fields = isosplat.build(values, "f.isosplat", fields={"a": values}).fields
name: str = fields["a"].name
at_vertices: np.float32 = store.mesh(5, fields="a").fields["a"][0]
positions, normals = store.points(5, fields=["a"])
at_points: np.float32 = store.points(5, fields=["a"]).fields["a"][0]
histogram = store.histogram
if histogram is not None:
    edges = histogram.edges
"""


def mypy(*arguments, cwd):
    environment = {**os.environ, "MYPYPATH": str(PACKAGE.parent)}
    return subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", *arguments],
        capture_output=True,
        text=True,
        cwd=cwd,
        env=environment,
    )


@pytest.mark.skipif(importlib.util.find_spec("mypy") is None, reason="mypy is not installed")
def test_the_package_and_its_use(tmp_path):
    (tmp_path / "use.py").write_text(USE)
    (tmp_path / "misuse.py").write_text(USE + "store.points('5')\nstore.no_such_method()\n")
    # The types of xarray, and of pandas behind it, take a minute.
    (tmp_path / "mypy.ini").write_text("[mypy]\n[mypy-xarray.*]\nfollow_imports = skip\n")
    settings = ["--ignore-missing-imports", "--cache-dir", str(tmp_path / "cache")]
    right = mypy(*settings, "-p", "isosplat", cwd=tmp_path)
    assert right.returncode == 0, right.stdout + right.stderr
    assert mypy(*settings, "use.py", cwd=tmp_path).returncode == 0
    wrong = mypy(*settings, "misuse.py", cwd=tmp_path)
    assert wrong.stdout.count("error:") == 2, wrong.stdout


def test_the_package_says_that_it_is_typed():
    assert (PACKAGE / "py.typed").is_file() and (PACKAGE / "_core.pyi").is_file()


def test_every_public_name_has_a_description():
    for name in set(isosplat.__all__) - {"__version__"}:
        described = getattr(isosplat, name)
        assert described.__doc__
        for key, member in vars(described).items():
            if callable(member) and not key.startswith("_"):
                assert member.__doc__, f"{name}.{key}"
