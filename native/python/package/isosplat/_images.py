"""Images that are not arrays: of nibabel, SimpleITK, ITK, VTK and PyVista. They are recognised by their
methods, so that none of these libraries is imported."""

from __future__ import annotations

import sys
from typing import Any, List, NamedTuple, Optional, Tuple

import numpy as np
from numpy.typing import NDArray

_LENGTHS_MM = {
    **{"mm": 1.0, "millimeter": 1.0, "millimeters": 1.0, "millimetre": 1.0, "millimetres": 1.0},
    **{"um": 1e-3, "µm": 1e-3, "μm": 1e-3, "micron": 1e-3, "microns": 1e-3},
    **{"micrometer": 1e-3, "micrometers": 1e-3, "micrometre": 1e-3, "micrometres": 1e-3},
    **{"nm": 1e-6, "nanometer": 1e-6, "nanometers": 1e-6, "nanometre": 1e-6, "nanometres": 1e-6},
    **{"cm": 10.0, "centimeter": 10.0, "centimeters": 10.0, "centimetre": 10.0, "centimetres": 10.0},
    **{"m": 1e3, "meter": 1e3, "meters": 1e3, "metre": 1e3, "metres": 1e3},
}


def millimetres(unit: Any) -> Optional[float]:
    """The length of a unit; None: it is not one of length."""
    return _LENGTHS_MM.get(unit.strip()) if isinstance(unit, str) else None


class Image(NamedTuple):
    """An image as an array with its place in the world."""

    array: Any  # indexed [z, y, x]
    affine: NDArray[np.float64]  # 4×4, from the index x, y, z to the world
    notes: List[str]


def image_of(volume: Any) -> Optional[Image]:
    """None: it is none of these images. Raises ValueError for images of other dimensions, and for
    several values in each voxel."""
    if _has(volume, "affine", "dataobj", "header"):
        return _of_nibabel(volume)
    if _has(volume, "GetDimensions", "GetSpacing", "GetOrigin", "GetPointData"):
        return _of_vtk(volume)
    if _has(volume, "GetSpacing", "GetOrigin", "GetDirection"):
        return _of_itk(volume)
    return None


def _has(volume: Any, *names: str) -> bool:
    return all(hasattr(volume, name) for name in names)


class _NibabelSlices:
    """The voxels of an image of nibabel, indexed [z, y, x]. Its own arrays are indexed [x, y, z]."""

    def __init__(self, data: Any, shape: Tuple[int, ...]) -> None:
        self._data = data
        self._index = (0,) * (len(shape) - 3)
        self.shape = shape[2::-1]
        # Of the values, which may be scaled: not that of the file.
        self.dtype = np.asarray(data[(slice(0, 1),) * 3 + self._index]).dtype

    def __getitem__(self, part: slice) -> Any:
        return np.asarray(self._data[(slice(None), slice(None), part) + self._index]).T


def _of_nibabel(image: Any) -> Image:
    shape = tuple(int(size) for size in image.shape)
    if len(shape) < 3 or any(size != 1 for size in shape[3:]):
        raise ValueError(
            f"image: expected three axes, found the shape {shape}: choose a volume, as by "
            "image.slicer[..., 0], or build all of them with build_scene"
        )
    if image.affine is None:
        raise ValueError("image: expected an affine, found none: pass its array and spacing=")
    # nibabel's world is RAS: x to the right, y forwards.
    affine = np.diag([-1.0, -1.0, 1.0, 1.0]) @ np.asarray(image.affine, dtype=float)
    notes = []
    read_units = getattr(image.header, "get_xyzt_units", None)
    unit = read_units()[0] if callable(read_units) else "mm"
    scale = millimetres(unit)
    if scale is None:
        notes.append("the header has no unit of lengths: millimetres are assumed")
    affine[:3] *= 1.0 if scale is None else scale
    return Image(_NibabelSlices(image.dataobj, shape), affine, notes)


def _of_itk(image: Any) -> Image:
    """Images of ITK and SimpleITK: both have LPS as their world."""
    module = type(image).__module__.partition(".")[0]
    library = sys.modules[module]
    if module == "SimpleITK":
        array = library.GetArrayViewFromImage(image)
        components = image.GetNumberOfComponentsPerPixel()
        matrix = np.array(image.GetDirection(), dtype=float)
    else:
        array = library.array_view_from_image(image)
        components = image.GetNumberOfComponentsPerPixel()
        matrix = np.asarray(library.array_from_matrix(image.GetDirection()), dtype=float)
    spacing = np.array([float(each) for each in image.GetSpacing()])
    if components != 1 or len(spacing) != 3:
        raise ValueError(
            f"image: expected three axes and one number in each voxel, found {len(spacing)} axes and "
            f"{components} numbers: extract a volume, or a component"
        )
    affine = np.eye(4)
    affine[:3, :3] = matrix.reshape(3, 3) * spacing
    affine[:3, 3] = [float(each) for each in image.GetOrigin()]
    return Image(array, affine, [])


def _of_vtk(image: Any) -> Image:
    """vtkImageData, which pyvista.ImageData extends."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    size = tuple(int(each) for each in image.GetDimensions())
    scalars = image.GetPointData().GetScalars()
    if scalars is None:
        in_cells = image.GetCellData().GetScalars() is not None
        found = "scalars in cells: convert them with cells_to_points()" if in_cells else "none"
        raise ValueError(f"image: expected active scalars in points, found {found}")
    if scalars.GetNumberOfComponents() != 1:
        raise ValueError(
            "image: expected one number in each point, found "
            f"{scalars.GetNumberOfComponents()}: choose a component"
        )
    array = vtk_to_numpy(scalars).reshape(size[::-1])
    matrix = image.GetDirectionMatrix()
    direction = np.array([[matrix.GetElement(row, column) for column in range(3)] for row in range(3)])
    affine = np.eye(4)
    affine[:3, :3] = direction * np.array(image.GetSpacing())
    # The origin is that of index 0, which may lie outside of the extent.
    first = np.array(image.GetExtent()[::2], dtype=float)
    affine[:3, 3] = np.array(image.GetOrigin()) + affine[:3, :3] @ first
    return Image(array, affine, [])
