"""Pictures, which the program draws."""

from __future__ import annotations

import os
import subprocess
import tempfile
from typing import Any, List, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._arguments import is_address, number, numbers, text, whole
from ._program import find_program

_MAX_SIZE = 16384


class Camera(NamedTuple):
    """A viewpoint. Angles are in degrees, lengths in world units."""

    azimuth: float = 30
    """0 is the front, 90 the left."""
    elevation: float = 20
    """Above the horizon."""
    roll: float = 0
    distance: Optional[float] = None
    """From the eye to the target. None: so that the whole volume is visible."""
    target: Optional[Sequence[float]] = None
    """The point (x, y, z) at which the camera looks. None: the centre of the volume."""
    field_of_view: float = 30
    """Vertical, 1 to 120."""
    zoom: float = 1
    """The distance is divided by it."""
    projection: str = "perspective"
    """Or "orthographic"."""

    def arguments(self) -> List[str]:
        """The options of `isosplat render`. Raises TypeError, ValueError."""
        names = ["azimuth", "elevation", "roll", "field_of_view", "zoom"]
        found = [_option(name, number(name, getattr(self, name))) for name in names]
        if self.distance is not None:
            found.append(_option("distance", number("distance", self.distance)))
        if self.target is not None:
            found.append(_option("target", *numbers("target", self.target, 3)))
        return [*found, f"--projection={text('projection', self.projection)}"]


def render(
    path: str,
    isovalue: Union[float, Sequence[float]],
    camera: Camera,
    size: Tuple[int, int],
    level: Optional[int],
    colours: Sequence[str],
    opacities: Sequence[float],
    background: str,
    options: Sequence[str],
) -> NDArray[np.uint8]:
    """See Store.render()."""
    if not isinstance(camera, Camera):
        raise TypeError(f"camera: expected a Camera, found {type(camera).__name__}")
    width, height = _size_of(size)
    isovalues = _floats("isovalue", [isovalue] if np.ndim(isovalue) == 0 else isovalue)
    if not isovalues:
        raise ValueError("isovalue: expected a number or several, found none")
    command = [find_program(), "render", _absolute(path)]
    command += [_option("isovalue", *isovalues), f"--size={width}x{height}"]
    command += [*camera.arguments(), f"--background={text('background', background)}"]
    if level is not None:
        command.append(f"--level={level}")
    if len(_listed("colours", colours)):
        command.append("--colour=" + ",".join(text("colours", each) for each in colours))
    if len(_listed("opacities", opacities)):
        command.append(_option("opacity", *_floats("opacities", opacities)))
    command += [text("options", each) for each in _listed("options", options)]
    with tempfile.TemporaryDirectory(prefix="isosplat-") as folder:
        picture = os.path.join(folder, "picture.png")
        run = subprocess.run(
            [*command, "--output", picture],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            errors="replace",
        )
        if run.returncode != 0:
            raise _error_of(run)
        if not os.path.isfile(picture):
            raise ValueError("options: expected options that draw one picture, found others")
        return _core.read_png(os.fsencode(picture))


def _error_of(run: "subprocess.CompletedProcess[str]") -> Exception:
    lines = run.stderr.strip().splitlines() or [f"it ended with status {run.returncode}"]
    # Notes precede the error.
    message = lines[-1].removeprefix("isosplat: ")
    return ValueError(message) if run.returncode == 2 else RuntimeError(message)


def _absolute(path: str) -> str:
    # Never an option, even if a name begins with a hyphen.
    return path if is_address(os.fsencode(path)) else os.path.abspath(path)


def _size_of(size: Any) -> Tuple[int, int]:
    listed = _listed("size", size)
    if len(listed) != 2:
        raise ValueError(f"size: expected (width, height), found {size!r}")
    width, height = (whole("size", each, 1, _MAX_SIZE) for each in listed)
    return width, height


def _listed(name: str, values: Any) -> List[Any]:
    if isinstance(values, (str, bytes)):
        raise TypeError(f"{name}: expected a list, found {values!r}")
    try:
        return list(values)
    except TypeError:
        raise TypeError(f"{name}: expected a list, found {values!r}") from None


def _floats(name: str, values: Any) -> List[float]:
    return [number(name, each) for each in _listed(name, values)]


def _option(name: str, *values: float) -> str:
    return f"--{name.replace('_', '-')}=" + ",".join(repr(each) for each in values)
