"""Boxes that repeat."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Union

import numpy as np
import numpy.typing as npt

from ._input import AXES, axes, floats


@dataclass(frozen=True)
class Box:
    """A box that repeats: an origin, and edges of any direction.

    Every value of ``box=`` is converted to a ``Box``. Make one yourself where the short forms are ambiguous, or for a sheared box that does not start at 0.

    Parameters
    ----------
    edges : array [D, D]
        The edges, one a row.
    origin : array [D], optional
        The corner from which they start; zeros otherwise.

    Examples
    --------
    >>> from fdem import Box
    >>> Box.of([4.0, 2.0], 2)
    Box(edges=[[4.0, 0.0], [0.0, 2.0]], origin=[0.0, 0.0])
    >>> Box.from_bounds([-1, -1], [3, 1])
    Box(edges=[[4.0, 0.0], [0.0, 2.0]], origin=[-1.0, -1.0])
    """

    edges: npt.NDArray[np.float64]
    origin: npt.NDArray[np.float64]

    def __init__(self, edges: Any, origin: Any = None) -> None:
        of_edges = floats(edges, "box").astype(np.float64)
        if of_edges.shape not in ((2, 2), (3, 3)):
            raise ValueError(f"edges of a box must have the shape [2, 2] or [3, 3], not {of_edges.shape}")
        dimensions = len(of_edges)
        start = np.zeros(dimensions) if origin is None else floats(origin, "origin of the box").astype(np.float64)
        if start.shape != (dimensions,):
            raise ValueError(f"the origin of the box must have {dimensions} coordinates, not the shape {start.shape}")
        object.__setattr__(self, "edges", of_edges)
        object.__setattr__(self, "origin", start)

    @classmethod
    def from_bounds(cls, lower: Any, upper: Any) -> Box:
        """The box between two corners, with edges along the axes.

        Raises
        ------
        ValueError
            If ``lower < upper`` does not hold on an axis.
        """
        low, high = (floats(corner, "box").astype(np.float64) for corner in (lower, upper))
        if low.shape != high.shape or low.shape not in ((2,), (3,)):
            raise ValueError(f"the corners of a box must have 2 or 3 coordinates each, not {low.shape} and {high.shape}")
        for axis in range(len(low)):
            if not low[axis] < high[axis]:
                raise ValueError(f"box: along {AXES[axis]} {low[axis]} is not below {high[axis]}")
        return cls(np.diag(high - low), low)

    @classmethod
    def of(cls, box: Any, dimensions: int) -> Box:
        """Converts a description of a box.

        Parameters
        ----------
        box : Box, freud.box.Box or array
            A box of freud has its middle at 0. ``[D]``: lengths of the edges along the axes, from 0. ``[D, 2]``: where the box starts and ends on each axis. ``[D, D]``: the edges, one a row, from
            0. In 2D the last two have one shape; an array that could be either is refused.
        dimensions : int
            D.

        Raises
        ------
        ValueError, TypeError
            If it is none of these.
        """
        if isinstance(box, Box):
            if len(box.origin) != dimensions:
                raise ValueError(f"the box has {len(box.origin)} dimensions, the positions have {dimensions}")
            return box
        if _is_of_freud(box):
            of_box = 2 if box.is2D else 3
            if of_box != dimensions:
                raise ValueError(f"the box of freud has {of_box} dimensions, the positions have {dimensions}: give positions with {of_box} coordinates")
            # Its edges are the columns.
            edges = np.asarray(box.to_matrix(), np.float64).T[:dimensions, :dimensions]
            return cls(edges, -0.5 * edges.sum(axis=0))
        if np.ndim(box) == 0:
            raise TypeError(f"box must be lengths, pairs (lower, upper), or edges: {dimensions} of them, not one number")
        array = floats(box, "box").astype(np.float64)
        if array.shape == (dimensions,):
            return cls.from_bounds(np.zeros(dimensions), array)
        are_edges = array.shape == (dimensions, dimensions)
        are_bounds = array.shape == (dimensions, 2)
        if are_edges and are_bounds:
            are_bounds = bool((array[:, 0] < array[:, 1]).all())
            are_edges = bool(np.linalg.det(array) > 0)
            if are_bounds and are_edges:
                raise ValueError(
                    "box: this may be edges or bounds: say fdem.Box(edges) or fdem.Box.from_bounds(lower, upper)"
                )
        if are_bounds:
            return cls.from_bounds(array[:, 0], array[:, 1])
        if array.shape == (dimensions, dimensions):
            return cls(array)
        raise ValueError(
            f"box must be {dimensions} lengths, {dimensions} pairs (lower, upper), or a {dimensions}x{dimensions} matrix of edges, "
            f"not of the shape {array.shape}"
        )

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Box):
            return NotImplemented
        return np.array_equal(self.edges, other.edges) and np.array_equal(self.origin, other.origin)

    def __hash__(self) -> int:
        return hash((self.edges.tobytes(), self.origin.tobytes()))

    def __repr__(self) -> str:
        return f"Box(edges={self.edges.tolist()}, origin={self.origin.tolist()})"


def _is_of_freud(box: Any) -> bool:
    return all(hasattr(box, name) for name in ("to_matrix", "is2D", "periodic", "xy"))


Cell = tuple[list[float], list[list[float]], list[bool]]


def cell_of(box: Any, periodic: Union[bool, Sequence[bool]], dimensions: int) -> tuple[Union[Box, None], Union[Cell, None]]:
    """The box, and the box as the extension module takes it; None for both if nothing repeats."""
    repeats = axes(periodic, dimensions)
    if box is None:
        if any(repeats):
            raise ValueError("periodic needs a box: lengths, pairs (lower, upper), or a matrix of edges")
        return None, None
    if _is_of_freud(box) and np.ndim(periodic) == 0 and not any(repeats):
        # Such a box says it itself.
        repeats = [bool(along) for along in box.periodic[:dimensions]]
    if np.ndim(periodic) == 0 and not any(repeats):
        raise ValueError("a box that does not repeat plays no part: give periodic=True, or one bool for each axis")
    of_box = Box.of(box, dimensions)
    if not any(repeats):
        return None, None
    return of_box, (of_box.origin.tolist(), of_box.edges.tolist(), repeats)
