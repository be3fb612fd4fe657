"""Python packages that list neighbours, side by side: from arrays to arrays, in one run.

    python bench/python.py [--quick] [--points N ...] [--rounds N] [--write bench/PYTHON.md]

There are two tables for each number of points. Pairs: each package gets the same float64 points, in C order, and must hand over arrays of all pairs at most 1 apart, in
any order. Sorted lists: the points are in a cube that repeats, and the package must return what ASE calls "ijdS", sorted by the first atom: every pair from both sides
with its distance and its shift. The numbers of pairs are compared, and the sums of distances. Packages that are not installed are left out. Rounds go through
all packages in turn, so that other work of the machine disturbs all of them alike; the tables have medians.
"""

import argparse
import importlib.metadata
import inspect
import math
import os
import pathlib
import platform
import statistics
import sys
import time

CUTOFF = 1.0
NEIGHBOURS = 12


def fdem_contacts(points, edge):
    import fdem

    def find(threads):
        found = fdem.contacts(points, cutoff=CUTOFF, threads=threads)
        return found.i, found.j

    return {1: lambda: find(1), "all": lambda: find(None)}


def scipy_tree(points, edge):
    from scipy.spatial import cKDTree

    # Building and search run on one thread in any case.
    return {1: lambda: tuple(cKDTree(points).query_pairs(CUTOFF, output_type="ndarray").T)}


def freud_query(points, edge):
    import freud
    import numpy as np

    # Computes in float32, and lists both directions. Its LinkCell takes a hundred times as long for these points.
    centred = (points - edge / 2).astype(np.float32)
    # A box that is larger than the points by more than the cut-off acts as an open one.
    box = freud.box.Box.cube(edge + 2.1 * CUTOFF)

    def find(threads):
        freud.parallel.set_num_threads(threads)
        options = {"r_max": CUTOFF, "exclude_ii": True}
        bonds = freud.locality.AABBQuery(box, centred).query(centred, options).toNeighborList()
        return bonds.query_point_indices, bonds.point_indices

    return {1: lambda: find(1), "all": lambda: find(0)}


def vesin_list(points, edge):
    import numpy as np
    import vesin

    box = np.eye(3) * (edge + 2 * CUTOFF)

    def find(**threads):
        calculator = vesin.NeighborList(cutoff=CUTOFF, full_list=False, sorted=False, **threads)
        return tuple(calculator.compute(points=points, box=box, periodic=False, quantities="ij"))

    if "n_threads" not in inspect.signature(vesin.NeighborList).parameters:
        return {1: find}
    return {1: lambda: find(n_threads=1), "all": lambda: find(n_threads=os.cpu_count())}


def matscipy_list(points, edge):
    import numpy as np
    from matscipy.neighbours import neighbour_list

    cell = np.eye(3) * (edge + 2 * CUTOFF)
    pbc = np.zeros(3, bool)
    return {1: lambda: tuple(neighbour_list("ij", positions=points, cell=cell, pbc=pbc, cutoff=CUTOFF))}


def neighborlist_rs(points, edge):
    import neighborlist_rs as package

    # This package makes its box itself.
    def find(parallel):
        return tuple(package.build_neighborlists(None, points, CUTOFF, parallel)["edge_index"])

    return {1: lambda: find(False), "all": lambda: find(True)}


def molar(points, edge):
    import numpy as np
    import pymolar

    # Points are added one by one, which is not timed. Computes in float32.
    system, atom = pymolar.System(), pymolar.Atom()
    for point in points.astype(np.float32):
        system.append(atom, point)
    everything = system("all")
    return {"all": lambda: tuple(pymolar.distance_search(CUTOFF, everything)[0].T)}


def fdem_sorted(points, edge):
    import fdem

    cell = [edge, edge, edge]

    def find(threads):
        return fdem.neighbor_list("ijdS", positions=points, cell=cell, pbc=True, cutoff=CUTOFF, threads=threads)

    return {1: lambda: find(1), "all": lambda: find(None)}


