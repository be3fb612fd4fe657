"""Detector, queries, images, meshes, files, exports and the command."""

import os
import pathlib
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from conftest import ROOT, couples, gas, with_shifts

import fdem

EXAMPLES = ROOT / "examples"


# Detector


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_a_detector_finds_what_a_search_finds(dtype, rng):
    positions = gas(5000, 8, 3)[0].astype(dtype)
    groups = rng.integers(0, 500, 5000)
    detector = fdem.Detector(cutoff=1.0, groups=groups, buffer=0.2)
    redetected = []
    for _ in range(12):
        positions += rng.normal(0, 0.01, positions.shape).astype(dtype) + dtype(0.3)
        redetected.append(detector.update(positions))
        found = fdem.contacts(positions, cutoff=1.0, groups=groups)
        assert couples(detector.contacts) == couples(found)
        assert np.allclose(np.sort(detector.contacts.distance), np.sort(found.distance))
    assert redetected[0] and not all(redetected)
    assert detector.updates == 12 and detector.redetections == sum(redetected)
    assert (detector.reason is None) == (not redetected[-1])
    assert "12 updates" in repr(detector)


def test_a_detector_takes_other_elements_and_recovers(rng):
    detector = fdem.Detector(radii=0.5, buffer=0.5)
    assert detector.update(np.zeros((2, 2))) and len(detector.contacts) == 1
    assert detector.update(np.zeros((3, 2))) and "2 elements became 3" in detector.reason
    assert detector.update(np.zeros((3, 3), np.float32)) and len(detector.contacts) == 3
    with pytest.raises(ValueError, match="element 1"):
        detector.update([[0, 0, 0], [0, 0, np.nan]])
    assert detector.update(np.zeros((3, 3))) and not detector.update(np.zeros((3, 3)))


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("wraps", [False, True])
def test_a_detector_in_a_box_that_repeats(dtype, wraps, rng):
    edges = np.array([[9.0, 0, 0], [2, 8, 0], [-1, 3, 10]])
    positions = ((rng.random((900, 3)) * 1.4 - 0.2) @ edges).astype(dtype)
    radii = rng.uniform(0.2, 0.5, 900).astype(dtype)
    groups = rng.integers(0, 300, 900)
    options = {"groups": groups, "tolerance": 0.05, "box": edges, "periodic": [True, True, False]}
    detector = fdem.Detector(radii=radii, buffer=0.25, **options)
    redetected = []
    for _ in range(12):
        positions += rng.normal(0, 0.01, positions.shape).astype(dtype) + dtype(0.1)
        if wraps:
            fractions = positions @ np.linalg.inv(edges)
            positions -= (np.floor(fractions) * [1, 1, 0] @ edges).astype(dtype)
        redetected.append(detector.update(positions))
        found = fdem.contacts(positions, radii, **options)
        assert with_shifts(detector.contacts) == with_shifts(found)
        assert np.allclose(np.sort(detector.contacts.distance), np.sort(found.distance))
    assert redetected[0] and sum(redetected) < 8, redetected
    assert len(detector.contacts._shifts) > 0


def test_a_detector_whose_box_changes():
    detector = fdem.Detector(cutoff=1.0, buffer=0.5, box=[4, 4], periodic=True)
    positions = np.array([[0.25, 1], [3.75, 1]])
    assert detector.update(positions) and with_shifts(detector.contacts) == {(0, 1, -1, 0)}
    detector.box = [5, 4]
    assert detector.update(positions) and "box" in detector.reason and len(detector.contacts) == 0
    detector.box, detector.periodic = None, False
    assert detector.update(positions + 1) and detector.update(positions * 1.5)
    detector.box, detector.periodic = [4, 4], True
    assert detector.update(positions) and len(detector.contacts) == 1
    with pytest.raises(ValueError, match="periodic needs a box"):
        fdem.Detector(cutoff=1.0, periodic=True).update(positions)


