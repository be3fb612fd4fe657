"""Contacts of spheres and points against brute force."""

import numpy as np
import pytest
from conftest import brute_force, brute_force_images, couples, gas, with_shifts
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

import fdem

ENGINES = ["auto", "rows", "multilevel", "nbs", "direct", "cgrid"]


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("dimensions", [2, 3])
def test_every_engine_finds_what_brute_force_finds(engine, dtype, dimensions):
    positions = gas(700, 9, dimensions)[0].astype(dtype)
    found = fdem.contacts(positions, cutoff=1.0, engine=engine)
    assert couples(found) == brute_force(positions, dtype(1))
    assert found.pairs.dtype == np.uint32 and found.distance.dtype == dtype
    assert (found.i < found.j).all()


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_radii_and_tolerance(dtype, rng):
    positions = (rng.random((500, 3)) * 12).astype(dtype)
    radii = rng.uniform(0.1, 1.1, 500).astype(dtype)
    reach = radii[:, None] + radii[None]
    assert couples(fdem.contacts(positions, radii)) == brute_force(positions, reach)
    found = fdem.contacts(positions, radii, tolerance=0.25)
    assert couples(found) == brute_force(positions, reach + dtype(0.25))
    assert found.overlap.min() < 0


def test_one_radius_is_that_of_all(rng):
    positions = rng.random((300, 2)) * 10
    one = fdem.contacts(positions, radii=0.4).sorted()
    each = fdem.contacts(positions, radii=np.full(300, 0.4)).sorted()
    assert (one.pairs == each.pairs).all() and len(one) > 0
    assert np.allclose(one.overlap, each.overlap)


def test_groups_form_no_couples_within(rng):
    positions, groups = rng.random((400, 3)) * 6, rng.integers(-3, 40, 400)
    found = fdem.contacts(positions, cutoff=1.0, groups=groups)
    assert couples(found) == brute_force(positions, 1.0, groups)
    unsigned = fdem.contacts(positions, cutoff=1.0, groups=(groups + 3).astype(np.uint32))
    assert (found.pairs == unsigned.pairs).all()


def test_distance_overlap_and_vector(rng):
    positions, radii = rng.random((300, 3)) * 8, rng.uniform(0.3, 0.9, 300)
    found = fdem.contacts(positions, radii)
    apart = positions[found.j] - positions[found.i]
    assert np.allclose(found.distance, np.linalg.norm(apart, axis=1), rtol=1e-15)
    assert np.allclose(found.overlap, radii[found.i] + radii[found.j] - found.distance, rtol=0, atol=1e-15)
    assert (found.vector == apart).all()
    assert found.distance is found.distance, "computed once"
    assert not found.shift.any() and found.shift.shape == (len(found), 3)


def test_the_result_does_not_depend_on_threads():
    positions = gas(30_000, 12, 3)[0]
    one = fdem.contacts(positions, cutoff=1.0, threads=1)
    for threads in (2, 3, None):
        other = fdem.contacts(positions, cutoff=1.0, threads=threads)
        assert np.array_equal(one.pairs, other.pairs)
        assert np.array_equal(one.distance, other.distance)


def test_coordination_rows_and_sorted(rng):
    positions = rng.random((250, 2)) * 12
    found = fdem.contacts(positions, cutoff=1.0)
    counts = np.bincount(found.pairs.ravel(), minlength=250)
    assert (found.coordination == counts).all()
    ordered = found.sorted()
    assert ordered.pairs.tolist() == sorted(found.pairs.tolist())

    rows = found.csr()
    assert (np.diff(rows.indptr) == counts).all()
    for element in range(250):
        stretch = slice(*rows.indptr[element : element + 2])
        partners = [int(a + b - element) for a, b in found.pairs[(found.pairs == element).any(axis=1)].astype(int)]
        assert rows.indices[stretch].tolist() == sorted(partners)
        assert (found.pairs[rows.couples[stretch]].sum(axis=1) - element == rows.indices[stretch]).all()
    half = found.csr(full=False)
    assert len(half.indices) == len(found)
    assert np.repeat(np.arange(250), np.diff(half.indptr)).tolist() == ordered.i.tolist()
    assert half.indices.tolist() == ordered.j.tolist()


@pytest.mark.parametrize("dimensions", [2, 3])
@pytest.mark.parametrize("edge", [0.7, 2.0, 5.0])
def test_boxes_that_repeat_also_small_ones(dimensions, edge, rng):
    n = 12
    edges = np.eye(dimensions) * edge
    edges[1, 0] = 0.3 * edge
    positions = (rng.random((n, dimensions)) * 3 - 1) @ edges
    radii = rng.uniform(0.2, 0.6, n)
    for periodic in (True, [True] + [False] * (dimensions - 1)):
        repeats = np.broadcast_to(periodic, dimensions).tolist()
        found = fdem.contacts(positions, radii, box=edges if dimensions == 3 else fdem.Box(edges), periodic=periodic)
        assert with_shifts(found) == brute_force_images(positions, radii, edges, repeats, 9)
        assert len(with_shifts(found)) == len(found)
        apart = positions[found.j] + found.shift @ edges - positions[found.i]
        assert np.allclose(found.vector, apart)
        assert np.allclose(found.distance, np.linalg.norm(apart, axis=1))
        assert np.allclose(found.overlap, radii[found.i] + radii[found.j] - found.distance)
        assert found.verify(n) == n
        ordered = found.sorted()
        keys = [(*pair, *shift) for pair, shift in zip(ordered.pairs.tolist(), ordered.shift.tolist())]
        assert keys == sorted(keys) and set(keys) == with_shifts(found)
        # A contact of an element with its own image has both ends on this element.
        counts = np.zeros(n, int)
        np.add.at(counts, found.i, 1)
        np.add.at(counts, found.j, 1)
        assert (found.coordination == counts).all()


