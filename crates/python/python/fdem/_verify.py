"""Brute force over images, by NumPy alone: a check that shares nothing with the search."""

from __future__ import annotations

import itertools

import numpy as np

from ._couples import Couples


def verify_periodic(found: Couples, periodic: list[bool], sample: int, seed: int) -> int:
    """Compares the couples of `sample` elements with all images of all elements, in float64.

    Both answers count as right if the distance is within rounding of the limit.
    """
    box = found._box
    assert box is not None
    low = found._positions.astype(np.float64)
    n, dimensions = low.shape
    rng = np.random.default_rng(seed)
    picked = np.sort(rng.choice(n, min(sample, n), replace=False)) if n else np.zeros(0, np.intp)

    is_box = found._kind == "upper"
    high = found._others.astype(np.float64) if is_box and found._others is not None else low
    radii = np.full(n, found._size / (2 if found._kind == "cutoff" else 1))
    if found._kind == "radii" and found._others is not None:
        radii = found._others.astype(np.float64)
    extent = (high - low).max(initial=0.0)
    single = found._positions.dtype == np.float32
    doubt = (1e-5 if single else 1e-12) * (np.abs(low).max(initial=1.0) + np.abs(box.edges).sum() + extent)

    heights = 1 / np.linalg.norm(np.linalg.inv(box.edges), axis=0)
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
        apart = (low - low[element]) @ np.linalg.inv(box.edges)
        first = np.floor(-apart - reach / heights).astype(np.int64)
        last = np.ceil(-apart + reach / heights).astype(np.int64)
        lengths = [range(int((last - first)[:, axis].max(initial=0)) + 1) if periodic[axis] else range(1) for axis in range(dimensions)]
        start = np.where(periodic, first, 0)
        for step in itertools.product(*lengths):
            shift = start + np.array(step)
            moved = shift @ box.edges
            if is_box:
                gaps = np.maximum(low + moved - high[element], low[element] - high - moved).max(axis=1)
                gap = gaps - found._tolerance
            else:
                distance = np.linalg.norm(low + moved - low[element], axis=1)
                gap = distance - (radii + radii[element] + found._tolerance)
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