# Two sets and walls


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_two_sets(dtype, rng):
    one, two = (rng.random((n, 3)).astype(dtype) * 6 for n in (300, 200))
    radii, other_radii = rng.uniform(0.2, 0.6, 300).astype(dtype), 0.4
    found = fdem.between(one, two, radii, other_radii, tolerance=0.125)
    reach = radii[:, None] + dtype(0.4) + dtype(0.125)
    distance = np.sqrt(((one[:, None] - two[None]) ** 2).sum(axis=-1))
    assert found.distance.dtype == dtype
    assert list(zip(found.i.tolist(), found.j.tolist())) == [tuple(pair) for pair in np.argwhere(distance <= reach).tolist()]
    assert np.allclose(found.distance, distance[found.i, found.j]) and not found.shift.any()
    assert np.allclose(found.overlap, radii[found.i] + dtype(0.4) - found.distance, atol=1e-6)
    assert "couples" in repr(found) and len(found) > 0


def test_two_sets_in_a_box_that_repeats(rng):
    edges = np.array([[2.0, 0], [0.5, 1.5]])
    one, two = rng.random((20, 2)) * 4 - 1, rng.random((15, 2)) * 4 - 1
    found = fdem.between(one, two, cutoff=0.9, box=fdem.Box(edges), periodic=True)
    expected = set()
    for a in range(-6, 7):
        for b in range(-6, 7):
            moved = two + np.array([a, b]) @ edges
            near = np.linalg.norm(one[:, None] - moved[None], axis=-1) <= 0.9
            expected |= {(i, j, a, b) for i, j in np.argwhere(near).tolist()}
    listed = [(i, j, *shift) for i, j, shift in zip(found.i.tolist(), found.j.tolist(), found.shift.tolist())]
    assert listed == sorted(expected)
    apart = two[found.j] + found.shift @ edges - one[found.i]
    assert np.allclose(found.distance, np.linalg.norm(apart, axis=1))


def test_what_two_sets_refuse():
    with pytest.raises(TypeError, match="radii and other_radii"):
        fdem.between([[0, 0]], [[1, 1]], radii=1.0)
    with pytest.raises(TypeError, match="radii and other_radii"):
        fdem.between([[0, 0]], [[1, 1]], radii=1.0, cutoff=1.0)
    with pytest.raises(ValueError, match="2 coordinates, and others 3"):
        fdem.between([[0, 0]], [[1, 1, 1]], cutoff=1.0)
    with pytest.raises(ValueError, match="other_radii must be one number, or one for each of 1"):
        fdem.between([[0, 0]], [[1, 1]], 1.0, [1.0, 2.0])


def test_spheres_in_a_box_of_walls(rng):
    corners = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)]) * 4.0
    squares = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]]
    triangles = [triangle for a, b, c, d in squares for triangle in ([a, b, c], [a, c, d])]
    bodies = np.repeat([10, 11, 12, 13, 14, 15], 2)
    centres, radii = rng.random((200, 3)) * 3 + 0.5, rng.uniform(0.1, 0.6, 200)
    found = fdem.walls(centres, radii, corners, triangles, bodies)
    # The gap to each wall, in the order of the bodies: z, y, x, each from below and from above.
    gaps = np.stack([centres[:, 2], 4 - centres[:, 2], centres[:, 1], 4 - centres[:, 1], centres[:, 0], 4 - centres[:, 0]], axis=1)
    touching = np.argwhere(gaps <= radii[:, None])
    assert list(zip(found.i.tolist(), found.body.tolist())) == [(i, 10 + wall) for i, wall in touching.tolist()]
    assert np.allclose(found.overlap, (radii[:, None] - gaps)[touching[:, 0], touching[:, 1]])
    assert np.allclose(np.linalg.norm(found.normal, axis=1), 1)
    assert np.allclose(found.point, centres[found.i] + found.normal * (radii[found.i] - found.overlap)[:, None])
    assert (bodies[found.triangle] == found.body).all() and "walls" in repr(found)
    with pytest.raises(ValueError, match="triangle 1: there is no node 99"):
        fdem.walls(centres, 0.5, corners, [[0, 1, 2], [0, 1, 99]])
    with pytest.raises(ValueError, match="radii must be one number, or one for each of 200"):
        fdem.walls(centres, [0.5], corners, triangles)
    with pytest.raises(ValueError, match="walls are triangles in 3D"):
        fdem.walls(centres, 0.5, corners[:, :2], triangles)


