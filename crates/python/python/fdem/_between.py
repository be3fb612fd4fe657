"""Contacts of two sets of spheres or points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

from ._input import Engine, Floats, alike, floats, is_number, number, points
from ._search import contacts


@dataclass(frozen=True, eq=False)
class CrossContacts:
    """Couples of an element of one set and an element of another that touch, sorted by `i`, then `j`, then `shift`."""

    i: npt.NDArray[np.uint32]
    """``[m]``: the element of the first set."""
    j: npt.NDArray[np.uint32]
    """``[m]``: the element of the second set."""
    distance: Floats
    """``[m]``: the distance of the centres."""
    overlap: Floats
    """``[m]``: the sum of the radii, or the cut-off, less the distance; negative for a gap within the tolerance."""
    shift: npt.NDArray[np.int32]
    """``[m, D]``: the edges by which `j` is displaced where it touches `i`; zeros without a box that repeats."""

    def __len__(self) -> int:
        return len(self.i)

    def __repr__(self) -> str:
        return f"<fdem.CrossContacts: {len(self):,} couples>"


def between(
    positions: npt.ArrayLike,
    others: npt.ArrayLike,
    radii: Optional[npt.ArrayLike] = None,
    other_radii: Optional[npt.ArrayLike] = None,
    cutoff: Optional[float] = None,
    *,
    box: Any = None,
    periodic: Union[bool, Sequence[bool]] = False,
    tolerance: float = 0.0,
    engine: Engine = "auto",
    threads: Optional[int] = None,
) -> CrossContacts:
    """Finds which spheres (discs in 2D) of one set touch spheres of another; couples within a set are left out.

    Parameters
    ----------
    positions, others : array [n, D] and array [m, D], float32 or float64
        The centres of both sets. If types differ, all become float64.
    radii, other_radii : array or number
        The radii of both sets.
    cutoff : number
        In place of radii: the distance at which points touch.
    box, periodic, tolerance, engine, threads
        As for :func:`contacts`.

    Returns
    -------
    CrossContacts
        ``i, j, distance, overlap, shift``: `i` is an element of the first set, `j` one of the second.

    Raises
    ------
    ValueError, TypeError, MemoryError
        As :func:`contacts`. Messages number the elements of the first set, then those of the second.

    Examples
    --------
    >>> import fdem
    >>> found = fdem.between([[0.0, 0.0], [1.0, 0.0]], [[2.0, 0.0], [1.0, 1.0]], radii=0.5, other_radii=0.5)
    >>> list(zip(found.i.tolist(), found.j.tolist()))
    [(1, 0), (1, 1)]
    """
    one, two = alike(points(positions, "positions"), points(others, "others"))
    if one.shape[1] != two.shape[1]:
        raise ValueError(f"positions have {one.shape[1]} coordinates, and others {two.shape[1]}")
    sizes = None
    if cutoff is None:
        if radii is None or other_radii is None:
            raise TypeError("give radii and other_radii, or the cutoff of points")
        of_one, of_two = _radii_of(radii, "radii", one), _radii_of(other_radii, "other_radii", two)
        sizes = np.concatenate(alike(of_one, of_two))
    elif radii is not None or other_radii is not None:
        raise TypeError("give radii and other_radii, or the cutoff of points")
    # Elements with equal numbers form no couple.
    groups = np.repeat(np.array([0, 1], np.uint32), [len(one), len(two)])
    options = {"box": box, "periodic": periodic, "tolerance": tolerance, "groups": groups, "engine": engine, "threads": threads}
    found = contacts(np.concatenate([one, two]), sizes, cutoff, **options).sorted()
    return CrossContacts(found.i.copy(), found.j - np.uint32(len(one)), found.distance, found.overlap, found.shift)


def _radii_of(radii: npt.ArrayLike, name: str, centres: Floats) -> Floats:
    if is_number(radii):
        return np.full(len(centres), number(radii, name), centres.dtype)
    each = floats(radii, name)
    if each.shape != (len(centres),):
        raise ValueError(f"{name} must be one number, or one for each of {len(centres)} elements, not of the shape {each.shape}")
    return each
