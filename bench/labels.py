"""Contacts in a labelled volume: `fdem contacts --labels` against numpy.

    python3 bench/labels.py make VOLUME.npy [EDGE [GRAINS]]   a cube of Voronoi grains around jittered sites; u2, from a seed
    python3 bench/labels.py compare VOLUME.npy FDEM           FDEM: the program; both find all contacts, and the lists must be equal

numpy compares shifted arrays, packs each pair of labels into one number, and counts these with `numpy.unique`. It is timed for the pairs and their
faces alone; then centroids and normals are worked out too, and compared.
"""

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np


def make(path, edge=512, grains=20_000):
    """A site in each cell of a grid, anywhere within it; a voxel belongs to the nearest site of the 27 cells around it."""
    per_axis = next(n for n in range(1, edge) if n**3 >= grains)
    # At least as many cells as grains; layers along z may be thicker than wide.
    shape = np.array([-(-grains // per_axis**2), per_axis, per_axis])
    cell = edge / shape
    random = np.random.default_rng(1)
    sites = (np.indices(shape).reshape(3, -1).T + random.random((shape.prod(), 3))) * cell
    sites = sites.reshape(*shape, 3)
    out = np.lib.format.open_memmap(path, "w+", np.uint16, (edge,) * 3)
    y, x = np.meshgrid(np.arange(edge), np.arange(edge), indexing="ij")
    cells = [(axis + 0.5) // size for axis, size in zip((y, x), cell[1:])]
    cy, cx = (c.astype(int) for c in cells)
    for z in range(edge):
        cz = int((z + 0.5) // cell[0])
        nearest = np.full((edge, edge), np.inf)
        for dz, dy, dx in np.ndindex(3, 3, 3):
            k, j, i = cz + dz - 1, cy + dy - 1, cx + dx - 1
            if not 0 <= k < shape[0]:
                continue
            inside = (0 <= j) & (j < shape[1]) & (0 <= i) & (i < shape[2])
            j, i = j.clip(0, shape[1] - 1), i.clip(0, shape[2] - 1)
            site = sites[k, j, i]
            distance = (site[..., 0] - z - 0.5) ** 2 + (site[..., 1] - y - 0.5) ** 2 + (site[..., 2] - x - 0.5) ** 2
            closer = inside & (distance < nearest)
            nearest[closer] = distance[closer]
            out[z][closer] = ((k * shape[1] + j) * shape[2] + i + 1)[closer]
    print(f"{path}: {out.shape}, {len(np.unique(out))} labels, {Path(path).stat().st_size / 1e6:.0f} MB")


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


def compare(path, program):
    labels = np.load(path)
    seconds = []
    for _ in range(3):
        start = time.perf_counter()
        pairs, faces = counts(labels)
        seconds.append(time.perf_counter() - start)
    centres, normals = means(labels, pairs)
    with np.errstate(invalid="ignore"):
        normals = np.nan_to_num(normals / np.sqrt((normals**2).sum(axis=0)))

    with tempfile.TemporaryDirectory() as folder:
        out, summary = Path(folder, "out.npy"), Path(folder, "out.json")
        runs = []
        for _ in range(5):
            start = time.perf_counter()
            subprocess.run(
                [program, "contacts", path, "--labels", "-q", "-o", out, "--json", summary], check=True
            )
            runs.append((time.perf_counter() - start, json.loads(summary.read_text())))
        found = np.load(out)
    assert np.array_equal(pack(found["i"], found["j"]), pairs), "other pairs"
    assert np.array_equal(found["faces"], faces), "other numbers of faces"
    for along, name in enumerate("zyx"):
        assert np.allclose(found[name], centres[along] / faces, rtol=1e-12, atol=1e-9), f"other centroids along {name}"
        assert np.allclose(found["n" + name], normals[along], atol=1e-12), f"other normals along {name}"
    wall, said = min(runs, key=lambda run: run[0])
    size = Path(path).stat().st_size
    print(f"{len(pairs):,} contacts, {faces.sum():,} faces: equal")
    print(f"numpy  {min(seconds):.2f} s, pairs and faces, volume in memory")
    print(f"fdem   {wall:.2f} s, file to file, with centroids and normals: {min(seconds) / wall:.1f} times faster")
    print(f"       read {said['seconds']['read']:.3f} s, detect {said['seconds']['detect']:.3f} s")
    print(f"peak   {said['peak_bytes'] / 1e6:.1f} MB of {size / 1e6:.1f} MB: {said['peak_bytes'] / size:.3f}")


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["make", path, *numbers]:
            make(path, *map(int, numbers))
        case ["compare", path, program]:
            compare(path, program)
        case _:
            sys.exit(__doc__)