# Queries


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("dimensions", [2, 3])
def test_queries_in_boxes_that_repeat(dtype, dimensions, rng):
    edges = np.eye(dimensions) * 2.5
    edges[1, 0] = 0.75
    positions = ((rng.random((25, dimensions)) * 2 - 0.5) @ edges).astype(dtype)
    at = ((rng.random((12, dimensions)) * 3 - 1) @ edges).astype(dtype)
    at[0] = positions[0]
    for periodic in (True, [True] + [False] * (dimensions - 1)):
        repeats = np.broadcast_to(periodic, dimensions)
        options = {"at": at, "box": fdem.Box(edges), "periodic": periodic}
        grid = np.stack(np.meshgrid(*[np.arange(-7, 8) if each else [0] for each in repeats], indexing="ij"), -1).reshape(-1, dimensions)
        images = positions.astype(float)[:, None] + grid @ edges
        found = fdem.query(positions, 1.5, **options)
        nearest = fdem.query(positions, k=40, **options)
        assert found.distances.dtype == dtype and found.shifts.dtype == np.int32
        for q, point in enumerate(at.astype(float)):
            distance = np.linalg.norm(images - point, axis=-1)
            stretch = slice(*found.offsets[q : q + 2])
            listed = [(i, *shift) for i, shift in zip(found.indices[stretch].tolist(), found.shifts[stretch].tolist())]
            assert listed == sorted((i, *grid[k].tolist()) for i, k in np.argwhere(distance <= 1.5).tolist())
            own = distance[found.indices[stretch], [np.flatnonzero((grid == shift).all(axis=1))[0] for shift in found.shifts[stretch]]]
            assert np.allclose(found.distances[stretch], own, atol=1e-6)
            stretch = slice(*nearest.offsets[q : q + 2])
            assert np.allclose(nearest.distances[stretch], np.sort(distance.ravel())[:40], atol=1e-5)
            moved = positions[nearest.indices[stretch]] + nearest.shifts[stretch] @ edges
            assert np.allclose(np.linalg.norm(moved - point, axis=1), nearest.distances[stretch], atol=1e-5)
    alone = fdem.query(positions, k=1, box=fdem.Box(edges), periodic=True)
    assert alone.indices.tolist() == list(range(25)) and not alone.distances.any() and not alone.shifts.any()
    none = fdem.query(positions[:0], k=3, **options)
    assert none.offsets.tolist() == [0] * 13 and none.shifts.shape == (0, dimensions)
    assert not fdem.query(positions, 1.0).shifts.any() and fdem.query(positions, k=2).shifts.shape == (50, dimensions)
    with pytest.raises(ValueError, match="cut-off"):
        fdem.query(positions, -1.0, **options)


@pytest.mark.parametrize("dimensions", [2, 3])
def test_queries_are_those_of_scipy(dimensions, rng):
    from scipy.spatial import cKDTree

    positions = gas(2000, 10, dimensions)[0]
    at = np.concatenate([positions[:50], rng.random((200, dimensions)) * positions.max() * 1.2])
    tree = cKDTree(positions)
    found = fdem.query(positions, 1.0, at=at)
    expected = tree.query_ball_point(at, 1.0, return_sorted=True)
    assert len(found.offsets) == len(at) + 1
    for k, indices in enumerate(expected):
        stretch = slice(*found.offsets[k : k + 2])
        assert found.indices[stretch].tolist() == indices
        assert np.allclose(found.distances[stretch], np.linalg.norm(positions[indices] - at[k], axis=1))
    nearest = fdem.query(positions, k=5, at=at)
    distances, indices = tree.query(at, 5)
    assert (nearest.indices.reshape(-1, 5) == indices).all()
    assert np.allclose(nearest.distances.reshape(-1, 5), distances)
    assert len(fdem.query(positions, 0.0).indices) == 2000, "each finds itself"


