"""Contacts of spheres, points and boxes."""

from __future__ import annotations

import base64
import os
import pathlib
from typing import Any, NamedTuple, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _fdem
from ._analysis import Analysis, analysed
from ._box import Box
from ._files import write_whole
from ._input import AXES, Engine, Floats, threads_of, whole
from ._neighbors import NeighborList
from ._verify import verify_periodic


class Csr(NamedTuple):
    """The partners of each element, side by side, as :meth:`Contacts.csr` makes them."""

    indptr: npt.NDArray[np.int64]
    """``[n + 1]``: the partners of element ``k`` are at ``indptr[k]:indptr[k + 1]``."""
    indices: npt.NDArray[np.uint32]
    """``[indptr[n]]``: the partners, ascending for each element."""
    couples: npt.NDArray[np.int64]
    """``[indptr[n]]``: the couple of each partner, as an index into the arrays of the contacts."""


class Contacts:
    """Couples of elements that touch, with their distances, overlaps and images.

    Made by :func:`contacts`, :func:`boxes` and :class:`Detector`. The couples are there at once; everything else is computed when it is asked for, and kept.

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
    _cutoffs: Optional[list[tuple[int, int, float]]]
    _engine: Engine
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
        engine: Engine,
        threads: Optional[int],
        cutoffs: Optional[list[tuple[int, int, float]]] = None,
        device: str = "cpu",
    ) -> Contacts:
        count = threads_of(threads)
        pairs, shifts = _fdem.contacts(elements, engine, count, device)
        if cutoffs is not None:
            pairs, shifts = _fdem.within_cutoffs(elements, pairs, shifts)
        arguments = (elements, positions, kind, size, others, box, groups, tolerance, cell, engine, count)
        return cls._of(arguments, pairs, shifts, cutoffs)

    @classmethod
    def _of(
        cls,
        arguments: tuple[Any, ...],
        pairs: npt.NDArray[np.uint32],
        shifts: npt.NDArray[np.int32],
        cutoffs: Optional[list[tuple[int, int, float]]] = None,
    ) -> Contacts:
        """The couples of some elements: the arguments of :meth:`_search`, with the number of threads."""
        self = cls.__new__(cls)
        self._elements, self._positions, self._kind, self._size, self._others = arguments[:5]
        self._box, self._groups, self._tolerance, self._cell, self._engine, self._threads = arguments[5:]
        self._pairs, self._shifts, self._kept, self._cutoffs = pairs, shifts, {}, cutoffs
        return self

    def __getstate__(self) -> dict[str, Any]:
        # The extension module only borrows the arrays. With the fingerprint a copy notices positions that were changed as the original does.
        state = dict(self.__dict__)
        state["_elements"] = self._elements.fingerprint
        # Pictures are drawn again.
        state["_kept"] = {name: value for name, value in self._kept.items() if name != "png"}
        return state

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._elements = _fdem.Elements(
            self._positions, self._kind, self._size, self._others, self._tolerance, self._groups, self._cell, state["_elements"], self._cutoffs
        )

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
        """``[m]``, of the type of the positions: the distance of the centres, or of the closest points of boxes.

        Raises ``RuntimeError`` if the positions have been changed in place since the search, which a sample of them shows.
        """
        return self._measured("distance")

    @property
    def overlap(self) -> Floats:
        """``[m]``, of the type of the positions: how deep the elements overlap; negative for a gap within the tolerance.

        The sum of the radii, or the cut-off, less the distance. For boxes it is the smallest overlap along an axis. Raises ``RuntimeError`` as `distance`.
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
        """``[n]``, int64: the number of contacts of each element. A contact with its own image counts twice, because it has two ends."""
        if "coordination" not in self._kept:
            self._kept["coordination"] = _fdem.coordination(self.n, self._pairs)
        counts: npt.NDArray[np.int64] = self._kept["coordination"]
        return counts

    def _own_images(self) -> int:
        """The number of couples of an element with its own image; they are among those through faces, at the end."""
        through = self._pairs[len(self._pairs) - len(self._shifts) :]
        return int(np.count_nonzero(through[:, 0] == through[:, 1]))

    def sorted(self) -> Contacts:
        """The same couples in ascending order: by `i`, then `j`, then `shift`.

        >>> import fdem
        >>> found = fdem.contacts([[2, 0], [0, 0], [1, 0]], cutoff=1).sorted()
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
        >>> rows = fdem.contacts([[0, 0], [1, 0], [2, 0]], cutoff=1).csr()
        >>> rows.indptr.tolist(), rows.indices.tolist()
        ([0, 1, 3, 4], [1, 0, 2, 1])
        """
        indptr, indices, couples = _fdem.csr(self.n, self._pairs, bool(full))
        return Csr(indptr, indices, np.where(couples < 0, ~couples, couples))

    def neighbor_list(self) -> NeighborList:
        """The contacts seen from each element, as freud has them: each couple twice, sorted by element."""
        return NeighborList._of(self)

    def edge_index(self, full: bool = True) -> npt.NDArray[np.int64]:
        """The couples as a graph of PyTorch Geometric has its edges; ``torch.from_numpy`` takes the array as it is, without a copy.

        Parameters
        ----------
        full : bool, default True
            Whether each couple is there from both sides.

        Returns
        -------
        array [2, edges], int64
            The two elements of each edge. The first ``len(self)`` edges are the couples in their order, from `i` to `j`; then follow, in the same order, those
            from `j` to `i`.

        Notes
        -----
        `i`, `j` and `pairs` are uint32, which PyTorch hardly knows. Elements are fewer than 2^31, so ``torch.from_numpy(found.pairs.view(np.int32))`` has the
        couples without a copy.

        Examples
        --------
        >>> import fdem
        >>> fdem.contacts([[0, 0], [1, 0], [2, 0]], cutoff=1).sorted().edge_index().tolist()
        [[0, 1, 1, 2], [1, 2, 0, 1]]
        """
        m = len(self._pairs)
        edges = np.empty((2, 2 * m if full else m), np.int64)
        edges[:, :m] = self._pairs.T
        if full:
            edges[::-1, m:] = self._pairs.T
        return edges

    def to_scipy(self, values: Optional[str] = "distance", full: bool = True) -> Any:
        """A sparse matrix ``[n, n]``, ``scipy.sparse.csr_array``.

        Parameters
        ----------
        values : {"distance", "overlap", None}
            The values of the entries; with None they are 1. A pair that touches through several faces of a box that repeats has one entry: the smallest distance,
            or the largest overlap.
        full : bool, default True
            Whether the matrix is symmetric, or its upper half only.

        Raises
        ------
        ImportError
            Without SciPy.
        """
        sparse = optional("scipy.sparse", "scipy")
        rows = self.csr(full)
        data = np.ones(len(rows.indices), np.int64) if values is None else self._column(values)[rows.couples]
        indices, indptr = rows.indices, rows.indptr
        if len(self._shifts):
            # Images of one pair stand side by side; SciPy would add their entries.
            row = np.repeat(np.arange(self.n), np.diff(indptr))
            first = np.ones(len(indices), bool)
            first[1:] = (indices[1:] != indices[:-1]) | (row[1:] != row[:-1])
            start = np.flatnonzero(first)
            best = np.minimum if values == "distance" else np.maximum
            data = best.reduceat(data, start) if len(start) else data
            indices, indptr = indices[start], np.searchsorted(start, indptr)
        index = np.int32 if max(self.n, len(indices)) < 2**31 else np.int64
        parts = (data, indices.astype(index), indptr.astype(index))
        return sparse.csr_array(parts, shape=(self.n, self.n))

    def to_networkx(self) -> Any:
        """A ``networkx.Graph`` of all elements, with `distance` and `overlap` of each edge.

        In a box that repeats it is a ``MultiGraph``, and edges have a `shift`.

        Raises
        ------
        ImportError
            Without NetworkX.
        """
        networkx = optional("networkx", "networkx")
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
        pandas = optional("pandas", "pandas")
        columns = {"i": self.i, "j": self.j, "distance": self.distance, "overlap": self.overlap}
        if self._box is not None:
            columns.update({f"s{AXES[axis]}": column for axis, column in enumerate(self.shift.T)})
        return pandas.DataFrame(columns)

    def to_pyvista(self) -> Any:
        """A ``pyvista.PolyData`` with a point for each element and a line for each couple.

        Returns
        -------
        pyvista.PolyData
            Points have `radius` (not those with a cut-off), `coordination`, `id` and `image`; lines have `distance`, `overlap` and `shift`. In a box that repeats the line
            of a couple through a face ends at a point of its own, the image of `j`, whose `image` is 1. In 2D z is 0.

        Raises
        ------
        ImportError
            Without PyVista.
        TypeError
            For boxes, which have no centres.

        Examples
        --------
        >>> import fdem
        >>> found = fdem.contacts([[0.0, 0.0], [1.0, 0.0], [9.0, 9.0]], radii=0.5)
        >>> data = found.to_pyvista()
        >>> data.n_points, data.n_lines, data.point_data["coordination"].tolist()
        (3, 1, [1, 1, 0])
        """
        pyvista = optional("pyvista", "pyvista")
        n, m, dimensions = self.n, len(self), self._positions.shape[1]
        vectors = self.vector
        across = np.flatnonzero(self.shift.any(axis=1))
        points = np.zeros((n + len(across), 3), self._positions.dtype)
        points[:n, :dimensions] = self._positions
        points[n:, :dimensions] = self._positions[self.i[across]] + vectors[across]
        lines = np.full((m, 3), 2, np.int64)
        lines[:, 1:] = self._pairs
        lines[across, 2] = n + np.arange(len(across))
        data = pyvista.PolyData(points, lines=lines.reshape(-1)) if m else pyvista.PolyData(points)
        element = np.concatenate([np.arange(n), self.j[across].astype(np.int64)])
        if self._kind == "radii" and self._others is not None:
            data.point_data["radius"] = self._others[element]
        elif self._kind == "radius":
            data.point_data["radius"] = np.full(len(element), self._size)
        data.point_data["coordination"] = self.coordination[element]
        data.point_data["id"] = element
        data.point_data["image"] = (np.arange(len(element)) >= n).astype(np.int32)
        if m:
            shift = np.zeros((m, 3), np.int32)
            shift[:, :dimensions] = self.shift
            data.cell_data["distance"], data.cell_data["overlap"], data.cell_data["shift"] = self.distance, self.overlap, shift
        return data

    def write(self, path: Union[str, os.PathLike[str]]) -> None:
        """Writes the couples to a file, as the command ``fdem contacts --output`` does; numbers are float64 and int64.

        Parameters
        ----------
        path : str or path
            The end of its name determines the format: ``.csv``, ``.npy`` and ``.parquet`` have the couples; ``.npz``, ``.vtp`` (for ParaView), ``.graphml`` and ``.json`` have the
            elements too. Written whole or not at all.

        Raises
        ------
        ValueError
            For other ends of the name, and for boxes.
        OSError
            If the file cannot be written.
        RuntimeError
            As `distance`.

        Examples
        --------
        >>> import os, tempfile, fdem
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = os.path.join(folder, "couples.csv")
        ...     fdem.contacts([[0, 0], [1, 0]], radii=0.5).write(path)
        ...     print(open(path).read(), end="")
        i,j,distance,overlap
        0,1,1.0,0.0
        """
        target = pathlib.Path(path)
        write_whole(target, _fdem.file(self._elements, self._pairs, self._shifts, os.fspath(target)))

    def _column(self, name: str) -> Floats:
        if name not in ("distance", "overlap"):
            raise ValueError(f"there are no values '{name}': choose one of distance, overlap, None")
        return self._measured(name)

    def verify(self, k: int = 100, seed: int = 0) -> int:
        """Compares the couples of `k` random elements with brute force: each against all others.

        Parameters
        ----------
        k : int
            Number of elements; all of them if there are fewer.
        seed : int
            The same seed picks the same elements.

        Returns
        -------
        int
            Number of elements that were compared.

        Raises
        ------
        RuntimeError
            If a couple is missing, or a couple is listed that does not touch.

        Examples
        --------
        >>> import fdem
        >>> fdem.contacts([[0, 0], [1, 0], [2, 0]], cutoff=1).verify()
        3
        """
        sample, seed = whole(k, "k", 0), whole(seed, "seed", 0)
        if self._box is not None:
            _fdem.measure(self._elements, self._pairs[:0], self._shifts[:0], False, 1)
            return verify_periodic(self, self._cell[2], sample, seed)
        if self._kind == "pairs":
            _fdem.measure(self._elements, self._pairs[:0], self._shifts[:0], False, 1)
            return verify_periodic(self, [False] * self._positions.shape[1], sample, seed)
        checked, mistake = _fdem.verify(self._elements, self._pairs, sample, seed)
        if mistake is not None:
            raise RuntimeError(f"the couples are wrong: {mistake}")
        return checked

    def explain(self) -> str:
        """Describes the search: the engine and the reason for it, cells, memory, threads, and the expected number of couples.

        >>> import fdem
        >>> print(fdem.contacts([[0, 0], [1, 0], [2, 0]], cutoff=1).explain())  # doctest: +ELLIPSIS
        engine...
        """
        return _fdem.explain(self._elements, self._engine, self._threads)

    def analyse(
        self,
        *,
        min_contacts: Optional[int] = None,
        inner: Optional[npt.ArrayLike] = None,
        rdf: Union[float, tuple[float, int], None] = None,
        voids: bool = False,
    ) -> Analysis:
        """Coordination, rattlers, fabric, clusters, overlaps, packing fraction, radial distribution.

        Parameters
        ----------
        min_contacts : int, optional
            Elements with fewer contacts are rattlers. The default is D + 1, the least number that holds an element without friction; take 2 for elements with friction.
        inner : array [D, 2], optional
            The region in which the packing fraction is measured, as limits on each axis. The default is the whole box along axes that repeat; along other axes it is the
            domain without a margin of the largest diameter.
        rdf : number or (number, int), optional
            The largest distance of the radial distribution, and the number of its bins. The defaults are 3 mean diameters and 150.
        voids : bool, default False
            Whether local void ratios and sizes of pores are measured, which takes some 20 µs for each element.

        Returns
        -------
        Analysis
            Its parts are attributes: `coordination`, `without_rattlers`, `directions`, `fabric`, `clusters`, `overlaps`, `packing`, `voids` if they were asked for, `radial`.

        Raises
        ------
        ValueError
            For boxes, which have no centres, and for impossible regions and distances.
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
        return analysed(self, min_contacts, inner, rdf, voids)

    def picture(self, path: Union[str, os.PathLike[str]], *, title: str = "", width: Optional[int] = None) -> None:
        """Draws the elements and their contacts to a file, ``.png`` or ``.svg``.

        Discs with their contacts in 2D; in 3D shaded spheres coloured by contacts, beside the contacts coloured by overlap. No display is needed.

        Parameters
        ----------
        path : str or path
            Written whole or not at all.
        title : str
            The text above the picture.
        width : int, optional
            The width of a PNG in pixels.

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
        ...     fdem.contacts([[0, 0], [1, 0]], radii=0.5).picture(os.path.join(folder, "two.png"))
        ...     os.listdir(folder)
        ['two.png']
        """
        self._draw("picture", path, ("png", "svg"), title, width)

    def plots(self, path: Union[str, os.PathLike[str]], *, title: str = "", width: Optional[int] = None) -> None:
        """Draws how contacts, overlaps, sizes and directions are distributed, to a ``.png`` or ``.svg`` file, as :meth:`picture`."""
        self._draw("plots", path, ("png", "svg"), title, width)

    def report(self, path: Union[str, os.PathLike[str]], *, title: str = "") -> None:
        """Writes one ``.html`` file for a browser, as :meth:`picture`: plots, a table, and a view that can be turned and cut and in which elements can be picked."""
        self._draw("report", path, ("html",), title, None)

    def _draw(self, what: str, path: Union[str, os.PathLike[str]], forms: tuple[str, ...], title: str, width: Optional[int]) -> None:
        target = pathlib.Path(path)
        form = target.suffix[1:].lower()
        if form not in forms:
            raise ValueError(f"{target}: end the name in {' or '.join('.' + each for each in forms)}")
        wide = None if width is None else whole(width, "width", 1)
        write_whole(target, self._drawn(what, form, title, wide))

    def _drawn(self, what: str, form: str, title: str, width: Optional[int]) -> bytes:
        return _fdem.draw(self._elements, self._pairs, self._shifts, what, form, title, width)

    def _noun(self) -> str:
        flat = self._positions.shape[1] == 2
        one = self.n == 1
        if self._kind == "upper":
            return ("rectangle" if one else "rectangles") if flat else ("box" if one else "boxes")
        if self._kind == "pairs":
            return f"{'point' if one else 'points'} within cut-offs up to {self._size:g}"
        if self._kind == "cutoff":
            return f"{'point' if one else 'points'} within {self._size:g}"
        return f"{'disc' if flat else 'sphere'}{'' if one else 's'}"

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
        table = f"<table><caption>fdem.Contacts</caption>{body}</table>"
        # Notebooks that show HTML leave out the picture.
        picture = self._repr_png_()
        if picture is None:
            return table
        encoded = base64.b64encode(picture).decode("ascii")
        return f"{table}<img alt='the elements and their contacts' style='max-width:100%' src='data:image/png;base64,{encoded}'>"

    def _repr_png_(self) -> Optional[bytes]:
        """The picture for notebooks; none of boxes, of very many elements, and of positions that have been changed since the search."""
        if "png" not in self._kept:
            drawable = self._kind != "upper" and 0 < self.n <= _MOST_SHOWN and len(self) <= 8 * _MOST_SHOWN
            try:
                self._kept["png"] = self._drawn("picture", "png", "", _SHOWN_WIDTH) if drawable else None
            except RuntimeError:
                return None
        picture: Optional[bytes] = self._kept["png"]
        return picture


_MOST_SHOWN = 50_000
"""Elements that are drawn in a notebook in about a second."""

_SHOWN_WIDTH = 900
"""Pixels that the picture in a notebook is wide."""


def optional(module: str, package: str) -> Any:
    """Imports a module of a package that fdem needs for one purpose only."""
    import importlib

    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise ImportError(f"this needs {package}: pip install {package}") from error
