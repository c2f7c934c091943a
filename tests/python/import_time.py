"""How long `import isosplat` takes, in new processes. The limit is 60 ms on a machine that is idle.

    PYTHONPATH=build/release/native/python/package /usr/bin/python3 tests/python/import_time.py
"""

import subprocess
import sys

RUNS = 15
LIMIT_SECONDS = 0.060


def seconds(statement):
    """The shortest of several times: other work can only add to it."""
    script = f"import time; begin = time.perf_counter(); {statement}; print(time.perf_counter() - begin)"
    return min(
        float(subprocess.run([sys.executable, "-c", script], check=True, capture_output=True).stdout)
        for _ in range(RUNS)
    )


def main():
    numpy, package = seconds("import numpy"), seconds("import isosplat")
    build = seconds("import isosplat; isosplat.build")
    print(f"numpy {1000 * numpy:.1f} ms")
    print(f"isosplat {1000 * package:.1f} ms: {package / numpy:.3f} of numpy")
    print(f"isosplat.build, with numpy {1000 * build:.1f} ms: {build / numpy:.2f} of numpy")
    if package > LIMIT_SECONDS:
        sys.exit(f"expected at most {1000 * LIMIT_SECONDS:.0f} ms")


if __name__ == "__main__":
    main()
