"""The widget of isosplat.view(). Importing it needs anywidget."""

# mypy: allow-untyped-calls, allow-untyped-decorators
from __future__ import annotations

from typing import Any, Dict, List, Optional

import traitlets

from ._arguments import Path
from ._html_view import kernel_of, loader, save_page
from ._shown import Shown
from ._widget_traits import IsosplatWidget


class KernelWidget(IsosplatWidget):
    """A view of a volume. isosplat.view() returns it where anywidget is installed. Its traits are those
    of IsosplatWidget.

    The module finds out whether the browser can reach the server of this process. If not, it requests
    its own code, {"kind": "module", "id"}, and bytes of the store, {"kind": "read", "id", "offset",
    "bytes"}. An answer has the same kind and id, and one buffer or an error."""

    _kernel = traitlets.Dict().tag(sync=True)

    def __init__(self, shown: Shown, proxy: str, traits: Dict[str, Any]) -> None:
        self._shown = shown
        self._proxy = proxy
        address = {"scene" if shown.is_scene else "src": shown.address}
        super().__init__(module=loader(), **address, **traits)
        self.on_msg(self._answer)

    @traitlets.default("_kernel")
    def _kernel_default(self) -> Dict[str, Any]:
        return kernel_of(self._shown, self._proxy)

    @property
    def address(self) -> str:
        """The address of the page for a browser of this machine. Who has it can read the volume, as long
        as this process runs."""
        return self._shown.page

    def save(self, path: Path) -> None:
        """Writes a page with the viewer and the store or the scene, which needs neither this process nor
        a network. Raises OSError, and ValueError above 300 MB."""
        save_page(self._shown, {"isovalue": self.isovalue}, path)

    def close(self) -> None:
        """Removes the views, and ends serving the volume."""
        super().close()
        self._shown.close()

    def _answer(self, _widget: Any, content: Any, _buffers: Any) -> None:
        if not isinstance(content, dict) or content.get("kind") not in ("read", "module"):
            return
        answer = {"kind": content["kind"], "id": content.get("id")}
        buffers: Optional[List[bytes]] = None
        try:
            if content["kind"] == "read":
                buffers = [self._shown.read(content.get("offset"), content.get("bytes"))]
            else:
                buffers = [self._shown.page_file("isosplat-anywidget-single.js")]
        except Exception as error:  # for the picture: an exception of a message has no reader
            answer["error"] = str(error)
        self.send(answer, buffers)
