"""Neighbour lists as ASE and matscipy spell them."""

from __future__ import annotations

from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _fdem
from ._box import Box
from ._contacts import Contacts, contacts
from ._input import array_of, is_number, number, points

_SYMBOLS = (
    "X H He Li Be B C N O F Ne Na Mg Al Si P S Cl Ar K Ca Sc Ti V Cr Mn Fe Co Ni Cu Zn Ga Ge As Se Br Kr Rb Sr Y Zr Nb Mo Tc Ru Rh Pd Ag Cd In Sn Sb Te I Xe "
    "Cs Ba La Ce Pr Nd Pm Sm Eu Gd Tb Dy Ho Er Tm Yb Lu Hf Ta W Re Os Ir Pt Au Hg Tl Pb Bi Po At Rn Fr Ra Ac Th Pa U Np Pu Am Cm Bk Cf Es Fm Md No Lr Rf Db Sg "
    "Bh Hs Mt Ds Rg Cn Nh Fl Mc Lv Ts Og"
).split()

_MARGIN = 1e-9
"""Relative to the cut-off: candidates are found with a little more, and then decided by the sums of ASE."""


def neighbor_list(
    quantities: str,
    atoms: Any = None,
    cutoff: Union[float, npt.ArrayLike, dict[tuple[Any, Any], float], None] = None,
    self_interaction: bool = False,
    *,
    positions: Optional[npt.ArrayLike] = None,
    cell: Optional[npt.ArrayLike] = None,
    pbc: Union[bool, npt.ArrayLike, None] = None,
    numbers: Optional[npt.ArrayLike] = None,
    cell_origin: Optional[npt.ArrayLike] = None,
    threads: Optional[int] = None,
) -> Any:
    """All pairs of atoms that are less than a cut-off apart, as ``ase.neighborlist.neighbor_list`` and ``matscipy.neighbours.neighbour_list`` list them.

    For those who migrate; :func:`contacts` lists each couple once, counts what touches, and is faster.

    Parameters
    ----------
    quantities : str
        What is returned, a letter each: ``i`` first atom, ``j`` second atom, ``d`` distance, ``D`` vector from the first to the second, ``S`` shift of the second in
        edges of the cell, so that ``D = positions[j] - positions[i] + S @ cell``.
    atoms : ase.Atoms or alike, optional
        What has ``positions``, ``cell`` and ``pbc``, and for a `cutoff` by elements ``numbers``.
    cutoff : number, array [n] or dict
        One distance; a radius for each atom, of which two are added; or a distance for each pair of elements, ``{("H", "O"): 1.2, (1, 1): 0.8}``, and none for
        others.
    self_interaction : bool, default False
        Whether each atom is its own neighbour at distance 0.
    positions, cell, pbc, numbers, cell_origin
        In place of `atoms`. A cell is a matrix of edges, or their lengths; edges of zero length are allowed where nothing repeats.
    threads : int, optional
        One for each processor by default. The result does not depend on it.

    Returns
    -------
    array, or tuple of arrays
        In the order of `quantities`: int64 ``[m]``, float64 ``[m]``, ``[m, 3]``, and int64 ``[m, 3]``. Each pair is there from both sides, and each image counts.
        Sorted by ``i``, then ``j``.

    Raises
    ------
    ValueError, TypeError
        As :func:`contacts`; for letters and elements that are none.

    Examples
    --------
    >>> import fdem
    >>> i, j, S = fdem.neighbor_list("ijS", positions=[[0.0, 0, 0]], cell=[1.0, 9.0, 9.0], pbc=True, cutoff=1.5)
    >>> i.tolist(), S.tolist()
    ([0, 0], [[-1, 0, 0], [1, 0, 0]])
    """
    for letter in quantities:
        if letter not in "ijdDS":
            raise ValueError(f"there is no quantity '{letter}': choose among i, j, d, D, S")
    if cutoff is None:
        raise TypeError("give a cutoff")
    if atoms is not None:
        positions = atoms.positions if positions is None else positions
        cell = np.asarray(atoms.cell) if cell is None else cell
        pbc = atoms.pbc if pbc is None else pbc
        if numbers is None and isinstance(cutoff, dict):
            numbers = atoms.numbers
    if positions is None:
        raise TypeError("give atoms, or positions")
    centres = points(positions, "positions").astype(np.float64)
    if centres.shape[1] != 3:
        raise ValueError(f"positions must have the shape [n, 3], not {centres.shape}")
    repeats = np.broadcast_to(np.asarray(False if pbc is None else pbc, bool), 3)
    edges, signs = _edges_of(cell, repeats)
    limits = _Limits(cutoff, numbers, len(centres))

    margin = limits.largest * _MARGIN
    if margin > 0 or len(centres) == 0:
        found = _search(centres, limits, margin, edges * signs[:, None], repeats, cell_origin, threads)
        starts, partners, couples = _fdem.csr(found.n, found.pairs, True)
        i = np.repeat(np.arange(found.n), np.diff(starts))
        j = partners.astype(np.int64)
        shift = found.shift[np.where(couples < 0, ~couples, couples)].astype(np.int64)
        shift[couples < 0] *= -1
        shift *= signs.astype(np.int64)
        vector = centres[j] - centres[i] + shift @ edges
        distance = np.sqrt((vector * vector).sum(axis=1))
        kept = distance < limits.of(i, j)
        i, j, shift, vector, distance = (column[kept] for column in (i, j, shift, vector, distance))
    else:
        i = j = np.zeros(0, np.int64)
        shift, vector, distance = np.zeros((0, 3), np.int64), np.zeros((0, 3)), np.zeros(0)
    if self_interaction:
        own = np.arange(len(centres))
        i, j = np.concatenate([i, own]), np.concatenate([j, own])
        shift = np.concatenate([shift, np.zeros((len(own), 3), np.int64)])
        vector = np.concatenate([vector, np.zeros((len(own), 3))])
        distance = np.concatenate([distance, np.zeros(len(own))])
    order = np.lexsort((*shift.T[::-1], j, i))
    columns = {"i": i, "j": j, "d": distance, "D": vector, "S": shift}
    listed = tuple(columns[letter][order] for letter in quantities)
    return listed[0] if len(listed) == 1 else listed


