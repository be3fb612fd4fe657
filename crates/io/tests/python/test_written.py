"""What the command writes, read by those who will read it: pyvista (VTK), pyarrow, pandas, Polars, DuckDB, networkx and numpy.

FDEM=path/to/fdem pytest test_written.py
"""

import json
import os
import pathlib
import subprocess

import duckdb
import networkx as nx
import numpy as np
import pandas as pd
import polars
import pyarrow.parquet as pq
import pytest
import pyvista as pv

FDEM = os.environ["FDEM"]
ROOT = pathlib.Path(__file__).resolve().parents[4]
BED = ROOT.parent / "shared/data/roundrobin/penetration/25KParticles.txt"


def contacts(folder, file, output, *options):
    """Runs the command; the result is the path of the output."""
    path = folder / output
    subprocess.run([FDEM, "contacts", file, "-q", "-o", path, *options], check=True)
    return path


@pytest.fixture(scope="module", params=["open 3D", "open 2D", "periodic 3D", "periodic 2D", "sheared 2D", "points", "none"])
def case(request, tmp_path_factory):
    """A packing with ids, options, and its couples as CSV."""
    folder = tmp_path_factory.mktemp("packing")
    random = np.random.default_rng(5)
    d = 2 if "2D" in request.param else 3
    n = 0 if request.param == "none" else 400
    positions = random.uniform(0, 6, (n, d))
    radii = random.uniform(0.2, 0.6, n)
    ids = random.permutation(n) + 1000
    table = pd.DataFrame(positions, columns=list("xyz")[:d])
    table["radius"] = radii
    table["id"] = ids
    options = []
    if n == 0:
        # No file without elements is read: two that are apart.
        table = pd.DataFrame({"x": [0.0, 9.0], "y": [0.0, 9.0], "z": 0.0, "radius": 1.0, "id": [1000, 1001]})
    if "periodic" in request.param:
        options = ["--periodic", "xyz"[:d], "--box", ",".join(["0,6"] * d)]
    if "sheared" in request.param:
        options = ["--periodic", "xy", "--edges", "6,0,2.5,6"]
    if request.param == "points":
        options = ["--cutoff", "0.8"]
    file = folder / "packing.csv"
    table.to_csv(file, index=False)
    csv = pd.read_csv(contacts(folder, file, "couples.csv", *options))
    edges = None
    if options and options[0] == "--periodic":
        edges = np.array([[6, 0], [2.5, 6]]) if "sheared" in request.param else np.eye(d) * 6
    return folder, file, options, table, csv, edges


def axes(table):
    return [name for name in "xyz" if name in table]


def test_parquet(case):
    folder, file, options, _, csv, _ = case
    path = contacts(folder, file, "couples.parquet", *options)
    by_polars = pd.DataFrame(polars.read_parquet(path).to_dict(as_series=False), columns=csv.columns)
    by_duckdb = pd.DataFrame(duckdb.read_parquet(str(path)).fetchnumpy())
    for frame in [by_polars, by_duckdb]:
        for name in csv:
            assert np.array_equal(frame[name], csv[name]), name
    for frame in [pd.read_parquet(path), pq.read_table(path).to_pandas()]:
        assert list(frame.columns) == list(csv.columns)
        assert frame["i"].dtype == np.int64 and frame["overlap"].dtype == np.float64
        for name in csv:
            assert np.array_equal(frame[name], csv[name]), name


def test_npy(case):
    folder, file, options, _, csv, _ = case
    records = np.load(contacts(folder, file, "couples.npy", *options))
    assert list(records.dtype.names) == list(csv.columns)
    for name in csv:
        assert np.array_equal(records[name], csv[name]), name


def test_npz(case):
    folder, file, options, table, csv, edges = case
    found = np.load(contacts(folder, file, "couples.npz", *options))
    assert np.array_equal(found["positions"], table[axes(table)])
    assert np.array_equal(found["ids"], table["id"])
    assert ("radii" in found) == ("--cutoff" not in options)
    if "radii" in found:
        assert np.array_equal(found["radii"], table["radius"])
    i, j, shift = found["i"], found["j"], found["shift"]
    assert np.array_equal(found["ids"][i], csv["i"]) and np.array_equal(found["ids"][j], csv["j"])
    assert np.array_equal(found["distance"], csv["distance"]) and np.array_equal(found["overlap"], csv["overlap"])
    assert shift.shape == (len(csv), len(axes(table))) and shift.dtype == np.int32
    displaced = found["positions"][j]
    if edges is None:
        assert "edges" not in found and not shift.any()
    else:
        assert np.array_equal(shift, csv[["sx", "sy", "sz"][: len(edges)]])
        assert np.array_equal(found["edges"], edges) and found["periodic"].all() and not found["origin"].any()
        displaced = displaced + shift @ edges
        assert shift.any()
    distance = np.linalg.norm(displaced - found["positions"][i], axis=1)
    assert np.allclose(distance, found["distance"], rtol=0, atol=1e-12)


