"""What builds of scenes share: their output, and the program that makes a part of it."""

from __future__ import annotations

import collections
import os
import re
import shutil
import signal
import subprocess
import tempfile
from contextlib import contextmanager
from typing import Any, Callable, Deque, Iterator, List, Optional, Sequence

from ._arguments import Path, is_address, path_bytes
from ._program import find_program

Progress = Callable[[float, str], object]

# The first bytes of a bundle (BUNDLE.md).
_MAGIC = b"\x89ISOB\r\n\x1a"

_PROGRESS = re.compile(r"Building .*: (\d+) %, (.*)")


@contextmanager
def scene_output(path: Path, overwrite: bool) -> Iterator[str]:
    """A new folder beside the output. In the context, make there what has the output's name: a bundle
    or a folder. Then it replaces the output. After an exception nothing is left. Raises ValueError,
    FileExistsError, OSError."""
    encoded = path_bytes("path", path)
    if is_address(encoded):
        raise ValueError("path: expected a file, found an address: build to a file, and upload it")
    given = os.fsdecode(encoded)
    is_bundle = given.endswith(".isobundle")
    if not is_bundle and not given.endswith(os.sep):
        raise ValueError(
            f"path: expected NAME.isobundle, or a folder NAME/ for a scene, found {given!r}"
        )
    target = os.path.abspath(given)
    _check_free(target, is_bundle, overwrite)
    parent, name = os.path.split(target)
    folder = tempfile.mkdtemp(prefix=f".{name}.", suffix=".building", dir=parent)
    try:
        made = os.path.join(folder, name)
        yield made
        os.replace(made, target)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _check_free(target: str, is_bundle: bool, overwrite: bool) -> None:
    """Another file than an older bundle is replaced only with overwrite; a folder only if it is empty."""
    if not os.path.lexists(target):
        return
    if os.path.isdir(target):
        if is_bundle or os.listdir(target):
            raise FileExistsError(f"{target}: expected no folder, or an empty one, found another")
        return
    with open(target, "rb") as file:
        beginning = file.read(len(_MAGIC))
    if not is_bundle or (beginning not in (b"", _MAGIC) and not overwrite):
        raise FileExistsError(
            f"{target}: expected no file, or a bundle, found another file: give another name, or "
            "replace it with overwrite=True"
        )


def run_program(arguments: Sequence[Any], progress: Optional[Progress] = None) -> None:
    """Runs the program isosplat, which prints its progress. It ends with any exception. Raises ValueError
    with its message if it refuses its arguments or its input, else RuntimeError."""
    process = subprocess.Popen(
        [find_program(), *arguments],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        errors="replace",
        start_new_session=True,
    )
    last: Deque[str] = collections.deque(maxlen=20)
    try:
        assert process.stderr is not None
        for line in process.stderr:
            reported = _PROGRESS.match(line)
            if reported and progress is not None:
                progress(int(reported[1]) / 100, reported[2])
            elif not reported:
                last.append(line.strip())
        status = process.wait()
    except BaseException:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        raise
    finally:
        assert process.stderr is not None
        process.stderr.close()
    if status != 0:
        messages: List[str] = [line for line in last if line.startswith("isosplat: ")]
        message = messages[-1].removeprefix("isosplat: ") if messages else f"status {status}"
        raise ValueError(message) if messages else RuntimeError(f"isosplat ended with {message}")
