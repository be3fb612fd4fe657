from collections.abc import Callable, Sequence
from typing import Any, Optional, final

import numpy as np
import numpy.typing as npt

__all__ = [
    "__version__",
    "Buffered",
    "DeviceCouples",
    "Elements",
    "Ready",
    "Run",
    "Frames",
    "Tensor",
    "Tree",
    "analyse",
    "ascending",
    "contacts",
    "contacts_on_device",
    "coordination",
    "csr",
    "dlpack_of_rows",
    "draw",
    "explain",
    "fields",
    "file",
    "labels",
    "main",
    "materials",
    "measure",
    "mesh",
    "nearest",
    "neighbor_list",
    "read",
    "sweep",
    "to_toml",
    "verify",
    "walls",
    "within",
    "within_cutoffs",
]

__version__: str

_Floats = npt.NDArray[Any]
_Found = tuple[npt.NDArray[np.uint32], npt.NDArray[np.int32]]
_Rows = tuple[npt.NDArray[np.int64], npt.NDArray[np.uint32], npt.NDArray[np.int64]]
_Neighbours = tuple[npt.NDArray[np.int64], npt.NDArray[np.uint32], _Floats]

@final
class Elements:
    def __new__(
        cls,
        points: _Floats,
        kind: str,
        size: float,
        others: Optional[_Floats],
        tolerance: float,
        groups: Optional[npt.NDArray[np.uint32]],
        cell: Optional[tuple[list[float], list[list[float]], list[bool]]],
        fingerprint: Optional[int] = None,
        cutoffs: Optional[list[tuple[int, int, float]]] = None,
    ) -> Elements: ...
    @property
    def fingerprint(self) -> int: ...

@final
class Tensor:
    def __new__(cls, capsule: Any) -> Tensor: ...
    @property
    def address(self) -> int: ...
    @property
    def device(self) -> list[int]: ...
    @property
    def typestr(self) -> str: ...
    @property
    def shape(self) -> list[int]: ...
    @property
    def strides(self) -> Optional[list[int]]: ...

@final
class DeviceCouples:
    def __len__(self) -> int: ...
    @property
    def device(self) -> int: ...
    @property
    def __cuda_array_interface__(self) -> dict[str, Any]: ...
    def __dlpack_device__(self) -> tuple[int, int]: ...
    def __dlpack__(
        self,
        *,
        stream: Optional[int] = None,
        max_version: Optional[tuple[int, int]] = None,
        dl_device: Optional[tuple[int, int]] = None,
        copy: Optional[bool] = None,
    ) -> Any: ...
    def numpy(self) -> npt.NDArray[np.int32]: ...

@final
class Buffered:
    def __new__(cls, buffer: float, engine: str, threads: int) -> Buffered: ...
    def update(self, elements: Elements) -> tuple[_Found, Optional[str]]: ...

@final
class Frames:
    def __new__(
        cls,
        bytes: bytes,
        name: str,
        format: Optional[str],
        columns: Optional[str],
        bodies: Optional[str],
        skip_bad_lines: bool,
    ) -> Frames: ...
    def __len__(self) -> int: ...
    def read(self, frame: int) -> dict[str, Any]: ...
@final
class Tree:
    def __new__(cls, points: npt.NDArray[np.float64], sides: Sequence[float], leaf: int) -> Tree: ...
    def nearest_one(self, at: npt.NDArray[np.float64], p: float, bound: float) -> tuple[float, int]: ...
    def within_one(self, at: npt.NDArray[np.float64], r: float, p: float) -> list[int]: ...
    def count_within_one(self, at: npt.NDArray[np.float64], r: float, p: float) -> int: ...
    def nodes(self) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]: ...
    def node_weights(self, weights: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]: ...
    def nearest(
        self, at: npt.NDArray[np.float64], k: int, p: float, bound: float, threads: int
    ) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]: ...
    def within(
        self, at: npt.NDArray[np.float64], r: npt.NDArray[np.float64], p: float, threads: int
    ) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64], npt.NDArray[np.float64]]: ...
    def count_within(
        self, at: npt.NDArray[np.float64], r: npt.NDArray[np.float64], p: float, threads: int
    ) -> npt.NDArray[np.int64]: ...
    def count_pairs(
        self,
        other: Tree,
        r: npt.NDArray[np.float64],
        p: float,
        weights: Optional[npt.NDArray[np.float64]],
        other_weights: Optional[npt.NDArray[np.float64]],
    ) -> npt.NDArray[np.float64]: ...

@final
class Ready:
    def __new__(cls, text: Optional[str], name: str, place: str) -> Ready: ...
    @property
    def text(self) -> str: ...
    def about(self) -> dict[str, Any]: ...

