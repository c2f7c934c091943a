"""Where arrays and images lie in the world."""

from __future__ import annotations

from typing import Any, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from ._arguments import numbers, spacing_of
from ._arrays import is_array
from ._images import image_of, millimetres

_IDENTITY = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


class Placed(NamedTuple):
    """An array with its geometry, as _core.ArrayCall has it."""

    array: Any
    spacing: Tuple[float, ...]
    origin: Tuple[float, ...]
    direction: Tuple[float, ...]  # row by row; the columns are the axes
    units: Optional[str]  # of the values
    notes: List[str]


def is_volume(volume: Any) -> bool:
    """Whether it is an array or an image, rather than a path."""
    return is_array(volume) or any(hasattr(volume, name) for name in ("GetSpacing", "dataobj"))


def placed(
    volume: Any,
    spacing: Optional[Sequence[float]],
    origin: Optional[Sequence[float]],
    direction: Optional[Any],
) -> Placed:
    """The array of an array or image, and its geometry: what is given, else what it states itself.
    Raises ValueError if a store cannot have its geometry, TypeError."""
    given = None if spacing is None else spacing_of(spacing)
    image = image_of(volume)
    if image is not None:
        columns = image.affine[:3, :3]
        lengths = np.linalg.norm(columns, axis=0)
        if not (np.isfinite(image.affine).all() and (lengths > 0).all()):
            raise ValueError("image: expected a finite affine of full rank, found another")
        found = Placed(
            image.array,
            spacing_of(lengths.tolist()),
            tuple(image.affine[:3, 3].tolist()),
            tuple((columns / lengths).ravel().tolist()),
            None,
            image.notes,
        )
    else:
        found = _of_array(volume, given is not None)
    return found._replace(
        spacing=given or found.spacing,
        origin=found.origin if origin is None else numbers("origin", origin, 3),
        direction=found.direction if direction is None else _matrix(direction),
    )


def _of_array(volume: Any, has_spacing: bool) -> Placed:
    """Labelled arrays (xarray) have coordinates and units."""
    notes = []
    units = None
    known: Optional[Tuple[Tuple[float, ...], Tuple[float, ...], List[str]]] = None
    dims, coords = getattr(volume, "dims", None), getattr(volume, "coords", None)
    if dims is not None and coords is not None and len(dims) == 3:
        stated = getattr(volume, "attrs", {}).get("units")
        units = stated if isinstance(stated, str) else None
        known = _of_coordinates(volume, dims, coords)
    if known is None:
        if not has_spacing:
            notes.append("the array has no voxel spacing: 1,1,1 is assumed; spacing= sets another")
        return Placed(volume, (1.0, 1.0, 1.0), (0.0, 0.0, 0.0), _IDENTITY, units, notes)
    return Placed(volume, known[0], known[1], _IDENTITY, units, known[2])


def _of_coordinates(
    volume: Any, dims: Any, coords: Any
) -> Optional[Tuple[Tuple[float, ...], Tuple[float, ...], List[str]]]:
    """Spacing, origin and notes. None if no axis has coordinates. Raises ValueError if they are not
    evenly spaced: a store cannot hold them."""
    steps: List[float] = []
    starts: List[float] = []
    scales: List[Optional[float]] = []
    for dim, size in zip(dims, volume.shape):
        start, step, scale = 0.0, 1.0, None
        if dim in coords:
            values = np.asarray(coords[dim])
            if values.dtype.kind not in "iuf" or values.shape != (size,):
                raise ValueError(f"array: expected numbers as the coordinates of {dim!r}")
            values = values.astype(float)
            start, step = float(values[0]), float(values[-1] - values[0]) / max(1, size - 1)
            even = np.allclose(np.diff(values), step, rtol=1e-3, atol=0)
            if not step > 0 or not even:
                raise ValueError(
                    f"array: expected coordinates of {dim!r} that ascend evenly, found others: "
                    "sort or interpolate the array, or pass its values and spacing="
                )
            scale = millimetres(getattr(coords[dim], "attrs", {}).get("units"))
        starts.append(start)
        steps.append(step)
        scales.append(scale)
    if not any(dim in coords for dim in dims):
        return None
    notes = []
    if all(scale is not None for scale in scales):
        factors = [scale or 1.0 for scale in scales]
        steps = [step * factor for step, factor in zip(steps, factors)]
        starts = [start * factor for start, factor in zip(starts, factors)]
        if any(factor != 1 for factor in factors):
            notes.append("the coordinates were converted to millimetres")
    return tuple(reversed(steps)), tuple(reversed(starts)), notes


def _matrix(direction: Any) -> Tuple[float, ...]:
    try:
        rows = [list(row) for row in direction]
    except TypeError:
        raise TypeError(f"direction: expected a 3×3 matrix, found {direction!r}") from None
    if len(rows) != 3 or any(len(row) != 3 for row in rows):
        raise ValueError("direction: expected a 3×3 matrix, found another shape")
    return numbers("direction", [each for row in rows for each in row], 9)
