"""use_package.py VERSION: uses the package isosplat for Python, in the current folder, as a program
would: builds and opens a store, extracts its surface, and runs the program that belongs to it."""

import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import isosplat
import numpy as np

expected = sys.argv[1]
assert isosplat.__version__ == expected, isosplat.__version__
assert version("isosplat") == expected.replace("-rc.", "rc"), version("isosplat")

z, y, x = np.indices((20, 24, 28))
array = np.hypot(np.hypot(z - 9.5, y - 11.5), x - 13.5).astype(np.float32)
np.save("a.npy", array)
store = isosplat.build(array, "a.isosplat")
assert len(store.points(6).positions) == len(store.active_cells(6)) > 100
mesh = store.mesh(6)
mesh.save("a.ply")
assert Path("a.ply").stat().st_size > 1000


def program(*arguments):
    command = [sys.executable, "-m", "isosplat", *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


assert program("--version") == f"isosplat {expected}\n"
Path("again").mkdir()
program("build", "a.npy", "-o", "again/a.isosplat")
again = isosplat.open("again/a.isosplat")
assert np.array_equal(again.active_cells(6), store.active_cells(6))
view = isosplat.view(again)
view.save("page.html")
assert Path("page.html").stat().st_size > 1_000_000
assert view._shown.page_file("isosplat-anywidget-single.js") and "iframe" in view._repr_html_()
view.close()
print(f"{isosplat.__file__}: {len(mesh.triangles)} triangles")
