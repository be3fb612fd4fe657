"""Folders of results of ``fdem run``: history, frames, summary and pictures."""

from __future__ import annotations

import base64
import csv
import difflib
import html
import json
import os
import pathlib
from collections.abc import Mapping, Sequence
from typing import Any, Union, overload

import numpy as np
import numpy.typing as npt

from . import _vtk
from ._contacts import optional
from ._model import Model
from ._picture import Picture

_Path = Union[str, "os.PathLike[str]"]
_Array = npt.NDArray[Any]


class History(dict[str, npt.NDArray[np.float64]]):
    """The columns of a history by their names in ``history.csv``. Like keys of model files, a name may lack its unit: ``history["top fx"]`` is ``history["top fx [N]"]``."""

    def _named(self, name: object) -> str | None:
        return next((full for full in self if full.rpartition(" [")[0] == name), None) if isinstance(name, str) and name else None

    def __missing__(self, name: str) -> npt.NDArray[np.float64]:
        full = self._named(name)
        if full is not None:
            return self[full]
        near = difflib.get_close_matches(str(name), list(self), n=len(self), cutoff=0.0) if self else []
        raise KeyError(f"the history has no column {name!r}: there is {', '.join(near)}")

    def __contains__(self, name: object) -> bool:
        return super().__contains__(name) or self._named(name) is not None

    def get(self, name: str, default: Any = None) -> Any:
        """The column, or ``default`` if there is none."""
        return self[name] if name in self else default


class Frame:
    """A frame of a run. Its files are read when an array is asked for. In two dimensions vectors have a third component of 0.

    Arrays belong to the frame and are read-only.
    """

    def __init__(self, folder: pathlib.Path, time: float, stem: str) -> None:
        self._folder = folder
        self._stem = stem
        self._time = time
        self._read: dict[str, dict[str, dict[str, _Array]]] = {}

    def _sections(self, end: str) -> dict[str, dict[str, _Array]]:
        if end not in self._read:
            path = self._folder / (self._stem + end)
            if not path.exists():
                raise ValueError(f"{path}: the frame has no such file")
            self._read[end] = _vtk.read(path)
        return self._read[end]

    @property
    def time(self) -> float:
        """Time, s."""
        return self._time

    @property
    def path(self) -> pathlib.Path:
        """The file of the bodies, or of the spheres if there are no bodies, for ParaView."""
        bodies = self._folder / (self._stem + ".vtu")
        return bodies if bodies.exists() else self._folder / (self._stem + "_spheres.vtp")

    @property
    def positions(self) -> _Array:
        """Positions of the nodes, m."""
        return self._sections(".vtu")["Points"]["Points"]

    @property
    def elements(self) -> _Array:
        """Nodes of each element."""
        cells = self._sections(".vtu")["Cells"]
        return cells["connectivity"].reshape(len(cells["offsets"]), -1)

    @property
    def nodes(self) -> Mapping[str, _Array]:
        """Arrays of the nodes by the keys of their fields: those of ``fields("node")``, such as ``velocity``."""
        return self._sections(".vtu")["PointData"]

    @property
    def cells(self) -> Mapping[str, _Array]:
        """Arrays of the elements by the keys of their fields: those of ``fields("element")``, such as ``von_mises``. ``principal_stress`` has both principal stresses."""
        return self._sections(".vtu")["CellData"]

    @property
    def cracks(self) -> Mapping[str, _Array]:
        """Broken joints, by the keys of ``fields("joint")``: ``mode`` (0 tension, 1 shear, 2 mixed), ``opening`` and so on."""
        return self._sections("_cracks.vtp").get("CellData", {})

    @property
    def contacts(self) -> Mapping[str, _Array]:
        """Contact forces, by the keys of ``fields("contact")``: ``force``, ``elements`` and so on, and the ``position`` of each."""
        sections = self._sections("_contacts.vtp")
        return {"position": sections["Points"]["Points"], **sections.get("PointData", {})}

    @property
    def spheres(self) -> Mapping[str, _Array]:
        """Spheres: their ``position``, m, and the arrays of ``spheres.pvd``, such as ``radius`` and ``velocity``."""
        sections = self._sections("_spheres.vtp")
        return {"position": sections["Points"]["Points"], **sections.get("PointData", {})}

    @property
    def sphere_contacts(self) -> Mapping[str, _Array]:
        """Contacts of spheres: the arrays of ``sphere_contacts.pvd``, such as ``force``."""
        return self._sections("_sphere_contacts.vtp").get("CellData", {})

    @property
    def coarse(self) -> Mapping[str, _Array]:
        """Spheres as a continuum, of runs with ``coarse`` in ``[output]``: ``density``, kg/m³, ``solid_fraction``, ``velocity``, m/s, and ``stress``, Pa, at ``[i, j, k]`` of the grid, whose places are ``x``, ``y`` and ``z``, m."""
        return _vtk.on_grid(self._folder / (self._stem + "_coarse.vti"), self._sections("_coarse.vti")["PointData"])

    def __repr__(self) -> str:
        return f"<fdem.Frame: {self._time:g} s, {self.path}>"


