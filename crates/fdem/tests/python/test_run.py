"""The folder of a run, read by the tools that the book names: meshio, PyVista (VTK), pandas, a JSON parser.

FDEM=path/to/fdem pytest test_run.py
"""

import json
import os
import subprocess

import meshio
import numpy as np
import pandas as pd
import pytest
import pyvista as pv

FDEM = os.environ["FDEM"]

MODEL = """
[model]
end_time = 0.6e-3
[[body]]
name = "floor"
material = "rock"
rectangle = { min = [-0.2, -0.1], max = [0.2, 0] }
mesh_size = 0.03
[[body]]
name = "block"
material = "rock"
rectangle = { min = [-0.05, 0.0005], max = [0.05, 0.1] }
mesh_size = 0.02
velocity = [1, -20]
[[material]]
name = "rock"
density = 2700
youngs_modulus = 10e9
poissons_ratio = 0.2
friction = 0.4
tensile_strength = 1e6
cohesion = 3e6
friction_angle = 30
fracture_energy_i = 5
fracture_energy_ii = 20
[[boundary]]
name = "ground"
body = "floor"
side = "bottom"
fixed = "xy"
[output]
frames = 60
[[history]]
name = "ground"
force = "ground"
"""


SPACE = """
[model]
end_time = 0.2e-3
[[body]]
name = "floor"
material = "steel"
box = { min = [-0.06, -0.06, -0.02], max = [0.06, 0.06, 0] }
mesh_size = 0.03
[[body]]
name = "block"
material = "rock"
box = { min = [-0.02, -0.02, 0.0005], max = [0.02, 0.02, 0.0405] }
mesh_size = 0.015
velocity = [1, 0, -20]
[[material]]
name = "steel"
density = 7800
youngs_modulus = 100e9
poissons_ratio = 0.3
friction = 0.4
[[material]]
name = "rock"
density = 2700
youngs_modulus = 10e9
poissons_ratio = 0.2
friction = 0.4
tensile_strength = 1e6
cohesion = 3e6
friction_angle = 30
fracture_energy_i = 5
fracture_energy_ii = 20
[[boundary]]
name = "ground"
body = "floor"
side = "bottom"
fixed = "xyz"
[output]
frames = 10
"""


