"""scipy, freud and matscipy as peers: arrays in, arrays of pairs out (README.md).

python python_peers.py scipy|freud|matscipy FILE DIMENSION KIND THREADS
"""

import os
import resource
import sys
import time

library, file, dimension, kind, threads = sys.argv[1:]
# An error rather than the whole machine's memory, for grids of cells that grow with the domain.
resource.setrlimit(resource.RLIMIT_AS, (12 << 30, 12 << 30))
# Before numpy is there.
os.environ["OMP_NUM_THREADS"] = threads

import numpy as np  # noqa: E402



def refuse(why):
    print("error", why, flush=True)
    sys.exit(0)


if kind in ("radii", "boxes"):
    refuse("one distance for all" if kind == "radii" else "points only")
dimension, cutoff, threads = int(dimension), float(kind), int(threads)


def scipy():
    import scipy
    from scipy.spatial import cKDTree

    def detect(points):
        # Split by midpoints, boxes not shrunk: built faster, and fastest in all for points that are spread evenly.
        tree = cKDTree(points, balanced_tree=False, compact_nodes=False)
        return tree.query_pairs(cutoff, output_type="ndarray")

    how = "`cKDTree(balanced_tree=False, compact_nodes=False).query_pairs(output_type=\"ndarray\")`, one thread"
    return scipy.__version__, how, detect, len


def freud():
    import freud

    if dimension == 2:
        refuse("not called in the plane")
    freud.parallel.set_num_threads(threads)

    def detect(points):
        low, high = points.min(axis=0), points.max(axis=0)
        if (high - low).max() > 300.0 * cutoff:
            refuse("f32 does not resolve the cut-off in so wide a domain")
        # It finds pairs in periodic boxes only: one so wide that no image is in reach.
        box = freud.box.Box.cube((high - low).max() + 3.0 * cutoff)
        query = freud.locality.AABBQuery(box, points - (low + high) / 2.0)
        found = query.query(query.points, {"r_max": cutoff, "exclude_ii": True})
        return found.toNeighborList()[:]

    how = "`AABBQuery`, f32, in a wider periodic box, `toNeighborList`: both directions, with distances"
    return freud.__version__, how, detect, lambda found: len(found) // 2


def matscipy():
    from importlib.metadata import version

    from matscipy.neighbours import neighbour_list

    if dimension == 2:
        refuse("3D only")

    def detect(points):
        low, high = points.min(axis=0), points.max(axis=0)
        cell = np.diag(high - low + 2.0 * cutoff)
        return neighbour_list(
            "ij", positions=points - low + cutoff, cutoff=cutoff, cell=cell, pbc=np.zeros(3, dtype=bool)
        )

    how = "`neighbour_list(\"ij\")`: both directions, one thread"
    return version("matscipy"), how, detect, lambda found: len(found[0]) // 2


peers = {"scipy": scipy, "freud": freud, "matscipy": matscipy}
if library not in peers:
    refuse("no such library: " + library)
points = np.fromfile(file, dtype="<f8").reshape(-1, dimension)
version, how, detect, count = peers[library]()
print(f"ready {version}; {how}", flush=True)
found = None
for line in sys.stdin:
    if line != "round\n":
        refuse("not a round: " + line.strip())
    # The arrays of the round before are given back outside the time.
    found = None
    start = time.perf_counter()
    try:
        found = detect(points)
    except Exception as error:  # whatever it is, this search takes no further part
        refuse(str(error).splitlines()[0])
    seconds = time.perf_counter() - start
    print(1e3 * seconds, count(found), flush=True)
