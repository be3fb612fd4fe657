"""Neighbours of points as SciPy's k-d tree finds them."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from typing import Any, Optional

import numpy as np
import numpy.typing as npt

from . import _fdem
from ._contacts import optional
from ._input import floats, is_number, number, whole
from ._nodes import InnerNode, LeafNode, Node, node
from ._search import contacts

_Reals = npt.NDArray[np.float64]

_FEW = 8
"""With fewer queries than the number of points divided by this, a tree answers: sorting the points for one search would cost more than the search."""

_SAMPLE = 4096
"""Points of a sample that shows whether the points are even."""

_CROWDED = 8
"""The points are uneven if points have more than this many times the mean number of points around them."""

_PIECE = 1 << 16
"""Rows that become objects of Python at a time: between two pieces Ctrl-C is heeded."""

_ALL = 1e150
"""Distances beyond this one are those of all couples: the search of contacts refuses them, and coordinates do not reach it."""


class KDTree:
    """Points, asked for their neighbours as ``scipy.spatial.KDTree`` and ``cKDTree``.

    For code that was written for SciPy: the same methods, arguments and results, for points of any dimension, any Minkowski norm and boxes that repeat. Results are
    always exact; `eps` has no effect. Where SciPy leaves an order open, here it is ascending: neighbours at one distance by their number, the
    points of a ball by their number.

    Many points in a plane or in space at once are sorted into rows, as :func:`query` does; a k-d tree answers all other questions.

    Parameters
    ----------
    data : array [n, m]
        The points, converted to float64.
    leafsize : int
        The most points of a leaf of the tree.
    compact_nodes, balanced_tree
        Have no effect: nodes are compact, and the tree is balanced.
    copy_data : bool
        Whether `data` is a copy of the array that is given.
    boxsize : number or array [m], optional
        Lengths of a box from 0 that repeats; 0 is an axis that does not repeat. The points must lie in the box.

    Attributes
    ----------
    data : array [n, m], float64
        The points.
    n, m : int
        The number of points, and of their coordinates.
    mins, maxes : array [m]
        The least and the greatest coordinate on each axis.
    boxsize : array [m] or None
        The lengths of the box.
    tree : KDTree.node
        The root of the tree: a ``KDTree.innernode``, or a ``KDTree.leafnode``.
    size : int
        The number of nodes.
    indices : array [n], intp
        The numbers of the points in the order of the leaves.

    Raises
    ------
    TypeError
        For complex data.
    ValueError
        For data that are not finite, not of two dimensions, or outside of the box, or a `leafsize` below 1.

    Examples
    --------
    >>> import fdem
    >>> tree = fdem.KDTree([[0.0, 0.0], [1.0, 0.0], [5.0, 5.0]])
    >>> tree.query_pairs(1.0)
    {(0, 1)}
    >>> distance, index = tree.query([[4.0, 5.0], [0.0, 1.0]])
    >>> distance.tolist(), index.tolist()
    ([1.0, 1.0], [2, 0])
    >>> tree.query_ball_point([0.0, 0.0], 2.0)
    [0, 1]
    """

    node = Node
    leafnode = LeafNode
    innernode = InnerNode

    def __init__(
        self,
        data: npt.ArrayLike,
        leafsize: int = 10,
        compact_nodes: bool = True,
        copy_data: bool = False,
        balanced_tree: bool = True,
        boxsize: Any = None,
    ) -> None:
        array: _Reals = np.require(floats(_real(data), "data"), np.float64, ["C", "A"])
        if array.ndim != 2 or array.shape[1] == 0:
            raise ValueError(f"data must have the shape [n, m], n points of dimension m, not {array.shape}")
        if not np.isfinite(array).all():
            point = int(np.flatnonzero(~np.isfinite(array).all(axis=1))[0])
            raise ValueError(f"data must be finite; point {point} is {array[point].tolist()}")
        self.data: _Reals = array.copy() if copy_data else array
        self.n, self.m = self.data.shape
        self.leafsize = whole(leafsize, "leafsize", 1)
        self.mins: _Reals = self.data.min(axis=0) if self.n else np.zeros(self.m)
        self.maxes: _Reals = self.data.max(axis=0) if self.n else np.zeros(self.m)
        self.boxsize: Optional[_Reals] = None
        if boxsize is not None:
            sides = np.asarray(boxsize, np.float64)
            if sides.shape not in ((), (self.m,)):
                raise ValueError(f"boxsize must be one number or {self.m}, not of the shape {sides.shape}")
            if not (np.isfinite(sides) & (sides >= 0)).all():
                raise ValueError(f"boxsize must be finite and not negative, not {boxsize}")
            self.boxsize = np.broadcast_to(sides, (self.m,)).copy()
            repeats = self.boxsize > 0
            outside = repeats & ((self.data < 0) | (self.data >= self.boxsize))
            if outside.any():
                point = int(np.flatnonzero(outside.any(axis=1))[0])
                raise ValueError(f"point {point} is outside of the periodic box: {self.data[point].tolist()}")
        self._built: Optional[_fdem.Tree] = None
        self._walked: Optional[tuple[npt.NDArray[np.int64], npt.NDArray[np.intp]]] = None
        self._even: Optional[bool] = None

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_built": None, "_walked": None}

    def __repr__(self) -> str:
        return f"<fdem.KDTree: {self.n:,} points of dimension {self.m}>"

    @property
    def _tree(self) -> _fdem.Tree:
        if self._built is None:
            sides = [0.0] * self.m if self.boxsize is None else self.boxsize.tolist()
            self._built = _fdem.Tree(self.data, sides, self.leafsize)
        return self._built

    @property
    def _walk(self) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.intp]]:
        if self._walked is None:
            nodes, numbers = self._tree.nodes()
            self._walked = nodes, numbers.astype(np.intp, copy=False)
        return self._walked

    @property
    def _nodes(self) -> npt.NDArray[np.int64]:
        """For each node the range of its points, and the node of its right half or 0; the left half comes next."""
        return self._walk[0]

    @property
    def indices(self) -> npt.NDArray[np.intp]:
        """``[n]``: the numbers of the points in the order of the leaves."""
        return self._walk[1]

    @property
    def size(self) -> int:
        """The number of nodes."""
        return len(self._nodes)

    @property
    def tree(self) -> Node:
        """The root of the tree."""
        return node(self, 0, 0) if self.n else LeafNode()

    def _build_weights(self, weights: npt.ArrayLike) -> _Reals:
        """The sum of the weights of the points of each node."""
        each = _weights_of(weights, self.n)
        return np.zeros(0) if each is None else self._tree.node_weights(each)

    def query(
        self,
        x: npt.ArrayLike,
        k: Any = 1,
        eps: float = 0.0,
        p: float = 2.0,
        distance_upper_bound: float = np.inf,
        workers: int = 1,
    ) -> tuple[Any, Any]:
        """The `k` nearest neighbours of points.

        Parameters
        ----------
        x : array [..., m]
            The points.
        k : int or sequence of int
            How many neighbours; or which of them, counted from 1.
        eps : number
            Has no effect: the result is exact.
        p : number
            The order of the Minkowski norm, from 1 to infinity.
        distance_upper_bound : number
            Only neighbours nearer than this are returned.
        workers : int
            Number of threads; -1 is one for each processor.

        Returns
        -------
        distances, indices : arrays of the shape of `x` without its last axis, and with one of length `k` unless `k` is 1
            The nearest first; for one point and `k` of 1 a float and a ``numpy.intp``. Where there are fewer neighbours, the distance is infinite and the index `n`.

        Raises
        ------
        ValueError
            For another norm, points of another dimension, points that are not finite, `k` below 1.
        """
        _checked_norm(p)
        threads = _threads_of(workers)
        if k is None:
            raise ValueError("k must be an integer or a sequence of integers")
        one = self._point(x)
        if one is not None and type(k) is int and k >= 1 and type(distance_upper_bound) is float and distance_upper_bound == distance_upper_bound:
            if k == 1:
                nearest, index = self._tree.nearest_one(one, float(p), distance_upper_bound)
                return nearest, np.intp(index)
            if self.boxsize is None and np.isfinite(one).all():
                rows = self._tree.nearest(one[None], k, float(p), distance_upper_bound, 1)
                return rows[0][0], rows[1][0].astype(np.intp, copy=False)
        at = self._points(x)
        squeezed = is_number(k)
        which = np.arange(1, whole(k, "k", 1) + 1) if squeezed else np.asarray([whole(each, "k", 1) for each in k], np.intp)
        if len(which) == 0:
            raise ValueError("k must not be empty")
        most = int(which.max())
        bound = number(distance_upper_bound, "distance_upper_bound")
        if np.isnan(bound):
            raise ValueError("distance_upper_bound is NaN")
        flat = self._wrapped(at.reshape(-1, self.m))
        if self._are_many(flat, p):
            found = _fdem.nearest(self.data, flat, min(most, self.n), threads)
            distances: npt.NDArray[Any] = np.full((len(flat), most), np.inf)
            indices: npt.NDArray[Any] = np.full((len(flat), most), self.n, np.intp)
            distances[:, : min(most, self.n)] = found[2].reshape(len(flat), -1)
            indices[:, : min(most, self.n)] = found[1].reshape(len(flat), -1)
            too_far = distances >= bound
            distances[too_far], indices[too_far] = np.inf, self.n
        else:
            distances, indices = self._tree.nearest(flat, most, float(p), bound, threads)
        shape = at.shape[:-1]
        if squeezed and most == 1:
            distances, indices = distances.reshape(shape), indices.reshape(shape)
            return (float(distances), np.intp(indices)) if not shape else (distances, indices.astype(np.intp, copy=False))
        distances, indices = distances[:, which - 1], indices[:, which - 1]
        return distances.reshape(*shape, len(which)), indices.reshape(*shape, len(which)).astype(np.intp, copy=False)

    def query_ball_point(
        self,
        x: npt.ArrayLike,
        r: npt.ArrayLike,
        p: float = 2.0,
        eps: float = 0.0,
        workers: int = 1,
        return_sorted: Optional[bool] = None,
        return_length: bool = False,
    ) -> Any:
        """The points at most `r` away from points.

        Parameters
        ----------
        x : array [..., m]
            The points to look around.
        r : number, or array that broadcasts to the shape of `x` without its last axis
            The largest distance, which counts. Nothing is nearer than a negative one.
        p, eps, workers
            As for :meth:`query`.
        return_sorted : bool, optional
            Has no effect: numbers are ascending.
        return_length : bool
            Whether the number of the points is returned, and not their list.

        Returns
        -------
        list, int, or array of them
            For one point a list of numbers, for several an array of lists, of the shape of `x` without its last axis.

        Raises
        ------
        ValueError
            As :meth:`query`.
        """
        _checked_norm(p)
        threads = _threads_of(workers)
        one = self._point(x)
        radius: Any = r if type(r) in (int, float, np.float64) else np.nan
        if one is not None and radius == radius:
            if return_length:
                return self._tree.count_within_one(one, float(radius), float(p))
            return self._tree.within_one(one, float(radius), float(p))
        at = self._points(x)
        shape = at.shape[:-1]
        radii = floats(r, "r").astype(np.float64)
        if np.isnan(radii).any():
            raise ValueError("r is NaN")
        try:
            each = np.ascontiguousarray(np.broadcast_to(radii, shape)).reshape(-1)
        except ValueError:
            raise ValueError(f"r must be one number, or one for each of the points of shape {shape}, not of the shape {radii.shape}") from None
        flat = self._wrapped(at.reshape(-1, self.m))
        if return_length:
            counts = self._tree.count_within(flat, each, float(p), threads).astype(np.intp).reshape(shape)
            return counts if shape else counts[()]
        offsets, numbers, _ = self._within(flat, each, p, threads)
        lists: list[list[int]] = []
        for rows in _pieces(len(flat)):
            ends = offsets[rows.start : rows.stop + 1]
            listed, ends = numbers[ends[0] : ends[-1]].tolist(), (ends - ends[0]).tolist()
            lists += [listed[start:end] for start, end in zip(ends, ends[1:])]
        if not shape:
            return lists[0]
        found = np.empty(len(lists), object)
        found[:] = lists
        return found.reshape(shape)

    def query_ball_tree(self, other: KDTree, r: float, p: float = 2.0, eps: float = 0.0) -> list[list[int]]:
        """For each point of this tree the points of `other` at most `r` away.

        Parameters
        ----------
        other : KDTree
            A tree of the same dimension and box.
        r, p, eps
            As for :meth:`query_ball_point`.

        Returns
        -------
        list of lists of int
            Ascending.

        Raises
        ------
        ValueError
            For trees of other dimensions or boxes, and as :meth:`query`.
        """
        self._check_alike(other)
        found: Any = other.query_ball_point(self.data, number(r, "r"), p, workers=-1)
        return list(found)

    def query_pairs(self, r: float, p: float = 2.0, eps: float = 0.0, output_type: str = "set") -> Any:
        """All couples of points at most `r` apart.

        Parameters
        ----------
        r : number
            The largest distance, which counts.
        p, eps
            As for :meth:`query`.
        output_type : {"set", "ndarray"}
            A set of tuples ``(i, j)``, or an array ``[pairs, 2]`` of intp, with ``i < j``.

        Returns
        -------
        set or array

        Raises
        ------
        ValueError
            For another norm or output, NaN, negative `r`.
        """
        if output_type not in ("set", "ndarray"):
            raise ValueError(f"there is no output_type '{output_type}': choose one of set, ndarray")
        if not is_number(r):
            raise TypeError("r is one number")
        _checked_norm(p)
        pairs: npt.NDArray[Any]
        if number(r, "r") > _ALL:
            pairs = np.stack(np.triu_indices(self.n, 1), axis=1)
        elif self.boxsize is None and p == 2 and self.m in (2, 3):
            pairs = contacts(self.data, cutoff=r).pairs
        else:
            if not r >= 0:
                raise ValueError(f"r must not be negative, not {r}")
            offsets, numbers, _ = self._within(self.data, np.full(self.n, float(r)), p, 0)
            pairs = np.stack([np.repeat(np.arange(self.n), np.diff(offsets)), numbers], axis=1)
            pairs = pairs[pairs[:, 0] < pairs[:, 1]]
        if output_type == "ndarray":
            return pairs.astype(np.intp)
        found: set[tuple[int, int]] = set()
        for rows in _pieces(len(pairs)):
            found.update(zip(pairs[rows, 0].tolist(), pairs[rows, 1].tolist()))
        return found

    def count_neighbors(
        self,
        other: KDTree,
        r: npt.ArrayLike,
        p: float = 2.0,
        weights: Any = None,
        cumulative: bool = True,
    ) -> Any:
        """Counts the pairs of a point of this tree and a point of `other` that are at most `r` apart.

        Parameters
        ----------
        other : KDTree
            A tree of the same dimension and box; may be this one, and then each point is also paired with itself.
        r : number or array [k]
            The largest distances, which count.
        p : number
            As for :meth:`query`.
        weights : tuple, array or None
            Weights of the points of this tree and of `other`; each may be None. One array is for both, which must be one tree. A pair counts with the product.
        cumulative : bool
            Whether pairs at most ``r[i]`` apart are counted, or those that are besides more than ``r[i - 1]`` apart; `r` must not decrease then.

        Returns
        -------
        number or array [k]
            Whole numbers without weights.

        Raises
        ------
        ValueError
            For other dimensions or boxes, weights of another length, an `r` of more dimensions.
        """
        self._check_alike(other)
        _checked_norm(p)
        distances = floats(r, "r").astype(np.float64)
        if distances.ndim > 1:
            raise ValueError("r must be either a single value or a one-dimensional array of values")
        if np.isnan(distances).any():
            raise ValueError("r is NaN")
        ascending = distances.reshape(-1)
        if not cumulative and (ascending[:-1] > ascending[1:]).any():
            raise ValueError("r must be non-decreasing for non-cumulative counting.")
        if weights is None or isinstance(weights, tuple):
            one, two = weights or (None, None)
        elif self is other:
            one = two = weights
        else:
            raise ValueError("Two different trees are used. Specify weights for both in a tuple.")
        of_these, of_others = _weights_of(one, self.n), _weights_of(two, other.n)
        order = np.argsort(ascending, kind="stable")
        bins = self._tree.count_pairs(other._tree, ascending[order], float(p), of_these, of_others)
        counts: npt.NDArray[Any] = bins
        if cumulative:
            # Back in the order of `r`.
            counts = np.cumsum(bins)[np.searchsorted(ascending[order], ascending, side="right") - 1]
        if weights is None:
            counts = counts.astype(np.intp)
        if distances.ndim:
            return counts
        return int(counts[0]) if weights is None else counts[0]

    def sparse_distance_matrix(self, other: KDTree, max_distance: float, p: float = 2.0, output_type: str = "dok_matrix") -> Any:
        """The distances of the points of this tree and of `other` that are at most `max_distance` apart.

        Parameters
        ----------
        other : KDTree
            A tree of the same dimension and box.
        max_distance : number
            The largest distance, which counts.
        p : number
            As for :meth:`query`.
        output_type : {"dict", "dok_matrix", "coo_matrix", "ndarray"}
            What is returned; a matrix needs SciPy.

        Returns
        -------
        dict, dok_matrix, coo_matrix or array
            A dict has keys ``(i, j)``; an array has the fields `i`, `j` and `v`. Sorted by `i`, then `j`.

        Raises
        ------
        ValueError
            For another output, and as :meth:`query_ball_tree`.
        ImportError
            For a matrix without SciPy.
        """
        self._check_alike(other)
        if output_type not in ("dict", "dok_matrix", "coo_matrix", "ndarray"):
            raise ValueError(f"there is no output_type '{output_type}': choose one of dict, dok_matrix, coo_matrix, ndarray")
        _checked_norm(p)
        offsets, j, v = other._within(self.data, np.full(self.n, number(max_distance, "max_distance")), p, 0)
        i = np.repeat(np.arange(self.n, dtype=np.intp), np.diff(offsets))
        if output_type == "dict":
            distances: dict[tuple[int, int], float] = {}
            for piece in _pieces(len(v)):
                distances.update(zip(zip(i[piece].tolist(), j[piece].tolist()), v[piece].tolist()))
            return distances
        if output_type == "ndarray":
            rows = np.empty(len(v), np.dtype([("i", np.intp), ("j", np.intp), ("v", np.float64)], align=True))
            rows["i"], rows["j"], rows["v"] = i, j, v
            return rows
        sparse = optional("scipy.sparse", "scipy")
        matrix = sparse.coo_matrix((v, (i, j)), shape=(self.n, other.n))
        return matrix if output_type == "coo_matrix" else matrix.todok()

    def _point(self, x: Any) -> Optional[_Reals]:
        """One point that needs no conversion: it is asked in a few microseconds. None for all others."""
        at = np.array(x) if type(x) in (list, tuple) else x
        if type(at) is np.ndarray and at.dtype == np.float64 and at.shape == (self.m,):
            return np.ascontiguousarray(at)
        return None

    def _points(self, x: Any) -> _Reals:
        at: _Reals = floats(_real(x), "x").astype(np.float64)
        if at.ndim == 0 or at.shape[-1] != self.m:
            raise ValueError(f"x must consist of vectors of length {self.m} but has shape {at.shape}")
        if not np.isfinite(at).all():
            raise ValueError("'x' must be finite, check for nan or inf values")
        return at

    def _wrapped(self, at: _Reals) -> _Reals:
        """Points in the box, where it repeats."""
        if self.boxsize is None:
            return np.ascontiguousarray(at)
        repeats = self.boxsize > 0
        sides = np.where(repeats, self.boxsize, 1.0)
        wrapped = at - np.floor(at / sides) * sides
        # Rounding may leave a point just outside.
        wrapped = np.where(wrapped < 0, wrapped + sides, wrapped)
        wrapped = np.where(wrapped >= sides, wrapped - sides, wrapped)
        return np.ascontiguousarray(np.where(repeats, wrapped, at))

    def _are_many(self, at: _Reals, p: float) -> bool:
        """Whether sorting all points for this question is worth it."""
        return self.boxsize is None and p == 2 and self.m in (2, 3) and len(at) * _FEW >= self.n > 0 and self._is_even()

    def _is_even(self) -> bool:
        """Whether the points fill their box about evenly, by a sample: rows of cells suit no others."""
        if self._even is None:
            sample = self.data[:: max(1, self.n // _SAMPLE)]
            low, high = sample.min(axis=0), sample.max(axis=0)
            bins = 16 if self.m == 2 else 8
            place = ((sample - low) / np.where(high > low, high - low, 1.0) * bins).astype(np.intp).clip(0, bins - 1)
            counts = np.bincount(np.ravel_multi_index(tuple(place.T), (bins,) * self.m), minlength=bins**self.m)
            # The mean number of points in the bin of a point, over that in any bin: about 1 if they are even.
            self._even = bool((counts**2).sum() * len(counts) <= _CROWDED * len(sample) * (len(sample) + len(counts)))
        return self._even

    def _within(self, at: _Reals, radii: _Reals, p: float, threads: int) -> tuple[npt.NDArray[np.int64], npt.NDArray[Any], _Reals]:
        if self._are_many(at, p) and len(radii) and (radii == radii[0]).all() and 0 <= radii[0] < np.inf:
            return _fdem.within(self.data, at, float(radii[0]), threads)
        return self._tree.within(at, radii, float(p), threads)

    def _check_alike(self, other: KDTree) -> None:
        if self.m != other.m:
            raise ValueError("Trees passed to this method have different dimensionality")
        if not np.array_equal(np.zeros(self.m) if self.boxsize is None else self.boxsize, np.zeros(other.m) if other.boxsize is None else other.boxsize):
            raise ValueError("Trees passed to this method have different boxes")


def _pieces(rows: int) -> Iterator[slice]:
    """Parts of all rows. Until the last one is used, Python does not look for cycles: it would look through the new lists and tuples, which have none, again and again."""
    looks = gc.isenabled()
    gc.disable()
    try:
        yield from (slice(start, min(start + _PIECE, rows)) for start in range(0, rows, _PIECE))
    finally:
        if looks:
            gc.enable()


def _real(data: Any) -> Any:
    """Data that are not complex."""
    if np.iscomplexobj(data):
        raise TypeError("KDTree does not work with complex data")
    return data


def _checked_norm(p: float) -> None:
    if not number(p, "p") >= 1:
        raise ValueError("Only p-norms with 1<=p<=infinity permitted")


def _threads_of(workers: int) -> int:
    """0 is one thread for each processor."""
    if workers == -1:
        return 0
    if isinstance(workers, bool) or workers < 1:
        raise ValueError(f"Invalid number of workers {workers}, must be -1 or > 0")
    return whole(workers, "workers", 1)


def _weights_of(weights: Optional[npt.ArrayLike], n: int) -> Optional[_Reals]:
    if weights is None:
        return None
    each = np.ascontiguousarray(floats(weights, "weights").astype(np.float64))
    if each.shape != (n,):
        raise ValueError("Number of weights differ from the number of data points")
    return each
