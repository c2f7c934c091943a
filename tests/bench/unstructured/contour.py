#!/usr/bin/python3
"""VTK as a peer: reads a .vtu, contours it, and prints one line of JSON: the seconds of both, and
the triangles.

    contour.py FILE ISOVALUE
"""

import json
import sys
import time

from vtkmodules.vtkFiltersCore import vtkContourFilter
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader


def main():
    begin = time.perf_counter()
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(sys.argv[1])
    reader.Update()
    read = time.perf_counter()
    contour = vtkContourFilter()
    contour.SetInputConnection(reader.GetOutputPort())
    contour.SetInputArrayToProcess(0, 0, 0, 0, "values")
    contour.SetValue(0, float(sys.argv[2]))
    contour.Update()
    end = time.perf_counter()
    answer = {
        "read": read - begin,
        "contour": end - read,
        "triangles": contour.GetOutput().GetNumberOfPolys(),
    }
    print(json.dumps(answer))


main()
