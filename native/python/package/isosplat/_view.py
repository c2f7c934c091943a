"""Views of volumes in notebooks."""

# mypy: allow-untyped-calls
from __future__ import annotations

import os
from typing import Any, Optional, Sequence

from ._arguments import is_address, number, path_bytes, text
from ._build import build
from ._geometry import is_volume
from ._scene import Scene
from ._scene_links import link_scene
from ._shown import Shown, view_server
from ._store import Store

# The first bytes of a store (FORMAT.md).
_STORE_MAGIC = b"\x89ISOS\r\n\x1a"

_TRAITS = (
    "surfaces camera clip slices background controls show link height step"  # of the element
).split()


def view(
    volume: Any,
    isovalue: Optional[float] = None,
    *,
    spacing: Optional[Sequence[float]] = None,
    origin: Optional[Sequence[float]] = None,
    direction: Optional[Any] = None,
    units: Optional[str] = None,
    title: str = "",
    max_error: Optional[float] = None,
    proxy: str = "",
    **traits: Any,
) -> Any:
    """Shows a volume in a notebook: the value of the last line of a cell, or of display().

    volume: an array, an image or a file, which is built first (spacing … max_error are those of build); an open
    store or scene; or the path of one. isovalue: of the first surface. Default: the volume's
    first suggestion.

    If anywidget is installed, the result is a widget. Its traits isovalue, surfaces, camera, clip,
    slices, step and picked follow the picture, and the picture follows them. Otherwise the result is
    displayed as HTML, and nothing returns from the picture.

    traits: further traits: surfaces ([{"isovalue": 60, "colour": "#d9ccb3", "opacity": 1}, …]), camera
    ({"azimuth": 90, …}), clip, slices, background (rrggbb), controls (False: none), show
    ("axes,scale,box,clip"), link (views with the same name move together), height (of CSS: "30rem"),
    step. help() of the widget describes them.

    The browser reads the volume from a server of this process, which ends with it. Only who has the
    view's link can read it. If a browser cannot reach ports of this machine, the widget reads through
    the kernel's messages. proxy: the address under which the notebook's browser reaches a port, such as
    "/user/me/proxy/{port}/"; that of jupyter-server-proxy is found without it.

    volume may also be the address of a volume or a scene of a server (https://…/v1/volumes/NAME), which
    the browser reads itself: its server has to allow that (--cors). This needs anywidget.

    Raises what build raises."""
    unknown = sorted(set(traits) - set(_TRAITS))
    if unknown:
        raise TypeError(f"expected traits ({', '.join(_TRAITS)}), found {', '.join(unknown)}")
    if isovalue is not None:
        traits["isovalue"] = number("isovalue", isovalue)
    proxy = text("proxy", proxy)
    if proxy and "{port}" not in proxy:
        raise ValueError(f"proxy: expected an address with {{port}}, found {proxy!r}")
    options = {
        "spacing": spacing,
        "origin": origin,
        "direction": direction,
        "units": units,
        "title": title,
        "max_error": max_error,
    }
    given = {name: value for name, value in options.items() if value not in (None, "")}
    address = _address_of(volume)
    if address:
        return _remote_view(address, traits, given or proxy)
    shown = _shown(volume, given)
    from ._html_view import HtmlView

    try:
        # Installed by the user; it imports much.
        from ._kernel_widget import KernelWidget
    except ImportError:
        return HtmlView(shown, proxy, traits)
    return KernelWidget(shown, proxy, traits)


def _address_of(volume: Any) -> str:
    """The address of a store that is not on this machine; else empty."""
    path = volume.path if isinstance(volume, Store) else volume
    is_path = isinstance(path, (str, bytes, os.PathLike))
    return os.fsdecode(path) if is_path and is_address(os.fsencode(path)) else ""


def _remote_view(address: str, traits: Any, others: Any) -> Any:
    """The widget of a volume or a scene of a server, which the browser reads itself."""
    if others:
        raise TypeError("expected no options of a build and no proxy=, because the volume is at an address")
    try:
        from ._widget_traits import IsosplatWidget
    except ImportError:
        raise ImportError(
            f"{address}: expected anywidget, which shows volumes at addresses: install it, or open the "
            "page of the server"
        ) from None
    name = "scene" if "/v1/scenes/" in address else "src"
    return IsosplatWidget(**{name: address}, **traits)


def _shown(volume: Any, options: Any) -> Shown:
    server = view_server()
    if isinstance(volume, (Scene, Store)):
        volume = volume.path
    if is_volume(volume):
        target = server.new_path(".isosplat")
        build(volume, target, **options).close()
        return server.shown(target)
    path = path_bytes("volume", volume)
    os.stat(path)  # raises FileNotFoundError, PermissionError, …
    found = os.fsdecode(os.path.abspath(path))
    document = _document_of(found)
    is_bundle = found.endswith(".isobundle")
    if document or is_bundle or _is_store(found):
        if options:
            raise TypeError(f"{', '.join(options)}: expected none, because the volume is a store")
        if document:
            target = server.new_path("")
            link_scene(document, target)
            return server.shown(target, "scene")
        target = server.new_path(".isobundle" if is_bundle else ".isosplat")
        os.symlink(found, target)
        return server.shown(target)
    target = server.new_path(".isosplat")
    build(path, target, **options).close()
    return server.shown(target)


def _document_of(path: str) -> str:
    """The document of a scene at a path or in a folder; empty: none."""
    if os.path.isdir(path):
        document = os.path.join(path, "scene.json")
        return document if os.path.isfile(document) else ""
    name = os.path.basename(path)
    return path if name == "scene.json" or name.endswith(".scene.json") else ""


def _is_store(path: str) -> bool:
    if not os.path.isfile(path):
        return False
    with open(path, "rb") as file:
        return file.read(len(_STORE_MAGIC)) == _STORE_MAGIC
