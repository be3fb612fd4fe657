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
from vtkmodules.vtkCommonCore import vtkDataArray

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
    names = ["mesh_{}.vtu", "cracks_{}.vtp", "damaged_joints_{}.vtp", "contacts_{}.vtp"]
    return [*(folder / name.format(number) for name in names), expected]


def in_space(vectors):
    return np.column_stack([vectors, np.zeros(len(vectors))])


def test_mesh_by_vtk(instant):
    path, *_, expected = instant
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
    assert [names.GetComponentName(k) for k in range(6)] == ["xx", "yy", "zz", "xy", "yz", "xz"]
    tensors = np.zeros((len(stress), 2, 2))
    tensors[:, 0, 0], tensors[:, 1, 1] = stress[:, 0], stress[:, 1]
    tensors[:, 0, 1] = tensors[:, 1, 0] = stress[:, 3]
    low, high = np.linalg.eigvalsh(tensors).T
    scale = np.abs(stress).max() + 1.0
    assert np.allclose(mesh.cell_data["principal_stress"], np.column_stack([high, low]), rtol=0, atol=1e-12 * scale)
    mean = stress[:, :3].sum(axis=1) / 3
    deviator = np.sqrt(1.5 * (((stress[:, :3] - mean[:, None]) ** 2).sum(axis=1) + 2 * stress[:, 3] ** 2))
    assert np.allclose(mesh.cell_data["von_mises"], deviator, rtol=0, atol=1e-12 * scale)
    assert np.array_equal(mesh.point_data["reaction"], in_space(expected["reactions"]))
    for name, key in [("damage", "damage"), ("body", "bodies"), ("material", "materials"), ("fragment", "fragments")]:
        assert np.array_equal(mesh.cell_data[name], expected[key]), name
    assert mesh.field_data["TimeValue"].tolist() == [expected["time"]]
    for name, number in [("body: left half", 0), ("body: right half", 1), ("material: sandstone", 0)]:
        assert mesh.field_data[name].tolist() == [number]


def unit(array):
    """The unit that VTK knows of an array."""
    key = vtkDataArray.UNITS_LABEL()
    information = array.GetInformation()
    return information.Get(key) if information.Has(key) else None


def test_units_by_vtk(instant):
    mesh, cracks, contacts = pv.read(instant[0]), pv.read(instant[1]), pv.read(instant[3])
    points, cells = mesh.GetPointData(), mesh.GetCellData()
    units = {"displacement": "m", "velocity": "m/s", "reaction": "N"}
    assert {name: unit(points.GetArray(name)) for name in units} == units
    units = {"stress": "Pa", "principal_stress": "Pa", "von_mises": "Pa", "damage": None, "fragment": None}
    assert {name: unit(cells.GetArray(name)) for name in units} == units
    if cracks.n_lines:
        units = {"opening": "m", "sliding": "m", "time_of_failure": "s", "length": "m", "mode": None}
        assert {name: unit(cracks.GetCellData().GetArray(name)) for name in units} == units
    if contacts.n_points:
        units = {"force": "N", "normal_force": "N", "tangential_force": "N", "elements": None}
        assert {name: unit(contacts.GetPointData().GetArray(name)) for name in units} == units


def test_triangles_are_counter_clockwise(instant):
    mesh = pv.read(instant[0])
    a, b, c = (mesh.points[mesh.cells.reshape(-1, 4)[:, k]] for k in (1, 2, 3))
    areas = np.cross(b - a, c - a)[:, 2] / 2
    assert (areas > 0).all()
    assert areas.sum() == pytest.approx(np.pi * 0.025**2, rel=0.05)


def test_mesh_by_meshio(instant):
    path, *_, expected = instant
    mesh = meshio.read(path)
    assert np.array_equal(mesh.points, in_space(expected["positions"]))
    assert np.array_equal(mesh.cells_dict["triangle"], expected["triangles"])
    assert np.array_equal(mesh.cell_data["stress"][0], expected["stresses"])
    assert np.array_equal(mesh.cell_data["damage"][0], expected["damage"])


@pytest.mark.parametrize("broken", [True, False])
def test_cracks_by_vtk(instant, broken):
    expected = instant[-1]
    cracks = [crack for crack in expected["cracks"] if (crack["time"] is not None) == broken]
    mesh = pv.read(instant[1 if broken else 2])
    assert mesh.n_lines == len(cracks)
    if not cracks:
        return
    ends = mesh.lines.reshape(-1, 3)
    assert (ends[:, 0] == 2).all()
    found = mesh.points[ends[:, 1:]]
    assert np.array_equal(found[:, :, :2], [crack["ends"] for crack in cracks]) and not found[:, :, 2].any()
    for name in ("mode", "damage", "opening", "sliding", "length", "elements"):
        assert np.array_equal(mesh.cell_data[name], [crack[name] for crack in cracks]), name
    assert (mesh.cell_data["broken"] == broken).all()
    times = [np.nan if crack["time"] is None else crack["time"] for crack in cracks]
    assert np.array_equal(mesh.cell_data["time_of_failure"], times, equal_nan=True)
    assert mesh.field_data["TimeValue"].tolist() == [expected["time"]]


def test_contacts_by_vtk(instant):
    expected = instant[-1]
    contacts = expected["contacts"]
    mesh = pv.read(instant[3])
    assert mesh.n_points == len(contacts) == mesh.n_verts
    if not contacts:
        return
    assert np.array_equal(mesh.points, in_space([contact["point"] for contact in contacts]))
    normal, tangential = (np.array([contact[key] for contact in contacts]) for key in ("normal", "tangential"))
    assert np.array_equal(mesh.point_data["force"], in_space(normal + tangential))
    for name, vectors in [("normal_force", normal), ("tangential_force", tangential)]:
        assert np.allclose(mesh.point_data[name], np.hypot(*vectors.T), rtol=1e-15, atol=0)
    elements = np.array([contact["elements"] for contact in contacts])
    assert np.array_equal(mesh.point_data["elements"], elements)
    for name, key in [("bodies", "bodies"), ("fragments", "fragments")]:
        assert np.array_equal(mesh.point_data[name], np.array(expected[key])[elements])
    arrows = mesh.glyph(orient="force", scale="normal_force", factor=1e-3)
    assert arrows.n_cells > len(contacts)


def test_collections(folder):
    for name in ("mesh", "cracks", "damaged_joints", "contacts"):
        name, kind = f"{name}.pvd", pv.UnstructuredGrid if name == "mesh" else pv.PolyData
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
    assert rows.shape == (1001, 22)
    assert (np.diff(rows[:, 1]) > 0).all() and not np.isnan(rows).any()
    # Energies from `kinetic` on, then the work of what acts from outside, and the balance.
    external = names.split(",").index("external")
    stored = rows[:, 2:external].sum(axis=1)
    assert np.allclose(stored - rows[:, external], rows[:, external + 1], rtol=0, atol=1e-12)
