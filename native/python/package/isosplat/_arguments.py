"""Checks of arguments that several modules share."""

from __future__ import annotations

import math
import operator
import os
from typing import Any, Optional, Sequence, Tuple, Union

Path = Union[str, bytes, "os.PathLike[str]", "os.PathLike[bytes]"]

MAX_THREADS = 256


def path_bytes(name: str, path: Any) -> bytes:
    """The bytes of a path. Raises TypeError, and ValueError for an empty path or a null byte."""
    try:
        encoded = os.fsencode(path)
    except TypeError:
        raise TypeError(f"{name}: expected a path, found {type(path).__name__}") from None
    if not encoded:
        raise ValueError(f"{name}: expected a path, found an empty text")
    if b"\0" in encoded:
        raise ValueError(f"{name}: expected a path, found a text with a null byte")
    return encoded


def is_address(path: bytes) -> bool:
    return path.lower().startswith((b"http://", b"https://", b"s3://"))


def number(name: str, value: Any) -> float:
    """A finite number. Raises TypeError or ValueError."""
    if isinstance(value, (str, bytes, bytearray)):
        raise TypeError(f"{name}: expected a number, found {value!r}")
    try:
        result = float(value)
    except (TypeError, OverflowError):
        raise TypeError(f"{name}: expected a number, found {value!r}") from None
    if not math.isfinite(result):
        raise ValueError(f"{name}: expected a finite number, found {result}")
    return result


def whole(name: str, value: Any, low: int, high: int) -> int:
    """A whole number from low to high. Raises TypeError or ValueError."""
    try:
        result = operator.index(value)
    except TypeError:
        raise TypeError(f"{name}: expected a whole number, found {value!r}") from None
    if not low <= result <= high:
        raise ValueError(f"{name}: expected a whole number from {low} to {high}, found {result}")
    return result


def numbers(name: str, values: Any, count: int) -> Tuple[float, ...]:
    """`count` finite numbers. Raises TypeError or ValueError."""
    try:
        listed = list(values)
    except TypeError:
        raise TypeError(f"{name}: expected {count} numbers, found {values!r}") from None
    if isinstance(values, (str, bytes, bytearray)):
        raise TypeError(f"{name}: expected {count} numbers, found {values!r}")
    if len(listed) != count:
        raise ValueError(f"{name}: expected {count} numbers, found {len(listed)}")
    return tuple(number(name, value) for value in listed)


def text(name: str, value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{name}: expected a text, found {type(value).__name__}")
    # Surrogates cannot be written to a store.
    return value.encode("utf-8", "replace").decode("utf-8")


def above_zero(name: str, value: Any) -> float:
    result = number(name, value)
    if result <= 0:
        raise ValueError(f"{name}: expected a number above 0, found {result}")
    return result


def spacing_of(values: Any) -> Tuple[float, ...]:
    spacing = numbers("spacing", values, 3)
    if not all(0 < each < 1e12 for each in spacing):
        raise ValueError(f"spacing: expected three numbers above 0 and below 10¹², found {spacing}")
    return spacing


def box_of(values: Optional[Sequence[Any]]) -> Optional[Tuple[float, ...]]:
    """The six numbers of ((x0, y0, z0), (x1, y1, z1)), or of a flat sequence."""
    if values is None:
        return None
    try:
        flat = [each for corner in values for each in corner]
    except TypeError:
        flat = list(numbers("box", values, 6))
    box = numbers("box", flat, 6)
    if not all(low < high for low, high in zip(box[:3], box[3:])):
        raise ValueError(
            "box: expected ((x0, y0, z0), (x1, y1, z1)) with x0 < x1, y0 < y1 and z0 < z1, "
            f"found {box}"
        )
    return box
