"""Makes the HDF5 files of programs' conventions in the folder conventions beside this script: with
python3-h5py 3.7 and python3-netcdf4 1.6, HDF5 1.10.

usage: /usr/bin/python3 make_conventions.py

In every file, the voxel at x = 10 + 0.5·i, y = 20 + 2·j, z = 30 + 3·k (in the unit that the file
states) has the value 100·k + 10·j + i, for i < 5, j < 6, k < 7, whatever order its axes have.
tests/native/import_hdf5_conventions_test.cpp says how each is read.
"""

import json
import os
import struct

import h5py
import netCDF4
import numpy

SIZES = {"z": 7, "y": 6, "x": 5}
FIRST = {"z": 30.0, "y": 20.0, "x": 10.0}
STEP = {"z": 3.0, "y": 2.0, "x": 0.5}
folder = os.path.join(os.path.dirname(os.path.abspath(__file__)), "conventions")
os.makedirs(folder, exist_ok=True)


def voxels(order="zyx", kind="<i2"):
    z, y, x = numpy.indices([SIZES[axis] for axis in "zyx"])
    values = (100 * z + 10 * y + x).astype(kind)
    return values.transpose(["zyx".index(axis) for axis in order])


def positions(axis):
    return FIRST[axis] + STEP[axis] * numpy.arange(SIZES[axis])


def path_of(name):
    path = os.path.join(folder, name)
    if os.path.exists(path):
        os.remove(path)
    return path


def create(name, **options):
    return h5py.File(path_of(name), "w", **options)


def netcdf(name, order, kind="i2", with_positions=True, names=None, units="mm", **options):
    """A netCDF file, and its variable, which has no values yet."""
    file = netCDF4.Dataset(path_of(name), "w", format="NETCDF4")
    for axis in order:
        title = (names or {}).get(axis, axis)
        file.createDimension(title, SIZES.get(axis, 2))
        if with_positions and axis in SIZES:
            scale = file.createVariable(title, "f8", (title,))
            scale.units = units
            scale[:] = positions(axis)
    variable = file.createVariable("density", kind, [(names or {}).get(a, a) for a in order], **options)
    variable.set_auto_maskandscale(False)
    return file, variable


# netCDF-4 ----------------------------------------------------------------------------------------

file, data = netcdf("xyz.nc", "xyz")
data[:] = voxels("xyz")
file.close()

file, data = netcdf("descending.nc", "zyx")
for axis in "zy":
    file[axis][:] = positions(axis)[::-1]
data[:] = voxels()[::-1, ::-1]
file.close()

# More attributes and variables than their headers hold: they are in heaps.
file, data = netcdf("many.nc", "yxz", zlib=True, chunksizes=(3, 3, 3))
for i in range(12):
    data.setncattr(f"remark {i}", "a remark that takes some room " * (1 + i % 3))
    file.createVariable(f"series {i}", "f4", ("x",))[:] = positions("x")
data[:] = voxels("yxz")
file.close()

file, data = netcdf("time.nc", "tzyx", names={"t": "time"})
data[0] = voxels() * 0
data[1] = voxels()
file.close()

file, data = netcdf("unlimited.nc", "zyx", zlib=True)
file.close()
file = netCDF4.Dataset(path_of("unlimited.nc"), "w", format="NETCDF4")
for axis in "zyx":
    file.createDimension(axis, None if axis == "z" else SIZES[axis])
    scale = file.createVariable(axis, "f4", (axis,))
    scale.units = "mm"
    scale[:] = positions(axis)
data = file.createVariable("density", "i2", ("z", "y", "x"), zlib=True)
data[:] = voxels()
file.close()

# Unsigned numbers stored as signed ones; 65534 and 600 mark missing values.
file, data = netcdf("unsigned.nc", "zyx", fill_value=numpy.int16(-2))
data.setncattr("_Unsigned", "true")
data.missing_value = numpy.array([600, -3], "i2")
values = voxels().astype("u2")
values[0, 0, 0] = 65534
values[0, 0, 1] = 40000
data[:] = values.view("i2")
file.close()

# Packed values with a range.
file, data = netcdf("packed.nc", "zyx")
data.scale_factor = 0.5
data.add_offset = 10.0
data.valid_range = numpy.array([10, 640], "i2")
data[:] = voxels()
file.close()

