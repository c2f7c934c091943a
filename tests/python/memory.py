"""Builds and opens 1,000 stores in one process, and shows 1,000 views. Its memory has to stay the same. It
takes minutes, so it is no part of `npm test`:

    PYTHONPATH=build/release/native/python/package /usr/bin/python3 tests/python/memory.py [COUNT]

Prints the resident memory and the number of open files after each tenth. Fails if memory grows by more
than 2 MB, or files by one, from the second tenth to the last. One mesh that is not freed has 6 MB.
"""

import gc
import os
import sys
import tempfile

import isosplat
import numpy as np

MAX_GROWTH_BYTES = 2 << 20


def resident_bytes():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGESIZE")


def open_files():
    return len(os.listdir("/proc/self/fd"))


def use(array, path):
    with isosplat.build(array, path, threads=2) as store:
        store.points(50)
        store.mesh(50).vertices.sum()
        store.read()
    again = isosplat.open(path)
    again.area(50)
    again.active_cells(50)


def show(_, path):
    view = isosplat.view(path)
    view._repr_html_()
    view.close()


def measure(name, action, count, array, path):
    """Whether memory and files stay the same while `action` runs `count` times."""
    measured = []
    for tenth in range(10):
        for _ in range(count // 10):
            action(array, path)
        gc.collect()
        measured.append((resident_bytes(), open_files()))
        print(f"{(tenth + 1) * (count // 10):6} {name}: {measured[-1][0] / 1e6:.1f} MB, "
              f"{measured[-1][1]} files", flush=True)
    growth = measured[-1][0] - measured[1][0]
    files = measured[-1][1] - measured[1][1]
    print(f"growth: {growth / 1e6:.2f} MB, {files} files")
    return growth <= MAX_GROWTH_BYTES and files <= 0


def main():
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    array = np.random.default_rng(1).integers(0, 99, (40, 40, 40)).astype(np.uint16)
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "a.isosplat")
        actions = {"stores": use, "views": show}
        flat = [measure(name, action, count, array, path) for name, action in actions.items()]
    if not all(flat):
        sys.exit("expected memory and files that stay the same")


if __name__ == "__main__":
    main()
