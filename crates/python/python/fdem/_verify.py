"""Brute force over images, by NumPy alone: a check that shares nothing with the search."""

from __future__ import annotations

import itertools

import numpy as np

from ._couples import Couples


def verify_periodic(found: Couples, periodic: list[bool], sample: int, seed: int) -> int:
    """Compares the couples of `sample` elements with all images of all elements, in float64. Without a box that repeats there is one image.

    Both answers count as right if the distance is within rounding of the limit.
    """
    low = found._positions.astype(np.float64)
    n, dimensions = low.shape
    edges = np.eye(dimensions) if found._box is None else found._box.edges
    rng = np.random.default_rng(seed)
    picked = np.sort(rng.choice(n, min(sample, n), replace=False)) if n else np.zeros(0, np.intp)

    is_box = found._kind == "upper"
    high = found._others.astype(np.float64) if is_box and found._others is not None else low
    radii = np.full(n, found._size / (2 if found._kind in ("cutoff", "pairs") else 1))
    if found._kind == "radii" and found._others is not None:
        radii = found._others.astype(np.float64)
    extent = (high - low).max(initial=0.0)
    # The cut-off of each pair of types; pairs that have none never touch.
    types, limits = found._others, None
    if found._kind == "pairs" and types is not None and n:
        limits = np.full([int(types.max()) + 1] * 2, -np.inf)
        for a, b, limit in found._cutoffs or []:
            limits[a, b] = limits[b, a] = limit
    single = found._positions.dtype == np.float32
    doubt = (1e-5 if single else 1e-12) * (np.abs(low).max(initial=1.0) + np.abs(edges).sum() + extent)

    heights = 1 / np.linalg.norm(np.linalg.inv(edges), axis=0)
    reach = extent + 2 * radii.max(initial=0.0) + found._tolerance + doubt

    in_box = np.isin(np.arange(n), picked)
    of_picked = in_box[found.i] | in_box[found.j]
    listed: dict[tuple[int, ...], int] = {}
    for i, j, shift in zip(found.i[of_picked].tolist(), found.j[of_picked].tolist(), found.shift[of_picked].tolist()):
        key = (i, j, *shift)
        listed[key] = listed.get(key, 0) + 1
        if i > j or (i == j and tuple(shift) <= (0,) * dimensions) or listed[key] > 1:
            raise RuntimeError(f"the couples are wrong: ({i}, {j}) with shift {shift} is none, or is listed twice")

    allowed = dict.fromkeys(listed, False)
    for element in picked.tolist():
        apart = (low - low[element]) @ np.linalg.inv(edges)
        first = np.floor(-apart - reach / heights).astype(np.int64)
        last = np.ceil(-apart + reach / heights).astype(np.int64)
        lengths = [range(int((last - first)[:, axis].max(initial=0)) + 1) if periodic[axis] else range(1) for axis in range(dimensions)]
        start = np.where(periodic, first, 0)
        for step in itertools.product(*lengths):
            shift = start + np.array(step)
            moved = shift @ edges
            if is_box:
                gaps = np.maximum(low + moved - high[element], low[element] - high - moved).max(axis=1)
                gap = gaps - found._tolerance
            else:
                distance = np.linalg.norm(low + moved - low[element], axis=1)
                touching = radii + radii[element] if limits is None or types is None else limits[types, types[element]]
                gap = distance - (touching + found._tolerance)
            near = gap <= doubt
            if found._groups is not None:
                near &= found._groups != found._groups[element]
            for other in np.flatnonzero(near).tolist():
                of_other = tuple(shift[other].tolist())
                if other == element and not any(of_other):
                    continue
                if other < element or (other == element and of_other < (0,) * dimensions):
                    key = (other, element, *(-s for s in of_other))
                else:
                    key = (element, other, *of_other)
                if key in allowed:
                    allowed[key] = True
                elif gap[other] < -doubt:
                    raise RuntimeError(f"the couples are wrong: elements {key[0]} and {key[1]} touch with shift {key[2:]}, and are not listed")
    for key, touches in allowed.items():
        if not touches:
            raise RuntimeError(f"the couples are wrong: elements {key[0]} and {key[1]} are listed with shift {key[2:]}, and do not touch")
    return len(picked)
