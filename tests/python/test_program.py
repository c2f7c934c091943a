"""python -m isosplat: the program isosplat."""

import os
import signal
import subprocess
import sys

import numpy as np
import pytest
from conftest import PROGRAM, run_program, sphere

# So that the tests also run where the package is not beside the program.
ENVIRONMENT = {**os.environ, "ISOSPLAT_PROGRAM": str(PROGRAM)}


def run_module(*arguments, **options):
    return subprocess.run(
        [sys.executable, "-m", "isosplat", *map(str, arguments)],
        capture_output=True,
        text=True,
        **{"env": ENVIRONMENT, **options},
    )


def test_it_prints_what_the_program_prints(store):
    run = run_module("info", store.path)
    assert (run.returncode, run.stderr) == (0, "")
    assert run.stdout == run_program("info", store.path)


@pytest.mark.parametrize(
    "arguments", [(), ("--no-such-option",), ("info", "/no/such/store"), ("info", "--help")]
)
def test_exit_status_and_messages_are_those_of_the_program(arguments):
    expected = subprocess.run([PROGRAM, *arguments], capture_output=True, text=True)
    run = run_module(*arguments)
    assert (run.returncode, run.stdout, run.stderr) == (
        expected.returncode,
        expected.stdout,
        expected.stderr,
    )


def test_arguments_that_are_no_text_arrive_unchanged(tmp_path):
    name = os.fsencode(tmp_path) + b"/sph\xe9re 1.npy"
    with open(name, "wb") as file:
        np.save(file, sphere())
    run = subprocess.run(
        [sys.executable, "-m", "isosplat", "build", name, "-o", tmp_path / "a.isosplat"],
        env=ENVIRONMENT,
    )
    assert run.returncode == 0 and (tmp_path / "a.isosplat").stat().st_size > 1000


@pytest.mark.parametrize("ending", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_program_and_leaves_no_file(ending, tmp_path):
    # 64 GiB of zeros, which take no memory: the build cannot end before.
    np.lib.format.open_memmap(
        tmp_path / "sparse.npy", "w+", np.uint16, shape=(1 << 15, 1024, 1024)
    ).flush()
    (tmp_path / "output").mkdir()
    process = subprocess.Popen(
        [sys.executable, "-m", "isosplat", "build", tmp_path / "sparse.npy"]
        + ["-o", tmp_path / "output/a.isosplat", "--range", "0,9"],
        env=ENVIRONMENT,
        stderr=subprocess.PIPE,
    )
    while not any((tmp_path / "output").iterdir()):
        assert process.poll() is None, process.stderr.read()
    process.send_signal(ending)
    process.communicate(timeout=120)
    assert process.returncode == -ending
    assert list((tmp_path / "output").iterdir()) == []


def test_a_reader_that_ends_early_ends_the_program():
    # Python ignores SIGPIPE; the program then would report an error of writing instead.
    first, second = os.pipe()
    os.close(first)
    run = subprocess.run(
        [sys.executable, "-m", "isosplat", "--help"],
        env=ENVIRONMENT,
        stdout=second,
        stderr=subprocess.PIPE,
    )
    os.close(second)
    assert run.returncode == -signal.SIGPIPE and run.stderr == b""


def test_a_program_that_is_missing_is_one_error():
    run = run_module("info", env={**ENVIRONMENT, "ISOSPLAT_PROGRAM": "/no/such/program"})
    assert run.returncode == 1 and run.stdout == ""
    assert run.stderr == (
        "isosplat: ISOSPLAT_PROGRAM: expected a program, found '/no/such/program': correct the "
        "variable\n"
    )
