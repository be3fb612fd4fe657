"""Sweeps in Python, and the library of materials."""

import json
import subprocess
import sys
import textwrap
import threading
import time

import numpy as np
import pytest

import fdem

BAR = """
[parameters]
speed = 0.1
[model]
end_time = 1e-4
gravity = "none"
[[body]]
name = "bar"
material = "steel"
rectangle = { min = [0, 0], max = [1.0, 0.1] }
mesh_size = 0.1
[[material]]
name = "steel"
library = "steel"
[[boundary]]
name = "end"
body = "bar"
side = "right"
velocity = ["speed", 0]
[output]
frames = 1
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "bar.toml").write_text(BAR)
    monkeypatch.chdir(tmp_path)
    # No command can be found.
    monkeypatch.setenv("PATH", str(tmp_path))
    return tmp_path


def test_a_sweep_of_keywords_is_that_of_a_file(folder):
    grid = {"speed": np.array([0.1, 0.2]), "material.steel.density": [7850, "8 g/cm^3"]}
    found = fdem.sweep(model="bar.toml", grid=grid, output="swept", processes=2)
    assert repr(found) == "<fdem.Sweep: swept, 4 finished>"
    columns = found.columns
    assert columns["run"] == [1, 2, 3, 4]
    assert columns["material.steel.density"] == [7850.0, 7850.0, 8000.0, 8000.0]
    assert columns["speed"] == [0.1, 0.2, 0.1, 0.2]
    assert columns["status"] == ["finished"] * 4 and columns["message"] == [""] * 4
    kinetic = columns["energy kinetic"]
    assert 3.9 < kinetic[1] / kinetic[0] < 4.1, "twice the speed is four times the energy"

    model = fdem.Model.from_toml(BAR.replace("speed = 0.1", "speed = 0.2"))
    run = fdem.Simulation(model)
    run.advance()
    assert columns["state_hash"][1] == run.state_hash
    assert found.runs[1].summary["state_hash"] == run.state_hash
    assert set(found.runs[1].history) >= {"time", "kinetic"}

    (folder / "sweep.toml").write_text(
        'model = "bar.toml"\nfolder = "filed"\n[grid]\nmaterial.steel.density = [7850, "8 g/cm^3"]\nspeed = [0.1, 0.2]\n'
    )
    filed = fdem.sweep("sweep.toml", processes=1)
    assert filed.columns == columns and filed.path.resolve() == folder / "filed"
    assert fdem.Sweep("filed").columns == columns


def test_the_table_is_one_of_pandas(folder):
    pandas = pytest.importorskip("pandas")
    runs = pandas.DataFrame({"speed": [0.3, 0.1]})
    found = fdem.sweep(model=folder / "bar.toml", runs=runs, output="rows")
    assert list(found.table.index) == [1, 2] and list(found.table["speed"]) == [0.3, 0.1]
    assert found.table["energy kinetic"].dtype == np.float64
    assert "<table" in found._repr_html_()


def test_a_latin_hypercube_and_what_a_run_lacks(folder):
    cube = {"count": 2, "seed": 3, "ranges": {"speed": {"from": 0.1, "to": 0.3}}}
    found = fdem.sweep(model="bar.toml", latin_hypercube=cube)
    assert found.path.name == "sweep_results"
    low, high = sorted(found.columns["speed"])
    assert 0.1 <= low < 0.2 <= high < 0.3
    found = fdem.sweep(model="bar.toml", grid={"material.steel.density": [-1, 7850]}, output="skipped", skip_refused=True)
    assert found.columns["status"] == ["refused", "finished"]
    assert found.columns["time"][0] is None and "density" in found.columns["message"][0]
    assert found.runs[0] is None and found.runs[1] is not None


def test_what_is_wrong_is_told_and_nothing_runs(folder):
    with pytest.raises(ValueError, match="no parameter \"sped\".*did you mean \"speed\""):
        fdem.sweep(model="bar.toml", grid={"sped": [1]})
    with pytest.raises(ValueError, match="run 2 .* of 2 is refused"):
        fdem.sweep(model="bar.toml", grid={"material.steel.density": [1, -1]})
    with pytest.raises(ValueError, match="more than 3"):
        fdem.sweep(model="bar.toml", grid={"speed": [1, 2, 3, 4]}, max_runs=3)
    with pytest.raises(ValueError, match="has no values to run"):
        fdem.sweep(model="bar.toml")
    with pytest.raises(TypeError, match="give a sweep file"):
        fdem.sweep(grid={"speed": [1]})
    with pytest.raises(TypeError, match="no other keywords"):
        fdem.sweep("sweep.toml", model="bar.toml")
    with pytest.raises(TypeError, match="model.write"):
        fdem.sweep(model=fdem.Model.read("bar.toml"), grid={"speed": [1]})
    with pytest.raises(ValueError, match="has no sweep"):
        fdem.Sweep(folder)
    assert sorted(path.name for path in folder.iterdir()) == ["bar.toml"]
    fdem.sweep(model="bar.toml", runs=[{"speed": 0.1}])
    with pytest.raises(ValueError, match="has another sweep: the values of its runs are others"):
        fdem.sweep(model="bar.toml", runs=[{"speed": 0.2}])
    assert fdem.sweep(model="bar.toml", runs=[{"speed": 0.2}], force=True).columns["speed"] == [0.2]


def test_other_threads_run_meanwhile(folder):
    ticks = []
    done = threading.Event()

    def tick():
        while not done.wait(0.01):
            ticks.append(time.monotonic())

    thread = threading.Thread(target=tick)
    thread.start()
    start = time.monotonic()
    fdem.sweep(model="bar.toml", grid={"speed": [0.1, 0.2]}, output="threads")
    spent = time.monotonic() - start
    done.set()
    thread.join()
    assert len(ticks) > spent / 0.01 / 10


@pytest.mark.skipif(sys.platform == "win32", reason="there is no signal to send")
def test_ctrl_c_ends_a_sweep_that_goes_on_later(folder):
    (folder / "bar.toml").write_text(BAR.replace("end_time = 1e-4", "end_time = 0.5").replace("frames = 1", "frames = 1\ncheckpoint_steps = 100"))
    program = """
        import os, pathlib, signal, threading, time
        import fdem
        signal.signal(signal.SIGINT, signal.default_int_handler)
        def interrupt():
            while not pathlib.Path("long/runs/001/checkpoint").exists():
                time.sleep(0.01)
            time.sleep(0.5)
            os.kill(os.getpid(), signal.SIGINT)
        threading.Thread(target=interrupt, daemon=True).start()
        try:
            fdem.sweep(model="bar.toml", runs=[{"speed": 0.1}, {"speed": 0.2}], output="long", processes=1)
        except KeyboardInterrupt:
            print(fdem.Sweep("long").columns["status"])
    """
    run = subprocess.run([sys.executable, "-c", textwrap.dedent(program)], capture_output=True, text=True, timeout=120)
    assert run.returncode == 0, run.stderr
    assert run.stdout == "['interrupted', 'waiting']\n"
    assert json.loads((folder / "long/runs/001/run.json").read_text())["status"] == "interrupted"


def test_the_library_of_materials():
    granite = fdem.material("granite")
    with pytest.raises(ValueError, match="no material 'cheese': it has granite, basalt, .*steel.*ice"):
        fdem.material("cheese")
    body = {"name": "block", "material": "rock", "rectangle": {"min": [0, 0], "max": [0.2, 0.1]}, "mesh_size": 0.05}
    short = fdem.Model(model={"end_time": 1e-4}, body=[body], material=[{"name": "rock", "library": "granite"}])
    whole = fdem.Model(model={"end_time": 1e-4}, body=[body], material=[{"name": "rock", **granite}])
    assert short.hash == whole.hash
    hashes = []
    for model in (short, whole):
        run = fdem.Simulation(model)
        run.advance(20)
        hashes.append(run.state_hash)
    assert hashes[0] == hashes[1]
    with pytest.raises(ValueError, match="did you mean \"granite\""):
        fdem.Model(model={"end_time": 1e-4}, body=[body], material=[{"name": "rock", "library": "granit"}])
