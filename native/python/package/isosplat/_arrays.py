"""Arrays as the builder reads them: NumPy arrays in place, others slice by slice."""

from __future__ import annotations

from typing import Any, NamedTuple, Tuple

import numpy as np

# The names of types in C++, by NumPy's kind and size.
_TYPES = {
    "b1": "u8",
    "u1": "u8",
    "i1": "i8",
    "u2": "u16",
    "i2": "i16",
    "u4": "u32",
    "i4": "i32",
    "u8": "u64",
    "i8": "i64",
    "f2": "f16",
    "f4": "f32",
    "f8": "f64",
}

# Arrays that have chunks are read by a whole layer of chunks, unless it has more bytes than this.
_MAX_LAYER_BYTES = 256 << 20

# Along an axis: the limit of stores.
_MAX_SAMPLES = 1 << 20


class Voxels(NamedTuple):
    """What _core.build_array reads."""

    data: Any  # an array that is contiguous in its order, or a function
    read_count: int  # of the function: slices that it returns together; 0: data is an array
    type: str
    big_endian: bool
    shape: Tuple[int, int, int]
    z_is_fastest: bool


def is_array(volume: Any) -> bool:
    """Whether this is an array, or something that slices to arrays, rather than a path."""
    return hasattr(volume, "shape") and hasattr(volume, "dtype")


def voxels_of(volume: Any) -> Voxels:
    """Raises TypeError for types that are not real numbers, ValueError for other shapes."""
    if isinstance(volume, np.ma.MaskedArray):
        raise TypeError(
            "array: expected an array without a mask, found a masked array: replace masked values, "
            "as by array.astype(float).filled(numpy.nan), which makes them missing voxels"
        )
    type_name, big_endian = _type_of(volume)
    shape = _shape_of(volume)
    if not isinstance(volume, np.ndarray):
        return _sliced(volume, type_name, shape)
    array = np.asarray(volume)
    if array.flags.c_contiguous or array.flags.f_contiguous:
        # As numpy.save decides.
        z_is_fastest = not array.flags.c_contiguous
        return Voxels(array, 0, type_name, big_endian, shape, z_is_fastest)
    native = array.dtype.newbyteorder("=")

    def read(first: int, count: int) -> Any:
        return np.ascontiguousarray(array[first : first + count], dtype=native)

    return Voxels(read, 1, type_name, _is_big(native), shape, False)


def _is_big(dtype: np.dtype[Any]) -> bool:
    return dtype.newbyteorder("=").str[0] == ">" if dtype.isnative else dtype.str[0] == ">"


def _type_of(volume: Any) -> Tuple[str, bool]:
    try:
        dtype = np.dtype(volume.dtype)
    except TypeError:
        raise TypeError(f"array: expected a type of numbers, found {volume.dtype!r}") from None
    name = _TYPES.get(f"{dtype.kind}{dtype.itemsize}")
    if name is None:
        raise TypeError(
            "array: expected numbers that are whole, or of floating point with 16, 32 or 64 bits, "
            f"found {dtype}: convert it with astype"
        )
    return name, _is_big(dtype)


def _shape_of(volume: Any) -> Tuple[int, int, int]:
    shape = tuple(int(size) for size in volume.shape)
    if len(shape) != 3:
        raise ValueError(
            f"array: expected three axes (z, y, x), found the shape {shape}: choose one volume, "
            "such as array[0], or add axes"
        )
    if min(shape) < 2:
        raise ValueError(f"array: expected at least two samples along each axis, found {shape}")
    if max(shape) > _MAX_SAMPLES:
        raise ValueError(
            f"array: expected at most {_MAX_SAMPLES} samples along each axis, found {shape}: "
            "build parts of it"
        )
    return shape  # type: ignore[return-value]


def _sliced(volume: Any, type_name: str, shape: Tuple[int, int, int]) -> Voxels:
    native = np.dtype(volume.dtype).newbyteorder("=")
    depth = _chunk_depth(volume)
    layer_bytes = depth * shape[1] * shape[2] * native.itemsize
    if layer_bytes > _MAX_LAYER_BYTES:
        depth = max(1, depth * _MAX_LAYER_BYTES // layer_bytes)

    def read(first: int, count: int) -> Any:
        values = np.asarray(volume[first : first + count])
        if values.shape != (count, *shape[1:]):
            raise ValueError(
                f"array: expected slices of shape {(count, *shape[1:])}, found {values.shape}"
            )
        return np.ascontiguousarray(values, dtype=native)

    return Voxels(read, min(depth, shape[0]), type_name, _is_big(native), shape, False)


def _chunk_depth(volume: Any) -> int:
    """The extent of a chunk along z: of h5py, zarr and dask, else 1."""
    chunks: Any = getattr(volume, "chunks", None)
    try:
        depth = chunks[0]
        return max(1, int(depth if not isinstance(depth, tuple) else depth[0]))
    except (TypeError, IndexError, ValueError):
        return 1
