"""What `fdem contacts` says of files beside what public libraries see in the same files.

Each file is written by a library or by hand, read by a library, and its couples are found with SciPy's cKDTree in all images of its box. `fdem` must give
the same couples with the same shifts, the same number of elements, and the same box. Run with pytest where the packages of `requirements.txt` are; the
environment variable FDEM names the command.
"""

import csv
import gzip
import itertools
import json
import os
import subprocess
import warnings
from importlib import import_module

import numpy as np
import pytest
from scipy.spatial import cKDTree

FDEM = os.environ.get("FDEM", "fdem")
N = 150
FRAMES = 3
CELL = np.array([[9.0, 0.0, 0.0], [1.5, 8.0, 0.0], [-1.0, 2.0, 7.0]])
STRAIGHT = np.diag([9.0, 8.0, 7.0])

warnings.filterwarnings("ignore")


def fdem(file, *options):
    """The rows of the table and the summary, or summaries of a series."""
    out, told = file.parent / "out.csv", file.parent / "out.json"
    command = [FDEM, "contacts", str(file), "-q", "-o", str(out), "--json", str(told), *options]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    with open(out) as table:
        rows = list(csv.DictReader(table))
    return rows, json.loads(told.read_text())


def refusal(file, *options):
    done = subprocess.run([FDEM, "contacts", str(file), *options], capture_output=True, text=True)
    assert done.returncode == 2, done.stdout
    return done.stderr


def couples_of(rows, first=0):
    """Couples with their shifts; ids count from `first`."""
    shift = lambda row: tuple(int(row.get(name, 0)) for name in ("sx", "sy", "sz"))
    return {(int(row["i"]) - first, int(row["j"]) - first, shift(row)) for row in rows}


def expected(positions, radii, cell=None, pbc=(False,) * 3):
    """All couples whose spheres touch, from trees of all images next to the box, in which the positions are."""
    positions = np.asarray(positions, float)
    radii = np.broadcast_to(np.asarray(radii, float), len(positions))
    tree, found = cKDTree(positions), set()
    for shift in itertools.product(*[(-1, 0, 1) if repeats else (0,) for repeats in pbc]):
        images = positions + (np.array(shift) @ cell if cell is not None else 0.0)
        for i, near in enumerate(tree.query_ball_tree(cKDTree(images), 2 * radii.max())):
            for j in near:
                touch = np.linalg.norm(positions[i] - images[j]) <= radii[i] + radii[j]
                if touch and (i < j or (i == j and shift > (0, 0, 0))):
                    found.add((i, j, shift))
    assert len(found) > len(positions) // 6, "too few couples to compare"
    return found


def spheres(seed, cell=CELL):
    random = np.random.default_rng(seed)
    return random.random((N, 3)) @ cell, random.uniform(0.2, 0.6, N)


def check_box(summary, cell, pbc, origin=(0, 0, 0)):
    box = summary["periodic"] if any(pbc) else summary["box"]
    if any(pbc):
        assert box["axes"] == "".join(axis for axis, repeats in zip("xyz", pbc) if repeats)
        assert box["from"] == "file"
    np.testing.assert_allclose(box["edges"], cell, atol=1e-12)
    np.testing.assert_allclose(box["origin"], origin, atol=1e-12)


def check_frames(file, frames, *options, first=0):
    """`frames`: positions, radii, cell, pbc of each."""
    rows, summaries = fdem(file, *options)
    assert len(summaries) == len(frames)
    for k, (positions, radii, cell, pbc) in enumerate(frames):
        summary = summaries[k]
        assert (summary["frame"], summary["elements"]) == (k, len(positions))
        own = [row for row in rows if int(row["frame"]) == k]
        assert couples_of(own, first) == expected(positions, radii, cell, pbc)
        if cell is not None:
            check_box(summary, cell, pbc)
    return rows, summaries


@pytest.mark.parametrize("pbc", [(True, True, True), (True, False, True), (False, False, False)])
def test_extended_xyz_of_ase(tmp_path, pbc):
    ase, io = import_module("ase"), import_module("ase.io")
    frames = []
    for seed in range(FRAMES):
        positions, radii = spheres(seed)
        atoms = ase.Atoms("Si" * N, positions=positions, cell=CELL, pbc=pbc)
        atoms.new_array("radius", radii)
        atoms.info["step"] = 10 * seed
        frames.append(atoms)
    file = tmp_path / "run.xyz"
    io.write(file, frames, format="extxyz")
    read = io.read(file, index=":")
    seen = [(atoms.positions, atoms.arrays["radius"], np.array(atoms.cell), tuple(atoms.pbc)) for atoms in read]
    rows, summaries = check_frames(file, seen)
    assert [summary["step"] for summary in summaries] == [0, 10, 20]
    assert {row["step"] for row in rows} == {"0", "10", "20"}
    # A slice, from the end.
    rows, summaries = fdem(file, "--frames", "-1::-2")
    assert [summary["frame"] for summary in summaries] == [2, 0]


