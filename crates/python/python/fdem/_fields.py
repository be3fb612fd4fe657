"""The table of fields: descriptions, units and signs of the quantities of a run."""

from __future__ import annotations

from typing import NamedTuple, Optional

from . import _fdem


class Field(NamedTuple):
    """A quantity of a run at each node, element, joint or contact."""

    key: str
    """Name for :meth:`Simulation.field`, in the files of frames and in model files."""
    name: str
    """Name in texts."""
    about: str
    """Description."""
    definition: str
    """Definition and source; empty if ``about`` says all."""
    unit: str
    """Unit; empty for none."""
    sign: str
    """Sign convention; empty if the values have no sign."""
    span: tuple[float, float]
    """The least and the largest value that are possible."""
    at: str
    """The part of a model that has a value: "node", "element", "joint", "contact", "sphere", "sphere contact" or "wall"."""
    components: list[str]
    """Names of the components; empty for one number."""
    dimensions: Optional[int]
    """The number of dimensions in which it exists; ``None`` for both."""
    drawn: bool
    """Whether :meth:`Simulation.picture` and ``[output] fields`` can show it."""


def fields(at: Optional[str] = None) -> list[Field]:
    """The fields of results: names, units and signs of the values of :meth:`Simulation.field` and of the arrays in frames.

    Parameters
    ----------
    at : str, optional
        Only those of a "node", an "element", a "joint", a "contact", a "sphere", a "sphere contact" or a "wall".

    Returns
    -------
    list of Field
        The fields, in the order in which files have them.

    Raises
    ------
    ValueError
        If `at` is not one of these places.

    Examples
    --------
    >>> import fdem
    >>> [field.key for field in fdem.fields("node")]
    ['displacement', 'velocity', 'reaction', 'pore_pressure']
    >>> next(field.unit for field in fdem.fields() if field.key == "von_mises")
    'Pa'
    """
    places = ("node", "element", "joint", "contact", "sphere", "sphere contact", "wall")
    if at is not None and at not in places:
        raise ValueError(f"at must be one of {', '.join(map(repr, places))}, not {at!r}")
    rows = [Field(**row) for row in _fdem.fields()]
    return [row for row in rows if at is None or row.at == at]
