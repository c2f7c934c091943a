"""Calls that cannot work: each raises the fitting exception of Python, and the process goes on."""

import os

import isosplat
import numpy as np
import pytest
from conftest import sphere

NAN, INF = float("nan"), float("inf")


class Bad:
    """A volume whose parts lie."""

    shape, dtype = (8, 8, 8), np.dtype("u2")

    def __init__(self, result=None, **parts):
        self.result = result
        self.__dict__.update(parts)

    def __getitem__(self, key):
        if isinstance(self.result, BaseException):
            raise self.result
        return self.result


ARRAYS = [
    (np.zeros(()), ValueError),
    (np.zeros(8), ValueError),
    (np.zeros((8, 8)), ValueError),
    (np.zeros((8, 8, 8, 3)), ValueError),
    (np.zeros((0, 8, 8)), ValueError),
    (np.zeros((8, 0, 8)), ValueError),
    (np.zeros((1, 8, 8)), ValueError),
    (np.zeros((8, 8, 1)), ValueError),
    (np.zeros((8, 8, 8), complex), TypeError),
    (np.zeros((8, 8, 8), np.longdouble), TypeError),
    (np.zeros((8, 8, 8), object), TypeError),
    (np.zeros((8, 8, 8), "S4"), TypeError),
    (np.zeros((8, 8, 8), "U1"), TypeError),
    (np.zeros((8, 8, 8), "M8[s]"), TypeError),
    (np.zeros((8, 8, 8), "m8[s]"), TypeError),
    (np.zeros((8, 8, 8), "V8"), TypeError),
    (np.zeros((8, 8, 8), [("r", "u1"), ("g", "u1")]), TypeError),
    (np.ma.masked_less(np.arange(512.0).reshape(8, 8, 8), 5), TypeError),
    (np.zeros((2, 2, (1 << 20) + 1), np.uint8), ValueError),
    (np.broadcast_to(np.uint8(0), (1 << 21, 2, 2)), ValueError),
    (Bad(shape=(2, 1 << 62, 2)), ValueError),
    (Bad(shape=(1 << 20, 1 << 20, 1 << 20)), MemoryError),
    (Bad(np.zeros((1, 8, 7), "u2")), ValueError),
    (Bad(np.zeros((2, 8, 8), "u2")), ValueError),
    (Bad(np.zeros((0, 8, 8), "u2")), ValueError),
    (Bad(None), ValueError),
    (Bad(np.full((1, 8, 8), None)), TypeError),
    (Bad("text"), ValueError),
    (Bad(KeyError("gone")), KeyError),
    (Bad(MemoryError()), MemoryError),
    (Bad(KeyboardInterrupt()), KeyboardInterrupt),
    (Bad(SystemExit(3)), SystemExit),
    (Bad(shape=(8, 8)), ValueError),
    (Bad(shape=(8, 8, -8)), ValueError),
    (Bad(shape=(8, 8, 1 << 40)), ValueError),
    (Bad(shape=("a", 8, 8)), ValueError),
    (Bad(shape=None), TypeError),
    (Bad(dtype="no type"), TypeError),
    (Bad(dtype=None), Exception),
    (Bad(dims=("z", "y", "x"), coords={"z": ["a"] * 8}), ValueError),
    (Bad(dims=("z", "y", "x"), coords={"z": np.arange(7)}), ValueError),
    (Bad(dims=("z", "y", "x"), coords={"z": -np.arange(8)}), ValueError),
    (None, TypeError),
    (7, (TypeError, OSError)),
    ([[[1, 2], [3, 4]]], TypeError),
    (memoryview(b"12345678"), TypeError),
    ("", ValueError),
    ("a\0b", ValueError),
    ("missing.npy", FileNotFoundError),
    ("missing/", FileNotFoundError),
    ("https://example.org/volume.npy", ValueError),
    (__file__, ValueError),
    ("/dev/null", OSError),
    (os.path.dirname(__file__), ValueError),
]


@pytest.mark.parametrize("index", range(len(ARRAYS)))
def test_arrays(index, tmp_path):
    volume, kind = ARRAYS[index]
    with pytest.raises(kind) as raised:
        isosplat.build(volume, tmp_path / "a.isosplat")
    assert raised.type is not AssertionError
    assert list(tmp_path.iterdir()) == []


