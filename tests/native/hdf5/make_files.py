"""Makes the HDF5 files beside this script, with HDF5's own library: python3-h5py 3.7, HDF5 1.10.

usage: /usr/bin/python3 make_files.py

Every voxel is 100·z + 10·y + x. The files are kept, since other versions of the library write other
bytes; tests/native/import_hdf5_test.cpp says what each of them must be read as.
"""

import os
import struct

import h5py
import numpy

SIZES = (7, 6, 5)
folder = os.path.dirname(os.path.abspath(__file__))


def voxels(sizes=SIZES, kind="<i2"):
    z, y, x = numpy.indices(sizes)
    return (100 * z + 10 * y + x).astype(kind)


def create(name, **options):
    path = os.path.join(folder, name + ".h5")
    if os.path.exists(path):
        os.remove(path)
    return h5py.File(path, "w", **options)


with create("contiguous") as file:
    data = file.create_dataset("volume", data=voxels())
    data.attrs["element_size_um"] = numpy.array([3.0, 2.0, 0.5], "<f4")

with create("filtered") as file:
    file.create_dataset("volume", data=voxels(kind="<u2"), chunks=(4, 4, 4), compression="gzip",
                        shuffle=True, fletcher32=True)

with create("user_block", userblock_size=512) as file:
    file.create_dataset("volume", data=voxels(kind=">f4"), chunks=(3, 6, 5), compression="gzip")

# The format of HDF5 1.10: checksums, and other indices of chunks.
with create("latest_fixed", libver="latest") as file:
    file.create_dataset("volume", data=voxels(), chunks=(4, 4, 4), compression="gzip", shuffle=True)
with create("latest_plain", libver="latest") as file:
    file.create_dataset("volume", data=voxels(), chunks=(4, 4, 4))
with create("latest_single", libver="latest") as file:
    file.create_dataset("volume", data=voxels(), chunks=SIZES, compression="gzip")
with create("latest_pages", libver="latest") as file:
    file.create_dataset("volume", data=voxels((12, 10, 10)), chunks=(1, 1, 1))
with create("latest_implicit", libver="latest") as file:
    kept = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    kept.set_chunk((4, 4, 4))
    kept.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    data = h5py.h5d.create(file.id, b"volume", h5py.h5t.STD_I16LE,
                           h5py.h5s.create_simple(SIZES), kept)
    h5py.Dataset(data)[...] = voxels()

with create("compact") as file:
    kept = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    kept.set_layout(h5py.h5d.COMPACT)
    data = h5py.h5d.create(file.id, b"volume", h5py.h5t.STD_I16LE,
                           h5py.h5s.create_simple(SIZES), kept)
    h5py.Dataset(data)[...] = voxels()

# An array that can grow, of which two chunks of eight are written.
with create("sparse") as file:
    data = file.create_dataset("volume", SIZES, "<i4", chunks=(4, 4, 4), fillvalue=-7,
                               maxshape=(None, None, None))
    data[0:4, 0:4, 0:4] = voxels()[0:4, 0:4, 0:4]
    data[4:7, 4:6, 0:4] = voxels()[4:7, 4:6, 0:4]

with create("several") as file:
    group = file.create_group("a/b")
    group.create_dataset("half", data=voxels(kind="<f2"))
    group.create_dataset("long", data=voxels(kind=">i8"))
    file.create_dataset("mask", data=voxels() % 2 == 1)
    file.create_dataset("image", data=voxels()[0])
    file.create_dataset("name", data="scan")
    file.create_dataset("colours", data=numpy.zeros((3, 4, 5, 3), "u1"))
    file["again"] = file["mask"]
    file["a/up"] = file["a"]  # a cycle
    file["soft"] = h5py.SoftLink("/a/b/half")

# NeXus: the file names its default; the axes have positions.
with create("nexus") as file:
    file.attrs["default"] = "entry"
    entry = file.create_group("entry")
    entry.attrs["default"] = "data"
    data = entry.create_group("data")
    data.attrs["signal"] = "counts"
    data.attrs["axes"] = ["z", "y", "x"]
    data.create_dataset("counts", data=voxels(kind="<u2"), chunks=(1, 6, 5))
    data.create_dataset("errors", data=voxels(kind="<f4"))
    for axis, (size, first, step) in zip("zyx", ((7, -3, 0.5), (6, 10, 0.25), (5, 0, 2))):
        positions = data.create_dataset(axis, data=(first + step * numpy.arange(size)).astype("f4"))
        positions.attrs["units"] = "um" if axis == "z" else "mm"

# ilastik: the axes are named in an attribute; the channel is one.
with create("ilastik") as file:
    data = file.create_dataset("exported_data", data=voxels().transpose(2, 1, 0)[..., None],
                               chunks=(3, 3, 3, 1), compression="gzip")
    data.attrs["axistags"] = ('{"axes": [{"key": "x", "typeFlags": 2}, {"key": "y", "typeFlags": 2}, '
                              '{"key": "z", "typeFlags": 2}, {"key": "c", "typeFlags": 1}]}')