# A fill value with more digits than the voxels have.
file, data = netcdf("lowest.nc", "zyx", kind="f4")
data.setncattr("missing_value", -3.39999999999999996e38)
values = voxels(kind="f4")
values[0, 0, 0] = numpy.float32(-3.4e38)
data[:] = values
file.close()

# CF: an ocean's temperature. Depths are positive downwards.
file, data = netcdf("depth.nc", "zyx", names={"z": "lev", "y": "lat", "x": "lon"}, units="m")
file["lev"].positive = "down"
file["lev"].axis = "Z"
file["lev"].standard_name = "depth"
data[:] = voxels()
file.close()

# h5py, NeXus, ilastik ------------------------------------------------------------------------------

with create("scales.h5") as file:
    data = file.create_dataset("group/volume", data=voxels("yzx"))
    for i, axis in enumerate("yzx"):
        scale = file.create_dataset(f"scale {axis}", data=positions(axis))
        scale.attrs["units"] = "mm"
        scale.make_scale(f"scale of {axis}")
        data.dims[i].attach_scale(scale)
        data.dims[i].label = axis

with create("labels.h5") as file:
    data = file.create_dataset("volume", data=voxels("xzy"))
    for i, axis in enumerate("xzy"):
        data.dims[i].label = axis

with create("nexus_2013.nxs") as file:
    group = file.create_group("entry/data")
    data = group.create_dataset("data", data=voxels("xyz"))
    data.attrs["signal"] = 1
    data.attrs["axes"] = "pos_x:pos_y:pos_z"
    for axis in "xyz":
        group.create_dataset(f"pos_{axis}", data=positions(axis)).attrs["units"] = "mm"

with create("named.h5") as file:
    data = file.create_dataset("volume", data=voxels())
    for i, name in enumerate(("energy", "theta", "phi")):
        data.dims[i].label = name

# VTK, ITK, Chimera ---------------------------------------------------------------------------------

with create("points.vtkhdf") as file:
    group = file.create_group("VTKHDF")
    group.attrs["Version"] = [1, 0]
    group.attrs.create("Type", b"ImageData", dtype="S9")
    group.attrs["WholeExtent"] = [2, 6, 0, 5, 1, 7]
    group.attrs["Spacing"] = [STEP[axis] for axis in "xyz"]
    group.attrs["Origin"] = [FIRST["x"] - 2 * STEP["x"], FIRST["y"], FIRST["z"] - STEP["z"]]
    group.attrs["Direction"] = numpy.eye(3).ravel()
    group.create_dataset("PointData/density", data=voxels())

# The array's x, y and z lie along the world's y, -z and -x: the columns of the matrix.
with create("turned.vtkhdf") as file:
    group = file.create_group("VTKHDF")
    group.attrs["Version"] = [2, 0]
    group.attrs.create("Type", b"ImageData", dtype="S9")
    group.attrs["WholeExtent"] = [0, 5, 0, 6, 0, 4]
    group.attrs["Spacing"] = [STEP["y"], STEP["z"], STEP["x"]]
    group.attrs["Origin"] = [FIRST["x"] + 4 * STEP["x"], FIRST["y"], FIRST["z"] + 6 * STEP["z"]]
    group.attrs["Direction"] = [0.0, 0, -1, 1, 0, 0, 0, -1, 0]
    turned = voxels("xzy")[::-1, ::-1]
    group.create_dataset("PointData/density", data=turned)

with create("cells.vtkhdf") as file:
    group = file.create_group("VTKHDF")
    group.attrs["Version"] = [1, 0]
    group.attrs.create("Type", b"ImageData", dtype="S9")
    group.attrs["WholeExtent"] = [0, 5, 0, 6, 0, 7]
    group.attrs["Spacing"] = [STEP[axis] for axis in "xyz"]
    group.attrs["Origin"] = [FIRST[axis] - STEP[axis] / 2 for axis in "xyz"]
    group.create_dataset("CellData/density", data=voxels())

