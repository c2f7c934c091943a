"""Store.read and Store.lattice: the values that a store has, against brute force."""

import threading

import isosplat
import numpy as np
import pytest
from conftest import sphere


def stored_values(array):
    """The values at corners of cells whose corners differ and are not missing, else NaN."""
    corners = [
        array[z : z - 1 or None, y : y - 1 or None, x : x - 1 or None].astype(float)
        for z in (0, 1)
        for y in (0, 1)
        for x in (0, 1)
    ]
    stored = np.min(corners, axis=0) < np.max(corners, axis=0)  # not where one of them is NaN
    touched = np.zeros(array.shape, bool)
    for z in (0, 1):
        for y in (0, 1):
            for x in (0, 1):
                touched[z : z - 1 or None, y : y - 1 or None, x : x - 1 or None] |= stored
    return np.where(touched, array, np.nan)


def plateaus(shape=(70, 66, 131)):
    """Whole numbers, with regions in which all are equal, over several blocks."""
    return np.clip(sphere(shape), 90, 300)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_values_are_those_of_the_volume_where_cells_are_stored(dtype, tmp_path):
    array = plateaus()
    store = isosplat.build(array, tmp_path / "a.isosplat")
    values = store.read(dtype=dtype)
    assert values.dtype == dtype and values.flags.c_contiguous and values.flags.writeable
    expected = stored_values(array)
    assert 0.1 < np.isnan(expected).mean() < 0.9
    assert np.array_equal(values, expected.astype(dtype), equal_nan=True)
    for threads in (1, 5):
        assert np.array_equal(store.read(dtype=dtype, threads=threads), values, equal_nan=True)


def test_missing_voxels_and_errors_of_values(tmp_path):
    array = np.random.default_rng(3).normal(size=(20, 24, 28))
    array[5:8, 9, 20:] = np.nan
    store = isosplat.build(array, tmp_path / "a.isosplat", max_error=0.01)
    values, expected = store.read(dtype=np.float64), stored_values(array)
    assert np.array_equal(np.isnan(values), np.isnan(expected)) and np.isnan(expected).any()
    assert np.nanmax(np.abs(values - expected)) <= store.max_error * (1 + 1e-9)


@pytest.mark.parametrize("level", [0, 1, 2])
def test_boxes_are_parts_of_the_whole(level, tmp_path):
    store = isosplat.build(
        plateaus(), tmp_path / "a.isosplat", spacing=(0.5, 1, 2), origin=(10, 20, 30)
    )
    whole, lattice = store.read(level), store.lattice(level)
    assert whole.shape == lattice.shape and lattice.first == (0, 0, 0)
    for low, high in [((0, 0, 0), (1, 1, 1)), ((0.3, 0.2, 0.1), (0.7, 0.6, 0.9)), ((-1,) * 3, (2,) * 3)]:
        ends = [np.array(part) * (65, 65, 138) + (10, 20, 30) for part in (low, high)]
        part = store.lattice(level, ends)
        x, y, z = part.first
        depth, height, width = part.shape
        values = store.read(level, ends)
        expected = whole[z : z + depth, y : y + height, x : x + width]
        assert np.array_equal(values, expected, equal_nan=True)
        # The voxels in the box are these, and no others: by the position of each.
        indices = np.indices(whole.shape)[::-1].reshape(3, -1)
        last = np.array(store.shape[::-1])[:, None] - 1
        positions = np.minimum(indices << level, last) * np.array([[0.5], [1], [2]])
        positions += np.array([[10], [20], [30]])
        inside = np.all((ends[0][:, None] <= positions) & (positions <= ends[1][:, None]), axis=0)
        assert inside.sum() == values.size
        assert np.allclose(part.affine @ [0, 0, 0, 1], [*positions[:, inside][:, 0], 1])


def test_a_coarse_level_has_values_of_the_volume_at_its_voxels(tmp_path):
    array = plateaus((65, 65, 65))
    store = isosplat.build(array, tmp_path / "a.isosplat")
    values = store.read(1)
    assert values.shape == (33, 33, 33)
    stored = ~np.isnan(values)
    cells = np.vstack([store.active_cells(value, 1) for value in (91, 150, 200, 299)])
    x, y, z = cells.T
    assert stored[z, y, x].all() and stored[z + 1, y + 1, x + 1].all()
    assert array.min() <= np.nanmin(values) and np.nanmax(values) <= array.max()


def test_a_direction_that_is_not_that_of_the_world(tmp_path):
    array = np.random.default_rng(3).integers(0, 99, (9, 10, 11)).astype(np.uint8)
    turned = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    store = isosplat.build(array, tmp_path / "a.isosplat", direction=turned, origin=(5, 0, 0))
    # x of the volume is y of the world, and y of the volume is -x of the world.
    part = store.lattice(box=((2, 3, 1), (4, 8, 2)))
    assert part.first == (3, 1, 1) and part.shape == (2, 3, 6)
    assert np.allclose(part.affine @ [0, 0, 0, 1], [4, 3, 1, 1])
    assert np.array_equal(store.read(box=((2, 3, 1), (4, 8, 2))), array[1:3, 1:4, 3:9])


def test_threads_read_the_same_store(store):
    expected = store.read()
    found = []
    threads = [threading.Thread(target=lambda: found.append(store.read())) for _ in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 6
    assert all(np.array_equal(each, expected, equal_nan=True) for each in found)


@pytest.mark.parametrize(
    "arguments, error",
    [
        ({"level": 99}, ValueError),
        ({"level": "0"}, TypeError),
        ({"box": ((0, 0, 0), (0, 1, 1))}, ValueError),
        ({"box": ((900, 0, 0), (901, 1, 1))}, ValueError),
        ({"box": ((0.1, 0, 0), (0.9, 9, 9))}, ValueError),
        ({"dtype": np.int16}, ValueError),
        ({"dtype": "no type"}, TypeError),
        ({"dtype": ">f4"}, ValueError),
        ({"threads": -1}, ValueError),
    ],
)
def test_arguments_that_cannot_work(arguments, error, store):
    with pytest.raises(error):
        store.read(**arguments)


def test_a_closed_and_a_damaged_store(store):
    store.close()
    with pytest.raises(ValueError, match="closed"):
        store.read()
    with open(store.path, "r+b") as file:
        file.seek(isosplat.open(store.path).file_bytes // 2)
        file.write(bytes(64))
    with pytest.raises(ValueError, match="checksum"):
        isosplat.open(store.path).read()
