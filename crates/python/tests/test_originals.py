"""The drop-in forms, against what they stand in for."""

import numpy as np
import pytest
from conftest import gas

import fdem

CELLS = {
    "cube": (np.eye(3) * 9.0, True),
    "sheared": (np.array([[8.0, 0, 0], [3, 7, 0], [-2, 1, 9]]), True),
    "slab": (np.diag([9.0, 8.0, 20.0]), [True, True, False]),
    "smaller than the cut-off": (np.array([[1.1, 0, 0], [0.4, 1.3, 0], [0, 0.2, 0.9]]), True),
    "left-handed": (np.array([[0, 6.0, 0], [6.0, 0, 0], [0, 0, 7.0]]), True),
    "open": (np.zeros((3, 3)), False),
    "chain": (np.array([[0, 0, 0], [0, 0, 0], [0, 0, 5.0]]), [False, False, True]),
}


def rows(i, j, shift):
    return sorted(zip(i.tolist(), j.tolist(), map(tuple, np.asarray(shift, int).tolist())))


def atoms_in(cell, n, rng):
    from ase import Atoms

    edges, pbc = CELLS[cell]
    span = edges + np.diag((np.abs(edges).sum(axis=1) == 0) * 6.0)
    # Some are outside.
    positions = (rng.random((n, 3)) * 1.4 - 0.2) @ span
    return Atoms(rng.choice(["H", "O", "Si"], n), positions, cell=edges, pbc=pbc)


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("cutoff", [1.7, "radii", {("H", "O"): 1.9, (14, 14): 2.2, ("O", "O"): 0.7}], ids=["one", "radii", "pairs"])
def test_neighbor_list_is_that_of_ase(cell, cutoff, rng):
    from ase.neighborlist import neighbor_list

    atoms = atoms_in(cell, 9 if "smaller" in cell else 60, rng)
    if cutoff == "radii":
        cutoff = rng.uniform(0.3, 1.2, len(atoms))
    i, j, d, D, S = neighbor_list("ijdDS", atoms, cutoff)
    found = dict(zip("ijdDS", fdem.neighbor_list("ijdDS", atoms, cutoff)))
    assert len(i) > 0
    assert rows(found["i"], found["j"], found["S"]) == rows(i, j, S)
    assert (np.diff(found["i"]) >= 0).all()
    order, mine = (np.lexsort((*np.asarray(s).T, b, a)) for a, b, s in [(i, j, S), (found["i"], found["j"], found["S"])])
    assert np.allclose(found["d"][mine], d[order], rtol=1e-14) and np.allclose(found["D"][mine], D[order], atol=1e-13)
    expected = atoms.positions[found["j"]] - atoms.positions[found["i"]] + found["S"] @ atoms.cell.array
    assert np.allclose(found["D"], expected)


def test_neighbor_list_with_self_interaction(rng):
    from ase.neighborlist import neighbor_list

    atoms = atoms_in("cube", 30, rng)
    ours, theirs = (f("ijS", atoms, 1.5, self_interaction=True) for f in (fdem.neighbor_list, neighbor_list))
    assert rows(*ours) == rows(*theirs)
    only = fdem.neighbor_list("d", atoms, 1.5)
    assert isinstance(only, np.ndarray) and only.ndim == 1


def test_what_is_just_a_cutoff_apart_is_none(rng):
    from ase.build import bulk
    from ase.neighborlist import neighbor_list

    atoms = bulk("Cu", cubic=True) * (3, 3, 3)
    for cutoff in (3.61 / 2**0.5, 3.61, 3.0):
        ours, theirs = fdem.neighbor_list("i", atoms, cutoff), neighbor_list("i", atoms, cutoff)
        assert len(ours) == len(theirs)


@pytest.mark.parametrize("cell", ["cube", "sheared", "slab", "smaller than the cut-off"])
def test_neighbor_list_is_that_of_matscipy(cell, rng):
    from matscipy.neighbours import neighbour_list

    atoms = atoms_in(cell, 40, rng)
    arguments = {"positions": atoms.positions, "cell": atoms.cell.array, "pbc": atoms.pbc, "cutoff": 1.9}
    theirs = neighbour_list("ijS", **arguments)
    ours = fdem.neighbor_list("ijS", **arguments)
    assert len(theirs[0]) > 0 and rows(*ours) == rows(*theirs)


