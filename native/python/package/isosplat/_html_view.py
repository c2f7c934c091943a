"""Views as HTML, for notebooks without anywidget."""

from __future__ import annotations

import base64
import html
import json
import os
from typing import Any, Dict, List
from urllib.parse import quote

from ._arguments import Path, path_bytes
from ._shown import Shown

_HERE = os.path.dirname(os.path.realpath(__file__))

# Bytes in one element of a page: a multiple of 3, so that only the last one has padding.
_PART_BYTES = 3 << 20

# Browsers read larger pages slowly, or refuse them.
_MAX_PAGE_BYTES = 300_000_000


def loader() -> str:
    """The module that finds the server and shows the view."""
    with open(os.path.join(_HERE, "_view.js"), encoding="utf-8") as file:
        return file.read()


def kernel_of(shown: Shown, proxy: str) -> Dict[str, Any]:
    """What the module needs to find the server."""
    return {
        "address": shown.address,
        "path": shown.path,
        "port": shown.port,
        "proxy": proxy,
        "content": shown.content_id,
        "bytes": shown.file_bytes,
    }


class HtmlView:
    """A view of a volume, which notebooks display as HTML. isosplat.view() returns it where anywidget
    is not installed."""

    def __init__(self, shown: Shown, proxy: str, traits: Dict[str, Any]) -> None:
        self._shown = shown
        self._proxy = proxy
        self._traits = traits

    def __setattr__(self, name: str, value: Any) -> None:
        # Otherwise a new isovalue would have no effect, and raise no error.
        if not name.startswith("_"):
            raise AttributeError(
                f"{name}: expected anywidget, without which values do not reach the picture: install it "
                "for this kernel, or call isosplat.view() again"
            )
        super().__setattr__(name, value)

    @property
    def address(self) -> str:
        """The address of the page for a browser of this machine. Who has it can read the volume, as long
        as this process runs."""
        return self._shown.page

    def close(self) -> None:
        """Ends serving the volume."""
        self._shown.close()

    def save(self, path: Path) -> None:
        """Writes a page with the viewer and the store or the scene, which needs neither this process nor
        a network. Raises OSError, and ValueError above 300 MB."""
        save_page(self._shown, self._traits, path)

    def _repr_html_(self) -> str:
        shown = {"scene" if self._shown.is_scene else "src": self._shown.address}
        traits = {**self._traits, **shown, "height": "100vh"}
        height = html.escape(str(self._traits.get("height") or "30rem"), quote=True)
        call = json.dumps([kernel_of(self._shown, self._proxy), traits], default=_plain)
        page = (
            "<!doctype html><meta charset='utf-8'><style>body{margin:0}</style><body>"
            f"<script type='module'>{loader()}\nshowPage(...{_in_script(call)});</script>"
        )
        return (
            f'<iframe srcdoc="{html.escape(page, quote=True)}" width="100%" '
            f'style="border: 0; height: {height}" allow="fullscreen"></iframe>'
        )

    def __repr__(self) -> str:
        # Without the link: notebooks and logs keep what is printed.
        return "<isosplat.HtmlView: for notebooks; its address is for browsers>"


def save_page(shown: Shown, traits: Dict[str, Any], path: Path) -> None:
    """Writes single.html of the page with the bytes of the store or the bundle."""
    target = path_bytes("path", path)
    size = shown.file_bytes
    if size > _MAX_PAGE_BYTES:
        raise ValueError(
            f"expected a store of at most {_MAX_PAGE_BYTES // 10**6} MB, found {size // 10**6} MB: "
            "publish it with `isosplat publish`"
        )
    before, _, after = shown.page_file("single.html").decode().partition("<!-- store -->")
    parts: List[str] = [before]
    for offset in range(0, size, _PART_BYTES):
        piece = base64.b64encode(shown.read(offset, min(_PART_BYTES, size - offset))).decode()
        parts.append(f'<script type="text/plain" data-store>{piece}</script>\n')
    isovalue = traits.get("isovalue")
    view = "" if isovalue is None else f"isovalue={quote(str(isovalue))}"
    parts.append(f'<meta name="isosplat-name" content="volume"><meta name="isosplat-view" content="{view}">')
    with open(target, "w", encoding="utf-8") as file:
        file.writelines([*parts, after])


def _plain(value: Any) -> Any:
    """NumPy's numbers and arrays as JSON."""
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"expected numbers, texts, lists and dicts as traits, found {value!r}")


def _in_script(text: str) -> str:
    """JSON that contains no end of a script."""
    return text.replace("<", "\\u003c")
