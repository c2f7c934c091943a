#!/usr/bin/python3
"""Reads meshes with VTK's readers, and prints what VTK finds in them, one JSON line for each.

    check_meshes.py FILE…                                       .ply, .stl, .obj, .glb or .3mf
    check_meshes.py --flying-edges FILE X Y Z TYPE SX SY SZ ISOVALUE    raw volume (raw_volume.py)

VTK has no reader for 3MF; its XML is read here. Vertices at the same position count as one.
"""

import json
import sys
import zipfile
from xml.etree import ElementTree

from raw_volume import flying_edges, raw_volume
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkFiltersCore import vtkCleanPolyData, vtkFeatureEdges, vtkMassProperties
from vtkmodules.vtkFiltersGeometry import vtkCompositeDataGeometryFilter
from vtkmodules.vtkIOGeometry import vtkGLTFReader, vtkOBJReader, vtkSTLReader
from vtkmodules.vtkIOPLY import vtkPLYReader

READERS = {"ply": vtkPLYReader, "stl": vtkSTLReader, "obj": vtkOBJReader}


def read_3mf(path):
    with zipfile.ZipFile(path) as archive:
        model = ElementTree.fromstring(archive.read("3D/3dmodel.model"))
    space = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"
    points, triangles = vtkPoints(), vtkCellArray()
    points.SetDataTypeToDouble()
    for vertex in model.iter(space + "vertex"):
        points.InsertNextPoint(*(float(vertex.get(axis)) for axis in "xyz"))
    for triangle in model.iter(space + "triangle"):
        triangles.InsertNextCell(3, [int(triangle.get(key)) for key in ("v1", "v2", "v3")])
    mesh = vtkPolyData()
    mesh.SetPoints(points)
    mesh.SetPolys(triangles)
    return mesh


def read(path):
    kind = path.rsplit(".", 1)[1]
    if kind == "3mf":
        return read_3mf(path)
    if kind == "glb":
        reader, parts = vtkGLTFReader(), vtkCompositeDataGeometryFilter()
        reader.SetFileName(path)
        parts.SetInputConnection(reader.GetOutputPort())
        parts.Update()
        return parts.GetOutput()
    reader = READERS[kind]()
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()


def count_edges(mesh, **kinds):
    edges = vtkFeatureEdges()
    edges.SetInputData(mesh)
    for kind in ("BoundaryEdges", "FeatureEdges", "ManifoldEdges", "NonManifoldEdges"):
        getattr(edges, "Set" + kind)(kinds.get(kind, False))
    edges.Update()
    return edges.GetOutput().GetNumberOfCells()


def describe(mesh):
    clean = vtkCleanPolyData()
    clean.SetInputData(mesh)
    clean.SetTolerance(0)
    clean.ConvertPolysToLinesOff()
    clean.ConvertLinesToPointsOff()
    clean.Update()
    joined = clean.GetOutput()
    mass = vtkMassProperties()
    mass.SetInputData(mesh)
    boundary = count_edges(joined, BoundaryEdges=True)
    non_manifold = count_edges(joined, NonManifoldEdges=True)
    edges = boundary + non_manifold + count_edges(joined, ManifoldEdges=True)
    print(
        json.dumps(
            {
                "vertices": joined.GetNumberOfPoints(),
                "triangles": mesh.GetNumberOfCells(),
                "boundary": boundary,
                "nonManifold": non_manifold,
                "euler": joined.GetNumberOfPoints() - edges + joined.GetNumberOfCells(),
                "area": mass.GetSurfaceArea(),
                "volume": mass.GetVolume(),
            }
        ),
        flush=True,
    )


def main():
    if sys.argv[1] == "--flying-edges":
        path, x, y, z, kind, sx, sy, sz, isovalue = sys.argv[2:]
        edges = flying_edges(raw_volume(path, (x, y, z), kind, (sx, sy, sz)))
        edges.SetValue(0, float(isovalue))
        edges.Update()
        describe(edges.GetOutput())
    else:
        for path in sys.argv[1:]:
            describe(read(path))


main()
