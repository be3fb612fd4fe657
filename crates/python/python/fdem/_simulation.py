"""Runs of models: steps, the arrays of their state, and changes by the caller between steps."""

from __future__ import annotations

import math
import os
import threading
from collections.abc import Callable, Mapping
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _fdem
from ._model import Model
from ._picture import Picture
from ._sphere_law import SphereLaw, with_arrays
from ._spheres import Spheres

_Path = Union[str, "os.PathLike[str]"]
_Reals = npt.NDArray[np.float64]
_Numbers = npt.NDArray[np.uint32]


class Simulation:
    """A run of a model.

    The state is read as NumPy arrays in SI units: nodes are the rows of :attr:`positions`, elements those of :attr:`elements`. They are made once for each state of the
    run, all of them at the first access, and moved into NumPy without another copy. They are read-only and do not change when the run continues: a later state has
    other arrays. Where the mesh breaks, a node becomes several: the first keeps its number, and the others follow after all nodes of the mesh.

    A run goes through the stages, conditions and servos of its model as ``fdem run`` does, and reaches the same state. A stage in which elements vanish or appear renumbers
    nodes and elements.

    Results do not depend on the number of threads, nor on how steps are divided into calls. Other threads of Python run while steps are taken. Ctrl-C ends
    :meth:`advance` after a step, and the run can be used and continued.

    Parameters
    ----------
    model : Model
        The model.
    threads : int, optional
        Number of threads; 0 for one on each processor.
    earlier : path, optional
        A folder of ``fdem run``, with whose end the run begins, as with ``fdem run --from``.

    Raises
    ------
    ValueError
        A model that cannot be simulated.

    Examples
    --------
    >>> import fdem
    >>> body = {"name": "bar", "material": "steel", "rectangle": {"min": [0, 0], "max": [1.0, 0.1]}, "mesh_size": 0.05, "velocity": [2.0, 0]}
    >>> steel = {"name": "steel", "density": 7800, "youngs_modulus": 210e9, "poissons_ratio": 0.3}
    >>> run = fdem.Simulation(fdem.Model(model={"end_time": 1e-4, "gravity": "none"}, body=[body], material=[steel]))
    >>> run.advance()
    >>> round(float(run.displacements[:, 0].mean()), 5)
    0.0002
    >>> round(run.energies["kinetic"])
    1560
    """

    def __init__(self, model: Model, threads: int = 0, *, earlier: Optional[_Path] = None) -> None:
        if threads < 0:
            raise ValueError(f"threads must be at least 0, not {threads}")
        if earlier is not None and not os.path.isdir(earlier):
            raise ValueError(f"earlier must be a folder of `fdem run`, not {os.fspath(earlier)!r}")
        self._open(_fdem.Run(model._ready, threads, None if earlier is None else os.fspath(earlier)))

    def _open(self, run: _fdem.Run) -> None:
        self._opened, self._process = run, os.getpid()
        # Held while steps are taken: by this thread, another one, or the callback.
        self._advancing = threading.Lock()
        self._begin()

    @property
    def _run(self) -> _fdem.Run:
        if os.getpid() != self._process and self._opened.threads > 1:
            raise RuntimeError(
                f"this run has {self._opened.threads} threads, and a forked process has none of them: make the run in the child, or with threads=1"
            )
        return self._opened

    def _begin(self) -> None:
        self._about: dict[str, Any] = self._run.about()
        self._stage = self.stage
        self._clear()

    def _clear(self) -> None:
        self._seen: Optional[dict[str, Any]] = None
        self._fields: dict[tuple[str, Optional[str]], npt.NDArray[Any]] = {}
        self._forces: Optional[dict[str, Any]] = None

    @property
    def model(self) -> str:
        """The text of the model file."""
        return self._run.text

    @property
    def dimensions(self) -> int:
        """2 for triangles, 3 for tetrahedra."""
        return int(self._about["dimensions"])

    @property
    def steps(self) -> int:
        """Steps done."""
        return self._run.steps

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return self._run.time

    @property
    def time_step(self) -> float:
        """Time step, s."""
        return self._run.time_step

    @property
    def end_time(self) -> float:
        """The ``end_time`` of the model, s."""
        return float(self._about["end_time"])

    @property
    def stage(self) -> Optional[str]:
        """Name of the stage in which the run is; ``None`` if the model has no stages."""
        return self._run.stage

    @property
    def is_over(self) -> bool:
        """Whether the run is over before its ``end_time``: the ``until`` of the model is met, or its last stage has ended."""
        return self._run.is_over

    @property
    def log(self) -> list[str]:
        """Lines that ``fdem run`` writes to its log: an earlier run that this one begins with, ends of stages, the end of the run. A resumed run begins with none."""
        return self._run.told

    @property
    def threads(self) -> int:
        """Number of threads."""
        return self._run.threads

    @property
    def state_hash(self) -> str:
        """SHA-256 of positions, velocities, stresses, cracks and energies: ``state_hash`` of ``run.json``. Energies are those of the last step of :meth:`advance`."""
        return self._run.state_hash

    def advance(
        self,
        steps: Optional[int] = None,
        *,
        time: Optional[float] = None,
        until: Optional[float] = None,
        callback: Optional[Callable[[Simulation], object]] = None,
        every: int = 1,
    ) -> None:
        """Takes a number of steps, or steps for a duration, until a simulated time, or to the end of the model. A run that is over (:attr:`is_over`) takes none.

        Parameters
        ----------
        steps : int, optional
            Number of steps.
        time, until : float, optional
            Simulated time to add, or to reach, s; rounded up to whole steps.
        callback : callable, optional
            Called with this run before each step whose number is a multiple of `every`, also before the first. It may read the run, and set velocities, forces and
            factors of boundaries, whose work is in the energies. How steps are divided into calls of `advance` does not matter. If it raises an exception, the run
            stays at this step.
        every : int, optional
            Steps between two calls of `callback`.

        Raises
        ------
        ValueError
            More than one of `steps`, `time` and `until`, or one that is no number of steps.
        RuntimeError
            The reason why the run cannot continue, such as an inverted element or an error of the energy balance; steps of a run that is over; a call from the
            `callback`, or while another thread takes steps; several threads in a forked process.
        """
        if sum(given is not None for given in (steps, time, until)) > 1:
            raise ValueError("give one of steps, time and until")
        if every < 1:
            raise ValueError(f"every must be at least 1, not {every}")
        for name, given in (("steps", steps), ("time", time), ("until", until)):
            if given is not None and not 0 <= given < math.inf:
                raise ValueError(f"{name} must be a number from 0 on, not {given}")
        if steps is not None:
            end = self.steps + int(steps)
        elif time is not None:
            end = self.steps + _steps(time, self.time_step)
        elif until is not None:
            end = _steps(until, self.time_step)
        else:
            end = self._run.total
        if self.is_over and end > self.steps and (steps is not None or time is not None or until is not None):
            raise RuntimeError(f"the run is over at step {self.steps}: its until is met, or its last stage has ended")
        if not self._advancing.acquire(blocking=False):
            raise RuntimeError("the run is taking steps already: in another thread, or because the callback of advance calls it")
        try:
            while self.steps < end and not self.is_over:
                stop = end
                if callback is not None:
                    if self.steps % every == 0:
                        callback(self)
                    stop = min(end, self.steps + every - self.steps % every)
                self._clear()
                self._run.advance(stop - self.steps)
                if self.stage != self._stage:
                    self._begin()
        finally:
            self._advancing.release()

    def _state(self, name: str) -> Any:
        if self._seen is None:
            seen = self._run.snapshot()
            names = seen.pop("group_names"), seen.pop("wall_names")
            self._seen = _frozen(seen)
            self._spheres = Spheres(seen["spheres"], *names)
        return self._seen[name]

    def _pressing(self) -> dict[str, Any]:
        if self._forces is None:
            self._forces = _frozen(self._run.forces())
        return self._forces

    @property
    def positions(self) -> _Reals:
        """Positions of the nodes, m: nodes × dimensions."""
        return self._state("positions")  # type: ignore[no-any-return]

    @property
    def displacements(self) -> _Reals:
        """Displacements of the nodes, m."""
        return self._state("displacements")  # type: ignore[no-any-return]

    @property
    def velocities(self) -> _Reals:
        """Velocities of the nodes, m/s, half a step before the positions."""
        return self._state("velocities")  # type: ignore[no-any-return]

    @property
    def elements(self) -> _Numbers:
        """Nodes of each element."""
        return self._state("elements")  # type: ignore[no-any-return]

    @property
    def stress(self) -> _Reals:
        """Cauchy stress of each element, ``[xx, yy, zz, xy, yz, xz]`` in Pa, tension positive."""
        return self._state("stress")  # type: ignore[no-any-return]

    @property
    def damage(self) -> _Reals:
        """Largest damage of the joints of each element, from 0 to 1."""
        return self._state("damage")  # type: ignore[no-any-return]

    @property
    def bodies(self) -> _Numbers:
        """Body of each element."""
        return self._state("bodies")  # type: ignore[no-any-return]

    @property
    def materials(self) -> _Numbers:
        """Material of each element."""
        return self._state("materials")  # type: ignore[no-any-return]

    @property
    def fragments(self) -> _Numbers:
        """Fragment of each element: elements that hang together by facets have one number."""
        return self._state("fragments")  # type: ignore[no-any-return]

    @property
    def joints(self) -> Mapping[str, npt.NDArray[Any]]:
        """Joints that soften or are broken, by column: ``elements`` (on both sides), ``corners`` (m), ``damage`` (0 to 1), ``broken``, ``mode`` (0 tension, 1 shear,
        2 mixed), ``opening`` and ``sliding`` (m), ``time`` (of failure, s; NaN while the joint holds), ``measure`` (length, m, or area, m²)."""
        return self._state("joints")  # type: ignore[no-any-return]

    @property
    def spheres(self) -> Spheres:
        """Spheres or discs, their contacts and the walls now; without any, all arrays are empty. See :class:`Spheres`."""
        self._state("spheres")
        return self._spheres

    def field(self, name: str, at: Optional[str] = None) -> npt.NDArray[Any]:
        """Values of a field now: a number, or a row of components, for each node, element, joint, contact or sphere. Read-only. :func:`fields` lists the fields with their
        units and signs.

        Parameters
        ----------
        name : str
            Its key, such as "von_mises".
        at : str, optional
            "node", "element", "joint", "contact", "sphere", "sphere contact" or "wall", where a key occurs twice. Otherwise the first of these that has it.

        Raises
        ------
        ValueError
            A field that does not exist. The message lists those that do.
        """
        if (name, at) not in self._fields:
            values = self._run.field(name, at)
            values.flags.writeable = False
            self._fields[name, at] = values
        return self._fields[name, at]

    @property
    def cracks(self) -> dict[str, npt.NDArray[Any]]:
        """The joints that the run has broken, with the columns of :attr:`joints`. Joints of sets that are open from the start are not among them. Copies."""
        joints = self.joints
        cracked = joints["broken"] & ~joints["open_from_start"]
        return {name: values[cracked] for name, values in joints.items()}

    @property
    def contacts(self) -> dict[str, npt.NDArray[Any]]:
        """Contacts that press, at the beginning of the last step, by column: ``elements`` (the two), ``point`` (m), ``force`` on the first element (N), and its parts
        ``normal`` and ``tangential``."""
        return {name: values for name, values in self._pressing().items() if name != "reactions"}

    @property
    def reactions(self) -> _Reals:
        """Force of all boundaries, and of the caller, on each node at the beginning of the last step, N."""
        return self._pressing()["reactions"]  # type: ignore[no-any-return]

    @property
    def boundary_forces(self) -> dict[str, _Reals]:
        """Force of each boundary on the bodies at the beginning of the last step, N."""
        return self._run.boundary_forces()

    @property
    def energies(self) -> dict[str, float]:
        """Energies at the beginning of the last step, J, by their names in the history, with the initial energy. ``balance`` is the error of their balance, and ``error`` that as
        a share of the energy exchanged."""
        return dict(self._run.energies())

    @property
    def counts(self) -> dict[str, int]:
        """Numbers of elements, nodes, joints that hold, joints that the run has broken, joints that are open from the start, contacts and detections."""
        return dict(self._run.counts())

    def set_velocities(self, nodes: npt.ArrayLike, velocities: npt.ArrayLike) -> None:
        """Sets velocities of nodes, m/s. The work of the change is external work, which :attr:`energies` have after the next step.

        Parameters
        ----------
        nodes : array_like
            Nodes: rows of :attr:`positions` of now, or a mask.
        velocities : array_like
            One velocity for each node, or one for all.
        """
        numbers, vectors = self._vectors(nodes, velocities)
        self._run.set_velocities(numbers, vectors)
        self._clear()

    def set_forces(self, nodes: npt.ArrayLike, forces: npt.ArrayLike) -> None:
        """Sets forces on nodes, N, which act from the next step on until they are set again. Other nodes keep theirs.

        The elements around a node share its force equally, and keep their shares where the mesh breaks. The work is external work. In two dimensions a force is
        that on the whole thickness.

        Parameters
        ----------
        nodes : array_like
            Nodes: rows of :attr:`positions` of now, or a mask.
        forces : array_like
            One force for each node, or one for all.
        """
        numbers, vectors = self._vectors(nodes, forces)
        self._run.set_forces(numbers, vectors)

    def clear_forces(self) -> None:
        """Takes all forces of :meth:`set_forces` away."""
        self._run.clear_forces()

    def add_spheres(
        self,
        positions: npt.ArrayLike,
        radii: npt.ArrayLike,
        *,
        material: Optional[str] = None,
        group: Optional[str] = None,
        velocities: npt.ArrayLike = 0.0,
        spins: npt.ArrayLike = 0.0,
    ) -> _Numbers:
        """Adds spheres between two steps: an insertion of your own, for instance in the callback of :meth:`advance`. They touch nothing at first. Their energy is external work.

        Parameters
        ----------
        positions : array_like, spheres × 3 or spheres × 2
            Centres, m.
        radii : array_like
            One radius for each, or one for all, m.
        material : str, optional
            Name of their material. Default: the only material of the model.
        group : str, optional
            Name of the ``[[grains]]`` or the ``[[insertion]]`` to which they belong. Default: the first.
        velocities, spins : array_like
            Velocity, m/s, and angular velocity, rad/s, of each or of all. Default: 0.

        Returns
        -------
        ndarray of uint32
            The numbers of the new spheres.

        Raises
        ------
        ValueError
            A sphere that overlaps another one, a wall or a body, or a wrong number. Then none is added.
        """
        places = _in_space(positions, None)
        materials, groups = self._run.sphere_names()
        if material is None and len(materials) != 1:
            raise ValueError(f"material is one of {', '.join(materials)}")
        kind = _place("material", material if material is not None else materials[0], materials)
        number = 0 if group is None else _place("group", group, groups)
        each = np.ascontiguousarray(np.broadcast_to(np.asarray(radii, dtype=np.float64), (len(places),)))
        motion = [_in_space(of, len(places)) for of in (velocities, spins)]
        added = self._run.add_spheres(places, each, motion, [kind, number])
        self._clear()
        return added

    def set_sphere_law(self, law: SphereLaw, *, reach: float = 0.0, memory: int = 0, replace: bool = False) -> None:
        """Sets a law of your own for couples of spheres, from the next step on: a bond, a liquid bridge, a force at a distance, or another law of contact.

        The law is called once in each step with all couples, and computes with whole arrays. Contacts with walls and bodies keep the law of the model. The work of the
        law is external work. The time step must be short enough for the law: nothing checks that. A function is not saved: a run that is resumed needs the law again,
        and has its memory.

        Parameters
        ----------
        law : function
            Gets :class:`SpherePairs`, and returns the force on the first sphere of each couple, N, couples × 3; or a pair of these and the moments on the first, N m. The
            opposite acts on the second. Forces act in the middle of the overlap or of the gap.
        reach : float
            Gap up to which the law gets couples, m. Default: those that touch.
        memory : int
            Numbers that the law keeps for each couple from step to step.
        replace : bool
            Whether the law acts in place of that of the model, and not besides it.

        Raises
        ------
        ValueError
            A model without spheres, a wrong reach, or a law that differs from that of the run that is continued. What the law itself raises comes out of :meth:`advance`.
        """
        self._run.set_sphere_law(with_arrays(law), (reach, memory), replace)

    def clear_sphere_law(self) -> None:
        """Takes the law of :meth:`set_sphere_law` away: contacts of spheres have the law of the model from the next step on."""
        self._run.clear_sphere_law()

    def set_boundary(self, name: str, *, factor: Optional[float]) -> None:
        """Sets the factor of a boundary from the next step on, in place of its ramp or table; ``None`` gives it these back. A servo sets that of its own boundary.

        Parameters
        ----------
        name : str
            Name of a boundary of the present stage.
        factor : float or None
            Factor of its velocity, displacement, force, traction or pressure.
        """
        names: list[str] = self._about["boundaries"]
        if name not in names:
            raise ValueError(f"there is no boundary {name!r}: {', '.join(map(repr, names)) or 'the model has none'}")
        self._run.set_boundary(names.index(name), factor)

    def _vectors(self, nodes: npt.ArrayLike, vectors: npt.ArrayLike) -> tuple[_Numbers, _Reals]:
        numbers = np.asarray(nodes)
        if numbers.dtype == bool:
            if numbers.shape != (self.counts["nodes"],):
                raise ValueError(f"a mask of nodes has {self.counts['nodes']} entries, not the shape {numbers.shape}")
            numbers = np.flatnonzero(numbers)
        numbers = numbers.reshape(-1)
        if numbers.size and (not np.issubdtype(numbers.dtype, np.integer) or numbers.min() < 0 or numbers.max() > 0xFFFF_FFFF):
            raise ValueError("nodes are whole numbers from 0 on, or a mask")
        shape = (len(numbers), self.dimensions)
        given = np.asarray(vectors, dtype=np.float64)
        if given.shape not in (shape, (self.dimensions,)):
            raise ValueError(f"one vector of {self.dimensions} components for each of {len(numbers)} nodes, or one for all, not the shape {given.shape}")
        return numbers.astype(np.uint32), np.ascontiguousarray(np.broadcast_to(given, shape))

    def save(self, path: _Path) -> None:
        """Writes the run, with its model and the forces and factors that are set, to a file from which :func:`resume` continues it with the same bits."""
        self._run.save(os.fspath(path))

    def picture(self, field: Optional[str] = None, *, width: Optional[int] = None) -> Picture:
        """Draws the run now.

        Parameters
        ----------
        field : str, optional
            A field of :func:`fields` that is ``drawn``, such as "von_mises"; otherwise the first of the model's output.
        width : int, optional
            Width in pixels.
        """
        return Picture(self._run.picture(field, width))

    def _repr_png_(self) -> bytes:
        return self.picture().png

    def __repr__(self) -> str:
        counts = self.counts
        broken = f", {counts['broken_joints']:,} joints broken" if counts["broken_joints"] else ""
        return f"<fdem.Simulation: step {self.steps:,}, {self.time:g} of {self.end_time:g} s, {counts['elements']:,} elements{broken}>"


