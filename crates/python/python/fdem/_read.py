"""Files of packings and meshes."""

from __future__ import annotations

import io
import os
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, Optional, Union, overload

import numpy as np
import numpy.typing as npt

from . import _fdem
from ._box import Box
from ._input import whole

_PIECE = 1 << 26
"""Bytes that are read at a time."""


@dataclass(frozen=True, eq=False)
class Packing:
    """The elements of a file."""

    positions: npt.NDArray[np.float64]
    """``[n, 2]`` or ``[n, 3]``: centres, in the unit of the file."""
    radii: Optional[npt.NDArray[np.float64]]
    """``[n]``: radii; None if the file has none."""
    ids: Optional[npt.NDArray[np.int64]]
    """``[n]``: the ids of the elements in the file; None if it has none."""
    bodies: Optional[npt.NDArray[np.int64]]
    """``[n]``: the body of each element, from the column that was asked for; None without one."""
    row_numbers: Optional[npt.NDArray[np.uint64]]
    """``[n]``: the row of each element, from 0, if rows were left out; else None."""
    box: Optional[Box]
    """The box of the file, as :func:`contacts` takes it; None if it has none, or one without extent along an axis."""
    periodic: tuple[bool, ...]
    """``(D,)``: whether the box repeats along each edge, as the file says."""
    frames: int
    """The number of frames of the file."""
    frame: int
    """The number of this frame, from 0."""
    step: Optional[int]
    """The number of its time step, if the file has one."""
    time: Optional[float]
    """The time of the frame, if the file has one."""
    format: str
    """The format that was read."""
    unit: Optional[str]
    """The unit in the names of the columns, if there is one."""
    skipped: int
    """The number of bad lines that were left out."""
    bad_lines: list[str]
    """The first bad lines, each with its error."""

    def __len__(self) -> int:
        return len(self.positions)

    def __repr__(self) -> str:
        sizes = "no radii" if self.radii is None else "radii"
        if any(self.periodic):
            sizes += ", a box that repeats"
        if self.frames > 1:
            sizes += f", frame {self.frame} of {self.frames}"
        left_out = f", {self.skipped} bad lines left out" if self.skipped else ""
        return f"<fdem.Packing: {len(self):,} elements in {self.positions.shape[1]}D, {sizes}; {self.format}{left_out}>"


@dataclass(frozen=True, eq=False)
class Mesh:
    """The nodes and elements of a file."""

    nodes: npt.NDArray[np.float64]
    """``[n, 2]`` if all is flat, else ``[n, 3]``."""
    segments: npt.NDArray[np.uint32]
    """``[s, 2]``: the nodes of each segment."""
    triangles: npt.NDArray[np.uint32]
    """``[t, 3]``: the nodes of each triangle."""
    tetrahedra: npt.NDArray[np.uint32]
    """``[v, 4]``: the nodes of each tetrahedron."""
    segments_bodies: npt.NDArray[np.uint32]
    """``[s]``: the body of each segment, an index into `bodies`."""
    triangles_bodies: npt.NDArray[np.uint32]
    """``[t]``: the body of each triangle."""
    tetrahedra_bodies: npt.NDArray[np.uint32]
    """``[v]``: the body of each tetrahedron."""
    bodies: list[tuple[Optional[int], Optional[str]]]
    """The number and the name of each body in the file, where it has them."""
    groups: dict[str, dict[str, npt.NDArray[np.uint32]]]
    """The sets of the file that may overlap each other and the bodies, by name: ``nodes``, ``segments``, ``triangles`` and ``tetrahedra`` are ``[k]``, indices; ``edges``
    ``[k, 2]`` and ``faces`` ``[k, 3]`` are those of elements, by their nodes."""
    notes: list[str]
    """Differences between the elements of the file and these, such as quadrilaterals that are cut into triangles."""
    format: str
    """The format that was read."""

    def __repr__(self) -> str:
        parts = [f"{len(getattr(self, kind)):,} {kind}" for kind in ("segments", "triangles", "tetrahedra") if len(getattr(self, kind))]
        return f"<fdem.Mesh: {len(self.nodes):,} nodes, {', '.join(parts)}, {len(self.bodies)} bodies; {self.format}>"


