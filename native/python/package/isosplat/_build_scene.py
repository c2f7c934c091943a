"""Building scenes of channels and time steps."""

from __future__ import annotations

import json
import os
import tempfile
from typing import Any, Dict, Iterator, List, Optional, Sequence, Tuple, Union

import numpy as np

from . import _core
from ._arguments import Path, number, path_bytes, text
from ._arrays import voxels_of
from ._build import array_build, run_build
from ._geometry import Placed, is_volume, placed
from ._scene import Scene, open_scene
from ._scene_output import Progress, run_program, scene_output

# Of surfaces in order, as `isosplat build` chooses them.
_COLOURS = "#e6d9bd #d68c6b #57b5e8 #009e73 #f0e342 #0073b3 #d65e00 #cc78a6".split()

# Read from an array at a time.
_PART_BYTES = 64 << 20

_GEOMETRY = ("spacing", "origin", "direction")
_OPTIONS = {*_GEOMETRY, "units", "max_error", "threads", "memory"}

Channel = Union[str, Tuple[str, str]]


def build_scene(
    volumes: Any,
    path: Path,
    *,
    channels: Optional[Sequence[Channel]] = None,
    times: Optional[Sequence[float]] = None,
    time_unit: str = "",
    title: str = "",
    value_range: Optional[Sequence[float]] = None,
    progress: Optional[Progress] = None,
    overwrite: bool = False,
    **options: Any,
) -> Scene:
    """Builds a scene of several volumes, and opens it: of channels, which are layers, of time steps, or
    of both.

    volumes: one volume for each channel or time step: an array whose first axis are these, or any
    iterable of arrays, images and files as for build(), such as a generator. With channels and times,
    one for each time step, each with one volume for each channel: (t, c, z, y, x).

    path: NAME.isobundle, or a folder NAME/ that does not exist or is empty.

    channels: the name of each, or its name and colour: ["DNA", ("actin", "#57b5e8")]. times: of each
    step, ascending.

    The steps of a channel have the same quantized values, so that an isovalue selects the same voxels
    throughout. So time steps are read twice; those of an iterator are kept in temporary files beside
    the scene meanwhile. value_range: (low, high) of all volumes saves this.

    options: those of build() that hold for each volume: spacing, origin, direction, units, max_error,
    threads and memory. A surface is shown at the first suggested isovalue of the middle step.

    Raises what build() raises."""
    if channels is None and times is None:
        raise TypeError("expected channels= or times=, found neither")
    if progress is not None and not callable(progress):
        raise TypeError(f"progress: expected a function, found {type(progress).__name__}")
    unknown = sorted(set(options) - _OPTIONS)
    if unknown:
        raise TypeError(f"expected options ({', '.join(sorted(_OPTIONS))}), found {', '.join(unknown)}")
    layers = [("", "")] if channels is None else [_named(each) for each in channels]
    steps = [0.0] if times is None else [number("times", each) for each in times]
    if not layers or not steps:
        raise ValueError("expected at least one channel and one time, found none")
    if any(later <= earlier for earlier, later in zip(steps, steps[1:])):
        raise ValueError(f"times: expected ascending numbers, found {steps[:10]}")
    unit, name = text("time_unit", time_unit), text("title", title)
    with scene_output(path, bool(overwrite)) as made:
        files = _files_of(volumes) if channels is None and value_range is None else None
        if files is not None and times is not None and not options:
            _check_count("times", len(steps), len(files))
            _run_program(files, steps, unit, name, made, progress)
        else:
            if value_range is not None:
                options["value_range"] = value_range
            parts = _parts(volumes, None if channels is None else len(layers), times, len(steps))
            run = _SceneBuild(made, layers, steps if times is not None else [], options, progress)
            # An iterator may use one array for all steps.
            run.build_all(parts, copies=hasattr(volumes, "__next__"))
            run.write(unit, name or os.path.splitext(os.path.basename(made))[0])
    scene = open_scene(path)
    if progress is not None:
        progress(1.0, "complete")
    return scene


def _named(channel: Any) -> Tuple[str, str]:
    """The name and the colour, which may be empty."""
    try:
        name, colour = (channel, "") if isinstance(channel, str) else channel
    except (TypeError, ValueError):
        raise TypeError(
            f"channels: expected names, or names with colours, found {channel!r}"
        ) from None
    return text("channels", name), text("channels", colour)


def _check_count(name: str, expected: int, found: int) -> None:
    if found != expected:
        raise ValueError(f"{name}: expected one volume for each of {expected}, found {found}")


