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
    "Histogram",
    "Lattice",
    "Mesh",
    "Points",
    "Server",
    "Store",
    "__version__",
    "build",
    "open",
    "serve",
    "view",
]

if TYPE_CHECKING:
    from ._build import build
    from ._description import Histogram
    from ._lattice import Lattice
    from ._mesh import Mesh
    from ._render import Camera
    from ._server import Server, serve
    from ._store import Points, Store, open
    from ._view import view

    __version__: str

# The modules are imported at the first use: NumPy and the libraries that read files take most of
# the time of an import.
_HOMES = {
    "Camera": "_render",
    "Histogram": "_description",
    "Lattice": "_lattice",
    "Mesh": "_mesh",
    "Points": "_store",
    "Server": "_server",
    "Store": "_store",
    "build": "_build",
    "open": "_store",
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
