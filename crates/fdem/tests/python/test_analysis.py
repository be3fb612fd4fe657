"""`fdem contacts --analyse` against numpy, scipy, networkx and freud.

FDEM=path/to/fdem pytest test_analysis.py
"""

import json
import os
import subprocess

import freud
import networkx as nx
import numpy as np
import pandas as pd
import pytest
import scipy.sparse as sp

FDEM = os.environ["FDEM"]
SIDE = 12.0


def analysed(folder, positions, radii, *options):
    """The analysis as JSON, and the couples."""
    table = pd.DataFrame(positions, columns=list("xyz")[: positions.shape[1]])
    table["radius"] = radii
    table.to_csv(folder / "packing.csv", index=False)
    command = [FDEM, "contacts", folder / "packing.csv", "--analyse", "--json", folder / "summary.json", "-q"]
    subprocess.run([*command, "-o", folder / "couples.npz", *options], check=True)
    return json.loads((folder / "summary.json").read_text())["analysis"], np.load(folder / "couples.npz")


@pytest.fixture(scope="module", params=[(2, ""), (3, ""), (2, "xy"), (3, "xyz"), (3, "xz")], ids=str)
def case(request, tmp_path_factory):
    d, periodic = request.param
    random = np.random.default_rng(d)
    n = 900
    positions = random.uniform(0, SIDE, (n, d))
    radii = random.uniform(0.2, 0.45 if d == 2 else 1.0, n)
    options = ["--tolerance", "0.05", "--rdf", "2,40"]
    if periodic:
        options += ["--periodic", periodic, "--box", ",".join([f"0,{SIDE}"] * d)]
    analysis, couples = analysed(tmp_path_factory.mktemp("packing"), positions, radii, *options)
    repeats = np.array([axis in periodic for axis in "xyz"[:d]])
    assert len(couples["i"]) > n
    return analysis, couples, positions, radii, repeats


def branches(couples, positions):
    return positions[couples["j"]] + couples["shift"] * SIDE - positions[couples["i"]]


def test_coordination(case):
    analysis, couples, positions, _, _ = case
    degrees = np.bincount(np.concatenate([couples["i"], couples["j"]]), minlength=len(positions))
    assert analysis["coordination"]["distribution"] == np.bincount(degrees).tolist()
    assert analysis["coordination"]["mean"] == pytest.approx(degrees.mean(), rel=1e-14)


def test_rattlers_are_what_is_outside_of_the_core(case):
    """Removing elements with fewer than k contacts repeatedly leaves the k-core."""
    analysis, couples, positions, _, _ = case

    def core(k):
        graph = nx.MultiGraph()
        graph.add_nodes_from(range(len(positions)))
        graph.add_edges_from(zip(couples["i"].tolist(), couples["j"].tolist()))
        while few := [node for node, degree in graph.degree() if degree < k]:
            graph.remove_nodes_from(few)
        return graph

    # More than half of the elements are lost without friction: it is taken to be there.
    k = positions.shape[1] + 1
    graph = core(k)
    found = analysis["without_rattlers"]
    if 2 * len(graph) < len(core(2)):
        assert found["frictionless"] == {"min_contacts": k, "elements": len(graph)}
        k, graph = 2, core(2)
    assert found["min_contacts"] == k
    assert (found["elements"], found["couples"]) == (len(graph), graph.number_of_edges())
    assert found["rattlers"] == len(positions) - len(graph)
    expected = np.bincount([degree for _, degree in graph.degree()]).tolist() if len(graph) else []
    assert found["distribution"] == expected


def test_fabric(case):
    analysis, couples, positions, _, _ = case
    normals = branches(couples, positions)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    tensor = np.einsum("ka,kb->ab", normals, normals) / len(normals)
    fabric = analysis["fabric"]
    assert np.allclose(fabric["tensor"], tensor, rtol=0, atol=1e-13)
    values, vectors = np.linalg.eigh(tensor)
    assert np.allclose(fabric["eigenvalues"], values[::-1], rtol=0, atol=1e-13)
    products = np.abs(np.sum(np.array(fabric["principal_directions"]) * vectors[:, ::-1].T, axis=1))
    assert np.allclose(products, 1, atol=1e-9)
    d = positions.shape[1]
    if d == 2:
        assert fabric["anisotropy"] == pytest.approx(2 * (values[1] - values[0]), abs=1e-12)
    else:
        a = 7.5 * (tensor - np.eye(3) / 3)
        assert fabric["anisotropy"] == pytest.approx(np.sqrt(1.5 * (a * a).sum()), abs=1e-12)


def test_directions(case):
    analysis, couples, positions, _, _ = case
    branch = branches(couples, positions)
    branch = np.concatenate([branch, -branch])
    branch /= np.linalg.norm(branch, axis=1)[:, None]
    found = analysis["directions"]
    sectors = np.round(np.arctan2(branch[:, 1], branch[:, 0]) / (2 * np.pi) * found["sectors"]).astype(int)
    cells = sectors % found["sectors"]
    if branch.shape[1] == 3:
        bands = np.minimum((branch[:, 2] + 1) / 2 * found["bands"], found["bands"] - 1).astype(int)
        cells += bands * found["sectors"]
    counts = np.bincount(cells, minlength=found["bands"] * found["sectors"])
    assert found["counts"] == counts.tolist()


def test_clusters(case):
    analysis, couples, positions, _, _ = case
    n = len(positions)
    matrix = sp.coo_array((np.ones(len(couples["i"])), (couples["i"], couples["j"])), shape=(n, n))
    count, labels = sp.csgraph.connected_components(matrix, directed=False)
    sizes = np.bincount(labels)
    found = analysis["clusters"]
    assert (found["count"], found["largest"]) == (count, sizes.max())
    each, how_many = np.unique(sizes, return_counts=True)
    expected = [{"elements": int(a), "clusters": int(b)} for a, b in zip(each, how_many)]
    assert found["sizes"] == expected