class _Slab:
    """One volume of an array with more axes, which is not read before it is sliced."""

    def __init__(self, array: Any, index: int) -> None:
        self._array, self._index = array, index
        self.shape, self.dtype = tuple(array.shape)[1:], array.dtype
        chunks = getattr(array, "chunks", None)
        if isinstance(chunks, tuple):
            self.chunks = chunks[1:]

    def __getitem__(self, part: Any) -> Any:
        inner = part if isinstance(part, tuple) else (part,)
        return self._array[(self._index, *inner)]


def _listed(volumes: Any, count: int, name: str) -> Iterator[Any]:
    """The volumes of an iterable, or along the first axis of an array."""
    if is_volume(volumes):
        shape: Any = getattr(volumes, "shape", ())
        if len(shape) < 4:
            raise ValueError(f"{name}: expected an array of volumes, found one of shape {tuple(shape)}")
        _check_count(name, count, shape[0])
        # Arrays that index without reading keep what they know, such as the coordinates of xarray.
        is_lazy = hasattr(volumes, "__array_interface__") or hasattr(volumes, "coords")
        for index in range(count):
            yield volumes[index] if is_lazy else _Slab(volumes, index)
        return
    if isinstance(volumes, (str, bytes, os.PathLike)):
        raise TypeError(f"{name}: expected several volumes, found the path {volumes!r}")
    found = 0
    for volume in volumes:
        found += 1
        if found > count:
            break
        yield volume
    _check_count(name, count, found)


def _parts(
    volumes: Any, channels: Optional[int], times: Any, steps: int
) -> Iterator[Tuple[int, int, Any]]:
    """The layer, the step and the volume of each part of the scene."""
    for step, of_step in enumerate([volumes] if times is None else _listed(volumes, steps, "times")):
        if channels is None:
            yield 0, step, of_step
            continue
        for layer, volume in enumerate(_listed(of_step, channels, "channels")):
            yield layer, step, volume


class _SceneBuild:
    """The stores and the document of a scene, in the folder of the output."""

    def __init__(
        self,
        made: str,
        layers: List[Tuple[str, str]],
        times: List[float],
        options: Dict[str, Any],
        progress: Optional[Progress],
    ) -> None:
        self._made = made
        self._folder = f"{made}.stores" if made.endswith(".isobundle") else made
        self._layers, self._times = layers, times
        self._steps = max(len(times), 1)
        self._options = options
        self._progress = progress
        self._built = 0
        self._isovalues: Dict[int, float] = {}
        os.makedirs(os.path.join(self._folder, "stores"))

    def build_all(self, parts: Iterator[Tuple[int, int, Any]], copies: bool) -> None:
        """copies: keeps the arrays of the parts until all steps were scanned."""
        scans: Dict[int, Optional[_core.VoxelScan]] = {}
        types: Dict[int, Any] = {}
        later: List[Tuple[int, int, Any, Dict[str, Any]]] = []
        with tempfile.TemporaryDirectory(dir=os.path.dirname(self._made)) as spool:
            for layer, step, volume in parts:
                if not self._is_shared(volume):
                    self._build(layer, step, volume, None, self._options)
                    continue
                options = self._options
                if copies:
                    place = placed(volume, *(options.get(key) for key in _GEOMETRY))
                    volume = _copied(place, os.path.join(spool, f"{layer}.{step}"))
                    options = {**_geometry(place), **_given(options)}
                self._scan(layer, step, volume, options, scans, types)
                later.append((layer, step, volume, options))
            for layer, step, volume, options in later:
                self._build(layer, step, volume, scans[layer], options)

    def _scan(
        self,
        layer: int,
        step: int,
        volume: Any,
        options: Dict[str, Any],
        scans: Dict[int, Optional[_core.VoxelScan]],
        types: Dict[int, Any],
    ) -> None:
        """Adds the values of a step to those of its layer, as far as they can change the quantization."""
        arguments = array_build(volume, self._target(layer, step), None, **options)
        known = scans.get(layer)
        is_first = types.setdefault(layer, arguments.array.type) == arguments.array.type
        if layer in scans and (known is None or not is_first):
            scans[layer] = None  # steps of different types are quantized by themselves
        elif known is None:
            scans[layer] = _core.scan_array(*arguments)
        elif not known.is_settled or options.get("max_error") is not None:
            known.add(_core.scan_array(*arguments))

    def _is_shared(self, volume: Any) -> bool:
        """Whether the quantized values of a step follow from those of all steps."""
        if self._steps == 1 or self._options.get("value_range") is not None:
            return False
        if not is_volume(volume):
            raise TypeError(
                f"times: expected arrays, or files alone, or value_range=, found the file {volume!r}"
            )
        return True

    def _name(self, layer: int, step: int) -> str:
        name = f"layer_{layer:04}" if len(self._layers) > 1 else "volume"
        return f"{name}_{step:05}" if self._steps > 1 else name

    def _target(self, layer: int, step: int) -> str:
        return os.path.join(self._folder, "stores", f"{self._name(layer, step)}.isosplat")

    def _build(
        self,
        layer: int,
        step: int,
        volume: Any,
        scan: Optional[_core.VoxelScan],
        options: Dict[str, Any],
    ) -> None:
        count = len(self._layers) * self._steps

        def report(fraction: float, phase: str) -> None:
            if self._progress is not None:
                done = (self._built + fraction) / count
                self._progress(done, f"store {self._built + 1} of {count}: {phase}")

        target = self._target(layer, step)
        with run_build(volume, target, scan, progress=report, **_given(options)) as store:
            suggested = store.suggested_isovalues
            if step == self._steps // 2 and suggested:
                self._isovalues[layer] = suggested[0]
        self._built += 1

    def write(self, unit: str, name: str) -> None:
        """Writes the document, and the bundle if the output is one."""
        document: Dict[str, Any] = {"format": "isosplat-scene", "version": 1, "name": name}
        if self._times:
            document["time"] = {"steps": self._times}
            if unit:
                document["time"]["unit"] = unit
        document["layers"] = [self._layer(index) for index in range(len(self._layers))]
        written = os.path.join(self._folder, "scene.json")
        with open(written, "w", encoding="utf-8") as file:
            json.dump(document, file, ensure_ascii=False, indent=1, allow_nan=False)
        if self._folder != self._made:
            run_program(["bundle", written, "-o", self._made])

    def _layer(self, index: int) -> Dict[str, Any]:
        name, colour = self._layers[index]
        layer: Dict[str, Any] = {}
        if name:
            layer["name"] = name
        paths = [f"stores/{self._name(index, step)}.isosplat" for step in range(self._steps)]
        layer["store" if len(paths) == 1 else "stores"] = paths[0] if len(paths) == 1 else paths
        if index in self._isovalues:
            surface: Dict[str, Any] = {"isovalue": self._isovalues[index]}
            if colour or len(self._layers) > 1:
                surface["colour"] = colour or _COLOURS[index % len(_COLOURS)]
            layer["surfaces"] = [surface]
        return layer