@final
class Run:
    def __new__(cls, model: Ready, threads: int, earlier: Optional[str]) -> Run: ...
    @staticmethod
    def resume(path: str, threads: int) -> Run: ...
    def advance(self, steps: int) -> None: ...
    @property
    def is_over(self) -> bool: ...
    @property
    def stage(self) -> Optional[str]: ...
    @property
    def told(self) -> list[str]: ...
    @property
    def text(self) -> str: ...
    @property
    def steps(self) -> int: ...
    @property
    def total(self) -> int: ...
    @property
    def time(self) -> float: ...
    @property
    def time_step(self) -> float: ...
    @property
    def threads(self) -> int: ...
    @property
    def state_hash(self) -> str: ...
    def about(self) -> dict[str, Any]: ...
    def snapshot(self) -> dict[str, Any]: ...
    def forces(self) -> dict[str, Any]: ...
    def energies(self) -> list[tuple[str, float]]: ...
    def counts(self) -> list[tuple[str, int]]: ...
    def boundary_forces(self) -> dict[str, npt.NDArray[np.float64]]: ...
    def set_velocities(self, nodes: npt.NDArray[np.uint32], vectors: npt.NDArray[np.float64]) -> None: ...
    def set_forces(self, nodes: npt.NDArray[np.uint32], vectors: npt.NDArray[np.float64]) -> None: ...
    def add_spheres(
        self,
        places: npt.NDArray[np.float64],
        radii: npt.NDArray[np.float64],
        motion: Sequence[npt.NDArray[np.float64]],
        numbers: Sequence[int],
    ) -> npt.NDArray[np.uint32]: ...
    def set_sphere_law(
        self,
        function: Callable[[dict[str, Any]], tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]],
        numbers: tuple[float, int],
        replaces: bool,
    ) -> None: ...
    def clear_sphere_law(self) -> None: ...
    def sphere_names(self) -> list[list[str]]: ...
    def clear_forces(self) -> None: ...
    def set_boundary(self, number: int, factor: Optional[float]) -> None: ...
    def save(self, path: str) -> None: ...
    def field(self, name: str, at: Optional[str]) -> npt.NDArray[Any]: ...
    def picture(self, field: Optional[str], width: Optional[int]) -> bytes: ...

def fields() -> list[dict[str, Any]]: ...

def sweep(
    text: str,
    name: str,
    place: str,
    output: Optional[str],
    processes: Optional[int],
    threads: Optional[int],
    most: Optional[int],
    force: bool,
    skip_refused: bool,
    quiet: bool,
    program: list[str],
) -> str: ...
def materials() -> list[tuple[str, list[tuple[str, float]]]]: ...
def to_toml(tables: dict[str, Any]) -> str: ...
def contacts(elements: Elements, engine: str, threads: int, device: str) -> _Found: ...
def contacts_on_device(elements: dict[str, Any], waits: bool) -> DeviceCouples: ...
def dlpack_of_rows(rows: list[list[int]]) -> Any: ...
def verify(elements: Elements, pairs: npt.NDArray[np.uint32], sample: int, seed: int) -> tuple[int, Optional[str]]: ...
def explain(elements: Elements, engine: str, threads: int) -> str: ...
def within_cutoffs(elements: Elements, pairs: npt.NDArray[np.uint32], shifts: npt.NDArray[np.int32]) -> _Found: ...
def measure(elements: Elements, pairs: npt.NDArray[np.uint32], shifts: npt.NDArray[np.int32], overlap: bool, threads: int) -> _Floats: ...
def analyse(
    elements: Elements,
    pairs: npt.NDArray[np.uint32],
    shifts: npt.NDArray[np.int32],
    min_contacts: Optional[int],
    inner: Optional[list[list[float]]],
    r_max: Optional[float],
    bins: Optional[int],
    voids: bool,
) -> tuple[str, npt.NDArray[np.uint32], npt.NDArray[np.uint32], npt.NDArray[np.bool_], Optional[npt.NDArray[np.float64]]]: ...
def file(elements: Elements, pairs: npt.NDArray[np.uint32], shifts: npt.NDArray[np.int32], name: str) -> bytes: ...
def draw(
    elements: Elements,
    pairs: npt.NDArray[np.uint32],
    shifts: npt.NDArray[np.int32],
    what: str,
    form: str,
    title: str,
    width: Optional[int],
) -> bytes: ...
def neighbor_list(
    elements: Elements,
    quantities: str,
    cutoff: float,
    kinds: Optional[npt.NDArray[np.uint32]],
    table: Optional[npt.NDArray[np.float64]],
    edges: list[list[float]],
    self_interaction: bool,
    threads: int,
) -> tuple[
    Optional[npt.NDArray[np.int64]],
    Optional[npt.NDArray[np.int64]],
    Optional[npt.NDArray[np.float64]],
    Optional[npt.NDArray[np.float64]],
    Optional[npt.NDArray[np.int64]],
]: ...
def csr(elements: int, pairs: npt.NDArray[np.uint32], full: bool) -> _Rows: ...
def coordination(elements: int, pairs: npt.NDArray[np.uint32]) -> npt.NDArray[np.int64]: ...
def ascending(pairs: npt.NDArray[np.uint32], shifts: npt.NDArray[np.int32]) -> _Found: ...
def within(points: _Floats, at: _Floats, r: float, threads: int) -> _Neighbours: ...
def nearest(points: _Floats, at: _Floats, k: int, threads: int) -> _Neighbours: ...
def labels(image: npt.NDArray[Any], neighbourhood: str, background: Optional[int], spacing: Sequence[float], threads: int) -> dict[str, Any]: ...
def mesh(
    nodes: npt.NDArray[np.float64], cells: npt.NDArray[np.uint32], bodies: npt.NDArray[np.uint32], self_contact: bool, threads: int
) -> tuple[dict[str, Any], dict[str, Any]]: ...
def walls(
    centres: npt.NDArray[np.float64],
    radii: npt.NDArray[np.float64],
    nodes: npt.NDArray[np.float64],
    cells: npt.NDArray[np.uint32],
    bodies: npt.NDArray[np.uint32],
    threads: int,
) -> dict[str, Any]: ...
def read(
    bytes: bytes,
    name: str,
    format: Optional[str],
    frame: Optional[int],
    columns: Optional[str],
    bodies: Optional[str],
    skip_bad_lines: bool,
) -> tuple[str, dict[str, Any]]: ...
def main(arguments: list[str]) -> int: ...
