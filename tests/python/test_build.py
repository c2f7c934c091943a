"""isosplat.build: bytes, kinds of arrays, geometry, progress."""

import json

import h5py
import isosplat
import numpy as np
import pytest
import zarr
from conftest import run_program, sphere


def content(path):
    """The chunks of a store, and what else it states but for the volume's name and source. Pages and
    header depend on the length of these."""
    info = json.loads(run_program("info", "--json", "--chunks", str(path)))
    for key in "name", "title", "source", "notes":
        info["metadata"].pop(key, None)
    info.pop("contentId")
    info.pop("fileBytes")
    data = path.read_bytes()
    begin = int.from_bytes(data[12:16], "little")  # FORMAT.md: header_bytes
    size = sum(level["bytes"] for level in info["chunkReport"]["levels"])
    assert size > 0
    return data[begin : begin + size], info


def same_as_program(array, tmp_path):
    """Builds the array by the package, and the same .npy file by the program."""
    ours, theirs = tmp_path / "ours.isosplat", tmp_path / "theirs.isosplat"
    isosplat.build(array, ours)
    np.save(tmp_path / "array.npy", array)
    run_program("build", str(tmp_path / "array.npy"), "-o", str(theirs), "-q", "--no-thumbnail")
    assert content(ours) == content(theirs)


@pytest.mark.parametrize(
    "dtype",
    "u1 i1 <u2 >u2 <i2 >i2 <u4 >u4 <i4 <u8 >i8 <f2 >f2 <f4 >f4 <f8 >f8 ?".split(),
)
@pytest.mark.parametrize("order", "CF")
def test_bytes_are_those_of_the_program(dtype, order, tmp_path):
    array = sphere() > 60 if dtype == "?" else sphere().astype(dtype) % 100
    same_as_program(np.array(array, dtype=dtype, order=order), tmp_path)


def test_missing_values_are_found_as_by_the_program(tmp_path):
    array = sphere().astype(np.float32)
    array[3:6, 4:8, 2:9] = np.nan
    array[0, :, :9] = -9999
    same_as_program(array, tmp_path)
    assert isosplat.open(tmp_path / "ours.isosplat").missing_voxels > 84


@pytest.mark.parametrize(
    "view",
    [
        lambda a: a[::2, ::3, ::2],
        lambda a: a[::-1],
        lambda a: a[:, ::-1, ::-1],
        lambda a: a.transpose(1, 0, 2),
        lambda a: a.transpose(2, 1, 0)[1:],
        lambda a: np.broadcast_to(a[:, :, :1], a.shape),
        lambda a: np.lib.stride_tricks.as_strided(a, (8, 8, 8), (2, 2, 2)),
    ],
    ids="steps backwards mirrored axes fortran broadcast overlapping".split(),
)
def test_strides_do_not_matter(view, tmp_path):
    same_as_program(view(sphere()), tmp_path)


def test_a_volume_of_several_blocks_is_the_same(tmp_path):
    same_as_program(sphere((70, 131, 90)), tmp_path)


@pytest.mark.parametrize("order", "CF")
def test_memory_maps_are_read_in_place(order, tmp_path):
    array = np.asarray(sphere(), order=order)
    np.save(tmp_path / "mapped.npy", array)
    mapped = np.load(tmp_path / "mapped.npy", mmap_mode="r")
    isosplat.build(mapped, tmp_path / "mapped.isosplat")
    isosplat.build(array, tmp_path / "array.isosplat", title="mapped")
    assert content(tmp_path / "mapped.isosplat") == content(tmp_path / "array.isosplat")


class Sliced:
    """Slices to NumPy, as dask and others do, and counts what was read."""

    def __init__(self, array, chunks=None):
        self.array, self.shape, self.dtype = array, array.shape, array.dtype
        self.calls, self.largest = 0, 0
        if chunks:
            self.chunks = chunks

    def __getitem__(self, key):
        assert isinstance(key, slice)
        self.calls += 1
        self.largest = max(self.largest, key.stop - key.start)
        return self.array[key]


@pytest.mark.parametrize("kind", "slices chunks dask h5py zarr".split())
def test_other_arrays_are_read_slice_by_slice(kind, tmp_path):
    array = sphere((40, 24, 28))
    if kind == "h5py":
        with h5py.File(tmp_path / "array.h5", "w") as file:
            file.create_dataset("a", data=array, chunks=(16, 16, 16), compression="gzip")
        source = h5py.File(tmp_path / "array.h5", "r")["a"]
    elif kind == "zarr":
        source = zarr.array(array, chunks=(16, 16, 16))
    else:
        chunks = {"slices": None, "chunks": (8, 8, 8), "dask": ((8, 8, 24), (24,), (28,))}
        source = Sliced(array, chunks[kind])
    isosplat.build(source, tmp_path / "sliced.isosplat")
    isosplat.build(array, tmp_path / "array.isosplat")
    assert content(tmp_path / "sliced.isosplat") == content(tmp_path / "array.isosplat")
    if isinstance(source, Sliced):
        assert source.largest == (1 if kind == "slices" else 8)


class Labelled(Sliced):
    """As xarray.DataArray: names and coordinates of axes."""

    dims = ("z", "y", "x")

    def __init__(self, array, coords, **attrs):
        super().__init__(array)
        self.coords, self.attrs = coords, attrs