PackingFormat = Literal["text", "npy", "npz", "lammps-dump", "lammps-data", "xyz", "mercury", "vtk", "vtk-xml"]
"""The name of a format of packings."""


@overload
def read(
    path: Union[str, os.PathLike[str]],
    frame: Optional[int] = None,
    *,
    kind: Literal["packing"],
    format: Optional[PackingFormat] = None,
    columns: Optional[str] = None,
    bodies: Optional[str] = None,
    skip_bad_lines: bool = False,
) -> Packing: ...
@overload
def read(path: Union[str, os.PathLike[str]], *, kind: Literal["mesh"]) -> Mesh: ...
@overload
def read(
    path: Union[str, os.PathLike[str]],
    frame: int,
    *,
    kind: None = None,
    format: Optional[PackingFormat] = None,
    columns: Optional[str] = None,
    bodies: Optional[str] = None,
    skip_bad_lines: bool = False,
) -> Packing: ...
@overload
def read(
    path: Union[str, os.PathLike[str]],
    frame: None = None,
    *,
    kind: None = None,
    format: Optional[PackingFormat] = None,
    columns: Optional[str] = None,
    bodies: Optional[str] = None,
    skip_bad_lines: bool = False,
) -> Any: ...
def read(
    path: Union[str, os.PathLike[str]],
    frame: Optional[int] = None,
    *,
    kind: Optional[Literal["packing", "mesh"]] = None,
    format: Optional[PackingFormat] = None,
    columns: Optional[str] = None,
    bodies: Optional[str] = None,
    skip_bad_lines: bool = False,
) -> Union[Packing, Mesh]:
    """Reads a packing or a mesh.

    Parameters
    ----------
    path : str or path
        Packings: delimited text, also of YADE; NumPy ``.npy`` and ``.npz``; dumps and data of LAMMPS and LIGGGHTS; XYZ, also extended; MercuryDPM; points of VTK, VTU
        and VTP. Meshes: Gmsh, STL, OBJ, PLY, VTK, VTU, VTP, Abaqus. Files may be compressed by gzip or zstd. The format is recognised by the content, then by the name.
    frame : int, optional
        The frame of a dump, an XYZ or a MercuryDPM file, from 0, or from the end if it is negative. Required if the file has several frames.
    kind : {"packing", "mesh"}, optional
        The kind of content that the file must have. With it, or with a `frame`, type checkers know the type of the result.
    format : str, optional
        The format of a packing, if neither content nor name determine it: "text", "npy", "npz", "lammps-dump", "lammps-data", "xyz", "mercury", "vtk", "vtk-xml".
    columns : str, optional
        The columns of a packing, if the file does not name them: ``"id,x,y,z,radius"``; ``-`` is a column that is left out.
    bodies : str, optional
        The column with the body of each element: its name, or its number from 1.
    skip_bad_lines : bool, default False
        Whether lines that cannot be read are left out and listed in `skipped` and `bad_lines` of the result. Otherwise the first bad line is an error.

    Returns
    -------
    Packing or Mesh
        By the content of the file; that which `kind` names, if it is given.

    Raises
    ------
    OSError
        If the file cannot be opened.
    ValueError
        If it cannot be understood, with file, line and text; if its content is not of the `kind`.

    Examples
    --------
    >>> import pathlib, tempfile, fdem
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder, "packing.csv")
    ...     _ = path.write_text("x,y,radius\\n0,0,0.5\\n1,0,0.5\\n")
    ...     packing = fdem.read(path, kind="packing")
    >>> packing
    <fdem.Packing: 2 elements in 2D, radii; comma-separated text>
    >>> len(fdem.contacts(packing.positions, packing.radii))
    1
    """
    if kind not in (None, "packing", "mesh"):
        raise ValueError(f"there is no kind '{kind}': choose one of packing, mesh")
    name = os.fspath(path)
    content = _content(name)
    chosen = None if frame is None else whole(frame, "frame", -(2**62))
    holds, found = _fdem.read(content, name, format, chosen, columns, bodies, bool(skip_bad_lines))
    if kind is not None and holds != kind:
        raise ValueError(f"{name}: this is a {holds}, not a {kind}")
    if holds == "mesh":
        return Mesh(**found)
    return _packing_of(name, found)


