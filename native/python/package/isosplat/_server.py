"""Servers in processes of their own."""

from __future__ import annotations

import atexit
import collections
import os
import secrets
import signal
import subprocess
import threading
import weakref
from types import TracebackType
from typing import Any, Deque, List, Optional, Sequence, Type, Union

from ._arguments import Path, is_address, path_bytes, text, whole
from ._program import find_program
from ._scene import Scene
from ._store import Store

_READY = "Isosplat is ready: "

# The program runs in a session of its own, so that an interrupt of a notebook's cell does not stop it.
# It ends when the pipe of file 3 closes: by Server.stop(), or because this process has ended, however
# that happened. `kill 0` ends the processes of that session, of which the program may be the only one.
# ISOSPLAT_VIEWS is the temporary folder of a server of views.
_SCRIPT = """exec 3<&0
{ cat <&3; rm -rf -- ${ISOSPLAT_VIEWS:+"$ISOSPLAT_VIEWS"}; kill 0; } >/dev/null 2>&1 &
exec "$@" 3<&- </dev/null
"""

_MAX_STOP_SECONDS = 30

Stores = Union[Scene, Store, Path, Sequence[Union[Scene, Store, Path]]]


class Server:
    """A running server: isosplat.serve() returns it. Use it in a with statement, or stop() it. It ends
    with this process at the latest."""

    def __init__(self, process: "subprocess.Popen[str]", token: Optional[str]) -> None:
        self._process = process
        self._owner = os.getpid()
        self._log: Deque[str] = collections.deque(maxlen=100)
        assert process.stderr is not None
        self._reader = threading.Thread(
            target=self._log.extend, args=(process.stderr,), daemon=True, name="isosplat.Server"
        )
        self._reader.start()
        self.token = token
        """What grants access; None: everyone on this machine has access."""
        self.url = ""
        """Of the page and the data, such as http://localhost:8080/."""
        _running.add(self)

    @property
    def address(self) -> str:
        """The address of the page for a browser, with the token. Who has it can read the volumes."""
        return f"{self.url}?token={self.token}" if self.token else self.url

    @property
    def log(self) -> List[str]:
        """The last lines of the server's log, at most 100."""
        return [line.rstrip("\n") for line in list(self._log)]

    @property
    def is_running(self) -> bool:
        return self._owner == os.getpid() and self._process.poll() is None

    def stop(self) -> None:
        """Stops the server, and waits until it has ended. Does nothing in a forked process, whose
        parent has the server."""
        if self._owner != os.getpid():
            return
        _running.discard(self)
        assert self._process.stdin is not None and self._process.stdout is not None
        self._process.stdin.close()
        try:
            self._process.wait(_MAX_STOP_SECONDS)
        except subprocess.TimeoutExpired:
            os.killpg(self._process.pid, signal.SIGKILL)
            self._process.wait()
        self._reader.join(_MAX_STOP_SECONDS)
        self._process.stdout.close()
        if not self._reader.is_alive() and self._process.stderr is not None:
            self._process.stderr.close()

    def _wait_until_ready(self) -> None:
        assert self._process.stdout is not None
        try:
            for line in self._process.stdout:
                if line.startswith(_READY):
                    self.url = line[len(_READY) :].split()[0]
                    return
        except BaseException:  # Ctrl-C
            self.stop()
            raise
        status = self._process.wait()
        self.stop()
        message = self.log[-1] if self.log else f"it ended with status {status}"
        message = message.removeprefix("isosplat: ")
        raise ValueError(message) if status == 2 else RuntimeError(message)

    def __enter__(self) -> "Server":
        return self

    def __exit__(
        self,
        kind: Optional[Type[BaseException]],
        error: Optional[BaseException],
        trace: Optional[TracebackType],
    ) -> None:
        self.stop()

    def __repr__(self) -> str:
        # Without the token: notebooks and logs keep what is printed.
        return f"<isosplat.Server {self.url}{'' if self.is_running else ', stopped'}>"


_running: "weakref.WeakSet[Server]" = weakref.WeakSet()


@atexit.register
def _stop_all() -> None:
    for server in list(_running):
        server.stop()


def serve(
    stores: Stores,
    *,
    port: int = 0,
    private: bool = True,
    options: Sequence[str] = (),
) -> Server:
    """Serves stores, scenes and the page with `isosplat serve` in a process of its own, and returns
    when the server answers.

    stores: an open store or scene, a path of a store, a scene or a folder of them, or a list of these. port:
    0: any free one. Only programs on this machine can reach the server.

    private: the server has a random token, `Server.token`, without which nobody can read the volumes.
    Other users of this machine can reach the port too.

    options: further options of the command, such as ["--cors", "http://localhost:8888"]: see
    `isosplat serve --help`.

    Raises ValueError for arguments that the command refuses, RuntimeError with its message if it
    fails, such as for a port that is in use."""
    paths = [_path_of(each) for each in _listed(stores)]
    if not paths:
        raise ValueError("stores: expected at least one, found none")
    if isinstance(options, (str, bytes)):
        raise TypeError(f"options: expected a list, found {options!r}")
    chosen = [f"--port={whole('port', port, 0, 65535)}", *(text("options", each) for each in options)]
    return start(paths, chosen, secrets.token_urlsafe(24) if private else None)


def start(paths: Sequence[bytes], options: Sequence[str], token: Optional[str], **secret: str) -> Server:
    """Runs `isosplat serve`. secret: further variables of its environment, which other users cannot see,
    unlike the arguments of a program."""
    environment = {**os.environ, **secret}
    if "ISOSPLAT_VIEWS" not in secret:
        environment.pop("ISOSPLAT_VIEWS", None)
    for name in ("ISOSPLAT_TOKEN", "NOTIFY_SOCKET", "LISTEN_FDS", "LISTEN_PID"):
        environment.pop(name, None)
    if token:
        environment["ISOSPLAT_TOKEN"] = token
    command: List[Any] = ["/bin/sh", "-c", _SCRIPT, "sh", find_program(), "serve", *paths, *options]
    process = subprocess.Popen(
        command,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        errors="replace",
        env=environment,
        start_new_session=True,
    )
    server = Server(process, token)
    server._wait_until_ready()
    return server


def _listed(stores: Any) -> List[Any]:
    if isinstance(stores, (Scene, Store, str, bytes, os.PathLike)):
        return [stores]
    try:
        return list(stores)
    except TypeError:
        raise TypeError(f"stores: expected stores or paths, found {stores!r}") from None


def _path_of(store: Any) -> bytes:
    """An absolute path, which is never an option."""
    path = path_bytes("stores", store.path if isinstance(store, (Scene, Store)) else store)
    if is_address(path):
        raise ValueError(
            f"stores: expected files or folders, found the address {os.fsdecode(path)}: it is served "
            "already"
        )
    return os.path.abspath(path)
