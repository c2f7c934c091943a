"""Tests of the package isosplat for Python (native/python). They run by

    PYTHONPATH=build/release/native/python/package /usr/bin/python3 -m pytest tests/python
"""

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
# Programs that tests start elsewhere find the package as well.
os.environ["PYTHONPATH"] = os.pathsep.join(
    os.path.abspath(path) for path in os.environ.get("PYTHONPATH", "").split(os.pathsep) if path
)
# A thumbnail takes longer than building a small volume.
os.environ["ISOSPLAT_NO_THUMBNAIL"] = "1"
PROGRAM = Path(os.environ.get("ISOSPLAT_PROGRAM", ROOT / "build/release/native/cli/isosplat"))


def sphere(shape=(20, 24, 28), dtype=np.uint16):
    """Distances from the middle, as whole numbers."""
    z, y, x = np.indices(shape)
    middle = [(size - 1) / 2 for size in shape]
    distance = np.sqrt((z - middle[0]) ** 2 + (y - middle[1]) ** 2 + (x - middle[2]) ** 2)
    return (distance * 6).astype(dtype)


def run_program(*arguments):
    """The standard output of the program isosplat."""
    run = subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, check=True)
    return run.stdout


@pytest.fixture
def store(tmp_path):
    import isosplat

    return isosplat.build(sphere(), tmp_path / "sphere.isosplat", spacing=(1, 2, 3))
