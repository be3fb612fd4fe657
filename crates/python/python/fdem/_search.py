"""The search for contacts of spheres, points and boxes."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping, Sequence
from typing import Any, Optional, Union

import numpy.typing as npt

from . import _fdem
from ._box import cell_of
from ._contacts import Contacts
from ._input import Engine, Floats, alike, floats, is_number, number, numbers, points
from ._read import Packing
from ._types import PairCutoffs, numbered_types


def contacts(
    positions: Union[npt.ArrayLike, Packing],
    radii: Optional[npt.ArrayLike] = None,
    cutoff: Union[float, Mapping[tuple[Any, Any], float], None] = None,
    *,
    types: Optional[npt.ArrayLike] = None,
    box: Any = None,
    periodic: Union[bool, Sequence[bool]] = False,
    groups: Optional[npt.ArrayLike] = None,
    tolerance: float = 0.0,
    engine: Engine = "auto",
    threads: Optional[int] = None,
    device: str = "cpu",
) -> Contacts:
    """Finds all couples of spheres (discs in 2D) that touch, or of points that are at most `cutoff` apart.

    Parameters
    ----------
    positions : array [n, 2] or [n, 3], float32 or float64; or Packing
        Centres. A :class:`Packing` of :func:`read` brings its radii and its box, unless others are given. Arrays in C order are read where they are; other orders, strides, byte orders and whole numbers are converted, and float64 is never converted to
        float32. The centres must not change before `distance`, `overlap` or `vector` of the result has been asked for.
    radii : array [n] or number, optional
        The radius of each element, or of all. If positions and radii have different types, both become float64.
    cutoff : number or dict, optional
        The distance at which points touch, or a distance for each pair of `types`, ``{("H", "C"): 1.3, ("C", "C"): 1.9}``: pairs that the dict lacks form no couple. One of
        `radii` and `cutoff` must be given. A number is rounded to the type of the positions.
    types : array [n] of names or whole numbers, optional
        The type of each element, for a `cutoff` by pairs.
    box : array or Box, optional
        The box that repeats: ``[D]`` lengths of its edges from 0; ``[D, 2]`` where it starts and ends on each axis; ``[D, D]`` edges, one a row; or a
        :class:`Box`.
    periodic : bool or one for each axis (edge), default False
        The axes (edges) that repeat. Every image that touches counts, also in a box that is smaller than the elements. An element outside the box stands for its image
        inside the box.
    groups : array [n] of whole numbers, optional
        Elements with equal numbers are parts of one body and form no couple.
    tolerance : number, default 0
        The gap between surfaces that still counts as contact.
    engine : {"auto", "rows", "multilevel", "cgrid", "nbs", "direct"}
        The search method. All methods find the same couples, in different orders.
    threads : int, optional
        Number of threads. The default is one for each processor, or one thread if there are too few elements for more to be of use. Neither the couples nor their order
        depend on it.
    device : str, default "cpu"
        Where the search runs: "cpu", "gpu", or "gpu:N" with a number of ``fdem devices``. A graphics processor of NVIDIA finds the couples of the engine
        "rows", in its order.

    Returns
    -------
    Contacts
        Each couple once: ``i < j``, or ``i == j`` for an element that touches its own image. The order is that of the engine and depends on the arguments only;
        :meth:`Contacts.sorted` returns the couples in ascending order.

    Raises
    ------
    ValueError
        For NaN, infinity, negative sizes, arrays of different lengths, a box without volume: the message names the element. For a type in `cutoff` that no element has.
    TypeError
        For arguments that are not numbers, and unless exactly one of `radii` and `cutoff` is given.
    MemoryError
        If the couples do not fit.
    RuntimeError
        If the device cannot be had: the message says whether the driver, the compiler of kernels or the card is missing. Nothing runs elsewhere instead.

    Notes
    -----
    Elements touch if ``|x_i - x_j|^2 <= (r_i + r_j + tolerance)^2``, computed in the type of the positions, in this order, each operation rounded once.

    Time is proportional to the elements and the couples; one thread finds the 6 million couples of a million points with 12 neighbours each in less than a tenth
    of a second.

    Examples
    --------
    >>> import numpy as np, fdem
    >>> found = fdem.contacts(np.array([[0.0, 0, 0], [1, 0, 0], [5, 5, 5]]), radii=0.5)
    >>> found.i, found.j
    (array([0], dtype=uint32), array([1], dtype=uint32))

    Points that are at most 1.5 apart in a square that repeats:

    >>> found = fdem.contacts([[0.5, 2.0], [3.5, 2.0]], cutoff=1.5, box=[4, 4], periodic=True)
    >>> found.shift.tolist(), found.distance.tolist()
    ([[-1, 0]], [1.0])

    A cut-off for each pair of types:

    >>> fdem.contacts([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], cutoff={("H", "C"): 1.3}, types=["C", "H", "H"]).pairs.tolist()
    [[0, 1]]

    Errors name the element:

    >>> fdem.contacts([[0.0, 0.0], [1.0, float("nan")]], radii=1.0)
    Traceback (most recent call last):
    ValueError: element 1: coordinate y is NaN, not a finite number
    """
    if isinstance(positions, Packing):
        packing, positions = positions, positions.positions
        if radii is None and cutoff is None:
            if packing.radii is None:
                raise TypeError("the packing has no radii: give radii or cutoff")
            radii = packing.radii
        if box is None and packing.box is not None and any(packing.periodic):
            box, periodic = packing.box, packing.periodic
    if isinstance(positions, (str, os.PathLike)):
        raise TypeError(f"positions must be an array or a Packing; read the file first: fdem.read({os.fspath(positions)!r})")
    centres = points(positions, "positions")
    kind: str
    size: float
    others: Optional[npt.NDArray[Any]]
    cutoffs: Optional[PairCutoffs] = None
    if isinstance(cutoff, Mapping):
        if radii is not None:
            raise TypeError("give radii, or the cutoff of points: one of the two")
        others, cutoffs = numbered_types(cutoff, types, len(centres))
        kind, size = "pairs", max((limit for _, _, limit in cutoffs), default=0.0)
    elif types is not None:
        raise TypeError('types are for a cutoff by pairs of types, such as {("H", "C"): 1.3}')
    else:
        kind, size, others, centres = sizes_of(centres, radii, cutoff)
    cell_box, cell = cell_of(box, periodic, centres.shape[1])
    bodies = None if groups is None else numbers(groups, "groups", len(centres))
    elements = _fdem.Elements(centres, kind, size, others, number(tolerance, "tolerance"), bodies, cell, cutoffs=cutoffs)
    found = Contacts._search(elements, centres, kind, size, others, cell_box, bodies, float(tolerance), cell, engine, threads, cutoffs, device)
    if kind not in ("cutoff", "pairs") and (own := found._own_images()):
        warnings.warn(f"{own} couples are of an element with its own image: it touches itself across the whole box", stacklevel=2)
    return found


def boxes(
    lower: npt.ArrayLike,
    upper: npt.ArrayLike,
    *,
    box: Any = None,
    periodic: Union[bool, Sequence[bool]] = False,
    groups: Optional[npt.ArrayLike] = None,
    tolerance: float = 0.0,
    engine: Engine = "auto",
    threads: Optional[int] = None,
) -> Contacts:
    """Finds all couples of axis-aligned boxes that touch or overlap.

    Parameters
    ----------
    lower, upper : array [n, 2] or [n, 3], float32 or float64
        The corners of each box, ``lower <= upper``. If their types differ, both become float64.
    box, periodic, groups, tolerance, engine, threads
        As for :func:`contacts`. Boxes touch if the gap between them is at most `tolerance` on every axis.

    Returns
    -------
    Contacts
        Its `distance` is the distance of the closest points, 0 for boxes that overlap. Its `overlap` is the smallest overlap along an axis, negative for a gap.

    Raises
    ------
    ValueError, TypeError, MemoryError
        As :func:`contacts`.

    Examples
    --------
    >>> import fdem
    >>> found = fdem.boxes([[0, 0], [1, 0], [4, 4]], [[1, 1], [3, 2], [5, 5]])
    >>> found.pairs.tolist(), found.distance.tolist()
    ([[0, 1]], [0.0])
    """
    low, high = alike(points(lower, "lower"), points(upper, "upper"))
    if low.shape != high.shape:
        raise ValueError(f"lower has the shape {low.shape}, and upper {high.shape}")
    cell_box, cell = cell_of(box, periodic, low.shape[1])
    bodies = None if groups is None else numbers(groups, "groups", len(low))
    elements = _fdem.Elements(low, "upper", 0.0, high, number(tolerance, "tolerance"), bodies, cell)
    return Contacts._search(elements, low, "upper", 0.0, high, cell_box, bodies, float(tolerance), cell, engine, threads)


def sizes_of(
    centres: Floats, radii: Optional[npt.ArrayLike], cutoff: Optional[float]
) -> tuple[str, float, Optional[Floats], Floats]:
    """Checks the sizes: returns their kind, the size of all, the array of sizes, and the centres in the type of both."""
    if (radii is None) == (cutoff is None):
        raise TypeError("give radii, or the cutoff of points: one of the two")
    if cutoff is not None:
        if not is_number(cutoff):
            raise TypeError("cutoff is one number; if elements differ in size, give radii")
        return "cutoff", number(cutoff, "cutoff"), None, centres
    if is_number(radii):
        return "radius", number(radii, "radii"), None, centres
    each = floats(radii, "radii")
    if each.shape != (len(centres),):
        raise ValueError(f"radii must be one number, or one for each of {len(centres)} elements, not of the shape {each.shape}")
    centres, each = alike(centres, each)
    return "radii", 0.0, each, centres
