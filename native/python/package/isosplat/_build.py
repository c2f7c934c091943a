"""Building stores."""

from __future__ import annotations

import errno
import os
from typing import Any, Callable, Mapping, NamedTuple, Optional, Sequence

import numpy as np

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
from ._arrays import voxels_of
from ._geometry import is_volume, placed
from ._store import Store, open


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
    fields: Optional[Mapping[str, Any]] = None,
    progress: Optional[Callable[[float, str], object]] = None,
    threads: int = 0,
    memory: int = 1 << 30,
    overwrite: bool = False,
) -> Store:
    """Builds the store of a volume, and opens it.

    volume: an array indexed [z, y, x], of integers, booleans or floating-point numbers; an image of
    nibabel, SimpleITK, ITK, VTK or PyVista; or the path of any file or folder that `isosplat build`
    reads. NumPy arrays are read in place, whatever their order and byte order; memory-mapped ones
    are never in memory as a whole. Other objects with `shape`, `dtype` and slices (h5py, zarr, dask,
    xarray) are read slice by slice. Do not change an array until the function returns.

    path: the store to write. It appears when it is complete. An older store of this name is
    replaced; another file only with overwrite=True.

    spacing, origin: distances of voxels, and the centre of voxel (0, 0, 0), each along x, y and z
    (default: those of an image, the coordinates of an xarray, else 1 and 0). direction: a 3×3 matrix
    whose columns are the axes x, y and z of the volume in the world (default: that of an image, else
    the identity). For files, only spacing can be given.

    units: of the values, such as "HU". title: for display; default: the name of the store.

    max_error: largest difference between a voxel and its stored value, in the volume's units.
    Default: integers of up to 16 bits are exact, other values as exact as 16 bits allow.
    value_range: (low, high); values outside are set to its ends.

    fields: arrays of the same shape, by name: further scalars, whose values the store has where its
    surfaces are (Store.fields). An image with another geometry than that of an image as volume is
    resampled to its voxels. Names: at most 64 letters, digits, "_", "-" and "."; the first one is a
    letter. Not for files: `isosplat build --field` takes those.

    progress: called with the complete fraction (0 to 1) and the name of the phase, on the calling
    thread. An exception of it, and Ctrl-C, end the build and leave no file behind.

    threads: 0: one per core. memory: limit in bytes, besides the array. Neither changes the store.

    Raises ValueError, TypeError, OSError, FileExistsError, MemoryError.
    """
    return run_build(
        volume,
        path,
        spacing=spacing,
        origin=origin,
        direction=direction,
        units=units,
        title=title,
        max_error=max_error,
        value_range=value_range,
        fields=fields,
        progress=progress,
        threads=threads,
        memory=memory,
        overwrite=overwrite,
    )


class ArrayBuild(NamedTuple):
    """The arguments of _core.build_array and _core.scan_array."""

    data: Any
    read_count: int
    array: _core.ArrayCall
    call: _core.BuildCall


def run_build(
    volume: Any,
    path: Path,
    scan: Optional[_core.VoxelScan] = None,
    fields: Optional[Mapping[str, Any]] = None,
    **options: Any,
) -> Store:
    """build(), with the values of all volumes that are quantized together."""
    if not is_volume(volume):
        if fields:
            raise TypeError(
                "fields: expected an array as the volume, found a file: build it with "
                "`isosplat build --field`"
            )
        _build_file(volume, path, **options)
    else:
        arguments = array_build(volume, path, scan, **options)
        is_placed = _states_place(volume) and all(
            options.get(name) is None for name in ("spacing", "origin", "direction")
        )
        calls = [
            _field_call(name, field, arguments.array.z_is_fastest, is_placed)
            for name, field in (fields or {}).items()
        ]
        _core.build_array(*arguments, calls)
    return open(path)


def _states_place(volume: Any) -> bool:
    """Whether an array or image states another geometry than the default one."""
    found = placed(volume, None, None, None)
    place = (*found.spacing, *found.origin, *found.direction)
    return place != (1, 1, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1)