def test_percolation(case):
    """Around the box: a search from one element of each cluster meets an element again in another place. Else: both faces."""
    analysis, couples, positions, radii, repeats = case
    n, d = positions.shape
    neighbours = [[] for _ in range(n)]
    for i, j, shift in zip(couples["i"], couples["j"], couples["shift"]):
        neighbours[i].append((j, shift))
        neighbours[j].append((i, -shift))
    place = [None] * n
    winding = np.zeros(d, bool)
    spanning = np.zeros(d, bool)
    low, high = (positions - radii[:, None]).min(0), (positions + radii[:, None]).max(0)
    for start in range(n):
        if place[start] is not None:
            continue
        place[start] = np.zeros(d, int)
        cluster = [start]
        for element in cluster:
            for other, shift in neighbours[element]:
                there = place[element] + shift
                if place[other] is None:
                    place[other] = there
                    cluster.append(other)
                winding |= place[other] != there
        inside = positions[cluster], radii[cluster][:, None]
        spanning |= ((inside[0] - inside[1] <= low + radii.max()).any(0)) & (
            (inside[0] + inside[1] >= high - radii.max()).any(0)
        )
    found = analysis["clusters"]["percolation"]
    assert [along["periodic"] for along in found] == repeats.tolist()
    assert [along["percolates"] for along in found] == np.where(repeats, winding, spanning).tolist()


def test_overlaps(case):
    analysis, couples, _, radii, _ = case
    overlap = couples["overlap"]
    for name, lengths in [("overlaps", overlap[overlap >= 0]), ("gaps", -overlap[overlap < 0])]:
        found = analysis["overlaps"][name]
        assert found["count"] == len(lengths) > 0
        assert (found["min"], found["max"]) == (lengths.min(), lengths.max())
        assert found["mean"] == pytest.approx(lengths.mean(), rel=1e-12)
        counts, limits = np.histogram(lengths, 20, (0, lengths.max()))
        # numpy corrects what is next to a limit by a rounding; there is none here.
        assert found["histogram"]["counts"] == counts.tolist()
        assert found["histogram"]["width"] == pytest.approx(limits[1])
    assert analysis["overlaps"]["mean_radius"] == pytest.approx(radii.mean(), rel=1e-13)


def test_packing_fraction_by_points_of_a_grid(case):
    analysis, _, positions, radii, repeats = case
    found = analysis["packing"]
    region = np.array(found["region"])
    low, high = (positions - radii[:, None]).min(0), (positions + radii[:, None]).max(0)
    margin = 2 * radii.max()
    expected = np.where(repeats[:, None], [0, SIDE], np.stack([low + margin, high - margin], axis=1))
    assert np.allclose(region, expected, rtol=0, atol=1e-12)
    assert found["measure"] == pytest.approx(np.prod(region[:, 1] - region[:, 0]))
    d = len(region)
    if repeats.all():
        volumes = np.pi * radii**2 if d == 2 else 4 / 3 * np.pi * radii**3
        assert found["solid"] == pytest.approx(volumes.sum(), rel=1e-12)
        assert found["overlap_error"] == 0
        return
    points = np.random.default_rng(0).uniform(region[:, 0], region[:, 1], (100_000, d))
    inside = 0
    for centre, radius in zip(positions, radii):
        apart = points - centre
        apart -= np.where(repeats, SIDE * np.round(apart / SIDE), 0)
        inside += np.count_nonzero((apart**2).sum(1) < radius**2)
    # A point may be in several elements, which is one hit each.
    error = 5 * np.sqrt(inside * 4) / len(points)
    assert abs(found["fraction"] - inside / len(points)) < error


def test_radial_distribution(case):
    """By all distances; in boxes that repeat along every axis also by freud."""
    analysis, _, positions, _, repeats = case
    found = analysis["radial"]
    n, d = positions.shape
    apart = positions[:, None] - positions[None]
    apart -= np.where(repeats, SIDE * np.round(apart / SIDE), 0)
    distance = np.linalg.norm(apart, axis=2)
    np.fill_diagonal(distance, np.inf)
    low, high = positions.min(0) + 2, positions.max(0) - 2
    reference = (repeats | ((low <= positions) & (positions < high))).all(1)
    lengths = np.where(repeats, SIDE, high - low)
    counts, limits = np.histogram(distance[reference], 40, (0, 2))
    assert found["references"] == reference.sum()
    assert found["counts"] == counts.tolist()
    assert found["density"] == pytest.approx(reference.sum() / np.prod(lengths))
    shells = np.diff(np.pi * limits**2 if d == 2 else 4 / 3 * np.pi * limits**3)
    assert np.allclose(found["g"], counts / (reference.sum() * found["density"] * shells), rtol=1e-10)
    if repeats.all():
        box = freud.box.Box.square(SIDE) if d == 2 else freud.box.Box.cube(SIDE)
        padded = np.pad(positions - SIDE / 2, ((0, 0), (0, 3 - d)))
        rdf = freud.density.RDF(bins=40, r_max=2, normalization_mode="exact").compute((box, padded))
        # freud works in single precision: a distance next to a limit may be in the next bin.
        assert np.abs(rdf.bin_counts.astype(int) - counts).sum() <= 8
        assert np.allclose(rdf.bin_centers, found["r"], atol=1e-6)
        assert np.allclose(rdf.rdf[10:], np.array(found["g"])[10:], rtol=0.01)
