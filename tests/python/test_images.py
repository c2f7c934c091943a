"""Images of other libraries: their values and their geometry.

nibabel, SimpleITK, ITK, PyVista and xarray are not among the test packages: where one is not installed, a class
with its documented members stands in, and the test with the library itself is skipped.
"""

import sys
import types

import isosplat
import numpy as np
import pytest
from conftest import sphere

AFFINE_RAS = np.array(
    [[0.0, -2.0, 0.0, 90.0], [1.5, 0.0, 0.0, -126.0], [0.0, 0.0, 3.0, -72.0], [0, 0, 0, 1.0]]
)
AFFINE_LPS = np.diag([-1.0, -1, 1, 1]) @ AFFINE_RAS


def built(image, tmp_path, **options):
    return isosplat.build(image, tmp_path / "a.isosplat", **options)


def same_values(store, array):
    values = store.read(dtype=np.float64)
    known = np.isfinite(values)
    return known.sum() > 100 and np.abs(values[known] - array[known]).max() <= store.max_error


# nibabel -------------------------------------------------------------------------------------


class NiftiHeader:
    def __init__(self, unit):
        self._unit = unit

    def get_xyzt_units(self):
        return self._unit, "sec"


class Nifti1Image:
    """The members of nibabel.Nifti1Image: its arrays are indexed [x, y, z]."""

    def __init__(self, dataobj, affine, unit="mm"):
        self.dataobj, self.affine, self.shape = dataobj, affine, dataobj.shape
        self.header = NiftiHeader(unit)


class ArrayProxy:
    """As nibabel.arrayproxy.ArrayProxy: the values are scaled, its dtype is that of the file."""

    def __init__(self, stored, slope):
        self._stored, self._slope = stored, slope
        self.shape, self.dtype = stored.shape, stored.dtype
        self.read = 0

    def __getitem__(self, index):
        part = self._stored[index] * self._slope
        self.read = max(self.read, part.size)
        return part


def test_nibabel_is_turned_from_ras_to_lps(tmp_path):
    array = sphere()
    store = built(Nifti1Image(array.T, AFFINE_RAS), tmp_path)
    assert store.shape == array.shape and store.dtype == array.dtype
    assert np.allclose(store.affine, AFFINE_LPS)
    assert store.notes == [] and same_values(store, array)


@pytest.mark.parametrize("unit, scale", [("meter", 1000), ("micron", 0.001), ("unknown", 1)])
def test_units_of_nibabel(tmp_path, unit, scale):
    store = built(Nifti1Image(sphere().T, AFFINE_RAS, unit), tmp_path)
    assert np.allclose(store.affine[:3], AFFINE_LPS[:3] * scale)
    assert any("millimetres are assumed" in note for note in store.notes) == (unit == "unknown")


def test_scaled_images_of_nibabel_are_read_slice_by_slice(tmp_path):
    array = sphere().astype(np.int16)
    proxy = ArrayProxy(array.T[..., np.newaxis], 0.5)  # a fourth axis of one volume
    store = built(Nifti1Image(proxy, AFFINE_RAS), tmp_path)
    assert store.dtype == np.float64 and same_values(store, array * 0.5)
    assert proxy.read == array[0].size


@pytest.mark.parametrize(
    "image, message",
    [
        (Nifti1Image(np.zeros((4, 4, 4, 2)), AFFINE_RAS), "three axes.*slicer"),
        (Nifti1Image(np.zeros((4, 4)), AFFINE_RAS), "three axes"),
        (Nifti1Image(np.zeros((4, 4, 4)), None), "affine"),
        (Nifti1Image(np.zeros((4, 4, 4)), np.zeros((4, 4))), "full rank"),
        (Nifti1Image(np.zeros((4, 4, 4)), AFFINE_RAS * np.nan), "full rank"),
    ],
)
def test_images_of_nibabel_that_a_store_cannot_hold(tmp_path, image, message):
    with pytest.raises(ValueError, match=message):
        built(image, tmp_path)


def test_nibabel_itself(tmp_path):
    nibabel = pytest.importorskip("nibabel")
    image = nibabel.Nifti1Image(sphere().T, AFFINE_RAS)
    image.header.set_xyzt_units("mm")
    nibabel.save(image, tmp_path / "a.nii.gz")
    expected = isosplat.build(tmp_path / "a.nii.gz", tmp_path / "file.isosplat")
    for each in (image, nibabel.load(tmp_path / "a.nii.gz")):
        store = built(each, tmp_path)
        assert np.allclose(store.affine, expected.affine)
        assert np.array_equal(store.read(), expected.read(), equal_nan=True)


# SimpleITK and ITK ---------------------------------------------------------------------------

DIRECTION = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])


