"""The part of the package that is in C++ (native/python). Its callers check the arguments."""

from typing import Any, Callable, Optional, Sequence, Tuple

import numpy as np
from numpy.typing import NDArray

version: str

class VoxelScan:
    @property
    def is_settled(self) -> bool: ...
    def add(self, other: VoxelScan) -> None: ...

class BuildCall:
    def __init__(
        self,
        *,
        target: bytes,
        title: str,
        units: str,
        max_error: float,
        range: Optional[Tuple[float, float]],
        threads: int,
        memory_bytes: int,
        overwrite: bool,
        progress: Optional[Callable[[float, str], object]],
        scan: Optional[VoxelScan],
    ) -> None: ...

class ArrayCall:
    @property
    def type(self) -> str: ...
    @property
    def z_is_fastest(self) -> bool: ...
    def __init__(
        self,
        *,
        type: str,
        big_endian: bool,
        shape: Sequence[int],
        z_is_fastest: bool,
        name: str,
        spacing: Sequence[float],
        origin: Sequence[float],
        direction: Sequence[float],
        notes: Sequence[str],
    ) -> None: ...

class FieldCall:
    def __init__(
        self, *, name: str, data: Any, read_count: int, array: ArrayCall, is_placed: bool
    ) -> None: ...

def build_array(
    data: Any, read_count: int, array: ArrayCall, call: BuildCall, fields: Sequence[FieldCall]
) -> None: ...
def scan_array(data: Any, read_count: int, array: ArrayCall, call: BuildCall) -> VoxelScan: ...
def build_file(path: bytes, spacing: Optional[Sequence[float]], call: BuildCall) -> None: ...

class Part:
    def __init__(self, *, level: int, box: Optional[Sequence[float]], threads: int) -> None: ...

class MeshData:
    @property
    def vertices(self) -> NDArray[np.float64]: ...
    @property
    def normals(self) -> NDArray[np.float32]: ...
    @property
    def triangles(self) -> NDArray[np.uint32]: ...
    @property
    def fields(self) -> list[Tuple[str, NDArray[np.float32]]]: ...
    def column_names(self, used: Sequence[str]) -> list[str]: ...
    def save(self, path: bytes, comment: str) -> None: ...

class StoreHandle:
    @property
    def is_open(self) -> bool: ...
    def close(self) -> None: ...
    def info(self) -> dict[str, Any]: ...
    def fields(self) -> list[dict[str, Any]]: ...
    def points(
        self, isovalue: float, part: Part, *, smooth: bool, exact: bool, fields: Sequence[str]
    ) -> Tuple[NDArray[np.float64], NDArray[np.float32], list[NDArray[np.float32]]]: ...
    def active_cells(self, isovalue: float, part: Part) -> NDArray[np.int32]: ...
    def read(self, part: Part, first: Sequence[int], values: NDArray[Any]) -> None: ...
    def bytes(self, isovalue: float, part: Part) -> int: ...
    def measures(self, isovalue: float, *, threads: int) -> Tuple[float, float]: ...
    def mesh(
        self,
        isovalue: float,
        part: Part,
        *,
        components: Optional[int],
        simplify_error: Optional[float],
        fields: Sequence[str],
    ) -> MeshData: ...

def read_png(path: bytes) -> NDArray[np.uint8]: ...
def open_store(path: bytes) -> StoreHandle: ...

class SceneHandle:
    @property
    def document(self) -> bytes: ...
    def store(self, path: str) -> StoreHandle: ...

def open_scene(path: bytes) -> Optional[SceneHandle]: ...
