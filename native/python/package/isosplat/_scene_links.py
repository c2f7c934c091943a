"""Links to the files of a scene, in another folder."""

from __future__ import annotations

import json
import os
from typing import Any, Iterator
from urllib.parse import unquote

# Of the document of a scene (SCENE.md).
_MAX_BYTES = 4 << 20


def link_scene(document: str, folder: str) -> None:
    """Makes a folder with links to the document of a scene, as scene.json, and to its stores. The server
    follows links to files, but not to folders. Raises OSError, and ValueError if it is no document."""
    with open(document, "rb") as file:
        text = file.read(_MAX_BYTES + 1)
    try:
        if len(text) > _MAX_BYTES:
            raise ValueError(f"more than {_MAX_BYTES} bytes")
        parsed = json.loads(text)
        layers = parsed["layers"]
        paths = {path for layer in layers for path in _paths(layer)}
    except (ValueError, RecursionError, KeyError, TypeError) as error:
        raise ValueError(f"{document}: expected the document of a scene, found {error}") from None
    os.mkdir(folder)
    os.symlink(document, os.path.join(folder, "scene.json"))
    source = os.path.dirname(document)
    for path in paths:
        target = os.path.normpath(os.path.join(folder, path))
        # Addresses, and paths that lead out of the folder, are for the server to judge.
        if not target.startswith(folder + os.sep) or not os.path.isfile(os.path.join(source, path)):
            continue
        if not os.path.lexists(target):
            os.makedirs(os.path.dirname(target), exist_ok=True)
            os.symlink(os.path.join(source, path), target)


def _paths(layer: Any) -> Iterator[str]:
    for path in [layer.get("store"), *layer.get("stores", [])]:
        if isinstance(path, str) and "\0" not in path:
            yield unquote(path)
