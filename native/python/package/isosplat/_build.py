"""Building stores."""

from __future__ import annotations

import errno
import os
from typing import Any, Callable, Optional, Sequence

from . import _core
from ._arguments import (
    MAX_THREADS,
    Path,
    above_zero,
    is_address,
    numbers,
    path_bytes,
    spacing_of,
    text,
    whole,
)
from ._arrays import geometry_of, is_array, voxels_of
from ._store import Store, open

_IDENTITY = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


def build(
    volume: Any,
    path: Path,
    *,
    spacing: Optional[Sequence[float]] = None,
    origin: Optional[Sequence[float]] = None,
    direction: Optional[Any] = None,
    units: Optional[str] = None,
    title: str = "",
    max_error: Optional[float] = None,
    value_range: Optional[Sequence[float]] = None,
    progress: Optional[Callable[[float, str], object]] = None,
    threads: int = 0,
    memory: int = 1 << 30,
    overwrite: bool = False,
) -> Store:
    """Builds the store of a volume, and opens it.

    volume: an array indexed [z, y, x], of integers, booleans or floating-point numbers; or the path
    of any file or folder that `isosplat build` reads. NumPy arrays are read in place, whatever
    their order and byte order; memory-mapped ones are never in memory as a whole. Other objects
    with `shape`, `dtype` and slices (h5py, zarr, dask, xarray) are read slice by slice. Do not
    change an array until the function returns.

    path: the store to write. It appears when it is complete. An older store of this name is
    replaced; another file only with overwrite=True.

    spacing, origin: distances of voxels, and the centre of voxel (0, 0, 0), each along x, y and z
    (default: coordinates of an xarray, else 1 and 0). direction: a 3×3 matrix whose columns are the
    axes x, y and z of the volume in the world. For files, only spacing can be given.

    units: of the values, such as "HU". title: for display; default: the name of the store.

    max_error: largest difference between a voxel and its stored value, in the volume's units.
    Default: integers of up to 16 bits are exact, other values as exact as 16 bits allow.
    value_range: (low, high); values outside are set to its ends.

    progress: called with the complete fraction (0 to 1) and the name of the phase, on the calling
    thread. An exception of it, and Ctrl-C, end the build and leave no file behind.

    threads: 0: one per core. memory: limit in bytes, besides the array. Neither changes the store.

    Raises ValueError, TypeError, OSError, FileExistsError, MemoryError.
    """
    target = path_bytes("path", path)
    if is_address(target):
        raise ValueError("path: expected a file, found an address: build to a file, and upload it")
    if progress is not None and not callable(progress):
        raise TypeError(f"progress: expected a function, found {type(progress).__name__}")
    limits = None if value_range is None else numbers("value_range", value_range, 2)
    if limits is not None and not limits[0] < limits[1]:
        raise ValueError(f"value_range: expected two numbers, the lower one first, found {limits}")
    given_spacing = None if spacing is None else spacing_of(spacing)
    _check_folder(target)
    voxels = geometry = None
    if is_array(volume):
        voxels, geometry = voxels_of(volume), geometry_of(volume)
    found_units = units if units is not None else geometry.units if geometry is not None else None
    call = _core.BuildCall(
        target=target,
        title=text("title", title),
        units=text("units", found_units or ""),
        max_error=0.0 if max_error is None else above_zero("max_error", max_error),
        range=None if limits is None else (limits[0], limits[1]),
        threads=whole("threads", threads, 0, MAX_THREADS),
        memory_bytes=whole("memory", memory, 1, 1 << 62),
        overwrite=bool(overwrite),
        progress=progress,
    )
    if voxels is None or geometry is None:
        source = path_bytes("volume", volume)
        if is_address(source):
            raise ValueError("volume: expected an array or a file, found an address: download it")
        if origin is not None or direction is not None:
            raise TypeError("origin and direction are for arrays: a file states its own")
        os.stat(source)  # raises FileNotFoundError, PermissionError, …
        _core.build_file(source, given_spacing, call)
        return open(path)
    notes = []
    used_spacing = given_spacing or geometry.spacing
    if used_spacing is None:
        notes.append("the array has no voxel spacing: 1,1,1 is assumed; spacing= sets another")
        used_spacing = (1.0, 1.0, 1.0)
    used_origin = geometry.origin or (0.0, 0.0, 0.0)
    array = _core.ArrayCall(
        type=voxels.type,
        big_endian=voxels.big_endian,
        shape=voxels.shape,
        z_is_fastest=voxels.z_is_fastest,
        name=_name_of(target),
        spacing=used_spacing,
        origin=used_origin if origin is None else numbers("origin", origin, 3),
        direction=_IDENTITY if direction is None else _matrix(direction),
        notes=notes,
    )
    _core.build_array(voxels.data, voxels.read_count, array, call)
    return open(path)


def _name_of(target: bytes) -> str:
    name = os.path.splitext(os.path.basename(os.fsdecode(target)))[0]
    return text("path", name) or "volume"


def _matrix(direction: Any) -> Sequence[float]:
    try:
        rows = [list(row) for row in direction]
    except TypeError:
        raise TypeError(f"direction: expected a 3×3 matrix, found {direction!r}") from None
    if len(rows) != 3 or any(len(row) != 3 for row in rows):
        raise ValueError("direction: expected a 3×3 matrix, found another shape")
    return numbers("direction", [each for row in rows for each in row], 9)


def _check_folder(target: bytes) -> None:
    folder = os.path.dirname(target) or b"."
    os.stat(folder)  # raises FileNotFoundError, PermissionError, …
    if not os.path.isdir(folder):
        raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR), os.fsdecode(folder))
    if os.path.isdir(target):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), os.fsdecode(target))