def _field_call(name: str, field: Any, z_is_fastest: bool, is_placed: bool) -> _core.FieldCall:
    """Checks an array with the voxels of a field. If its order in memory is another one, it is
    copied. is_placed: the volume states its own geometry; if the field does too, it keeps it."""
    name = text("fields", name)
    if not is_volume(field):
        raise TypeError(f"fields: expected an array as {name!r}, found {type(field).__name__}")
    found = placed(field, None, None, None)
    is_placed = is_placed and _states_place(field)
    values = found.array
    voxels = voxels_of(values)
    if voxels.z_is_fastest != z_is_fastest:
        voxels = voxels_of(np.array(values[: voxels.shape[0]], order="F" if z_is_fastest else "C"))
    array = _core.ArrayCall(
        type=voxels.type,
        big_endian=voxels.big_endian,
        shape=voxels.shape,
        z_is_fastest=voxels.z_is_fastest,
        name=name,
        spacing=found.spacing,
        origin=found.origin,
        direction=found.direction,
        notes=(),
    )
    return _core.FieldCall(
        name=name,
        data=voxels.data,
        read_count=voxels.read_count,
        array=array,
        is_placed=is_placed,
    )


def array_build(
    volume: Any,
    path: Path,
    scan: Optional[_core.VoxelScan],
    *,
    spacing: Optional[Sequence[float]] = None,
    origin: Optional[Sequence[float]] = None,
    direction: Optional[Any] = None,
    units: Optional[str] = None,
    **options: Any,
) -> ArrayBuild:
    """Checks the arguments of build() for an array or image."""
    target = _target(path, **options)
    place = placed(volume, spacing, origin, direction)
    voxels = voxels_of(place.array)
    call = _call(target, place.units if units is None else units, scan, **options)
    array = _core.ArrayCall(
        type=voxels.type,
        big_endian=voxels.big_endian,
        shape=voxels.shape,
        z_is_fastest=voxels.z_is_fastest,
        name=_name_of(target),
        spacing=place.spacing,
        origin=place.origin,
        direction=place.direction,
        notes=place.notes,
    )
    return ArrayBuild(voxels.data, voxels.read_count, array, call)


def _build_file(
    volume: Any,
    path: Path,
    *,
    spacing: Optional[Sequence[float]] = None,
    origin: Optional[Sequence[float]] = None,
    direction: Optional[Any] = None,
    units: Optional[str] = None,
    **options: Any,
) -> None:
    target = _target(path, **options)
    given = None if spacing is None else spacing_of(spacing)
    call = _call(target, units, None, **options)
    source = path_bytes("volume", volume)
    if is_address(source):
        raise ValueError("volume: expected an array or a file, found an address: download it")
    if origin is not None or direction is not None:
        raise TypeError("origin and direction are for arrays: a file states its own")
    os.stat(source)  # raises FileNotFoundError, PermissionError, …
    _core.build_file(source, given, call)


def _target(path: Path, progress: Any = None, **_options: Any) -> bytes:
    target = path_bytes("path", path)
    if is_address(target):
        raise ValueError("path: expected a file, found an address: build to a file, and upload it")
    if progress is not None and not callable(progress):
        raise TypeError(f"progress: expected a function, found {type(progress).__name__}")
    _check_folder(target)
    return target


def _call(
    target: bytes,
    units: Optional[str],
    scan: Optional[_core.VoxelScan],
    *,
    title: str = "",
    max_error: Optional[float] = None,
    value_range: Optional[Sequence[float]] = None,
    progress: Optional[Callable[[float, str], object]] = None,
    threads: int = 0,
    memory: int = 1 << 30,
    overwrite: bool = False,
) -> _core.BuildCall:
    limits = None if value_range is None else numbers("value_range", value_range, 2)
    if limits is not None and not limits[0] < limits[1]:
        raise ValueError(f"value_range: expected two numbers, the lower one first, found {limits}")
    return _core.BuildCall(
        target=target,
        title=text("title", title),
        units=text("units", units or ""),
        max_error=0.0 if max_error is None else above_zero("max_error", max_error),
        range=None if limits is None else (limits[0], limits[1]),
        threads=whole("threads", threads, 0, MAX_THREADS),
        memory_bytes=whole("memory", memory, 1, 1 << 62),
        overwrite=bool(overwrite),
        progress=progress,
        scan=scan,
    )


def _name_of(target: bytes) -> str:
    name = os.path.splitext(os.path.basename(os.fsdecode(target)))[0]
    return text("path", name) or "volume"


def _check_folder(target: bytes) -> None:
    folder = os.path.dirname(target) or b"."
    os.stat(folder)  # raises FileNotFoundError, PermissionError, …
    if not os.path.isdir(folder):
        raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR), os.fsdecode(folder))
    if os.path.isdir(target):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), os.fsdecode(target))
