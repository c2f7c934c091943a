"""Scenes: of labels, channels and time steps."""

import os
import pickle
import threading

import isosplat
import numpy as np
import pytest
from conftest import PROGRAM, ROOT, run_program, sphere


@pytest.fixture(autouse=True)
def program(monkeypatch):
    monkeypatch.setenv("ISOSPLAT_PROGRAM", str(PROGRAM))


def organs(dtype=np.uint8):
    """Two boxes that touch, of the values 1 and 3."""
    labels = np.zeros((12, 14, 16), dtype)
    labels[3:9, 4:10, 3:8] = 1
    labels[3:9, 4:10, 8:12] = 3
    return labels


def left_in(folder):
    return sorted(each.name for each in folder.iterdir())


def points_of(store, isovalue):
    return sorted(map(tuple, store.mesh(isovalue).vertices.round(3).tolist()))


# Labels --------------------------------------------------------------------------------------


def test_labels_have_names_colours_and_volumes(tmp_path):
    seen = []
    scene = isosplat.build_labels(
        organs(),
        tmp_path / "organs.isobundle",
        labels={1: ("kidney, left", "#c33"), 3: ("tumour", (0, 1, 0, 0.5)), 7: "absent"},
        spacing=(1, 2, 3),
        origin=(10, 20, 30),
        progress=lambda fraction, phase: seen.append(fraction),
    )
    assert [layer.name for layer in scene.layers] == ["kidney, left", "tumour"]
    assert [layer.label for layer in scene.layers] == [(1, 180, 1080), (3, 144, 864)]
    colours = [(layer.surfaces[0].colour, layer.surfaces[0].opacity) for layer in scene.layers]
    assert colours[0] == ("#cc3333", 1) and colours[1][0] == "#00ff00"
    assert colours[1][1] == pytest.approx(0.5, abs=0.01)
    kidney = scene.layer("kidney, left")
    store = kidney.store()
    mesh = store.mesh(kidney.surfaces[0].isovalue)
    # The box of the label: it ends half a voxel beyond its voxels.
    assert mesh.vertices.min(axis=0) == pytest.approx([12.5, 27, 37.5], abs=1.5)
    assert mesh.vertices.max(axis=0) == pytest.approx([17.5, 39, 55.5], abs=1.5)
    assert seen[-1] == 1 and seen == sorted(seen)
    assert left_in(tmp_path) == ["organs.isobundle", "organs.isobundle.webp"] or left_in(tmp_path) == [
        "organs.isobundle"
    ]


@pytest.mark.parametrize("smooth", [True, False])
@pytest.mark.parametrize("order", ["C", "F"])
def test_labels_are_those_of_the_program(tmp_path, smooth, order):
    array = np.asarray(organs(np.int32), order=order)
    np.save(tmp_path / "organs.npy", array)
    kind = ["--labels"] if smooth else ["--labels", "raw"]
    run_program(
        "build", str(tmp_path / "organs.npy"), "-o", f"{tmp_path}/expected.isobundle", *kind
    )
    expected = isosplat.open_scene(tmp_path / "expected.isobundle")
    found = isosplat.build_labels(array, tmp_path / "found.isobundle", smooth=smooth)
    from_file = isosplat.build_labels(
        tmp_path / "organs.npy", tmp_path / "file.isobundle", smooth=smooth
    )
    for scene in (found, from_file):
        for one, other in zip(scene.layers, expected.layers, strict=True):
            assert (one.name, one.surfaces, one.label) == (other.name, other.surfaces, other.label)
            isovalue = one.surfaces[0].isovalue
            # In Fortran's order, the program reads z as the first axis, so it meets the cells in another order.
            assert points_of(one.store(), isovalue) == points_of(other.store(), isovalue)


def test_labels_in_a_folder(tmp_path):
    scene = isosplat.build_labels(organs(bool), f"{tmp_path}/organs/")
    assert scene.layers[0].name == "label 1"
    assert (tmp_path / "organs/scene.json").is_file()
    again = isosplat.open_scene(tmp_path / "organs")
    assert again.layers[0].store().content_id == scene.layers[0].store().content_id
    assert isosplat.open(again.layers[0].store().path).shape == again.layers[0].store().shape


# Channels and time steps ---------------------------------------------------------------------