class ItkImage:
    """The members of SimpleITK.Image and itk.Image that both have."""

    def __init__(self, array, components=1):
        self.array, self._components = array, components

    def GetSpacing(self):
        return (1.5, 2.0, 3.0)[: self.array.ndim]

    def GetOrigin(self):
        return (10.0, 20.0, 30.0)[: self.array.ndim]

    def GetDirection(self):
        return self.matrix

    def GetNumberOfComponentsPerPixel(self):
        return self._components


@pytest.fixture(params=["SimpleITK", "itk"])
def itk_image(request, monkeypatch):
    if request.param == "SimpleITK":
        module = types.SimpleNamespace(GetArrayViewFromImage=lambda image: image.array)
        kind = type("Image", (ItkImage,), {"__module__": "SimpleITK.SimpleITK"})
        kind.matrix = tuple(DIRECTION.ravel())
    else:
        module = types.SimpleNamespace(
            array_view_from_image=lambda image: image.array,
            array_from_matrix=lambda matrix: matrix["values"],
        )
        # Like an array, it has a shape and a type.
        more = {"shape": property(lambda self: self.array.shape), "dtype": np.uint16}
        kind = type("itkImageUS3", (ItkImage,), {"__module__": "itk.itkImagePython", **more})
        kind.matrix = {"values": DIRECTION}
    monkeypatch.setitem(sys.modules, request.param, module)
    return kind


def test_itk(tmp_path, itk_image):
    array = sphere()
    store = built(itk_image(array), tmp_path)
    assert (store.spacing, store.origin) == ((1.5, 2, 3), (10, 20, 30))
    assert np.allclose(store.direction, DIRECTION) and same_values(store, array)
    assert store.dtype == array.dtype
    chosen = built(itk_image(array), tmp_path, spacing=(1, 1, 1), origin=(0, 0, 0))
    assert (chosen.spacing, chosen.origin) == ((1, 1, 1), (0, 0, 0))
    assert np.allclose(chosen.direction, DIRECTION)


def test_itk_of_other_dimensions(tmp_path, itk_image):
    for image in (itk_image(np.zeros((4, 4))), itk_image(np.zeros((4, 4, 4)), components=3)):
        with pytest.raises(ValueError, match="three axes and one number"):
            built(image, tmp_path)


def test_simpleitk_itself(tmp_path):
    sitk = pytest.importorskip("SimpleITK")
    image = sitk.GetImageFromArray(sphere())
    image.SetSpacing((1.5, 2, 3))
    image.SetOrigin((10, 20, 30))
    image.SetDirection(DIRECTION.ravel().tolist())
    store = built(image, tmp_path)
    assert np.allclose(store.affine[:3, 3], (10, 20, 30)) and np.allclose(store.direction, DIRECTION)
    assert same_values(store, sphere())


def test_itk_itself(tmp_path):
    itk = pytest.importorskip("itk")
    image = itk.image_from_array(sphere())
    image.SetSpacing((1.5, 2, 3))
    image.SetDirection(itk.matrix_from_array(DIRECTION))
    store = built(image, tmp_path)
    assert store.spacing == (1.5, 2, 3) and np.allclose(store.direction, DIRECTION)
    assert same_values(store, sphere())


# VTK and PyVista -----------------------------------------------------------------------------


@pytest.fixture
def vtk_image():
    data_model = pytest.importorskip("vtkmodules.vtkCommonDataModel")
    from vtkmodules.util.numpy_support import numpy_to_vtk

    def make(array, extent_from=(0, 0, 0), in_cells=False):
        image = data_model.vtkImageData()
        ends = [
            (low, low + size - 1 + in_cells)
            for low, size in zip(extent_from, array.shape[2::-1], strict=True)
        ]
        image.SetExtent(*(each for end in ends for each in end))
        image.SetSpacing(1.5, 2, 3)
        image.SetOrigin(10, 20, 30)
        image.SetDirectionMatrix(*DIRECTION.ravel())
        scalars = numpy_to_vtk(array.reshape(-1, *array.shape[3:]), deep=True)
        (image.GetCellData() if in_cells else image.GetPointData()).SetScalars(scalars)
        return image

    return make


def test_vtk(tmp_path, vtk_image):
    array = sphere()
    store = built(vtk_image(array), tmp_path)
    assert (store.spacing, store.origin) == ((1.5, 2, 3), (10, 20, 30))
    assert np.allclose(store.direction, DIRECTION) and same_values(store, array)
    moved = vtk_image(array, extent_from=(2, -3, 4))
    expected = np.zeros(3)
    moved.TransformIndexToPhysicalPoint((2, -3, 4), expected)
    assert np.allclose(built(moved, tmp_path).origin, expected)


