"""isosplat.serve: a server in a process of its own."""

import json
import os
import signal
import subprocess
import sys
import time
import urllib.error
import urllib.request

import isosplat
import pytest
from conftest import PROGRAM


@pytest.fixture(autouse=True)
def program(monkeypatch):
    monkeypatch.setenv("ISOSPLAT_PROGRAM", str(PROGRAM))


def volumes(url, token=None):
    """The names of the volumes that a client with this token sees."""
    headers = {"Authorization": f"Bearer {token}"} if token else {}
    request = urllib.request.Request(url + "v1/volumes", headers=headers)
    with urllib.request.urlopen(request, timeout=60) as response:
        return [volume["name"] for volume in json.load(response)["volumes"]]


def wait_until_unreachable(url):
    while True:  # pytest's caller limits the time
        try:
            urllib.request.urlopen(url, timeout=60).close()
        except urllib.error.HTTPError:
            pass
        except (urllib.error.URLError, ConnectionError):
            return
        time.sleep(0.05)


def test_only_who_has_the_token_reads_the_volumes(store):
    with isosplat.serve(store) as server:
        assert server.is_running and len(server.token) >= 16
        assert volumes(server.url, server.token) == ["sphere"]
        for token in (None, "x" * 32):
            with pytest.raises(urllib.error.HTTPError) as refused:
                volumes(server.url, token)
            assert refused.value.code == 401
        assert server.token not in repr(server)
        with open(f"/proc/{server._process.pid}/cmdline", "rb") as file:
            assert server.token.encode() not in file.read()
        cookies = urllib.request.HTTPCookieProcessor()
        with urllib.request.build_opener(cookies).open(server.address, timeout=60) as page:
            assert page.status == 200 and "token" not in page.url
    assert not server.is_running
    wait_until_unreachable(server.url)
    server.stop()  # again, which does nothing


def test_paths_folders_and_servers_for_all(store, tmp_path):
    with isosplat.serve([store.path, tmp_path / "sphere.isosplat"], private=False) as server:
        assert server.token is None and server.address == server.url
        assert "sphere" in volumes(server.url)
    with isosplat.serve(tmp_path) as server:
        remote = volumes(server.url, server.token)
        assert remote == ["sphere"]


@pytest.mark.parametrize("ending", ["exit", "exception", "SIGKILL", "SIGTERM"])
def test_it_ends_with_the_process_that_has_started_it(ending, store):
    code = """
import os, signal, sys, isosplat
server = isosplat.serve(sys.argv[1])
print(server.url, flush=True)
if sys.argv[2] == "exception": raise KeyError
if sys.argv[2] != "exit": os.kill(os.getpid(), getattr(signal, sys.argv[2]))
"""
    run = subprocess.run(
        [sys.executable, "-c", code, store.path, ending], capture_output=True, text=True
    )
    assert run.stdout.startswith("http://"), run.stderr
    wait_until_unreachable(run.stdout.strip() + "healthz")


def test_an_interrupt_of_the_group_and_a_forked_process_leave_it_running(store):
    with isosplat.serve(store) as server:
        assert os.getsid(server._process.pid) != os.getsid(0)
        child = os.fork()
        if child == 0:
            server.stop()
            os._exit(0)
        os.waitpid(child, 0)
        assert server.is_running and volumes(server.url, server.token) == ["sphere"]


def test_a_server_that_dies_is_reported(store):
    with isosplat.serve(store) as server:
        os.kill(server._process.pid, signal.SIGKILL)
        server._process.wait()
        assert not server.is_running and "stopped" in repr(server)


@pytest.mark.parametrize(
    "stores, arguments, error",
    [
        ([], {}, ValueError),
        (None, {}, TypeError),
        (7, {}, TypeError),
        ([7], {}, TypeError),
        ("", {}, ValueError),
        ("/no/such/store", {}, RuntimeError),
        ("https://example.org/a.isosplat", {}, ValueError),
        ("/tmp", {"port": 70000}, ValueError),
        ("/tmp", {"port": "80"}, TypeError),
        ("/tmp", {"options": "--public"}, TypeError),
        ("/tmp", {"options": ["--no-such-option"]}, ValueError),
        ("/tmp", {"options": ["--host", "0.0.0.0"]}, (RuntimeError, ValueError)),
    ],
)
def test_arguments_that_cannot_work(stores, arguments, error):
    with pytest.raises(error):
        isosplat.serve(stores, **arguments)


def test_a_port_in_use(store):
    with isosplat.serve(store) as server:
        port = int(server.url.rstrip("/").rsplit(":", 1)[1])
        with pytest.raises(RuntimeError, match=str(port)):
            isosplat.serve(store, port=port)