OPTIONS = [
    *[
        (name, value, kind)
        for name in ("spacing", "origin")
        for value, kind in [
            ((1, 1), ValueError),
            ((1, 1, 1, 1), ValueError),
            ((1, 1, NAN), ValueError),
            ((1, 1, INF), ValueError),
            (3, TypeError),
            ("123", TypeError),
            (("1", "1", "1"), TypeError),
            ((None, 1, 1), TypeError),
            ((1j, 1, 1), TypeError),
        ]
    ],
    ("spacing", (0, 1, 1), ValueError),
    ("spacing", (-1, 1, 1), ValueError),
    ("spacing", (1e300, 1, 1), ValueError),
    ("direction", np.eye(4), ValueError),
    ("direction", np.zeros((3, 3)), ValueError),
    ("direction", 2 * np.eye(3), ValueError),
    ("direction", np.full((3, 3), NAN), ValueError),
    ("direction", [1] * 9, TypeError),
    ("direction", 5, TypeError),
    ("direction", [["a"] * 3] * 3, TypeError),
    ("units", 5, TypeError),
    ("units", b"HU", TypeError),
    ("title", None, TypeError),
    ("max_error", 0, ValueError),
    ("max_error", -1, ValueError),
    ("max_error", NAN, ValueError),
    ("max_error", "1", TypeError),
    ("value_range", (1,), ValueError),
    ("value_range", (2, 1), ValueError),
    ("value_range", (1, 1), ValueError),
    ("value_range", (NAN, 1), ValueError),
    ("value_range", "ab", TypeError),
    ("progress", 5, TypeError),
    ("progress", lambda: None, TypeError),
    ("threads", -1, ValueError),
    ("threads", 257, ValueError),
    ("threads", 1 << 80, ValueError),
    ("threads", 1.5, TypeError),
    ("threads", None, TypeError),
    ("memory", 0, ValueError),
    ("memory", 1, MemoryError),
    ("memory", "1G", TypeError),
    ("memory", 1 << 70, ValueError),
    ("no_such_option", 1, TypeError),
]


@pytest.mark.parametrize("name, value, kind", OPTIONS, ids=str)
def test_options(name, value, kind, tmp_path):
    with pytest.raises(kind):
        isosplat.build(sphere(), tmp_path / "a.isosplat", **{name: value})
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("option", ["origin", "direction"])
def test_geometry_of_files_is_theirs(option, tmp_path):
    np.save(tmp_path / "a.npy", sphere())
    with pytest.raises(TypeError, match="for arrays"):
        isosplat.build(tmp_path / "a.npy", tmp_path / "a.isosplat", **{option: (1, 2, 3)})


TARGETS = [
    ("", ValueError),
    ("a\0b", ValueError),
    (5, TypeError),
    (None, TypeError),
    ("s3://bucket/a.isosplat", ValueError),
    ("missing/folder/a.isosplat", FileNotFoundError),
    (".", IsADirectoryError),
    ("file/a.isosplat", NotADirectoryError),
    ("/dev/null", ValueError),
    ("n" * 300, OSError),
]


