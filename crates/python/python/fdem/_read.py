"""Files of packings and meshes."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _fdem
from ._box import Box
from ._input import whole


@dataclass(frozen=True, eq=False)
class Packing:
    """The elements of a file."""

    positions: npt.NDArray[np.float64]
    """``[n, 2]`` or ``[n, 3]``: centres, in the unit of the file."""
    radii: Optional[npt.NDArray[np.float64]]
    """``[n]``: radii; None if the file has none."""
    ids: Optional[npt.NDArray[np.int64]]
    """``[n]``: what the file calls the elements; None if it does not."""
    bodies: Optional[npt.NDArray[np.int64]]
    """``[n]``: the body of each, of the column that was asked for."""
    row_numbers: Optional[npt.NDArray[np.uint64]]
    """``[n]``: the row of each, from 0, if rows were left out."""
    box: Optional[Box]
    """The box of the file, as :func:`contacts` takes it; None if it has none, or one without extent along an axis."""
    periodic: tuple[bool, ...]
    """``(D,)``: along which edges of the box the file says that it repeats."""
    frames: int
    """How many frames the file has."""
    frame: int
    """Which of them this is, from 0."""
    step: Optional[int]
    """The number of its time step, if the file has one."""
    time: Optional[float]
    """Its time, if the file has one."""
    format: str
    """How the file was understood."""
    unit: Optional[str]
    """The unit in the names of its columns, if there is one."""
    skipped: int
    """How many bad lines were left out."""
    bad_lines: list[str]
    """The first of them, with what is wrong."""

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
    """``[s, 2]``: nodes of each."""
    triangles: npt.NDArray[np.uint32]
    """``[t, 3]``: nodes of each."""
    tetrahedra: npt.NDArray[np.uint32]
    """``[v, 4]``: nodes of each."""
    segments_bodies: npt.NDArray[np.uint32]
    """``[s]``: the body of each, a place in `bodies`."""
    triangles_bodies: npt.NDArray[np.uint32]
    """``[t]``: the body of each."""
    tetrahedra_bodies: npt.NDArray[np.uint32]
    """``[v]``: the body of each."""
    bodies: list[tuple[Optional[int], Optional[str]]]
    """The number and the name of each body in the file, where it has them."""
    format: str
    """How the file was understood."""

    def __repr__(self) -> str:
        parts = [f"{len(getattr(self, kind)):,} {kind}" for kind in ("segments", "triangles", "tetrahedra") if len(getattr(self, kind))]
        return f"<fdem.Mesh: {len(self.nodes):,} nodes, {', '.join(parts)}, {len(self.bodies)} bodies; {self.format}>"


def read(
    path: Union[str, os.PathLike[str]],
    frame: Optional[int] = None,
    *,
    format: Optional[str] = None,
    columns: Optional[str] = None,
    bodies: Optional[str] = None,
    skip_bad_lines: bool = False,
) -> Union[Packing, Mesh]:
    """Reads a packing or a mesh.

    Parameters
    ----------
    path : str or path
        Packings: delimited text, also of YADE; NumPy ``.npy`` and ``.npz``; dumps and data of LAMMPS and LIGGGHTS; XYZ, also extended; MercuryDPM; points of VTK, VTU
        and VTP. Meshes: Gmsh, STL, OBJ, PLY, VTK, VTU, VTP, Abaqus. Compressed by gzip or zstd or not. The content says which it is, and then the name.
    frame : int, optional
        Which frame of a dump, an XYZ or a MercuryDPM file, from 0, or from the end if it is negative. Of several one must be chosen.
    format : str, optional
        What a packing is, if neither content nor name say: "text", "npy", "npz", "lammps-dump", "lammps-data", "xyz", "mercury", "vtk", "vtk-xml".
    columns : str, optional
        What the columns of a packing are, if the file does not say: ``"id,x,y,z,radius"``; ``-`` is one that is left out.
    bodies : str, optional
        The column with the body of each element: its name, or its number from 1.
    skip_bad_lines : bool, default False
        Whether lines that cannot be read are left out; `skipped` and `bad_lines` of the result tell of them. Otherwise the first is an error.

    Returns
    -------
    Packing or Mesh

    Raises
    ------
    OSError
        If the file cannot be opened.
    ValueError
        If it cannot be understood, with file, line and text.

    Examples
    --------
    >>> import pathlib, tempfile, fdem
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder, "packing.csv")
    ...     _ = path.write_text("x,y,radius\\n0,0,0.5\\n1,0,0.5\\n")
    ...     packing = fdem.read(path)
    >>> packing
    <fdem.Packing: 2 elements in 2D, radii; comma-separated text>
    >>> len(fdem.contacts(packing.positions, packing.radii))
    1
    """
    name = os.fspath(path)
    with open(name, "rb") as file:
        content = file.read()
    chosen = None if frame is None else whole(frame, "frame", -(2**62))
    kind, found = _fdem.read(content, name, format, chosen, columns, bodies, bool(skip_bad_lines))
    if kind == "mesh":
        return Mesh(**found)
    box = _box_of(name, found.pop("cell"), found["positions"].shape[1])
    return Packing(**found, **box)


def _box_of(name: str, cell: Any, dimensions: int) -> dict[str, Any]:
    """The box of a file, in so many dimensions, and where it repeats."""
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
