"""``Contacts.analyse`` on lattices whose numbers are known, and against the command on one packing. The numbers themselves are tested in Rust."""

import json
import os
import subprocess

import numpy as np
import pytest
from conftest import ROOT

import fdem

LATTICES = {
    "sc": ([[0, 0, 0]], 0.5, 6, np.pi / 6),
    "bcc": ([[0, 0, 0], [0.5, 0.5, 0.5]], np.sqrt(3) / 4, 8, np.pi * np.sqrt(3) / 8),
    "fcc": ([[0, 0, 0], [0.5, 0.5, 0], [0.5, 0, 0.5], [0, 0.5, 0.5]], np.sqrt(2) / 4, 12, np.pi * np.sqrt(2) / 6),
}


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("name", LATTICES)
def test_lattices(name, dtype):
    base, radius, neighbours, fraction = LATTICES[name]
    cells = np.stack(np.meshgrid(*[np.arange(4)] * 3), axis=-1).reshape(-1, 1, 3)
    positions = (cells + np.array(base)).reshape(-1, 3).astype(dtype)
    found = fdem.contacts(positions, radius, box=[4, 4, 4], periodic=True, tolerance=1e-5)
    said = found.analyse(rdf=(1.5, 30))
    assert len(said.radial.g) == 30 and said.radial.r_max == 1.5
    assert said.coordination.mean == neighbours
    assert (said.coordination.of_each == found.coordination).all()
    assert said.coordination.distribution[neighbours] == len(positions)
    assert said.without_rattlers.rattlers == 0 and not said.without_rattlers.is_rattler.any()
    assert said.packing.fraction == pytest.approx(fraction, rel=1e-6)
    assert said.fabric.eigenvalues == pytest.approx([1 / 3] * 3, abs=1e-6)
    assert said.clusters.count == 1 and all(along.percolates for along in said.clusters.percolation)
    json.dumps(said.to_dict())


def test_options_and_what_each_element_is():
    chain = np.column_stack([np.arange(5.0), np.zeros(5)])
    found = fdem.contacts(np.vstack([chain, [[0, 9]]]), radii=0.5)
    said = found.analyse(min_contacts=1, inner=[[0, 4], [-0.25, 0.25]])
    assert said.without_rattlers.is_rattler.tolist() == [False] * 5 + [True]
    assert len(set(said.clusters.of_each[:5].tolist())) == 1 and said.clusters.of_each[5] != said.clusters.of_each[0]
    assert said.packing.region.tolist() == [[0, 4], [-0.25, 0.25]]
    assert said.clusters.percolation[0].percolates
    with pytest.raises(AttributeError, match="coordination, without_rattlers"):
        said.coordinaton  # noqa: B018


def test_what_cannot_be_analysed_is_said():
    with pytest.raises(ValueError, match="boxes have no centres"):
        fdem.boxes([[0, 0]], [[1, 1]]).analyse()
    found = fdem.contacts([[0.0, 0], [1, 0]], radii=0.5)
    with pytest.raises(ValueError, match=r"shape \[2, 2\]"):
        found.analyse(inner=[0, 1])
    with pytest.raises(ValueError, match="empty"):
        found.analyse(inner=[[0, 1], [2, 2]])


def test_the_command_says_the_same(tmp_path):
    packing = fdem.read(ROOT / "examples/packing.csv")
    said = fdem.contacts(packing.positions, packing.radii).analyse().to_dict()
    command = [os.environ.get("FDEM", "fdem"), "contacts", str(ROOT / "examples/packing.csv"), "--analyse", "--json", "s.json", "--quiet", "--count"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    told = json.loads((tmp_path / "s.json").read_text())["analysis"]
    for name, part in told.items():
        if name in ("coordination", "clusters"):
            for key, value in part.items():
                assert said[name][key] == value, (name, key)
    # Sums run in the order of the couples, which the command has sorted.
    assert said["fabric"]["eigenvalues"] == pytest.approx(told["fabric"]["eigenvalues"], rel=1e-12)
    assert said["packing"]["fraction"] == pytest.approx(told["packing"]["fraction"], rel=1e-12)
    assert said["overlaps"]["overlaps"]["mean"] == pytest.approx(told["overlaps"]["overlaps"]["mean"], rel=1e-12)


@pytest.mark.parametrize("dimensions", [2, 3])
def test_pictures_and_reports(dimensions, tmp_path, rng):
    found = fdem.contacts(rng.random((200, dimensions)) * 5, rng.uniform(0.2, 0.4, 200))
    for name, start in (("a.png", b"\x89PNG"), ("a.svg", b"<svg"), ("p.svg", b"<svg"), ("p.png", b"\x89PNG")):
        (found.plots if name.startswith("p") else found.picture)(tmp_path / name, title="two hundred")
        assert (tmp_path / name).read_bytes().startswith(start), name
    found.report(tmp_path / "r.html", title="two <hundred>")
    page = (tmp_path / "r.html").read_text(encoding="utf-8")
    assert page.startswith("<!DOCTYPE html>") and "two &lt;hundred&gt;" in page
    with pytest.raises(ValueError, match=r"end the name in \.png or \.svg"):
        found.picture(tmp_path / "a.jpg")
    with pytest.raises(OSError, match="no such folder.*none"):
        found.picture(tmp_path / "none" / "a.png")
    assert len(list(tmp_path.iterdir())) == 5


def test_voids_of_a_lattice():
    found = fdem.contacts([[0.5, 0.5, 0.5]], radii=0.5, box=[1, 1, 1], periodic=True)
    voids = found.analyse(voids=True).voids
    assert np.allclose(voids.of_each, 6 / np.pi - 1, rtol=1e-12) and voids.void_ratio.count == 1
    assert abs(voids.porosity - (1 - np.pi / 6)) < 2e-3 and 0.33 < voids.pores.max <= np.sqrt(0.75) - 0.5
    assert not hasattr(found.analyse(), "voids") or found.analyse().voids is None
