#!/usr/bin/python3
"""Writes a mesh of at least N tetrahedra as .vtu (appended, raw, as ParaView writes it).

    write_tetrahedra.py N FILE

A lattice of cubes with an edge of 1 in total, whose inner points are moved by up to 0.2 edges along
each axis, each cube divided into 6 tetrahedra. A crack, a gap of 1/50 of an edge, parts
the middle of the mesh. The values are those of a gyroid of 4 periods and a slower wave.
"""

import sys

import numpy as np

# The divisions of a cube along its diagonal (Kuhn): neighbours share the diagonals of faces.
PATHS = [(0, 1, 3, 7), (0, 5, 1, 7), (0, 3, 2, 7), (0, 2, 6, 7), (0, 4, 5, 7), (0, 6, 4, 7)]
CUBES_AT_ONCE = 1 << 18


def positions(n):
    """The points of a lattice of n cubes along each axis, x fastest, with moved inner points."""
    at = np.arange(n + 1, dtype=np.float64)
    z, y, x = np.meshgrid(at, at, at, indexing="ij")
    points = np.stack([x, y, z], axis=-1)
    moves = np.random.default_rng(1).uniform(-0.2, 0.2, points.shape)
    inner = (points > 0) & (points < n)
    return ((points + moves * inner) / n).reshape(-1, 3)


def field(p):
    x, y, z = (p * (8 * np.pi)).T
    gyroid = np.sin(x) * np.cos(y) + np.sin(y) * np.cos(z) + np.sin(z) * np.cos(x)
    return gyroid + 0.5 * np.sin(x / 5 + y / 7) * np.cos(z / 6)


def corners_of(cubes, n):
    """The eight corners of cubes, by bits for x, y and z."""
    x, y, z = cubes % n, cubes // n % n, cubes // (n * n)
    first = x + (n + 1) * (y + (n + 1) * z)
    steps = [(i & 1) + (n + 1) * ((i >> 1 & 1) + (n + 1) * (i >> 2)) for i in range(8)]
    return first[:, None] + np.array(steps)


def opened(points, n):
    """Doubles the points of a crack: half of the plane in the middle along x.

    Returns the points, and the new number of each point for cubes beyond the crack."""
    rows = np.arange(points.shape[0])
    x, y = rows % (n + 1), rows // (n + 1) % (n + 1)
    in_crack = (x == n // 2) & (y > n // 4) & (y < n - n // 4)
    others = rows.copy()
    others[in_crack] = points.shape[0] + np.arange(in_crack.sum())
    beyond = points[in_crack].copy()
    beyond[:, 0] += 0.02 / n
    return np.concatenate([points, beyond]), others


def main():
    n = int(np.ceil((int(sys.argv[1]) / 6) ** (1 / 3)))
    points, others = opened(positions(n), n)
    count = 6 * n**3
    values = field(points).astype("<f4")
    points = points.astype("<f4")
    sizes = {
        "values": values.nbytes,
        "points": points.nbytes,
        "connectivity": count * 32,
        "offsets": count * 8,
        "types": count,
    }
    at = dict(zip(sizes, np.cumsum([0] + [size + 8 for size in sizes.values()])))
    array = '<DataArray type="{}" Name="{}" NumberOfComponents="{}" format="appended" offset="{}"/>'
    header = "\n".join(
        [
            '<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian"'
            ' header_type="UInt64">',
            "<UnstructuredGrid>",
            f'<Piece NumberOfPoints="{len(points)}" NumberOfCells="{count}">',
            '<PointData Scalars="values">',
            array.format("Float32", "values", 1, at["values"]),
            "</PointData>",
            "<Points>",
            array.format("Float32", "Points", 3, at["points"]),
            "</Points>",
            "<Cells>",
            array.format("Int64", "connectivity", 1, at["connectivity"]),
            array.format("Int64", "offsets", 1, at["offsets"]),
            array.format("UInt8", "types", 1, at["types"]),
            "</Cells></Piece></UnstructuredGrid>",
            '<AppendedData encoding="raw">',
            "_",
        ]
    )
    with open(sys.argv[2], "wb") as file:

        def begin(name):
            file.write(np.uint64(sizes[name]).tobytes())

        file.write(header.encode())
        begin("values")
        file.write(values)
        begin("points")
        file.write(points)
        begin("connectivity")
        for first in range(0, n**3, CUBES_AT_ONCE):
            cubes = np.arange(first, min(first + CUBES_AT_ONCE, n**3))
            corners = corners_of(cubes, n)
            beyond = cubes % n >= n // 2
            corners[beyond] = others[corners[beyond]]
            file.write(corners[:, np.array(PATHS)].astype("<i8").tobytes())
        begin("offsets")
        for first in range(0, count, CUBES_AT_ONCE):
            last = min(first + CUBES_AT_ONCE, count)
            file.write((4 * np.arange(first + 1, last + 1)).astype("<i8"))
        begin("types")
        file.write(np.full(count, 10, np.uint8))
        file.write(b"</AppendedData></VTKFile>\n")
    print(count)


main()