def test_coordinates_of_labelled_arrays_are_the_geometry(tmp_path):
    array = sphere()
    coords = {"z": 10 + 3.0 * np.arange(20), "x": -5 + 0.5 * np.arange(28)}
    store = isosplat.build(Labelled(array, coords, units="K"), tmp_path / "a.isosplat")
    assert store.spacing == pytest.approx((0.5, 1, 3))
    assert store.origin == pytest.approx((-5, 0, 10))
    assert (store.units, store.notes) == ("K", [])
    coords["z"] = np.arange(20.0) ** 2
    with pytest.raises(ValueError, match="ascend evenly"):
        isosplat.build(Labelled(array, coords), tmp_path / "b.isosplat")


def test_a_path_gives_the_same_file_as_the_program(tmp_path):
    np.save(tmp_path / "volume.npy", sphere())
    isosplat.build(
        tmp_path / "volume.npy", tmp_path / "a.isosplat", spacing=(1, 2, 3), units="HU"
    )
    run_program(
        *f"build {tmp_path}/volume.npy -o {tmp_path}/b.isosplat --spacing 1,2,3".split(),
        *"--units HU -q --no-thumbnail".split(),
    )
    assert (tmp_path / "a.isosplat").read_bytes() == (tmp_path / "b.isosplat").read_bytes()


def test_options_are_stored(tmp_path):
    turned = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    store = isosplat.build(
        sphere(dtype=np.float64) + 0.123,
        tmp_path / "a.isosplat",
        spacing=(0.5, 1, 2),
        origin=(10, 20, 30),
        direction=turned,
        units="K",
        title="Sphere",
        max_error=0.5,
    )
    assert (store.spacing, store.origin) == ((0.5, 1, 2), (10, 20, 30))
    assert np.array_equal(store.direction, turned)
    assert store.affine @ (1, 1, 1, 1) == pytest.approx((9, 20.5, 32, 1))
    assert (store.units, store.title, store.dtype) == ("K", "Sphere", np.float64)
    assert 0 < store.max_error <= 0.5
    assert store.shape == (20, 24, 28)


def test_fortran_order_keeps_positions(tmp_path):
    array = sphere((20, 24, 28)).astype(np.float32) + np.arange(28) / 3
    a = isosplat.build(array, tmp_path / "c.isosplat", spacing=(1, 2, 3), origin=(5, 6, 7))
    b = isosplat.build(
        np.asfortranarray(array), tmp_path / "f.isosplat", spacing=(1, 2, 3), origin=(5, 6, 7)
    )
    one, other = (np.sort(s.points(30).positions.round(4), axis=0) for s in (a, b))
    assert np.allclose(one, other, atol=1e-3)


def test_progress_ends_at_one(tmp_path):
    calls = []
    isosplat.build(
        sphere((130, 130, 130)),
        tmp_path / "a.isosplat",
        progress=lambda fraction, phase: calls.append((fraction, phase)),
    )
    fractions = [fraction for fraction, _ in calls]
    assert fractions == sorted(fractions) and fractions[-1] == 1
    assert all(isinstance(phase, str) for _, phase in calls)


def test_a_store_is_replaced_and_another_file_is_not(tmp_path):
    target = tmp_path / "a.isosplat"
    isosplat.build(sphere(), target)
    assert isosplat.build(sphere((30, 30, 30)), target).shape == (30, 30, 30)
    target.write_text("precious")
    with pytest.raises(FileExistsError, match="overwrite=True"):
        isosplat.build(sphere(), target)
    assert target.read_text() == "precious"
    isosplat.build(sphere(), target, overwrite=True)
    assert [entry.name for entry in tmp_path.iterdir()] == ["a.isosplat"]


def test_the_volume_is_never_overwritten(tmp_path):
    source = tmp_path / "volume.npy"
    np.save(source, sphere())
    with pytest.raises(ValueError, match="not an input"):
        isosplat.build(source, source, overwrite=True)
    assert np.array_equal(np.load(source), sphere())


@pytest.mark.parametrize("where", ["progress", "slice"])
def test_an_exception_of_a_callback_leaves_nothing(where, tmp_path):
    class Mine(Exception):
        pass

    def refuse(*_):
        raise Mine("mine")

    class Refusing(Sliced):
        def __getitem__(self, key):
            if self.calls > 50:
                refuse()
            return super().__getitem__(key)

    array = sphere((130, 130, 130))
    with pytest.raises(Mine, match="mine"):
        if where == "progress":
            isosplat.build(array, tmp_path / "a.isosplat", progress=refuse)
        else:
            isosplat.build(Refusing(array), tmp_path / "a.isosplat")
    assert list(tmp_path.iterdir()) == []


def test_large_slices_are_built_in_bands_of_rows(tmp_path):
    wide = np.zeros((67, 1500, 1500), np.uint8)
    wide[20:40, 100:1400, 700:800] = 200
    np.save(tmp_path / "wide.npy", wide)
    isosplat.build(wide, tmp_path / "whole.isosplat").close()
    isosplat.build(tmp_path / "wide.npy", tmp_path / "file.isosplat").close()
    # Less than the slices of one layer of blocks need.
    for volume, name in ((wide, "whole"), (tmp_path / "wide.npy", "file")):
        bands = tmp_path / "bands.isosplat"
        isosplat.build(volume, bands, memory=140 << 20, threads=1, overwrite=True).close()
        assert content(bands) == content(tmp_path / f"{name}.isosplat")
