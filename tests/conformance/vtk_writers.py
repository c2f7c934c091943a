"""Writes files of VTK's XML format with VTK, for vtk_writers_test.cpp.

usage: vtk_writers.py FOLDER

If VTK is not installed, prints "absent". The array density has the value index / 4 at each point,
counted with x fastest.
"""

import sys

try:
    import numpy
    from vtkmodules import vtkIOParallelXML, vtkIOXML
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonDataModel import vtkImageData, vtkRectilinearGrid
except ImportError:
    print("absent")
    sys.exit()

folder = sys.argv[1]
extent = (2, 12, -1, 8, 3, 9)
sizes = [11, 10, 7]


def with_arrays(grid):
    points, cells = grid.GetNumberOfPoints(), grid.GetNumberOfCells()
    density = numpy_to_vtk((numpy.arange(points) * 0.25).astype("f4"), deep=True)
    density.SetName("density")
    grid.GetPointData().SetScalars(density)
    velocity = numpy_to_vtk(numpy.arange(3 * points).reshape(-1, 3).astype("i2"), deep=True)
    velocity.SetName("velocity")
    grid.GetPointData().AddArray(velocity)
    other = numpy_to_vtk(numpy.arange(cells).astype("f8"), deep=True)
    other.SetName("other")
    grid.GetCellData().AddArray(other)
    return grid


image = vtkImageData()
image.SetExtent(*extent)
image.SetSpacing(0.5, 0.75, 2)
image.SetOrigin(10, 20, 30)
image.SetDirectionMatrix(0, -1, 0, 1, 0, 0, 0, 0, 1)
with_arrays(image)
for mode in ("Ascii", "Binary", "Appended"):
    for compressor in ("None", "ZLib", "LZ4", "LZMA"):
        for order in ("Little", "Big"):
            for encode in (0, 1):
                writer = vtkIOXML.vtkXMLImageDataWriter()
                writer.SetInputData(image)
                getattr(writer, "SetDataModeTo" + mode)()
                getattr(writer, "SetCompressorTypeTo" + compressor)()
                getattr(writer, f"SetByteOrderTo{order}Endian")()
                writer.SetEncodeAppendedData(encode)
                writer.SetBlockSize(1024)
                if encode:
                    writer.SetHeaderTypeToUInt64()
                writer.SetFileName(f"{folder}/{mode}_{compressor}_{order}_{encode}.vti")
                writer.Write()
writer = vtkIOXML.vtkXMLImageDataWriter()
writer.SetInputData(image)
writer.SetNumberOfPieces(4)
writer.SetFileName(f"{folder}/pieces.vti")
writer.Write()

grid = vtkRectilinearGrid()
grid.SetExtent(*extent)
for axis, size, step in zip("XYZ", sizes, (0.5, 0.75, 2)):
    positions = numpy_to_vtk((numpy.arange(size) * step + 5).astype("f4"), deep=True)
    getattr(grid, f"Set{axis}Coordinates")(positions)
with_arrays(grid)
for writer, name in (
    (vtkIOXML.vtkXMLRectilinearGridWriter(), "even.vtr"),
    (vtkIOParallelXML.vtkXMLPRectilinearGridWriter(), "even.pvtr"),
    (vtkIOParallelXML.vtkXMLPImageDataWriter(), "files.pvti"),
):
    writer.SetInputData(image if name.endswith("i") else grid)
    if name[-4] == "p":
        writer.SetNumberOfPieces(3)
        writer.SetStartPiece(0)
        writer.SetEndPiece(2)
        writer.SetGhostLevel(1)
    writer.SetFileName(f"{folder}/{name}")
    writer.Write()
