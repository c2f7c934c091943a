#!/usr/bin/python3
"""VTK's Flying Edges as a peer: loads a raw volume once, then extracts what it is asked for.

    flying_edges.py FILE X Y Z u8|i16|u16|f32 THREADS [marching-cubes]

With "marching-cubes": vtkMarchingCubes, which has one thread.

Each line of standard input is an isovalue. Answered by one line of JSON: seconds (of the filter
alone, warm), triangles, and the bytes of the mesh with normals (points, normals, connectivity).
"""

import json
import sys
import time

from raw_volume import flying_edges, raw_volume, vtkFlyingEdges3D, vtkMarchingCubes
from vtkmodules.vtkCommonCore import vtkSMPTools


def main():
    path, x, y, z, kind, threads = sys.argv[1:7]
    vtkSMPTools.SetBackend("TBB")
    vtkSMPTools.Initialize(int(threads))

    reader = raw_volume(path, (x, y, z), kind)
    reader.Update()
    marching_cubes = sys.argv[7:] == ["marching-cubes"]
    edges = flying_edges(reader, vtkMarchingCubes if marching_cubes else vtkFlyingEdges3D)
    print(json.dumps({"backend": vtkSMPTools.GetBackend()}), flush=True)
    for line in sys.stdin:
        edges.SetValue(0, float(line))
        edges.Modified()
        begin = time.perf_counter()
        edges.Update()
        seconds = time.perf_counter() - begin
        mesh = edges.GetOutput()
        size = lambda array: array.GetNumberOfValues() * array.GetDataTypeSize() if array else 0
        arrays = [
            mesh.GetPoints().GetData(),
            mesh.GetPointData().GetNormals(),
            mesh.GetPolys().GetConnectivityArray(),
            mesh.GetPolys().GetOffsetsArray(),
        ]
        answer = {
            "seconds": seconds,
            "triangles": mesh.GetNumberOfPolys(),
            "points": mesh.GetNumberOfPoints(),
            "bytes": sum(size(array) for array in arrays),
        }
        print(json.dumps(answer), flush=True)


main()