def vesin_sorted(points, edge):
    import numpy as np
    import vesin

    box = np.eye(3) * edge

    def find(**threads):
        # As vesin.ase_neighbor_list, which takes no number of threads.
        calculator = vesin.NeighborList(cutoff=CUTOFF, full_list=True, sorted=True, **threads)
        return calculator.compute(points=points, box=box, periodic=True, quantities="ijdS", copy=True)

    if "n_threads" not in inspect.signature(vesin.NeighborList).parameters:
        return {1: find}
    return {1: lambda: find(n_threads=1), "all": lambda: find(n_threads=os.cpu_count())}


def matscipy_sorted(points, edge):
    import numpy as np
    from matscipy.neighbours import neighbour_list

    cell, pbc = np.eye(3) * edge, np.ones(3, bool)
    return {1: lambda: neighbour_list("ijdS", positions=points, cell=cell, pbc=pbc, cutoff=CUTOFF)}


def ase_sorted(points, edge):
    import numpy as np
    from ase.neighborlist import primitive_neighbor_list

    if len(points) > 200_000:
        raise ImportError("it takes minutes for so many points")
    cell, pbc = np.eye(3) * edge, np.ones(3, bool)
    return {1: lambda: primitive_neighbor_list("ijdS", pbc, cell, points, CUTOFF)}


PACKAGES = {
    "fdem": ("fdem-rs", fdem_contacts),
    "SciPy cKDTree": ("scipy", scipy_tree),
    "freud AABBQuery": ("freud-analysis", freud_query),
    "vesin": ("vesin", vesin_list),
    "matscipy": ("matscipy", matscipy_list),
    "neighborlist-rs": ("neighborlist-rs", neighborlist_rs),
    "molar": ("pymolar", molar),
}

SORTED = {
    "fdem": ("fdem-rs", fdem_sorted),
    "vesin": ("vesin", vesin_sorted),
    "matscipy": ("matscipy", matscipy_sorted),
    "ASE": ("ase", ase_sorted),
}

SINGLE = ("freud AABBQuery", "molar")
"""Packages that compute in float32, and may decide otherwise where the distance is within rounding of the cut-off."""

MOST = {"ASE": 20_000}
"""Packages that need too much memory and time for more points: ASE 24 GB and minutes for a million."""


def gas(n, seed):
    """Random points in a cube with NEIGHBOURS neighbours on average, whose coordinates are exact in float32."""
    import numpy as np

    edge = (n * 4 / 3 * math.pi * CUTOFF**3 / NEIGHBOURS) ** (1 / 3)
    return (np.random.default_rng(seed).random((n, 3)) * edge).astype(np.float32).astype(np.float64), edge


def count_of(i, j, n):
    """The number of different pairs: some packages list both directions."""
    import numpy as np

    i, j = np.asarray(i, np.int64), np.asarray(j, np.int64)
    keys = np.sort(np.minimum(i, j) * n + np.maximum(i, j))
    return int((np.diff(keys) > 0).sum()) + min(len(keys), 1)


def pairs_of(found, n):
    """The number of different pairs."""
    return count_of(*found, n)


def entries_of(found, n):
    """The number of entries of a sorted list. Checks the order and the sizes of the columns."""
    import numpy as np

    i, j, distance, shift = found
    assert len(i) == len(j) == len(distance) == len(shift) and (np.diff(i) >= 0).all()
    assert abs(distance.mean() - 0.75 * CUTOFF) < 0.01 * CUTOFF
    return len(i)


def measure(n, rounds, packages, count):
    """Times in seconds by package and threads, the number of pairs of each, and why some are left out."""
    points, edge = gas(n, seed=n)
    runs, missing = {}, {}
    for name, (distribution, prepare) in packages.items():
        if n > MOST.get(name, n):
            missing[name] = f"more than {MOST[name]:,} points"
            continue
        try:
            importlib.metadata.version(distribution)
            for threads, find in prepare(points, edge).items():
                runs[name, threads] = find
        except (ImportError, importlib.metadata.PackageNotFoundError) as error:
            missing[name] = str(error)
    pairs, times = {}, {key: [] for key in runs}
    # The first round is not counted: it loads code and fills caches.
    for turn in range(rounds + 1):
        for key, find in runs.items():
            begin = time.perf_counter()
            found = find()
            end = time.perf_counter()
            if turn > 0:
                times[key].append(end - begin)
            elif key[0] not in pairs:
                pairs[key[0]] = count(found, n)
            del found
    expected = pairs["fdem"]
    for name, count in pairs.items():
        slack = 1e-5 * expected if name in SINGLE else 0
        assert abs(count - expected) <= slack, f"{name} finds {count} pairs, fdem {expected}"
    return {key: statistics.median(seconds) for key, seconds in times.items()}, pairs, missing