@pytest.mark.parametrize("cell", [STRAIGHT, CELL])
def test_lammps_data_of_ase(tmp_path, cell):
    ase, io = import_module("ase"), import_module("ase.io")
    positions, _ = spheres(5, cell)
    file = tmp_path / "bed.data"
    io.write(file, ase.Atoms("Si" * N, positions=positions, cell=cell, pbc=True), format="lammps-data", masses=True)
    atoms = io.read(file, format="lammps-data", atom_style="atomic", sort_by_id=True)
    rows, summary = fdem(file, "--radius", "0.4", "--periodic", "xyz")
    assert couples_of(rows, 1) == expected(atoms.positions, 0.4, np.array(atoms.cell), (True,) * 3)
    check_box(summary, np.array(atoms.cell), (True,) * 3)
    # The file does not say whether its box repeats.
    rows, summary = fdem(file, "--radius", "0.4")
    assert couples_of(rows, 1) == expected(atoms.positions, 0.4)
    check_box(summary, np.array(atoms.cell), (False,) * 3)


def dump(cell, pbc, scaled, seeds):
    """A dump as LAMMPS writes it, with the bounds that enclose the box."""
    (xx, _, _), (xy, yy, _), (xz, yz, zz) = cell
    flags = " ".join("pp" if repeats else "ff" for repeats in pbc)
    text = ""
    for seed in seeds:
        positions, radii = spheres(seed, cell)
        columns = positions @ np.linalg.inv(cell) if scaled else positions
        if xy == xz == yz == 0:
            bounds = f"ITEM: BOX BOUNDS {flags}\n0 {xx}\n0 {yy}\n0 {zz}\n"
        else:
            low, high = min(0, xy, xz, xy + xz), max(0, xy, xz, xy + xz)
            bounds = f"ITEM: BOX BOUNDS xy xz yz {flags}\n{low} {xx + high} {xy}\n{min(0, yz)} {yy + max(0, yz)} {xz}\n0 {zz} {yz}\n"
        axes = "xs ys zs" if scaled else "x y z"
        text += f"ITEM: TIMESTEP\n{100 * seed}\nITEM: NUMBER OF ATOMS\n{N}\n{bounds}ITEM: ATOMS id type {axes} radius\n"
        for k, (point, radius) in enumerate(zip(columns, radii)):
            text += f"{k + 1} 1 {' '.join(repr(float(x)) for x in point)} {float(radius)!r}\n"
    return text


@pytest.mark.parametrize("scaled", [False, True])
@pytest.mark.parametrize("cell", [STRAIGHT, CELL])
@pytest.mark.parametrize("pbc", [(True, True, True), (True, True, False)])
def test_lammps_dump_beside_ase_and_mdanalysis(tmp_path, cell, pbc, scaled):
    io, mda = import_module("ase.io"), import_module("MDAnalysis")
    file = tmp_path / "run.lammpstrj"
    file.write_text(dump(cell, pbc, scaled, range(FRAMES)))
    read = io.read(file, index=":", format="lammps-dump-text")
    radii = [spheres(seed, cell)[1] for seed in range(FRAMES)]
    seen = [(atoms.positions, r, np.array(atoms.cell), tuple(atoms.pbc)) for atoms, r in zip(read, radii)]
    _, summaries = check_frames(file, seen, first=1)
    trajectory = mda.Universe(str(file), format="LAMMPSDUMP", atom_style="id type x y z").trajectory
    assert len(trajectory) == len(summaries)
    for frame, summary in zip(trajectory, summaries):
        assert frame.data["step"] == summary["step"]
        edges = mda.lib.mdamath.triclinic_box(*np.array(summary["periodic"]["edges"]))
        np.testing.assert_allclose(frame.dimensions, edges, rtol=1e-5)
    packed = tmp_path / "run.lammpstrj.gz"
    packed.write_bytes(gzip.compress(file.read_bytes()))
    assert fdem(packed)[0] == fdem(file)[0]


