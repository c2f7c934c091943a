#!/usr/bin/python3
"""Writes VTK's Flying Edges mesh of a raw volume, with the normals that it computes.

    flying_edges_mesh.py FILE X Y Z u8|i16|u16|f32 SX SY SZ ISOVALUE OUT

OUT, little-endian: points (u64), triangles (u64), points × 3 f32 (positions from voxel (0, 0, 0)'s
centre in the volume's axes), points × 3 f32 (normals), triangles × 3 u32.
"""

import struct
import sys
from array import array

from raw_volume import flying_edges, raw_volume


def main():
    path, x, y, z, kind, sx, sy, sz, isovalue, out = sys.argv[1:11]
    edges = flying_edges(raw_volume(path, (x, y, z), kind, (sx, sy, sz)))
    edges.SetValue(0, float(isovalue))
    edges.Update()
    mesh = edges.GetOutput()
    points = memoryview(mesh.GetPoints().GetData()).cast("B").cast("f")
    normals = memoryview(mesh.GetPointData().GetNormals()).cast("B").cast("f")
    cells = mesh.GetPolys().GetConnectivityArray()
    connectivity = memoryview(cells).cast("B").cast("q" if cells.GetDataTypeSize() == 8 else "i")
    with open(out, "wb") as file:
        count = mesh.GetNumberOfPoints()
        file.write(struct.pack("<QQ", count, len(connectivity) // 3))
        file.write(bytes(points))
        file.write(bytes(normals))
        file.write(memoryview(array("I", connectivity)).cast("B"))


main()