def seconds(value):
    return f"{1e3 * value:,.1f}" if value < 1 else f"{1e3 * value:,.0f}"


def processor():
    try:
        lines = pathlib.Path("/proc/cpuinfo").read_text().splitlines()
        return next(line.split(":")[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()


def report(results, rounds):
    versions = []
    for distribution in dict.fromkeys(distribution for distribution, _ in (*PACKAGES.values(), *SORTED.values())):
        try:
            versions.append(f"{distribution} {importlib.metadata.version(distribution)}")
        except importlib.metadata.PackageNotFoundError:
            pass
    load = f", load {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    busy = hasattr(os, "getloadavg") and os.getloadavg()[0] > os.cpu_count() + 1
    lines = [
        "# Python packages side by side",
        "",
        "Written by `python bench/python.py --write bench/PYTHON.md`, which describes the timing. Random points with about 12 neighbours at the cut-off, float64 arrays in, arrays",
        "of pairs out; everything between is timed. *Pairs* are each pair once, or from both sides, in any order; *sorted lists* are what ASE calls \"ijdS\" in a cube that repeats:",
        "each pair from both sides with its distance and its shift, sorted by the first atom. Milliseconds, medians of rounds that go through all packages in turn.",
        "",
        f"{processor()}, {os.cpu_count()} processors{load}; Python {platform.python_version()}; {', '.join(versions)}; {rounds} rounds.",
        "",
    ]
    if busy:
        lines += ["**The machine was busy with other work: only orders of magnitude can be read from this.**", ""]
    for (n, title), (times, pairs, missing) in results.items():
        lines += [f"## {title}: {n:,} points, {pairs['fdem']:,} pairs", ""]
        lines += ["| package | one thread | times fdem | all threads | times fdem |", "|---|---:|---:|---:|---:|"]
        for name in pairs:
            cells = [name + (" (float32)" if name in SINGLE else "")]
            for threads in (1, "all"):
                value = times.get((name, threads))
                # A package that has one thread only stands in both columns.
                shown = value if value is not None else (times.get((name, 1)) if threads == "all" else None)
                if shown is None:
                    cells += ["", ""]
                    continue
                ratio = shown / times["fdem", threads]
                cells += [seconds(shown) + ("" if value is not None else " (one thread)"), f"{ratio:.1f}"]
            lines.append(f"| {' | '.join(cells)} |")
        for name, why in missing.items():
            lines += ["", f"{name} is left out: {why}."]
        lines.append("")
    worst = [
        min(value / times["fdem", threads] for (name, of), value in times.items() if name != "fdem" and (of == threads or (threads == "all" and of == 1)))
        for times, _, _ in results.values()
        for threads in (1, "all")
        if len(times) > 2
    ]
    if worst:
        lines += [f"The fastest other package takes at least {min(worst):.1f} times as long as fdem in every column of every table.", ""]
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="few points, to see that all works")
    parser.add_argument("--points", type=int, nargs="+", default=[100_000, 1_000_000])
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--write", type=pathlib.Path, help="the file for the table, besides standard output")
    arguments = parser.parse_args()
    rounds = 2 if arguments.quick else arguments.rounds
    sizes = [2_000, 10_000] if arguments.quick else arguments.points
    kinds = {"Pairs": (PACKAGES, pairs_of), "Sorted lists": (SORTED, entries_of)}
    text = report({(n, title): measure(n, rounds, *kind) for n in sizes for title, kind in kinds.items()}, rounds)
    print(text)
    if arguments.write:
        arguments.write.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
