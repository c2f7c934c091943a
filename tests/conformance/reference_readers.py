"""Reads volumes with programs that are independent of Isosplat, for reference_test.cpp.

usage: reference_readers.py FORMAT < requests > results

A request is a line of JSON: {"path": …, "step": …}. Its result is a line, too: the volume
{"sizes", "values", "steps", "origin"} (x fastest; mm, LPS), or {"skipped": why}. If the reader is
not installed, the only result is {"absent": what}.
"""

import json
import os
import subprocess
import sys
import tempfile


class Skipped(Exception):
    """The reader does not read this kind of file."""


def volume(values, steps, origin):
    """values: a NumPy array, its axes z, y, x."""
    return {
        "sizes": list(values.shape[::-1]),
        "values": [float(v) for v in values.astype(float).ravel()],
        "steps": [[float(c) for c in step] for step in steps],
        "origin": [float(c) for c in origin],
    }


# DICOM: pydicom ----------------------------------------------------------------------------------


def dicom_pixels(ds):
    """Values of all frames. pydicom does not remove the bits outside of the stored ones."""
    if not hasattr(ds.file_meta, "TransferSyntaxUID"):
        little, implicit = ds.is_little_endian, ds.is_implicit_VR
        if implicit:
            ds.file_meta.TransferSyntaxUID = pydicom.uid.ImplicitVRLittleEndian
        elif little:
            ds.file_meta.TransferSyntaxUID = pydicom.uid.ExplicitVRLittleEndian
        else:
            ds.file_meta.TransferSyntaxUID = pydicom.uid.ExplicitVRBigEndian
    words = ds.pixel_array.astype(numpy.int64) >> (ds.HighBit + 1 - ds.BitsStored)
    codes = words & ((1 << ds.BitsStored) - 1)
    if ds.PixelRepresentation == 1:
        sign = 1 << (ds.BitsStored - 1)
        codes = (codes ^ sign) - sign
    return codes.reshape((-1, ds.Rows, ds.Columns)).astype(float)


def rescaled(codes, item):
    slope, intercept = item.get("RescaleSlope", 1), item.get("RescaleIntercept", 0)
    return codes * float(slope) + float(intercept)


def numbers(value):
    return numpy.array([float(v) for v in value])


def dicom_frames(ds):
    """(position, orientation, pixel spacing, values) of each frame of a file."""
    codes = dicom_pixels(ds)
    if "PerFrameFunctionalGroupsSequence" in ds:
        shared = ds.SharedFunctionalGroupsSequence[0]
        for i, own in enumerate(ds.PerFrameFunctionalGroupsSequence):
            def group(name):
                return (own if name in own else shared)[name].value[0]

            position = numbers(group("PlanePositionSequence").ImagePositionPatient)
            orientation = numbers(group("PlaneOrientationSequence").ImageOrientationPatient)
            spacing = numbers(group("PixelMeasuresSequence").PixelSpacing)
            values = codes[i]
            if "PixelValueTransformationSequence" in own:
                values = rescaled(values, own.PixelValueTransformationSequence[0])
            yield position, orientation, spacing, values
        return
    spacing = numbers(ds.PixelSpacing)
    place = ds.DetectorInformationSequence[0] if "DetectorInformationSequence" in ds else ds
    position = numbers(place.ImagePositionPatient)
    orientation = numbers(place.ImageOrientationPatient)
    normal = numpy.cross(orientation[:3], orientation[3:])
    for i in range(codes.shape[0]):
        along = 0.0
        values = rescaled(codes[i], ds)
        if "GridFrameOffsetVector" in ds:
            along = float(ds.GridFrameOffsetVector[i])
            values = codes[i] * float(ds.DoseGridScaling)
        elif codes.shape[0] > 1:
            along = i * float(ds.SpacingBetweenSlices)
        yield position + normal * along, orientation, spacing, values


def read_dicom(path, step):
    names = sorted(os.listdir(path)) if os.path.isdir(path) else [""]
    frames = []
    for name in names:
        try:
            ds = pydicom.dcmread(os.path.join(path, name) if name else path, force=True)
        except Exception:
            continue
        if "PixelData" not in ds or ds.get("SeriesInstanceUID") != "1.2.3.4":
            continue
        if "LOCALIZER" in ds.get("ImageType", []):
            continue
        keys = ("TemporalPositionIdentifier", "EchoTime", "AcquisitionNumber")
        step_values = [ds.get(key) for key in keys]
        if step is not None and step not in [float(t) for t in step_values if t is not None]:
            continue
        frames += dicom_frames(ds)
    o = frames[0][1]
    normal = numpy.cross(o[:3], o[3:])
    frames.sort(key=lambda frame: numpy.dot(frame[0], normal))
    first, last = frames[0][0], frames[-1][0]
    steps = [o[:3] * frames[0][2][1], o[3:] * frames[0][2][0], (last - first) / (len(frames) - 1)]
    return volume(numpy.array([frame[3] for frame in frames]), steps, first)