def test_vtp(case):
    folder, file, options, table, csv, edges = case
    mesh = pv.read(contacts(folder, file, "couples.vtp", *options))
    n, d = len(table), len(axes(table))
    # pyvista makes cells of the points of a file that has none.
    assert (mesh.n_lines, mesh.n_cells) == (len(csv), len(csv) or n)
    assert np.array_equal(mesh.points[:n, :d], table[axes(table)])
    assert not mesh.points[:, d:].any()
    assert np.array_equal(mesh["id"][:n], table["id"])
    image = mesh["image"].astype(bool)
    assert not image[:n].any() and image[n:].all()
    if "--cutoff" not in options:
        assert np.array_equal(mesh["radius"][:n], table["radius"])
    if len(csv) == 0:
        return
    ends = mesh.lines.reshape(-1, 3)
    assert (ends[:, 0] == 2).all()
    i, j = ends[:, 1], ends[:, 2]
    assert np.array_equal(mesh["id"][i], csv["i"]) and np.array_equal(mesh["id"][j], csv["j"])
    assert np.array_equal(mesh["overlap"], csv["overlap"]) and np.array_equal(mesh["distance"], csv["distance"])
    # Lines are as long as the distance: also across a face.
    assert np.allclose(np.linalg.norm(mesh.points[i] - mesh.points[j], axis=1), csv["distance"], rtol=0, atol=1e-12)
    coordination = pd.concat([csv["i"], csv["j"]]).value_counts().reindex(table["id"], fill_value=0)
    assert np.array_equal(mesh["coordination"][:n], coordination)
    if edges is None:
        assert mesh.n_points == n and not mesh["shift"].any()
    else:
        assert np.array_equal(mesh["shift"][:, :d], csv[["sx", "sy", "sz"][:d]])
        assert image.sum() == mesh["shift"].any(axis=1).sum() > 0


@pytest.mark.parametrize("form", ["graphml", "json"])
def test_graphs(case, form):
    folder, file, options, table, csv, edges = case
    path = contacts(folder, file, f"couples.{form}", *options)
    if form == "graphml":
        graph = nx.read_graphml(path, node_type=int)
    else:
        graph = nx.node_link_graph(json.loads(path.read_text()), edges="edges")
        assert graph.is_multigraph() == (edges is not None)
    assert not graph.is_directed()
    assert sorted(graph) == sorted(table["id"])
    assert graph.number_of_edges() == len(csv)
    for _, row in table.iterrows():
        node = graph.nodes[int(row["id"])]
        assert [node[name] for name in axes(table)] == [row[name] for name in axes(table)]
        assert ("radius" in node) == ("--cutoff" not in options)
        assert node["coordination"] == graph.degree(int(row["id"]))
    names = [name for name in csv if name not in "ij"]
    rows = sorted((min(a, b), max(a, b), *(data[name] for name in names)) for a, b, data in graph.edges(data=True))
    expected = sorted((min(a, b), max(a, b), *rest) for a, b, *rest in csv[["i", "j", *names]].itertuples(index=False))
    assert rows == expected


def test_tables_of_meshes(tmp_path):
    file = ROOT / "examples/squares.msh"
    csv = pd.read_csv(contacts(tmp_path, file, "a.csv", "--body-table", tmp_path / "b.csv"))
    parquet = pd.read_parquet(contacts(tmp_path, file, "a.parquet", "--body-table", tmp_path / "b.parquet"))
    pd.testing.assert_frame_equal(csv, parquet, check_dtype=False)
    pd.testing.assert_frame_equal(pd.read_csv(tmp_path / "b.csv"), pd.read_parquet(tmp_path / "b.parquet"))
    archive = np.load(contacts(tmp_path, file, "a.npz"))
    assert [kind.decode() for kind in archive["kind"]] == list(csv["kind"])
    assert np.array_equal(archive["point"], csv[["x", "y"]])


def test_tables_of_images(tmp_path):
    file = ROOT / "examples/grains.npy"
    csv = pd.read_csv(contacts(tmp_path, file, "a.csv", "--labels"))
    parquet = pd.read_parquet(contacts(tmp_path, file, "a.parquet", "--labels"))
    assert parquet["faces"].dtype == np.uint64
    pd.testing.assert_frame_equal(csv, parquet, check_dtype=False)
    archive = np.load(contacts(tmp_path, file, "a.npz", "--labels"))
    assert np.array_equal(archive["normal"], csv[["nx", "ny", "nz"]])


@pytest.mark.skipif(not BED.exists(), reason="the bed is not there")
def test_bed_in_paraview(tmp_path):
    """25,000 spheres of the DEM round robin have 53,876 contacts, all of them lines."""
    mesh = pv.read(contacts(tmp_path, BED, "bed.vtp", "--skip-bad-lines"))
    assert (mesh.n_points, mesh.n_lines) == (25_000, 53_876)
    assert mesh["overlap"].max() == pytest.approx(9.0117e-7, rel=1e-4)
    assert mesh["coordination"].sum() == 2 * 53_876
    frame = pd.read_parquet(contacts(tmp_path, BED, "bed.parquet", "--skip-bad-lines"))
    assert len(frame) == 53_876


def test_a_series_is_one_table(tmp_path):
    frames = []
    for step in (500, 600, 700):
        rows = "".join(f"{k} {k * 0.9} 5 {step / 1000} 0.5\n" for k in range(1, 4 + step // 100))
        frames.append(
            f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{rows.count(chr(10))}\nITEM: BOX BOUNDS pp pp ff\n0 20\n0 20\n0 10\n"
            f"ITEM: ATOMS id x y z radius\n{rows}"
        )
    file = tmp_path / "run.dump"
    file.write_text("".join(frames))
    csv = pd.read_csv(contacts(tmp_path, file, "all.csv"))
    assert csv["frame"].nunique() == 3 and len(csv) > 20
    pd.testing.assert_frame_equal(pd.read_parquet(contacts(tmp_path, file, "all.parquet")), csv, check_dtype=False)
    array = np.load(contacts(tmp_path, file, "all.npy"))
    with np.load(contacts(tmp_path, file, "all.npz")) as archive:
        assert sorted(archive) == sorted(["frame", "step", "i", "j", "distance", "overlap", "shift"])
        for name in ("frame", "step", "i", "j", "distance", "overlap"):
            assert (archive[name] == csv[name]).all() and (array[name] == csv[name]).all()
        assert (archive["shift"] == csv[["sx", "sy", "sz"]].to_numpy()).all()
