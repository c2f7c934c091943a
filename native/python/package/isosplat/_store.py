"""Open stores."""

from __future__ import annotations

import os
from types import TracebackType
from typing import Any, Dict, List, NamedTuple, Optional, Sequence, Tuple, Type, Union

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._arguments import (
    MAX_THREADS,
    Path,
    above_zero,
    box_of,
    is_address,
    number,
    path_bytes,
    text,
    whole,
)
from ._description import Description
from ._lattice import Lattice, lattice_of
from ._mesh import Mesh
from ._render import Camera, render

# 2³² is beyond the number of vertices of a mesh.
_MAX_COMPONENTS = 1 << 32


class _PositionsAndNormals(NamedTuple):

    positions: NDArray[np.float64]
    """In the world, of shape (points, 3): x, y, z."""
    normals: NDArray[np.float32]
    """Unit normals towards smaller values, of shape (points, 3); zero where the gradient is zero."""


class Points(_PositionsAndNormals):
    """Points on an isosurface: the tuple (positions, normals), with the values of fields."""

    fields: Dict[str, NDArray[np.float32]] = {}
    """The values of the fields that points() was called with, each of shape (points,); NaN:
    missing."""

    def _replace(self, **changes: Any) -> Points:
        points = super()._replace(**changes)
        points.fields = self.fields
        return points


class Field(NamedTuple):
    """A further scalar of a store, at the voxels of its volume."""

    name: str
    title: str
    units: str
    """Of the values; empty: unknown."""
    value_range: Tuple[float, float]
    """The lowest and the highest value."""
    max_error: float
    """Largest difference of a stored value from the voxel's; 0: none."""
    missing_voxels: int


def open(path: Path) -> "Store":
    """Opens the store at a path, or at an address: http://…, https://… or s3://BUCKET/KEY, of which
    only the parts that are needed are fetched. PATH.isobundle#MEMBER is a store in a bundle, as
    Layer.store() has it. Raises ValueError if it is not a store, or damaged; OSError, such as
    FileNotFoundError."""
    encoded = path_bytes("path", path)
    name = os.fsdecode(encoded)
    if is_address(encoded):
        return Store(_core.open_store(encoded), name)
    if is_in_bundle(name):
        from ._scene import open_scene

        bundle, _, member = name.rpartition("#")
        return open_scene(bundle)._store(member)
    os.stat(encoded)  # raises FileNotFoundError, PermissionError, …
    if os.path.isdir(encoded):
        raise IsADirectoryError(f"{name}: expected a store, found a folder{_scene_hint(name)}")
    if name.endswith((".isobundle", ".json")):
        raise ValueError(f"{name}: expected a store, found a scene: isosplat.open_scene() opens it")
    return Store(_core.open_store(encoded), name)


def _names(fields: Union[str, Sequence[str]]) -> List[str]:
    """The names of fields: one, or several."""
    names = [fields] if isinstance(fields, str) else list(fields)
    return [text("fields", name) for name in names]


def _scene_hint(folder: str) -> str:
    has_scene = os.path.isfile(os.path.join(folder, "scene.json"))
    return " of a scene: isosplat.open_scene() opens it" if has_scene else ""


def is_in_bundle(path: str) -> bool:
    """Whether it is the path of a store in a bundle, rather than of a file."""
    return ".isobundle#" in path and not os.path.lexists(path)