# Two steps of time: the voxels of the first are 0.
with create("steps.vtkhdf") as file:
    group = file.create_group("VTKHDF")
    group.attrs["Version"] = [2, 0]
    group.attrs.create("Type", b"ImageData", dtype="S9")
    group.attrs["WholeExtent"] = [0, 4, 0, 5, 0, 6]
    group.attrs["Spacing"] = [STEP[axis] for axis in "xyz"]
    group.attrs["Origin"] = [FIRST[axis] for axis in "xyz"]
    group.create_dataset("PointData/density", data=numpy.stack([voxels() * 0, voxels()]))
    group.create_group("Steps").attrs["NSteps"] = 2
    group["Steps"]["Values"] = [0.25, 0.75]

with create("times.h5") as file:
    data = file.create_dataset("density", data=numpy.stack([voxels() * 0, voxels()]))
    for i, axis in enumerate("tzyx"):
        scale = file.create_dataset("time" if axis == "t" else axis,
                                    data=[6.0, 12.0] if axis == "t" else positions(axis))
        scale.attrs["units"] = "hours since 1900-01-01" if axis == "t" else "mm"
        scale.make_scale("time" if axis == "t" else axis)
        data.dims[i].attach_scale(scale)

with create("itk.hdf5") as file:
    group = file.create_group("ITKImage/0")
    # The array's x is the world's -y, its y the world's x.
    group["Dimension"] = numpy.array([6, 5, 7], "u8")
    group["Directions"] = numpy.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    group["Origin"] = [FIRST["x"], FIRST["y"] + 5 * STEP["y"], FIRST["z"]]
    group["Spacing"] = [STEP["y"], STEP["x"], STEP["z"]]
    group["VoxelType"] = "SHORT"
    group.create_dataset("VoxelData", data=voxels("zxy")[:, :, ::-1])
    file["ITKVersion"] = "5.3.0"

with create("chimera.cmap") as file:
    group = file.create_group("Chimera/image1")
    group.attrs["chimera_map_version"] = numpy.int64(1)
    group.attrs["chimera_version"] = numpy.bytes_("1.16")
    group.attrs["name"] = numpy.bytes_("map")
    group.attrs["step"] = numpy.array([STEP[axis] for axis in "xyz"], "f4")
    group.attrs["origin"] = numpy.array([FIRST[axis] for axis in "xyz"], "f4")
    group.create_dataset("data_zyx", data=voxels(), chunks=(4, 4, 4), compression="gzip")
    coarse = group.create_dataset("data_zyx_2", data=voxels()[::2, ::2, ::2])
    coarse.attrs["subsample_spacing"] = [2, 2, 2]

# Turned by 90° about z: the array's x is the world's y, its y the world's -x.
with create("turned.cmap") as file:
    group = file.create_group("Chimera/image1")
    group.attrs["step"] = [STEP["y"], STEP["x"], STEP["z"]]
    group.attrs["origin"] = [FIRST["x"] + 4 * STEP["x"], FIRST["y"], FIRST["z"]]
    group.attrs["cell_angles"] = [90.0, 90, 90]
    group.attrs["rotation_axis"] = [0.0, 0, 1]
    group.attrs["rotation_angle"] = 90.0
    group.create_dataset("data_zyx", data=voxels("zxy")[:, ::-1])

# Electron microscopy, openPMD, MATLAB ---------------------------------------------------------------

with create("berkeley.emd") as file:
    group = file.create_group("data/volume")
    group.attrs["emd_group_type"] = 1
    group.create_dataset("data", data=voxels("xzy"))
    for i, axis in enumerate("xzy"):
        dim = group.create_dataset(f"dim{i + 1}", data=positions(axis))
        dim.attrs["name"] = axis
        dim.attrs["units"] = "[n_m]"

with create("py4dstem.emd") as file:
    group = file.create_group("root/volume")
    group.attrs["emd_group_type"] = "array"
    group.create_dataset("data", data=voxels()).attrs["units"] = "counts"
    for i, axis in enumerate("zyx"):
        dim = group.create_dataset(f"dim{i}", data=positions(axis)[:2])
        dim.attrs["name"] = axis
        dim.attrs["units"] = "nm"

with create("velox.emd") as file:
    group = file.create_group("Data/Image/0123456789abcdef")
    group.create_dataset("Data", data=voxels("yxz"), chunks=(6, 5, 1))
    text = json.dumps({"BinaryResult": {
        "PixelSize": {"width": "5e-10", "height": "2e-09"},
        "PixelUnitX": "m", "PixelUnitY": "m"}}).encode()
    column = numpy.frombuffer(text.ljust(512, b"\0"), "u1")
    group.create_dataset("Metadata", data=numpy.repeat(column[:, None], 7, axis=1), chunks=(512, 1))