def resume(path: _Path, threads: int = 0) -> Simulation:
    """Continues a run with the same bits.

    Parameters
    ----------
    path : path
        A file of :meth:`Simulation.save`, or a folder of ``fdem run``, whose last checkpoint is read. The folder is not changed.
    threads : int, optional
        Number of threads; 0 for one on each processor.

    Returns
    -------
    Simulation
        The run.

    Raises
    ------
    ValueError
        A file that cannot be read, is damaged, or was made by another version.

    Examples
    --------
    >>> import fdem, os, tempfile
    >>> body = {"name": "bar", "material": "steel", "rectangle": {"min": [0, 0], "max": [1.0, 0.1]}, "mesh_size": 0.05}
    >>> steel = {"name": "steel", "density": 7800, "youngs_modulus": 210e9, "poissons_ratio": 0.3}
    >>> run = fdem.Simulation(fdem.Model(model={"end_time": 1e-4}, body=[body], material=[steel]))
    >>> run.advance(10)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     run.save(os.path.join(folder, "half"))
    ...     again = fdem.resume(os.path.join(folder, "half"))
    >>> again.state_hash == run.state_hash
    True
    """
    run = Simulation.__new__(Simulation)
    run._open(_fdem.Run.resume(os.fspath(path), threads))
    return run


