"""Open scenes."""

from __future__ import annotations

import json
import os
from typing import Any, Dict, NamedTuple, Optional, Tuple, Union

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._arguments import Path, is_address, path_bytes, whole
from ._store import Store


class Surface(NamedTuple):
    """A surface that a scene shows of a layer."""

    isovalue: float
    colour: str
    """#rrggbb; empty: the viewer chooses it."""
    opacity: float


class Label(NamedTuple):
    """The label of a segmentation whose surface a layer shows."""

    value: int
    """In the volume of labels."""
    voxels: int
    """The number of voxels with this value."""
    volume: float
    """Of these voxels, in world units³."""


class Layer:
    """A volume of a scene: one store, or one for each time step."""

    def __init__(self, scene: "Scene", description: Dict[str, Any]) -> None:
        self._scene = scene
        single = description.get("store")
        self._paths: Tuple[str, ...] = tuple(description["stores"]) if single is None else (single,)
        self.name: str = description.get("name", "")
        self.group: str = description.get("group", "")
        """Layers of a group are listed together; empty: none."""
        self.visible: bool = description.get("visible", True)
        self.surfaces: Tuple[Surface, ...] = tuple(
            Surface(float(each["isovalue"]), each.get("colour", ""), float(each.get("opacity", 1)))
            for each in description.get("surfaces", [])
        )
        label = description.get("label")
        self.label: Optional[Label] = (
            Label(int(label["value"]), int(label["voxels"]), float(label["volume"])) if label else None
        )
        transform = description.get("transform")
        self.transform: NDArray[np.float64] = (
            np.eye(4) if transform is None else np.array(transform, dtype=float).reshape(4, 4)
        )
        """The 4×4 matrix that maps the world of the store to that of the scene."""

    def store(self, step: int = 0) -> Store:
        """Opens the store of a time step; a layer that does not change has the same one at all steps.
        Raises ValueError, OSError."""
        steps = max(len(self._scene.times), 1)
        index = whole("step", step, 0, steps - 1)
        path = self._paths[index if len(self._paths) > 1 else 0]
        return self._scene._store(path)

    def __repr__(self) -> str:
        return f"<isosplat.Layer {self.name!r}>"


class Scene:
    """A list of layers that one picture shows: isosplat.open_scene(), build_scene() and build_labels()
    return it. Stores are opened when Layer.store() is called."""

    def __init__(self, handle: _core.SceneHandle, path: str) -> None:
        self._handle = handle
        document = json.loads(handle.document)
        self.path = path
        self.name: str = document.get("name", "")
        time = document.get("time", {})
        self.times: Tuple[float, ...] = tuple(float(each) for each in time.get("steps", ()))
        """Of the steps, ascending; empty: the scene does not change."""
        self.time_unit: str = time.get("unit", "")
        self.layers: Tuple[Layer, ...] = tuple(Layer(self, each) for each in document["layers"])

    def layer(self, which: Union[int, str]) -> Layer:
        """The layer with this index, or the first one with this name. Raises KeyError, IndexError."""
        if not isinstance(which, str):
            return self.layers[which]
        for layer in self.layers:
            if layer.name == which:
                return layer
        names = ", ".join(repr(layer.name) for layer in self.layers[:20])
        raise KeyError(f"expected the name of a layer ({names}), found {which!r}")

    def _store(self, path: str) -> Store:
        # Of a bundle, the store has no path of its own.
        beside = os.path.join(os.path.dirname(self.path), path)
        name = f"{self.path}#{path}" if self.path.endswith(".isobundle") else beside
        return Store(self._handle.store(path), name)

    def __reduce__(self) -> Any:
        # Another process opens the scene itself.
        return open_scene, (self.path,)

    def __repr__(self) -> str:
        steps = f", {len(self.times)} time steps" if self.times else ""
        return f"<isosplat.Scene {self.path!r}: {len(self.layers)} layers{steps}>"


def open_scene(path: Path) -> Scene:
    """Opens a bundle (.isobundle), the document of a scene (scene.json), or a folder with scene.json.
    Raises ValueError if it is no scene, or damaged; OSError, such as FileNotFoundError."""
    encoded = path_bytes("path", path)
    if is_address(encoded):
        raise ValueError("path: expected a file, found an address: download the scene")
    os.stat(encoded)  # raises FileNotFoundError, PermissionError, …
    if os.path.isdir(encoded):
        encoded = os.path.join(encoded, b"scene.json")
        os.stat(encoded)
    handle = _core.open_scene(encoded)
    if handle is None:
        raise ValueError(f"{os.fsdecode(encoded)}: expected a scene, found another file")
    return Scene(handle, os.fsdecode(encoded))
