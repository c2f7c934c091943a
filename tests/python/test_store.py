"""isosplat.open and Store: properties and surfaces, against brute force and the program."""

import http.server
import io
import subprocess
import sys
import threading

import isosplat
import numpy as np
import pytest
from conftest import run_program, sphere


def brute_force_cells(array, isovalue):
    """The active cells of an array: min ≤ isovalue < max over eight voxels. (x, y, z)."""
    corners = [
        array[z : z - 1 or None, y : y - 1 or None, x : x - 1 or None]
        for z in (0, 1)
        for y in (0, 1)
        for x in (0, 1)
    ]
    active = (np.min(corners, axis=0) <= isovalue) & (isovalue < np.max(corners, axis=0))
    return np.argwhere(active)[:, ::-1]


def in_order(rows):
    return rows[np.lexsort(rows.T)]


@pytest.mark.parametrize("isovalue", [0, 30, 45.5, 1000])
def test_active_cells_are_those_of_brute_force(isovalue, tmp_path):
    array = sphere((20, 70, 90))
    store = isosplat.build(array, tmp_path / "a.isosplat")
    cells = store.active_cells(isovalue)
    assert cells.dtype == np.int32 and cells.shape[1] == 3
    assert np.array_equal(in_order(cells), in_order(brute_force_cells(array, isovalue)))
    assert len(store.points(isovalue).positions) == len(cells)


def test_points_are_those_of_the_program(store, tmp_path):
    for ours, flags in [
        (store.points(45), []),
        (store.points(45, 1), ["--level", "1"]),
        (store.points(45, normals="cell", exact=True), ["--shading", "exact", "--exact"]),
        (store.points(45, box=((5, 5, 5), (20, 30, 40))), ["--box", "5,5,5,20,30,40"]),
        (store.points(45, box=(5, 5, 5, 20, 30, 40), threads=1), ["--box", "5,5,5,20,30,40"]),
    ]:
        out = str(tmp_path / "points.npz")
        run_program("extract", store.path, "-i", "45", "-o", out, "--force", *flags)
        theirs = np.load(out)
        assert len(ours.positions) > 50
        assert np.array_equal(ours.positions.astype(theirs["positions"].dtype), theirs["positions"])
        assert np.array_equal(ours.normals, theirs["normals"])
        assert ours.positions.flags.writeable and ours.positions.flags.c_contiguous


@pytest.mark.parametrize("suffix", "glb ply stl obj 3mf npz".split())
def test_meshes_are_those_of_the_program(suffix, store, tmp_path):
    ours, theirs = tmp_path / f"ours.{suffix}", tmp_path / f"theirs.{suffix}"
    mesh = store.mesh(45, components=1, simplify=0.2)
    mesh.save(ours)
    how = "-i 45 --mesh --open --largest --simplify 0.2 -o".split()
    run_program("extract", store.path, *how, str(theirs))

    def content(path):
        # The comment writes the isovalue as 45.0, and without the level.
        return [line for line in path.read_bytes().split(b"\n") if b"isosurface" not in line]

    if suffix in ("ply", "obj"):
        assert content(ours) == content(theirs)
    elif suffix == "npz":
        one, other = np.load(ours), np.load(theirs)
        assert all(np.array_equal(one[key], other[key]) for key in other.files)
    else:
        assert abs(ours.stat().st_size - theirs.stat().st_size) < 64
    mesh.save(ours)  # replaces its own file


def test_meshes_are_closed_and_their_arrays_outlive_them(store):
    mesh = store.mesh(45)
    vertices, triangles, normals = mesh.vertices, mesh.triangles, mesh.normals
    store.close()
    del mesh
    assert vertices.dtype == np.float64 and normals.dtype == np.float32
    assert triangles.dtype == np.uint32 and triangles.max() == len(vertices) - 1
    edges = np.concatenate([triangles[:, [i, (i + 1) % 3]] for i in range(3)]).astype(np.int64)
    forth = edges[:, 0] << 32 | edges[:, 1]
    back = edges[:, 1] << 32 | edges[:, 0]
    assert np.array_equal(np.sort(forth), np.sort(back))
    assert np.linalg.norm(normals, axis=1) == pytest.approx(1, abs=1e-5)
    with pytest.raises(ValueError):
        vertices[0] = 0


