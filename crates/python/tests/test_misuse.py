"""Arguments and calls that are mistaken: each ends in an answer or in an exception that says what to do."""

from __future__ import annotations

import os
import pathlib
import subprocess
import sys
import textwrap
import threading
import warnings

import numpy as np
import pytest

import fdem

BAR = {"name": "bar", "material": "steel", "rectangle": {"min": [0, 0], "max": [1, 0.1]}, "mesh_size": 0.05}
STEEL = {"name": "steel", "density": 7800, "youngs_modulus": 210e9, "poissons_ratio": 0.3}


def simulation(threads: int = 1) -> fdem.Simulation:
    return fdem.Simulation(fdem.Model(model={"end_time": 1e-3, "gravity": "none"}, body=[BAR], material=[STEEL]), threads=threads)


def test_tables_and_lists_that_contain_themselves_are_refused() -> None:
    table: dict = {}
    table["again"] = table
    items: list = []
    items.append(items)
    deep: object = 1
    for _ in range(100_000):
        deep = [deep]
    for value in (table, items, deep, {"gravity": items}):
        with pytest.raises(ValueError, match="in each other: does one contain itself"):
            fdem.Model(model={"gravity": value})


def test_a_callback_that_advances_its_run_is_refused() -> None:
    plain, run = simulation(), simulation()
    plain.advance(3)
    with pytest.raises(RuntimeError, match="the callback of advance"):
        run.advance(10, callback=lambda run: run.advance(5) if run.steps == 3 else None)
    assert (run.steps, run.state_hash) == (3, plain.state_hash)
    plain.advance(7)
    run.advance(7)
    assert run.state_hash == plain.state_hash


def test_two_threads_that_advance_one_run_are_refused() -> None:
    run = simulation()
    inside, leave = threading.Event(), threading.Event()

    def callback(_: fdem.Simulation) -> None:
        inside.set()
        leave.wait(20)

    thread = threading.Thread(target=lambda: run.advance(1, callback=callback))
    thread.start()
    try:
        assert inside.wait(20)
        with pytest.raises(RuntimeError, match="in another thread"):
            run.advance(1)
    finally:
        leave.set()
        thread.join()
    assert run.steps == 1


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there are no forks")
@pytest.mark.parametrize("threads", [1, 3])
def test_a_run_in_a_forked_process_continues_or_is_refused(threads: int) -> None:
    program = f"""
        import os, signal, fdem
        from test_misuse import simulation
        run = simulation({threads})
        run.advance(50)
        child = os.fork()
        if child == 0:
            signal.alarm(20)
            try:
                run.advance(50)
            except RuntimeError as error:
                assert "a forked process has none of them" in str(error), error
                os._exit(3)
            os._exit(run.steps)
        print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
    """
    folder = pathlib.Path(__file__).parent
    run = subprocess.run([sys.executable, "-c", textwrap.dedent(program)], capture_output=True, text=True, timeout=60, cwd=folder)
    assert run.stdout == ("100\n" if threads == 1 else "3\n"), run.stderr


def test_contacts_takes_a_packing_and_names_a_path(tmp_path: pathlib.Path) -> None:
    path = tmp_path / "a.xyz"
    path.write_text('2\nLattice="6 0 0 0 6 0 0 0 6" Properties=pos:R:3:radius:R:1\n0.2 1 1 0.3\n5.7 1 1 0.3\n')
    packing = fdem.read(path, kind="packing")
    assert fdem.contacts(packing).shift.tolist() == [[-1, 0, 0]]
    assert len(fdem.contacts(packing, radii=0.2)) == 0
    assert len(fdem.contacts(packing, cutoff=0.5, box=[9, 9, 9], periodic=True)) == 0
    for name in (path, str(path)):
        with pytest.raises(TypeError, match="read the file first: fdem.read"):
            fdem.contacts(name)
    path.write_text("x,y\n0,0\n")
    with pytest.raises(TypeError, match="the packing has no radii"):
        fdem.contacts(fdem.read(path, kind="packing"))