@pytest.mark.parametrize("target, kind", TARGETS, ids=str)
def test_targets(target, kind, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("")
    with pytest.raises(kind):
        isosplat.build(sphere(), target)
    assert [entry.name for entry in tmp_path.iterdir()] == ["file"]


def test_names_with_any_bytes(tmp_path):
    target = os.fsencode(tmp_path) + b"/\xff\xfe \xe2\x82\xac.isosplat"
    store = isosplat.build(sphere(), target)
    assert isosplat.open(os.fsdecode(target)).content_id == store.content_id
    store.mesh(45).save(os.fsencode(tmp_path) + b"/\xff.ply")
    with pytest.raises(FileNotFoundError):
        isosplat.open(target + b"\xff")


CALLS = [
    ("points", (NAN,), {}, ValueError),
    ("points", (INF,), {}, ValueError),
    ("points", (1 << 2000,), {}, TypeError),
    ("points", ("45",), {}, TypeError),
    ("points", (None,), {}, TypeError),
    ("points", ([45],), {}, TypeError),
    ("points", (np.zeros(3),), {}, TypeError),
    ("points", (), {}, TypeError),
    ("points", (45, 2), {}, ValueError),
    ("points", (45, -1), {}, ValueError),
    ("points", (45, 0.5), {}, TypeError),
    ("points", (45, 1 << 40), {}, ValueError),
    ("points", (45,), {"normals": "flat"}, ValueError),
    ("points", (45,), {"normals": None}, ValueError),
    ("points", (45,), {"threads": 1000}, ValueError),
    ("points", (45,), {"threads": "2"}, TypeError),
    ("points", (45,), {"box": (1, 2, 3)}, ValueError),
    ("points", (45,), {"box": ((0, 0, 0), (0, 1, 1))}, ValueError),
    ("points", (45,), {"box": ((0, 0, 0), (1, 1, NAN))}, ValueError),
    ("points", (45,), {"box": ((0, 0), (1, 1, 1))}, ValueError),
    ("points", (45,), {"box": "abcdef"}, TypeError),
    ("points", (45,), {"box": 5}, TypeError),
    ("mesh", (NAN,), {}, ValueError),
    ("mesh", ("a",), {}, TypeError),
    ("mesh", (45, 9), {}, ValueError),
    ("mesh", (45,), {"components": 0}, ValueError),
    ("mesh", (45,), {"components": 1.0}, TypeError),
    ("mesh", (45,), {"components": 1 << 70}, ValueError),
    ("mesh", (45,), {"simplify": 0}, ValueError),
    ("mesh", (45,), {"simplify": INF}, ValueError),
    ("mesh", (45,), {"simplify": "much"}, TypeError),
    ("mesh", (45,), {"box": ((2, 2, 2), (1, 1, 1))}, ValueError),
    ("active_cells", (NAN,), {}, ValueError),
    ("active_cells", (45, 7), {}, ValueError),
    ("active_cells", (45,), {"box": []}, ValueError),
    ("bytes", (NAN,), {}, ValueError),
    ("bytes", (45, None), {}, TypeError),
    ("area", (INF,), {}, ValueError),
    ("area", (45,), {"threads": -1}, ValueError),
    ("volume", (NAN,), {}, ValueError),
    ("volume", (object(),), {}, TypeError),
]


@pytest.mark.parametrize("method, arguments, options, kind", CALLS, ids=str)
def test_calls(method, arguments, options, kind, store):
    with pytest.raises(kind):
        getattr(store, method)(*arguments, **options)
    assert len(store.points(45).positions) > 0


@pytest.mark.parametrize("method", "points mesh active_cells bytes area volume".split())
def test_closed_stores(method, store):
    store.close()
    with pytest.raises(ValueError, match="the store is closed"):
        getattr(store, method)(45)


SAVES = [
    ("a.txt", ValueError),
    ("a", ValueError),
    ("", ValueError),
    (5, TypeError),
    ("missing/a.ply", FileNotFoundError),
    ("a.ply/", (ValueError, OSError)),
    ("folder.ply", (ValueError, OSError)),
]


@pytest.mark.parametrize("target, kind", SAVES, ids=str)
def test_saving(target, kind, store, tmp_path, monkeypatch):
    (tmp_path / "folder.ply").mkdir()
    monkeypatch.chdir(tmp_path)
    with pytest.raises(kind):
        store.mesh(45).save(target)


def test_every_truncation_of_a_store(tmp_path):
    isosplat.build(sphere(), tmp_path / "a.isosplat")
    whole = (tmp_path / "a.isosplat").read_bytes()
    for length in [*range(0, 200), *range(200, len(whole), 997), len(whole) - 1]:
        (tmp_path / "b.isosplat").write_bytes(whole[:length])
        with pytest.raises((ValueError, OSError)):
            isosplat.open(tmp_path / "b.isosplat").points(45)


def test_flipped_bytes_of_a_store(tmp_path):
    isosplat.build(sphere(), tmp_path / "a.isosplat")
    whole = (tmp_path / "a.isosplat").read_bytes()
    right = isosplat.open(tmp_path / "a.isosplat").points(45).positions
    for at in range(0, len(whole), 211):
        damaged = bytearray(whole)
        damaged[at] ^= 0x10
        (tmp_path / "b.isosplat").write_bytes(damaged)
        try:
            found = isosplat.open(tmp_path / "b.isosplat").points(45).positions
        except ValueError:
            continue
        assert np.array_equal(found, right)  # a chunk that this isovalue does not need


OPENS = [
    ("missing.isosplat", FileNotFoundError),
    (".", IsADirectoryError),
    ("", ValueError),
    ("a\0", ValueError),
    (None, TypeError),
    (3.5, TypeError),
    (__file__, ValueError),
    ("/dev/null", (ValueError, OSError)),
    ("http://", ValueError),
    ("s3://", ValueError),
]


@pytest.mark.parametrize("path, kind", OPENS, ids=str)
def test_opening(path, kind):
    with pytest.raises(kind):
        isosplat.open(path)