def _given(options: Dict[str, Any]) -> Dict[str, Any]:
    return {key: value for key, value in options.items() if value is not None}


def _geometry(place: Placed) -> Dict[str, Any]:
    """The options of build() that state this geometry."""
    return {
        "spacing": place.spacing,
        "origin": place.origin,
        "direction": [place.direction[row : row + 3] for row in (0, 3, 6)],
        "units": place.units,
    }


def _copied(place: Placed, file: str) -> Any:
    """A copy of an array in a new file, in parts. Raises what voxels_of() raises."""
    voxels_of(place.array)
    shape, dtype = tuple(place.array.shape), np.dtype(place.array.dtype)
    copy = np.memmap(file, dtype=dtype, mode="w+", shape=shape)
    count = max(1, _PART_BYTES // max(1, shape[1] * shape[2] * dtype.itemsize))
    for first in range(0, shape[0], count):
        copy[first : first + count] = place.array[first : first + count]
    return copy


def _files_of(volumes: Any) -> Optional[List[bytes]]:
    """The paths of a list of files; None: others, or an iterator."""
    if not isinstance(volumes, (list, tuple)) or any(is_volume(each) for each in volumes):
        return None
    if not all(isinstance(each, (str, bytes, os.PathLike)) for each in volumes):
        return None
    return [os.path.abspath(path_bytes("volumes", each)) for each in volumes]


def _run_program(
    files: List[bytes], times: List[float], unit: str, name: str, made: str, progress: Optional[Progress]
) -> None:
    """Time steps of files: their values are scanned while they are read."""
    for file in files:
        os.stat(file)  # raises FileNotFoundError, PermissionError, …
    steps = os.path.join(os.path.dirname(made), "steps.txt")
    with open(steps, "wb") as listed:
        for time, file in zip(times, files):
            if b"\n" in file or b"\r" in file:
                raise ValueError(f"volumes: expected a path without line breaks, found {file!r}")
            listed.write(repr(time).encode() + b" " + file + b"\n")
    output = made if made.endswith(".isobundle") else f"{made}{os.sep}"
    named = [f"--name={name}"] if name else []
    timed = [f"--time-unit={unit}"] if unit else []
    run_program(["build", f"--steps={steps}", "-o", output, *named, *timed], progress)
