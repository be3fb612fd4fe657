"""Functions that replace those of other packages, compared with these."""

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
    # Some atoms are outside of the cell.
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
    assert [column.dtype for column in found.values()] == [column.dtype for column in (i, j, d, D, S)]
    # As ASE sorts, by the first atom; and then by the second, and the shift.
    assert (np.diff(found["i"]) >= 0).all()
    listed = list(zip(found["i"].tolist(), found["j"].tolist(), map(tuple, found["S"].tolist())))
    assert listed == sorted(listed)
    order, mine = (np.lexsort((*np.asarray(s).T, b, a)) for a, b, s in [(i, j, S), (found["i"], found["j"], found["S"])])
    assert np.allclose(found["d"][mine], d[order], rtol=1e-14) and np.allclose(found["D"][mine], D[order], atol=1e-13)
    expected = atoms.positions[found["j"]] - atoms.positions[found["i"]] + found["S"] @ atoms.cell.array
    assert np.allclose(found["D"], expected)


def test_neighbor_list_with_self_interaction(rng):
    from ase.neighborlist import neighbor_list

    atoms = atoms_in("cube", 30, rng)
    ours, theirs = (f("ijS", atoms, 1.5, self_interaction=True) for f in (fdem.neighbor_list, neighbor_list))
    assert rows(*ours) == rows(*theirs)
    listed = list(zip(ours[0].tolist(), ours[1].tolist(), map(tuple, ours[2].tolist())))
    assert listed == sorted(listed)
    only = fdem.neighbor_list("d", atoms, 1.5)
    assert isinstance(only, np.ndarray) and only.ndim == 1
    assert (fdem.neighbor_list("d", atoms, 1.5, False, 1e6) == only).all(), "max_nbins, as ASE has it"
    assert (fdem.neighbor_list("SS", atoms, 1.5)[1] == fdem.neighbor_list("S", atoms, 1.5)).all()


def test_self_interaction_of_pairs_that_a_dict_lacks(rng):
    from ase.neighborlist import neighbor_list

    atoms = atoms_in("cube", 30, rng)
    cutoff = {("H", "O"): 1.9, ("Si", "Si"): 1.5}
    ours, theirs = (f("ijS", atoms, cutoff, self_interaction=True) for f in (fdem.neighbor_list, neighbor_list))
    assert rows(*ours) == rows(*theirs) and (ours[0] == ours[1]).any()


def test_long_neighbor_lists_do_not_depend_on_threads(rng):
    """Enough atoms and pairs for several tasks of each kind."""
    from ase import Atoms

    n = 40_000
    edges = np.eye(3) * (n / 3) ** (1 / 3) + np.array([[0, 0, 0], [4, 0, 0], [-3, 2, 0]])
    atoms = Atoms("Cu" * n, (rng.random((n, 3)) * 1.2 - 0.1) @ edges, cell=edges, pbc=True)
    expected = fdem.neighbor_list("ijdDS", atoms, 1.1, threads=1)
    for threads in (2, 3, None):
        for column, other in zip(expected, fdem.neighbor_list("ijdDS", atoms, 1.1, threads=threads)):
            assert np.array_equal(column, other)
    i, j, d, D, S = expected
    assert len(i) > 2 * 2**18, "more than one task deals out"
    assert (S.any(axis=1).sum()) > 0
    order = np.lexsort((*S.T[::-1], j, i))
    assert (order == np.arange(len(i))).all()
    assert np.allclose(D, atoms.positions[j] - atoms.positions[i] + S @ edges, atol=1e-12) and (d < 1.1).all()
    # From both sides.
    back = np.lexsort((*-S.T[::-1], i, j))
    assert (j[back] == i).all() and (i[back] == j).all() and (S[back] == -S).all() and (d[back] == d).all()
    found = fdem.contacts(atoms.positions, cutoff=1.1, box=edges, periodic=True)
    assert 2 * len(found) == len(i)


def test_neighbor_list_of_atoms_with_few_and_with_hundreds_of_neighbours(rng):
    """Short rows and long ones are sorted in two ways; distances travel alone, or as vectors."""
    positions = np.concatenate([rng.random((150, 3)), rng.random((150, 3)) * 12])
    i, j, d = fdem.neighbor_list("ijd", positions=positions, cutoff=1.5)
    distances = np.linalg.norm(positions[:, None] - positions, axis=2)
    expected = np.argwhere((distances < 1.5) & ~np.eye(len(positions), dtype=bool))
    assert np.array_equal(np.stack([i, j], axis=1), expected)
    of_each = np.bincount(i, minlength=len(positions))
    assert of_each.max() > 100 and 0 < np.count_nonzero(of_each < 64) < len(positions)
    assert np.allclose(d, distances[i, j], rtol=1e-14)
    vectors, again = fdem.neighbor_list("Dd", positions=positions, cutoff=1.5)
    assert np.array_equal(vectors, positions[j] - positions[i]) and np.array_equal(d, again)