def test_channels_are_layers_with_names_and_colours(tmp_path):
    array = np.stack([sphere(), 300 - sphere(), sphere() // 2])
    scene = isosplat.build_scene(
        array,
        tmp_path / "cells.isobundle",
        channels=["DNA", ("actin", "#102030"), "membrane"],
        spacing=(1, 2, 3),
        units="counts",
        title="cells",
    )
    assert (scene.name, scene.times) == ("cells", ())
    assert [layer.name for layer in scene.layers] == ["DNA", "actin", "membrane"]
    assert [layer.surfaces[0].colour for layer in scene.layers] == ["#e6d9bd", "#102030", "#57b5e8"]
    for layer, values in zip(scene.layers, array, strict=True):
        store = layer.store()
        assert (store.units, store.spacing, store.dtype) == ("counts", (1, 2, 3), values.dtype)
        alone = isosplat.build(values, tmp_path / "alone.isosplat", spacing=(1, 2, 3))
        assert np.array_equal(store.read(), alone.read(), equal_nan=True)
        assert layer.surfaces[0].isovalue == store.suggested_isovalues[0]


def test_time_steps_of_a_generator_that_uses_one_array(tmp_path):
    array = np.empty((12, 14, 16), np.float32)
    expected = [np.sqrt(sphere(array.shape) * (1.0 + step)).astype(np.float32) for step in range(3)]

    def steps():
        for values in expected:
            array[:] = values
            yield array

    scene = isosplat.build_scene(
        steps(), tmp_path / "run.isobundle", times=[0, 0.5, 2], time_unit="s"
    )
    assert (scene.times, scene.time_unit) == ((0, 0.5, 2), "s")
    (layer,) = scene.layers
    stores = [layer.store(step) for step in range(3)]
    errors = {store.max_error for store in stores}
    assert len(errors) == 1 and errors.pop() > 0  # they are quantized together
    for step, store in enumerate(stores):
        values = store.read()
        known = np.isfinite(values)
        assert np.abs(values[known] - expected[step][known]).max() <= store.max_error * 1.01
    assert left_in(tmp_path) == ["run.isobundle"]


@pytest.mark.parametrize("dtype", [np.uint8, np.int16, np.float32, np.int32])
def test_time_steps_are_those_of_the_program(tmp_path, dtype):
    steps = [(sphere((12, 14, 16)) * (1 + step)).astype(dtype) for step in range(3)]
    files = []
    for step, array in enumerate(steps):
        files.append(str(tmp_path / f"{step}.npy"))
        np.save(files[-1], array)
    run_program("build", *files, "-o", f"{tmp_path}/expected.isobundle")
    expected = isosplat.open_scene(tmp_path / "expected.isobundle")
    of_arrays = isosplat.build_scene(steps, tmp_path / "arrays.isobundle", times=[0, 1, 2])
    of_files = isosplat.build_scene(files, tmp_path / "files.isobundle", times=[0, 1, 2])
    for scene in (of_arrays, of_files):
        assert scene.times == expected.times
        (one,), (other,) = scene.layers, expected.layers
        for step in range(3):
            a, b = one.store(step), other.store(step)
            assert np.array_equal(a.read(), b.read(), equal_nan=True)
            assert a.max_error == b.max_error
    assert [s.isovalue for s in of_files.layers[0].surfaces] == [
        s.isovalue for s in expected.layers[0].surfaces
    ]


def test_steps_with_channels_of_an_array_that_is_not_in_memory(tmp_path):
    h5py = pytest.importorskip("h5py")
    array = np.stack([np.stack([sphere((6, 7, 8)) + t, sphere((6, 7, 8)) * 2]) for t in range(3)])
    with h5py.File(tmp_path / "run.h5", "w") as file:
        file.create_dataset("run", data=array, chunks=(1, 1, 3, 7, 8))
        scene = isosplat.build_scene(
            file["run"], f"{tmp_path}/run/", channels=["a", "b"], times=range(3)
        )
    for channel, layer in enumerate(scene.layers):
        for step in range(3):
            values = layer.store(step).read()
            known = np.isfinite(values)
            assert known.any() and np.array_equal(values[known], array[step, channel][known])
    assert scene.layer(1).name == "b"


def test_a_store_of_a_bundle(tmp_path):
    array = np.stack([sphere(), sphere() // 2])
    scene = isosplat.build_scene(array, tmp_path / "a.isobundle", channels=["a", "b"])
    store = scene.layers[1].store()
    again = pickle.loads(pickle.dumps(store))
    assert again.content_id == store.content_id and again.path == store.path
    for other in (isosplat.open, lambda path: isosplat.open(path).render(50)):
        with pytest.raises(ValueError, match="open_scene|unbundle"):
            other(scene.path if other is isosplat.open else store.path)
    with isosplat.serve([scene]) as server:
        assert server.is_running


# Opening -------------------------------------------------------------------------------------


def test_scenes_are_shared_by_processes_and_threads(tmp_path):
    scene = isosplat.build_scene(
        np.stack([sphere(), sphere() // 2]), tmp_path / "a.isobundle", channels=["a", "b"]
    )
    again = pickle.loads(pickle.dumps(scene))
    assert [layer.name for layer in again.layers] == ["a", "b"]
    found = []
    threads = [
        threading.Thread(target=lambda: found.append(len(scene.layers[0].store().active_cells(50))))
        for _ in range(4)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(set(found)) == 1 and len(found) == 4
    store = scene.layers[0].store()
    store.close()
    with pytest.raises(ValueError, match="closed"):
        store.active_cells(50)


@pytest.mark.parametrize(
    "call, error, message",
    [
        (lambda p: isosplat.open_scene(p / "absent"), FileNotFoundError, "absent"),
        (lambda p: isosplat.open_scene(p), FileNotFoundError, "scene.json"),
        (lambda p: isosplat.open_scene("https://host/a.isobundle"), ValueError, "address"),
        (lambda p: isosplat.open_scene(ROOT / "LICENSE"), ValueError, "expected"),
        (lambda p: isosplat.open_scene(3), TypeError, "path"),
        (lambda p: isosplat.build_labels(organs(), p / "a.isosplat"), ValueError, "NAME.isobundle"),
        (lambda p: isosplat.build_labels(organs(), 3), TypeError, "path"),
        (lambda p: isosplat.build_labels(organs(), p / "no/a.isobundle"), FileNotFoundError, "no"),
        (lambda p: isosplat.build_labels(organs(float), p / "a.isobundle"), TypeError, "whole"),
        (lambda p: isosplat.build_labels(organs() * 0, p / "a.isobundle"), ValueError, "labels"),
        (lambda p: isosplat.build_labels(np.zeros(3, int), p / "a.isobundle"), ValueError, "axes"),
        (lambda p: isosplat.build_labels("absent.nii", p / "a.isobundle"), FileNotFoundError, "ab"),
        (lambda p: labelled(p, ["a"]), TypeError, "dict"),
        (lambda p: labelled(p, {"1": "a"}), TypeError, "whole number"),
        (lambda p: labelled(p, {1: 3}), TypeError, "name"),
        (lambda p: labelled(p, {1: ("a", "red")}), ValueError, "colour"),
        (lambda p: labelled(p, {1: ("a", "#12345")}), ValueError, "colour"),
        (lambda p: labelled(p, {1: ("a", (0, 300, 0))}), ValueError, "colour"),
        (lambda p: scene_of(p, sphere()), TypeError, "channels= or times="),
        (lambda p: scene_of(p, sphere(), channels=["a"]), ValueError, "array of volumes"),
        (lambda p: scene_of(p, [sphere()], channels=["a", "b"]), ValueError, "found 1"),
        (lambda p: scene_of(p, [sphere()] * 3, channels=["a", "b"]), ValueError, "found 3"),
        (lambda p: scene_of(p, np.zeros((3, 4, 4, 4)), times=[1, 2]), ValueError, "found 3"),
        (lambda p: scene_of(p, [sphere()] * 2, times=[1, 1]), ValueError, "ascending"),
        (lambda p: scene_of(p, [sphere()] * 2, times=[1, float("nan")]), ValueError, "finite"),
        (lambda p: scene_of(p, [], times=[]), ValueError, "found none"),
        (lambda p: scene_of(p, 3, times=[1]), TypeError, ""),
        (lambda p: scene_of(p, "a.npy", times=[1]), TypeError, "path"),
        (lambda p: scene_of(p, ["a.npy", "b.npy"], times=[0, 1]), FileNotFoundError, "a.npy"),
        (lambda p: scene_of(p, [sphere(), "a.npy"], times=[0, 1]), TypeError, "a.npy"),
        (lambda p: scene_of(p, [sphere()], channels=[3]), TypeError, "channels"),
        (lambda p: scene_of(p, [sphere()], channels=["a"], overwrites=1), TypeError, "overwrites"),
        (lambda p: scene_of(p, [sphere()], channels=["a"], progress=1), TypeError, "function"),
        (lambda p: scene_of(p, [sphere()], channels=[("a", "red")]), ValueError, "colour"),
    ],
)
def test_calls_that_cannot_work_leave_nothing(tmp_path, call, error, message):
    with pytest.raises(error, match=message):
        call(tmp_path)
    assert left_in(tmp_path) == []


def labelled(folder, labels):
    return isosplat.build_labels(organs(), folder / "a.isobundle", labels=labels)


def scene_of(folder, volumes, **options):
    return isosplat.build_scene(volumes, folder / "a.isobundle", **options)


def test_an_exception_of_progress_or_of_the_iterator_leaves_nothing(tmp_path):
    def steps():
        yield sphere()
        raise KeyError("the source failed")

    def stop(fraction, phase):
        raise InterruptedError("enough")

    with pytest.raises(KeyError, match="the source failed"):
        scene_of(tmp_path, steps(), times=[0, 1])
    with pytest.raises(InterruptedError, match="enough"):
        scene_of(tmp_path, [sphere()], channels=["a"], progress=stop)
    with pytest.raises(InterruptedError, match="enough"):
        isosplat.build_labels(organs(), tmp_path / "a.isobundle", progress=stop)
    assert left_in(tmp_path) == []


def test_other_files_and_folders_are_not_replaced(tmp_path):
    other = tmp_path / "a.isobundle"
    other.write_text("mine")
    with pytest.raises(FileExistsError, match="overwrite=True"):
        labelled(tmp_path, None)
    assert other.read_text() == "mine"
    scene = isosplat.build_labels(organs(), other, overwrite=True)
    assert len(isosplat.build_labels(organs() // 3, other).layers) == 1  # an older bundle is replaced
    assert len(scene.layers) == 2
    (tmp_path / "full").mkdir()
    (tmp_path / "full/mine").touch()
    for path in (f"{tmp_path}/full/", tmp_path / "full.isobundle"):
        os.path.lexists(path) or os.mkdir(path)
        with pytest.raises(FileExistsError):
            isosplat.build_labels(organs(), path, overwrite=True)
    assert left_in(tmp_path / "full") == ["mine"]
