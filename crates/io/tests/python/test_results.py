"""Results of a run, read by those who will read them: VTK itself (pyvista), ParaView's reader of collections, and meshio.

RUN_REPORT=path/to/the/example/run_report pytest test_results.py
"""

import json
import os
import subprocess

import meshio
import numpy as np
import pytest
import pyvista as pv

RUN_REPORT = os.environ["RUN_REPORT"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A disc of 6 * 20² elements that splits, in 31 frames, of which numbers 0, 15 and 30 are files."""
    folder = tmp_path_factory.mktemp("run")
    subprocess.run([RUN_REPORT, folder, "20", "31"], check=True, capture_output=True)
    return folder


@pytest.fixture(params=[0, 15, 30])
def instant(request, folder):
    number = f"{request.param:04}"
    expected = json.loads((folder / f"expected_{number}.json").read_text())
    return folder / f"mesh_{number}.vtu", folder / f"cracks_{number}.vtp", expected


def in_space(vectors):
    return np.column_stack([vectors, np.zeros(len(vectors))])


def test_mesh_by_vtk(instant):
    path, _, expected = instant
    mesh = pv.read(path)
    assert isinstance(mesh, pv.UnstructuredGrid)
    assert mesh.points.dtype == np.float64
    assert np.array_equal(mesh.points, in_space(expected["positions"]))
    assert set(mesh.celltypes) == {pv.CellType.TRIANGLE}
    assert np.array_equal(mesh.cells.reshape(-1, 4)[:, 1:], expected["triangles"])
    assert np.array_equal(mesh.point_data["displacement"], in_space(expected["displacements"]))
    assert np.array_equal(mesh.point_data["velocity"], in_space(expected["velocities"]))
    stress = np.array(expected["stresses"])
    assert np.array_equal(mesh.cell_data["stress"], stress)
    names = mesh.GetCellData().GetArray("stress")
    assert [names.GetComponentName(k) for k in range(4)] == ["xx", "yy", "xy", "zz"]
    tensors = np.zeros((len(stress), 2, 2))
    tensors[:, 0, 0], tensors[:, 1, 1] = stress[:, 0], stress[:, 1]
    tensors[:, 0, 1] = tensors[:, 1, 0] = stress[:, 2]
    low, high = np.linalg.eigvalsh(tensors).T
    scale = np.abs(stress).max() + 1.0
    assert np.allclose(mesh.cell_data["principal_stress"], np.column_stack([high, low]), rtol=0, atol=1e-12 * scale)
    mean = (stress[:, 0] + stress[:, 1] + stress[:, 3]) / 3
    deviator = np.sqrt(1.5 * (((stress[:, [0, 1, 3]] - mean[:, None]) ** 2).sum(axis=1) + 2 * stress[:, 2] ** 2))
    assert np.allclose(mesh.cell_data["von_mises"], deviator, rtol=0, atol=1e-12 * scale)
    for name, key in [("damage", "damage"), ("body", "bodies"), ("material", "materials")]:
        assert np.array_equal(mesh.cell_data[name], expected[key]), name
    assert mesh.field_data["TimeValue"].tolist() == [expected["time"]]


def test_triangles_are_counter_clockwise(instant):
    mesh = pv.read(instant[0])
    a, b, c = (mesh.points[mesh.cells.reshape(-1, 4)[:, k]] for k in (1, 2, 3))
    areas = np.cross(b - a, c - a)[:, 2] / 2
    assert (areas > 0).all()
    assert areas.sum() == pytest.approx(np.pi * 0.025**2, rel=0.05)


def test_mesh_by_meshio(instant):
    path, _, expected = instant
    mesh = meshio.read(path)
    assert np.array_equal(mesh.points, in_space(expected["positions"]))
    assert np.array_equal(mesh.cells_dict["triangle"], expected["triangles"])
    assert np.array_equal(mesh.cell_data["stress"][0], expected["stresses"])
    assert np.array_equal(mesh.cell_data["damage"][0], expected["damage"])


def test_cracks_by_vtk(instant):
    _, path, expected = instant
    cracks = expected["cracks"]
    mesh = pv.read(path)
    assert mesh.n_lines == len(cracks)
    if not cracks:
        return
    ends = mesh.lines.reshape(-1, 3)
    assert (ends[:, 0] == 2).all()
    found = mesh.points[ends[:, 1:]]
    assert np.array_equal(found[:, :, :2], [crack["ends"] for crack in cracks]) and not found[:, :, 2].any()
    for name in ("mode", "damage", "opening", "sliding", "length", "elements"):
        assert np.array_equal(mesh.cell_data[name], [crack[name] for crack in cracks]), name
    times = [np.nan if crack["time"] is None else crack["time"] for crack in cracks]
    assert np.array_equal(mesh.cell_data["time_of_failure"], times, equal_nan=True)
    assert np.isnan(mesh.cell_data["time_of_failure"]).any() == any(crack["time"] is None for crack in cracks)


def test_collections(folder):
    for name, kind in [("mesh.pvd", pv.UnstructuredGrid), ("cracks.pvd", pv.PolyData)]:
        reader = pv.get_reader(folder / name)
        assert reader.time_values == [0.0, 0.001, 0.002]
        for time in reader.time_values:
            reader.set_active_time_value(time)
            part = reader.read()[0]
            assert isinstance(part, kind)
            if kind is pv.UnstructuredGrid:
                assert part.field_data["TimeValue"][0] == time


def test_the_history_is_a_table(folder):
    with open(folder / "history.csv") as text:
        names = text.readline()
    assert names.startswith("step,time,kinetic,") and '"upper platen, force y [N]"' in names
    rows = np.genfromtxt(folder / "history.csv", delimiter=",", skip_header=1)
    assert rows.shape == (1001, 19)
    assert (np.diff(rows[:, 1]) > 0).all() and not np.isnan(rows).any()
    stored = rows[:, 2:8].sum(axis=1)
    assert np.allclose(stored - rows[:, 8], rows[:, 9], rtol=0, atol=1e-12)