def _content(name: str) -> bytes:
    """The bytes of a file, read piece by piece: between them Ctrl-C is heeded."""
    content = io.BytesIO()
    with open(name, "rb", buffering=0) as file:
        while piece := file.read(_PIECE):
            content.write(piece)
    return content.getvalue()


def _packing_of(name: str, found: dict[str, Any]) -> Packing:
    """A packing of the columns of a frame."""
    for remark in found.pop("remarks"):
        warnings.warn(remark, stacklevel=3)
    box = _box_of(name, found.pop("cell"), found["positions"].shape[1])
    return Packing(**found, **box)


class Frames(Sequence[Packing]):
    """The frames of a file: a sequence of packings, each of which is read when it is asked for. Made by :func:`frames`."""

    def __init__(self) -> None:
        raise TypeError("frames come from fdem.frames()")

    _name: str
    _frames: _fdem.Frames
    _chosen: range

    @classmethod
    def _of(cls, name: str, frames: _fdem.Frames, chosen: range) -> Frames:
        self = cls.__new__(cls)
        self._name, self._frames, self._chosen = name, frames, chosen
        return self

    def __len__(self) -> int:
        return len(self._chosen)

    @overload
    def __getitem__(self, index: int) -> Packing: ...
    @overload
    def __getitem__(self, index: slice) -> Frames: ...
    def __getitem__(self, index: Union[int, slice]) -> Union[Packing, Frames]:
        """A packing, or some of the frames; negative numbers count from the end."""
        if isinstance(index, slice):
            return Frames._of(self._name, self._frames, self._chosen[index])
        return _packing_of(self._name, self._frames.read(self._chosen[index]))

    def __repr__(self) -> str:
        return f"<fdem.Frames: {len(self):,} of {len(self._frames):,} frames of {self._name}>"


def frames(
    path: Union[str, os.PathLike[str]],
    *,
    format: Optional[PackingFormat] = None,
    columns: Optional[str] = None,
    bodies: Optional[str] = None,
    skip_bad_lines: bool = False,
) -> Frames:
    """The frames of a file of packings, such as a dump, one after the other.

    The content of the file is in memory, but only those packings that the caller keeps. For a file of one frame there is one.

    Parameters
    ----------
    path : str or path
        A file of packings, as :func:`read` takes it.
    format, columns, bodies, skip_bad_lines
        As for :func:`read`.

    Returns
    -------
    Frames
        A sequence of :class:`Packing`; slices are such sequences too. `frame`, `step` and `time` of a packing are those of the file.

    Raises
    ------
    OSError, ValueError
        As :func:`read`; for a mesh. An error inside a frame is raised when the frame is read.

    Examples
    --------
    >>> import pathlib, tempfile, fdem
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder, "run.xyz")
    ...     _ = path.write_text("".join(f"2\\nTime={time}\\nC 0 0 0\\nC {time} 0 0\\n" for time in (0.5, 1.5)))
    ...     for packing in fdem.frames(path):
    ...         print(packing.frame, len(fdem.contacts(packing.positions, cutoff=1.0)))
    0 1
    1 0
    """
    name = os.fspath(path)
    content = _content(name)
    found = _fdem.Frames(content, name, format, columns, bodies, bool(skip_bad_lines))
    return Frames._of(name, found, range(len(found)))


def _box_of(name: str, cell: Any, dimensions: int) -> dict[str, Any]:
    """The box of a file in the given number of dimensions, and the axes along which it repeats."""
    if cell is None:
        return {"box": None, "periodic": (False,) * dimensions}
    origin, edges, repeats = (np.array(part)[:dimensions] for part in cell)
    if (edges[:, dimensions:] != 0).any():
        raise ValueError(f"{name}: the box is sheared along z, and the positions have two coordinates")
    edges = edges[:, :dimensions]
    periodic = tuple(bool(edge) for edge in repeats)
    if np.linalg.det(edges) == 0:
        if any(periodic):
            raise ValueError(f"{name}: the box repeats, and has no volume")
        return {"box": None, "periodic": periodic}
    return {"box": Box(edges, origin), "periodic": periodic}
