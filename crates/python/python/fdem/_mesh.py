"""Contacts of meshed bodies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Optional

import numpy as np
import numpy.typing as npt

from . import _fdem
from ._input import array_of, floats, is_number, number, threads_of


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
    """``[b]``: the area of the overlap in 2D, its volume for tetrahedra, the length of the lines in which surfaces cross."""
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
    """Couples of elements of a mesh that touch, sorted by `i`, then `j`, and the contacts of the bodies that follow from them."""

    i: npt.NDArray[np.uint32]
    """``[m]``: the smaller element."""
    j: npt.NDArray[np.uint32]
    """``[m]``: the larger element."""
    measure: npt.NDArray[np.float64]
    """``[m]``: the area of the overlap in 2D; its volume for tetrahedra; for surfaces its length, or its area if they are coplanar. 0 for a mere touch."""
    point: npt.NDArray[np.float64]
    """``[m, D]``: the contact point."""
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
    """Finds which elements of a mesh touch elements of other bodies, with the place and the size of each contact, and which bodies touch.

    Parameters
    ----------
    nodes : array [n, 2] or [n, 3]
        Coordinates, computed with in float64.
    cells : array [m, 3] or [m, 4] of whole numbers
        The nodes of each element: triangles in 2D or, as surfaces, in 3D; tetrahedra in 3D.
    bodies : array [m] of whole numbers, optional
        The body of each element. Elements of one body form no couple. Without it all elements are one body, which makes sense with `self_contact` only.
    self_contact : bool, default False
        Whether elements of one body form couples too, unless they have a node in common.
    threads : int, optional
        Number of threads; one for each processor by default. The result does not depend on it.

    Returns
    -------
    MeshContacts
        Elements that just touch count: bodies that have a node in common touch there.

    Raises
    ------
    ValueError
        For nodes that are not there, NaN, coordinates beyond the range of exact arithmetic. The message names the element or node.
    TypeError
        For cells that are not whole numbers; without `bodies` and `self_contact`.

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
    coordinates, elements = _mesh_of(nodes, cells, "element")
    names, numbers = _numbers_of(bodies, len(elements))
    found, of_bodies = _fdem.mesh(coordinates, elements, numbers, bool(self_contact), threads_of(threads))
    of_bodies["i"], of_bodies["j"] = names[of_bodies["i"]], names[of_bodies["j"]]
    return MeshContacts(bodies=BodyContacts(**of_bodies), **found)


@dataclass(frozen=True, eq=False)
class WallContacts:
    """Contacts of spheres with the surfaces of bodies, sorted by `i`, then `body`, then `triangle`."""

    i: npt.NDArray[np.uint32]
    """``[m]``: the sphere."""
    triangle: npt.NDArray[np.uint32]
    """``[m]``: the triangle; of several that have the contact, the first."""
    body: npt.NDArray[Any]
    """``[m]``: the body of the triangle."""
    overlap: npt.NDArray[np.float64]
    """``[m]``: how deep the triangle is in the sphere; 0 for a mere touch."""
    point: npt.NDArray[np.float64]
    """``[m, 3]``: the point of the triangle closest to the centre."""
    normal: npt.NDArray[np.float64]
    """``[m, 3]``: from the sphere to the triangle, of length 1."""

    def __len__(self) -> int:
        return len(self.i)

    def __repr__(self) -> str:
        return f"<fdem.WallContacts: {len(self):,} contacts of spheres with walls>"


def walls(
    positions: npt.ArrayLike,
    radii: npt.ArrayLike,
    nodes: npt.ArrayLike,
    triangles: npt.ArrayLike,
    bodies: Optional[npt.ArrayLike] = None,
    *,
    threads: Optional[int] = None,
) -> WallContacts:
    """Finds which spheres touch walls, which are meshes of triangles: a drum, a box, a silo.

    Each face, edge and vertex of a body counts once: a sphere on a flat wall has one contact with it wherever it stands, and in a corner one with each wall.

    Parameters
    ----------
    positions : array [n, 3]
        The centres, computed with in float64.
    radii : array [n] or number
        The radii.
    nodes : array [p, 3]
        The corners of the triangles.
    triangles : array [t, 3] of whole numbers
        The nodes of each triangle.
    bodies : array [t] of whole numbers, optional
        The body of each triangle; all are one body by default.
    threads : int, optional
        Number of threads; one for each processor by default. The result does not depend on it.

    Returns
    -------
    WallContacts
        ``i, triangle, body, overlap, point, normal``.

    Raises
    ------
    ValueError
        For nodes that are not there, NaN, negative radii, coordinates beyond the range of exact arithmetic; it names the sphere, triangle or node.
    TypeError
        For triangles that are not whole numbers.

    Examples
    --------
    A ball on a floor of two triangles:

    >>> import fdem
    >>> nodes = [[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0]]
    >>> found = fdem.walls([[2.0, 2.0, 0.75]], 1.0, nodes, [[0, 1, 2], [0, 2, 3]])
    >>> found.i.tolist(), found.overlap.tolist(), found.normal.tolist()
    ([0], [0.25], [[0.0, 0.0, -1.0]])
    """
    centres = np.require(floats(positions, "positions"), np.float64, ["C", "A"])
    if centres.ndim != 2 or centres.shape[1] != 3:
        raise ValueError(f"positions must have the shape [n, 3], not {centres.shape}")
    if is_number(radii):
        each = np.full(len(centres), number(radii, "radii"))
    else:
        each = np.require(floats(radii, "radii"), np.float64, ["C", "A"])
    if each.shape != (len(centres),):
        raise ValueError(f"radii must be one number, or one for each of {len(centres)} spheres, not of the shape {each.shape}")
    coordinates, elements = _mesh_of(nodes, triangles, "triangle")
    if coordinates.shape[1] != 3 or elements.shape[1] != 3:
        raise ValueError(f"walls are triangles in 3D: {elements.shape[1]} nodes each in {coordinates.shape[1]}D are not")
    names, numbers = _numbers_of(bodies, len(elements))
    found = _fdem.walls(centres, each, coordinates, elements, numbers, threads_of(threads))
    found["body"] = names[found["body"]]
    return WallContacts(**found)


def _mesh_of(nodes: npt.ArrayLike, cells: npt.ArrayLike, noun: str) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.uint32]]:
    """The nodes and the elements of a mesh, each element with nodes that are there."""
    coordinates = np.require(floats(nodes, "nodes"), np.float64, ["C", "A"])
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
        raise ValueError(f"{noun} {element}: there is no node {elements[element, corner]} among {len(coordinates)}")
    return coordinates, np.require(elements, np.uint32, ["C", "A"])


def _numbers_of(bodies: Optional[npt.ArrayLike], elements: int) -> tuple[npt.NDArray[Any], npt.NDArray[np.uint32]]:
    """The names of the bodies, ascending, and for each element the index of the name of its body."""
    if bodies is None:
        return np.zeros(1, np.int64), np.zeros(elements, np.uint32)
    array = array_of(bodies, "bodies")
    if array.shape != (elements,):
        raise ValueError(f"bodies must have one number for each of {elements} elements, not the shape {array.shape}")
    if array.dtype.kind not in "iu" and elements:
        raise TypeError(f"bodies must be whole numbers, not {array.dtype}")
    names, numbers = np.unique(array, return_inverse=True)
    return names, np.require(numbers.reshape(elements), np.uint32, ["C", "A"])
