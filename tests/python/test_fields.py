"""Fields of stores: their values at points and vertices."""

import sys
import types

import isosplat
import numpy as np
import pytest
from conftest import run_program, sphere


def linear(shape=(20, 24, 28)):
    """x + 2 y - 3 z of the voxels, which trilinear interpolation keeps."""
    z, y, x = np.indices(shape)
    return (x + 2 * y - 3 * z).astype(np.int16)


def expected(positions, spacing=(1, 1, 1)):
    x, y, z = (positions / spacing).T
    return x + 2 * y - 3 * z


@pytest.mark.parametrize("order", ["C", "F"])
@pytest.mark.parametrize("order_of_field", ["C", "F"])
def test_values_are_those_of_the_array(order, order_of_field, tmp_path):
    cube = (24, 24, 24)  # whose axes no check of sizes tells apart
    volume = np.array(sphere(cube), order=order)
    field = np.array(linear(cube), order=order_of_field)
    store = isosplat.build(
        volume, tmp_path / "a.isosplat", spacing=(1, 2, 3), fields={"linear": field}
    )
    points = store.points(50.5, fields="linear")
    positions, normals = points
    assert len(positions) > 500
    values = points.fields["linear"]
    assert values.dtype == np.float32
    np.testing.assert_allclose(values, expected(positions, (1, 2, 3)), atol=1e-3)
    mesh = store.mesh(50.5, fields=["linear"], simplify=0.3)
    np.testing.assert_allclose(
        mesh.fields["linear"], expected(mesh.vertices, (1, 2, 3)), atol=1e-3
    )
    with pytest.raises(ValueError):
        mesh.fields["linear"][0] = 1
    assert store.points(50.5).fields == {}
    assert store.mesh(50.5).fields == {}


def test_fields_are_described(tmp_path):
    values = linear().astype(np.float64) / 7
    values[0, 0, 0] = np.nan
    store = isosplat.build(
        sphere(), tmp_path / "a.isosplat", fields={"b": values, "a": linear()}
    )
    assert list(store.fields) == ["b", "a"]
    field = store.fields["b"]
    assert field.missing_voxels == 1
    assert 0 < field.max_error < 1e-3
    low, high = field.value_range
    assert abs(low - np.nanmin(values)) <= field.max_error * 1.01
    assert abs(high - np.nanmax(values)) <= field.max_error * 1.01
    assert store.fields["a"].max_error == 0
    run_program("verify", tmp_path / "a.isosplat")
    assert isosplat.build(sphere(), tmp_path / "b.isosplat").fields == {}


def test_missing_values_are_nan(tmp_path):
    values = linear().astype(np.float32)
    values[:, :, :14] = np.nan
    store = isosplat.build(sphere(), tmp_path / "a.isosplat", fields={"f": values})
    mesh = store.mesh(40.5, fields="f")
    found = mesh.fields["f"]
    x = mesh.vertices[:, 0]
    assert np.isnan(found[x < 13.999]).all()
    assert np.isfinite(found[x >= 14]).all()
    assert np.isnan(found).any() and np.isfinite(found).any()


def test_fields_of_the_program_are_saved(tmp_path):
    np.save(tmp_path / "v.npy", sphere())
    np.save(tmp_path / "f.npy", linear())
    path = tmp_path / "a.isosplat"
    run_program("build", tmp_path / "v.npy", "-o", path, "--field", f"f={tmp_path / 'f.npy'}")
    mesh = isosplat.open(path).mesh(50.5, fields="f")
    mesh.save(tmp_path / "a.npz")
    with np.load(tmp_path / "a.npz") as saved:
        np.testing.assert_array_equal(saved["f"], mesh.fields["f"])
    run_program("extract", path, "-i", "50.5", "--mesh", "--field", "f", "-o", tmp_path / "b.npz")
    with np.load(tmp_path / "b.npz") as saved:
        np.testing.assert_array_equal(saved["f"], mesh.fields["f"])
    run_program("extract", path, "-i", "50.5", "--field", "f", "-o", tmp_path / "b.npy")
    points = np.load(tmp_path / "b.npy")
    np.testing.assert_allclose(points["f"], expected(points["position"]), atol=1e-3)
    with pytest.raises(ValueError, match=r"\.ply, \.glb, \.npz, \.vtp"):
        mesh.save(tmp_path / "a.stl")


def test_vtk_reads_the_values(tmp_path):
    vtk_xml = pytest.importorskip("vtkmodules.vtkIOXML")
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkDataArray

    store = isosplat.build(sphere(), tmp_path / "a.isosplat", fields={"f": linear()})
    mesh = store.mesh(50.5, fields="f")
    mesh.save(tmp_path / "mesh.vtp")
    run_program("extract", store.path, "-i", "50.5", "--field", "f", "-o", tmp_path / "points.vtp")
    for name, count in ("mesh.vtp", len(mesh.vertices)), ("points.vtp", len(store.points(50.5)[0])):
        reader = vtk_xml.vtkXMLPolyDataReader()
        reader.SetFileName(str(tmp_path / name))
        reader.Update()
        surface = reader.GetOutput()
        positions = vtk_to_numpy(surface.GetPoints().GetData())
        array = surface.GetPointData().GetArray("f")
        assert isinstance(array, vtkDataArray)
        assert len(positions) == count
        np.testing.assert_allclose(vtk_to_numpy(array), expected(positions), atol=1e-3)
        assert surface.GetPointData().GetNormals().GetNumberOfTuples() == count
        cells = surface.GetNumberOfPolys() if name == "mesh.vtp" else surface.GetNumberOfVerts()
        assert cells == (len(mesh.triangles) if name == "mesh.vtp" else count)