def test_xyz_of_mdanalysis(tmp_path):
    mda = import_module("MDAnalysis")
    universe = mda.Universe.empty(N, trajectory=True)
    universe.add_TopologyAttr("names", ["Si"] * N)
    file = tmp_path / "run.xyz"
    with mda.Writer(str(file), n_atoms=N) as writer:
        for seed in range(FRAMES):
            universe.atoms.positions = spheres(seed)[0]
            writer.write(universe.atoms)
    # MDAnalysis holds positions in 32 bits, the file has decimals: no distance may be that near to the limit.
    points = [np.array([line.split()[1:] for line in block.splitlines()[2:]], float) for block in blocks(file, N + 2)]
    for frame, own in zip(mda.Universe(str(file)).trajectory, points):
        np.testing.assert_allclose(frame.positions, own, atol=1e-5)
    check_frames(file, [(own, 0.4, None, (False,) * 3) for own in points], "--radius", "0.4")


def blocks(file, size):
    lines = file.read_text().splitlines()
    return ["\n".join(lines[at : at + size]) for at in range(0, len(lines) - size + 1, size)]


def test_lammps_data_of_mdanalysis(tmp_path):
    mda = import_module("MDAnalysis")
    universe = mda.Universe.empty(N, trajectory=True, atom_resindex=[0] * N)
    for name, values in {"types": ["1"] * N, "masses": [1.0] * N, "charges": [0.0] * N, "resids": [1]}.items():
        universe.add_TopologyAttr(name, values)
    for name in ("bonds", "angles", "dihedrals", "impropers"):
        universe.add_TopologyAttr(name, [])
    universe.atoms.positions = spheres(3, STRAIGHT)[0]
    universe.dimensions = [9, 8, 7, 90, 90, 90]
    file = tmp_path / "bed.data"
    universe.atoms.write(str(file))
    read = mda.Universe(str(file), atom_style="id resid type charge x y z")
    lines = [line.split() for line in file.read_text().splitlines()]
    rows = [line for line in lines if len(line) == 7]
    points = np.array([row[4:7] for row in rows], float)
    np.testing.assert_allclose(read.atoms.positions, points, atol=1e-5)
    found, summary = fdem(file, "--columns", "id,_,_,_,x,y,z", "--radius", "0.4")
    assert couples_of(found, 1) == expected(points, 0.4)
    np.testing.assert_allclose(np.diag(summary["box"]["edges"]), read.dimensions[:3], rtol=1e-6)


@pytest.mark.parametrize("name,options", [("a.vtp", {}), ("a.vtp", {"binary": False}), ("a.vtk", {}), ("a.vtk", {"binary": False})])
def test_poly_data_of_pyvista(tmp_path, name, options):
    pyvista = import_module("pyvista")
    positions, radii = spheres(1)
    cloud = pyvista.PolyData(positions)
    cloud["velocity"] = np.zeros((N, 3))
    cloud["Radius"] = radii
    cloud["id"] = np.arange(N) + 7
    file = tmp_path / name
    cloud.save(file, **options)
    check_vtk(file, pyvista.read(file), "Radius", 7)


@pytest.mark.parametrize("name,options", [("a.vtu", {}), ("a.vtu", {"binary": False}), ("a.vtk", {}), ("a.vtk", {"binary": False})])
def test_grids_of_pyvista(tmp_path, name, options):
    pyvista = import_module("pyvista")
    positions, radii = spheres(2)
    cells = np.column_stack([np.ones(N, int), np.arange(N)]).ravel()
    grid = pyvista.UnstructuredGrid(cells, np.full(N, 1, np.uint8), positions)
    grid.point_data["radius"] = radii
    file = tmp_path / name
    grid.save(file, **options)
    check_vtk(file, pyvista.read(file), "radius")


