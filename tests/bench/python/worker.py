"""Answers the requests of python.bench.ts, one a line, by a number a line: mostly seconds."""

import sys
import time

import isosplat
import numpy as np

THREADS = 2


def make(path):
    """A volume of smooth surfaces and a little noise, kept in memory and saved."""
    global array
    axis = np.linspace(-6, 6, 512, dtype=np.float32)
    waves = np.cos(axis)[:, None, None] + np.sin(1.3 * axis)[:, None] + np.cos(0.7 * axis)
    noise = np.random.default_rng(1).integers(0, 16, waves.shape, np.uint16)
    array = (1000 * (waves + 3)).astype(np.uint16) + noise
    np.save(path, array)


def build(path):
    global store
    store = isosplat.build(array, path, threads=THREADS)


def points(isovalue):
    store.points(float(isovalue), threads=THREADS)


def isovalue():
    return float(store.suggested_isovalues[0])


for line in sys.stdin:
    name, *arguments = line.rstrip("\n").split("\t")
    begin = time.perf_counter()
    answer = {"make": make, "build": build, "points": points, "isovalue": isovalue}[name](*arguments)
    print(time.perf_counter() - begin if answer is None else answer, flush=True)
