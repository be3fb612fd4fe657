"""Results that are copied, pickled and sent to other processes."""

import copy
import multiprocessing
import pickle

import numpy as np
import pytest
from conftest import couples, gas, with_shifts

import fdem

COPIES = {
    "pickle": lambda thing: pickle.loads(pickle.dumps(thing)),
    "protocol 2": lambda thing: pickle.loads(pickle.dumps(thing, protocol=2)),
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
}


def sets():
    positions, edge = gas(400, 9, 3)
    radii = np.random.default_rng(1).uniform(0.2, 0.6, 400)
    groups = np.arange(400) // 2
    yield fdem.contacts(positions, radii, groups=groups, tolerance=0.1, engine="nbs", threads=2)
    yield fdem.contacts(positions.astype(np.float32), cutoff=1.0, box=[edge] * 3, periodic=True)
    yield fdem.contacts(positions[:, :2], radii=0.1)
    yield fdem.boxes(positions, positions + radii[:, None], box=[edge] * 3, periodic=[True, False, True])


def same(one, other):
    assert np.array_equal(one.pairs, other.pairs) and np.array_equal(one.shift, other.shift)
    assert np.array_equal(one.distance, other.distance) and one.distance.dtype == other.distance.dtype
    assert np.array_equal(one.overlap, other.overlap)
    assert repr(one) == repr(other) and one.explain() == other.explain()
    assert other.verify(50) == 50


@pytest.mark.parametrize("how", COPIES)
def test_contacts(how):
    for found in sets():
        same(found, COPIES[how](found))
        assert len(found.distance) == len(COPIES[how](found)._kept["distance"]), "what was computed is kept"
        bonds = found.neighbor_list()
        other = COPIES[how](bonds)
        assert np.array_equal(bonds[:], other[:]) and np.array_equal(bonds.distances, other.distances)
        assert np.array_equal(bonds.segments, other.segments) and np.array_equal(bonds.shifts, other.shifts)


@pytest.mark.parametrize("how", COPIES)
def test_a_copy_notices_positions_that_were_changed(how):
    positions = gas(400, 9, 3)[0]
    found = fdem.contacts(positions, cutoff=1.0)
    positions += np.linspace(0, 1, 400)[:, None]
    with pytest.raises(RuntimeError, match="changed in place"):
        COPIES[how](found).distance  # noqa: B018


@pytest.mark.parametrize("how", COPIES)
@pytest.mark.parametrize("periodic", [False, True])
def test_detectors(how, periodic, rng):
    positions, edge = gas(500, 9, 3)
    options = {"box": [edge] * 3, "periodic": True} if periodic else {}
    detector = fdem.Detector(cutoff=1.0, buffer=0.3, groups=np.arange(500) // 3, **options)
    detector.update(positions.copy())
    other = COPIES[how](detector)
    assert (other.updates, other.redetections, other.reason) == (1, 1, detector.reason)
    same(detector.contacts, other.contacts)
    positions += rng.normal(0, 0.01, positions.shape)
    assert not detector.update(positions) and other.update(positions)
    assert with_shifts(detector.contacts) == with_shifts(other.contacts)
    assert (other.updates, other.redetections) == (2, 2) and (detector.updates, detector.redetections) == (2, 1)
    assert not other.update(positions)
    new = COPIES[how](fdem.Detector(radii=0.5))
    with pytest.raises(RuntimeError, match="before the first update"):
        new.contacts  # noqa: B018


@pytest.mark.parametrize("how", COPIES)
def test_all_other_results(how, rng):
    positions = rng.random((100, 3)) * 5
    nodes, cells = [[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1, 2], [0, 2, 3]]
    floor = [[0, 0, 0], [9, 0, 0], [0, 9, 0]]
    tree = fdem.KDTree(positions, boxsize=6)
    tree.query(positions[0])
    things = [
        fdem.Box([[1.0, 0], [0, 1]]),
        fdem.query(positions, 1.0),
        fdem.contacts(positions, cutoff=1.0).csr(),
        fdem.contacts(positions, cutoff=1.0).analyse(),
        fdem.between(positions, positions, cutoff=0.5),
        fdem.walls(positions, 0.5, floor, [[0, 1, 2]]),
        fdem.mesh(nodes, cells, bodies=[0, 1]),
        fdem.labels(np.eye(3, dtype=int)),
        tree,
    ]
    for thing in things:
        other = COPIES[how](thing)
        assert type(other) is type(thing) and repr(other) == repr(thing)
    assert COPIES[how](tree).query(positions[:3], 2)[1].tolist() == tree.query(positions[:3], 2)[1].tolist()


def searched(seed):
    return fdem.contacts(gas(300, 9, 3, seed)[0], cutoff=1.0)


def counted(found):
    return int(found.coordination.sum()), float(found.distance.sum())


@pytest.mark.parametrize("method", ["spawn", "forkserver"] if "forkserver" in multiprocessing.get_all_start_methods() else ["spawn"])
def test_multiprocessing(method):
    with multiprocessing.get_context(method).Pool(2) as pool:
        found = pool.map(searched, range(3))
        assert [couples(each) for each in found] == [couples(searched(seed)) for seed in range(3)]
        assert pool.map(counted, found) == [counted(each) for each in found]


def test_joblib():
    from joblib import Parallel, delayed

    found = [searched(seed) for seed in range(3)]
    assert Parallel(n_jobs=2)(delayed(counted)(each) for each in found) == [counted(each) for each in found]
    detector = fdem.Detector(cutoff=1.0, buffer=0.2)
    detector.update(gas(300, 9, 3)[0])
    same(Parallel(n_jobs=2)(delayed(copy.copy)(each) for each in [detector])[0].contacts, detector.contacts)


def test_dask():
    import dask

    found = [dask.delayed(searched)(seed) for seed in range(3)]
    counts = dask.compute(*[dask.delayed(counted)(each) for each in found], scheduler="processes", num_workers=2)
    assert list(counts) == [counted(searched(seed)) for seed in range(3)]
