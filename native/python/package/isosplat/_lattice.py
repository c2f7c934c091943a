"""The voxels of a level of a store, and those in a box."""

from __future__ import annotations

from typing import Any, NamedTuple, Optional, Sequence, Tuple

import numpy as np
from numpy.typing import NDArray

from ._arguments import box_of


class Lattice(NamedTuple):
    """The voxels that Store.read() returns."""

    shape: Tuple[int, int, int]
    """Numbers of voxels along z, y and x."""
    affine: NDArray[np.float64]
    """The 4×4 matrix that maps the index (x, y, z, 1) of one of these voxels to its world position.
    On coarse levels, the last voxel of the whole level along an axis may lie closer, since it has the
    position of the volume's last voxel."""
    first: Tuple[int, int, int]
    """The index x, y, z of its first voxel among all voxels of the level."""


def lattice_of(
    shape: Tuple[int, int, int],
    affine: NDArray[np.float64],
    level: int,
    box: Optional[Sequence[Any]],
) -> Lattice:
    """The lattice of a level of a volume with this shape and affine. Raises ValueError if no voxel lies
    in the box."""
    low, high = np.full(3, -np.inf), np.full(3, np.inf)
    corners = box_of(box)
    if corners is not None:
        low, high = _index_range(corners, affine)
    first, counts = [], []
    for axis, voxels in enumerate(reversed(shape)):
        cells = voxels - 1
        for _ in range(level):
            cells = (cells + 1) // 2
        positions = np.minimum(np.arange(cells + 1, dtype=np.int64) << level, voxels - 1)
        start = int(np.searchsorted(positions, low[axis], "left"))
        end = int(np.searchsorted(positions, high[axis], "right"))
        if end <= start:
            raise ValueError(
                f"box: expected a box that contains voxels of level {level}, found {corners}: give a "
                "larger box, or one inside of the volume"
            )
        first.append(start)
        counts.append(end - start)
    scaled = affine.copy()
    scaled[:3, :3] *= 2.0**level
    scaled[:3, 3] = scaled[:3, :3] @ first + affine[:3, 3]
    return Lattice((counts[2], counts[1], counts[0]), scaled, (first[0], first[1], first[2]))


def _index_range(
    corners: Tuple[float, ...], affine: NDArray[np.float64]
) -> Tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The lowest and highest indices x, y, z in a box of the world, a little more for rounding."""
    ends = np.array(corners).reshape(2, 3)
    choices = np.array(np.meshgrid([0, 1], [0, 1], [0, 1])).reshape(3, 8)
    points = np.array([ends[choices[axis], axis] for axis in range(3)]) - affine[:3, 3:]
    indices = np.linalg.solve(affine[:3, :3], points)
    return indices.min(axis=1) - 1e-6, indices.max(axis=1) + 1e-6
