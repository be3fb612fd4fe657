"""``KDTree`` against SciPy's: any dimension, norm and box."""

import numpy as np
import pytest
from conftest import gas

import fdem

CASES = [
    # Dimension, box, norm. Coordinates are multiples of 1/16, so that there are ties and sums are exact.
    *[(m, None, p) for m in (1, 2, 3, 4, 7) for p in (1, 2, np.inf)],
    (3, None, 3.5),
    *[(m, 2.0, p) for m in (1, 2, 3, 5) for p in (1, 2, np.inf)],
    (3, [2.0, 0.0, 3.0], 2),
    (2, [0.0, 2.5], 1.5),
]


def trees(m, box, rng, n=300):
    from scipy.spatial import cKDTree

    points = rng.integers(0, 32, (n, m)) / 16
    others = rng.integers(0, 32, (n // 2, m)) / 16
    ours = [fdem.KDTree(each, boxsize=box) for each in (points, others)]
    theirs = [cKDTree(each, boxsize=box) for each in (points, others)]
    # Some of the points that ask are outside.
    return ours, theirs, rng.integers(-40, 80, (60, m)) / 16


@pytest.mark.parametrize(("m", "box", "p"), CASES)
def test_query(m, box, p, rng):
    (ours, _), (theirs, _), at = trees(m, box, rng)
    for k in (1, 4, [1], [2, 5], 400):
        for bound in (np.inf, 1.0):
            distance, index = ours.query(at, k, p=p, distance_upper_bound=bound)
            expected, theirs_index = theirs.query(at, k, p=p, distance_upper_bound=bound)
            assert distance.shape == expected.shape and index.shape == expected.shape
            assert index.dtype == theirs_index.dtype and distance.dtype == expected.dtype
            assert np.allclose(distance, expected, rtol=1e-14, atol=0), (k, bound)
            found = np.isfinite(distance)
            assert (index[~found] == ours.n).all() and (index[found] < ours.n).all()
            assert (found == np.isfinite(expected)).all()
    # The points themselves: ties at the end are those of smaller number.
    k = 6
    distance, index = ours.query(at, k, p=p)
    everything, all_indices = ours.query(at, ours.n, p=p)
    assert (index == all_indices[:, :k]).all() and np.array_equal(distance, everything[:, :k])
    steps = np.diff(everything, axis=1)
    assert (steps >= 0).all()
    # Sums of other powers are rounded, so that two of them may have one root.
    assert p not in (1, 2, np.inf) or (np.diff(all_indices, axis=1)[steps == 0] > 0).all()
    assert (np.sort(all_indices, axis=1) == np.arange(ours.n)).all()


@pytest.mark.parametrize(("m", "box", "p"), CASES)
def test_query_ball_point(m, box, p, rng):
    (ours, _), (theirs, _), at = trees(m, box, rng)
    for r in (0.0, 0.25, 1.0, 3.0, rng.integers(0, 20, len(at)) / 16):
        found, expected = ours.query_ball_point(at, r, p), theirs.query_ball_point(at, r, p, return_sorted=True)
        assert found.shape == expected.shape and found.dtype == object
        assert found.tolist() == expected.tolist()
        counts = ours.query_ball_point(at, r, p, return_length=True)
        assert counts.dtype == np.intp and counts.tolist() == [len(each) for each in expected]
    assert ours.query_ball_point(at[0], 0.5, p) == sorted(theirs.query_ball_point(at[0], 0.5, p))
    assert ours.query_ball_point(at[0], 0.5, p, return_length=True) == theirs.query_ball_point(at[0], 0.5, p, return_length=True)
    assert ours.query_ball_point(at.reshape(3, 20, m), 1.0, p).shape == (3, 20)
    assert ours.query_ball_point(at[0], -1.0, p) == []


@pytest.mark.parametrize(("m", "box", "p"), CASES)
def test_two_trees(m, box, p, rng):
    ours, theirs, _ = trees(m, box, rng)
    r = [-1.0, 0.0, 0.25, 0.25, 0.5, 1.0, 2.0, 9.0]
    for one, two in ((0, 1), (0, 0)):
        expected = theirs[one].count_neighbors(theirs[two], r[1:], p)
        counts = ours[one].count_neighbors(ours[two], r, p)
        assert counts.dtype == expected.dtype and counts.tolist() == [0, *expected.tolist()]
        assert ours[one].count_neighbors(ours[two], r[::-1], p).tolist() == counts.tolist()[::-1]
        bins = ours[one].count_neighbors(ours[two], r[1:], p, cumulative=False)
        assert bins.tolist() == theirs[one].count_neighbors(theirs[two], r[1:], p, cumulative=False).tolist()
        weights = rng.random(ours[one].n), rng.random(ours[two].n)
        for each in (weights, (None, weights[1]), (weights[0], None)):
            weighed = ours[one].count_neighbors(ours[two], r[1:], p, weights=each)
            assert np.allclose(weighed, theirs[one].count_neighbors(theirs[two], r[1:], p, weights=each), rtol=1e-12)
        for limit in (0.0, 0.5):
            for form in ("dict", "ndarray", "coo_matrix", "dok_matrix"):
                ours_found = ours[one].sparse_distance_matrix(ours[two], limit, p, form)
                theirs_found = theirs[one].sparse_distance_matrix(theirs[two], limit, p, form)
                assert type(ours_found) is type(theirs_found), form
                if form == "dict":
                    assert ours_found.keys() == theirs_found.keys()
                    assert all(abs(theirs_found[key] - value) <= 1e-14 for key, value in ours_found.items())
                elif form == "ndarray":
                    assert ours_found.dtype == theirs_found.dtype and len(ours_found) == len(theirs_found)
                    assert (np.diff(ours_found["i"]) >= 0).all()
                else:
                    assert ours_found.shape == theirs_found.shape and ours_found.nnz == theirs_found.nnz
                    assert np.allclose(ours_found.toarray(), theirs_found.toarray(), atol=1e-14)
        balls = theirs[one].query_ball_tree(theirs[two], 0.5, p)
        assert ours[one].query_ball_tree(ours[two], 0.5, p) == [sorted(ball) for ball in balls]
    weights = rng.random(ours[0].n)
    one, two = (trees[0].count_neighbors(trees[0], 0.5, p, weights=weights) for trees in (ours, theirs))
    assert np.isclose(one, two, rtol=1e-12)
    counts = [trees[0].count_neighbors(trees[1], 0.5, p) for trees in (ours, theirs)]
    assert isinstance(counts[0], int) and counts[0] == counts[1]


@pytest.mark.parametrize(("m", "box", "p"), CASES)
def test_query_pairs(m, box, p, rng):
    (ours, _), (theirs, _), _ = trees(m, box, rng)
    for r in (0.0, 0.25, 1.0):
        assert ours.query_pairs(r, p) == theirs.query_pairs(r, p)
        found, expected = (tree.query_pairs(r, p, output_type="ndarray") for tree in (ours, theirs))
        assert found.dtype == expected.dtype and sorted(found.tolist()) == sorted(expected.tolist())
        assert (found[:, 0] < found[:, 1]).all()


@pytest.mark.parametrize("dimensions", [2, 3])
def test_many_points_at_once_and_one_by_one(dimensions):
    """The two ways to answer agree with SciPy to the last neighbour."""
    from scipy.spatial import cKDTree

    positions, edge = gas(3000, 10, dimensions)
    ours, theirs = fdem.KDTree(positions), cKDTree(positions)
    for at in (positions, positions[:40]):
        distance, index = ours.query(at, 8, workers=-1)
        expected = theirs.query(at, 8)
        assert (index == expected[1]).all() and np.allclose(distance, expected[0], rtol=1e-15)
        assert ours.query_ball_point(at, 1.1, workers=2).tolist() == theirs.query_ball_point(at, 1.1, return_sorted=True).tolist()
    inside = positions % edge
    boxes = fdem.KDTree(inside, boxsize=edge), cKDTree(inside, boxsize=edge)
    assert np.allclose(*(tree.query(inside[:500] * 3 - edge, 5)[0] for tree in boxes), rtol=1e-14, atol=1e-13)
    assert boxes[0].query_pairs(1.2) == boxes[1].query_pairs(1.2)


def test_points_in_one_place():
    tree = fdem.KDTree(np.ones((5000, 4)))
    distance, index = tree.query(np.zeros(4), 3, p=1)
    assert distance.tolist() == [4.0] * 3 and index.tolist() == [0, 1, 2]
    assert tree.query_ball_point(np.zeros(4), 2.0, return_length=True) == 5000
    assert tree.count_neighbors(tree, [0.0, 1.0]).tolist() == [5000**2] * 2


def test_shapes_and_scalars(rng):
    from scipy.spatial import KDTree

    points = rng.random((50, 3))
    ours, theirs = fdem.KDTree(points), KDTree(points)
    for x in (points[0], points[:7], points[:8].reshape(2, 4, 3), np.zeros((0, 3))):
        for k in (1, 3, [1], [3, 2]):
            for mine, other in zip(ours.query(x, k), theirs.query(x, k)):
                assert type(mine) is type(other) and np.shape(mine) == np.shape(other)
        mine, other = ours.query_ball_point(x, 0.3), theirs.query_ball_point(x, 0.3)
        assert type(mine) is type(other) and np.shape(mine) == np.shape(other) or isinstance(mine, list)
    assert (ours.maxes == theirs.maxes).all() and (ours.mins == theirs.mins).all() and (ours.n, ours.m) == (theirs.n, theirs.m)
    empty, none = fdem.KDTree(np.zeros((0, 3))), KDTree(np.zeros((0, 3)))
    assert [part.tolist() for part in empty.query(points[0], 2)] == [part.tolist() for part in none.query(points[0], 2)]
    assert empty.query_pairs(1.0) == set() and empty.query_ball_point(points[:2], 1.0).tolist() == [[], []]
    assert "50 points of dimension 3" in repr(ours)


@pytest.mark.parametrize("radius", [2, np.int64(2), np.array(2), np.float32(2)])
def test_a_radius_may_be_a_whole_number(radius, rng):
    points = rng.random((30, 3)) * 4
    expected = sorted(fdem.KDTree(points).query_ball_point([2.0, 2.0, 2.0], 2.0))
    assert len(expected) > 0 and sorted(fdem.KDTree(points).query_ball_point([2.0, 2.0, 2.0], radius)) == expected


def test_what_is_refused(rng):
    from scipy.spatial import cKDTree

    points = rng.random((20, 3))
    makes = [
        ("finite", [[np.nan, 0.0]], None),
        ("shape", np.zeros(3), None),
        ("outside", [[1.0, 0.0]], 1.0),
        ("outside", [[-1.0, 0.0]], [1.0, 0.0]),
        ("boxsize", [[0.5, 0.5]], [1, 2, 3]),
    ]
    for words, data, box in makes:
        with pytest.raises(ValueError):
            cKDTree(data, boxsize=box)
        with pytest.raises(ValueError, match=words):
            fdem.KDTree(data, boxsize=box)
    asks = [
        ("must be finite", lambda tree, _: tree.query([np.inf, 0, 0])),
        ("vectors of length 3", lambda tree, _: tree.query([0.0, 0])),
        ("p-norms", lambda tree, _: tree.query([0.0, 0, 0], p=0.5)),
        ("workers", lambda tree, _: tree.query([0.0, 0, 0], workers=0)),
        ("k must be at least 1", lambda tree, _: tree.query([0.0, 0, 0], k=0)),
        ("non-decreasing", lambda tree, _: tree.count_neighbors(tree, [2.0, 1.0], cumulative=False)),
        ("one-dimensional", lambda tree, _: tree.count_neighbors(tree, [[1.0]])),
        ("different dimensionality", lambda tree, make: tree.count_neighbors(make(np.zeros((2, 2))), 1.0)),
        ("tuple", lambda tree, make: tree.count_neighbors(make(np.zeros((2, 3))), 1.0, weights=np.ones(20))),
        ("weights differ", lambda tree, _: tree.count_neighbors(tree, 1.0, weights=np.ones(3))),
        ("output", lambda tree, _: tree.sparse_distance_matrix(tree, 1.0, output_type="x")),
    ]
    for words, ask in asks:
        with pytest.raises(ValueError):
            ask(cKDTree(points), cKDTree)
        with pytest.raises(ValueError, match=words):
            ask(fdem.KDTree(points), fdem.KDTree)
    with pytest.raises(ValueError, match="different boxes"):
        fdem.KDTree(points).count_neighbors(fdem.KDTree(points, boxsize=2), 1.0)


@pytest.mark.parametrize(("m", "box", "p"), CASES)
def test_single_questions_are_those_of_many(m, box, p, rng):
    """One point of float64 takes a shorter way."""
    (ours, _), (theirs, _), at = trees(m, box, rng)
    for point in at[:20]:
        distance, index = ours.query(point, p=p)
        assert (type(distance), type(index)) == (float, np.intp)
        assert np.isclose(distance, theirs.query(point, p=p)[0], rtol=1e-14, atol=0)
        assert (distance, index) == tuple(each[0] for each in ours.query(point[None], p=p))
        assert ours.query(point, p=p, distance_upper_bound=0.0) == (np.inf, ours.n)
        several = ours.query(point, 3, p=p), ours.query(point[None], 3, p=p)
        assert all(np.array_equal(one, many[0]) for one, many in zip(*several))
        expected = sorted(theirs.query_ball_point(point, 0.75, p))
        assert ours.query_ball_point(point, 0.75, p) == ours.query_ball_point(point.tolist(), 0.75, p) == expected
        assert ours.query_ball_point(point, 0.75, p, return_length=True) == len(expected)
    for wrong in (at[0][:-1], np.append(at[0], 1.0)):
        with pytest.raises(ValueError, match="vectors of length"):
            ours.query_ball_point(wrong, 1.0)
    with pytest.raises(ValueError, match="finite"):
        ours.query_ball_point(np.full(m, np.nan), 1.0)


@pytest.mark.parametrize("dimensions", [2, 3])
@pytest.mark.parametrize("kind", ["heavy-tailed", "clusters", "one place"])
def test_uneven_points(kind, dimensions, rng):
    """Rows of cells do not suit these: a tree answers, with the same result."""
    points = {
        "heavy-tailed": rng.standard_t(1.2, (4000, dimensions)),
        "clusters": rng.random((9, dimensions))[rng.integers(0, 9, 4000)] + rng.normal(0, 1e-3, (4000, dimensions)),
        "one place": np.ones((50, dimensions)),
    }[kind]
    from scipy.spatial import cKDTree

    ours, theirs = fdem.KDTree(points), cKDTree(points)
    assert not ours._is_even() and fdem.KDTree(rng.random((4000, dimensions)))._is_even()
    assert np.allclose(ours.query(points, 5)[0], theirs.query(points, 5)[0], rtol=1e-14, atol=0)
    assert ours.query_ball_point(points[:99], 1e-3).tolist() == theirs.query_ball_point(points[:99], 1e-3, return_sorted=True).tolist()
    assert ours.count_neighbors(ours, [1e-3, 0.1]).tolist() == theirs.count_neighbors(theirs, [1e-3, 0.1]).tolist()


def test_nodes_are_those_of_the_tree(rng):
    tree = fdem.KDTree(rng.random((500, 3)), leafsize=7)
    assert tree.size == len(tree._nodes) > 100 and sorted(tree.indices.tolist()) == list(range(500))
    leaves, waiting = [], [tree.tree]
    while waiting:
        node = waiting.pop()
        if isinstance(node, fdem.KDTree.leafnode):
            assert node.children <= 7
            leaves.append(node)
        else:
            assert isinstance(node, fdem.KDTree.innernode) and node.less is node.lesser
            assert node.less.data_points[:, node.split_dim].max() <= node.split <= node.greater.data_points[:, node.split_dim].min()
            waiting += [node.less, node.greater]
    assert sorted(sum((leaf.idx.tolist() for leaf in leaves), [])) == list(range(500))
    with pytest.raises(ValueError, match="leafsize must be at least 1"):
        fdem.KDTree([[0.0]], leafsize=0)
    with pytest.raises(TypeError, match="complex data"):
        fdem.KDTree([[1j]])
    with pytest.raises(ValueError, match="k must be an integer"):
        tree.query([0.0, 0, 0], None)