def test_what_neighbor_list_refuses():
    three = np.zeros((2, 3))
    for error, words, call in [
        (ValueError, "no quantity 'x'", lambda: fdem.neighbor_list("ix", positions=three, cutoff=1.0)),
        (TypeError, "give a cutoff", lambda: fdem.neighbor_list("i", positions=three)),
        (TypeError, "atoms, or positions", lambda: fdem.neighbor_list("i", cutoff=1.0)),
        (ValueError, "edge 1 of the cell", lambda: fdem.neighbor_list("i", positions=three, cutoff=1.0, cell=[1, 0, 1], pbc=True)),
        (TypeError, "needs numbers", lambda: fdem.neighbor_list("i", positions=three, cutoff={("H", "H"): 1})),
        (ValueError, "no element 'Xy'", lambda: fdem.neighbor_list("i", positions=three, numbers=[1, 1], cutoff={("H", "Xy"): 1})),
        (ValueError, "radius for each of 2", lambda: fdem.neighbor_list("i", positions=three, cutoff=[1.0])),
    ]:
        with pytest.raises(error, match=words):
            call()


@pytest.mark.parametrize("dimensions", [2, 3])
def test_query_pairs_is_that_of_scipy(dimensions):
    from scipy.spatial import cKDTree

    positions, edge = gas(3000, 10, dimensions)
    ours, theirs = fdem.KDTree(positions), cKDTree(positions)
    assert ours.query_pairs(1.0) == theirs.query_pairs(1.0)
    arrays = [tree.query_pairs(1.0, output_type="ndarray") for tree in (ours, theirs)]
    assert arrays[0].dtype == arrays[1].dtype == np.intp
    assert (arrays[0][:, 0] < arrays[0][:, 1]).all()
    assert sorted(arrays[0].tolist()) == sorted(arrays[1].tolist())

    inside = positions % edge
    for boxsize in (edge, [edge, 0, edge][:dimensions]):
        trees = fdem.KDTree(inside, boxsize=boxsize), cKDTree(inside, boxsize=boxsize)
        assert trees[0].query_pairs(1.2) == trees[1].query_pairs(1.2)


def test_touching_pairs_of_a_lattice_are_those_of_scipy():
    from scipy.spatial import cKDTree

    lattice = np.stack(np.meshgrid(*[np.arange(7.0)] * 3), -1).reshape(-1, 3)
    for r in (1.0, 2**0.5, 3**0.5, 2.0):
        assert fdem.KDTree(lattice).query_pairs(r) == cKDTree(lattice).query_pairs(r)


def test_what_query_pairs_refuses():
    tree = fdem.KDTree(np.zeros((2, 2)))
    with pytest.raises(ValueError, match="p must be 2"):
        tree.query_pairs(1.0, p=1)
    with pytest.raises(ValueError, match="no output_type 'list'"):
        tree.query_pairs(1.0, output_type="list")


def test_bonds_are_those_of_freud():
    import freud

    positions, edge = gas(2000, 12, 3)
    positions = (positions - edge / 2).astype(np.float32)
    query = freud.locality.AABBQuery(freud.box.Box.cube(edge), positions)
    theirs = query.query(positions, {"r_max": 1.0, "exclude_ii": True}).toNeighborList()
    ours = fdem.contacts(positions, cutoff=1.0, box=[[-edge / 2, edge / 2]] * 3, periodic=True).neighbor_list()
    assert len(ours) == len(theirs) > 0
    order = np.lexsort((theirs.point_indices, theirs.query_point_indices))
    assert (ours.query_point_indices == theirs.query_point_indices[order]).all()
    assert (ours.point_indices == theirs.point_indices[order]).all()
    assert (ours[:] == theirs[:][order]).all()
    assert (ours.neighbor_counts == theirs.neighbor_counts).all()
    assert (ours.segments == theirs.segments).all()
    assert np.allclose(ours.distances, theirs.distances[order], atol=1e-5)
    assert np.allclose(ours.vectors, theirs.vectors[order], atol=1e-5)
    assert (ours.weights == theirs.weights).all()
    assert (ours.num_points, ours.num_query_points) == (theirs.num_points, theirs.num_query_points)
    assert ours.find_first_index(77) == theirs.find_first_index(77)
    assert np.allclose(np.linalg.norm(ours.vectors, axis=1), ours.distances, atol=1e-6)
    assert "bonds of 2,000 points" in repr(ours)


def test_couples_are_those_of_vesin():
    import vesin

    positions, edge = gas(1500, 12, 3)
    for periodic in (False, True):
        calculator = vesin.NeighborList(cutoff=1.0, full_list=False)
        i, j, shift = calculator.compute(points=positions, box=np.eye(3) * edge, periodic=periodic, quantities="ijS")
        options = {"box": [edge] * 3, "periodic": True} if periodic else {}
        found = fdem.contacts(positions, cutoff=1.0, **options)
        ours = {frozenset([(a, b, *s), (b, a, *(-x for x in s))]) for (a, b), s in zip(found.pairs.tolist(), found.shift.tolist())}
        theirs = {frozenset([(a, b, *s), (b, a, *(-x for x in s))]) for a, b, s in zip(i.tolist(), j.tolist(), shift.tolist())}
        assert ours == theirs and len(ours) == len(found) == len(i)