# TIFF: tifffile ----------------------------------------------------------------------------------


def read_tiff(path, step):
    if os.path.isdir(path):
        raise Skipped("tifffile does not order the files of a folder")
    with tifffile.TiffFile(path) as tiff:
        # The reader's series need pages with equal tags and contiguous bytes, which these files do not
        # have. So it decodes the pages one by one, and its metadata state their order.
        page = tiff.pages[0]
        values = numpy.stack([one.asarray() for one in tiff.pages])
        orientation = page.tags[274].value if 274 in page.tags else 1
        times, slices_first = 1, True
        if tiff.is_imagej:
            times = tiff.imagej_metadata.get("frames", 1)
        elif tiff.is_ome:
            pixels = tifffile.xml2dict(tiff.ome_metadata)["OME"]["Image"]["Pixels"]
            times = int(pixels["SizeT"])
            slices_first = pixels["DimensionOrder"].index("Z") < pixels["DimensionOrder"].index("T")
        elif step is not None:
            raise Skipped("the order of slices and times is unknown")
        if slices_first:
            values = values.reshape((times, -1) + values.shape[1:])[step or 0]
        else:
            values = values[step or 0 :: times]
        if orientation in (2, 3):
            values = values[:, :, ::-1]
        if orientation in (3, 4):
            values = values[:, ::-1, :]
        if page.photometric == tifffile.PHOTOMETRIC.MINISWHITE and values.dtype.kind == "u":
            values = numpy.iinfo(values.dtype).max - values
        size = [1.0, 1.0, 1.0]
        if tiff.is_imagej:
            about = tiff.imagej_metadata
            unit = {"mm": 1, "cm": 10}.get(about["unit"], 0.001)
            x = page.tags["XResolution"].value
            y = page.tags["YResolution"].value
            between = abs(about["spacing"])
            size = [unit * x[1] / x[0], unit * y[1] / y[0], unit * between]
        elif tiff.is_ome:
            size = [0.001 * pixels["PhysicalSize" + axis] for axis in "XYZ"]
        return volume(values, numpy.diag(size), [0, 0, 0])


# NRRD: teem's unu --------------------------------------------------------------------------------


def read_nrrd(path, step):
    """unu reads the voxels and parses the header, and writes an equivalent header."""
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "out.nrrd")

        def unu(*arguments):
            run = subprocess.run(["teem-unu", *arguments], capture_output=True, check=False)
            if run.returncode:
                raise Skipped(run.stderr.decode(errors="replace")[-300:])

        unu("save", "-f", "nrrd", "-e", "raw", "-i", path, "-o", out)
        header = nrrd_header(out)
        vectors = header.get("space directions", "").split()
        kinds = header.get("kinds", "").split()
        if len(header["sizes"].split()) == 4:
            if vectors and not any("none" in v or v.startswith("(0,0,0,") for v in vectors):
                raise Skipped("no axis except the spatial ones")
            other = [
                i
                for i in range(4)
                if (vectors and (vectors[i] == "none" or vectors[i].startswith("(0,0,0,")))
                or (not vectors and kinds[i] in ("list", "time"))
            ]
            unu("slice", "-a", str(other[0]), "-p", str(step or 0), "-i", out, "-o", out)
            header = nrrd_header(out)
        unu("convert", "-t", "double", "-i", out, "-o", out)
        unu("save", "-f", "nrrd", "-e", "raw", "-en", "little", "-i", out, "-o", out)
        sizes = [int(n) for n in header["sizes"].split()]
        with open(out, "rb") as file:
            data = file.read()
        values = numpy.frombuffer(data[data.index(b"\n\n") + 2 :], "<f8").reshape(sizes[::-1])
    if "space directions" in header:
        space = header.get("space", "")
        sign = numpy.array([1.0, 1.0, 1.0])
        if space.startswith("right"):
            sign[0] = -1
        if "anterior" in space:
            sign[1] = -1
        if space == "3D-left-handed":
            sign[2] = -1
        unit = header.get("space units", '"mm"').split()[0].strip('"')
        scale = {"mm": 1, "cm": 10, "um": 0.001}[unit]

        def vector(text):
            return numpy.array([float(c) for c in text.strip("()").split(",")])[:3] * sign * scale

        steps = [vector(v) for v in header["space directions"].split()]
        return volume(values, steps, vector(header["space origin"]))
    if "axis maxs" in header or "axis mins" in header:
        raise Skipped("positions by mins and maxs: they are missing in unu's header")
    spacing = [float(s) for s in header.get("spacings", "1 1 1").split()]
    return volume(values, numpy.diag(spacing), [0, 0, 0])


def nrrd_header(path):
    with open(path, "rb") as file:
        text = file.read().split(b"\n\n")[0].decode()
    lines = [line.split(": ", 1) for line in text.split("\n") if ": " in line]
    return {line[0]: line[1].strip() for line in lines}