@pytest.mark.parametrize("engine", ["auto", "rows", "nbs", "direct"])
def test_engines_agree_in_a_large_box_that_repeats(engine):
    positions, edge = gas(3000, 10, 3)
    found = fdem.contacts(positions, cutoff=1.0, box=[edge] * 3, periodic=True, engine=engine)
    reference = fdem.contacts(positions + edge * np.array([2, -3, 0]), cutoff=1.0, box=[edge] * 3, periodic=True)
    assert couples(found) == couples(reference)
    assert found.verify(200) == 200
    assert found._shifts.any(axis=1).all(), "only the last ones have shifts, and these all"


def test_the_ways_to_say_a_box():
    positions = np.array([[0.1, 0.5], [3.9, 0.5]])
    edges = [[4, 0], [0, 2]]
    for box in ([4, 2], [[0, 4], [0, 2]], edges, fdem.Box(edges), fdem.Box.from_bounds([0, 0], [4, 2])):
        found = fdem.contacts(positions, cutoff=0.5, box=box, periodic=True)
        assert with_shifts(found) == {(0, 1, -1, 0)}, box
    bounds = fdem.contacts(positions - 7, cutoff=0.5, box=fdem.Box.from_bounds([-7, -7], [-3, -5]), periodic=[True, False])
    assert len(bounds) == 1
    with pytest.raises(ValueError, match="edges or bounds"):
        fdem.contacts(positions, cutoff=0.5, box=[[1, 5], [-1, 3]], periodic=True)


def test_boxes_touch_at_faces(rng):
    lower = rng.integers(0, 30, (300, 3)).astype(float)
    upper = lower + rng.integers(0, 4, (300, 3))
    found = fdem.boxes(lower, upper)
    i, j = np.triu_indices(300, 1)
    touch = ((lower[i] <= upper[j]) & (lower[j] <= upper[i])).all(axis=1)
    assert couples(found) == set(zip(i[touch].tolist(), j[touch].tolist()))
    assert (found.distance == 0).all()
    common = np.minimum(upper[found.i], upper[found.j]) - np.maximum(lower[found.i], lower[found.j])
    assert (found.overlap == common.min(axis=1)).all()
    apart = fdem.boxes([[0, 0], [2, 3]], [[1, 1], [4, 4]], tolerance=2.0)
    assert apart.distance.tolist() == [5**0.5] and apart.overlap.tolist() == [-2.0]
    with pytest.raises(TypeError, match="no centres"):
        found.vector  # noqa: B018


def test_boxes_in_a_box_that_repeats(rng):
    lower = rng.random((60, 2)) * 9 - 3
    upper = lower + rng.random((60, 2)) * 1.5
    found = fdem.boxes(lower, upper, box=[4, 5], periodic=True)
    assert found.verify(60) == 60
    # Some overlap through a face of the box.
    assert len(found._shifts) > 0
    assert (found.distance == 0).all() and (found.overlap >= 0).all()


def test_a_wrong_list_is_found_out():
    positions, edge = gas(500, 8, 3)
    for options in ({}, {"box": [edge] * 3, "periodic": True}):
        found = fdem.contacts(positions, cutoff=1.0, **options)
        for pairs in (found.pairs[1:], np.concatenate([found.pairs, found.pairs[-1:]])):
            with pytest.raises(RuntimeError, match="wrong"):
                found._with(np.ascontiguousarray(pairs), found._shifts).verify(500)
        far = found.pairs.copy()
        far[0] = [0, int(np.linalg.norm(positions - positions[0], axis=1).argmax())]
        with pytest.raises(RuntimeError, match="wrong"):
            found._with(far, found._shifts).verify(500)


@settings(max_examples=150, deadline=None)
@given(
    arrays.arrays(
        st.sampled_from([np.float32, np.float64]),
        st.tuples(st.integers(0, 40), st.integers(2, 3)),
        # Multiples of 1/8: differences and squares are exact, so rounding decides nothing.
        elements=st.integers(-40, 40).map(lambda k: k / 8),
    ),
    st.integers(0, 24).map(lambda k: k / 8),
)
def test_any_points_at_any_distance(positions, cutoff):
    found = fdem.contacts(positions, cutoff=cutoff)
    assert couples(found) == brute_force(positions, positions.dtype.type(cutoff))
    assert found.verify(len(positions)) == len(positions)


def test_no_elements_and_one():
    for n in (0, 1):
        for dimensions in (2, 3):
            found = fdem.contacts(np.zeros((n, dimensions)), cutoff=1.0)
            assert len(found) == 0 and found.pairs.shape == (0, 2) and found.shift.shape == (0, dimensions)
            assert found.distance.shape == (0,) and found.coordination.tolist() == [0] * n
            assert found.csr().indptr.tolist() == [0] * (n + 1)
            assert found.verify() == n and "couples" in repr(found)
            assert len(found.neighbor_list()) == 0


def test_what_is_shown():
    positions, edge = gas(600, 6, 3)
    assert repr(fdem.contacts(positions, radii=0.5)).startswith("<fdem.Contacts: ")
    assert "of 1 disc, mean" in repr(fdem.contacts([[0.0, 0.0]], radii=1.0))
    found = fdem.contacts(positions, cutoff=1, box=[edge] * 3, periodic=True)
    assert "600 points within 1 in a box that repeats" in repr(found)
    assert "<table>" in found._repr_html_() and "600" in found._repr_html_()
    explained = found.explain()
    assert explained.startswith("engine") and "images" in explained
    assert fdem.contacts(positions, cutoff=1, engine="nbs").explain().splitlines()[0].split()[1].startswith("nbs")
