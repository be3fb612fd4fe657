from collections.abc import Sequence
from typing import Any, Optional, final

import numpy as np
import numpy.typing as npt

__all__ = [
    "__version__",
    "Buffered",
    "Elements",
    "analyse",
    "ascending",
    "contacts",
    "coordination",
    "csr",
    "draw",
    "explain",
    "labels",
    "main",
    "measure",
    "mesh",
    "nearest",
    "read",
    "verify",
    "within",
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
    ) -> Elements: ...

@final
class Buffered:
    def __new__(cls, buffer: float, engine: str, threads: int) -> Buffered: ...
    def update(self, elements: Elements) -> tuple[npt.NDArray[np.uint32], Optional[str]]: ...

def contacts(elements: Elements, engine: str, threads: int) -> _Found: ...
def verify(elements: Elements, pairs: npt.NDArray[np.uint32], sample: int, seed: int) -> tuple[int, Optional[str]]: ...
def explain(elements: Elements, engine: str, threads: int) -> str: ...
def measure(elements: Elements, pairs: npt.NDArray[np.uint32], shifts: npt.NDArray[np.int32], overlap: bool, threads: int) -> _Floats: ...
def analyse(
    elements: Elements,
    pairs: npt.NDArray[np.uint32],
    shifts: npt.NDArray[np.int32],
    min_contacts: Optional[int],
    inner: Optional[list[list[float]]],
    r_max: Optional[float],
    bins: Optional[int],
) -> tuple[str, npt.NDArray[np.uint32], npt.NDArray[np.uint32], npt.NDArray[np.bool_]]: ...
def draw(
    elements: Elements,
    pairs: npt.NDArray[np.uint32],
    shifts: npt.NDArray[np.int32],
    what: str,
    form: str,
    title: str,
    width: Optional[int],
) -> bytes: ...
def csr(elements: int, pairs: npt.NDArray[np.uint32], full: bool) -> _Rows: ...
def coordination(elements: int, pairs: npt.NDArray[np.uint32]) -> npt.NDArray[np.int64]: ...
def ascending(pairs: npt.NDArray[np.uint32], shifts: npt.NDArray[np.int32]) -> _Found: ...
def within(points: _Floats, at: _Floats, r: float, threads: int) -> _Neighbours: ...
def nearest(points: _Floats, at: _Floats, k: int, threads: int) -> _Neighbours: ...
def labels(image: npt.NDArray[Any], neighbourhood: str, background: Optional[int], spacing: Sequence[float], threads: int) -> dict[str, Any]: ...
def mesh(
    nodes: npt.NDArray[np.float64], cells: npt.NDArray[np.uint32], bodies: npt.NDArray[np.uint32], self_contact: bool, threads: int
) -> tuple[dict[str, Any], dict[str, Any]]: ...
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
