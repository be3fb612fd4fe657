"""Cut-offs by pairs of types."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Optional

import numpy as np
import numpy.typing as npt

from ._input import array_of, number

PairCutoffs = list[tuple[int, int, float]]
"""Pairs of numbers of types, and the cut-off of each."""

_SHOWN = 20
"""Largest number of types that a message lists."""


def numbered_types(cutoff: Mapping[tuple[Any, Any], float], types: Optional[npt.ArrayLike], length: int) -> tuple[npt.NDArray[np.uint32], PairCutoffs]:
    """A number for the type of each of `length` elements, and the cut-offs of pairs of these numbers."""
    if types is None:
        raise TypeError("a cutoff for pairs of types needs types: one for each element")
    each = array_of(types, "types")
    if each.shape != (length,):
        raise ValueError(f"types must have one entry for each of {length} elements, not the shape {each.shape}")
    if each.dtype.kind not in "iuUO" and length:
        raise TypeError(f"types must be names or whole numbers, not {each.dtype}")
    known: dict[Any, int] = {}
    numbers = np.fromiter((known.setdefault(name, len(known)) for name in each.tolist()), np.uint32, length)
    found: dict[tuple[int, int], float] = {}
    for pair, distance in cutoff.items():
        if not isinstance(pair, tuple) or len(pair) != 2:
            raise ValueError(f"a cutoff is for a pair of types, such as ('H', 'C'), not for {pair!r}")
        limit = number(distance, f"the cutoff of {pair!r}")
        if not 0 <= limit < np.inf:
            raise ValueError(f"the cutoff of {pair!r} must be finite and not negative, not {limit}")
        if length == 0:
            continue
        for name in pair:
            if name not in known:
                raise ValueError(f"the cutoff of {pair!r}: no element has the type {name!r}. The types are {_listed(known)}")
        a, b = sorted(known[name] for name in pair)
        if found.setdefault((a, b), limit) != limit:
            raise ValueError(f"the cutoff of {pair!r} is {limit}, and {found[a, b]} with the types in the other order")
    return numbers, [(a, b, limit) for (a, b), limit in found.items()]


def _listed(known: dict[Any, int]) -> str:
    names = sorted(map(repr, known))
    return ", ".join(names[:_SHOWN]) + (f", … ({len(names)} in all)" if len(names) > _SHOWN else "")
