"""What the views of this process show: one server for all of them."""

from __future__ import annotations

import atexit
import hashlib
import hmac
import json
import os
import secrets
import shutil
import tempfile
import threading
import time
import urllib.error
import urllib.request
from typing import Any, Dict, Optional

from ._server import Server, start

# Of the links to what is shown. The server ends with this process anyway.
_VALID_SECONDS = 30 * 24 * 3600

# The server reads a new file at once. A busy machine may delay it.
_MAX_WAIT_SECONDS = 60

_MAX_READ_BYTES = 64 << 20


class Shown:
    """A store or a scene that the server of this process serves to who has its link.

    path: of its description, relative to the server's address, with the signature of the link."""

    def __init__(self, server: "_ViewServer", name: str, link: str) -> None:
        self._server = server
        self._link = link
        kind, self._name = name.split("/", 1)
        self.is_scene = kind == "scenes"
        end = int(time.time()) + _VALID_SECONDS
        first = "isosplat scene link 1" if self.is_scene else "isosplat link 1"
        signed = f"{first}\n{self._name}\n{end}".encode()
        signature = hmac.new(server.key.encode(), signed, hashlib.sha256).hexdigest()
        self._signature = f"exp={end}&sig={signature}"
        self.path = f"v1/{name}?{self._signature}"
        described = server.json(self.path)
        self.content_id = str(described["contentId"])
        self._file = f"v1/{name}/{self.content_id}/file?{self._signature}"
        self.file_bytes = server.size(self._file)

    @property
    def port(self) -> int:
        return int(self._server.server.url.rstrip("/").rpartition(":")[2])

    @property
    def address(self) -> str:
        """Of the description, for programs of this machine."""
        return self._server.server.url + self.path

    @property
    def page(self) -> str:
        """The address of the page that shows it, for browsers of this machine."""
        kind = "scene" if self.is_scene else "volume"
        return f"{self._server.server.url}?{kind}={self._name}&{self._signature}"

    def read(self, offset: Any, count: Any) -> bytes:
        """Bytes of the store, or of the scene as a bundle. Raises ValueError."""
        if not all(type(each) is int for each in (offset, count)):
            raise ValueError("expected whole numbers of bytes")
        if not (0 <= offset and 0 < count <= _MAX_READ_BYTES and offset + count <= self.file_bytes):
            raise ValueError(f"expected a range of {self.file_bytes} bytes, found {offset}+{count}")
        return self._server.get(self._file, f"bytes={offset}-{offset + count - 1}")

    def page_file(self, name: str) -> bytes:
        """A file of the page."""
        return self._server.get(name)

    def close(self) -> None:
        """Ends serving it, and removes the store if it was built for the view."""
        self._server.remove(self._link)


class _ViewServer:
    """A server of a temporary folder, which has links to what is shown."""

    def __init__(self) -> None:
        self.key = secrets.token_hex(32)
        self.folder = tempfile.mkdtemp(prefix="isosplat-view-")
        # Not through the proxy of the environment: this is the same machine.
        self._opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
        self._owner = os.getpid()
        self._count = 0
        atexit.register(self.close)
        # Pages of notebooks have many origins. Each needs a link, which this process alone makes.
        self.server: Server = start(
            [os.fsencode(self.folder)],
            ["--port=0", "--public"],
            secrets.token_urlsafe(24),
            ISOSPLAT_LINK_KEY=self.key,
            ISOSPLAT_VIEWS=self.folder,
        )

    def new_path(self, suffix: str) -> str:
        """A new path in the folder. Names of views are never used twice: browsers keep what they read."""
        with _lock:
            self._count += 1
            return os.path.join(self.folder, f"view-{self._count}{suffix}")

    def shown(self, path: str, member: str = "") -> Shown:
        """The store or scene at a path of the folder. member: the scene's name in a folder."""
        base = os.path.basename(path)
        is_scene = bool(member) or base.endswith(".isobundle")
        name = os.path.splitext(base)[0] if not member else f"{base}~{member}"
        kind = "scenes" if is_scene else "volumes"
        end = time.monotonic() + _MAX_WAIT_SECONDS
        while True:
            try:
                self.get(f"v1/{kind}/{name}")
                return Shown(self, f"{kind}/{name}", path)
            except urllib.error.HTTPError as error:
                with error:
                    message = error.read().decode("utf-8", "replace").strip()
                if error.code not in (404, 503) or time.monotonic() > end:
                    raise ValueError(f"{os.path.realpath(path)}: cannot be shown: {message}") from None
            time.sleep(0.02)

    def get(self, path: str, bytes_range: Optional[str] = None) -> bytes:
        with self._open(path, {"Range": bytes_range} if bytes_range else {}) as response:
            body: bytes = response.read()
            return body

    def json(self, path: str) -> Dict[str, Any]:
        found: Dict[str, Any] = json.loads(self.get(path))
        return found

    def size(self, path: str) -> int:
        with self._open(path, {}, "HEAD") as response:
            return int(response.headers["Content-Length"])

    def _open(self, path: str, headers: Dict[str, str], method: str = "GET") -> Any:
        fields = {"Authorization": f"Bearer {self.server.token}", **headers}
        request = urllib.request.Request(self.server.url + path, headers=fields, method=method)
        return self._opener.open(request, timeout=_MAX_WAIT_SECONDS)

    def remove(self, path: str) -> None:
        if self._owner != os.getpid():
            return
        if os.path.isdir(path) and not os.path.islink(path):
            shutil.rmtree(path, ignore_errors=True)
        elif os.path.lexists(path):
            os.unlink(path)

    @property
    def is_usable(self) -> bool:
        return self.server.is_running

    def close(self) -> None:
        if self._owner == os.getpid():
            self.server.stop()
            shutil.rmtree(self.folder, ignore_errors=True)


_lock = threading.Lock()
_current: Optional[_ViewServer] = None


def view_server() -> _ViewServer:
    """The server of this process, which its first view starts."""
    global _current
    with _lock:
        if _current is None or not _current.is_usable:
            if _current is not None:
                _current.close()
            _current = _ViewServer()
        return _current
