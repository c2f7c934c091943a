"""Writes meshes with VTK, for the comparison with its contours.

usage: write_meshes.py FOLDER [legacy]

curved.vts: a curvilinear lattice. The array t of the points is a wave, whose isosurfaces have a
curvature of some cells.
quadratic.vtu: the same field on quadratic hexahedra, with curved edges.

With "legacy": small meshes, each as KIND.xml and as KIND_VERSION_text.vtk and _binary.vtk.
"""

import math
import sys

import vtk


def place(u, v, w):
    """A position in a bent and twisted block, for u, v, w from 0 to 1."""
    angle = 0.4 + 2 * v + 0.5 * w
    radius = 1 + u + 0.1 * math.sin(5 * w)
    return radius * math.cos(angle), radius * math.sin(angle), 1.5 * w + 0.2 * u * u


def field(x, y, z):
    return math.sin(2.5 * x) * math.cos(2 * y) + z * z / 2


def with_field(grid):
    values = vtk.vtkDoubleArray()
    values.SetName("t")
    for i in range(grid.GetNumberOfPoints()):
        values.InsertNextValue(field(*grid.GetPoint(i)))
    grid.GetPointData().SetScalars(values)
    return grid


def write(writer, grid, path):
    writer.SetInputData(grid)
    writer.SetFileName(path)
    writer.Write()


def curved(n):
    grid = vtk.vtkStructuredGrid()
    grid.SetExtent(3, 3 + n[0], -2, n[1] - 2, 0, n[2])
    points = vtk.vtkPoints()
    points.SetDataTypeToDouble()
    for k in range(n[2] + 1):
        for j in range(n[1] + 1):
            for i in range(n[0] + 1):
                points.InsertNextPoint(place(i / n[0], j / n[1], k / n[2]))
    grid.SetPoints(points)
    return with_field(grid)


def quadratic(n):
    """Hexahedra of 20 nodes: those of a lattice of half edges with at most one odd index."""
    points = vtk.vtkPoints()
    points.SetDataTypeToDouble()
    known = {}

    def node(*index):
        if index not in known:
            at = place(*(i / (2 * count) for i, count in zip(index, n)))
            known[index] = points.InsertNextPoint(at)
        return known[index]

    coordinates = vtk.vtkQuadraticHexahedron().GetParametricCoords()
    corners = [tuple(round(2 * coordinates[3 * i + k]) for k in range(3)) for i in range(20)]
    grid = vtk.vtkUnstructuredGrid()
    for k in range(n[2]):
        for j in range(n[1]):
            for i in range(n[0]):
                nodes = [node(2 * i + c[0], 2 * j + c[1], 2 * k + c[2]) for c in corners]
                grid.InsertNextCell(vtk.VTK_QUADRATIC_HEXAHEDRON, 20, nodes)
    grid.SetPoints(points)
    return with_field(grid)


def uneven():
    """A rectilinear grid with uneven spacing."""
    grid = vtk.vtkRectilinearGrid()
    grid.SetExtent(0, 3, 0, 2, 0, 4)
    for name, count in (("X", 4), ("Y", 3), ("Z", 5)):
        along = vtk.vtkDoubleArray()
        for i in range(count):
            along.InsertNextValue(i + 0.2 * i * i)
        getattr(grid, f"Set{name}Coordinates")(along)
    return with_field(grid)


def write_legacy(folder):
    meshes = (
        ("curved", curved((3, 4, 2)), vtk.vtkXMLStructuredGridWriter, vtk.vtkStructuredGridWriter),
        (
            "quadratic",
            quadratic((2, 2, 2)),
            vtk.vtkXMLUnstructuredGridWriter,
            vtk.vtkUnstructuredGridWriter,
        ),
        ("uneven", uneven(), vtk.vtkXMLRectilinearGridWriter, vtk.vtkRectilinearGridWriter),
    )
    for name, grid, xml, legacy in meshes:
        write(xml(), grid, f"{folder}/{name}.xml")
        for version in (42, 51):
            for form in ("text", "binary"):
                writer = legacy()
                writer.SetFileVersion(version)
                if form == "binary":
                    writer.SetFileTypeToBinary()
                write(writer, grid, f"{folder}/{name}_{version}_{form}.vtk")


def main():
    folder = sys.argv[1]
    if "legacy" in sys.argv[2:]:
        write_legacy(folder)
        return
    write(vtk.vtkXMLStructuredGridWriter(), curved((16, 40, 24)), folder + "/curved.vts")
    write(vtk.vtkXMLUnstructuredGridWriter(), quadratic((8, 20, 12)), folder + "/quadratic.vtu")


main()
