"""Searches that follow moving elements."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Optional, Union

import numpy.typing as npt

from . import _fdem
from ._box import cell_of
from ._contacts import Contacts
from ._input import Engine, number, numbers, points, threads_of
from ._search import sizes_of


class Detector:
    """Follows moving elements: it finds their contacts at each update, and searches only when an element has moved too far.

    With a buffer it keeps all couples whose surfaces are at most `buffer` apart. As long as no element has moved by more than half the buffer, relative to the mean
    motion of all, these contain every couple that touches, and an update only tests them. In a box that repeats, a motion by whole edges is no motion: elements may
    leave the box or be put back into it.

    A copy, also one that was pickled, has the contacts and the counts of the original, and searches at its next update.

    Parameters
    ----------
    radii, cutoff, box, periodic, groups, tolerance, engine, threads
        As for :func:`contacts`. The box may be changed between updates: set `box` and `periodic`.
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

    Across the faces of a box that repeats:

    >>> detector = fdem.Detector(radii=0.5, buffer=0.4, box=[4, 4], periodic=True)
    >>> detector.update(np.array([[0.2, 1.0], [3.3, 1.0]])), detector.contacts.shift.tolist()
    (True, [[-1, 0]])
    >>> detector.update(np.array([[3.95, 1.0], [3.2, 1.0]])), detector.contacts.shift.tolist()
    (False, [[0, 0]])
    """

    def __init__(
        self,
        radii: Optional[npt.ArrayLike] = None,
        cutoff: Optional[float] = None,
        *,
        buffer: float = 0.0,
        box: Any = None,
        periodic: Union[bool, Sequence[bool]] = False,
        groups: Optional[npt.ArrayLike] = None,
        tolerance: float = 0.0,
        engine: Engine = "auto",
        threads: Optional[int] = None,
    ) -> None:
        if (radii is None) == (cutoff is None):
            raise TypeError("give radii, or the cutoff of points: one of the two")
        self._radii, self._cutoff, self._groups = radii, cutoff, groups
        self.box, self.periodic = box, periodic
        self._tolerance = number(tolerance, "tolerance")
        self._buffer = number(buffer, "buffer")
        self._engine, self._threads = engine, threads_of(threads)
        self._search = _fdem.Buffered(self._buffer, engine, self._threads)
        self._contacts: Optional[Contacts] = None
        self._reason: Optional[str] = None
        self._updates = self._redetections = 0

    def __getstate__(self) -> dict[str, Any]:
        state = dict(self.__dict__)
        # Working memory and candidates: the next update makes new ones.
        del state["_search"]
        return state

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._search = _fdem.Buffered(self._buffer, self._engine, self._threads)

    def update(self, positions: npt.ArrayLike) -> bool:
        """Finds the contacts of the elements where they are now.

        Parameters
        ----------
        positions : array [n, 2] or [n, 3], float32 or float64
            Centres, as for :func:`contacts`.

        Returns
        -------
        bool
            Whether the elements had to be searched; `reason` says why.
        """
        centres = points(positions, "positions")
        kind, size, others, centres = sizes_of(centres, self._radii, self._cutoff)
        groups = None if self._groups is None else numbers(self._groups, "groups", len(centres))
        of_box, cell = cell_of(self.box, self.periodic, centres.shape[1])
        elements = _fdem.Elements(centres, kind, size, others, self._tolerance, groups, cell)
        (pairs, shifts), self._reason = self._search.update(elements)
        arguments = (elements, centres, kind, size, others, of_box, groups, self._tolerance, cell, self._engine, self._threads)
        self._contacts = Contacts._of(arguments, pairs, shifts)
        self._updates += 1
        self._redetections += self._reason is not None
        return self._reason is not None

    @property
    def contacts(self) -> Contacts:
        """The contacts at the last update.

        Raises ``RuntimeError`` before the first.
        """
        if self._contacts is None:
            raise RuntimeError("there are no contacts before the first update")
        return self._contacts

    @property
    def reason(self) -> Optional[str]:
        """The reason why the last update searched; None if it did not."""
        return self._reason

    @property
    def updates(self) -> int:
        """The number of updates."""
        return self._updates

    @property
    def redetections(self) -> int:
        """The number of updates that searched, including the first one."""
        return self._redetections

    def __repr__(self) -> str:
        return f"<fdem.Detector: {self._updates} updates, {self._redetections} of them searched>"