def test_area_and_volume_are_those_of_the_triangles(store):
    mesh = store.mesh(45)
    corners = mesh.vertices[mesh.triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert store.area(45) == pytest.approx(np.linalg.norm(cross, axis=1).sum() / 2, rel=1e-5)
    # Values grow outwards: what is below the isovalue is inside of the closed surface.
    inside = abs(np.einsum("ij,ij->i", corners[:, 0], cross).sum() / 6)
    z, y, x = (size - 1 for size in store.shape)
    grid = x * y * z * np.prod(store.spacing)
    assert store.volume(45) == pytest.approx(grid - inside, rel=1e-5)
    assert store.area(45, threads=1) == store.area(45, threads=3)


def test_volume_needs_all_voxels(tmp_path):
    array = sphere().astype(np.float32)
    array[5, 5, 5] = np.nan
    store = isosplat.build(array, tmp_path / "a.isosplat")
    assert store.area(45) > 0
    with pytest.raises(ValueError, match="without missing voxels, found 1"):
        store.volume(45)


def test_properties(store):
    array = sphere()
    assert store.shape == array.shape and store.dtype == np.uint16
    assert store.value_range == (array.min(), array.max()) and store.max_error == 0
    assert store.levels == 2 and store.missing_voxels == 0
    counts, edges = store.histogram
    assert counts.sum() == array.size and len(edges) == len(counts) + 1
    assert all(array.min() < v < array.max() for v in store.suggested_isovalues)
    assert len(store.suggested_isovalues) > 0
    assert 0 < store.bytes(45) < store.file_bytes and store.bytes(1e9) == 0
    assert store.bytes(45, level=1) < store.bytes(45)
    assert np.array_equal(np.diag(store.affine), (1, 2, 3, 1))
    assert len(store.content_id) == 32 and "28 × 24 × 20" in repr(store)


def test_no_surface_gives_empty_arrays(store):
    points, mesh = store.points(1e6), store.mesh(1e6)
    shapes = [a.shape for a in (*points, mesh.vertices, mesh.normals, mesh.triangles)]
    assert shapes == [(0, 3)] * 5 and store.active_cells(1e6).shape == (0, 3)
    assert store.area(1e6) == 0


def test_stores_can_be_closed(store):
    with store:
        assert not store.closed
    assert store.closed and "closed" in repr(store)
    store.close()
    with pytest.raises(ValueError, match="closed"):
        store.points(45)


@pytest.fixture
def served(tmp_path, store):
    """The address of the folder on a server that knows ranges: the program's."""
    serve = subprocess.Popen(
        [sys.executable, "-c", RANGE_SERVER, str(tmp_path)], stdout=subprocess.PIPE, text=True
    )
    yield f"http://127.0.0.1:{int(serve.stdout.readline())}"
    serve.kill()
    serve.wait()


RANGE_SERVER = """
import http.server, os, sys
os.chdir(sys.argv[1])
class Ranges(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    def log_message(self, *_): pass
    def do_HEAD(self): self.do_GET()
    def do_GET(self):
        try:
            data = open("." + self.path, "rb").read()
        except OSError:
            self.send_response(404)
            self.send_header("Content-Length", "0")
            return self.end_headers()
        first, last, total = 0, len(data) - 1, len(data)
        wanted = self.headers.get("Range")
        if wanted:
            first, last = (int(n) if n else total - 1 for n in wanted[6:].split("-"))
            last = min(last, total - 1)
        body = data[first:last + 1]
        self.send_response(206 if wanted else 200)
        self.send_header("Content-Length", str(len(body)))
        self.send_header("ETag", '"1"')
        if wanted: self.send_header("Content-Range", f"bytes {first}-{last}/{total}")
        self.end_headers()
        if self.command == "GET": self.wfile.write(body)
server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Ranges)
print(server.server_port, flush=True)
server.serve_forever()
"""


def test_addresses_are_read_by_ranges(served, store):
    remote = isosplat.open(f"{served}/sphere.isosplat")
    assert remote.content_id == store.content_id
    assert np.array_equal(remote.points(45).positions, store.points(45).positions)
    with pytest.raises(OSError, match="404"):
        isosplat.open(f"{served}/none.isosplat")


def test_a_forked_process_opens_addresses_itself(served):
    code = f"""
import os, isosplat
remote = isosplat.open("{served}/sphere.isosplat")
child = os.fork()
if child == 0:
    try:
        remote.points(45)
    except RuntimeError as error:
        os._exit(7 if "parent process" in str(error) else 8)
    os._exit(9)
assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
"""
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)