# Images


@pytest.mark.parametrize("dtype", ["u1", "i2", "u4", "i8", ">u2", "?"])
def test_labels_touch_where_neighbours_differ(dtype, rng):
    image = rng.integers(0, 2 if dtype == "?" else 6, (9, 8, 7)).astype(dtype)
    found = fdem.labels(image, spacing=[1, 2, 3], background=None)
    expected = {}
    for axis, area in enumerate([6.0, 3.0, 2.0]):
        whole = image.astype(int)
        a, b = (np.moveaxis(whole, axis, 0)[part].ravel() for part in (slice(None, -1), slice(1, None)))
        for i, j in zip(a[a != b].tolist(), b[a != b].tolist()):
            key = (min(i, j), max(i, j))
            faces, areas = expected.get(key, (0, 0.0))
            expected[key] = (faces + 1, areas + area)
    ours = {(i, j): (f, a) for i, j, f, a in zip(found.i.tolist(), found.j.tolist(), found.faces.tolist(), found.area.tolist())}
    assert ours == expected
    assert found.bodies == len(np.unique(image)) and len(found) == len(expected)
    assert f"{len(found)} contacts" in repr(found)


def test_labels_of_negative_numbers_and_backgrounds():
    image = np.array([[-1, -1, 5], [7, 7, 5]], np.int16)
    assert list(zip(fdem.labels(image).i, fdem.labels(image).j)) == [(-1, 5), (-1, 7), (5, 7)]
    assert fdem.labels(image, background=-1).i.tolist() == [5]
    assert fdem.labels(image.astype(np.int64)[:, ::2], background=300).bodies == 3
    with pytest.raises(ValueError, match="no neighbourhood 'all'"):
        fdem.labels(image, neighbourhood="all")
    with pytest.raises(TypeError, match="whole numbers"):
        fdem.labels(image * 0.5)
    with pytest.raises(ValueError, match="2 or 3 axes"):
        fdem.labels(np.zeros(4, int))
    with pytest.raises(ValueError, match="spacing"):
        fdem.labels(image, spacing=-1.0)


def test_the_image_of_the_examples():
    found = fdem.labels(np.load(EXAMPLES / "grains.npy"), spacing=0.5)
    assert (len(found), found.bodies) == (105, 27)
    assert found.faces.sum() == 4922 and found.area.sum() == 1230.5


# Meshes


def test_tetrahedra_that_overlap_by_a_known_volume():
    corners = np.array([[0, 0, 0], [6, 0, 0], [0, 6, 0], [0, 0, 6.0]])
    nodes = np.concatenate([corners, corners + [1, 1, 1], corners + 100])
    cells = np.arange(12).reshape(3, 4)
    found = fdem.mesh(nodes, cells, bodies=[-5, 30, 30])
    # The overlap has the same shape, with an edge of 3.
    assert len(found) == 1 and np.isclose(found.measure[0], 3**3 / 6)
    assert found.bodies.i.tolist() == [-5] and found.bodies.j.tolist() == [30]
    assert np.isclose(found.bodies.overlap[0], 4.5) and np.isclose(np.linalg.norm(found.normal), 1)
    assert len(fdem.mesh(nodes, cells, self_contact=True)) == 1
    with pytest.raises(TypeError, match="give bodies"):
        fdem.mesh(nodes, cells)
    with pytest.raises(ValueError, match="element 1: there is no node 77 among 12"):
        fdem.mesh(nodes, [[0, 1, 2, 3], [4, 5, 77, 6]], bodies=[0, 1])
    with pytest.raises(ValueError, match="3 or 4 nodes each, not 2 in 3D"):
        fdem.mesh(nodes, [[0, 1]], bodies=[0])
    with pytest.raises(ValueError, match="one number for each of 3"):
        fdem.mesh(nodes, cells, bodies=[0, 1])


