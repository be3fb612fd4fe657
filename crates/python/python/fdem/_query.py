"""Elements around points."""

from __future__ import annotations

from typing import Any, NamedTuple, Optional

import numpy as np
import numpy.typing as npt

from . import _fdem
from ._contacts import contacts
from ._input import Floats, alike, is_number, number, points, threads_of, whole


class Neighbours(NamedTuple):
    """What :func:`query` has found: for each point that asked, a stretch of the arrays."""

    offsets: npt.NDArray[np.int64]
    """``[q + 1]``: what point ``k`` has found is at ``offsets[k]:offsets[k + 1]``."""
    indices: npt.NDArray[np.uint32]
    """``[m]``: the elements found."""
    distances: Floats
    """``[m]``: how far they are."""


def query(
    positions: npt.ArrayLike,
    r: Optional[float] = None,
    *,
    at: Optional[npt.ArrayLike] = None,
    k: Optional[int] = None,
    threads: Optional[int] = None,
) -> Neighbours:
    """Finds the elements within `r` of points, or the `k` nearest to each.

    Parameters
    ----------
    positions : array [n, 2] or [n, 3], float32 or float64
        The elements that are sought.
    r : number
        The largest distance, which counts.
    at : array [q, D], optional
        The points around which they are sought; `positions` otherwise, and then each finds itself too.
    k : int
        How many are sought, in place of `r`; fewer are found only where there are no more.
    threads : int, optional
        One for each processor by default. The result does not depend on it.

    Returns
    -------
    Neighbours
        ``offsets, indices, distances``. With `r` the indices of each point ascend; with `k` the nearest comes first, and of equally near ones that with the smaller
        index.

    Raises
    ------
    ValueError
        For NaN, infinity, negative `r`.
    TypeError
        Unless just one of `r` and `k` is given.

    Examples
    --------
    >>> import fdem
    >>> found = fdem.query([[0.0, 0.0], [1.0, 0.0], [5.0, 0.0]], 1.0, at=[[0.5, 0.0], [9.0, 0.0]])
    >>> found.offsets.tolist(), found.indices.tolist()
    ([0, 2, 2], [0, 1])
    >>> fdem.query([[0.0, 0.0], [1.0, 0.0], [5.0, 0.0]], k=1, at=[[4.0, 0.0]]).distances.tolist()
    [1.0]
    """
    if (r is None) == (k is None):
        raise TypeError("give r, the largest distance, or k, how many are sought: one of the two")
    elements = points(positions, "positions")
    if at is None:
        asking = elements
    else:
        elements, asking = alike(elements, points(at, "at"))
    if elements.shape[1] != asking.shape[1]:
        raise ValueError(f"positions have {elements.shape[1]} coordinates, and the points at which to look {asking.shape[1]}")
    if r is not None:
        return Neighbours(*_fdem.within(elements, asking, number(r, "r"), threads_of(threads)))
    return Neighbours(*_fdem.nearest(elements, asking, whole(k, "k", 0), threads_of(threads)))


class KDTree:
    """Couples of points, asked for as of ``scipy.spatial.cKDTree``.

    There is no tree: this is :func:`contacts` in the words of SciPy, for those who migrate. New code has less to convert with :func:`contacts`.

    Parameters
    ----------
    data : array [n, 2] or [n, 3]
        The points.
    leafsize, compact_nodes, copy_data, balanced_tree
        Of no effect.
    boxsize : number or array [D], optional
        Lengths of a box from 0 that repeats.

    Examples
    --------
    >>> import fdem
    >>> fdem.KDTree([[0.0, 0.0], [1.0, 0.0], [5.0, 5.0]]).query_pairs(1.0)
    {(0, 1)}
    """

    def __init__(
        self,
        data: npt.ArrayLike,
        leafsize: int = 16,
        compact_nodes: bool = True,
        copy_data: bool = False,
        balanced_tree: bool = True,
        boxsize: Any = None,
    ) -> None:
        self.data = points(data, "data")
        self.n, self.m = self.data.shape
        self.boxsize: Optional[npt.NDArray[np.float64]] = None
        if boxsize is not None:
            sides = np.asarray(boxsize, np.float64)
            if sides.shape not in ((), (self.m,)):
                raise ValueError(f"boxsize must be one number or {self.m}, not of the shape {sides.shape}")
            if not (np.isfinite(sides) & (sides >= 0)).all():
                raise ValueError(f"boxsize must be finite and not negative, not {boxsize}")
            self.boxsize = np.broadcast_to(sides, (self.m,))

    def query_pairs(self, r: float, p: float = 2.0, eps: float = 0.0, output_type: str = "set") -> Any:
        """All couples of points that are at most `r` apart.

        Parameters
        ----------
        r : number
            The largest distance, which counts.
        p : number
            2: no other norm is there.
        eps : number
            Of no effect: the result is exact.
        output_type : {"set", "ndarray"}
            A set of tuples ``(i, j)``, or an array ``[m, 2]`` of intp, with ``i < j``.

        Raises
        ------
        ValueError
            For another norm or output, NaN, negative `r`.
        """
        if p != 2:
            raise ValueError(f"p must be 2, the Euclidean norm, not {p}")
        if output_type not in ("set", "ndarray"):
            raise ValueError(f"there is no output_type '{output_type}': choose one of set, ndarray")
        if not is_number(r):
            raise TypeError("r is one number")
        if self.boxsize is None:
            pairs = contacts(self.data, cutoff=r).pairs
        else:
            repeats = (self.boxsize > 0).tolist()
            extent = np.ptp(self.data, axis=0) if self.n else np.ones(self.m)
            edges = np.where(repeats, self.boxsize, extent + 1)
            pairs = contacts(self.data, cutoff=r, box=np.diag(edges), periodic=repeats).pairs
            # Here images are no couples of their own.
            pairs = np.unique(pairs[pairs[:, 0] != pairs[:, 1]], axis=0)
        if output_type == "ndarray":
            return pairs.astype(np.intp)
        return set(map(tuple, pairs.tolist()))
