"""isosplat.view: what it serves, and what it hands to notebooks. tests/browser/kernel.browser.ts shows it."""

import html
import json
import os
import re
import subprocess
import sys
import time
import types
import urllib.error
import urllib.request

import isosplat
import numpy as np
import pytest
from conftest import PROGRAM, run_program, sphere
from isosplat import _shown

traitlets = pytest.importorskip("traitlets")


@pytest.fixture(autouse=True)
def program(monkeypatch):
    monkeypatch.setenv("ISOSPLAT_PROGRAM", str(PROGRAM))


@pytest.fixture(autouse=True, scope="module")
def stopped_server():
    yield
    if _shown._current is not None:
        _shown._current.close()


def get(url):
    with urllib.request.urlopen(url, timeout=60) as response:
        return response.read()


def described(view):
    return json.loads(get(view._shown.address))


class AnyWidget(traitlets.HasTraits):
    """anywidget is not in Debian: its traits and messages alone."""

    def on_msg(self, callback):
        self._callback, self._sent = callback, []

    def send(self, content, buffers=None):
        self._sent.append((content, buffers))

    def close(self):
        self._is_closed = True


@pytest.fixture
def anywidget(monkeypatch):
    monkeypatch.setitem(sys.modules, "anywidget", types.SimpleNamespace(AnyWidget=AnyWidget))
    yield
    for name in ("_kernel_widget", "_widget_traits"):
        sys.modules.pop(f"isosplat.{name}", None)


@pytest.fixture
def no_anywidget(monkeypatch):
    monkeypatch.setitem(sys.modules, "anywidget", None)  # its import fails


def answer(view, content):
    view._callback(view, content, [])
    return view._sent.pop() if view._sent else None


# What it serves ------------------------------------------------------------------------------


def test_arrays_stores_paths_and_files_have_one_server(store, tmp_path, no_anywidget):
    array = sphere()
    np.save(tmp_path / "array.npy", array)
    views = [
        isosplat.view(array, spacing=(1, 2, 3)),
        isosplat.view(store),
        isosplat.view(store.path),
        isosplat.view(tmp_path / "array.npy", spacing=(1, 2, 3), title="from a file"),
    ]
    found = [described(view) for view in views]
    assert [each["spacing"] for each in found] == [[1, 2, 3]] * 4
    assert {each["contentId"] for each in found[1:3]} == {store.content_id}
    assert len({view._shown.port for view in views}) == 1
    assert len({each["name"] for each in found}) == 4
    assert get(views[0].address).lstrip().startswith(b"<!doctype html>")


def test_scenes(tmp_path, no_anywidget):
    for step in (0, 1):
        np.save(tmp_path / f"{step}.npy", sphere() + step)
    files = [str(tmp_path / f"{step}.npy") for step in (0, 1)]
    for target in ("run.isobundle", "run/"):
        run_program("build", *files, "-o", f"{tmp_path}/{target}")
    bundle = isosplat.view(tmp_path / "run.isobundle")
    folder = isosplat.view(tmp_path / "run")
    document = isosplat.view(tmp_path / "run/scene.json")
    for view in (bundle, folder, document):
        assert view._shown.is_scene and described(view)["steps"] == 2
        assert view._shown.read(0, 8) == (tmp_path / "run.isobundle").read_bytes()[:8]
    link = folder._shown._link
    folder.close()
    assert not os.path.exists(link) and (tmp_path / "run/stores").is_dir()
    (tmp_path / "scene.json").write_text('{"layers": 3}')
    with pytest.raises(ValueError, match="scene.json: expected the document of a scene"):
        isosplat.view(tmp_path / "scene.json")
    assert '"scene": "http' in html.unescape(bundle._repr_html_())


def test_only_who_has_the_link_reads_the_volume(store, no_anywidget):
    first, second = isosplat.view(store), isosplat.view(sphere())
    url, _, query = first._shown.address.partition("?")
    other = second._shown.address.partition("?")[2]
    for refused in (url, f"{url}?{other}", f"{url}?{query[:-1]}x"):
        with pytest.raises(urllib.error.HTTPError) as error:
            get(refused)
        assert error.value.code == 401
    for text in (repr(first), str(first)):
        assert "sig=" not in text
    mode = os.stat(_shown._current.folder).st_mode
    assert mode & 0o077 == 0