def test_vtk_without_scalars_in_points(tmp_path, vtk_image):
    with pytest.raises(ValueError, match="scalars in cells"):
        built(vtk_image(sphere(), in_cells=True), tmp_path)
    with pytest.raises(ValueError, match="found 3: choose"):
        built(vtk_image(np.zeros((4, 4, 4, 3))), tmp_path)
    empty = vtk_image(sphere())
    empty.GetPointData().SetScalars(None)
    with pytest.raises(ValueError, match="found none"):
        built(empty, tmp_path)


def test_pyvista_itself(tmp_path):
    pyvista = pytest.importorskip("pyvista")
    image = pyvista.ImageData(dimensions=(28, 24, 20), spacing=(1.5, 2, 3), origin=(10, 20, 30))
    image.point_data["values"] = sphere().ravel()
    image.set_active_scalars("values")
    store = built(image, tmp_path)
    assert (store.spacing, store.origin) == ((1.5, 2, 3), (10, 20, 30))
    assert same_values(store, sphere())


# xarray --------------------------------------------------------------------------------------


class Coordinate(np.ndarray):
    """A coordinate of xarray: numbers with attributes."""


def data_array(units, dtype=np.uint16):
    array = sphere(dtype=dtype)
    coords = {}
    for dim, size, step, unit in zip("zyx", array.shape, (3.0, 2.0, 1.0), units, strict=True):
        values = (np.arange(size) * step + 10).view(Coordinate)
        values.attrs = {} if unit is None else {"units": unit}
        coords[dim] = values

    class DataArray:
        dims, shape = tuple("zyx"), array.shape
        attrs = {"units": "counts"}

        def __getitem__(self, index):
            return array[index]

    DataArray.coords, DataArray.dtype = coords, array.dtype
    return DataArray()


@pytest.mark.parametrize(
    "units, factor, noted",
    [
        (("mm", "mm", "mm"), (1, 1, 1), False),
        (("um", "µm", "micrometer"), (0.001,) * 3, True),
        (("mm", "cm", "m"), (1000, 10, 1), True),
        ((None, "mm", "mm"), (1, 1, 1), False),
        (("degrees", "degrees", "mm"), (1, 1, 1), False),
    ],
)
def test_units_of_coordinates(tmp_path, units, factor, noted):
    store = built(data_array(units), tmp_path)
    assert np.allclose(store.spacing, np.array((1, 2, 3)) * factor)
    assert np.allclose(store.origin, np.array((10, 10, 10)) * factor)
    assert store.units == "counts"
    assert store.notes == (["the coordinates were converted to millimetres"] if noted else [])


def test_xarray_itself(tmp_path):
    xarray = pytest.importorskip("xarray")
    array = xarray.DataArray(
        sphere(),
        dims=("z", "y", "x"),
        coords={"x": ("x", np.arange(28) * 2.0, {"units": "um"})},
        attrs={"units": "counts"},
    )
    array = array.assign_coords({d: (d, np.arange(array.sizes[d]), {"units": "um"}) for d in "zy"})
    store = built(array, tmp_path)
    assert np.allclose(store.spacing, (0.002, 0.001, 0.001)) and store.units == "counts"


def test_dask_itself(tmp_path):
    dask_array = pytest.importorskip("dask.array")
    lazy = dask_array.from_array(sphere(), chunks=(8, 24, 10)) + 1
    store = built(lazy, tmp_path)
    assert store.dtype == np.uint16 and same_values(store, sphere() + 1)
    steps = dask_array.stack([lazy, lazy * 2])
    scene = isosplat.build_scene(steps, tmp_path / "a.isobundle", times=[0, 1])
    assert same_values(scene.layers[0].store(1), (sphere() + 1) * 2)


def test_images_in_scenes_and_views(tmp_path, monkeypatch):
    labels = np.zeros((12, 14, 16), np.uint8)
    labels[3:9, 4:10, 3:8] = 1
    image = Nifti1Image(labels.T, AFFINE_RAS)
    scene = isosplat.build_labels(image, tmp_path / "a.isobundle")
    assert scene.layers[0].label.volume == pytest.approx(180 * 9)
    assert np.allclose(scene.layers[0].store().affine[:3, :3], AFFINE_LPS[:3, :3])
    steps = (Nifti1Image(sphere().T * step, AFFINE_RAS) for step in (1.0, 2.0))
    run = isosplat.build_scene(steps, tmp_path / "b.isobundle", times=[0, 1])
    assert np.allclose(run.layers[0].store(1).affine, AFFINE_LPS)
    monkeypatch.setitem(sys.modules, "anywidget", None)
    assert isosplat.view(image)._shown.file_bytes > 1000
