"""The program isosplat, which this package runs in processes of its own."""

from __future__ import annotations

import os
from typing import Iterator

_HERE = os.path.dirname(os.path.realpath(__file__))


def find_program() -> str:
    """The path of the program that belongs to this package. Raises FileNotFoundError."""
    chosen = os.environ.get("ISOSPLAT_PROGRAM")
    if chosen:
        if not _is_program(chosen):
            raise FileNotFoundError(
                f"ISOSPLAT_PROGRAM: expected a program, found {chosen!r}: correct the variable"
            )
        return chosen
    for path in _places():
        if _is_program(path):
            return path
    raise FileNotFoundError(
        f"{_HERE}: expected the program isosplat beside this package, found none: install the "
        "package again, or set ISOSPLAT_PROGRAM to the path of the program"
    )


def _places() -> Iterator[str]:
    yield os.path.join(_HERE, "program/bin/isosplat")  # a wheel
    # PREFIX/lib/python3/dist-packages/isosplat: Debian's package, and the archive. Without the page,
    # bin/isosplat is the script that pip has made of a wheel, which looks for the program here.
    prefix = os.path.normpath(os.path.join(_HERE, "../../../.."))
    if os.path.isdir(os.path.join(prefix, "share/isosplat")):
        yield os.path.join(prefix, "bin/isosplat")
    # build/release/native/python/package/isosplat: the build for developers.
    yield os.path.normpath(os.path.join(_HERE, "../../../cli/isosplat"))


def _is_program(path: str) -> bool:
    return os.path.isfile(path) and os.access(path, os.X_OK)
