"""The spheres of a run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

_Reals = npt.NDArray[np.float64]
_Numbers = npt.NDArray[np.uint32]


class Spheres:
    """Spheres or discs, their contacts and the walls of a :class:`Simulation` at one instant, as read-only NumPy arrays in SI units.

    All arrays of spheres have the order of :attr:`numbers`, which ascend. Vectors have three components, of which the third is 0 for discs.

    Attributes
    ----------
    numbers : ndarray of uint32
        Number of each sphere, which it keeps for the whole run.
    positions : ndarray of float64, spheres × 3
        Centres, m.
    radii : ndarray of float64
        Radii, m.
    velocities, spins : ndarray of float64, spheres × 3
        Velocities, m/s, and angular velocities, rad/s.
    forces : ndarray of float64, spheres × 3
        Forces of all contacts, N.
    masses : ndarray of float64
        Masses, kg.
    materials, groups : ndarray of uint32
        Numbers of the materials, and of the groups: places in :attr:`group_names`.
    group_names : tuple of str
        Names of the groups.
    contacts : dict of ndarray
        Contacts by column: ``sphere`` and ``other`` (places in these arrays; the second that of a sphere, a wall or a facet of the bodies), ``kind`` (0 with a sphere,
        1 with a wall, 2 with a body), ``point`` (m), ``force`` on the first sphere (N), ``normal`` (its normal part, N, positive for pressure) and ``overlap`` (m).
    wall_names : tuple of str
        Names of the walls.
    wall_forces : ndarray of float64, walls × 3
        Force of the spheres on each wall, N.
    """

    numbers: _Numbers
    positions: _Reals
    radii: _Reals
    velocities: _Reals
    spins: _Reals
    forces: _Reals
    masses: _Reals
    materials: _Numbers
    groups: _Numbers
    contacts: Mapping[str, npt.NDArray[Any]]
    wall_forces: _Reals
    group_names: tuple[str, ...]
    wall_names: tuple[str, ...]

    def __init__(self, arrays: Mapping[str, Any], groups: list[str], walls: list[str]) -> None:
        for name, values in arrays.items():
            setattr(self, name, values)
        self.group_names, self.wall_names = tuple(groups), tuple(walls)

    def __len__(self) -> int:
        return len(self.numbers)

    @property
    def coordination(self) -> npt.NDArray[np.int64]:
        """Number of contacts of each sphere, with spheres, walls and bodies."""
        among = self.contacts["kind"] == 0
        ends = np.concatenate([self.contacts["sphere"], self.contacts["other"][among]])
        return np.bincount(ends, minlength=len(self))

    def __repr__(self) -> str:
        return f"<fdem.Spheres: {len(self):,}, {len(self.contacts['sphere']):,} contacts, {len(self.wall_forces):,} walls>"
