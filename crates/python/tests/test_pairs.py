"""Cut-offs by pairs of types."""

import pickle

import numpy as np
import pytest

import fdem

CUTOFFS = {("H", "C"): 1.1, ("C", "C"): 1.6, ("O", "H"): 1.25}


@pytest.mark.parametrize("pbc", [False, True, (True, False, True)])
def test_the_couples_are_those_of_ase(pbc, rng):
    ase = pytest.importorskip("ase")
    neighborlist = pytest.importorskip("ase.neighborlist")
    cell = np.array([[9.0, 0, 0], [2, 8, 0], [-1, 3, 10]])
    symbols = rng.choice(["H", "C", "O", "N"], 900)
    atoms = ase.Atoms(symbols, positions=rng.random((900, 3)) @ cell, cell=cell, pbc=pbc)
    i, j, shift = neighborlist.neighbor_list("ijS", atoms, CUTOFFS)
    once = (i < j) | ((i == j) & (shift[:, 0] * 100 + shift[:, 1] * 10 + shift[:, 2] > 0))
    of_ase = sorted(zip(i[once].tolist(), j[once].tolist(), map(tuple, shift[once].tolist())))
    repeats = np.broadcast_to(pbc, 3)
    box = {"box": cell, "periodic": repeats.tolist()} if repeats.any() else {}
    found = fdem.contacts(atoms.positions, cutoff=CUTOFFS, types=symbols, **box)
    assert len(of_ase) > 1000
    assert sorted(zip(found.i.tolist(), found.j.tolist(), map(tuple, found.shift.tolist()))) == of_ase
    assert found.verify(200) == 200
    numbers = fdem.contacts(atoms.positions, cutoff={(1, 6): 1.1, (6, 6): 1.6, (8, 1): 1.25}, types=atoms.numbers, **box)
    assert sorted(map(tuple, numbers.pairs.tolist())) == sorted(map(tuple, found.pairs.tolist()))


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_a_pair_at_its_cutoff_touches_and_the_overlap_is_from_it(dtype):
    positions = np.array([[0, 0], [1.25, 0], [0, 1.5], [0, -1], [0, -2.5]], dtype)
    types = ["C", "H", "C", "H", "H"]
    found = fdem.contacts(positions, cutoff={("H", "C"): 1.25, ("C", "C"): 1.5}, types=types).sorted()
    assert found.pairs.tolist() == [[0, 1], [0, 2], [0, 3]]
    assert found.overlap.tolist() == [0.0, 0.0, 0.25]
    assert found.verify() == 5
    assert found.analyse().overlaps.overlaps.max == 0.25
    copy = pickle.loads(pickle.dumps(found))
    assert copy.overlap.tolist() == found.overlap.tolist() and copy.verify() == 5
    assert "cut-offs up to 1.5" in repr(found)
    wider = fdem.contacts(positions, cutoff={("H", "C"): 1.25, ("C", "C"): 1.5}, types=types, tolerance=1.25, groups=[0, 0, 1, 2, 3])
    assert sorted(map(tuple, wider.pairs.tolist())) == [(0, 2), (0, 3), (0, 4), (1, 2), (2, 3)]
    with pytest.raises(RuntimeError, match="not listed"):
        found._with(found.pairs[:2], found._shifts).verify()


def test_pairs_that_cannot_be_used_are_refused():
    positions = [[0.0, 0], [1, 0]]
    with pytest.raises(ValueError, match=r"no element has the type 'O'. The types are 'C', 'H'"):
        fdem.contacts(positions, cutoff={("H", "O"): 1.0}, types=["H", "C"])
    with pytest.raises(ValueError, match="in the other order"):
        fdem.contacts(positions, cutoff={("H", "C"): 1.0, ("C", "H"): 2.0}, types=["H", "C"])
    with pytest.raises(TypeError, match="needs types"):
        fdem.contacts(positions, cutoff={("H", "C"): 1.0})
    with pytest.raises(TypeError, match="types are for a cutoff by pairs"):
        fdem.contacts(positions, cutoff=1.0, types=["H", "C"])
    with pytest.raises(TypeError, match="one of the two"):
        fdem.contacts(positions, radii=1.0, cutoff={("H", "C"): 1.0}, types=["H", "C"])
    with pytest.raises(ValueError, match="one entry for each of 2"):
        fdem.contacts(positions, cutoff={("H", "C"): 1.0}, types=["H"])
    with pytest.raises(ValueError, match="finite and not negative"):
        fdem.contacts(positions, cutoff={("H", "C"): -1.0}, types=["H", "C"])
    with pytest.raises(ValueError, match="pair of types"):
        fdem.contacts(positions, cutoff={"HC": 1.0}, types=["H", "C"])
    assert len(fdem.contacts(np.zeros((0, 3)), cutoff={("H", "C"): 1.0}, types=[])) == 0