def test_closing_a_view_ends_serving_it(store, no_anywidget):
    view, built = isosplat.view(store), isosplat.view(sphere())
    link = built._shown._link
    assert os.path.exists(link)
    for each in (view, built):
        each.close()
        each.close()  # again, which does nothing
    assert not os.path.exists(link) and os.path.exists(store.path)
    with pytest.raises(urllib.error.HTTPError) as error:
        while True:  # until the server has seen it
            get(view._shown.address)
    assert error.value.code in (401, 404)
    assert described(isosplat.view(store))["name"] != "view-1"


def test_a_process_leaves_no_folder_and_a_child_has_its_own_server(tmp_path):
    script = """
import os, sys, numpy, isosplat
from isosplat import _shown
sys.modules["anywidget"] = None
array = numpy.arange(1000.0).reshape(10, 10, 10)
view = isosplat.view(array)
print(_shown._current.folder, flush=True)
child = os.fork()
if child == 0:
    other = isosplat.view(array)
    print(_shown._current.folder, flush=True)
    sys.exit(other._shown.port == view._shown.port)
assert os.waitpid(child, 0)[1] == 0
assert os.path.isdir(_shown._current.folder) and view._shown.read(0, 4)
"""
    run = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    folders = run.stdout.split()
    assert len(set(folders)) == 2
    assert not any(os.path.exists(folder) for folder in folders), run.stderr


