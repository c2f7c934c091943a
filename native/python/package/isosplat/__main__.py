"""`python -m isosplat ARGS…`: the program isosplat."""

from __future__ import annotations

import os
import signal
import sys
from typing import NoReturn

from ._program import find_program


def main() -> NoReturn:
    """Becomes the program isosplat: its exit status, output and signals are those of this process."""
    try:
        program = find_program()
    except FileNotFoundError as error:
        sys.exit(f"isosplat: {error}")
    # Python ignores these, and programs inherit that. The program sets what it needs.
    for name in ("SIGPIPE", "SIGXFSZ"):
        signal.signal(getattr(signal, name), signal.SIG_DFL)
    sys.stdout.flush()
    sys.stderr.flush()
    os.execv(program, ["isosplat", *sys.argv[1:]])


if __name__ == "__main__":
    main()
