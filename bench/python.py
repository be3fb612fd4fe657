"""Python packages that list neighbours, side by side: from arrays to arrays, in one run.

    python bench/python.py [--quick] [--write bench/PYTHON.md]

Each package gets the same float64 points, in C order, and must hand over an array (or two) of all pairs at most 1 apart, each once. What is not installed is left out. Rounds go
through all packages in turn, so that what disturbs the machine disturbs all; the table has medians.
"""

import argparse
import importlib.metadata
import math
import os
import pathlib
import platform
import statistics
import subprocess
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

    # Building and search run on one thread, whatever there is.
    return {1: lambda: tuple(cKDTree(points).query_pairs(CUTOFF, output_type="ndarray").T)}


def freud_query(points, edge):
    import freud
    import numpy as np

    # Computes in float32, lists both directions and leaves it to its user to drop one.
    centred = (points - edge / 2).astype(np.float32)
    # An open box is made of one that is larger than the points by more than the cut-off.
    box = freud.box.Box.cube(edge + 2.1 * CUTOFF)

    def find(threads):
        freud.parallel.set_num_threads(threads)
        options = {"r_max": CUTOFF, "exclude_ii": True}
        bonds = freud.locality.AABBQuery(box, centred).query(centred, options).toNeighborList()
        return bonds.query_point_indices, bonds.point_indices

    return {1: lambda: find(1), "all": lambda: find(0)}


def freud_cells(points, edge):
    import freud
    import numpy as np

    centred = (points - edge / 2).astype(np.float32)
    box = freud.box.Box.cube(edge + 2.1 * CUTOFF)

    def find(threads):
        freud.parallel.set_num_threads(threads)
        options = {"r_max": CUTOFF, "exclude_ii": True}
        bonds = freud.locality.LinkCell(box, centred, CUTOFF).query(centred, options).toNeighborList()
        return bonds.query_point_indices, bonds.point_indices

    return {1: lambda: find(1), "all": lambda: find(0)}


def vesin_list(points, edge):
    import numpy as np
    import vesin

    calculator = vesin.NeighborList(cutoff=CUTOFF, full_list=False, sorted=False)
    box = np.eye(3) * (edge + 2 * CUTOFF)
    return {1: lambda: tuple(calculator.compute(points=points, box=box, periodic=False, quantities="ij"))}


def matscipy_list(points, edge):
    import numpy as np
    from matscipy.neighbours import neighbour_list

    cell = np.eye(3) * (edge + 2 * CUTOFF)
    pbc = np.zeros(3, bool)
    return {1: lambda: tuple(neighbour_list("ij", positions=points, cell=cell, pbc=pbc, cutoff=CUTOFF))}


def neighborlist_rs(points, edge):
    import neighborlist_rs
    import numpy as np

    cell = np.eye(3) * (edge + 2 * CUTOFF)

    def find(threads):
        neighborlist_rs.set_num_threads(threads)
        found = neighborlist_rs.build_from_arrays(points, cutoff=CUTOFF)
        return found["local"]["edge_i"], found["local"]["edge_j"]

    return {"all": lambda: find(0)}


PACKAGES = {
    "fdem": ("fdem", fdem_contacts),
    "SciPy cKDTree": ("scipy", scipy_tree),
    "freud AABBQuery": ("freud-analysis", freud_query),
    "freud LinkCell": ("freud-analysis", freud_cells),
    "vesin": ("vesin", vesin_list),
    "matscipy": ("matscipy", matscipy_list),
    "neighborlist-rs": ("neighborlist-rs", neighborlist_rs),
}