@pytest.fixture(scope="module")
def space(tmp_path_factory):
    """A block of tetrahedra that breaks on a floor, in 11 frames."""
    folder = tmp_path_factory.mktemp("space")
    (folder / "crash.toml").write_text(SPACE)
    subprocess.run([FDEM, "run", "crash.toml", "-q", "-o", "results"], cwd=folder, check=True, capture_output=True)
    return folder / "results"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A block that breaks on a floor, in 61 frames."""
    folder = tmp_path_factory.mktemp("run")
    (folder / "crash.toml").write_text(MODEL)
    subprocess.run([FDEM, "run", "crash.toml", "-q", "-o", "results"], cwd=folder, check=True, capture_output=True)
    return folder / "results"


def test_meshio_and_vtk_read_the_same_in_every_frame(folder):
    """The arrays of a file end in any byte: of some sixty files each kind of end is met."""
    paths = sorted((folder / "frames").glob("?????.vtu"))
    assert len(paths) == 61
    for path in paths:
        by_meshio, by_vtk = meshio.read(path), pv.read(path)
        assert np.array_equal(by_meshio.points, by_vtk.points), path
        assert np.array_equal(by_meshio.cells_dict["triangle"], by_vtk.cells.reshape(-1, 4)[:, 1:]), path
        for name, values in by_meshio.point_data.items():
            assert np.array_equal(values, by_vtk.point_data[name]), (path, name)
        # VTK counts texts and tables among the data of the file, not of the cells.
        assert len(by_meshio.cell_data) == len(by_vtk.cell_data.keys())
        for name, (values,) in by_meshio.cell_data.items():
            assert np.array_equal(values, by_vtk.cell_data[name]), (path, name)


def test_pyvista_plays_the_collections(folder):
    for name in ["results.pvd", "cracks.pvd"]:
        reader = pv.get_reader(folder / name)
        times = reader.time_values
        assert len(times) == 61 and times[0] == 0 and np.all(np.diff(times) > 0)
        assert times[-1] == pytest.approx(0.6e-3, rel=1e-3)
        reader.set_active_time_value(times[-1])
        assert reader.read()[0].n_cells > 0


def test_pandas_reads_the_history(folder):
    table = pd.read_csv(folder / "history.csv")
    assert table["step"].is_monotonic_increasing and table["time"].iloc[0] == 0
    assert (table.dtypes != object).all() and not table.isna().any().any()
    assert table["ground fy [N]"].max() > 0
    assert table["broken_joints"].iloc[-1] > 0


def test_the_summary_is_json(folder):
    summary = json.loads((folder / "run.json").read_text())
    table = pd.read_csv(folder / "history.csv")
    assert summary["status"] == "finished"
    assert summary["broken_joints"] == table["broken_joints"].iloc[-1]
    assert summary["energies"]["kinetic"] == table["kinetic"].iloc[-1]
    assert summary["elements"] == pv.read(folder / "frames/00000.vtu").n_cells


def test_pyvista_opens_tetrahedra_and_cracks(space):
    history = pd.read_csv(space / "history.csv").set_index("step")
    summary = json.loads((space / "run.json").read_text())
    solids, cracks = (pv.get_reader(space / name) for name in ["results.pvd", "cracks.pvd"])
    assert len(solids.time_values) == len(cracks.time_values) == 11
    assert solids.time_values[-1] == pytest.approx(0.2e-3, rel=1e-2)
    for time in solids.time_values:
        solids.set_active_time_value(time)
        mesh = solids.read()[0]
        assert set(mesh.celltypes) == {pv.CellType.TETRA} and mesh.n_cells == summary["elements"]
        assert np.all(np.isfinite(mesh.points))
        # The floor hardly deforms; its volume and the block's are those of boxes.
        volumes = mesh.compute_cell_sizes(length=False, area=False)["Volume"]
        body = mesh.cell_data["body"]
        assert volumes[body == 0].sum() == pytest.approx(0.12 * 0.12 * 0.02, rel=1e-3)
        assert volumes[body == 1].sum() == pytest.approx(0.04**3, rel=1e-2)
        # Six components of a symmetric tensor, in VTK's order: its eigenvalues are the principal stresses.
        stress = mesh.cell_data["stress"]
        assert stress.shape == (mesh.n_cells, 6)
        xx, yy, zz, xy, yz, xz = stress.T
        tensors = np.stack([xx, xy, xz, xy, yy, yz, xz, yz, zz], axis=1).reshape(-1, 3, 3)
        values = np.linalg.eigvalsh(tensors)
        scale = np.abs(values).max() + 1
        assert np.allclose(mesh.cell_data["principal_stress"][:, 0], values[:, 2], rtol=1e-6, atol=1e-6 * scale)
        assert np.allclose(mesh.cell_data["principal_stress"][:, 1], values[:, 0], rtol=1e-6, atol=1e-6 * scale)
    cracks.set_active_time_value(cracks.time_values[-1])
    faces = cracks.read()[0]
    assert faces.n_cells == summary["broken_joints"] > 0 and np.all(faces.faces.reshape(-1, 4)[:, 0] == 3)
    assert {"mode", "opening", "damage"} <= set(faces.cell_data.keys())
    assert np.all(faces.cell_data["broken"] == 1) and faces.cell_data["time_of_failure"].max() <= 0.2e-3 * 1.01
    assert faces.cell_data["area"].sum() == pytest.approx(history["crack_area"].iloc[-1], rel=1e-9)
    # Broken faces turn, but stretch little.
    seen = faces.compute_cell_sizes(length=False, volume=False)["Area"].sum()
    assert seen == pytest.approx(faces.cell_data["area"].sum(), rel=0.05)


def test_pandas_reads_the_fragments(space):
    table = pd.read_csv(space / "fragments.csv")
    summary = json.loads((space / "run.json").read_text())
    assert table["elements"].sum() == summary["elements"]
    assert table["mass"].sum() == pytest.approx(7800 * 0.12 * 0.12 * 0.02 + 2700 * 0.04**3, rel=1e-9)
    assert (table["body_name"][table["counted"] == 1] == "block").all()