def test_wrong_fields_are_refused(tmp_path):
    path = tmp_path / "a.isosplat"
    store = isosplat.build(sphere(), path, fields={"f": linear()})
    with pytest.raises((KeyError, ValueError, LookupError), match="which has f"):
        store.points(50.5, fields="g")
    with pytest.raises(TypeError, match="fields"):
        store.mesh(50.5, fields=[1])
    for fields, message in [
        ({"f": sphere((5, 5, 5))}, "expected 28 × 24 × 20 voxels"),
        ({"a b": linear()}, "name"),
    ]:
        with pytest.raises(ValueError, match=message):
            isosplat.build(sphere(), tmp_path / "b.isosplat", fields=fields)
        assert not (tmp_path / "b.isosplat").exists()
    with pytest.raises(TypeError, match="fields"):
        isosplat.build(path, tmp_path / "b.isosplat", fields={"f": linear()})


class CountedSlices:
    """An array that counts how often its slices are read."""

    def __init__(self, array):
        self._array, self.shape, self.dtype = array, array.shape, array.dtype
        self.reads = 0

    def __getitem__(self, key):
        self.reads += 1
        return self._array[key]


def test_fields_are_checked_before_the_volume_is_read(tmp_path):
    for fields in {"f": sphere((5, 5, 5))}, {"a b": linear()}:
        volume = CountedSlices(sphere())
        with pytest.raises(ValueError):
            isosplat.build(volume, tmp_path / "a.isosplat", fields=fields)
        assert volume.reads == 0


class Header:
    def get_xyzt_units(self):
        return "mm", "sec"


class Nifti1Image:
    """The members of nibabel.Nifti1Image: its arrays are indexed [x, y, z]."""

    header = Header()

    def __init__(self, dataobj, affine=np.eye(4)):
        self.dataobj, self.shape, self.affine = dataobj, dataobj.shape, affine


def test_an_image_on_other_voxels_is_resampled(tmp_path):
    fine, coarse = np.diag([1.0, 1, 2, 1]), np.diag([-2.0, 3, 2.5, 1])
    fine[:3, 3], coarse[:3, 3] = (10, 20, 30), (41, 17, 28)
    i = np.indices((19, 12, 22))  # of the field: x + 2 y - 3 z in the world, to the left and front
    x, y, z = (coarse[k, 3] + coarse[k, k] * i[k] for k in range(3))
    field = Nifti1Image((-x - 2 * y - 3 * z).astype(np.float32), coarse)
    for order in "C", "F":
        volume = Nifti1Image(np.array(sphere().T, order=order), fine)
        store = isosplat.build(volume, tmp_path / "a.isosplat", fields={"f": field})
        points = store.points(50.5, fields="f")
        assert len(points.positions) > 500
        found = points.fields["f"]
        np.testing.assert_allclose(found, expected(points.positions), atol=0.02)
    elsewhere = Nifti1Image(field.dataobj, coarse + np.diag([0.0, 0, 0, 0]))
    elsewhere.affine[:3, 3] = 1000
    with pytest.raises(ValueError, match="places it elsewhere"):
        isosplat.build(volume, tmp_path / "b.isosplat", fields={"f": elsewhere})
    # The geometry of the volume is given, so that of the image is not used.
    with pytest.raises(ValueError, match="resample it"):
        isosplat.build(volume, tmp_path / "b.isosplat", spacing=(1, 1, 1), fields={"f": field})


def test_an_image_as_a_field_may_have_another_order(tmp_path):
    for order in "C", "F":
        volume = np.array(sphere(), order=order)
        store = isosplat.build(
            volume, tmp_path / "a.isosplat", fields={"f": Nifti1Image(linear().T)}
        )
        points = store.points(50.5, fields="f")
        np.testing.assert_allclose(points.fields["f"], expected(points.positions), atol=1e-3)


def test_points_keep_their_fields(tmp_path):
    store = isosplat.build(sphere(), tmp_path / "a.isosplat", fields={"f": linear()})
    points = store.points(50.5, fields="f")
    moved = points._replace(positions=points.positions + 1)
    assert isinstance(moved, isosplat.Points)
    np.testing.assert_array_equal(moved.positions, points.positions + 1)
    np.testing.assert_array_equal(moved.fields["f"], points.fields["f"])
    assert isosplat.Points(points.positions, points.normals).fields == {}


def test_pyvista_keeps_the_normals(tmp_path, monkeypatch):
    class PolyData:
        def __init__(self, vertices, faces):
            self.point_data = {}

    monkeypatch.setitem(sys.modules, "pyvista", types.SimpleNamespace(PolyData=PolyData))
    names = ["Normals", "Normals_field", "f"]
    store = isosplat.build(
        sphere(), tmp_path / "a.isosplat", fields={name: linear() for name in names}
    )
    mesh = store.mesh(50.5, fields=names)
    data = mesh.to_pyvista().point_data
    assert list(data) == ["Normals", "Normals_field_field", "Normals_field", "f"]
    np.testing.assert_array_equal(data["Normals"], mesh.normals)
    np.testing.assert_array_equal(data["Normals_field_field"], mesh.fields["Normals"])


def test_an_interrupted_field_leaves_no_file(tmp_path):
    class Slices:
        shape = (20, 24, 28)
        dtype = np.dtype(np.int16)

        def __getitem__(self, key):
            raise RuntimeError("no such slice")

    with pytest.raises(RuntimeError, match="no such slice"):
        isosplat.build(sphere(), tmp_path / "a.isosplat", fields={"f": Slices()})
    assert list(tmp_path.iterdir()) == []
