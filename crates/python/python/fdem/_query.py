"""Elements around points."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _fdem
from ._box import Box, Cell, cell_of
from ._input import Floats, alike, number, points, threads_of, whole


class Neighbours(NamedTuple):
    """The elements that :func:`query` has found, those of the first point first."""

    offsets: npt.NDArray[np.int64]
    """``[q + 1]``: the elements around point ``k`` are at ``offsets[k]:offsets[k + 1]``."""
    indices: npt.NDArray[np.uint32]
    """``[m]``: the elements found."""
    distances: Floats
    """``[m]``: their distances."""
    shifts: npt.NDArray[np.int32]
    """``[m, D]``: the edges of the box by which each element is displaced; zeros without a box that repeats."""


def query(
    positions: npt.ArrayLike,
    r: Optional[float] = None,
    *,
    at: Optional[npt.ArrayLike] = None,
    k: Optional[int] = None,
    box: Any = None,
    periodic: Union[bool, Sequence[bool]] = False,
    threads: Optional[int] = None,
) -> Neighbours:
    """Finds the elements within `r` of points, or the `k` nearest to each.

    Parameters
    ----------
    positions : array [n, 2] or [n, 3], float32 or float64
        The elements.
    r : number
        The largest distance, which counts.
    at : array [q, D], optional
        The points to look around; `positions` by default, and then each element finds itself too.
    k : int
        How many elements are sought, in place of `r`; fewer are found only where there are no more.
    box, periodic
        As for :func:`contacts`. Every image of an element counts, also for `k`, and `shifts` identifies the image.
    threads : int, optional
        Number of threads; one for each processor by default. The result does not depend on it.

    Returns
    -------
    Neighbours
        ``offsets, indices, distances, shifts``: the elements around point ``q`` are ``indices[offsets[q]:offsets[q + 1]]``. They are ascending by number (and shift), or,
        for `k`, by distance, then number (and shift).

    Raises
    ------
    ValueError
        For NaN, negative `r`, points of another dimension, a box without volume; for `k` also where points are so far from the box that the images up to there do
        not fit into memory.
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

    In a box that repeats, the nearest element may be an image:

    >>> found = fdem.query([[0.5, 1.0], [2.0, 1.0]], k=1, at=[[3.75, 1.0]], box=[4, 4], periodic=True)
    >>> found.indices.tolist(), found.distances.tolist(), found.shifts.tolist()
    ([0], [0.75], [[1, 0]])
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
    of_box, cell = cell_of(box, periodic, elements.shape[1])
    if of_box is not None and cell is not None:
        elements, asking = alike(elements, asking)
        if r is not None:
            return _within_images(elements, asking, number(r, "r"), cell, threads_of(threads))
        return _nearest_images(elements, asking, whole(k, "k", 0), of_box, cell, threads_of(threads))
    if r is not None:
        found = _fdem.within(elements, asking, number(r, "r"), threads_of(threads))
    else:
        found = _fdem.nearest(elements, asking, whole(k, "k", 0), threads_of(threads))
    return Neighbours(*found, np.zeros((len(found[1]), elements.shape[1]), np.int32))


def _within_images(elements: Floats, asking: Floats, r: float, cell: Cell, threads: int) -> Neighbours:
    """The couples of two sets within `r`: points that ask, and elements, of which none forms a couple with its like."""
    q = len(asking)
    both = np.concatenate([asking, elements])
    groups = np.repeat(np.array([0, 1], np.uint32), [q, len(elements)])
    searched = _fdem.Elements(both, "cutoff", r, None, 0.0, groups, cell)
    pairs, shifts = _fdem.ascending(*_fdem.contacts(searched, "auto", threads, "cpu"))
    distances = _fdem.measure(searched, pairs, shifts, False, threads)
    all_shifts = np.zeros((len(pairs), both.shape[1]), np.int32)
    all_shifts[len(pairs) - len(shifts) :] = shifts
    offsets = np.zeros(q + 1, np.int64)
    np.cumsum(np.bincount(pairs[:, 0], minlength=q)[:q], out=offsets[1:])
    return Neighbours(offsets, pairs[:, 1] - np.uint32(q), distances, all_shifts)


def _nearest_images(elements: Floats, asking: Floats, k: int, box: Box, cell: Cell, threads: int) -> Neighbours:
    """The nearest ones among those within a distance that grows until all points have found `k`."""
    q, dimensions = asking.shape
    if len(elements) == 0 or k == 0:
        zeros = np.zeros(q + 1, np.int64)
        return Neighbours(zeros, np.zeros(0, np.uint32), np.zeros(0, elements.dtype), np.zeros((0, dimensions), np.int32))
    indices = np.zeros((q, k), np.uint32)
    distances = np.zeros((q, k), elements.dtype)
    shifts = np.zeros((q, k, dimensions), np.int32)
    # A ball that has about twice as many elements where they are as dense as in the box.
    ball = {2: math.pi, 3: 4 / 3 * math.pi}[dimensions]
    r = (2 * k * abs(np.linalg.det(box.edges)) / (len(elements) * ball)) ** (1 / dimensions)
    waiting = np.arange(q)
    while len(waiting):
        found = _within_images(elements, np.ascontiguousarray(asking[waiting]), r, cell, threads)
        counts = np.diff(found.offsets)
        enough = counts >= k
        asked = np.repeat(np.arange(len(waiting)), counts)
        # Stable: those at one distance stay ascending by number and shift.
        order = np.lexsort((found.distances, asked))
        nearest = order[(found.offsets[:-1][enough, None] + np.arange(k)).reshape(-1)]
        done = waiting[enough]
        indices[done] = found.indices[nearest].reshape(-1, k)
        distances[done] = found.distances[nearest].reshape(-1, k)
        shifts[done] = found.shifts[nearest].reshape(-1, k, dimensions)
        waiting = waiting[~enough]
        r *= 1.5
    offsets = np.arange(q + 1, dtype=np.int64) * k
    return Neighbours(offsets, indices.reshape(-1), distances.reshape(-1), shifts.reshape(-1, dimensions))
