"""image_to_raw.py IMAGE.vti OUT.raw: the values of VTK image data, little-endian, x fastest."""

import sys

from vtkmodules.vtkIOXML import vtkXMLImageDataReader

reader = vtkXMLImageDataReader()
reader.SetFileName(sys.argv[1])
reader.Update()
with open(sys.argv[2], "wb") as file:
    file.write(memoryview(reader.GetOutput().GetPointData().GetArray(0)))
