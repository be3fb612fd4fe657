"""Neighbour lists with the arguments and results of ASE and matscipy."""

from __future__ import annotations

from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _fdem
from ._box import Box, cell_of
from ._input import array_of, is_number, number, points, threads_of

_SYMBOLS = (
    "X H He Li Be B C N O F Ne Na Mg Al Si P S Cl Ar K Ca Sc Ti V Cr Mn Fe Co Ni Cu Zn Ga Ge As Se Br Kr Rb Sr Y Zr Nb Mo Tc Ru Rh Pd Ag Cd In Sn Sb Te I Xe "
    "Cs Ba La Ce Pr Nd Pm Sm Eu Gd Tb Dy Ho Er Tm Yb Lu Hf Ta W Re Os Ir Pt Au Hg Tl Pb Bi Po At Rn Fr Ra Ac Th Pa U Np Pu Am Cm Bk Cf Es Fm Md No Lr Rf Db Sg "
    "Bh Hs Mt Ds Rg Cn Nh Fl Mc Lv Ts Og"
).split()

_MARGIN = 1e-9
"""Part of the cut-off by which the search looks farther. The distances of the pairs it finds are then computed as ASE computes them, and compared with the cut-off."""


def neighbor_list(
    quantities: str,
    atoms: Any = None,
    cutoff: Union[float, npt.ArrayLike, dict[tuple[Any, Any], float], None] = None,
    self_interaction: bool = False,
    max_nbins: Optional[float] = None,
    *,
    positions: Optional[npt.ArrayLike] = None,
    cell: Optional[npt.ArrayLike] = None,
    pbc: Union[bool, npt.ArrayLike, None] = None,
    numbers: Optional[npt.ArrayLike] = None,
    cell_origin: Optional[npt.ArrayLike] = None,
    threads: Optional[int] = None,
) -> Any:
    """All pairs of atoms that are less than a cut-off apart, as ``ase.neighborlist.neighbor_list`` and ``matscipy.neighbours.neighbour_list`` list them.

    A replacement for code that uses these. :func:`contacts` lists each couple once, counts touching elements too, and is faster.

    Parameters
    ----------
    quantities : str
        The columns to return, one letter each: ``i`` first atom, ``j`` second atom, ``d`` distance, ``D`` vector from the first to the second, ``S`` shift of the second in
        edges of the cell, so that ``D = positions[j] - positions[i] + S @ cell``.
    atoms : ase.Atoms or alike, optional
        An object with ``positions``, ``cell`` and ``pbc``, and with ``numbers`` for a `cutoff` by elements.
    cutoff : number, array [n] or dict
        One distance; a radius for each atom, so that the cut-off of a pair is the sum of both; or a distance for each pair of elements,
        ``{("H", "O"): 1.2, (1, 1): 0.8}``. Pairs that the dict lacks are not listed.
    self_interaction : bool, default False
        Whether each atom is its own neighbour at distance 0.
    max_nbins : number, optional
        Has no effect: memory does not grow with the volume of the cell. ASE has this argument.
    positions, cell, pbc, numbers, cell_origin
        In place of `atoms`. A cell is a matrix of edges, or their lengths. Edges of zero length are allowed along directions that do not repeat.
    threads : int, optional
        Number of threads; one for each processor by default. The result does not depend on it.

    Returns
    -------
    array, or tuple of arrays
        In the order of `quantities`: int64 ``[m]`` for ``i`` and ``j``, float64 ``[m]`` for ``d``, float64 ``[m, 3]`` for ``D``, int64 ``[m, 3]`` for ``S``. Each pair
        is listed from both sides, and every image counts. Sorted by ``i``, as ASE sorts, and for each ``i`` by ``j``, then ``S``.

    Raises
    ------
    ValueError, TypeError
        As :func:`contacts`; for unknown letters and unknown elements.
    MemoryError
        If the list does not fit.

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
    if max_nbins is not None:
        number(max_nbins, "max_nbins")
    if atoms is not None:
        for name, given in (("positions", positions), ("cell", cell), ("pbc", pbc)):
            if given is None and not hasattr(atoms, name):
                raise TypeError(f"atoms must have {name}, as ase.Atoms has; {type(atoms).__name__} has not")
        positions = atoms.positions if positions is None else positions
        cell = np.asarray(atoms.cell) if cell is None else cell
        pbc = atoms.pbc if pbc is None else pbc
        if numbers is None and isinstance(cutoff, dict):
            numbers = atoms.numbers
    if positions is None:
        raise TypeError("give atoms, or positions")
    centres = np.require(points(positions, "positions"), np.float64, ["C", "A"])
    if centres.shape[1] != 3:
        raise ValueError(f"positions must have the shape [n, 3], not {centres.shape}")
    repeats = np.asarray(False if pbc is None else pbc, bool)
    if repeats.shape not in ((), (1,), (3,)):
        raise ValueError(f"pbc must be one truth value or three, not of the shape {repeats.shape}")
    repeats = np.broadcast_to(repeats, 3)
    edges = _edges_of(cell, repeats)
    limits = _Limits(cutoff, numbers, len(centres))

    # The search finds a little more than is listed.
    margin = limits.largest * _MARGIN
    box = Box(edges, cell_origin) if repeats.any() else None
    _, repeating = cell_of(box, repeats.tolist(), 3)
    if limits.radii is not None:
        elements = _fdem.Elements(centres, "radii", 0.0, limits.radii, margin, None, repeating)
    else:
        elements = _fdem.Elements(centres, "cutoff", limits.largest, None, margin, None, repeating)
    columns = _fdem.neighbor_list(
        elements,
        quantities,
        limits.largest,
        limits.kinds,
        limits.table,
        edges.tolist(),
        bool(self_interaction),
        threads_of(threads),
    )
    named = dict(zip("ijdDS", columns))
    listed = tuple(named[letter] for letter in quantities)
    return listed[0] if len(listed) == 1 else listed


def primitive_neighbor_list(
    quantities: str,
    pbc: Union[bool, npt.ArrayLike],
    cell: npt.ArrayLike,
    positions: npt.ArrayLike,
    cutoff: Union[float, npt.ArrayLike, dict[tuple[Any, Any], float]],
    numbers: Optional[npt.ArrayLike] = None,
    self_interaction: bool = False,
    use_scaled_positions: bool = False,
    max_nbins: Optional[float] = None,
) -> Any:
    """:func:`neighbor_list` with the arguments of ``ase.neighborlist.primitive_neighbor_list``.

    Parameters
    ----------
    quantities, pbc, cell, positions, cutoff, numbers, self_interaction, max_nbins
        As for :func:`neighbor_list`.
    use_scaled_positions : bool, default False
        Whether `positions` are in units of the edges of the cell.

    Returns
    -------
    array, or tuple of arrays
        As :func:`neighbor_list`.

    Raises
    ------
    ValueError, TypeError, MemoryError
        As :func:`neighbor_list`.

    Examples
    --------
    >>> import fdem
    >>> fdem.primitive_neighbor_list("d", True, [4.0, 9.0, 9.0], [[0.1, 0, 0], [0.9, 0, 0]], 1.0, use_scaled_positions=True).round(12).tolist()
    [0.8, 0.8]
    """
    at = points(positions, "positions")
    if use_scaled_positions:
        edges = np.asarray(cell, np.float64)
        at = at @ (np.diag(edges) if edges.shape == (3,) else edges)
    return neighbor_list(
        quantities,
        positions=at,
        cell=cell,
        pbc=pbc,
        cutoff=cutoff,
        numbers=numbers,
        self_interaction=self_interaction,
        max_nbins=max_nbins,
    )


class NewPrimitiveNeighborList:
    """A list of neighbours that is kept while atoms move little, as ``ase.neighborlist.NewPrimitiveNeighborList``.

    ``ase.neighborlist.NeighborList(..., primitive=fdem.NewPrimitiveNeighborList)`` uses it.

    Parameters
    ----------
    cutoffs : array [n]
        A radius for each atom.
    skin : number, default 0.3
        Added to each radius. The list is kept until an atom has moved farther than this.
    sorted : bool
        Has no effect: neighbours are always sorted.
    self_interaction : bool, default True
        Whether each atom is its own neighbour.
    bothways : bool, default False
        Whether each pair is listed for both of its atoms.
    use_scaled_positions : bool, default False
        Whether positions are in units of the edges of the cell.

    Attributes
    ----------
    nupdates : int
        The number of times that the list was built.
    pair_first, pair_second : array [m], int64
        The atoms of each pair.
    offset_vec : array [m, 3], int64
        The edges of the cell by which the second one is displaced.
    first_neigh : array [n + 1], int64
        Where the pairs of each atom begin.

    Examples
    --------
    >>> import numpy as np, fdem
    >>> neighbours = fdem.NewPrimitiveNeighborList([0.6, 0.6], self_interaction=False)
    >>> neighbours.update(np.zeros(3, bool), np.zeros((3, 3)), np.array([[0.0, 0, 0], [1, 0, 0]]))
    True
    >>> neighbours.get_neighbors(0)[0].tolist()
    [1]
    """

    def __init__(
        self,
        cutoffs: npt.ArrayLike,
        skin: float = 0.3,
        sorted: bool = False,
        self_interaction: bool = True,
        bothways: bool = False,
        use_scaled_positions: bool = False,
    ) -> None:
        self.cutoffs: npt.NDArray[np.float64] = np.asarray(cutoffs, np.float64) + number(skin, "skin")
        self.skin = float(skin)
        self.sorted, self.self_interaction, self.bothways = sorted, self_interaction, bothways
        self.use_scaled_positions = use_scaled_positions
        self.nupdates = 0

    def update(self, pbc: npt.ArrayLike, cell: npt.ArrayLike, positions: npt.ArrayLike, numbers: Optional[npt.ArrayLike] = None) -> bool:
        """Builds the list if it has to be: the first time, for another cell, and if an atom has moved farther than the skin.

        Returns
        -------
        bool
            Whether the list was built.
        """
        at = np.asarray(positions)
        if self.nupdates > 0 and at.shape == self.positions.shape:
            kept = np.array_equal(self.pbc, pbc) and np.array_equal(self.cell, cell)
            if kept and (((self.positions - at) ** 2).sum(axis=1) <= self.skin**2).all():
                return False
        self.build(pbc, cell, positions, numbers)
        return True

    def build(self, pbc: npt.ArrayLike, cell: npt.ArrayLike, positions: npt.ArrayLike, numbers: Optional[npt.ArrayLike] = None) -> None:
        """Builds the list."""
        self.pbc, self.cell, self.positions = np.array(pbc), np.array(cell), np.array(positions)
        i, j, S = primitive_neighbor_list(
            "ijS",
            self.pbc,
            self.cell,
            self.positions,
            self.cutoffs,
            numbers,
            self.self_interaction,
            self.use_scaled_positions,
        )
        if not self.bothways:
            x, y, z = S.T
            upper = (x > 0) | ((x == 0) & ((y > 0) | ((y == 0) & (z > 0))))
            kept = upper | ((i <= j) & (S == 0).all(axis=1))
            i, j, S = i[kept], j[kept], S[kept]
        self.pair_first, self.pair_second, self.offset_vec = i, j, S
        self.first_neigh: npt.NDArray[np.int64] = np.searchsorted(i, np.arange(len(self.positions) + 1))
        self.nupdates += 1

    def get_neighbors(self, a: int) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
        """The neighbours of an atom, and their offsets in edges of the cell.

        Unless the list is `bothways`, a pair is a neighbour of one of its atoms only.
        """
        here = slice(self.first_neigh[a], self.first_neigh[a + 1])
        return self.pair_second[here], self.offset_vec[here]


def _edges_of(cell: Optional[npt.ArrayLike], repeats: npt.NDArray[np.bool_]) -> npt.NDArray[np.float64]:
    """The edges of a cell, with unit edges in place of those of zero length."""
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
        # Orthogonal to all edges so far: the last right singular vector belongs to the space that they do not span.
        present = made_up[made_up.any(axis=1)]
        made_up[edge] = np.linalg.svd(present)[2][-1] if len(present) else np.eye(3)[edge]
    return made_up


class _Limits:
    """The cut-off of each pair: the sum of two of the `radii`, the entry of the `table` for two `kinds`, or else the `largest`."""

    radii: Optional[npt.NDArray[np.float64]] = None
    kinds: Optional[npt.NDArray[np.uint32]] = None
    table: Optional[npt.NDArray[np.float64]] = None

    def __init__(self, cutoff: Any, numbers: Optional[npt.ArrayLike], n: int) -> None:
        if isinstance(cutoff, dict):
            if numbers is None:
                raise TypeError("a cutoff for pairs of elements needs numbers")
            each = np.asarray(numbers, np.int64)
            if each.shape != (n,):
                raise ValueError(f"numbers must have one entry for each of {n} atoms, not the shape {each.shape}")
            present, kinds = np.unique(each, return_inverse=True)
            place = {int(kind): k for k, kind in enumerate(present)}
            self.kinds = np.require(kinds.reshape(n), np.uint32, ["C", "A"])
            # No distance is less than a limit of -1.
            self.table = np.full((len(present), len(present)), -1.0)
            for pair, distance in cutoff.items():
                limit = _checked(number(distance, "cutoff"))
                if not isinstance(pair, tuple) or len(pair) != 2:
                    raise ValueError(f"a cutoff is for a pair of elements, such as ('H', 'O'), not for {pair!r}")
                a, b = (_number_of(kind) for kind in pair)
                if a in place and b in place:
                    self.table[place[a], place[b]] = self.table[place[b], place[a]] = limit
            self.largest = float(self.table.max(initial=0.0))
        elif is_number(cutoff):
            self.largest = _checked(number(cutoff, "cutoff"))
        else:
            radii = np.require(array_of(cutoff, "cutoff"), np.float64, ["C", "A"])
            if radii.shape != (n,):
                raise ValueError(f"cutoff must be one number, or a radius for each of {n} atoms, not of the shape {radii.shape}")
            for atom in np.flatnonzero(~(np.isfinite(radii) & (radii >= 0)))[:1]:
                raise ValueError(f"atom {atom}: a cutoff must be finite and not negative, not {radii[atom]}")
            self.radii = radii
            self.largest = 2.0 * float(radii.max(initial=0.0))


def _checked(distance: float) -> float:
    if not 0 <= distance < np.inf:
        raise ValueError(f"a cutoff must be finite and not negative, not {distance}")
    return distance


def _number_of(kind: Union[str, int]) -> int:
    if isinstance(kind, str):
        if kind not in _SYMBOLS:
            raise ValueError(f"there is no element '{kind}'")
        return _SYMBOLS.index(kind)
    if not isinstance(kind, (int, np.integer)):
        raise ValueError(f"an element is a symbol or an atomic number, not {kind!r}")
    return int(kind)