with create("openpmd.h5") as file:
    mesh = file.create_group("data/0/fields/E")
    mesh.attrs["axisLabels"] = ["y", "x", "z"]
    mesh.attrs["gridSpacing"] = [STEP[axis] for axis in "yxz"]
    mesh.attrs["gridGlobalOffset"] = [FIRST[axis] for axis in "yxz"]
    mesh.attrs["gridUnitSI"] = 1e-3
    mesh.attrs["dataOrder"] = "C"
    mesh.create_dataset("x", data=voxels("yxz")).attrs["position"] = [0.0, 0, 0]

with create("matlab.mat", userblock_size=512) as file:
    data = file.create_dataset("V", data=voxels("zxy"))
    data.attrs["MATLAB_class"] = numpy.bytes_("int16")
with open(os.path.join(folder, "matlab.mat"), "r+b") as file:
    text = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: Thu Jan  1 00:00:00 2026 HDF5 schema 1.00 ."
    file.write(text.ljust(116, b" ") + bytes(8) + struct.pack("<H", 0x0200) + b"IM")

# Image pyramids -------------------------------------------------------------------------------------


def letters(text):
    return numpy.frombuffer(text.encode(), "S1")


with create("imaris.ims") as file:
    file.attrs["DataSetDirectoryName"] = letters("DataSet")
    file.attrs["DataSetInfoDirectoryName"] = letters("DataSetInfo")
    image = file.create_group("DataSetInfo/Image")
    image.attrs["Unit"] = letters("um")
    for i, axis in enumerate("xyz"):
        image.attrs[axis.upper()] = letters(str(SIZES[axis]))
        low = FIRST[axis] - STEP[axis] / 2
        image.attrs[f"ExtMin{i}"] = letters(str(low))
        image.attrs[f"ExtMax{i}"] = letters(str(low + STEP[axis] * SIZES[axis]))
    for channel, name in enumerate(("DAPI", "GFP")):
        file.create_group(f"DataSetInfo/Channel {channel}").attrs["Name"] = letters(name)
    for level in range(2):
        for time in range(2):
            for channel in range(2):
                group = file.create_group(
                    f"DataSet/ResolutionLevel {level}/TimePoint {time}/Channel {channel}")
                fine = voxels(kind="<u2") if (time, channel) == (1, 1) else voxels(kind="<u2") * 0
                values = fine[:: level + 1, :: level + 1, :: level + 1]
                for axis, size in zip("ZYX", values.shape):
                    group.attrs[f"ImageSize{axis}"] = letters(str(size))
                padded = numpy.pad(values, [(0, -size % 8) for size in values.shape])
                group.create_dataset("Data", data=padded, chunks=(4, 8, 8), compression="gzip")
                group.create_dataset("Histogram", data=numpy.zeros(256, "u8"))

with create("bdv.h5") as file:
    for setup in range(2):
        file[f"s{setup:02}/resolutions"] = numpy.array([[1.0, 1, 1], [2, 2, 1]])
        file[f"s{setup:02}/subdivisions"] = numpy.array([[4, 4, 4], [4, 4, 4]], "<i4")
        for time in range(2):
            fine = voxels(kind="<u2") if (time, setup) == (1, 1) else voxels(kind="<u2") * 0
            if (time, setup) == (1, 1):
                fine[0, 0, 0] = 40000
            for level, values in enumerate((fine, fine[:, ::2, ::2])):
                values = numpy.ascontiguousarray(values)
                file.create_dataset(f"t{time:05}/s{setup:02}/{level}/cells", data=values.view("<i2"),
                                    chunks=(3, 3, 3), compression="gzip")
setups = "".join(
    f"<ViewSetup><id>{i}</id><voxelSize><unit>\u00b5m</unit><size>0.5 2.0 3.0</size></voxelSize></ViewSetup>"
    for i in range(2))
with open(path_of("bdv.xml"), "w", encoding="utf-8") as xml:
    xml.write(f"<SpimData><SequenceDescription><ViewSetups>{setups}</ViewSetups></SequenceDescription>"
              "<ViewRegistrations/></SpimData>\n")
