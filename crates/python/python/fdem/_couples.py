"""The couples that the functions behind the methods of `Contacts` read."""

from __future__ import annotations

from typing import Optional, Protocol

import numpy as np
import numpy.typing as npt

from . import _fdem
from ._box import Box
from ._input import Floats


class Couples(Protocol):
    """Couples of elements that touch, with the arguments of their search: a part of :class:`Contacts`."""

    _elements: _fdem.Elements
    _positions: Floats
    _kind: str
    _size: float
    _others: Optional[Floats]
    _box: Optional[Box]
    _groups: Optional[npt.NDArray[np.uint32]]
    _tolerance: float
    _cutoffs: Optional[list[tuple[int, int, float]]]
    _pairs: npt.NDArray[np.uint32]
    _shifts: npt.NDArray[np.int32]

    @property
    def n(self) -> int:
        """The number of elements."""

    @property
    def pairs(self) -> npt.NDArray[np.uint32]:
        """``[m, 2]``: the elements of each couple."""

    @property
    def i(self) -> npt.NDArray[np.uint32]:
        """``[m]``: the first element of each couple."""

    @property
    def j(self) -> npt.NDArray[np.uint32]:
        """``[m]``: the second element of each couple."""

    @property
    def shift(self) -> npt.NDArray[np.int32]:
        """``[m, D]``: the edges of the box by which the second element is displaced."""

    @property
    def distance(self) -> Floats:
        """``[m]``: the distance of the two elements."""

    @property
    def vector(self) -> Floats:
        """``[m, D]``: from the first element to the second."""
