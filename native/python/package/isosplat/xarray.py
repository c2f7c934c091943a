"""The accessor `isosplat` of xarray.DataArray. Importing this module adds it:

    import isosplat.xarray
    array.isosplat.view(isovalue=300)
"""

# mypy: allow-untyped-calls, allow-untyped-decorators
from __future__ import annotations

from typing import Any, Optional

import numpy as np
import xarray

from ._arguments import Path
from ._build import build
from ._build_scene import build_scene
from ._scene import Scene
from ._store import Store
from ._view import view


@xarray.register_dataarray_accessor("isosplat")
class IsosplatAccessor:
    """Stores, scenes and views of an array whose last three axes are z, y and x."""

    def __init__(self, array: "xarray.DataArray") -> None:
        self._array = array

    def build(self, path: Path, **options: Any) -> Store:
        """As isosplat.build(). The title is the name of the array."""
        return build(self._array, path, **self._titled(options))

    def build_scene(self, path: Path, **options: Any) -> Scene:
        """As isosplat.build_scene(), of the time steps or the channels along the first of four axes. Its
        coordinates are numbers, which are times, or texts, which are names of channels; without
        coordinates they are indices, which are times. Raises ValueError for other axes."""
        array = self._array
        if array.ndim != 4:
            raise ValueError(f"array: expected four axes, found {array.dims}")
        first = array.dims[0]
        values = np.asarray(array.coords[first]) if first in array.coords else np.arange(array.shape[0])
        if values.dtype.kind in "iuf":
            found = {"times": values.tolist()}
            unit = array.coords[first].attrs.get("units") if first in array.coords else None
            if isinstance(unit, str):
                options.setdefault("time_unit", unit)
        elif values.dtype.kind in "UO" and all(isinstance(each, str) for each in values.tolist()):
            found = {"channels": values.tolist()}
        else:
            raise ValueError(
                f"array: expected numbers or texts as the coordinates of {first!r}, found {values.dtype}"
            )
        return build_scene(array, path, **{**found, **self._titled(options)})

    def view(self, isovalue: Optional[float] = None, **options: Any) -> Any:
        """As isosplat.view()."""
        return view(self._array, isovalue, **self._titled(options))

    def _titled(self, options: Any) -> Any:
        name = self._array.name
        return {"title": name, **options} if isinstance(name, str) else options
