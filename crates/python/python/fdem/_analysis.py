"""Analysis of the network of contacts."""

from __future__ import annotations

import json
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _fdem
from ._couples import Couples
from ._input import whole


class Numbers:
    """Named numbers, arrays, and groups of them; a missing value is ``None``."""

    def __init__(self, parts: dict[str, Any]) -> None:
        self.__dict__.update({name: _told(part) for name, part in parts.items()})

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(f"there is no '{name}': choose among {', '.join(self.__dict__)}")

    def __repr__(self) -> str:
        return f"<fdem.{type(self).__name__}: {', '.join(self.__dict__)}>"

    def to_dict(self) -> dict[str, Any]:
        """The same as dictionaries and lists, for ``json.dump``."""
        return {name: _plain(part) for name, part in self.__dict__.items()}


class Analysis(Numbers):
    """The result of :meth:`Contacts.analyse`; its parts are attributes.

    ================== ==============================================================================================================================
    part               content
    ================== ==============================================================================================================================
    coordination       `mean`; `distribution` ``[k]``: elements with ``k`` contacts; `of_each` ``[n]``
    without_rattlers   the same after elements with fewer than `min_contacts` contacts were removed repeatedly: `rattlers`, `elements`,
                       `couples`, `mean`, `distribution`, `is_rattler` ``[n]``
    directions         `counts` in `bands` of equal solid angle times `sectors`: where contacts point
    fabric             `tensor` ``[D, D]`` (Satake 1982: the mean of the dyads of the contact normals), `eigenvalues` in descending order,
                       `principal_directions`, `deviator`, `anisotropy`
    clusters           `count`, `largest`, `sizes`, `percolation` for each axis, `of_each` ``[n]``
    overlaps           `overlaps` and, within a tolerance, `gaps`: `count`, `min`, `mean`, `max`, `histogram`
    packing            solid `fraction` of the `region`, with overlaps counted twice; `fraction_without_overlap`: counted once, which is a lower bound where
                       three elements overlap in one place
    voids              if they were asked for: `void_ratio` by radical Voronoi cells and `pores`, the distances from points in voids to the nearest surface: `count`,
                       `min`, `mean`, `max`, `histogram`; `porosity`; `of_each` ``[n]``: void ratios, NaN where there is no cell or it ends at the border
    radial             the radial distribution: `r`, `g`, `counts`
    ================== ==============================================================================================================================
    """


def _told(part: Any) -> Any:
    if isinstance(part, dict):
        return Numbers(part)
    if isinstance(part, list):
        if part and isinstance(part[0], dict):
            return [Numbers(each) for each in part]
        return np.asarray(part)
    return part


def _plain(part: Any) -> Any:
    if isinstance(part, Numbers):
        return part.to_dict()
    if isinstance(part, list):
        return [_plain(each) for each in part]
    return part.tolist() if isinstance(part, np.ndarray) else part


def analysed(
    contacts: Couples,
    min_contacts: Optional[int],
    inner: Optional[npt.ArrayLike],
    rdf: Union[float, tuple[float, int], None],
    voids: bool,
) -> Analysis:
    """As :meth:`Contacts.analyse`."""
    r_max, bins = rdf if isinstance(rdf, tuple) else (rdf, None)
    region = None if inner is None else np.asarray(inner, np.float64)
    if region is not None and region.shape != (contacts._positions.shape[1], 2):
        raise ValueError(f"inner must have the shape [{contacts._positions.shape[1]}, 2], two limits for each axis, not {region.shape}")
    text, of_each, clusters, rattlers, ratios = _fdem.analyse(
        contacts._elements,
        contacts._pairs,
        contacts._shifts,
        None if min_contacts is None else whole(min_contacts, "min_contacts", 0),
        None if region is None else region.tolist(),
        None if r_max is None else float(r_max),
        None if bins is None else whole(bins, "the number of bins", 1),
        bool(voids),
    )
    analysis = Analysis(json.loads(text))
    analysis.coordination.of_each = of_each
    analysis.clusters.of_each = clusters
    analysis.without_rattlers.is_rattler = rattlers
    if ratios is not None:
        analysis.voids.of_each = ratios
    return analysis
