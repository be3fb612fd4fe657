"""``fdem.KDTree`` beside ``scipy.spatial.KDTree``: every call, on even points and on heavy-tailed and clustered ones, in one run by turns.

    python bench/kdtree.py [--points 20000] [--rounds 7] [--dimensions 2 3 5]

Both trees get one thread, the default. A line has the medians of both and their ratio: above 1, fdem is faster. Calls of which SciPy's take several seconds have fewer points.
"""

import argparse
import statistics
import time

import numpy as np


def clouds(n, m, rng):
    """Points of three kinds, scaled so that a point has about ten others within a distance of 1 at the middle distance."""
    even = rng.random((n, m))
    tails = rng.standard_t(1.5, (n, m))
    clusters = rng.random((30, m))[rng.integers(0, 30, n)] + rng.normal(0, 0.003, (n, m))
    from scipy.spatial import KDTree

    for name, points in (("even", even), ("heavy-tailed", tails), ("clusters", clusters)):
        tenth = np.median(KDTree(points).query(points[:: max(1, n // 500)], 11)[0][:, -1])
        yield name, points / tenth


def calls(points, rng):
    """Each call as a function of a tree, its name, and how often it is made in a round."""
    n, m = points.shape
    single = points[rng.integers(0, n, 200)]
    others = points + rng.normal(0, 0.1, points.shape)

    def each(call):
        return lambda tree, _: [call(tree, point) for point in single]

    yield "build", lambda tree, _: type(tree)(points).query(points[0])
    yield "query k=1, many", lambda tree, _: tree.query(others)
    yield "query k=8, many", lambda tree, _: tree.query(points, 8)
    yield "query k=1, single", each(lambda tree, point: tree.query(point))
    yield "query k=8, single", each(lambda tree, point: tree.query(point, 8))
    yield "query_ball_point, many", lambda tree, _: tree.query_ball_point(points, 1.0)
    yield "query_ball_point, single", each(lambda tree, point: tree.query_ball_point(point, 1.0))
    yield "query_ball_point, length", lambda tree, _: tree.query_ball_point(points, 1.0, return_length=True)
    yield "query_ball_tree", lambda tree, other: tree.query_ball_tree(other, 0.8)
    yield "query_pairs, set", lambda tree, _: tree.query_pairs(0.8)
    yield "query_pairs, array", lambda tree, _: tree.query_pairs(0.8, output_type="ndarray")
    yield "count_neighbors, itself", lambda tree, _: tree.count_neighbors(tree, 1.5)
    yield "count_neighbors, two", lambda tree, other: tree.count_neighbors(other, 1.5)
    yield "count_neighbors, 20 radii", lambda tree, other: tree.count_neighbors(other, np.linspace(0.1, 3, 20))
    weights = rng.random(n)
    yield "count_neighbors, weights", lambda tree, other: tree.count_neighbors(other, [0.5, 1.5], weights=(weights, None))
    yield "sparse_distance_matrix", lambda tree, other: tree.sparse_distance_matrix(other, 0.8, output_type="coo_matrix")


def main():
    from scipy.spatial import KDTree

    import fdem

    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--points", type=int, default=20_000)
    arguments.add_argument("--rounds", type=int, default=7)
    arguments.add_argument("--dimensions", type=int, nargs="+", default=[2, 3, 5])
    options = arguments.parse_args()
    rng = np.random.default_rng(7)
    for m in options.dimensions:
        for cloud, points in clouds(options.points, m, rng):
            shifted = points + 0.05
            trees = [(kind(points), kind(shifted)) for kind in (KDTree, fdem.KDTree)]
            for name, call in calls(points, rng):
                times = [[], []]
                # The first round builds what is built on demand.
                for _ in range(options.rounds + 1):
                    for of, (tree, other) in zip(times, trees):
                        start = time.perf_counter()
                        call(tree, other)
                        of.append(time.perf_counter() - start)
                scipy, ours = (statistics.median(of[1:]) * 1e3 for of in times)
                print(f"{m}D {cloud:<13} {name:<26} SciPy {scipy:9.2f} ms  fdem {ours:9.2f} ms  ratio {scipy / ours:6.2f}", flush=True)


if __name__ == "__main__":
    main()