class Frames(Sequence[Frame]):
    """The frames of a run in their order."""

    def __init__(self, frames: list[Frame]) -> None:
        self._frames = frames

    @overload
    def __getitem__(self, index: int) -> Frame: ...
    @overload
    def __getitem__(self, index: slice) -> Frames: ...
    def __getitem__(self, index: Union[int, slice]) -> Union[Frame, Frames]:
        return Frames(self._frames[index]) if isinstance(index, slice) else self._frames[index]

    def __len__(self) -> int:
        return len(self._frames)

    @property
    def times(self) -> npt.NDArray[np.float64]:
        """Times, s."""
        return np.array([frame.time for frame in self._frames])

    def __repr__(self) -> str:
        return f"<fdem.Frames: {len(self)}>"


class Results:
    """A folder of results of ``fdem run``. It can be read during the run. Jupyter shows its summary and its picture."""

    def __init__(self, folder: pathlib.Path) -> None:
        self._folder = folder
        if not (folder / "run.json").is_file():
            raise ValueError(f"{folder} has no run: there is no run.json in it")

    @property
    def path(self) -> pathlib.Path:
        """The folder."""
        return self._folder

    @property
    def summary(self) -> dict[str, Any]:
        """The content of ``run.json``: status, sizes, energies, times, hashes."""
        summary: dict[str, Any] = json.loads((self._folder / "run.json").read_text(encoding="utf-8"))
        return summary

    @property
    def status(self) -> str:
        """"begun", "finished", "interrupted", or "stopped" with the reason."""
        return str(self.summary["status"])

    @property
    def model(self) -> Model:
        """The model, checked and meshed again."""
        return Model.read(self._folder / "model.toml")

    @property
    def history(self) -> History:
        """Energies, cracks, fragments and recorded quantities over time, by the columns of ``history.csv``; units may be left out, as in model files. A last row that is not written to its end is left out."""
        text = (self._folder / "history.csv").read_text(encoding="utf-8")
        names, *rows = csv.reader(text[: text.rfind("\n") + 1].splitlines())
        table = np.array(rows, dtype=np.float64).reshape(-1, len(names))
        return History((name, np.ascontiguousarray(table[:, column])) for column, name in enumerate(names))

    def frame(self) -> Any:
        """The history as a ``pandas.DataFrame``, with the time as its index. Needs pandas."""
        pandas = optional("pandas", "pandas")
        return pandas.DataFrame(self.history).set_index("time")

    @property
    def frames(self) -> Frames:
        """The frames so far. Their files are read when an array is asked for."""
        for name, end in ("results.pvd", ".vtu"), ("spheres.pvd", "_spheres.vtp"):
            path = self._folder / name
            if path.exists():
                return Frames([Frame(self._folder, time, file[: -len(end)]) for time, file in _vtk.collection(path)])
        return Frames([])

    @property
    def picture(self) -> Picture:
        """The picture of the last frame, which the command draws when a run ends."""
        path = self._folder / "picture.png"
        if not path.exists():
            raise ValueError(f"{self._folder} has no picture: the run has not ended")
        return Picture(path.read_bytes())

    def plot(self, name: str) -> Picture:
        """A plot that the command has drawn, by the name of its file: ``energy``, for instance."""
        path = self._folder / "plots" / f"{name}.png"
        if not path.exists():
            raise ValueError(f"there is no plot {name!r}: {', '.join(self.plots) or 'none is drawn before the run ends'}")
        return Picture(path.read_bytes())

    @property
    def plots(self) -> list[str]:
        """Names of the plots."""
        return sorted(path.stem for path in (self._folder / "plots").glob("*.png"))

    def _repr_png_(self) -> Union[bytes, None]:
        path = self._folder / "picture.png"
        return path.read_bytes() if path.exists() else None

    def _repr_html_(self) -> str:
        summary = self.summary
        shown = ("title", "status", "elements", "steps", "time", "broken_joints", "state_hash")
        rows = "".join(f"<tr><th>{name}</th><td>{html.escape(str(summary[name]))}</td></tr>" for name in shown if name in summary)
        png = self._repr_png_()
        picture = f'<img alt="the last frame" src="data:image/png;base64,{base64.b64encode(png).decode()}">' if png else ""
        return f"<table>{rows}</table>{picture}"

    def __repr__(self) -> str:
        return f"<fdem.Results: {self._folder}, {self.status}, {len(self.frames)} frames>"


def results(folder: _Path) -> Results:
    """Opens a folder of results of ``fdem run``.

    Parameters
    ----------
    folder : path
        The folder.

    Returns
    -------
    Results
        History, frames, summary and pictures, each read when it is asked for.

    Raises
    ------
    ValueError
        A folder that has no run.

    Examples
    --------
    >>> import fdem
    >>> found = fdem.results("disc_results")  # doctest: +SKIP
    >>> found.history["kinetic"].max()  # doctest: +SKIP
    >>> found.frames[-1].cells["von_mises"]  # doctest: +SKIP
    """
    return Results(pathlib.Path(folder))
