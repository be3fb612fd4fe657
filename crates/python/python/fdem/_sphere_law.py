"""Laws of spheres that a program computes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Union

import numpy as np
import numpy.typing as npt

_Reals = npt.NDArray[np.float64]
_Numbers = npt.NDArray[np.uint32]


class SpherePairs:
    """The couples of spheres of a step, as a law of :meth:`Simulation.set_sphere_law` gets them: arrays with a row for each couple, in ascending order of the numbers.

    All arrays but :attr:`memory` are read-only.

    Attributes
    ----------
    time, step : float
        Time of the positions, and time step, s.
    spheres : ndarray of uint32, couples × 2
        Numbers of the first and the second sphere; the first has the lower one.
    materials : ndarray of uint32, couples × 2
        Numbers of their materials.
    radii, masses : ndarray of float64, couples × 2
        m and kg; the mass of a sphere in a clump is that of the clump.
    normals : ndarray of float64, couples × 3
        From the second sphere to the first, of unit length.
    overlaps : ndarray of float64
        m; negative where the spheres are apart.
    velocities : ndarray of float64, couples × 3
        Velocity of the first over that of the second where they touch, m/s.
    spins : ndarray of float64, couples × 2 × 3
        Angular velocities of both, rad/s.
    memory : ndarray of float64, couples × columns
        The numbers that the law has left there for each couple in the last step; 0 for a couple that is new. The law may change them in place.
    """

    time: float
    step: float
    spheres: _Numbers
    materials: _Numbers
    radii: _Reals
    masses: _Reals
    normals: _Reals
    overlaps: _Reals
    velocities: _Reals
    spins: _Reals
    memory: _Reals

    def __init__(self, columns: Mapping[str, Any]) -> None:
        for name, values in columns.items():
            if isinstance(values, np.ndarray) and name != "memory":
                values.flags.writeable = False
            setattr(self, name, values)

    def __len__(self) -> int:
        """The number of couples."""
        return len(self.spheres)

    def __repr__(self) -> str:
        """Says how many couples there are, and when."""
        return f"SpherePairs({len(self)} couples at {self.time:g} s)"


SphereLaw = Callable[[SpherePairs], Union[npt.ArrayLike, tuple[npt.ArrayLike, npt.ArrayLike]]]


def _rows(name: str, values: npt.ArrayLike, count: int) -> _Reals:
    rows = np.asarray(values, dtype=np.float64)
    if rows.shape not in ((), (count, 3)):
        raise ValueError(f"a law returns {name} of the shape ({count}, 3), one row for each couple, not {rows.shape}")
    return np.ascontiguousarray(np.broadcast_to(rows, (count, 3)))


def with_arrays(law: SphereLaw) -> Callable[[Mapping[str, Any]], tuple[_Reals, _Reals]]:
    """Returns the law as a function of columns, which returns the forces and the moments of all couples."""

    def call(columns: Mapping[str, Any]) -> tuple[_Reals, _Reals]:
        pairs = SpherePairs(columns)
        result = law(pairs)
        if result is None:
            raise ValueError("the law of spheres has returned nothing: it returns forces, or forces and moments")
        forces, moments = result if isinstance(result, tuple) else (result, 0.0)
        return _rows("forces", forces, len(pairs)), _rows("moments", moments, len(pairs))

    return call
