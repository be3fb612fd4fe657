"""Contacts of bodies in labelled images."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _fdem
from ._input import array_of, is_number, number, threads_of, whole


@dataclass(frozen=True, eq=False)
class LabelContacts:
    """Couples of labels that touch in an image, sorted by `i`, then `j`."""

    i: npt.NDArray[Any]
    """``[m]``: the smaller label."""
    j: npt.NDArray[Any]
    """``[m]``: the larger label."""
    faces: npt.NDArray[np.uint64]
    """``[m]``: pairs of neighbouring pixels (voxels), one of each label, that share a face."""
    edges: npt.NDArray[np.uint64]
    """``[m]``: pairs that meet along an edge; 0 unless `neighbourhood` includes edges."""
    vertices: npt.NDArray[np.uint64]
    """``[m]``: pairs that meet at a vertex; 0 unless `neighbourhood` includes vertices."""
    area: npt.NDArray[np.float64]
    """``[m]``: the area of the faces (length in 2D), in the unit of the spacing."""
    point: npt.NDArray[np.float64]
    """``[m, D]``: the mean position of the contact along the axes of the image; the first pixel starts at 0."""
    normal: npt.NDArray[np.float64]
    """``[m, D]``: the mean direction from `i` to `j`, of length 1; zeros where it cancels out."""
    bodies: int
    """The number of labels, including those without contacts, without the background."""

    def __len__(self) -> int:
        return len(self.i)

    def __repr__(self) -> str:
        return f"<fdem.LabelContacts: {len(self):,} contacts of {self.bodies:,} bodies>"


def labels(
    image: npt.ArrayLike,
    *,
    neighbourhood: Literal["face", "edge", "vertex"] = "face",
    background: Optional[int] = 0,
    spacing: Union[float, Sequence[float], None] = None,
    threads: Optional[int] = None,
) -> LabelContacts:
    """Finds which bodies touch in an image whose numbers are the bodies of its pixels (voxels).

    Parameters
    ----------
    image : array [rows, columns] or [planes, rows, columns] of whole numbers
        An array in C order of type uint8, uint16, uint32, uint64, int32 or int64 is read where it is; others are converted.
    neighbourhood : {"face", "edge", "vertex"}
        The pixels that are neighbours: those that share a face, an edge, or a vertex; each kind includes the kinds before it. In 2D there is no "edge".
    background : int or None, default 0
        The label that is not a body; None if all labels are bodies.
    spacing : number or one for each axis of the array, default 1
        The edges of a pixel.
    threads : int, optional
        Number of threads; one for each processor by default. The result does not depend on it.

    Returns
    -------
    LabelContacts
        ``i, j, faces, edges, vertices, area, point, normal``, and `bodies`, the number of bodies. Axes are in the order of the array.

    Raises
    ------
    ValueError
        For an image of other dimensions, a spacing that is not positive.
    TypeError
        For an image that is not of whole numbers.

    Examples
    --------
    >>> import fdem
    >>> found = fdem.labels([[1, 1, 0], [2, 2, 3]])
    >>> list(zip(found.i.tolist(), found.j.tolist(), found.area.tolist()))
    [(1, 2, 2.0), (2, 3, 1.0)]
    >>> found.normal.tolist()
    [[1.0, 0.0], [0.0, 1.0]]
    """
    array = array_of(image, "image")
    if array.dtype.kind not in "biu":
        raise TypeError(f"labels must be whole numbers, not {array.dtype}")
    if array.ndim not in (2, 3):
        raise ValueError(f"an image has 2 or 3 axes, not {array.ndim}")
    dtype: np.dtype[Any]
    if array.dtype.kind == "b":
        dtype = np.dtype(np.uint8)
    elif array.dtype.kind == "i" and array.dtype.itemsize < 4:
        dtype = np.dtype(np.int32)
    else:
        dtype = array.dtype.newbyteorder("=")
    array = np.require(array, dtype, ["C", "A"])
    none = None if background is None else whole(background, "background", -(2**63))
    if spacing is None:
        edges = [1.0] * array.ndim
    elif is_number(spacing):
        edges = [number(spacing, "spacing")] * array.ndim
    else:
        edges = [number(edge, "spacing") for edge in np.asarray(spacing).ravel()]
        if len(edges) != array.ndim:
            raise ValueError(f"spacing must be one number, or one for each of {array.ndim} axes, not {len(edges)}")
    return LabelContacts(**_fdem.labels(array, neighbourhood, none, edges, threads_of(threads)))