# MRC: mrcfile -------------------------------------------------------------------------------------


def read_mrc(path, step):
    with mrcfile.open(path) as file:
        h, values = file.header, file.data
        if h.ispg >= 401:
            values = values[step or 0]
        if (h.cellb.alpha, h.cellb.beta, h.cellb.gamma) != (90, 90, 90):
            raise Skipped("a sheared cell")
        origin = numpy.array([h.origin.x, h.origin.y, h.origin.z], float)
        if origin.any() and b"IMOD" in h.tobytes()[152:156] + h.tobytes()[155:151:-1]:
            raise Skipped("the sign of the origin: mrcfile does not know IMOD's flag")
        spacing = [h.cella.x / h.mx, h.cella.y / h.my, h.cella.z / h.mz]
        axes = [int(h.mapc) - 1, int(h.mapr) - 1, int(h.maps) - 1]
        steps = numpy.diag(spacing)[axes]
        if not origin.any():
            origin = numpy.array([h.nxstart, h.nystart, h.nzstart]) @ steps
        return volume(values, steps * 1e-7, origin * 1e-7)


# NumPy --------------------------------------------------------------------------------------------


def read_npy(path, step):
    values = numpy.load(path)
    # The order of the array in memory does not matter: the axes are z, y, x.
    return volume(values.reshape(values.shape[-3:]), numpy.diag([1, 1, 1]), [0, 0, 0])


# VTK's XML format: VTK -----------------------------------------------------------------------------


def vtk_result(image, cells, rectilinear):
    """The array density of an image or of a rectilinear grid with even spacing."""
    data = image.GetCellData() if cells else image.GetPointData()
    sizes = [n - (1 if cells else 0) for n in image.GetDimensions()]
    values = vtk_to_numpy(data.GetArray("density")).reshape(sizes[::-1])
    if rectilinear:
        axes = [image.GetXCoordinates(), image.GetYCoordinates(), image.GetZCoordinates()]
        axes = [vtk_to_numpy(axis).astype(float) for axis in axes]
        steps = numpy.diag([axis[1] - axis[0] for axis in axes])
        origin = numpy.array([axis[0] for axis in axes])
    else:
        matrix = image.GetDirectionMatrix()
        direction = numpy.array([[matrix.GetElement(i, k) for k in range(3)] for i in range(3)])
        steps = (direction * numpy.array(image.GetSpacing())).T
        low = numpy.array(image.GetExtent()[::2])
        origin = numpy.array(image.GetOrigin()) + low @ steps
    return volume(values, steps, origin + (steps.sum(0) / 2 if cells else 0))


def read_vtk_xml(path, step):
    kind = os.path.splitext(path)[1]
    reader = {
        ".vti": vtkIOXML.vtkXMLImageDataReader,
        ".pvti": vtkIOXML.vtkXMLPImageDataReader,
        ".vtr": vtkIOXML.vtkXMLRectilinearGridReader,
        ".pvtr": vtkIOXML.vtkXMLPRectilinearGridReader,
    }[kind]()
    if kind.startswith(".p"):
        raise Skipped("files of pieces need declarations of arrays, which the samples do not have")
    reader.SetFileName(path)
    reader.Update()
    image = reader.GetOutput()
    cells = image.GetPointData().GetArray("density") is None
    return vtk_result(image, cells, kind.endswith("vtr"))


READERS = {
    "Dicom": read_dicom,
    "Tiff": read_tiff,
    "Nrrd": read_nrrd,
    "Npy": read_npy,
    "Mrc": read_mrc,
    "VtkXml": read_vtk_xml,
}


def main():
    global mrcfile, numpy, pydicom, tifffile, vtkIOXML, vtk_to_numpy
    what = "python3-numpy"
    try:
        import numpy

        if sys.argv[1] == "Dicom":
            what = "python3-pydicom"
            import pydicom

            pydicom.config.settings.reading_validation_mode = pydicom.config.IGNORE
        if sys.argv[1] == "Tiff":
            what = "python3-tifffile"
            import tifffile
        if sys.argv[1] == "Mrc":
            what = "python3-mrcfile"
            import mrcfile
        if sys.argv[1] == "VtkXml":
            what = "python3-vtk9"
            from vtkmodules import vtkIOXML
            from vtkmodules.util.numpy_support import vtk_to_numpy
        if sys.argv[1] == "Nrrd":
            what = "teem-apps"
            subprocess.run(["teem-unu", "--help"], capture_output=True, check=False)
    except (ImportError, OSError):
        print(json.dumps({"absent": what}))
        return
    for line in sys.stdin:
        request = json.loads(line)
        try:
            result = READERS[sys.argv[1]](request["path"], request["step"])
        except Skipped as why:
            result = {"skipped": str(why)}
        print(json.dumps(result))


main()
