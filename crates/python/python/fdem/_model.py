"""Models of simulations: read from a file, or built in Python with the names of the file.

>>> import fdem
>>> model = fdem.Model(
...     model={"title": "a block", "end_time": 1e-4},
...     body=[{"name": "block", "material": "rock", "rectangle": {"min": [0, 0], "max": [0.2, 0.1]}, "mesh_size": 0.05}],
...     material=[{"name": "rock", "density": 2700, "youngs_modulus": 50e9, "poissons_ratio": 0.25}],
... )
>>> model
<fdem.Model 'a block': 2D, 1 body, 18 elements, end_time 0.0001 s>
"""

from __future__ import annotations

import os
import pathlib
from typing import Any, Union

from . import _fdem
from ._files import write_whole

_Path = Union[str, "os.PathLike[str]"]


class Model:
    """A model that has passed the checks of ``fdem check``, and is meshed.

    Parameters
    ----------
    folder : path, optional
        Folder of the mesh files that the model names.
    **tables
        The tables of a model file with their keys: ``model={"end_time": 1e-3}``, ``body=[{...}, ...]``, ``material=[...]``, ``boundary=[...]`` and so on. Values are
        numbers, strings, lists and dictionaries; arrays and numbers of NumPy are welcome. ``None`` stands for a key that is left out.

    Raises
    ------
    ValueError
        All errors of the model at once, each with its line, as the command shows them. Lines are those of :meth:`to_toml`.
    TypeError
        A value that no model has.

    Examples
    --------
    >>> import fdem
    >>> body = {"name": "bar", "material": "steel", "rectangle": {"min": [0, 0], "max": [1.0, 0.1]}, "mesh_size": 0.05}
    >>> steel = {"name": "steel", "density": 7800, "youngs_modulus": 210e9, "poissons_ratio": 0.3}
    >>> model = fdem.Model(model={"end_time": 1e-4}, body=[body], material=[steel])
    >>> model.bodies, model.dimensions
    (['bar'], 2)
    >>> fdem.Model.from_toml(model.to_toml()).hash == model.hash
    True
    """

    def __init__(self, *, folder: _Path = ".", **tables: Any) -> None:
        self._set(_fdem.Ready(_fdem.to_toml(tables), "model", os.path.join(folder, "model")))

    def _set(self, ready: _fdem.Ready) -> Model:
        self._ready = ready
        self._about: dict[str, Any] = ready.about()
        return self

    @classmethod
    def read(cls, path: _Path) -> Model:
        """Reads a model file. Errors are those of the command: a ``ValueError`` with its message."""
        return cls.__new__(cls)._set(_fdem.Ready(None, os.fspath(path), os.fspath(path)))

    @classmethod
    def from_toml(cls, text: str, *, folder: _Path = ".") -> Model:
        """A model of the text of a model file. ``folder``: that of the files that it names."""
        return cls.__new__(cls)._set(_fdem.Ready(text, "model", os.path.join(folder, "model")))

    def to_toml(self) -> str:
        """The text of the model file."""
        return self._ready.text

    def write(self, path: _Path) -> None:
        """Writes the model file, for ``fdem run``. Files that the model names are not copied."""
        write_whole(pathlib.Path(path), self.to_toml().encode())

    @property
    def title(self) -> str:
        """Title; empty if there is none."""
        return str(self._about["title"])

    @property
    def end_time(self) -> float:
        """When runs end, s."""
        return float(self._about["end_time"])

    @property
    def dimensions(self) -> int:
        """2 for bodies of triangles, 3 for bodies of tetrahedra."""
        return int(self._about["dimensions"])

    @property
    def elements(self) -> int:
        """Number of elements."""
        return int(self._about["elements"])

    @property
    def bodies(self) -> list[str]:
        """Names of the bodies, by the numbers in :attr:`Simulation.bodies`."""
        return list(self._about["bodies"])

    @property
    def materials(self) -> list[str]:
        """Names of the materials, by the numbers in :attr:`Simulation.materials`."""
        return list(self._about["materials"])

    @property
    def boundaries(self) -> list[str]:
        """Names of the boundaries."""
        return list(self._about["boundaries"])

    @property
    def warnings(self) -> list[str]:
        """Warnings of settings that are possible, but probably not meant."""
        return list(self._about["warnings"])

    @property
    def hash(self) -> str:
        """SHA-256 of the model: ``model_hash`` of ``run.json``. Two models are equal if their hashes are."""
        return str(self._about["hash"])

    def __repr__(self) -> str:
        title = f" {self.title!r}" if self.title else ""
        count = len(self.bodies)
        bodies = "1 body" if count == 1 else f"{count:,} bodies"
        return f"<fdem.Model{title}: {self.dimensions}D, {bodies}, {self.elements:,} elements, end_time {self.end_time:g} s>"


def material(name: str) -> dict[str, float]:
    """A material of the library, which ``library`` in a ``[[material]]`` names.

    Parameters
    ----------
    name : str
        Name of the material in the library.

    Returns
    -------
    dict
        Keys of ``[[material]]`` and their values in SI units. ``fdem materials`` shows them with their sources.

    Raises
    ------
    ValueError
        A name that the library does not have; the message lists them all.

    Examples
    --------
    >>> import fdem
    >>> fdem.material("granite")["density"]
    2650.0
    """
    known = {name: dict(keys) for name, keys in _fdem.materials()}
    if name not in known:
        raise ValueError(f"the library has no material {name!r}: it has {', '.join(known)}")
    return known[name]
