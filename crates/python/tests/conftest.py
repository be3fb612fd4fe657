"""Functions that several tests use."""

import importlib
import importlib.util
import itertools
import os
import pathlib
import sys

import numpy as np
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[3]


@pytest.fixture
def rng():
    return np.random.default_rng(20260101)


@pytest.fixture(scope="session")
def command():
    """The command: the one that the variable FDEM names, or else the one that the package has installed."""
    return os.environ.get("FDEM", "fdem")


def module_with(path, name, replaced):
    """The module of a file, which imports other things in place of some attributes of modules: ``{module: {attribute: value}}``."""
    spec = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(spec)
    # So that its classes can be pickled.
    sys.modules[name] = module
    with pytest.MonkeyPatch.context() as patch:
        for of, attributes in replaced.items():
            for attribute, value in attributes.items():
                patch.setattr(importlib.import_module(of), attribute, value)
        spec.loader.exec_module(module)
    return module


def gas(n, neighbours, dimensions, seed=0):
    """Random points in a cube, with about `neighbours` neighbours within a distance of 1."""
    ball = {2: np.pi, 3: 4 / 3 * np.pi}[dimensions]
    edge = (n * ball / neighbours) ** (1 / dimensions)
    return np.random.default_rng(seed).random((n, dimensions)) * edge, edge


def brute_force(positions, reach, groups=None):
    """Couples for a matrix of contact distances, by testing all pairs in the type of the positions."""
    n = len(positions)
    i, j = np.triu_indices(n, 1)
    squares = (positions[i] - positions[j]) ** 2
    sums = squares[:, 0]
    for axis in range(1, positions.shape[1]):
        sums = sums + squares[:, axis]
    limit = reach[i, j] if np.ndim(reach) else reach
    kept = sums <= limit * limit
    if groups is not None:
        kept &= groups[i] != groups[j]
    return set(zip(i[kept].tolist(), j[kept].tolist()))


def brute_force_images(positions, radii, edges, periodic, images):
    """Couples with shifts, by testing `images` images along each edge on both sides."""
    found = set()
    ranges = [range(-images, images + 1) if repeats else (0,) for repeats in periodic]
    for shift in itertools.product(*ranges):
        moved = positions + np.array(shift) @ edges
        distance = np.linalg.norm(positions[:, None] - moved[None], axis=-1)
        for i, j in np.argwhere(distance <= radii[:, None] + radii[None]):
            if i < j or (i == j and shift > (0,) * len(shift)):
                found.add((int(i), int(j), *shift))
    return found


def with_shifts(contacts):
    return {(i, j, *shift) for (i, j), shift in zip(contacts.pairs.tolist(), contacts.shift.tolist())}


def couples(contacts):
    pairs = list(map(tuple, contacts.pairs.tolist()))
    assert len(set(pairs)) == len(pairs), "each couple once"
    return set(pairs)
