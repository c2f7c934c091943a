"""What stores state about their volumes."""

from __future__ import annotations

import json
from typing import Any, Dict, List, NamedTuple, Optional, Tuple

import numpy as np
from numpy.typing import NDArray

from ._arguments import number, text

# The types of voxels in the metadata of a store.
_DTYPES = {f"{kind}{8 * size}": f"{kind}{size}" for kind in "uif" for size in (1, 2, 4, 8)}


class Histogram(NamedTuple):
    """Numbers of voxels in bins of equal width, as numpy.histogram returns them."""

    counts: NDArray[np.uint64]
    edges: NDArray[np.float64]
    """One more than counts."""


class Description:
    """What a store states about its volume."""

    def __init__(self, info: Dict[str, Any]) -> None:
        self._info = info
        metadata = self._info.pop("metadata")
        try:
            parsed = json.loads(metadata)
        except (ValueError, RecursionError):
            parsed = None
        # It is for people: it may be anything.
        self._metadata: Dict[str, Any] = parsed if isinstance(parsed, dict) else {}

    @property
    def shape(self) -> Tuple[int, int, int]:
        """Numbers of voxels along z, y and x: the shape of an array of the volume."""
        x, y, z = self._info["voxels"]
        return z, y, x

    @property
    def spacing(self) -> Tuple[float, float, float]:
        """Distances of voxels along the axes x, y and z of the volume, in world units."""
        return self._tuple("spacing")

    @property
    def origin(self) -> Tuple[float, float, float]:
        """The centre of voxel (0, 0, 0) in the world."""
        return self._tuple("origin")

    @property
    def direction(self) -> NDArray[np.float64]:
        """A 3×3 matrix whose columns are the axes x, y and z of the volume in the world."""
        return np.array(self._info["direction"], dtype=np.float64).reshape(3, 3)

    @property
    def affine(self) -> NDArray[np.float64]:
        """The 4×4 matrix that maps the index (x, y, z, 1) of a voxel to its world position."""
        affine = np.eye(4)
        affine[:3, :3] = self.direction * np.array(self.spacing)
        affine[:3, 3] = self.origin
        return affine

    @property
    def dtype(self) -> Optional[np.dtype[Any]]:
        """The type of the volume's voxels; None if the store does not state it."""
        source = self._metadata.get("source")
        name = source.get("type") if isinstance(source, dict) else None
        known = _DTYPES.get(name) if isinstance(name, str) else None
        return np.dtype(known) if known else None

    @property
    def value_range(self) -> Tuple[float, float]:
        """The lowest and the highest value."""
        low, high = self._info["value_range"]
        return low, high

    @property
    def max_error(self) -> float:
        """Largest difference of a stored value from the voxel's; 0: none."""
        return float(self._info["max_error"])

    @property
    def levels(self) -> int:
        """The number of levels of detail."""
        return int(self._info["levels"])

    @property
    def missing_voxels(self) -> int:
        """The number of voxels without a value (NaN, infinity, fill values)."""
        return int(self._info["missing_voxels"])

    @property
    def file_bytes(self) -> int:
        """The size of the store."""
        return int(self._info["file_bytes"])

    @property
    def content_id(self) -> str:
        """A hash of all content, 32 hexadecimal digits: equal for equal stores only."""
        return str(self._info["content_id"])

    @property
    def title(self) -> str:
        return self._text("title") or self._text("name")

    @property
    def units(self) -> str:
        """Of the values, such as "HU"; empty: unknown."""
        return self._text("units")

    @property
    def notes(self) -> List[str]:
        """Assumptions made when the volume was read."""
        notes = self._metadata.get("notes")
        return [each for each in notes if isinstance(each, str)] if isinstance(notes, list) else []

    @property
    def suggested_isovalues(self) -> List[float]:
        """Isovalues of boundaries in the volume, best first; at most five."""
        return _floats(self._metadata.get("suggested_isovalues"))

    @property
    def histogram(self) -> Optional[Histogram]:
        """At most 256 bins; None if the store has no histogram."""
        found = self._metadata.get("histogram")
        if not isinstance(found, dict):
            return None
        counts = _floats(found.get("counts"))
        ends = _floats([found.get("low"), found.get("high")])
        if not counts or len(ends) != 2 or min(counts) < 0 or max(counts) >= 2**63:
            return None
        edges = np.linspace(ends[0], ends[1], len(counts) + 1)
        return Histogram(np.array(counts).astype(np.uint64), edges)

    def _text(self, key: str) -> str:
        found = self._metadata.get(key)
        return text(key, found) if isinstance(found, str) else ""

    def _tuple(self, key: str) -> Tuple[float, float, float]:
        x, y, z = self._info[key]
        return x, y, z


def _floats(values: Any) -> List[float]:
    """The numbers of a list that may contain anything; none if one of them is something else."""
    if not isinstance(values, list):
        return []
    if not all(isinstance(each, (int, float)) and not isinstance(each, bool) for each in values):
        return []
    try:
        return [number("value", each) for each in values]
    except (TypeError, ValueError):
        return []