def _search(
    centres: npt.NDArray[np.float64],
    limits: _Limits,
    margin: float,
    edges: npt.NDArray[np.float64],
    repeats: npt.NDArray[np.bool_],
    origin: Optional[npt.ArrayLike],
    threads: Optional[int],
) -> Contacts:
    box = Box(edges, origin) if repeats.any() else None
    if limits.radii is not None:
        return contacts(centres, limits.radii, tolerance=margin, box=box, periodic=repeats.tolist(), threads=threads)
    return contacts(centres, cutoff=limits.largest + margin, box=box, periodic=repeats.tolist(), threads=threads)


def _edges_of(cell: Optional[npt.ArrayLike], repeats: npt.NDArray[np.bool_]) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """The edges of a cell, those that are missing made up, and by which signs it becomes right-handed."""
    edges = np.zeros((3, 3)) if cell is None else array_of(cell, "cell").astype(np.float64)
    if edges.shape == (3,):
        edges = np.diag(edges)
    if edges.shape != (3, 3):
        raise ValueError(f"cell must be 3 lengths or a 3x3 matrix, not of the shape {edges.shape}")
    missing = ~edges.any(axis=1)
    for edge in np.flatnonzero(missing & repeats):
        raise ValueError(f"edge {edge} of the cell repeats and has no length")
    made_up = edges.copy()
    for edge in np.flatnonzero(missing):
        # Across all edges that are there: the last right singular vector belongs to what they do not span.
        present = made_up[made_up.any(axis=1)]
        made_up[edge] = np.linalg.svd(present)[2][-1] if len(present) else np.eye(3)[edge]
    signs = np.ones(3)
    if np.linalg.det(made_up) < 0:
        signs[0] = -1.0
    return made_up, signs


class _Limits:
    """The cut-off of each pair."""

    def __init__(self, cutoff: Any, numbers: Optional[npt.ArrayLike], n: int) -> None:
        self.radii: Optional[npt.NDArray[np.float64]] = None
        self._table: Optional[npt.NDArray[np.float64]] = None
        self._kinds = np.zeros(0, np.int64)
        if isinstance(cutoff, dict):
            if numbers is None:
                raise TypeError("a cutoff for pairs of elements needs numbers")
            self._kinds = np.asarray(numbers, np.int64)
            if self._kinds.shape != (n,):
                raise ValueError(f"numbers must have one entry for each of {n} atoms, not the shape {self._kinds.shape}")
            kinds = int(self._kinds.max(initial=0)) + 1
            self._table = np.full((kinds, kinds), -1.0)
            for pair, distance in cutoff.items():
                a, b = (_number_of(kind) for kind in pair)
                if a < kinds and b < kinds:
                    self._table[a, b] = self._table[b, a] = _checked(number(distance, "cutoff"))
            self.largest = float(self._table.max(initial=0.0))
        elif is_number(cutoff):
            self.largest = _checked(number(cutoff, "cutoff"))
        else:
            self.radii = array_of(cutoff, "cutoff").astype(np.float64)
            if self.radii.shape != (n,):
                raise ValueError(f"cutoff must be one number, or a radius for each of {n} atoms, not of the shape {self.radii.shape}")
            for atom in np.flatnonzero(~(np.isfinite(self.radii) & (self.radii >= 0)))[:1]:
                raise ValueError(f"atom {atom}: a cutoff must be finite and not negative, not {self.radii[atom]}")
            self.largest = 2.0 * float(self.radii.max(initial=0.0))

    def of(self, i: npt.NDArray[np.int64], j: npt.NDArray[np.int64]) -> Any:
        if self.radii is not None:
            return self.radii[i] + self.radii[j]
        if self._table is not None:
            return self._table[self._kinds[i], self._kinds[j]]
        return self.largest


def _checked(distance: float) -> float:
    if not 0 <= distance < np.inf:
        raise ValueError(f"a cutoff must be finite and not negative, not {distance}")
    return distance


def _number_of(kind: Union[str, int]) -> int:
    if isinstance(kind, str):
        if kind not in _SYMBOLS:
            raise ValueError(f"there is no element '{kind}'")
        return _SYMBOLS.index(kind)
    return int(kind)
