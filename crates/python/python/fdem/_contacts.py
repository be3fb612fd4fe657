"""Contacts of spheres, points and boxes."""

from __future__ import annotations

import errno
import os
import pathlib
import tempfile
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _fdem
from ._box import Box, cell_of
from ._input import AXES, Floats, alike, floats, is_number, number, numbers, points, threads_of, whole
from ._verify import verify_periodic

if TYPE_CHECKING:
    from ._analysis import Analysis
    from ._neighbors import NeighborList


def contacts(
    positions: npt.ArrayLike,
    radii: Optional[npt.ArrayLike] = None,
    cutoff: Optional[float] = None,
    *,
    box: Any = None,
    periodic: Union[bool, Sequence[bool]] = False,
    groups: Optional[npt.ArrayLike] = None,
    tolerance: float = 0.0,
    engine: str = "auto",
    threads: Optional[int] = None,
) -> Contacts:
    """Finds all couples of spheres (discs in 2D) that touch, or of points that are at most `cutoff` apart.

    Parameters
    ----------
    positions : array [n, 2] or [n, 3], float32 or float64
        Centres. In C order they are read where they are; other orders, strides, byte orders and whole numbers are converted, float64 never to float32. They
        must not change before `distance`, `overlap` or `vector` of the result has been asked for.
    radii : array [n] or number, optional
        The radius of each element, or of all. If positions and radii have different types, both become float64.
    cutoff : number, optional
        The distance at which points touch. One of `radii` and `cutoff` must be given. A number is rounded to the type of the positions.
    box : array or Box, optional
        The box that repeats: ``[D]`` lengths of its edges from 0; ``[D, 2]`` where it starts and ends on each axis; ``[D, D]`` edges, one a row; or a
        :class:`Box`.
    periodic : bool or one for each axis (edge), default False
        What repeats. Every image that touches counts, also in a box that is smaller than the elements; elements outside the box are taken for their images
        inside it.
    groups : array [n] of whole numbers, optional
        Elements with equal numbers are parts of one body and form no couple.
    tolerance : number, default 0
        The gap between surfaces that still counts as contact.
    engine : {"auto", "rows", "multilevel", "cgrid", "nbs", "direct"}
        How to search. The couples are the same; their order is not.
    threads : int, optional
        How many threads search; by default one for each processor, or one if there are too few elements for more to be of use. Neither the couples nor their
        order depend on it.

    Returns
    -------
    Contacts
        Each couple once: ``i < j``, or ``i == j`` for an element that touches its own image. In the order of the engine, which depends on nothing but the
        arguments; :meth:`Contacts.sorted` has them in ascending order.

    Raises
    ------
    ValueError
        For NaN, infinity, negative sizes, arrays of unlike length, a box without volume; it names the element.
    TypeError
        For what are no numbers, and unless just one of `radii` and `cutoff` is given.
    MemoryError
        If the couples do not fit.

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

    What is wrong is named:

    >>> fdem.contacts([[0.0, 0.0], [1.0, float("nan")]], radii=1.0)
    Traceback (most recent call last):
    ValueError: element 1: coordinate y is NaN, not a finite number
    """
    centres = points(positions, "positions")
    kind, size, others, centres = sizes_of(centres, radii, cutoff)
    cell_box, cell = cell_of(box, periodic, centres.shape[1])
    bodies = None if groups is None else numbers(groups, "groups", len(centres))
    elements = _fdem.Elements(centres, kind, size, others, number(tolerance, "tolerance"), bodies, cell)
    return Contacts._search(elements, centres, kind, size, others, cell_box, bodies, float(tolerance), cell, engine, threads)