def _in_space(vectors: npt.ArrayLike, count: Optional[int]) -> _Reals:
    """Rows of three components. With a number of rows one vector may stand for all, and 0 for a vector."""
    given = np.asarray(vectors, dtype=np.float64)
    if count is not None and given.ndim == 0 and given == 0:
        return np.zeros((count, 3))
    if given.ndim == 1 and count is not None:
        given = np.broadcast_to(given, (count, len(given)))
    if given.ndim != 2 or given.shape[1] not in (2, 3) or count not in (None, len(given)):
        raise ValueError(f"one vector of 2 or 3 components for each sphere, or one for all, not the shape {np.shape(vectors)}")
    rows = np.zeros((len(given), 3))
    rows[:, : given.shape[1]] = given
    return rows


def _place(what: str, name: str, names: list[str]) -> int:
    if name not in names:
        raise ValueError(f"there is no {what} {name!r}: {', '.join(names)}")
    return names.index(name)


def _steps(time: float, step: float) -> int:
    """Steps that reach a time, as the command counts them."""
    return max(1, math.ceil(time / step)) if time > 0 else 0


def _frozen(arrays: dict[str, Any]) -> dict[str, Any]:
    """Arrays that nobody writes to, since that would not change the run."""
    for value in arrays.values():
        if isinstance(value, dict):
            _frozen(value)
        else:
            value.flags.writeable = False
    return arrays
