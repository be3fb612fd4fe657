"""Contacts of meshed bodies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Optional

import numpy as np
import numpy.typing as npt

from . import _fdem
from ._input import array_of, floats, threads_of


@dataclass(frozen=True, eq=False)
class BodyContacts:
    """Couples of bodies that touch, sorted by `i`, then `j`; an entry for each."""

    i: npt.NDArray[Any]
    """``[b]``: the smaller body."""
    j: npt.NDArray[Any]
    """``[b]``: the larger body."""
    couples: npt.NDArray[np.uint64]
    """``[b]``: couples of elements, one of each body, that touch."""
    overlap: npt.NDArray[np.float64]
    """``[b]``: the area of what overlaps in 2D, the volume of tetrahedra, the length of the lines in which surfaces cross."""
    shared: npt.NDArray[np.float64]
    """``[b]``: the boundary in common: length in 2D, area in 3D. 0 for bodies that meet at nodes or edges only."""
    point: npt.NDArray[np.float64]
    """``[b, D]``: the weighted mean of the contact points."""
    normal: npt.NDArray[np.float64]
    """``[b, D]``: the weighted mean of the normals, from `i` to `j`, of length 1; zeros where they cancel out."""

    def __len__(self) -> int:
        return len(self.i)

    def __repr__(self) -> str:
        return f"<fdem.BodyContacts: {len(self):,} couples of bodies>"


@dataclass(frozen=True, eq=False)
class MeshContacts:
    """Couples of elements of a mesh that touch, sorted by `i`, then `j`, and what they amount to for the bodies."""

    i: npt.NDArray[np.uint32]
    """``[m]``: the smaller element."""
    j: npt.NDArray[np.uint32]
    """``[m]``: the larger element."""
    measure: npt.NDArray[np.float64]
    """``[m]``: the area of the overlap in 2D; the volume of tetrahedra; of surfaces the length, or the area if they are coplanar. 0 for a mere touch."""
    point: npt.NDArray[np.float64]
    """``[m, D]``: where."""
    normal: npt.NDArray[np.float64]
    """``[m, D]``: from `i` to `j`, of length 1."""
    bodies: BodyContacts
    """The contacts of the bodies."""

    def __len__(self) -> int:
        return len(self.i)

    def __repr__(self) -> str:
        return f"<fdem.MeshContacts: {len(self):,} couples of elements, {len(self.bodies):,} of bodies>"


def mesh(
    nodes: npt.ArrayLike,
    cells: npt.ArrayLike,
    bodies: Optional[npt.ArrayLike] = None,
    *,
    self_contact: bool = False,
    threads: Optional[int] = None,
) -> MeshContacts:
    """Finds which elements of a mesh touch elements of other bodies, where, and how much; and which bodies.

    Parameters
    ----------
    nodes : array [n, 2] or [n, 3]
        Coordinates, computed with in float64.
    cells : array [m, 3] or [m, 4] of whole numbers
        The nodes of each element: triangles in 2D or, as surfaces, in 3D; tetrahedra in 3D.
    bodies : array [m] of whole numbers, optional
        The body of each element. Elements of one body form no couple. Without it all are one body, which makes sense with `self_contact` only.
    self_contact : bool, default False
        Whether elements of one body form couples too, unless they have a node in common.
    threads : int, optional
        One for each processor by default. The result does not depend on it.

    Returns
    -------
    MeshContacts
        Touching counts: bodies that have a node in common touch there.

    Raises
    ------
    ValueError
        For nodes that are not there, NaN, coordinates beyond the range of exact arithmetic; it names the element or node.
    TypeError
        For cells that are no whole numbers; without `bodies` and `self_contact`.

    Examples
    --------
    Two squares of two triangles each, side by side:

    >>> import fdem
    >>> nodes = [[0, 0], [1, 0], [1, 1], [0, 1], [2, 0], [2, 1]]
    >>> found = fdem.mesh(nodes, [[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]], bodies=[1, 1, 7, 7])
    >>> found
    <fdem.MeshContacts: 3 couples of elements, 1 of bodies>
    >>> found.bodies.i.tolist(), found.bodies.j.tolist(), found.bodies.shared.tolist()
    ([1], [7], [1.0])
    """
    if bodies is None and not self_contact:
        raise TypeError("give bodies: elements of one body form no couple unless self_contact is True")
    coordinates = floats(nodes, "nodes").astype(np.float64)
    if coordinates.ndim != 2:
        raise ValueError(f"nodes must have the shape [n, 2] or [n, 3], not {coordinates.shape}")
    elements = array_of(cells, "cells")
    if elements.ndim != 2:
        raise ValueError(f"cells must have the shape [m, 3] or [m, 4], not {elements.shape}")
    if elements.dtype.kind not in "iu":
        raise TypeError(f"cells must be whole numbers, not {elements.dtype}")
    wrong = (elements < 0) | (elements >= len(coordinates))
    if wrong.any():
        element, corner = (int(k) for k in np.argwhere(wrong)[0])
        raise ValueError(f"element {element}: there is no node {elements[element, corner]} among {len(coordinates)}")
    names, numbers = _numbers_of(bodies, len(elements))
    elements = np.require(elements, np.uint32, ["C", "A"])
    found, of_bodies = _fdem.mesh(np.require(coordinates, np.float64, ["C", "A"]), elements, numbers, bool(self_contact), threads_of(threads))
    of_bodies["i"], of_bodies["j"] = names[of_bodies["i"]], names[of_bodies["j"]]
    return MeshContacts(bodies=BodyContacts(**of_bodies), **found)


def _numbers_of(bodies: Optional[npt.ArrayLike], elements: int) -> tuple[npt.NDArray[Any], npt.NDArray[np.uint32]]:
    """What bodies are called, ascending, and the place of that of each element."""
    if bodies is None:
        return np.zeros(1, np.int64), np.zeros(elements, np.uint32)
    array = array_of(bodies, "bodies")
    if array.shape != (elements,):
        raise ValueError(f"bodies must have one number for each of {elements} elements, not the shape {array.shape}")
    if array.dtype.kind not in "iu" and elements:
        raise TypeError(f"bodies must be whole numbers, not {array.dtype}")
    names, numbers = np.unique(array, return_inverse=True)
    return names, np.require(numbers.reshape(elements), np.uint32, ["C", "A"])
