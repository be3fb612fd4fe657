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
