"""Sweeps: many runs of one model with other values of its parameters."""

from __future__ import annotations

import csv
import importlib.util
import os
import pathlib
import sys
from collections.abc import Mapping, Sequence
from typing import Any, Optional, Union

from . import _fdem
from ._contacts import optional
from ._model import Model
from ._results import Results

_Path = Union[str, "os.PathLike[str]"]

# The command of the runs, which needs no `fdem` on the path.
_COMMAND = "import sys; sys.path.insert(0, {!r}); from fdem._command import main; raise SystemExit(main())"


class Sweep:
    """A folder of results of a sweep. Jupyter shows its table."""

    def __init__(self, folder: _Path) -> None:
        self._folder = pathlib.Path(folder)
        if not (self._folder / "sweep.json").is_file():
            raise ValueError(f"{self._folder} has no sweep: there is no sweep.json in it")

    @property
    def path(self) -> pathlib.Path:
        """The folder."""
        return self._folder

    @property
    def columns(self) -> dict[str, list[Any]]:
        """The table of results by its columns: ``run``, the parameters, ``status``, ``message``, the results, ``folder``. Numbers are in SI units; ``None`` stands for a
        result that a run does not have."""
        with open(self._folder / "runs.csv", encoding="utf-8", newline="") as file:
            names, *rows = csv.reader(file)
        return {name: [_value(name, row[place]) for row in rows] for place, name in enumerate(names)}

    def frame(self) -> Any:
        """The table as a ``pandas.DataFrame``, with the number of the run as its index. Needs pandas."""
        pandas = optional("pandas", "pandas")
        return pandas.DataFrame(self.columns).set_index("run")

    @property
    def table(self) -> Any:
        """The table: :meth:`frame` where pandas is installed, and otherwise :attr:`columns`."""
        return self.frame() if importlib.util.find_spec("pandas") else self.columns

    @property
    def runs(self) -> list[Optional[Results]]:
        """The results of each run; ``None`` for a run that has not begun."""
        folders = [self._folder / name for name in self.columns["folder"]]
        return [Results(folder) if (folder / "run.json").is_file() else None for folder in folders]

    def _counts(self) -> dict[str, int]:
        counts: dict[str, int] = {}
        for status in self.columns["status"]:
            counts[status] = counts.get(status, 0) + 1
        return counts

    def _repr_html_(self) -> Optional[str]:
        if not importlib.util.find_spec("pandas"):
            return None
        html: Optional[str] = self.frame()._repr_html_()
        return html

    def __repr__(self) -> str:
        counts = ", ".join(f"{count} {status}" for status, count in self._counts().items())
        return f"<fdem.Sweep: {self._folder}, {counts}>"


def _value(name: str, text: str) -> Any:
    """A cell of the table."""
    if name in ("status", "message", "folder", "state_hash"):
        return text
    if not text:
        return None
    if name == "run":
        return int(text)
    try:
        return float(text)
    except ValueError:
        return text


def sweep(
    file: Optional[_Path] = None,
    *,
    model: Optional[_Path] = None,
    grid: Optional[Mapping[str, Any]] = None,
    runs: Optional[Any] = None,
    latin_hypercube: Optional[Mapping[str, Any]] = None,
    output: Optional[_Path] = None,
    processes: Optional[int] = None,
    threads: Optional[int] = None,
    max_runs: Optional[int] = None,
    force: bool = False,
    skip_refused: bool = False,
    quiet: bool = True,
) -> Sweep:
    """Runs a model many times with other values of its parameters.

    All models are checked before the first run. Each run is a separate process with a separate folder; a run that fails is noted in the table. The same call continues an
    interrupted sweep, and skips the finished runs.

    Parameters
    ----------
    file : path, optional
        A sweep file. Without it, the sweep is the one of the keywords.
    model : path, optional
        The model file.
    grid : dict, optional
        All combinations of values: a list for each parameter, or ``{"from": 1, "to": 2, "count": 5, "scale": "log"}``. Names are parameters of the model, or paths of keys such as
        ``"material.rock.cohesion"``.
    runs : list of dict, or pandas.DataFrame, optional
        The values of each run.
    latin_hypercube : dict, optional
        ``{"count": 20, "seed": 1, "ranges": {"strength": {"from": 5e6, "to": 9e6}}}``.
    output : path, optional
        Folder of results. Default: the name of the sweep file with ``_results``, or ``sweep_results``, in the working directory.
    processes : int, optional
        Runs at once. Default: one for each processor. Results do not depend on it.
    threads : int, optional
        Threads of each run. Default: 1. Results do not depend on it.
    max_runs : int, optional
        Largest number of runs. Default: 1000.
    force : bool, default False
        Replace the runs of another sweep in the folder.
    skip_refused : bool, default False
        If the models of some runs are refused, note it in the table and run the others.
    quiet : bool, default True
        Show no progress on standard error.

    Returns
    -------
    Sweep
        The table of results, a ``pandas.DataFrame`` where pandas is installed, and the results of each run.

    Raises
    ------
    ValueError
        A sweep file, a model or a folder that is refused, with the message of the command. Then nothing has run.
    TypeError
        Keywords that do not fit together.

    Examples
    --------
    >>> import fdem
    >>> found = fdem.sweep(model="disc.toml", grid={"strength": ["6 MPa", "8 MPa"]}, output="discs")  # doctest: +SKIP
    >>> found.table  # doctest: +SKIP
    """
    if isinstance(model, Model):
        raise TypeError("model is the path of a model file: model.write(path) writes one")
    if file is not None:
        if any(given is not None for given in (model, grid, runs, latin_hypercube)):
            raise TypeError("a sweep file has the model and the values: give no other keywords for them")
        text, name, place = pathlib.Path(file).read_text(encoding="utf-8"), os.fspath(file), os.fspath(file)
    else:
        if model is None:
            raise TypeError("give a sweep file, or the keyword model with grid, runs or latin_hypercube")
        tables = {"model": os.path.abspath(model), "grid": grid, "run": _rows(runs), "latin_hypercube": latin_hypercube}
        text, name, place = _fdem.to_toml(tables), "sweep", "sweep"
    if not sys.executable:
        raise ValueError("Python does not know its own program, sys.executable, which the runs need")
    package = str(pathlib.Path(__file__).resolve().parent.parent)
    program = [sys.executable, "-c", _COMMAND.format(package)]
    target = None if output is None else os.fspath(output)
    return Sweep(_fdem.sweep(text, name, place, target, processes, threads, max_runs, force, skip_refused, quiet, program))


def _rows(runs: Any) -> Optional[Sequence[Mapping[str, Any]]]:
    if runs is None:
        return None
    rows: Sequence[Mapping[str, Any]] = runs.to_dict("records") if hasattr(runs, "to_dict") else list(runs)
    return rows
