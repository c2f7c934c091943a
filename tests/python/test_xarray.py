"""The accessor of xarray."""

import sys

import numpy as np
import pytest
from conftest import PROGRAM, sphere

xarray = pytest.importorskip("xarray")
pytest.importorskip("isosplat.xarray")


@pytest.fixture(autouse=True)
def program(monkeypatch):
    monkeypatch.setenv("ISOSPLAT_PROGRAM", str(PROGRAM))
    monkeypatch.setitem(sys.modules, "anywidget", None)


def array(*first):
    values = sphere()
    for _, coordinate in first:
        values = np.stack([values + index for index in range(len(coordinate))])
    axes = {axis: np.arange(size) * 2.0 for axis, size in zip("zyx", sphere().shape, strict=True)}
    return xarray.DataArray(
        values,
        dims=[*(name for name, _ in first), *axes],
        coords={**dict(first), **axes},
        attrs={"units": "HU"},
        name="head",
    )


def test_build_and_view(tmp_path):
    store = array().isosplat.build(tmp_path / "a.isosplat")
    assert (store.title, store.units, store.spacing) == ("head", "HU", (2, 2, 2))
    view = array().isosplat.view(60, title="other")
    assert view._shown.file_bytes > 1000 and view._traits["isovalue"] == 60


def test_times_and_channels(tmp_path):
    run = array(("t", [0.0, 0.5, 2.0]))
    run.coords["t"].attrs["units"] = "s"
    scene = run.isosplat.build_scene(tmp_path / "run.isobundle")
    assert (scene.times, scene.time_unit, scene.name) == ((0, 0.5, 2), "s", "head")
    assert scene.layers[0].store(1).spacing == (2, 2, 2)
    cells = array(("c", ["DNA", "actin"])).isosplat.build_scene(tmp_path / "cells.isobundle")
    assert [layer.name for layer in cells.layers] == ["DNA", "actin"]
    indices = run.drop_vars("t").isosplat.build_scene(tmp_path / "indices.isobundle")
    assert indices.times == (0, 1, 2)


def test_other_arrays(tmp_path):
    with pytest.raises(ValueError, match="four axes"):
        array().isosplat.build_scene(tmp_path / "a.isobundle")
    dated = array(("t", np.array(["2026-01-01", "2026-01-02"], "datetime64[ns]")))
    with pytest.raises(ValueError, match="numbers or texts"):
        dated.isosplat.build_scene(tmp_path / "a.isobundle")
    with pytest.raises(ValueError, match="three axes"):
        dated.isosplat.build(tmp_path / "a.isosplat")