def test_collections_of_vtk(tmp_path):
    pyvista = import_module("pyvista")
    positions, radii = spheres(1)
    whole = pyvista.PolyData(positions)
    whole["Radius"] = radii
    halves = []
    for half in np.array_split(np.arange(N), 2):
        halves.append(pyvista.PolyData(positions[half]))
        halves[-1]["Radius"] = radii[half]
    pyvista.MultiBlock(halves).save(tmp_path / "blocks.vtm")
    check_vtk(tmp_path / "blocks.vtm", whole, "Radius")

    vtk = import_module("vtk")
    writer = vtk.vtkXMLPPolyDataWriter()
    writer.SetFileName(str(tmp_path / "pieces.pvtp"))
    writer.SetNumberOfPieces(3)
    writer.SetStartPiece(0)
    writer.SetEndPiece(2)
    writer.SetInputData(whole)
    assert writer.Write() == 1
    reader = vtk.vtkXMLPPolyDataReader()
    reader.SetFileName(str(tmp_path / "pieces.pvtp"))
    reader.Update()
    joined = pyvista.wrap(reader.GetOutput())
    check_vtk(tmp_path / "pieces.pvtp", joined, "Radius")

    entries = [(0.5, "blocks.vtm"), (1.5, "pieces.pvtp")]
    sets = "".join(f'<DataSet timestep="{time}" part="0" file="{file}"/>' for time, file in entries)
    (tmp_path / "run.pvd").write_text(f'<VTKFile type="Collection"><Collection>{sets}</Collection></VTKFile>')
    assert pyvista.PVDReader(tmp_path / "run.pvd").time_values == [0.5, 1.5]
    for frame, read in enumerate([whole, joined]):
        rows, summary = fdem(tmp_path / "run.pvd", "--frames", str(frame))
        assert (summary["elements"], summary["time"]) == (read.n_points, entries[frame][0])
        assert couples_of(rows) == expected(np.asarray(read.points, float), read["Radius"])


def check_vtk(file, read, name, first=0):
    rows, summary = fdem(file)
    assert summary["elements"] == read.n_points
    points, radii = np.asarray(read.points, float), np.asarray(read.point_data[name], float)
    assert couples_of(rows, first) == expected(points, radii)


@pytest.mark.parametrize(
    "name,options",
    [("a.vtu", {}), ("a.vtu", {"binary": False}), ("a.vtu", {"compression": None}), ("a.vtk", {}), ("a.vtk", {"binary": False})],
)
def test_vertices_of_meshio(tmp_path, name, options):
    meshio, pyvista = import_module("meshio"), import_module("pyvista")
    positions, radii = spheres(4)
    mesh = meshio.Mesh(positions, [("vertex", np.arange(N)[:, None])], point_data={"diameter": 2 * radii})
    file = tmp_path / name
    meshio.write(file, mesh, **options)
    read = meshio.read(file)
    np.testing.assert_array_equal(read.points, pyvista.read(file).points)
    rows, summary = fdem(file)
    assert summary["elements"] == len(read.points)
    assert couples_of(rows) == expected(read.points, read.point_data["diameter"] / 2)


def test_compressors_that_are_not_read_are_named(tmp_path):
    meshio = import_module("meshio")
    mesh = meshio.Mesh(spheres(4)[0], [("vertex", np.arange(N)[:, None])])
    meshio.write(tmp_path / "a.vtu", mesh, compression="lzma")
    assert "the compressor vtkLZMADataCompressor" in refusal(tmp_path / "a.vtu")


def test_cells_make_a_mesh(tmp_path):
    pyvista = import_module("pyvista")
    pyvista.Sphere(theta_resolution=8, phi_resolution=8).triangulate().save(tmp_path / "a.vtp")
    _, summary = fdem(tmp_path / "a.vtp")
    assert summary["files"][0]["format"] == "XML VTK" and summary["bodies_of_meshes"]


def test_a_hand_written_file_of_vtk(tmp_path):
    pyvista = import_module("pyvista")
    file = tmp_path / "a.vtk"
    positions, radii = spheres(6)
    text = "# vtk DataFile Version 2.0\nspheres\nASCII\nDATASET UNSTRUCTURED_GRID\n"
    text += f"POINTS {N} double\n" + "\n".join(" ".join(map(repr, map(float, point))) for point in positions)
    text += f"\nCELLS {N} {2 * N}\n" + "\n".join(f"1 {k}" for k in range(N)) + f"\nCELL_TYPES {N}\n" + "1\n" * N
    text += f"POINT_DATA {N}\nSCALARS radius double\nLOOKUP_TABLE default\n" + "\n".join(map(repr, map(float, radii))) + "\n"
    file.write_text(text)
    check_vtk(file, pyvista.read(file), "radius")


@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
def test_archives_of_numpy(tmp_path, save):
    positions, radii = spheres(7)
    save(tmp_path / "a.npz", positions=np.asfortranarray(positions), radii=radii, velocities=positions, box=CELL)
    rows, _ = fdem(tmp_path / "a.npz")
    assert couples_of(rows) == expected(positions, radii)
    save(tmp_path / "b.npz", np.column_stack([positions, radii]))
    assert couples_of(fdem(tmp_path / "b.npz")[0]) == expected(positions, radii)