def test_flat_packings_and_columns_that_may_be_an_axis_are_remarked(tmp_path: pathlib.Path) -> None:
    path = tmp_path / "a.xyz"
    path.write_text('2\nLattice="6 0 0 0 6 0 0 0 1" Properties=pos:R:3:radius:R:1\n1 1 0 0.5\n3 1 0 0.5\n')
    with pytest.warns(UserWarning, match="read in 2D, with x and y"):
        packing = fdem.read(path, kind="packing")
    assert packing.positions.tolist() == [[1, 1], [3, 1]]
    assert len(fdem.contacts(packing)) == 0

    path = tmp_path / "a.csv"
    path.write_text("x,y,zz,radius\n2,2,1,0.5\n2,2,8,0.5\n")
    with pytest.warns(UserWarning, match="column zz is not used: is it z"):
        fdem.read(path)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(fdem.contacts(fdem.read(path, kind="packing", columns="x,y,z,radius"))) == 0


def test_sets_and_cut_elements_of_a_mesh_are_there(tmp_path: pathlib.Path) -> None:
    path = tmp_path / "a.inp"
    path.write_text(
        "*Node\n1, 0, 0\n2, 1, 0\n3, 1, 1\n4, 0, 1\n*Element, type=CPS4, elset=all\n1, 1, 2, 3, 4\n*Nset, nset=base\n1, 2\n"
        "*Surface, name=roof\n1, S3\n"
    )
    mesh = fdem.read(path, kind="mesh")
    assert mesh.groups["base"]["nodes"].tolist() == [0, 1]
    assert sorted(mesh.groups["roof"]["edges"][0].tolist()) == [2, 3]
    assert mesh.notes == ["1 quadrilateral is cut into triangles"]


def test_own_images_are_worth_a_warning_for_radii_only() -> None:
    points = [[1.0, 1.0, 0.0], [3.0, 1.0, 0.1]]
    with pytest.warns(UserWarning, match="2 couples are of an element with its own image"):
        assert len(fdem.contacts(points, 0.5, box=[6, 6, 0.9], periodic=True)) == 2
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(fdem.contacts(points, cutoff=1.0, box=[6, 6, 0.9], periodic=True)) == 2


def test_left_handed_boxes_give_the_pairs_of_neighbor_list() -> None:
    points = np.array([[0.2, 1, 1], [5.7, 1, 1]])
    cell = np.array([[0, 6, 0], [6, 0, 0], [0, 0, 6.0]])
    found = fdem.contacts(points, cutoff=1.0, box=cell, periodic=True)
    i, j, shift = fdem.neighbor_list("ijS", positions=points, cell=cell, pbc=True, cutoff=1.0)
    assert found.pairs.tolist() == [[0, 1]] and found.shift.tolist() == [[0, -1, 0]]
    assert (i.tolist(), j.tolist(), shift.tolist()) == ([0, 1], [1, 0], [[0, -1, 0], [0, 1, 0]])


def test_a_pair_with_several_images_has_one_entry() -> None:
    pytest.importorskip("scipy")
    found = fdem.contacts([[0, 0, 0], [0.25, 0, 0], [5, 5, 5]], cutoff=0.75, box=[1, 9, 9], periodic=[True, False, False])
    assert len(found) == 2
    matrix = found.to_scipy()
    assert matrix[0, 1] == matrix[1, 0] == 0.25 and matrix.nnz == 2
    assert found.to_scipy("overlap")[0, 1] == 0.5
    assert found.to_scipy(None)[0, 1] == 1
    assert fdem.contacts(np.zeros((0, 3)), cutoff=1, box=[9, 9, 9], periodic=True).to_scipy().nnz == 0


@pytest.mark.parametrize("options", [{}, {"boxsize": 2.0}])
def test_pairs_within_any_distance(options: dict) -> None:
    points = np.array([[0.0, 0.0], [1.0, 1.0], [0.5, 0.0]])
    tree = fdem.KDTree(points, **options)
    for r in (np.inf, 1e300):
        assert tree.query_pairs(r) == {(0, 1), (0, 2), (1, 2)}
    with pytest.raises(ValueError):
        tree.query_pairs(float("nan"))