def boxes(
    lower: npt.ArrayLike,
    upper: npt.ArrayLike,
    *,
    box: Any = None,
    periodic: Union[bool, Sequence[bool]] = False,
    groups: Optional[npt.ArrayLike] = None,
    tolerance: float = 0.0,
    engine: str = "auto",
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
        Its `distance` is that of the closest points, 0 if they overlap; its `overlap` the smallest length, over the axes, that both have in common, negative for a
        gap.

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
    """Which sizes there are: their kind, the one size, the array, and the centres in the type of both."""
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


class Csr(NamedTuple):
    """The partners of each element, side by side, as :meth:`Contacts.csr` makes them."""

    indptr: npt.NDArray[np.int64]
    """``[n + 1]``: the partners of element ``k`` are at ``indptr[k]:indptr[k + 1]``."""
    indices: npt.NDArray[np.uint32]
    """``[indptr[n]]``: the partners, ascending for each element."""
    couples: npt.NDArray[np.int64]
    """``[indptr[n]]``: which couple each is, as a place in the arrays of the contacts."""


class Contacts:
    """Couples of elements that touch, and what is known of them.

    Made by :func:`contacts`, :func:`boxes` and :class:`Detector`. The couples are there at once; all else is computed when it is asked for, and kept.

    Examples
    --------
    >>> import fdem
    >>> found = fdem.contacts([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], radii=0.5)
    >>> found
    <fdem.Contacts: 2 couples of 3 discs, mean coordination 1.333>
    >>> found.coordination.tolist()
    [1, 2, 1]
    """

    def __init__(self) -> None:
        raise TypeError("contacts come from fdem.contacts, fdem.boxes and fdem.Detector")

    _elements: _fdem.Elements
    _positions: Floats
    _kind: str
    _size: float
    _others: Optional[Floats]
    _box: Optional[Box]
    _groups: Optional[npt.NDArray[np.uint32]]
    _tolerance: float
    _cell: Any
    _engine: str
    _threads: int
    _pairs: npt.NDArray[np.uint32]
    _shifts: npt.NDArray[np.int32]
    _kept: dict[str, Any]

    @classmethod
    def _search(
        cls,
        elements: _fdem.Elements,
        positions: Floats,
        kind: str,
        size: float,
        others: Optional[Floats],
        box: Optional[Box],
        groups: Optional[npt.NDArray[np.uint32]],
        tolerance: float,
        cell: Any,
        engine: str,
        threads: Optional[int],
    ) -> Contacts:
        self = cls.__new__(cls)
        self._elements, self._positions, self._kind, self._size, self._others = elements, positions, kind, size, others
        self._box, self._groups, self._tolerance, self._cell = box, groups, tolerance, cell
        self._engine, self._threads, self._kept = engine, threads_of(threads), {}
        self._pairs, self._shifts = _fdem.contacts(elements, engine, self._threads)
        return self

    def _with(self, pairs: npt.NDArray[np.uint32], shifts: npt.NDArray[np.int32]) -> Contacts:
        other = Contacts.__new__(Contacts)
        other.__dict__.update(self.__dict__)
        other._pairs, other._shifts, other._kept = pairs, shifts, {}
        return other

    def __len__(self) -> int:
        return len(self._pairs)

    @property
    def n(self) -> int:
        """The number of elements, with contacts or without."""
        return len(self._positions)

    @property
    def pairs(self) -> npt.NDArray[np.uint32]:
        """``[m, 2]``, uint32: the couples, in C order."""
        return self._pairs

    @property
    def i(self) -> npt.NDArray[np.uint32]:
        """``[m]``, uint32: the smaller element of each couple; a column of `pairs`."""
        return self._pairs[:, 0]

    @property
    def j(self) -> npt.NDArray[np.uint32]:
        """``[m]``, uint32: the larger element of each couple; a column of `pairs`."""
        return self._pairs[:, 1]

    @property
    def shift(self) -> npt.NDArray[np.int32]:
        """``[m, D]``, int32: the edges by which `j` is displaced where it touches `i`; zeros without a box that repeats."""
        if "shift" not in self._kept:
            if len(self._shifts) == len(self._pairs):
                self._kept["shift"] = self._shifts
            else:
                shift = np.zeros((len(self._pairs), self._positions.shape[1]), np.int32)
                if len(self._shifts):
                    shift[-len(self._shifts) :] = self._shifts
                self._kept["shift"] = shift
        shift_of_all: npt.NDArray[np.int32] = self._kept["shift"]
        return shift_of_all

    @property
    def distance(self) -> Floats:
        """``[m]``, of the type of the positions: the distance of the centres, of the closest points of boxes.

        Raises ``RuntimeError`` if the positions have been changed in place since the search, which a sample of them shows.
        """
        return self._measured("distance")

    @property
    def overlap(self) -> Floats:
        """``[m]``, of the type of the positions: how deep the elements overlap; negative for a gap within the tolerance.

        The sum of the radii, or the cut-off, less the distance. Of boxes the smallest length, over the axes, that both have in common. Raises ``RuntimeError`` as
        `distance`.
        """
        return self._measured("overlap")

    def _measured(self, what: str) -> Floats:
        if what not in self._kept:
            self._kept[what] = _fdem.measure(self._elements, self._pairs, self._shifts, what == "overlap", self._threads)
        values: Floats = self._kept[what]
        return values

    @property
    def vector(self) -> Floats:
        """``[m, D]``, of the type of the positions: from the centre of `i` to that of `j`, displaced by `shift`.

        Raises ``RuntimeError`` as `distance`, and ``TypeError`` for boxes, which have no centres.
        """
        if self._kind == "upper":
            raise TypeError("boxes have no centres for a vector to go from")
        if "vector" not in self._kept:
            _fdem.measure(self._elements, self._pairs[:0], self._shifts[:0], False, 1)
            vector = self._positions[self.j] - self._positions[self.i]
            if self._box is not None and len(self._shifts):
                vector[-len(self._shifts) :] += self._shifts @ self._box.edges
            self._kept["vector"] = vector
        vectors: Floats = self._kept["vector"]
        return vectors

    @property
    def coordination(self) -> npt.NDArray[np.int64]:
        """``[n]``, int64: the contacts that each element has. One with its own image counts twice: it has two ends."""
        if "coordination" not in self._kept:
            self._kept["coordination"] = _fdem.coordination(self.n, self._pairs)
        counts: npt.NDArray[np.int64] = self._kept["coordination"]
        return counts

    def sorted(self) -> Contacts:
        """The same couples in ascending order: by `i`, then `j`, then `shift`.

        >>> import fdem
        >>> found = fdem.contacts([[2.0, 0], [0, 0], [1, 0]], cutoff=1).sorted()
        >>> found.pairs.tolist()
        [[0, 2], [1, 2]]
        """
        return self._with(*_fdem.ascending(self._pairs, self._shifts))

    def csr(self, full: bool = True) -> Csr:
        """The partners of each element in compressed rows.

        Parameters
        ----------
        full : bool, default True
            Whether a couple is in the rows of both its elements, or in that of `i` only.

        Returns
        -------
        Csr
            ``indptr, indices, couples``: the partners of element ``k`` are ``indices[indptr[k]:indptr[k + 1]]``, ascending, and
            ``distance[couples[indptr[k]:indptr[k + 1]]]`` how far they are.

        Examples
        --------
        >>> import fdem
        >>> rows = fdem.contacts([[0.0, 0], [1, 0], [2, 0]], cutoff=1).csr()
        >>> rows.indptr.tolist(), rows.indices.tolist()
        ([0, 1, 3, 4], [1, 0, 2, 1])
        """
        indptr, indices, couples = _fdem.csr(self.n, self._pairs, bool(full))
        return Csr(indptr, indices, np.where(couples < 0, ~couples, couples))

    def neighbor_list(self) -> NeighborList:
        """The contacts seen from each element, as freud has them: each couple twice, sorted by element."""
        from ._neighbors import NeighborList

        return NeighborList._of(self)

    def to_scipy(self, values: Optional[str] = "distance", full: bool = True) -> Any:
        """A sparse matrix ``[n, n]``, ``scipy.sparse.csr_array``.

        Parameters
        ----------
        values : {"distance", "overlap", None}
            What an entry is; with None it is 1. Couples that touch through several faces of a box that repeats have several entries.
        full : bool, default True
            Whether the matrix is symmetric, or its upper half only.

        Raises
        ------
        ImportError
            Without SciPy.
        """
        sparse = _optional("scipy.sparse", "scipy")
        rows = self.csr(full)
        data = np.ones(len(rows.indices), np.int64) if values is None else self._column(values)[rows.couples]
        index = np.int32 if max(self.n, len(rows.indices)) < 2**31 else np.int64
        parts = (data, rows.indices.astype(index), rows.indptr.astype(index))
        return sparse.csr_array(parts, shape=(self.n, self.n))

    def to_networkx(self) -> Any:
        """A ``networkx.Graph`` of all elements, with `distance` and `overlap` of each edge.

        In a box that repeats it is a ``MultiGraph``, and edges have a `shift`.

        Raises
        ------
        ImportError
            Without NetworkX.
        """
        networkx = _optional("networkx", "networkx")
        graph = networkx.Graph() if self._box is None else networkx.MultiGraph()
        graph.add_nodes_from(range(self.n))
        columns = [self.i.tolist(), self.j.tolist(), self.distance.tolist(), self.overlap.tolist()]
        if self._box is None:
            graph.add_edges_from((i, j, {"distance": d, "overlap": o}) for i, j, d, o in zip(*columns))
        else:
            columns.append([tuple(shift) for shift in self.shift.tolist()])
            edges = ((i, j, {"distance": d, "overlap": o, "shift": s}) for i, j, d, o, s in zip(*columns))
            graph.add_edges_from(edges)
        return graph

    def to_pandas(self) -> Any:
        """A ``pandas.DataFrame`` with columns `i`, `j`, `distance`, `overlap`, and in a box that repeats `sx`, `sy`, `sz`.

        Raises
        ------
        ImportError
            Without pandas.
        """
        pandas = _optional("pandas", "pandas")
        columns = {"i": self.i, "j": self.j, "distance": self.distance, "overlap": self.overlap}
        if self._box is not None:
            columns.update({f"s{AXES[axis]}": column for axis, column in enumerate(self.shift.T)})
        return pandas.DataFrame(columns)

    def _column(self, name: str) -> Floats:
        if name not in ("distance", "overlap"):
            raise ValueError(f"there are no values '{name}': choose one of distance, overlap, None")
        return self._measured(name)

    def verify(self, k: int = 100, seed: int = 0) -> int:
        """Compares the couples of `k` random elements with brute force: each against all others.

        Parameters
        ----------
        k : int
            How many elements; all if there are no more.
        seed : int
            The same seed picks the same elements.

        Returns
        -------
        int
            How many elements were compared.

        Raises
        ------
        RuntimeError
            If a couple is missing, or is one too many.

        Examples
        --------
        >>> import fdem
        >>> fdem.contacts([[0.0, 0], [1, 0], [2, 0]], cutoff=1).verify()
        3
        """
        sample, seed = whole(k, "k", 0), whole(seed, "seed", 0)
        if self._box is not None:
            _fdem.measure(self._elements, self._pairs[:0], self._shifts[:0], False, 1)
            return verify_periodic(self, self._cell[2], sample, seed)
        checked, mistake = _fdem.verify(self._elements, self._pairs, sample, seed)
        if mistake is not None:
            raise RuntimeError(f"the couples are wrong: {mistake}")
        return checked

    def explain(self) -> str:
        """What the search does: engine and why, cells, memory, threads, and how many couples it would expect.

        >>> import fdem
        >>> print(fdem.contacts([[0.0, 0], [1, 0], [2, 0]], cutoff=1).explain())  # doctest: +ELLIPSIS
        engine...
        """
        return _fdem.explain(self._elements, self._engine, self._threads)

    def analyse(
        self,
        *,
        min_contacts: Optional[int] = None,
        inner: Optional[npt.ArrayLike] = None,
        rdf: Union[float, tuple[float, int], None] = None,
    ) -> Analysis:
        """Coordination, rattlers, fabric, clusters, overlaps, packing fraction, radial distribution.

        Parameters
        ----------
        min_contacts : int, optional
            Elements with fewer contacts are rattlers: D + 1 unless given, the fewest that hold an element without friction; 2 for elements with friction.
        inner : array [D, 2], optional
            Where the packing fraction is measured, the limits of each axis. Unless given: the whole box where it repeats, elsewhere what is more than the largest
            diameter away from the faces of the domain.
        rdf : number or (number, int), optional
            The largest distance of the radial distribution, and the number of its bins; 3 mean diameters and 150 unless given.

        Returns
        -------
        Analysis
            Its parts are attributes: `coordination`, `without_rattlers`, `directions`, `fabric`, `clusters`, `overlaps`, `packing`, `radial`.

        Raises
        ------
        ValueError
            For boxes, which have no centres, and for regions and distances that cannot be.
        RuntimeError
            As `distance`.

        Examples
        --------
        A sphere in a cube that repeats is the simple cubic lattice:

        >>> import fdem
        >>> said = fdem.contacts([[0.5, 0.5, 0.5]], radii=0.5, box=[1, 1, 1], periodic=True).analyse()
        >>> said.coordination.mean, round(said.packing.fraction, 4), said.fabric.eigenvalues.round(4).tolist()
        (6.0, 0.5236, [0.3333, 0.3333, 0.3333])
        """
        from ._analysis import analysed

        return analysed(self, min_contacts, inner, rdf)

    def picture(self, path: Union[str, os.PathLike[str]], *, title: str = "", width: Optional[int] = None) -> None:
        """Draws the elements and their contacts to a file, ``.png`` or ``.svg``.

        Discs with their contacts in 2D; in 3D shaded spheres coloured by contacts, beside the contacts coloured by overlap. No display is needed.

        Parameters
        ----------
        path : str or path
            Written whole or not at all.
        title : str
            Stands above the picture.
        width : int, optional
            Pixels that a PNG is wide.

        Raises
        ------
        ValueError
            For other ends of the name, and for boxes.
        OSError
            If the file cannot be written.

        Examples
        --------
        >>> import os, tempfile, fdem
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     fdem.contacts([[0.0, 0], [1, 0]], radii=0.5).picture(os.path.join(folder, "two.png"))
        ...     os.listdir(folder)
        ['two.png']
        """
        self._draw("picture", path, ("png", "svg"), title, width)

    def plots(self, path: Union[str, os.PathLike[str]], *, title: str = "", width: Optional[int] = None) -> None:
        """Draws how contacts, overlaps, sizes and directions are distributed, to a ``.png`` or ``.svg`` file, as :meth:`picture`."""
        self._draw("plots", path, ("png", "svg"), title, width)

    def report(self, path: Union[str, os.PathLike[str]], *, title: str = "") -> None:
        """Writes a page for a browser, ``.html``, all in one file: plots, a view to turn, cut and pick elements in, and a table; as :meth:`picture`."""
        self._draw("report", path, ("html",), title, None)

    def _draw(self, what: str, path: Union[str, os.PathLike[str]], forms: tuple[str, ...], title: str, width: Optional[int]) -> None:
        target = pathlib.Path(path)
        form = target.suffix[1:].lower()
        if form not in forms:
            raise ValueError(f"{target}: end the name in {' or '.join('.' + each for each in forms)}")
        wide = None if width is None else whole(width, "width", 1)
        drawn = _fdem.draw(self._elements, self._pairs, self._shifts, what, form, title, wide)
        if not target.parent.is_dir():
            raise FileNotFoundError(errno.ENOENT, "there is no such folder", str(target.parent))
        # Aside first: a full disk leaves the old file as it was.
        with tempfile.NamedTemporaryFile(dir=target.parent, prefix=target.name, delete=False) as aside:
            try:
                aside.write(drawn)
                aside.close()
                # As any file that is created, and not for its owner alone.
                mask = os.umask(0)
                os.umask(mask)
                os.chmod(aside.name, 0o666 & ~mask)
                os.replace(aside.name, target)
            except BaseException:
                os.unlink(aside.name)
                raise

    def _noun(self) -> str:
        flat = self._positions.shape[1] == 2
        if self._kind == "upper":
            return "rectangles" if flat else "boxes"
        if self._kind == "cutoff":
            return f"points within {self._size:g}"
        return "discs" if flat else "spheres"

    def __repr__(self) -> str:
        mean = 2 * len(self) / self.n if self.n else 0.0
        couples = "1 couple" if len(self) == 1 else f"{len(self):,} couples"
        where = "" if self._box is None else f" in a box that repeats, {len(self._shifts):,} through its faces"
        return f"<fdem.Contacts: {couples} of {self.n:,} {self._noun()}{where}, mean coordination {mean:.4g}>"

    def _repr_html_(self) -> str:
        mean = 2 * len(self) / self.n if self.n else 0.0
        rows = [("couples", f"{len(self):,}"), ("elements", f"{self.n:,} {self._noun()}"), ("mean coordination", f"{mean:.4g}")]
        if self._box is not None:
            rows.append(("through faces of the box", f"{len(self._shifts):,}"))
        body = "".join(f"<tr><th style='text-align:left'>{name}</th><td>{value}</td></tr>" for name, value in rows)
        return f"<table><caption>fdem.Contacts</caption>{body}</table>"


def _optional(module: str, package: str) -> Any:
    """A module of a package that fdem does without otherwise."""
    import importlib

    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise ImportError(f"this needs {package}: pip install {package}") from error
