"""Searches that follow moving elements."""

from __future__ import annotations

from typing import Optional

import numpy as np
import numpy.typing as npt

from . import _fdem
from ._contacts import Contacts, sizes_of
from ._input import number, numbers, points, threads_of


class Detector:
    """Finds contacts again and again, in memory that it keeps, and detects only when elements have moved too far.

    With a buffer it keeps all couples whose surfaces are at most `buffer` apart. As long as no element has moved by more than half of it, relative to the mean
    motion of all, these contain every couple that touches, and an update only tests them.

    Parameters
    ----------
    radii, cutoff, groups, tolerance, engine, threads
        As for :func:`contacts`. Boxes that repeat are not followed.
    buffer : number, default 0
        In the unit of the positions; with 0 every update detects.

    Raises
    ------
    ValueError, TypeError
        As :func:`contacts`; for a negative buffer.

    Examples
    --------
    >>> import numpy as np, fdem
    >>> positions = np.array([[0.0, 0.0], [1.05, 0.0], [3.0, 0.0]])
    >>> detector = fdem.Detector(radii=0.5, buffer=0.4)
    >>> detector.update(positions), len(detector.contacts)
    (True, 0)
    >>> positions[1, 0] -= 0.06
    >>> detector.update(positions), detector.contacts.pairs.tolist()
    (False, [[0, 1]])
    >>> positions[2, 0] -= 1.0
    >>> detector.update(positions), detector.reason  # doctest: +ELLIPSIS
    (True, 'element 2 moved by 6.4666...e-1 relative to the mean, more than 1.9999...e-1')
    """

    def __init__(
        self,
        radii: Optional[npt.ArrayLike] = None,
        cutoff: Optional[float] = None,
        *,
        buffer: float = 0.0,
        groups: Optional[npt.ArrayLike] = None,
        tolerance: float = 0.0,
        engine: str = "auto",
        threads: Optional[int] = None,
    ) -> None:
        if (radii is None) == (cutoff is None):
            raise TypeError("give radii, or the cutoff of points: one of the two")
        self._radii, self._cutoff, self._groups = radii, cutoff, groups
        self._tolerance = number(tolerance, "tolerance")
        self._engine, self._threads = engine, threads_of(threads)
        self._search = _fdem.Buffered(number(buffer, "buffer"), engine, self._threads)
        self._contacts: Optional[Contacts] = None
        self._reason: Optional[str] = None
        self._updates = self._redetections = 0

    def update(self, positions: npt.ArrayLike) -> bool:
        """Finds the contacts of the elements where they are now.

        Parameters
        ----------
        positions : array [n, 2] or [n, 3], float32 or float64
            Centres, as for :func:`contacts`.

        Returns
        -------
        bool
            Whether the couples had to be detected again; `reason` says why.
        """
        centres = points(positions, "positions")
        kind, size, others, centres = sizes_of(centres, self._radii, self._cutoff)
        groups = None if self._groups is None else numbers(self._groups, "groups", len(centres))
        elements = _fdem.Elements(centres, kind, size, others, self._tolerance, groups, None)
        pairs, self._reason = self._search.update(elements)
        found = Contacts.__new__(Contacts)
        found._elements, found._positions, found._kind, found._size, found._others = elements, centres, kind, size, others
        found._box, found._cell, found._groups, found._tolerance = None, None, groups, self._tolerance
        found._engine, found._threads, found._kept = self._engine, self._threads, {}
        found._pairs, found._shifts = pairs, np.zeros((0, centres.shape[1]), np.int32)
        self._contacts = found
        self._updates += 1
        self._redetections += self._reason is not None
        return self._reason is not None

    @property
    def contacts(self) -> Contacts:
        """What the last update has found.

        Raises ``RuntimeError`` before the first.
        """
        if self._contacts is None:
            raise RuntimeError("there are no contacts before the first update")
        return self._contacts

    @property
    def reason(self) -> Optional[str]:
        """Why the last update detected again; None if it did not."""
        return self._reason

    @property
    def updates(self) -> int:
        """How many updates there were."""
        return self._updates

    @property
    def redetections(self) -> int:
        """How many of them detected, the first one included."""
        return self._redetections

    def __repr__(self) -> str:
        return f"<fdem.Detector: {self._updates} updates, {self._redetections} of them detected>"
