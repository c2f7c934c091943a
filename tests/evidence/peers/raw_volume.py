"""Functions that the scripts in this folder share: a VTK reader of a raw volume, and the filter."""

from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D, vtkMarchingCubes
from vtkmodules.vtkIOImage import vtkImageReader2

SCALAR_TYPES = {
    "u8": "SetDataScalarTypeToUnsignedChar",
    "i16": "SetDataScalarTypeToShort",
    "u16": "SetDataScalarTypeToUnsignedShort",
    "f32": "SetDataScalarTypeToFloat",
}


def raw_volume(path, voxels, kind, spacing=(1, 1, 1)):
    """A reader of little-endian values, x fastest."""
    reader = vtkImageReader2()
    reader.SetFileName(path)
    reader.SetFileDimensionality(3)
    reader.SetDataExtent(*(bound for n in voxels for bound in (0, int(n) - 1)))
    reader.SetDataSpacing(*map(float, spacing))
    getattr(reader, SCALAR_TYPES[kind])()
    reader.SetDataByteOrderToLittleEndian()
    reader.FileLowerLeftOn()  # else rows are taken from the top
    return reader


def flying_edges(reader, filter_class=vtkFlyingEdges3D):
    """The filter (or vtkMarchingCubes) behind the reader, which computes only normals in addition."""
    edges = filter_class()
    edges.SetInputConnection(reader.GetOutputPort())
    edges.ComputeNormalsOn()
    edges.ComputeGradientsOff()
    edges.ComputeScalarsOff()
    return edges
