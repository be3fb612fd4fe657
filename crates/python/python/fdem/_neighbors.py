"""Contacts as a neighbour list of freud."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from . import _fdem
from ._couples import Couples
from ._input import Floats


class NeighborList:
    """Contacts seen from each element, with the names of ``freud.locality.NeighborList``.

    Each couple is listed twice, sorted by `query_point_indices`, then `point_indices`, as freud lists the result of
    ``AABBQuery(box, points).query(points, dict(r_max=cutoff, exclude_ii=True)).toNeighborList()``. Made by :meth:`Contacts.neighbor_list`.

    There are three differences: distances have the type of the positions, which need not be float32; points that are exactly `cutoff` apart are neighbours; in a
    small box every image counts.

    Attributes
    ----------
    query_point_indices, point_indices : array [b], uint32
        The two ends of each bond.
    segments : array [n], uint32 (int64 beyond 2^32 bonds)
        Where the bonds of each element start.
    neighbor_counts : array [n], uint32
        How many bonds it has.
    num_points, num_query_points : int
        The number of elements.

    Examples
    --------
    >>> import fdem
    >>> bonds = fdem.contacts([[0, 0], [1, 0], [2, 0]], cutoff=1).neighbor_list()
    >>> bonds[:].tolist(), bonds.vectors[:, 0].tolist()
    ([[0, 1], [1, 0], [1, 2], [2, 1]], [1.0, -1.0, 1.0, -1.0])
    """

    query_point_indices: npt.NDArray[np.uint32]
    point_indices: npt.NDArray[np.uint32]
    segments: npt.NDArray[Any]
    neighbor_counts: npt.NDArray[np.uint32]
    num_points: int
    num_query_points: int

    def __init__(self) -> None:
        raise TypeError("a neighbour list comes from Contacts.neighbor_list()")

    _contacts: Couples
    _couples: npt.NDArray[np.int64]

    @classmethod
    def _of(cls, contacts: Couples) -> NeighborList:
        self = cls.__new__(cls)
        starts, self.point_indices, couples = _fdem.csr(contacts.n, contacts.pairs, True)
        self._contacts, self._couples = contacts, couples
        # freud counts in 32 bits; a place beyond them would be wrong without a word.
        of_places = np.uint32 if starts[-1] < 2**32 else np.int64
        self.segments, self.neighbor_counts = starts[:-1].astype(of_places), np.diff(starts).astype(np.uint32)
        self.query_point_indices = np.repeat(np.arange(contacts.n, dtype=np.uint32), self.neighbor_counts)
        self.num_points = self.num_query_points = contacts.n
        return self

    @property
    def distances(self) -> Floats:
        """``[b]``: the length of each bond."""
        return self._contacts.distance[self._places]

    @property
    def vectors(self) -> Floats:
        """``[b, D]``: from the query point to the point."""
        vectors = self._contacts.vector[self._places]
        vectors[self._couples < 0] *= -1
        return vectors

    @property
    def shifts(self) -> npt.NDArray[np.int32]:
        """``[b, D]``: the edges of the box by which the point is displaced."""
        shifts = self._contacts.shift[self._places]
        shifts[self._couples < 0] *= -1
        return shifts

    @property
    def weights(self) -> npt.NDArray[np.float32]:
        """``[b]``: ones."""
        return np.ones(len(self), np.float32)

    @property
    def _places(self) -> npt.NDArray[np.int64]:
        return np.where(self._couples < 0, ~self._couples, self._couples)

    def find_first_index(self, i: int) -> int:
        """The place of the first bond of query point `i`, or where it would be."""
        return int(np.searchsorted(self.query_point_indices, i))

    def __len__(self) -> int:
        return len(self.point_indices)

    def __getitem__(self, key: Any) -> npt.NDArray[np.uint32]:
        bonds: npt.NDArray[np.uint32] = np.stack([self.query_point_indices, self.point_indices], axis=1)[key]
        return bonds

    def __repr__(self) -> str:
        return f"<fdem.NeighborList: {len(self):,} bonds of {self.num_points:,} points>"