def test_the_mesh_of_the_examples(tmp_path):
    mesh = fdem.read(EXAMPLES / "squares.msh")
    assert isinstance(mesh, fdem.Mesh) and "triangles" in repr(mesh)
    found = fdem.mesh(mesh.nodes, mesh.triangles, mesh.triangles_bodies)
    command = [*fdem_command(), "contacts", str(EXAMPLES / "squares.msh")]
    # In the file elements are numbered from 1.
    for option, ours, first in [("-o", found, 1), ("--body-table", found.bodies, 0)]:
        table = tmp_path / f"table{option}.csv"
        run = subprocess.run([*command, option, str(table)], capture_output=True, text=True)
        assert run.returncode == 0, run.stderr
        theirs = np.loadtxt(table, delimiter=",", skiprows=1, usecols=(0, 1), ndmin=2)
        assert (theirs - first == np.stack([ours.i, ours.j], 1)).all() and len(theirs) > 0


# Files


def fdem_command():
    return [os.environ["FDEM"]] if "FDEM" in os.environ else [sys.executable, "-m", "fdem"]


def test_the_packing_of_the_examples_and_the_command(tmp_path):
    packing = fdem.read(EXAMPLES / "packing.csv")
    found = fdem.contacts(packing.positions, packing.radii).sorted()
    assert len(packing) == 600 and len(found) == 1132
    table = tmp_path / "couples.csv"
    run = subprocess.run([*fdem_command(), "contacts", str(EXAMPLES / "packing.csv"), "-o", str(table)], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    theirs = np.loadtxt(table, delimiter=",", skiprows=1)
    assert (theirs[:, :2] == found.pairs).all()
    assert (theirs[:, 2] == found.distance).all() and (theirs[:, 3] == found.overlap).all()


def test_the_command_of_the_package(tmp_path):
    run = subprocess.run([sys.executable, "-m", "fdem", "contacts", "missing.csv"], capture_output=True, text=True, cwd=tmp_path)
    assert run.returncode == 2 and "missing.csv" in run.stderr
    run = subprocess.run([sys.executable, "-m", "fdem", "--version"], capture_output=True, text=True)
    assert run.returncode == 0 and fdem.__version__ in run.stdout
    script = pathlib.Path(sys.executable).with_name("fdem")
    run = subprocess.run([script, "generate", "gas", "--elements", "50", "--seed", "1", "--output", "gas.csv"], cwd=tmp_path)
    assert run.returncode == 0 and len(fdem.read(tmp_path / "gas.csv")) == 50


@pytest.mark.skipif(sys.platform == "win32", reason="there is no SIGINT for another process")
def test_ctrl_c_ends_the_command_of_the_package_without_a_traceback(tmp_path):
    model, folder = str(EXAMPLES / "three_point_bending.toml"), tmp_path / "run"
    run = subprocess.Popen(
        [sys.executable, "-m", "fdem", "run", model, "-o", str(folder)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=tmp_path
    )
    for _ in range(600):
        if list(folder.glob("*.pvd")) or run.poll() is not None:
            break
        time.sleep(0.05)
    run.send_signal(signal.SIGINT)
    _, errors = run.communicate(timeout=60)
    assert run.returncode == 130 and "Traceback" not in errors, errors


def bed():
    path = ROOT.parent / "shared/data/roundrobin/penetration/25KParticles.txt"
    return path if path.exists() else None


@pytest.mark.skipif(bed() is None, reason="the data is not there")
def test_the_bed_of_25_000_spheres():
    with pytest.raises(ValueError, match="25KParticles.txt:25002:"):
        fdem.read(bed())
    packing = fdem.read(bed(), skip_bad_lines=True)
    assert len(packing) == 25_000 and packing.skipped == 1 and ":25002:" in packing.bad_lines[0]
    found = fdem.contacts(packing.positions, packing.radii)
    assert len(found) == 53_876 and f"{found.coordination.mean():.4f}" == "4.3101"
    assert f"{found.overlap.max():.4e}" == "9.0117e-07"
    assert found.verify(100) == 100
    for engine in ("rows", "nbs"):
        other = fdem.contacts(packing.positions, packing.radii, engine=engine)
        assert np.array_equal(other.sorted().pairs, found.sorted().pairs)


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(FileNotFoundError):
        fdem.read(tmp_path / "missing.csv")
    path = tmp_path / "bad.csv"
    path.write_text("x,y,radius\n0,0,1\n1,abc,1\n")
    with pytest.raises(ValueError, match="bad.csv:3: cannot read 'abc'"):
        fdem.read(path)
    assert len(fdem.read(path, skip_bad_lines=True)) == 1
    path.write_text("0 0 1 3\n1 0 1 4\n")
    named = fdem.read(path, columns="x,y,radius,-")
    assert named.radii.tolist() == [1.0, 1.0]
    path.write_text("x,y,radius,clump\n0,0,1,3\n1,0,1,3\n")
    assert fdem.read(path, bodies="clump").bodies.tolist() == [3, 3]
    mesh = tmp_path / "bad.obj"
    mesh.write_text("v 0 0 0\nf 1 2 3\n")
    with pytest.raises(ValueError, match="bad.obj:2: .*node 2"):
        fdem.read(mesh)
    with pytest.raises(ValueError, match="mesh: it has no columns"):
        fdem.read(EXAMPLES / "squares.msh", columns="x,y")


XYZ = """2
Lattice="4 0 0 0 4 0 0 0 4" Properties=species:S:1:pos:R:3:radius:R:1 step={step}
A 0.25 1 1 0.5
B {x} 1 1 0.5
"""


def test_frames_and_boxes_of_files(tmp_path):
    import gzip

    path = tmp_path / "run.xyz.gz"
    path.write_bytes(gzip.compress((XYZ.format(step=10, x=2) + XYZ.format(step=20, x=3.5)).encode()))
    with pytest.raises(ValueError, match="run.xyz.gz: 2 frames: choose one of 0 to 1"):
        fdem.read(path)
    with pytest.raises(ValueError, match="no frame 2 among 2"):
        fdem.read(path, 2)
    found = []
    for frame in (0, 1, -1):
        packing = fdem.read(path, frame)
        assert packing.frames == 2 and packing.frame == frame % 2 and packing.step == 10 * (1 + frame % 2)
        assert packing.box == fdem.Box(np.eye(3) * 4) and packing.periodic == (True, True, True)
        contacts = fdem.contacts(packing.positions, packing.radii, box=packing.box, periodic=packing.periodic)
        found.append(contacts.shift.tolist())
    assert found == [[], [[-1, 0, 0]], [[-1, 0, 0]]]
    assert "a box that repeats, frame 1 of 2" in repr(packing)

    plain = fdem.read(EXAMPLES / "packing.csv")
    assert plain.box is None and plain.periodic == (False, False) and (plain.frames, plain.frame, plain.step) == (1, 0, None)
    again = fdem.contacts(plain.positions, plain.radii, box=plain.box, periodic=plain.periodic)
    assert len(again) == 1132
    with pytest.raises(ValueError, match="'csv' is none of text, npy"):
        fdem.read(EXAMPLES / "packing.csv", format="csv")


# Exports


def test_exports():
    positions, edge = gas(300, 8, 3)
    open_, closed = fdem.contacts(positions, cutoff=1), fdem.contacts(positions, cutoff=1, box=[edge] * 3, periodic=True)
    matrix = open_.to_scipy()
    assert matrix.shape == (300, 300) and matrix.nnz == 2 * len(open_)
    assert (matrix != matrix.T).nnz == 0 and np.allclose(matrix[open_.i, open_.j], open_.distance)
    assert open_.to_scipy(None, full=False).sum() == len(open_)
    assert np.allclose(open_.to_scipy("overlap", full=False).sum(), open_.overlap.sum())
    with pytest.raises(ValueError, match="no values 'radius'"):
        open_.to_scipy("radius")

    graph = open_.to_networkx()
    assert graph.number_of_nodes() == 300 and graph.number_of_edges() == len(open_)
    assert [graph.degree(k) for k in range(300)] == open_.coordination.tolist()
    graph = closed.to_networkx()
    assert graph.is_multigraph() and [graph.degree(k) for k in range(300)] == closed.coordination.tolist()
    assert sum(any(shift) for *_, shift in graph.edges(data="shift")) == len(closed._shifts) > 0

    table = open_.to_pandas()
    assert list(table) == ["i", "j", "distance", "overlap"] and (table["j"] == open_.j).all()
    table = closed.to_pandas()
    assert list(table)[4:] == ["sx", "sy", "sz"] and (table[["sx", "sy", "sz"]].to_numpy() == closed.shift).all()


def test_edges_of_graphs():
    found = fdem.contacts(gas(300, 8, 3)[0], cutoff=1)
    half, full = found.edge_index(full=False), found.edge_index()
    assert (half == found.pairs.T).all() and (full == np.concatenate([half, half[::-1]], axis=1)).all()
    for edges in (half, full):
        # What `torch.from_numpy` takes without a copy.
        assert edges.dtype == np.int64 and edges.flags.c_contiguous and edges.flags.writeable and edges.flags.aligned
        assert np.shares_memory(np.from_dlpack(edges), edges)
    signed = found.pairs.view(np.int32)
    assert (signed == found.pairs).all() and np.shares_memory(signed, found.pairs)


def test_pyvista():
    positions, edge = gas(300, 8, 3)
    radii = np.full(300, 0.5)
    for found in (
        fdem.contacts(positions, radii),
        fdem.contacts(positions, 0.5, box=[edge] * 3, periodic=True),
        fdem.contacts(positions[:, :2], cutoff=0.3),
        fdem.contacts(positions, radii=1e-9),
    ):
        data = found.to_pyvista()
        across = int(found.shift.any(axis=1).sum())
        assert data.n_points == 300 + across and data.n_lines == len(found)
        assert np.allclose(data.points[:300, : found._positions.shape[1]], found._positions)
        assert (data.point_data["coordination"][:300] == found.coordination).all()
        assert data.point_data["image"].sum() == across and ("radius" in data.point_data) == (found._kind != "cutoff")
        if len(found):
            ends = data.lines.reshape(-1, 3)[:, 1:]
            assert (data.point_data["id"][ends] == found.pairs).all()
            lengths = np.linalg.norm(data.points[ends[:, 1]] - data.points[ends[:, 0]], axis=1)
            assert np.allclose(lengths, found.distance, atol=1e-6) and (data.cell_data["distance"] == found.distance).all()


def test_files_of_couples(tmp_path):
    import pandas
    import pyvista

    packing = fdem.read(EXAMPLES / "packing.csv", kind="packing")
    found = fdem.contacts(packing.positions, packing.radii).sorted()
    for end in ("csv", "npy", "npz", "parquet", "vtp", "graphml", "json"):
        found.write(tmp_path / f"ours.{end}")
        command = [*fdem_command(), "contacts", str(EXAMPLES / "packing.csv"), "--quiet", "-o", str(tmp_path / f"theirs.{end}")]
        assert subprocess.run(command, capture_output=True).returncode == 0
    # Other formats have the time, or the ids of the file.
    assert (tmp_path / "ours.csv").read_bytes().count(b"\n") == (tmp_path / "theirs.csv").read_bytes().count(b"\n") == 1 + len(found)
    table = pandas.read_parquet(tmp_path / "ours.parquet")
    assert list(table) == ["i", "j", "distance", "overlap"]
    assert (table["i"] == found.i).all() and (table["overlap"] == found.overlap).all()
    positions, edge = gas(200, 8, 3)
    found = fdem.contacts(positions.astype(np.float32), cutoff=1.0, box=[edge] * 3, periodic=True)
    found.write(tmp_path / "network.vtp")
    theirs, ours = pyvista.read(tmp_path / "network.vtp"), found.to_pyvista()
    assert np.allclose(theirs.points, ours.points, atol=1e-5) and (theirs.lines == ours.lines).all()
    for name in ("id", "coordination", "image"):
        assert (theirs.point_data[name] == ours.point_data[name]).all(), name
    assert np.allclose(theirs.cell_data["distance"], ours.cell_data["distance"], atol=1e-6)
    found.write(tmp_path / "couples.parquet")
    table = pandas.read_parquet(tmp_path / "couples.parquet")
    assert (table[["sx", "sy", "sz"]].to_numpy() == found.shift).all()
    before = sorted(tmp_path.iterdir())
    with pytest.raises(ValueError, match=r"couples.txt: .*extension must be that of a format: .csv"):
        found.write(tmp_path / "couples.txt")
    with pytest.raises(ValueError, match="boxes have no centres"):
        fdem.boxes([[0, 0]], [[1, 1]]).write(tmp_path / "boxes.csv")
    with pytest.raises(FileNotFoundError, match="no such folder"):
        found.write(tmp_path / "none" / "couples.csv")
    assert sorted(tmp_path.iterdir()) == before


def test_pictures_in_notebooks():
    positions = gas(100, 8, 3)[0]
    for found in (fdem.contacts(positions, cutoff=1), fdem.contacts(positions[:, :2], radii=0.2)):
        picture = found._repr_png_()
        assert picture.startswith(b"\x89PNG") and found._repr_png_() is picture, "drawn once"
        assert "data:image/png;base64," in found._repr_html_() and "<table>" in found._repr_html_()
    for found in (fdem.boxes([[0, 0]], [[1, 1]]), fdem.contacts(np.zeros((0, 3)), cutoff=1), fdem.contacts(gas(60_000, 1, 3)[0], cutoff=1)):
        assert found._repr_png_() is None and "<img" not in found._repr_html_()
    found = fdem.contacts(positions, cutoff=1)
    positions += np.arange(100)[:, None]
    assert found._repr_png_() is None and "<table>" in found._repr_html_()


@pytest.mark.parametrize("export", ["to_scipy", "to_networkx", "to_pandas", "to_pyvista"])
def test_exports_say_what_they_need(export, monkeypatch):
    found = fdem.contacts([[0, 0], [1, 0]], cutoff=1)
    for name in ("scipy", "scipy.sparse", "networkx", "pandas", "pyvista"):
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(ImportError, match="pip install"):
        getattr(found, export)()


def test_frames_are_a_sequence_of_packings(tmp_path):
    def frame(step):
        head = f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp pp\n0 9\n0 9\n0 9\n"
        return head + f"ITEM: ATOMS id x y z radius\n1 1 1 1 0.5\n2 {1 + step / 100} 1 1 0.5\n"

    path = tmp_path / "run.dump"
    path.write_text("".join(frame(step) for step in (0, 50, 150)))
    frames = fdem.frames(path)
    assert len(frames) == 3 and [packing.step for packing in frames] == [0, 50, 150]
    assert [len(fdem.contacts(packing.positions, packing.radii, box=packing.box, periodic=packing.periodic)) for packing in frames] == [1, 1, 0]
    assert frames[-1].frame == 2 and frames[1].positions[1].tolist() == [1.5, 1, 1]
    assert [packing.frame for packing in frames[::-2]] == [2, 0] and len(frames[5:]) == 0
    assert "3 of 3 frames" in repr(frames)
    with pytest.raises(IndexError):
        frames[3]
    # A damaged frame does not hide those before it.
    path.write_text(frame(0) + frame(50).replace("1.5", "nonsense"))
    broken = fdem.frames(path)
    assert broken[0].step == 0
    with pytest.raises(ValueError, match="run.dump:22: frame 1 .*nonsense"):
        broken[1]
    assert len(fdem.frames(path, skip_bad_lines=True)[1]) == 1
    with pytest.raises(ValueError, match="squares.msh: this is a mesh"):
        fdem.frames(EXAMPLES / "squares.msh")
    assert len(fdem.frames(EXAMPLES / "packing.csv")) == 1
    with pytest.raises(TypeError, match="fdem.frames"):
        fdem.Frames()
