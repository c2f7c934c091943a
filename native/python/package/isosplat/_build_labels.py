"""Building scenes of the labels of a segmentation."""

from __future__ import annotations

import csv
import os
from typing import Any, Dict, Mapping, Optional, Sequence, Tuple, Union

import numpy as np

from ._arguments import MAX_THREADS, Path, path_bytes, text, whole
from ._arrays import voxels_of
from ._geometry import Placed, is_volume, placed
from ._scene import Scene, open_scene
from ._scene_output import Progress, run_program, scene_output

Name = Union[str, Tuple[str, Any]]

# Read from the array at a time.
_PART_BYTES = 64 << 20

_NRRD_TYPES = {
    "u8": "uint8",
    "i8": "int8",
    "u16": "uint16",
    "i16": "int16",
    "u32": "uint32",
    "i32": "int32",
    "u64": "uint64",
    "i64": "int64",
}


def build_labels(
    volume: Any,
    path: Path,
    *,
    labels: Optional[Mapping[int, Name]] = None,
    smooth: bool = True,
    spacing: Optional[Sequence[float]] = None,
    origin: Optional[Sequence[float]] = None,
    direction: Optional[Any] = None,
    title: str = "",
    progress: Optional[Progress] = None,
    threads: int = 0,
    memory: int = 1 << 30,
    overwrite: bool = False,
) -> Scene:
    """Builds a scene with a surface for each label of a segmentation, and opens it. It is the scene of
    `isosplat build --labels`, which runs in a process of its own.

    volume: an array of whole numbers, indexed [z, y, x], an image, or a file of labels. 0 is the background.
    path: NAME.isobundle, or a folder NAME/ that does not exist or is empty.

    labels: the name of each value, or its name and colour: {1: "liver", 2: ("kidney", "#cc3333")}.
    Colours are #rgb, #rrggbb, #rrggbbaa, or three or four numbers from 0 to 1. Values that are not
    listed have a name and a colour as well.

    smooth: smooth surfaces that separate exactly the voxels of each label; False: with the stairs of
    the voxels.

    spacing … overwrite: as for build(). An array is copied to a temporary file beside the scene.

    Raises what build() raises."""
    table = _table_of(labels)
    options = [f"--threads={whole('threads', threads, 0, MAX_THREADS)}"]
    options.append(f"--memory={whole('memory', memory, 1, 1 << 62)}")
    if progress is not None and not callable(progress):
        raise TypeError(f"progress: expected a function, found {type(progress).__name__}")
    given_title = text("title", title)
    if is_volume(volume):
        place = placed(volume, spacing, origin, direction)
    else:
        if not (spacing is None and origin is None and direction is None):
            raise TypeError("spacing, origin and direction are for arrays: a file states its own")
        source = os.path.abspath(path_bytes("volume", volume))
        os.stat(source)  # raises FileNotFoundError, PermissionError, …
    with scene_output(path, bool(overwrite)) as made:
        if is_volume(volume):
            # The title of the scene is the name of its file.
            name = os.path.splitext(os.path.basename(made))[0]
            source = os.fsencode(os.path.join(os.path.dirname(made), f"{name}.nrrd"))
            _write_nrrd(place, source)
        if table:
            listed = os.path.join(os.path.dirname(made), "labels.csv")
            with open(listed, "w", newline="", encoding="utf-8") as file:
                csv.writer(file).writerows([("value", "name", "r", "g", "b", "a"), *table])
            options.append(f"--label-table={listed}")
        if given_title:
            options.append(f"--name={given_title}")
        output = made if made.endswith(".isobundle") else f"{made}{os.sep}"
        # Both spellings end the list of values that --labels may have.
        kind = ["--labels"] if smooth else ["--labels", "raw"]
        run_program(["build", source, "-o", output, *options, *kind], progress)
    scene = open_scene(path)
    if progress is not None:
        progress(1.0, "complete")
    return scene


def _table_of(labels: Optional[Mapping[int, Name]]) -> Sequence[Tuple[Any, ...]]:
    """Rows of value, name, r, g, b and a; empty fields have defaults."""
    if labels is None:
        return []
    if not isinstance(labels, Mapping):
        raise TypeError(f"labels: expected a dict of values, found {type(labels).__name__}")
    rows = []
    for value, entry in labels.items():
        number = whole("labels", value, -(1 << 53), 1 << 53)
        name, colour = (entry, None) if isinstance(entry, str) else _pair(entry)
        # A line of the table is a line of the file.
        written = " ".join(text("labels", name).split())
        rows.append((number, written, *(("",) * 4 if colour is None else _bytes_of(colour))))
    return rows


def _pair(entry: Any) -> Tuple[Any, Any]:
    try:
        name, colour = entry
    except (TypeError, ValueError):
        raise TypeError(f"labels: expected a name, or a name and a colour, found {entry!r}") from None
    return name, colour


def _bytes_of(colour: Any) -> Tuple[Any, ...]:
    """r, g, b and a from 0 to 255."""
    try:
        if isinstance(colour, str):
            digits = colour.removeprefix("#")
            if len(digits) in (3, 4):
                digits = "".join(2 * digit for digit in digits)
            parts = [int(digits[i : i + 2], 16) for i in range(0, len(digits), 2)]
            numbers = [part / 255 for part in parts]
            if len(digits) not in (6, 8):
                raise ValueError
        else:
            numbers = [float(part) for part in colour]
        if len(numbers) not in (3, 4) or not all(0 <= part <= 1 for part in numbers):
            raise ValueError
    except (TypeError, ValueError):
        raise ValueError(
            f"labels: expected a colour such as '#cc3333' or (0.8, 0.2, 0.2), found {colour!r}"
        ) from None
    return tuple(round(255 * part) for part in numbers) + (255,) * (4 - len(numbers))


def _write_nrrd(place: Placed, path: bytes) -> None:
    volume = place.array
    voxels = voxels_of(volume)
    name = _NRRD_TYPES.get(voxels.type)
    if name is None:
        raise TypeError(
            f"volume: expected whole numbers as labels, found {volume.dtype}: convert them with astype"
        )
    # The order of the voxels in memory, as the program reads a .npy file.
    axes = slice(None, None, -1 if voxels.z_is_fastest else 1)
    ordered = volume.T if voxels.z_is_fastest else volume
    sizes: Sequence[int] = voxels.shape[::-1] if voxels.z_is_fastest else voxels.shape
    slowest, middle, fastest = sizes
    steps = np.asarray(place.direction, dtype=float).reshape(3, 3) * place.spacing

    def vector(values: Any) -> str:
        return "(" + ",".join(repr(float(each)) for each in values) + ")"

    header: Dict[str, Any] = {
        "type": name,
        "dimension": 3,
        "space": "left-posterior-superior",
        "sizes": f"{fastest} {middle} {slowest}",
        "space directions": " ".join(vector(step) for step in steps.T[axes]),
        "kinds": "domain domain domain",
        "endian": "little",
        "encoding": "raw",
        "space origin": vector(place.origin),
    }
    written = np.dtype(volume.dtype).newbyteorder("<")
    if written.kind == "b":
        written = np.dtype(np.uint8)
    count = max(1, _PART_BYTES // max(1, middle * fastest * written.itemsize))
    with open(path, "wb") as file:
        lines = ["NRRD0004", *(f"{key}: {value}" for key, value in header.items()), "", ""]
        file.write("\n".join(lines).encode())
        for first in range(0, slowest, count):
            part = np.asarray(ordered[first : first + count])
            file.write(np.ascontiguousarray(part, dtype=written).tobytes())
