"""Compares isosurfaces with VTK's contour of a mesh.

Arguments: the mesh's file, the name of an array, an isovalue, and .vtp files that together are the
surface. Prints: the ratio of the areas; the 95th percentiles of the distances from the surface to
the contour and back, in cube roots of the volumes of the mesh's cells there; the numbers of
connected components of both. With --points before them, the .vtp files are points, and only the
mean, the 95th percentile and the largest of their distances from the contour are printed, and the
largest one from the contour's points to them.
"""

import math
import random
import sys

import vtk


def read(reader, path):
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()


def area(surface):
    triangles = vtk.vtkTriangleFilter()
    triangles.SetInputData(surface)
    properties = vtk.vtkMassProperties()
    properties.SetInputConnection(triangles.GetOutputPort())
    return properties.GetSurfaceArea()


def components(surface):
    clean = vtk.vtkCleanPolyData()
    clean.SetInputData(surface)
    clean.ToleranceIsAbsoluteOn()
    # Edges between levels have vertices of one side only.
    clean.SetAbsoluteTolerance(1e-3 * surface.GetLength())
    connected = vtk.vtkPolyDataConnectivityFilter()
    connected.SetInputConnection(clean.GetOutputPort())
    connected.SetExtractionModeToAllRegions()
    connected.Update()
    return connected.GetNumberOfExtractedRegions()


def locator(data):
    found = vtk.vtkCellLocator()
    found.SetDataSet(data)
    found.BuildLocator()
    return found


def closest(locator, point):
    at, cell, part, square = [0.0] * 3, vtk.reference(0), vtk.reference(0), vtk.reference(0.0)
    locator.FindClosestPoint(point, at, cell, part, square)
    return math.sqrt(float(square)), int(cell)


def read_mesh(path):
    legacy = path.endswith(".vtk")
    return read(vtk.vtkDataSetReader() if legacy else vtk.vtkXMLGenericDataObjectReader(), path)


def main():
    are_points = sys.argv[1] == "--points"
    if are_points:
        del sys.argv[1]
    mesh = read_mesh(sys.argv[1])
    contour = vtk.vtkContourFilter()
    contour.SetInputData(mesh)
    contour.SetInputArrayToProcess(0, 0, 0, vtk.vtkDataObject.FIELD_ASSOCIATION_POINTS, sys.argv[2])
    contour.SetValue(0, float(sys.argv[3]))
    contour.Update()
    expected = contour.GetOutput()
    joined = vtk.vtkAppendPolyData()
    for path in sys.argv[4:]:
        joined.AddInputData(read(vtk.vtkXMLPolyDataReader(), path))
    joined.Update()
    surface = joined.GetOutput()
    sizes = vtk.vtkCellSizeFilter()
    sizes.SetInputData(mesh)
    sizes.Update()
    volumes = sizes.GetOutput().GetCellData().GetArray("Volume")
    cells = locator(mesh)
    random.seed(1)

    def distances(start, end):
        to = locator(end)
        count = start.GetNumberOfPoints()
        found = []
        for i in random.sample(range(count), min(count, 3000)):
            point = start.GetPoint(i)
            size = abs(volumes.GetValue(closest(cells, point)[1])) ** (1 / 3)
            found.append(closest(to, point)[0] / size)
        return sorted(found)

    def distance(start, end):
        found = distances(start, end)
        return found[len(found) * 95 // 100]

    if are_points:
        found = distances(surface, expected)
        print(sum(found) / len(found), found[len(found) * 95 // 100], found[-1],
              distances(expected, surface)[-1])
        return
    print(area(surface) / area(expected), distance(surface, expected), distance(expected, surface),
          components(surface), components(expected))


main()
