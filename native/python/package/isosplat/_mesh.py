"""Surfaces of triangles."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Dict

from . import _core
from ._arguments import Path, path_bytes

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class Mesh:
    """An isosurface of triangles, as Store.mesh() returns it. Its arrays are read-only; copy them to
    change them."""

    def __init__(self, data: _core.MeshData, isovalue: float, source: str) -> None:
        self._data = data
        self._source = source
        self.isovalue = isovalue

    @property
    def vertices(self) -> NDArray[np.float64]:
        """Positions in the world, of shape (vertices, 3): x, y, z."""
        return self._data.vertices

    @property
    def normals(self) -> NDArray[np.float32]:
        """Unit normals towards smaller values, of shape (vertices, 3)."""
        return self._data.normals

    @property
    def triangles(self) -> NDArray[np.uint32]:
        """Indices of vertices, of shape (triangles, 3), counter-clockwise seen from the side of
        smaller values."""
        return self._data.triangles

    @property
    def fields(self) -> Dict[str, NDArray[np.float32]]:
        """The values of the fields that mesh() was called with, each of shape (vertices,). NaN:
        missing. A vertex on an edge of cells has the value between the ends of this edge. In a
        few cells, the surface also has a vertex inside of the cell, which has the value of the
        field's trilinear function."""
        return dict(self._data.fields)

    def save(self, path: Path) -> None:
        """Writes the mesh to a .glb, .ply, .stl, .obj, .3mf, .npz or .vtp file, and replaces a file of
        this name. GLB and 3MF take the unit of the spacing as the millimetre. PLY, GLB, NPZ and VTP hold
        the values of fields, as `isosplat extract --field` writes them. Raises ValueError for
        another suffix, and for a format without fields if the mesh has them; OSError."""
        target = path_bytes("path", path)
        os.stat(os.path.dirname(target) or b".")  # raises FileNotFoundError, …
        comment = f"isosurface {self.isovalue!r} of {self._source}, by isosplat {_core.version}"
        self._data.save(target, " ".join(comment.encode("utf-8", "replace").decode().split()))

    def to_pyvista(self) -> Any:
        """The mesh as pyvista.PolyData, a copy, with the point data "Normals" and those of the
        fields' names; a field "Normals" is "Normals_field". Raises ImportError if PyVista is not
        installed."""
        import numpy as np
        import pyvista

        triangles = self.triangles
        faces = np.empty((len(triangles), 4), dtype=np.int64)
        faces[:, 0] = 3
        faces[:, 1:] = triangles
        mesh = pyvista.PolyData(self.vertices.copy(), faces.ravel())
        mesh.point_data["Normals"] = self.normals.copy()
        names = self._data.column_names(["Normals"])
        for name, (_, values) in zip(names, self._data.fields):
            mesh.point_data[name] = values.copy()
        return mesh

    def to_trimesh(self) -> Any:
        """The mesh as trimesh.Trimesh, a copy. Raises ImportError if trimesh is not installed."""
        import trimesh

        return trimesh.Trimesh(
            vertices=self.vertices.copy(),
            faces=self.triangles.astype("int64"),
            vertex_normals=self.normals.copy(),
            process=False,
        )

    def __repr__(self) -> str:
        return (
            f"<isosplat.Mesh at {self.isovalue:g}: {len(self.vertices)} vertices, "
            f"{len(self.triangles)} triangles>"
        )