def test_neighbor_list_of_no_atoms_and_of_no_distance():
    for n in (0, 1, 3):
        i, S = fdem.neighbor_list("iS", positions=np.zeros((n, 3)), cutoff=0.0)
        assert i.shape == (0,) and S.shape == (0, 3)
        i, j = fdem.neighbor_list("ij", positions=np.zeros((n, 3)), cutoff=0.0, self_interaction=True)
        assert i.tolist() == j.tolist() == list(range(n))


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
        (TypeError, "atoms must have positions.*int has not", lambda: fdem.neighbor_list("i", 3, 1.0)),
        (ValueError, r"pbc must be .* shape \(2,\)", lambda: fdem.neighbor_list("i", positions=three, cutoff=1.0, pbc=[True, False])),
        (ValueError, "for a pair of elements", lambda: fdem.neighbor_list("i", positions=three, numbers=[1, 1], cutoff={("H",): 1})),
        (ValueError, "symbol or an atomic number", lambda: fdem.neighbor_list("i", positions=three, numbers=[1, 1], cutoff={("H", 1.5): 1})),
    ]:
        with pytest.raises(error, match=words):
            call()


def test_touching_pairs_of_a_lattice_are_those_of_scipy():
    from scipy.spatial import cKDTree

    lattice = np.stack(np.meshgrid(*[np.arange(7.0)] * 3), -1).reshape(-1, 3)
    for r in (1.0, 2**0.5, 3**0.5, 2.0):
        assert fdem.KDTree(lattice).query_pairs(r) == cKDTree(lattice).query_pairs(r)


def test_what_query_pairs_refuses():
    tree = fdem.KDTree(np.zeros((2, 2)))
    with pytest.raises(ValueError, match="no output_type 'list'"):
        tree.query_pairs(1.0, output_type="list")
    for p in (1.0, 2.0):
        with pytest.raises(ValueError, match="negative|cut-off"):
            tree.query_pairs(-1.0, p)


def test_bonds_are_those_of_freud():
    import freud

    positions, edge = gas(2000, 12, 3)
    positions = (positions - edge / 2).astype(np.float32)
    query = freud.locality.AABBQuery(freud.box.Box.cube(edge), positions)
    theirs = query.query(positions, {"r_max": 1.0, "exclude_ii": True}).toNeighborList()
    ours = fdem.contacts(positions, cutoff=1.0, box=[[-edge / 2, edge / 2]] * 3, periodic=True).neighbor_list()
    assert len(ours) == len(theirs) > 0
    for name in ("query_point_indices", "point_indices", "segments", "neighbor_counts", "distances", "vectors", "weights"):
        assert getattr(ours, name).dtype == getattr(theirs, name).dtype, name
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


@pytest.mark.parametrize("dimensions", [2, 3])
def test_a_box_of_freud_is_a_box(dimensions, rng):
    freud = pytest.importorskip("freud")
    lengths = {"Lx": 6.0, "Ly": 5.0, "Lz": 7.0, "xy": 0.3, "xz": -0.2, "yz": 0.4}
    box = freud.box.Box(**lengths) if dimensions == 3 else freud.box.Box(Lx=6.0, Ly=5.0, xy=0.3, is2D=True)
    positions = box.wrap(np.pad((rng.random((80, dimensions)) - 0.5) * 6, ((0, 0), (0, 3 - dimensions))))
    query = freud.locality.AABBQuery(box, positions).query(positions, {"r_max": 1.4, "exclude_ii": True}).toNeighborList()
    found = fdem.contacts(positions[:, :dimensions].astype(float), cutoff=1.4, box=box).neighbor_list()
    order = np.lexsort((query.point_indices, query.query_point_indices))
    assert found[:].tolist() == query[:][order].tolist() and len(found) > 50
    assert np.isclose(np.sort(found.distances), np.sort(query.distances), atol=1e-5).all()
    box.periodic = [True, False, False]
    repeats = [True] + [False] * (dimensions - 1)
    with_box, said = (fdem.contacts(positions[:, :dimensions], cutoff=1.4, box=box, **more) for more in ({}, {"periodic": repeats}))
    assert (with_box.shift == said.shift).all() and len(with_box) == len(said) > 0 and not with_box.shift[:, 1:].any()
    with pytest.raises(ValueError, match="the box of freud has"):
        fdem.contacts(np.zeros((2, 5 - dimensions)), cutoff=1.0, box=box)


@pytest.mark.parametrize("scaled", [False, True])
@pytest.mark.parametrize("bothways", [False, True])
def test_a_list_that_is_kept_is_that_of_ase(scaled, bothways, rng):
    from ase import neighborlist

    edges = np.array([[5.0, 0, 0], [1, 4, 0], [0, -1, 6]])
    fractions = rng.random((40, 3))
    options = {"skin": 0.2, "bothways": bothways, "sorted": True, "use_scaled_positions": scaled}
    lists = [kind(np.full(40, 0.7), **options) for kind in (fdem.NewPrimitiveNeighborList, neighborlist.NewPrimitiveNeighborList)]
    for moved in (0.0, 0.01, 0.09):
        at = fractions + moved if scaled else (fractions + moved) @ edges
        updated = [each.update(np.array([True, True, False]), edges, at) for each in lists]
        assert updated[0] == updated[1]
        for atom in range(40):
            pairs = [sorted(zip(each.get_neighbors(atom)[0].tolist(), each.get_neighbors(atom)[1].tolist())) for each in lists]
            assert pairs[0] == pairs[1]
    assert lists[0].nupdates == lists[1].nupdates