class Store(Description):
    """An open store: isosplat.open() and isosplat.build() return it. Several threads may use it at
    the same time. Use it in a with statement, or close() it, to close the file early; afterwards
    its methods raise ValueError.

    Isovalues are in the units of the volume. `level`: 0 is the volume; each further level halves
    the resolution of each axis. `box`: ((x0, y0, z0), (x1, y1, z1)) in the world; only cells whose
    centres are in it count. `threads`: 0: one per core. Ctrl-C ends each method.
    """

    def __init__(self, handle: _core.StoreHandle, path: str) -> None:
        super().__init__(handle.info())
        self._handle = handle
        self.path = path

    # Surfaces --------------------------------------------------------------------------------

    def points(
        self,
        isovalue: float,
        level: int = 0,
        box: Optional[Sequence[Any]] = None,
        *,
        normals: str = "smooth",
        exact: bool = False,
        fields: Union[str, Sequence[str]] = (),
        threads: int = 0,
    ) -> Points:
        """One point for each active cell: its centre, moved onto the surface by a Newton step, but
        not out of the cell. exact: onto the trilinear surface, where the ray along the gradient
        meets it. normals: "smooth", continuous over the surface, or "cell", the gradient of each
        cell. The arrays are new; they own their memory. fields: names of fields of the store, whose
        values at the points are Points.fields. A value is that of the field's trilinear function in
        the cell; NaN where a corner of the cell is missing."""
        if normals not in ("smooth", "cell"):
            raise ValueError(f'normals: expected "smooth" or "cell", found {normals!r}')
        part = self._part(level, box, threads)
        value = number("isovalue", isovalue)
        smooth = normals == "smooth"
        names = _names(fields)
        positions, unit_normals, values = self._handle.points(
            value, part, smooth=smooth, exact=bool(exact), fields=names
        )
        points = Points(positions, unit_normals)
        points.fields = dict(zip(names, values))
        return points

    def mesh(
        self,
        isovalue: float,
        level: int = 0,
        box: Optional[Sequence[Any]] = None,
        *,
        components: Optional[int] = None,
        simplify: Optional[float] = None,
        fields: Union[str, Sequence[str]] = (),
        threads: int = 0,
    ) -> Mesh:
        """The surface as triangles: closed, except at the border of the volume or box, and at
        missing voxels. components: keep only this many connected components, the largest ones.
        simplify: use fewer triangles, with an error of about this length in world units. fields:
        names of fields of the store, whose values at the vertices are Mesh.fields."""
        value = number("isovalue", isovalue)
        kept = None if components is None else whole("components", components, 1, _MAX_COMPONENTS)
        error = None if simplify is None else above_zero("simplify", simplify)
        part = self._part(level, box, threads)
        names = _names(fields)
        data = self._handle.mesh(value, part, components=kept, simplify_error=error, fields=names)
        return Mesh(data, value, os.path.basename(self.path))

    def active_cells(
        self,
        isovalue: float,
        level: int = 0,
        box: Optional[Sequence[Any]] = None,
        *,
        threads: int = 0,
    ) -> NDArray[np.int32]:
        """The cells that the surface crosses: the indices (x, y, z) of their first voxels in the
        lattice of the level, of shape (cells, 3). A cell is active if min ≤ isovalue < max over its
        eight voxels; on coarser levels, over the voxels that it stands for."""
        part = self._part(level, box, threads)
        return self._handle.active_cells(number("isovalue", isovalue), part)

    def bytes(
        self, isovalue: float, level: int = 0, box: Optional[Sequence[Any]] = None
    ) -> int:
        """The bytes of the chunks that this surface needs, known before they are fetched."""
        return self._handle.bytes(number("isovalue", isovalue), self._part(level, box, 0))

    @property
    def fields(self) -> Dict[str, Field]:
        """The fields of the store, by name, in their order. Reads their headers."""
        return {each["name"]: Field(**each) for each in self._handle.fields()}

    # Values ----------------------------------------------------------------------------------

    def lattice(self, level: int = 0, box: Optional[Sequence[Any]] = None) -> Lattice:
        """The voxels that read() returns for the same arguments: their number along each axis, and
        where they lie. box: only the voxels whose positions lie in the box; if the volume's axes are
        not those of the world, in the smallest box along the volume's axes that contains it."""
        return lattice_of(self.shape, self.affine, self._level(level), box)

    def read(
        self,
        level: int = 0,
        box: Optional[Sequence[Any]] = None,
        *,
        dtype: Any = np.float32,
        threads: int = 0,
    ) -> NDArray[Any]:
        """The values of the voxels of a level, indexed [z, y, x]: of its whole lattice, or of the
        voxels that lattice(level, box) states. A store has values only where surfaces can be: of the
        corners of cells that are active for some isovalue. All others are NaN: missing voxels, and
        voxels all of whose neighbours (the other corners of the up to eight cells around it) have
        the same value. At level 0 a value differs from the volume's by at most max_error.

        dtype: float32 or float64. Values are rounded to it. Memory: the array. Raises MemoryError."""
        found = np.dtype(dtype)
        if found not in (np.dtype(np.float32), np.dtype(np.float64)):
            raise ValueError(f"dtype: expected float32 or float64, found {found}")
        lattice = self.lattice(level, box)
        part = self._part(level, None, threads)
        try:
            values = np.full(lattice.shape, np.nan, found)
        except ValueError:  # more bytes than an address has
            raise MemoryError(
                f"{self.path}: no memory for {lattice.shape} values: read parts with box="
            ) from None
        self._handle.read(part, lattice.first, values)
        return values

    # Pictures --------------------------------------------------------------------------------

    def render(
        self,
        isovalue: Union[float, Sequence[float]],
        *,
        camera: Camera = Camera(),
        size: Tuple[int, int] = (1024, 1024),
        level: Optional[int] = None,
        colours: Sequence[str] = (),
        opacities: Sequence[float] = (),
        background: str = "ffffff",
        options: Sequence[str] = (),
    ) -> NDArray[np.uint8]:
        """A picture of one or several isosurfaces: RGBA, of shape (height, width, 4), rows from the
        top, alpha not premultiplied. It is the picture of the command `isosplat render`, which runs
        in a process of its own, without a window, and reads the store from its path or address again.

        size: (width, height). level: default: the finest level with at most 67 million samples.
        colours: rrggbb or rrggbbaa of each isosurface. opacities: of each, 0 to 1. background:
        rrggbb, rrggbbaa or "transparent". options: further options of the command, such as
        ["--clip-box", "0,0,0,1,1,0.5"]: see `isosplat render --help`.

        Raises ValueError for arguments that the command refuses, RuntimeError with its message if it
        fails, such as on a machine without OpenGL ES."""
        if self.closed:
            raise ValueError("the store is closed: open it again")
        if is_in_bundle(self.path):
            raise ValueError(
                f"{self.path}: expected the store of a file, found one in a bundle: take it out with "
                "`isosplat unbundle`"
            )
        chosen = None if level is None else self._level(level)
        return render(
            self.path, isovalue, camera, size, chosen, colours, opacities, background, options
        )

    def area(self, isovalue: float, *, threads: int = 0) -> float:
        """The area of the surface in world units²."""
        return self._measures(isovalue, threads)[0]

    def volume(self, isovalue: float, *, threads: int = 0) -> float:
        """The volume of the region above the isovalue, inside of the grid, in world units³. Raises
        ValueError if voxels are missing: the surface then has holes."""
        if self.missing_voxels:
            raise ValueError(
                f"{self.path}: expected a volume without missing voxels, found "
                f"{self.missing_voxels}: the surface has holes, and encloses no volume"
            )
        return self._measures(isovalue, threads)[1]

    # The file --------------------------------------------------------------------------------

    @property
    def closed(self) -> bool:
        return not self._handle.is_open

    def close(self) -> None:
        """Closes the file. Methods that other threads have begun still end."""
        self._handle.close()

    def __enter__(self) -> "Store":
        return self

    def __exit__(
        self,
        kind: Optional[Type[BaseException]],
        error: Optional[BaseException],
        trace: Optional[TracebackType],
    ) -> None:
        self.close()

    def __reduce__(self) -> Any:
        # Another process opens the store itself.
        return open, (self.path,)

    def __repr__(self) -> str:
        z, y, x = self.shape
        state = ", closed" if self.closed else ""
        return f"<isosplat.Store {self.path!r}: {x} × {y} × {z} voxels{state}>"

    def _part(self, level: Any, box: Optional[Sequence[Any]], threads: Any) -> _core.Part:
        return _core.Part(
            level=self._level(level),
            box=box_of(box),
            threads=whole("threads", threads, 0, MAX_THREADS),
        )

    def _level(self, level: Any) -> int:
        return whole("level", level, 0, self.levels - 1)

    def _measures(self, isovalue: Any, threads: Any) -> Tuple[float, float]:
        count = whole("threads", threads, 0, MAX_THREADS)
        return self._handle.measures(number("isovalue", isovalue), threads=count)
