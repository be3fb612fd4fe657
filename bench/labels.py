"""Contacts in a labelled volume: `fdem contacts --labels` against numpy.

    python3 bench/labels.py make VOLUME.npy [EDGE [GRAINS [DTYPE]]]   a cube of Voronoi grains around jittered sites; 512, 20,000, u2; from a seed
    python3 bench/labels.py compare VOLUME.npy FDEM           FDEM: the program; both find all contacts, and the lists must be equal
    python3 bench/labels.py peers VOLUME.npy FDEM             the pairs of `spam` and of the region adjacency graph of scikit-image, if they are
                                                              installed; these take minutes for more than some million voxels

numpy compares shifted arrays, packs each pair of labels into one number, and counts these with `numpy.unique`. It is timed for the pairs and their
faces alone; then centroids and normals are worked out too, and compared. Times are those of the processor, of the user and the system, for other
programs may be running; the least of several runs.
"""

import itertools
import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np


def make(path, edge=512, grains=20_000, dtype="u2"):
    """A site in each cell of a grid, anywhere within it; a voxel belongs to the nearest site of the 27 cells around it."""
    per_axis = next(n for n in range(1, edge) if n**3 >= grains)
    # At least as many cells as grains; layers along z may be thicker than wide.
    shape = np.array([-(-grains // per_axis**2), per_axis, per_axis])
    cell = edge / shape
    random = np.random.default_rng(1)
    sites = (np.indices(shape).reshape(3, -1).T + random.random((shape.prod(), 3))) * cell
    sites = sites.reshape(*shape, 3)
    # Numbers beyond the range of the type start again from 1: two grains far from each other become one body.
    numbers = (np.arange(shape.prod()) % np.iinfo(dtype).max + 1).astype(dtype).reshape(shape)
    out = np.lib.format.open_memmap(path, "w+", dtype, (edge,) * 3)
    # The voxels of each cell, of which the same sites are near.
    inside = [np.searchsorted((np.arange(edge) + 0.5) // size, np.arange(n + 1)) for n, size in zip(shape, cell)]
    for z in range(shape[0]):
        layer = np.zeros((inside[0][z + 1] - inside[0][z], edge, edge), dtype)
        for y, x in np.ndindex(*shape[1:]):
            voxels = [np.arange(ends[at], ends[at + 1]) for ends, at in zip(inside, (z, y, x))]
            number = np.zeros([len(axis) for axis in voxels], dtype)
            nearest = np.full(number.shape, np.inf)
            around = [range(max(at - 1, 0), min(at + 2, n)) for at, n in zip((z, y, x), shape)]
            for k, j, i in itertools.product(*around):
                dz, dy, dx = ((site - axis - 0.5) ** 2 for site, axis in zip(sites[k, j, i], voxels))
                distance = (dz[:, None] + dy)[..., None] + dx
                closer = distance < nearest
                np.copyto(nearest, distance, where=closer)
                np.copyto(number, numbers[k, j, i], where=closer)
            layer[:, voxels[1][:, None], voxels[2]] = number
        out[inside[0][z] : inside[0][z + 1]] = layer
    out.flush()
    bodies = len(np.unique(numbers))
    print(f"{path}: {out.shape} {dtype}, {shape.prod()} grains, {bodies} bodies, {Path(path).stat().st_size / 1e6:.0f} MB")


def neighbours(labels, axis):
    """The two labels of each face across an axis that two bodies share, and where it is."""
    before = [slice(None)] * 3
    behind = [slice(None)] * 3
    before[axis], behind[axis] = slice(None, -1), slice(1, None)
    a, b = labels[tuple(before)], labels[tuple(behind)]
    faces = (a != b) & (a != 0) & (b != 0)
    return a[faces], b[faces], faces


def pack(a, b):
    return np.minimum(a, b).astype(np.int64) << 32 | np.maximum(a, b)


def counts(labels):
    return np.unique(np.concatenate([pack(*neighbours(labels, axis)[:2]) for axis in range(3)]), return_counts=True)


def means(labels, pairs):
    centres, normals = np.zeros((2, 3, len(pairs)))
    for axis in range(3):
        a, b, faces = neighbours(labels, axis)
        at = np.searchsorted(pairs, pack(a, b))
        normals[axis] = np.bincount(at, np.where(a < b, 1.0, -1.0), len(pairs))
        for along, index in enumerate(np.nonzero(faces)):
            centres[along] += np.bincount(at, index + (0.5 if along == axis else 0.0), len(pairs))
    return centres, normals


def timed(runs, task):
    """The last result and the least time."""
    seconds = []
    for _ in range(runs):
        start = time.process_time()
        result = task()
        seconds.append(time.process_time() - start)
    return result, min(seconds)


def fdem(path, program, runs=5):
    """The results of the program, its own report, and its least time."""
    children = lambda: sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])  # noqa: E731
    with tempfile.TemporaryDirectory() as folder:
        out, summary = Path(folder, "out.npy"), Path(folder, "out.json")
        command = [program, "contacts", path, "--labels", "-q", "-o", out, "--json", summary]
        seconds, wall, peaks = [], [], []
        for _ in range(runs):
            before, start = children(), time.perf_counter()
            subprocess.run(command, check=True)
            seconds.append(children() - before)
            wall.append(time.perf_counter() - start)
            said = json.loads(summary.read_text())
            peaks.append(said["peak_bytes"])
        size = Path(path).stat().st_size
        said = {"wall": min(wall), "peak": f"{max(peaks) / 1e6:.1f} MB of {size / 1e6:.1f} MB: {max(peaks) / size:.4f}"}
        return np.load(out), said, min(seconds)


def compare(path, program):
    labels = np.load(path)
    (pairs, faces), numpy_seconds = timed(3, lambda: counts(labels))
    (centres, normals), means_seconds = timed(1, lambda: means(labels, pairs))
    with np.errstate(invalid="ignore"):
        normals = np.nan_to_num(normals / np.sqrt((normals**2).sum(axis=0)))

    found, said, seconds = fdem(path, program)
    assert np.array_equal(pack(found["i"], found["j"]), pairs), "other pairs"
    assert np.array_equal(found["faces"], faces), "other numbers of faces"
    for along, name in enumerate("zyx"):
        assert np.allclose(found[name], centres[along] / faces, rtol=1e-12, atol=1e-9), f"other centroids along {name}"
        assert np.allclose(found["n" + name], normals[along], atol=1e-12), f"other normals along {name}"
    print(f"{len(pairs):,} contacts, {faces.sum():,} faces: equal")
    print(f"numpy  {numpy_seconds:.2f} s, pairs and faces, volume in memory")
    print(f"       {numpy_seconds + means_seconds:.2f} s, with centroids and normals")
    print(f"fdem   {seconds:.2f} s, with these, file to file: {(numpy_seconds + means_seconds) / seconds:.1f} times faster")
    print(f"       {numpy_seconds / seconds:.1f} times faster than numpy without centroids and normals, which fdem has besides")
    print(f"       by the clock {said['wall']:.2f} s")
    print(f"peak   {said['peak']}")


def peers(path, program):
    labels = np.load(path)
    found, _, seconds = fdem(path, program)
    mine = np.unique(np.sort(np.stack([found["i"], found["j"]], axis=1)), axis=0)
    print(f"fdem   {seconds:.3f} s, file to file: {len(mine):,} contacts")

    def scikit_image():
        from skimage.graph import RAG

        return np.array([edge for edge in RAG(labels, connectivity=1).edges if 0 not in edge])

    def spam():
        from spam.label import boundingBoxes, contactingLabels

        # Each label is dilated by a voxel; at the faces of the volume there must be room for that.
        padded = np.pad(labels.astype("<u4"), 3)
        bodies = [int(label) for label in np.unique(labels) if label]
        touching = contactingLabels(padded, labelsList=bodies, boundingBoxes=boundingBoxes(padded))
        return np.array([(a, b) for a, others in zip(bodies, touching) for b in others if b])

    for name, task in {"scikit-image": scikit_image, "spam": spam}.items():
        try:
            pairs, taken = timed(1, task)
        except ImportError as error:
            print(f"{name}: {error}")
            continue
        pairs = np.unique(np.sort(np.asarray(pairs).reshape(-1, 2)), axis=0)
        same = "equal" if np.array_equal(pairs, mine) else "DIFFERENT"
        print(f"{name}  {taken:.3f} s, volume in memory: {len(pairs):,} contacts, {same}; {taken / seconds:.0f} times as long")
        assert same == "equal"


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["make", path, *numbers]:
            make(path, *map(int, numbers[:2]), *numbers[2:3])
        case ["compare", path, program]:
            compare(path, program)
        case ["peers", path, program]:
            peers(path, program)
        case _:
            sys.exit(__doc__)