# netCDF (CF): packed values, one of which marks missing values.
with create("packed") as file:
    data = file.create_dataset("volume", data=voxels())
    data.attrs["scale_factor"] = 0.5
    data.attrs["add_offset"] = 10.0
    data.attrs["_FillValue"] = numpy.int16(624)

# Longer headers: attributes in a block of their own.
with create("continued") as file:
    data = file.create_dataset("volume", data=voxels())
    for i in range(6):
        data.attrs[f"note {i}"] = "x" * 300
    data.attrs["element_size_um"] = [1000.0, 2000.0, 3000.0]

# Other compression.
with create("lzf") as file:
    file.create_dataset("volume", data=voxels(), chunks=(4, 4, 4), compression="lzf")


def lz4(content):
    """The filter LZ4 with two blocks: the first has a copy that overlaps itself, the second is not compressed."""
    half = len(content) // 2
    out = struct.pack(">QI", len(content), half)
    first, second = content[:half], content[half:]
    # If at least 10 equal bytes end the block: literals, a copy of one byte, and 6 literals.
    end = len(first.rstrip(first[-1:])) + 1
    if len(first) - end >= 10:
        literals, copy = first[:end], len(first) - end - 6
        block = bytes([15 << 4 | min(copy - 4, 15)]) + bytes([len(literals) - 15])
        block += literals + struct.pack("<H", 1)
        if copy - 4 >= 15:
            block += bytes([copy - 4 - 15])
        block += bytes([6 << 4]) + first[-6:]
    else:
        block = first
    return out + struct.pack(">I", len(block)) + block + struct.pack(">I", len(second)) + second


with create("lz4") as file:
    kept = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    kept.set_chunk((4, 6, 5))
    kept.set_filter(32004, h5py.h5z.FLAG_OPTIONAL, (0,))
    data = h5py.h5d.create(file.id, b"volume", h5py.h5t.STD_U8LE,
                           h5py.h5s.create_simple(SIZES), kept)
    chunks = numpy.zeros((8, 6, 5), "u1")
    chunks[:7] = voxels() // 100
    for i in range(2):
        data.write_direct_chunk((4 * i, 0, 0), lz4(chunks[4 * i:4 * i + 4].tobytes()))

# Arrays that can grow, in the format of HDF5 1.10.
with create("growing", libver="latest") as file:
    file.create_dataset("volume", data=voxels(), chunks=(4, 4, 4), maxshape=(None, 6, 5))
with create("growing_rows", libver="latest") as file:
    file.create_dataset("volume", data=voxels(), chunks=(1, 1, 2), maxshape=(8, None, 9),
                        compression="lzf")
with create("growing_all", libver="latest") as file:
    file.create_dataset("volume", data=voxels(), chunks=(1, 2, 2), maxshape=(None, None, 9),
                        compression="gzip", shuffle=True)
with create("growing_plain", libver="latest") as file:
    file.create_dataset("volume", data=voxels(), chunks=(1, 1, 5), maxshape=(None, None, None))
with create("limited", libver="latest") as file:
    file.create_dataset("volume", data=voxels(), chunks=(4, 4, 4), maxshape=(14, 12, 5))

# More links and attributes than their headers hold.
with create("heaps", libver="latest") as file:
    for i in range(40):
        file.create_dataset(f"number {i}", data=numpy.uint8(i))
    data = file.create_dataset("volume", data=voxels())
    for i in range(20):
        data.attrs[f"remark {i}"] = "a remark that takes some room " * (i % 7)
    data.attrs["element_size_um"] = [3.0, 2.0, 0.5]

# Files that are refused.
with create("complex") as file:
    file.create_dataset("volume", data=voxels().astype("c8"))
with create("flat") as file:
    file.create_dataset("image", data=voxels()[0])
with create("steps") as file:
    file.create_dataset("volume", data=numpy.stack([voxels(), voxels()]))
with create("unwritten") as file:
    file.create_dataset("volume", SIZES, "<i2")
with create("empty") as file:
    file.create_group("group")
with create("minc") as file:
    file.create_dataset("minc-2.0/image/0/image", data=voxels())
with create("szip") as file:
    kept = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    kept.set_chunk((4, 6, 5))
    kept.set_filter(4, h5py.h5z.FLAG_OPTIONAL, (4, 16))
    h5py.h5d.create(file.id, b"volume", h5py.h5t.STD_U8LE, h5py.h5s.create_simple(SIZES), kept)
layout = h5py.VirtualLayout(SIZES, "<i2")
layout[...] = h5py.VirtualSource("contiguous.h5", "volume", SIZES)
with create("virtual", libver="latest") as file:
    file.create_virtual_dataset("volume", layout)
