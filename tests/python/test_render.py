"""Store.render: the pictures of the command render."""

import os
import struct
import zlib

import isosplat
import numpy as np
import pytest
from conftest import PROGRAM, run_program
from isosplat import _core


def drawn(store, tmp_path, *arguments):
    """The pixels of the picture that the program writes."""
    picture = tmp_path / "program.png"
    run_program("render", store.path, "-o", picture, *arguments)
    return _core.read_png(os.fsencode(picture))


def test_pixels_of_a_png_file(tmp_path):
    pixels = np.random.default_rng(1).integers(0, 256, (5, 7, 4), np.uint8)
    rows = b"".join(b"\0" + row.tobytes() for row in pixels)

    def chunk(kind, data):
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))

    header = struct.pack(">IIBBBBB", 7, 5, 8, 6, 0, 0, 0)
    parts = chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
    (tmp_path / "a.png").write_bytes(b"\x89PNG\r\n\x1a\n" + parts)
    assert np.array_equal(_core.read_png(os.fsencode(tmp_path / "a.png")), pixels)


@pytest.fixture(autouse=True)
def program(monkeypatch):
    monkeypatch.setenv("ISOSPLAT_PROGRAM", str(PROGRAM))


def test_pictures_are_those_of_the_program(store, tmp_path):
    picture = store.render(45, size=(96, 64))
    assert picture.shape == (64, 96, 4) and picture.dtype == np.uint8 and picture.flags.writeable
    assert np.array_equal(picture, drawn(store, tmp_path, "-i", "45", "--size", "96x64"))
    assert 0.05 < (picture[..., :3] < 250).any(axis=2).mean() < 0.9  # the surface is in it


def test_every_argument_reaches_the_program(store, tmp_path):
    picture = store.render(
        [30, 60],
        camera=isosplat.Camera(-70, 5, 3, 150, (10, 20, 30), 25, 1.5, "orthographic"),
        size=(64, 80),
        level=0,
        colours=["ff0000", "0000ff80"],
        opacities=[1, 0.5],
        background="transparent",
        options=["--clip-box", "0,0,0,1,1,0.6", "--aliased"],
    )
    expected = drawn(
        store,
        tmp_path,
        *"-i 30,60 --azimuth=-70 --elevation=5 --roll=3 --distance=150 --target=10,20,30".split(),
        *"--field-of-view=25 --zoom=1.5 --projection=orthographic --size=64x80 --level=0".split(),
        *"--colour=ff0000,0000ff80 --opacity=1,0.5 --background=transparent".split(),
        *"--clip-box 0,0,0,1,1,0.6 --aliased".split(),
    )
    assert np.array_equal(picture, expected)
    assert len(np.unique(picture[..., 3])) > 2


@pytest.mark.parametrize(
    "arguments, error",
    [
        ({"isovalue": "45"}, TypeError),
        ({"isovalue": []}, ValueError),
        ({"isovalue": float("nan")}, ValueError),
        ({"size": (0, 5)}, ValueError),
        ({"size": (5, 1 << 20)}, ValueError),
        ({"size": 5}, TypeError),
        ({"size": "64x64"}, TypeError),
        ({"level": 99}, ValueError),
        ({"camera": (1, 2)}, TypeError),
        ({"camera": isosplat.Camera(projection="fisheye")}, ValueError),
        ({"camera": isosplat.Camera(target=(1, 2))}, ValueError),
        ({"camera": isosplat.Camera(field_of_view=500)}, ValueError),
        ({"colours": "ff0000"}, TypeError),
        ({"colours": ["no colour"]}, ValueError),
        ({"opacities": [2]}, ValueError),
        ({"background": "a\0b"}, ValueError),
        ({"options": ["--no-such-option"]}, ValueError),
        ({"options": ["--turntable", "3"]}, ValueError),
    ],
)
def test_arguments_that_cannot_work(arguments, error, store):
    with pytest.raises(error):
        store.render(**{"isovalue": 45, "size": (8, 8), **arguments})


def test_a_closed_store_and_one_that_was_removed(store, tmp_path):
    (tmp_path / "sphere.isosplat").unlink()
    with pytest.raises(RuntimeError, match="sphere.isosplat"):
        store.render(45, size=(8, 8))
    store.close()
    with pytest.raises(ValueError, match="closed"):
        store.render(45, size=(8, 8))


def test_a_program_that_is_missing(store, monkeypatch):
    monkeypatch.setenv("ISOSPLAT_PROGRAM", "/no/such/program")
    with pytest.raises(FileNotFoundError, match="ISOSPLAT_PROGRAM"):
        store.render(45, size=(8, 8))
