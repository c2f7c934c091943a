"""Isosurfaces of volumes, from arrays and files.

    import isosplat
    store = isosplat.build(array, "head.isosplat")   # or isosplat.open("head.isosplat")
    mesh = store.mesh(isovalue=300)

A store is one file that holds, for each isovalue, the cells that its surface crosses. Arrays are
indexed [z, y, x], as in NumPy and scikit-image. Everything else is in the order x, y, z: spacing,
origin, the columns of direction, positions, boxes and cells. Lengths have the unit of the spacing,
millimetres for medical images, whose world is LPS as in DICOM.

Exceptions are Python's: ValueError (arguments, and files that are damaged or of another kind),
TypeError, OSError with FileNotFoundError, FileExistsError and others, and MemoryError.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

__all__ = [
    "Camera",
    "Field",
    "Histogram",
    "Label",
    "Lattice",
    "Layer",
    "Mesh",
    "Points",
    "Scene",
    "Server",
    "Store",
    "Surface",
    "__version__",
    "build",
    "build_labels",
    "build_scene",
    "open",
    "open_scene",
    "serve",
    "view",
]

if TYPE_CHECKING:
    from ._build import build
    from ._build_labels import build_labels
    from ._build_scene import build_scene
    from ._description import Histogram
    from ._lattice import Lattice
    from ._mesh import Mesh
    from ._render import Camera
    from ._scene import Label, Layer, Scene, Surface, open_scene
    from ._server import Server, serve
    from ._store import Field, Points, Store, open
    from ._view import view

    __version__: str

# The modules are imported at the first use: NumPy and the libraries that read files take most of
# the time of an import.
_HOMES = {
    "Camera": "_render",
    "Field": "_store",
    "Histogram": "_description",
    "Label": "_scene",
    "Lattice": "_lattice",
    "Layer": "_scene",
    "Mesh": "_mesh",
    "Points": "_store",
    "Scene": "_scene",
    "Server": "_server",
    "Store": "_store",
    "Surface": "_scene",
    "build": "_build",
    "build_labels": "_build_labels",
    "build_scene": "_build_scene",
    "open": "_store",
    "open_scene": "_scene",
    "serve": "_server",
    "view": "_view",
}


def __getattr__(name: str) -> Any:
    from importlib import import_module

    if name == "__version__":
        value: Any = import_module("._core", __name__).version
    elif name in _HOMES:
        value = getattr(import_module(f".{_HOMES[name]}", __name__), name)
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
