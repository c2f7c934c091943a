"""Ctrl-C, threads, forks, memory, imports."""

import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import isosplat
import numpy as np
import pytest
from conftest import sphere


def run_code(code, *arguments, **options):
    return subprocess.Popen(
        [sys.executable, "-c", code, *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **options,
    )


@pytest.mark.parametrize("kind", ["array", "slices"])
def test_ctrl_c_leaves_nothing(kind, tmp_path):
    # The volume has 64 GiB and more, which take no memory: the build cannot end before.
    (tmp_path / "output").mkdir()
    code = """
import sys, numpy as np, isosplat
if sys.argv[2] == "array":
    a = np.memmap(sys.argv[1] + "/../sparse", np.uint16, "w+", shape=(1 << 15, 1024, 1024))
else:
    noise = np.random.default_rng(1).integers(0, 999, (1, 1024, 1024), np.uint16)
    a = np.broadcast_to(noise, (1 << 20, 1024, 1024))
class Sliced:
    shape, dtype = a.shape, a.dtype
    def __getitem__(self, key): return a[key]
started = lambda fraction, phase: fraction > 0 and print(phase, flush=True)
try:
    isosplat.build(a if sys.argv[2] == "array" else Sliced(), sys.argv[1] + "/a.isosplat",
                   progress=started, value_range=(0, 999), memory=2 << 30)
except KeyboardInterrupt:
    print("interrupted")
"""
    process = run_code(code, tmp_path / "output", kind)
    assert process.stdout.readline() != "", process.stderr.read()
    process.send_signal(signal.SIGINT)
    output, errors = process.communicate(timeout=120)
    assert output.endswith("interrupted\n"), errors
    assert list((tmp_path / "output").iterdir()) == []


def test_builds_release_the_gil(tmp_path):
    counts = []
    stop = threading.Event()

    def count():
        while not stop.is_set():
            counts.append(time.monotonic())
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    begin = time.monotonic()
    isosplat.build(sphere((200, 200, 200)), tmp_path / "a.isosplat")
    end = time.monotonic()
    stop.set()
    thread.join()
    assert sum(begin < at < end for at in counts) > 2


def test_threads_share_a_store_that_one_of_them_closes(tmp_path):
    path = tmp_path / "a.isosplat"
    whole = isosplat.build(sphere((70, 70, 70)), path).points(100).positions
    store = isosplat.open(path)

    def use(number):
        try:
            if number == 40:
                store.close()
                return 0
            return len(store.points(100, threads=2).positions)
        except ValueError as error:
            assert "closed" in str(error)
            return 0

    with ThreadPoolExecutor(8) as pool:
        found = list(pool.map(use, range(60)))
    assert set(found) <= {0, len(whole)} and found[0] == len(whole) and found[40] == 0


def test_threads_build_at_the_same_time(tmp_path):
    def build(number):
        return isosplat.build(sphere(), tmp_path / f"{number % 3}.isosplat").content_id

    with ThreadPoolExecutor(6) as pool:
        ids = list(pool.map(build, range(12)))
    assert len(set(ids)) == 3  # the name is in the metadata
    assert len(list(tmp_path.iterdir())) == 3


def test_forked_processes_use_the_store(store):
    expected = len(store.points(45).positions)
    children = []
    for _ in range(4):
        child = os.fork()
        if child == 0:
            os._exit(0 if len(store.points(45).positions) == expected else 1)
        children.append(child)
    assert [os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) for child in children] == [0] * 4


def test_other_processes_open_the_store_themselves(store):
    other = pickle.loads(pickle.dumps(store))
    assert other.content_id == store.content_id and other is not store


def test_memory_stays_the_same(tmp_path):
    code = """
import resource, sys, numpy as np, isosplat
a = np.random.default_rng(1).integers(0, 99, (40, 40, 40)).astype(np.uint16)
def peak(): return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
def use():
    with isosplat.build(a, sys.argv[1], threads=2) as store:
        store.points(50); store.mesh(50).vertices; store.active_cells(50); store.area(50)
    try: isosplat.build(a.astype(object), sys.argv[1])
    except TypeError: pass
    try: isosplat.build(a, sys.argv[1], progress=lambda *_: 1 / 0)
    except ZeroDivisionError: pass
for _ in range(20): use()
before = peak()
for _ in range(60): use()
print(peak() - before)
"""
    process = run_code(code, tmp_path / "a.isosplat", env={**os.environ, "MALLOC_ARENA_MAX": "2"})
    output, errors = process.communicate(timeout=300)
    assert process.returncode == 0, errors
    # One mesh and its points have 3 MB: 60 of them would have 180 MB.
    assert int(output) < 20_000, output


def test_debugging_allocator(tmp_path):
    code = """
import sys, numpy as np, isosplat
a = np.arange(8000.0).reshape(20, 20, 20)
store = isosplat.build(a[::-1], sys.argv[1], progress=lambda *_: None)
m = store.mesh(4000.5); v = m.vertices; del m, store
print(v.sum() > 0)
"""
    process = run_code(
        code, tmp_path / "a.isosplat", env={**os.environ, "PYTHONMALLOC": "debug"}
    )
    assert process.communicate(timeout=120) == ("True\n", "")


def test_an_import_loads_neither_numpy_nor_libraries():
    code = """
import sys, isosplat
print([name for name in ("numpy", "isosplat._core", "json") if name in sys.modules])
isosplat.Store, isosplat.build, isosplat.__version__
try: isosplat.no_such_name
except AttributeError as error: print(error)
print(set(isosplat.__all__) <= set(dir(isosplat)))
"""
    output, errors = run_code(code).communicate(timeout=60)
    assert output.splitlines() == [
        "[]",
        "module 'isosplat' has no attribute 'no_such_name'",
        "True",
    ], errors