def test_a_killed_process_leaves_no_folder():
    script = """
import os, sys, numpy, isosplat
from isosplat import _shown
sys.modules["anywidget"] = None
isosplat.view(numpy.arange(1000.0).reshape(10, 10, 10))
print(_shown._current.folder, flush=True)
sys.stdin.read()
"""
    process = subprocess.Popen(
        [sys.executable, "-c", script], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    folder = process.stdout.readline().strip()
    assert os.path.isdir(folder)
    process.kill()
    process.communicate()
    while os.path.exists(folder):  # pytest's caller limits the time
        time.sleep(0.05)


# HTML ----------------------------------------------------------------------------------------


def test_html_has_the_traits_and_no_end_of_its_script(store, no_anywidget):
    text = "</script><b>"
    view = isosplat.view(store, np.float32(60.5), link=text, clip={"low": np.zeros(3)}, height='1"')
    shown = view._repr_html_()
    assert shown.startswith('<iframe srcdoc="') and shown.count('"') == shown.replace("&quot;", "").count('"')
    (page,) = re.findall(r'srcdoc="([^"]*)"', shown)
    page = html.unescape(page)
    assert page.count("</script") == 1 and page.endswith("</script>")
    kernel, traits = json.loads(re.search(r"showPage\(\.\.\.(.*)\);", page)[1])
    assert traits["isovalue"] == 60.5 and traits["clip"] == {"low": [0, 0, 0]}
    assert traits["link"] == text and traits["src"] == kernel["address"]
    assert kernel["bytes"] == store.file_bytes and kernel["content"] == store.content_id
    assert 'height: 1&quot;"' in shown


def test_values_of_html_cannot_be_set(store, no_anywidget):
    with pytest.raises(AttributeError, match="isovalue: expected anywidget"):
        isosplat.view(store).isovalue = 3


def test_a_saved_page_has_the_store(store, tmp_path, no_anywidget, monkeypatch):
    isosplat.view(store, 60.5).save(tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text()
    import base64

    parts = re.findall(r"data-store>([^<]*)<", page)
    stored = b"".join(base64.b64decode(part) for part in parts)
    with open(store.path, "rb") as file:
        assert stored == file.read()
    assert 'content="isovalue=60.5"' in page
    from isosplat import _html_view

    monkeypatch.setattr(_html_view, "_MAX_PAGE_BYTES", 1000)
    with pytest.raises(ValueError, match="expected a store of at most .*isosplat publish"):
        isosplat.view(store).save(tmp_path / "large.html")


# The widget ----------------------------------------------------------------------------------


def test_the_widget_sends_code_and_bytes(store, anywidget):
    view = isosplat.view(store, 60, camera={"azimuth": np.float32(90)})
    assert (view.isovalue, view.camera, view.src) == (60, {"azimuth": 90}, view._shown.address)
    assert view._esm.rstrip().endswith("export default { render };")
    assert view.traits(sync=True)["_kernel"] and view._kernel["path"] == view._shown.path
    content, (part,) = answer(view, {"kind": "read", "id": 7, "offset": 0, "bytes": 8})
    assert content == {"kind": "read", "id": 7} and part == b"\x89ISOS\r\n\x1a"
    content, (code,) = answer(view, {"kind": "module", "id": 8})
    assert content == {"kind": "module", "id": 8} and b"kernelFile" in code
    view.close()
    assert view._is_closed


@pytest.mark.parametrize(
    "range_",
    [
        {"offset": -1, "bytes": 8},
        {"offset": 0, "bytes": 0},
        {"offset": 0, "bytes": 1 << 40},
        {"offset": 1 << 62, "bytes": 1},
        {"offset": 0.5, "bytes": 8},
        {"offset": "0", "bytes": True},
        {},
    ],
)
def test_malformed_messages_are_answered_by_an_error(store, anywidget, range_):
    view = isosplat.view(store)
    content, buffers = answer(view, {"kind": "read", "id": 1, **range_})
    assert content["error"].startswith("expected") and buffers is None


def test_other_messages_are_ignored(store, anywidget):
    view = isosplat.view(store)
    for content in (None, [], "read", {"kind": "write"}, {"id": 1}):
        assert answer(view, content) is None


def test_volumes_of_servers(anywidget):
    volume = "https://host.example/v1/volumes/head"
    view = isosplat.view(volume, 60, link="a")
    assert (view.src, view.isovalue, view.link) == (volume, 60, "a")
    assert view._esm == "https://host.example/isosplat-anywidget.js"
    scene = isosplat.view("https://host.example/v1/scenes/run", step=2)
    assert (scene.src, scene.scene, scene.step) == ("", "https://host.example/v1/scenes/run", 2)
    with pytest.raises(ValueError, match="/v1/volumes/NAME"):
        isosplat.view("https://host.example/head.isosplat")


# Arguments -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "call, error, message",
    [
        (lambda s: isosplat.view(s, isovalues=[1]), TypeError, "expected traits .*isovalues"),
        (lambda s: isosplat.view(s, "60"), TypeError, "isovalue: expected a number"),
        (lambda s: isosplat.view(s, float("nan")), ValueError, "isovalue: expected a finite"),
        (lambda s: isosplat.view(s, spacing=(1, 1, 1)), TypeError, "spacing: expected none"),
        (lambda s: isosplat.view(s, proxy="/proxy/80"), ValueError, r"proxy: .*\{port\}"),
        (lambda s: isosplat.view("https://host.example/v1/volumes/a"), ImportError, "anywidget"),
        (lambda s: isosplat.view("https://host.example/a", title="b"), TypeError, "address"),
        (lambda s: isosplat.view("absent.isosplat"), FileNotFoundError, "absent"),
        (lambda s: isosplat.view(np.zeros(3)), ValueError, "three axes"),
        (lambda s: isosplat.view(3), TypeError, "volume: expected a path"),
    ],
)
def test_calls_that_cannot_work(store, no_anywidget, call, error, message):
    with pytest.raises(error, match=message):
        call(store)


def test_a_damaged_store(store, tmp_path, no_anywidget):
    with open(store.path, "rb") as file:
        damaged = bytearray(file.read())
    damaged[60] ^= 255
    (tmp_path / "damaged.isosplat").write_bytes(damaged)
    with pytest.raises(ValueError, match="damaged.isosplat: cannot be shown"):
        isosplat.view(tmp_path / "damaged.isosplat")


def test_the_import_takes_no_libraries_of_notebooks():
    script = "import sys, isosplat; isosplat.view, isosplat.Store; print(*sys.modules)"
    modules = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert not {"traitlets", "anywidget", "IPython"} & set(modules.stdout.split())
