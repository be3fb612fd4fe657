"""Simulations in Python: models, runs, what is set between steps, saved runs, folders of results."""

import json
import os
import subprocess
import sys
import textwrap
import threading
import time

import numpy as np
import pytest
from conftest import ROOT

import fdem

STEEL = {"name": "steel", "density": 7800, "youngs_modulus": 210e9, "poissons_ratio": 0.3}
ROCK = {
    "name": "rock",
    "density": 2700,
    "youngs_modulus": 30e9,
    "poissons_ratio": 0.2,
    "damping": 0.1,
    "friction": 0.5,
    "tensile_strength": 2.5e6,
    "cohesion": 7.5e6,
    "friction_angle": 30,
    "fracture_energy_i": 2.5,
    "fracture_energy_ii": 12.5,
}
# A plate with a notch that is torn apart.
TORN = {
    "model": {"end_time": 4e-4, "gravity": "none"},
    "body": [
        {
            "name": "plate",
            "material": "rock",
            "polygon": {"points": [[0, -0.03], [0.04, -0.03], [0.04, 0.03], [0, 0.03], [0, 0.001], [0.01, 0], [0, -0.001]]},
            "mesh_size": 4e-3,
        }
    ],
    "material": [ROCK],
    "boundary": [
        {"name": "lower end", "body": "plate", "side": "bottom", "velocity": [0.2, -0.2], "ramp": 2e-5},
        {"name": "upper end", "body": "plate", "side": "top", "velocity": [-0.2, 0.2], "ramp": 2e-5},
    ],
    "output": {"frames": 4},
}
IN_SPACE = {
    "model": {"end_time": 1e-4},
    "body": [{"name": "block", "material": "steel", "box": {"min": [0, 0, 0], "max": [0.1, 0.1, 0.2]}, "mesh_size": 0.05, "velocity": [0, 0, -1.0]}],
    "material": [STEEL],
}


def bar(**more):
    body = {"name": "bar", "material": "steel", "rectangle": {"min": [0, 0], "max": [1.0, 0.1]}, "mesh_size": 0.05}
    wall = {"name": "wall", "body": "bar", "side": "left", "velocity": [0, 0]}
    return fdem.Model(model={"end_time": 1e-3, "gravity": "none"}, body=[body], material=[STEEL], boundary=[wall], **more)


def run_of_command(command, place, name, tables, *options):
    """Writes a model file and runs it. Returns the folder of results, beside it."""
    fdem.Model(**tables).write(place / f"{name}.toml")
    subprocess.run([command, "run", f"{name}.toml", "--output", name, "--quiet", *options], cwd=place, check=True, capture_output=True)
    return place / name


@pytest.fixture(scope="module")
def torn(command, tmp_path_factory):
    """The folder of a run of the command, and the model file."""
    return run_of_command(command, tmp_path_factory.mktemp("torn"), "torn", TORN)


# Two bars end to end that are squeezed by a servo; then one of them vanishes; then the other is pulled until it has moved.
STAGED = {
    "model": {"end_time": 2e-3, "gravity": "none", "local_damping": 0.2},
    "body": [
        {"name": "left", "material": "steel", "rectangle": {"min": [0, 0], "max": [0.5, 0.1]}, "mesh_size": 0.05},
        {"name": "right", "material": "steel", "rectangle": {"min": [0.5, 0], "max": [1.0, 0.1]}, "mesh_size": 0.05},
    ],
    "material": [STEEL],
    "boundary": [
        {"name": "wall", "body": "left", "side": "left", "velocity": [0, 0]},
        {"name": "platen", "body": "right", "side": "right", "velocity": [-0.5, "free"], "servo": {"column": "platen fx", "target": "-200 kN"}, "stages": ["squeeze"]},
        {"name": "pull", "body": "left", "side": "top", "traction": [1e6, 0], "ramp": 1e-4, "stages": ["pull"]},
    ],
    "history": [{"name": "platen", "force": "platen"}, {"name": "corner", "body": "left", "node": [0.5, 0.0]}],
    "stage": [
        {"name": "squeeze", "duration": 8e-4},
        {"name": "dig", "excavate": ["right"], "release": 1e-4, "equilibrium": 1e-2, "duration": 4e-4},
        {"name": "pull", "until": {"column": "corner ux", "above": 1e-6}},
    ],
    "output": {"frames": 4, "history_interval": 1e-5},
}


@pytest.fixture(scope="module")
def staged(command, tmp_path_factory):
    """A folder of `fdem run` of a model with stages, a servo and a condition."""
    return run_of_command(command, tmp_path_factory.mktemp("staged"), "staged", STAGED)


def test_stages_servos_and_conditions_act_as_in_the_command(staged, tmp_path):
    summary = json.loads((staged / "run.json").read_text())
    model = fdem.Model(**STAGED)
    run = fdem.Simulation(model, threads=2)
    assert run.stage == "squeeze"
    before = len(run.elements)
    seen = []
    run.advance(until=9e-4, callback=lambda now: seen.append(now.stage), every=10)
    assert run.stage == "dig"
    assert set(seen) == {"squeeze", "dig"}
    assert len(run.elements) < before
    with pytest.raises(ValueError, match="there is no boundary 'platen': 'wall'"):
        run.set_boundary("platen", factor=0.0)
    run.save(tmp_path / "dug")
    again = fdem.resume(tmp_path / "dug", threads=1)
    assert again.stage == "dig"
    for steps in (1, 17):
        again.advance(steps)
    for each in (run, again):
        each.advance()
        assert each.is_over
        assert each.stage == "pull"
        assert each.steps == summary["steps"] < STAGED["model"]["end_time"] / each.time_step
        assert each.state_hash == summary["state_hash"]
        assert "corner ux" in each.log[-1]
        each.advance()
        with pytest.raises(RuntimeError, match="the run is over at step"):
            each.advance(1)
    assert fdem.resume(staged).is_over


def test_a_run_begins_with_the_end_of_another(command, staged, tmp_path):
    model = {name: value for name, value in STAGED.items() if name not in ("stage", "history", "boundary", "body")}
    model |= {"body": STAGED["body"][:1], "boundary": STAGED["boundary"][:1]}
    later = run_of_command(command, tmp_path, "later", model, "--from", staged)
    summary = json.loads((later / "run.json").read_text())
    run = fdem.Simulation(fdem.Model(**model), earlier=staged)
    assert run.steps > 0
    assert "begins with" in run.log[0]
    assert "pull" in " ".join(run.log)
    run.advance(5)
    run.save(tmp_path / "saved")
    for each in (run, fdem.resume(tmp_path / "saved")):
        each.advance()
        assert each.state_hash == summary["state_hash"]
    with pytest.raises(ValueError, match="nothing"):
        fdem.Simulation(fdem.Model(**model), earlier=tmp_path / "nothing")


def test_the_command_a_file_and_python_give_the_same_state(torn):
    summary = json.loads((torn / "run.json").read_text())
    assert summary["broken_joints"] > 3
    built, read = fdem.Model(**TORN), fdem.Model.read(torn.parent / "torn.toml")
    assert built.hash == read.hash == summary["model_hash"]
    for model, threads, parts in ((built, 2, []), (read, 1, [17, 100])):
        run = fdem.Simulation(model, threads=threads)
        for steps in parts:
            run.advance(steps)
        run.advance()
        assert run.steps == summary["steps"]
        assert run.time == summary["time"]
        assert run.counts["broken_joints"] == summary["broken_joints"]
        assert run.energies == summary["energies"]
        assert run.state_hash == summary["state_hash"]


@pytest.mark.parametrize("tables", [TORN, IN_SPACE], ids=["plane", "space"])
def test_arrays_of_the_state(tables):
    run = fdem.Simulation(fdem.Model(**tables), threads=1)
    run.advance()
    d, n = run.dimensions, run.counts["nodes"]
    elements = run.counts["elements"]
    for array in (run.positions, run.displacements, run.velocities, run.reactions):
        assert array.shape == (n, d) and array.dtype == np.float64
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0] = 1.0
    assert run.positions is run.positions, "made once for each state"
    assert run.elements.shape == (elements, d + 1) and run.elements.max() < n
    assert run.stress.shape == (elements, 6)
    for array in (run.damage, run.bodies, run.materials, run.fragments):
        assert array.shape == (elements,)
    joints = run.joints
    assert joints["corners"].shape == (len(joints["damage"]), d, d)
    assert len(run.cracks["mode"]) == run.counts["broken_joints"] == joints["broken"].sum()
    assert np.isnan(joints["time"][~joints["broken"]]).all()
    assert set(run.contacts) == {"elements", "point", "force", "normal", "tangential"}
    assert run.contacts["force"].shape == (len(run.contacts["elements"]), d)
    assert set(run.boundary_forces) == {table["name"] for table in tables.get("boundary", [])}
    before = run.positions
    copy = before.copy()
    run.advance(5)
    assert run.positions is not before
    np.testing.assert_array_equal(before, copy)


def test_steps_and_times():
    run = fdem.Simulation(bar(), threads=1)
    run.advance(10)
    run.advance(time=9.5 * run.time_step)
    assert run.steps == 20
    run.advance(until=25 * run.time_step * 0.999)
    assert run.steps == 25
    run.advance(until=1e-9)
    run.advance(0)
    assert run.steps == 25
    run.advance()
    assert run.time >= run.end_time > run.time - run.time_step
    for wrong in ({"steps": 1, "time": 1.0}, {"steps": -1}, {"time": np.nan}, {"until": np.inf}, {"steps": 1, "every": 0}):
        with pytest.raises(ValueError):
            run.advance(**wrong)


def test_errors_are_those_of_the_command(command, tmp_path):
    text = fdem.Model(**TORN).to_toml().replace("density", "densty").replace('"plate"\nside', '"plat"\nside')
    (tmp_path / "wrong.toml").write_text(text)
    said = subprocess.run([command, "check", "wrong.toml"], cwd=tmp_path, capture_output=True, text=True)
    assert said.returncode == 2
    before = os.getcwd()
    os.chdir(tmp_path)
    try:
        with pytest.raises(ValueError) as raised:
            fdem.Model.read("wrong.toml")
    finally:
        os.chdir(before)
    assert said.stderr.strip() == f"error: {raised.value}"
    assert 'did you mean "density"' in str(raised.value)
    with pytest.raises(ValueError, match="model has 1 error"):
        fdem.Model(model={"end_time": -1.0}, body=TORN["body"], material=TORN["material"])
    with pytest.raises(TypeError, match=r"body\[0\]\.name: a model has no values of"):
        fdem.Model(body=[{"name": object()}])
    with pytest.raises(ValueError, match="cannot read nothing.toml"):
        fdem.Model.read("nothing.toml")


def test_values_of_numpy_and_paths_are_those_of_python():
    plain = fdem.Model(**TORN)
    tables = dict(TORN, body=({**TORN["body"][0], "mesh_size": np.float64(4e-3), "polygon": {"points": np.array(TORN["body"][0]["polygon"]["points"])}, "seed": None},))
    assert fdem.Model(**tables).hash == plain.hash
    assert fdem.Model.from_toml(plain.to_toml()).hash == plain.hash


def test_a_callback_loads_with_its_work_in_the_account():
    run = fdem.Simulation(bar(), threads=1)
    right = run.positions[:, 0] > 1 - 1e-9
    called = []

    def pull(seen):
        assert seen is run
        called.append(seen.steps)
        seen.set_forces(right, [1e5 * np.sin(seen.time / 1e-4), 0.0])

    run.advance(95, callback=pull, every=10)
    run.advance(205, callback=pull, every=10)
    assert called == list(range(0, 300, 10))
    energies = run.energies
    assert energies["external"] > 1e-3
    assert abs(energies["error"]) < 1e-3
    # The same calls, divided in another way.
    again = fdem.Simulation(bar(), threads=2)
    again.advance(300, callback=lambda seen: seen.set_forces(right, [1e5 * np.sin(seen.time / 1e-4), 0.0]), every=10)
    assert again.state_hash == run.state_hash
    run.clear_forces()
    run.advance(1)
    assert not run.reactions[right].any()


def test_velocities_and_factors():
    run = fdem.Simulation(bar(), threads=1)
    run.set_velocities(np.arange(len(run.positions)), [0.0, 1.0])
    run.advance(1)
    energies = run.energies
    assert energies["external"] == pytest.approx(energies["kinetic"], rel=1e-2)
    assert energies["kinetic"] == pytest.approx(0.5 * 7800 * 0.1, rel=0.1)
    torn = fdem.Simulation(fdem.Model(**TORN), threads=1)
    torn.set_boundary("upper end", factor=0.0)
    torn.advance(50)
    top = torn.positions[:, 1] > 0.0299
    assert not torn.velocities[top].any()
    torn.set_boundary("upper end", factor=None)
    torn.advance(1)
    assert torn.velocities[top].any()
    before = torn.state_hash
    for wrong, message in (
        (lambda: torn.set_boundary("left end", factor=1.0), "there is no boundary 'left end': 'lower end', 'upper end'"),
        (lambda: torn.set_boundary("upper end", factor=np.nan), "must be a number"),
        (lambda: torn.set_forces([100_000], [[0.0, 0.0]]), "there is no node 100000"),
        (lambda: torn.set_forces([0, -1], [0.0, 0.0]), "whole numbers from 0 on"),
        (lambda: torn.set_forces([0.5], [0.0, 0.0]), "whole numbers from 0 on"),
        (lambda: torn.set_forces([True], [0.0, 0.0]), "a mask of nodes has"),
        (lambda: torn.set_velocities([0], [0.0, 0.0, 0.0]), "one vector of 2 components"),
        (lambda: torn.set_velocities([0], [np.nan, 0.0]), "must be a number"),
        (lambda: torn.set_velocities([0], [1e7, 0.0]), "at most ten times the speed of waves"),
    ):
        with pytest.raises(ValueError, match=message):
            wrong()
    assert torn.state_hash == before


def test_a_run_that_stops_says_why_and_can_be_read():
    run = fdem.Simulation(bar(), threads=1)
    run.set_forces([0, 5, 9], [1e15, -1e15])
    with pytest.raises(RuntimeError, match="^step "):
        run.advance(200)
    assert np.isfinite(run.time) and len(run.positions) == run.counts["nodes"]


def test_an_exception_in_a_callback_leaves_the_run_at_its_step():
    run = fdem.Simulation(bar(), threads=1)

    def fail(seen):
        if seen.steps == 20:
            raise KeyError("enough")

    with pytest.raises(KeyError, match="enough"):
        run.advance(100, callback=fail, every=5)
    assert run.steps == 20
    run.advance(5)
    assert run.steps == 25


@pytest.mark.parametrize("tables", [TORN, IN_SPACE], ids=["plane", "space"])
def test_a_saved_run_goes_on_with_the_same_bits(tables, tmp_path):
    whole = fdem.Simulation(fdem.Model(**tables), threads=2)
    whole.advance(40)
    whole.set_forces([0, 1], np.full(whole.dimensions, 50.0))
    whole.set_velocities([3], np.full(whole.dimensions, 0.1))
    whole.save(tmp_path / "half.run")
    resumed = fdem.resume(tmp_path / "half.run", threads=1)
    assert resumed.model == whole.model
    for run in (whole, resumed):
        run.advance(200)
    assert resumed.state_hash == whole.state_hash
    with pytest.raises(ValueError, match="is no run that this version of fdem has saved"):
        (tmp_path / "other").write_text("other")
        fdem.resume(tmp_path / "other")
    with pytest.raises(ValueError, match="cannot read"):
        fdem.resume(tmp_path / "nothing")
    with pytest.raises(OSError, match="cannot write"):
        whole.save(tmp_path / "nowhere" / "half.run")


def test_the_checkpoint_of_a_folder_is_resumed(torn):
    run = fdem.resume(torn)
    summary = fdem.results(torn).summary
    assert (run.steps, run.state_hash) == (summary["steps"], summary["state_hash"])
    run.advance(10)
    assert fdem.results(torn).summary == summary
    with pytest.raises(ValueError, match="has no run"):
        fdem.resume(torn.parent)


def test_columns_of_a_history_have_the_names_of_model_files(staged):
    """With their units or without."""
    history = fdem.results(staged).history
    full = next(name for name in history if name.startswith("platen f"))
    short = full.rpartition(" [")[0]
    assert full.endswith(" [N]") and history[short] is history[full]
    assert short in history and history.get(short) is history[full] and history.get("platen") is None
    with pytest.raises(KeyError, match="no column 'platen force': there is platen"):
        history["platen force"]


def test_results_of_a_folder(torn):
    found = fdem.results(torn)
    assert found.status == "finished"
    history = found.history
    assert history["time"][0] == 0.0 and history["step"][-1] == found.summary["steps"]
    assert history["kinetic"][-1] == found.summary["energies"]["kinetic"]
    assert len(found.frames) == found.summary["output"]["frames"]
    first, last = found.frames[0], found.frames[-1]
    assert [first.time, last.time] == [found.frames.times[0], found.frames.times[-1]]
    run = fdem.Simulation(found.model, threads=1)
    np.testing.assert_array_equal(first.positions[:, :2], run.positions)
    run.advance()
    np.testing.assert_array_equal(last.positions[:, :2], run.positions)
    np.testing.assert_array_equal(last.elements, run.elements)
    np.testing.assert_array_equal(last.nodes["velocity"][:, :2], run.velocities)
    np.testing.assert_array_equal(last.cells["stress"], run.stress)
    np.testing.assert_array_equal(last.cells["fragment"], run.fragments)
    # The files have the fields of the table, but for those of liquids; pictures have two more that are parts of one.
    assert set(last.nodes) == {field.key for field in fdem.fields("node")} - {"pore_pressure"}
    assert set(last.cells) == {field.key for field in fdem.fields("element")} - {
        "max_principal",
        "min_principal",
        "fluid_pressure",
    }
    np.testing.assert_array_equal(last.cracks["elements"], run.cracks["elements"])
    np.testing.assert_array_equal(last.contacts["elements"].reshape(-1, 2), run.contacts["elements"])
    assert found.frames[1:].times.tolist() == found.frames.times[1:].tolist()
    pandas = pytest.importorskip("pandas")
    table = found.frame()
    assert isinstance(table, pandas.DataFrame) and table.index.name == "time"
    assert "finished" in found._repr_html_() and "data:image/png;base64," in found._repr_html_()
    assert found.picture.png.startswith(b"\x89PNG")
    assert found.plot(found.plots[0]).png.startswith(b"\x89PNG")
    with pytest.raises(ValueError, match="there is no plot 'nothing'"):
        found.plot("nothing")
    with pytest.raises(ValueError, match="has no run"):
        fdem.results(torn.parent)


@pytest.mark.parametrize("tables", [TORN, IN_SPACE], ids=["plane", "space"])
def test_pictures_of_a_run(tables, tmp_path):
    run = fdem.Simulation(fdem.Model(**tables), threads=1)
    run.advance(20)
    picture = run.picture("von_mises", width=500)
    assert picture._repr_png_() == picture.png
    picture.save(tmp_path / "now.png")
    assert (tmp_path / "now.png").read_bytes().startswith(b"\x89PNG")
    assert int.from_bytes(picture.png[16:20], "big") == 500
    assert run._repr_png_().startswith(b"\x89PNG")
    with pytest.raises(ValueError, match="there is no field 'heat': max_principal, min_principal"):
        run.picture("heat")


@pytest.mark.parametrize("tables", [TORN, IN_SPACE], ids=["plane", "space"])
def test_every_field_of_the_table_is_an_array(tables):
    run = fdem.Simulation(fdem.Model(**tables), threads=1)
    run.advance()
    rows = {"node": len(run.positions), "element": len(run.elements), "joint": len(run.joints["damage"]), "contact": len(run.contacts["elements"])}
    rows |= {"sphere": 0, "sphere contact": 0, "wall": 0}
    for field in fdem.fields():
        if field.dimensions not in (None, run.dimensions):
            with pytest.raises(ValueError, match=f"there is no field '{field.key}' at"):
                run.field(field.key, at=field.at)
            continue
        values = run.field(field.key, at=field.at)
        assert values.shape == ((rows[field.at], len(field.components)) if field.components else (rows[field.at],)), field
        least, most = field.span
        assert np.all(np.isnan(values) | (least <= values) & (values <= most)), field
        assert not values.flags.writeable and run.field(field.key, at=field.at) is values
        if field.drawn:
            assert run.picture(field.key, width=300).png.startswith(b"\x89PNG")
    np.testing.assert_array_equal(run.field("velocity")[:, : run.dimensions], run.velocities)
    np.testing.assert_array_equal(run.field("stress"), run.stress)
    np.testing.assert_array_equal(run.field("damage"), run.damage)
    np.testing.assert_array_equal(run.field("damage", at="joint"), run.joints["damage"])
    np.testing.assert_array_equal(run.field("reaction")[:, : run.dimensions], run.reactions)
    deviator = run.stress[:, :3] - run.stress[:, :3].mean(axis=1)[:, None]
    mises = np.sqrt(1.5 * ((deviator**2).sum(axis=1) + 2 * (run.stress[:, 3:] ** 2).sum(axis=1)))
    np.testing.assert_allclose(run.field("von_mises"), mises, rtol=1e-9, atol=1e-3)
    with pytest.raises(ValueError, match="there is no field 'heat': displacement, velocity"):
        run.field("heat")
    with pytest.raises(ValueError, match="there is no field 'damage' at \"node\": displacement, velocity, reaction"):
        run.field("damage", at="node")
    with pytest.raises(ValueError, match="at must be one of 'node', 'element', 'joint', 'contact', 'sphere', 'sphere contact', 'wall', not 'edge'"):
        fdem.fields("edge")


@pytest.mark.skipif(sys.platform == "win32", reason="a process cannot send itself Ctrl-C there")
def test_ctrl_c_ends_a_run_after_a_step():
    program = """
        import threading, os, signal, time
        import fdem
        signal.signal(signal.SIGINT, signal.default_int_handler)
        body = {"name": "bar", "material": "steel", "rectangle": {"min": [0, 0], "max": [1.0, 0.1]}, "mesh_size": 0.02}
        steel = {"name": "steel", "density": 7800, "youngs_modulus": 210e9, "poissons_ratio": 0.3}
        run = fdem.Simulation(fdem.Model(model={"end_time": 1e3}, body=[body], material=[steel]))
        def interrupt():
            time.sleep(0.5)
            os.kill(os.getpid(), signal.SIGINT)
        threading.Thread(target=interrupt, daemon=True).start()
        try:
            run.advance()
        except KeyboardInterrupt:
            steps = run.steps
            again = fdem.Simulation(fdem.Model.from_toml(run.model), threads=1)
            again.advance(steps)
            assert again.state_hash == run.state_hash
            run.advance(10)
            assert run.steps == steps + 10 > 10
            print("interrupted")
    """
    run = subprocess.run([sys.executable, "-c", textwrap.dedent(program)], capture_output=True, text=True, timeout=120)
    assert run.returncode == 0, run.stderr
    assert run.stdout == "interrupted\n"


def test_other_threads_run_meanwhile():
    run = fdem.Simulation(bar(), threads=1)
    ticks, done = [], threading.Event()

    def tick():
        while not done.is_set():
            ticks.append(time.perf_counter())
            time.sleep(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    begin = time.perf_counter()
    run.advance(3000)
    end = time.perf_counter()
    done.set()
    thread.join()
    assert sum(begin < moment < end for moment in ticks) > 3


def test_spheres_of_a_callback():
    """A program lets spheres fall, one in a hundred steps; the balance has their energy."""
    sand = {"name": "sand", "material": "steel", "at": [[0, 0, 0.2]], "radius": 0.03}
    floor = {"name": "floor", "material": "steel", "plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}}
    model = fdem.Model(model={"end_time": 1.0, "gravity": [0, 0, -9.81]}, material=[STEEL | {"restitution": 0.5}], grains=[sand], wall=[floor])
    run = fdem.Simulation(model)
    numbers = []

    def rain(run):
        if 0 < run.steps <= 300:
            numbers.extend(run.add_spheres([[0.2 * run.steps / 100, 0, 0.3]], 0.04, velocities=[0, 0, -1.0]).tolist())

    run.advance(400, callback=rain, every=100)
    spheres = run.spheres
    assert numbers == [1, 2, 3] and spheres.numbers.tolist() == [0, 1, 2, 3]
    assert spheres.radii.tolist() == [0.03, 0.04, 0.04, 0.04] and spheres.group_names == ("sand",)
    assert spheres.velocities[1:, 2] == pytest.approx([-1.0] * 3, rel=0.1)
    # The velocity counts half a step earlier: g dt / v.
    assert abs(run.energies["error"]) < 1e-4
    hash_before = run.state_hash
    for places, message in [
        ([[5, 5, 1.0], [0.0, 0, 0.2]], "sphere 1 of those to add overlaps"),
        ([[5, 5, 0.01]], "sphere 0 of those to add overlaps"),
        ([[5, 5, np.nan]], "a coordinate"),
        ([1.0, 2.0, 3.0], "one vector of 2 or 3 components for each sphere"),
    ]:
        with pytest.raises(ValueError, match=message):
            run.add_spheres(places, 0.04)
    with pytest.raises(ValueError, match="time step, s, is .* at least a quarter of that of the run"):
        run.add_spheres([[5, 5, 5]], 0.002)
    with pytest.raises(ValueError, match="there is no group 'gravel': sand"):
        run.add_spheres([[5, 5, 5]], 0.04, group="gravel")
    assert run.state_hash == hash_before


def falling(count, **more):
    """A column of spheres above a floor."""
    sand = {"name": "sand", "material": "steel", "at": [[0, 0, 0.0999 + 0.1999 * k] for k in range(count)], "radius": 0.1}
    floor = {"name": "floor", "material": "steel", "plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}}
    settings = {"end_time": 1.0, "gravity": [0, 0, -9.81], "time_step": 5e-5}
    return fdem.Model(model=settings | more, material=[STEEL | {"youngs_modulus": 1e7, "restitution": 0.5}], grains=[sand], wall=[floor])


def test_laws_of_spheres_are_functions(tmp_path):
    """A spring and a dashpot in place of Hertz's law keep up a column; their memory counts the steps."""
    seen = []

    def law(pairs):
        pairs.memory[:, 0] += 1
        seen.append((len(pairs), float(pairs.memory.sum())))
        along = np.einsum("ij,ij->i", pairs.velocities, pairs.normals)
        size = 1e7 * np.maximum(pairs.overlaps, 0) - 3e4 * along * (pairs.overlaps > 0)
        assert (pairs.spheres[:, 0] < pairs.spheres[:, 1]).all() and pairs.spins.shape == (len(pairs), 2, 3)
        return size[:, None] * pairs.normals, np.zeros((len(pairs), 3))

    run = fdem.Simulation(falling(3))
    run.set_sphere_law(law, reach=0.01, memory=1, replace=True)
    run.advance(18000)
    assert seen[0] == (2, 2.0) and seen[-1] == (2, 36000.0) and len(seen) == 18000
    spheres, mass = run.spheres, 7800 * 4 / 3 * np.pi * 0.1**3
    between = [force for kind, force in zip(spheres.contacts["kind"], spheres.contacts["normal"]) if kind == 0]
    assert between == pytest.approx([2 * 9.81 * mass, 9.81 * mass], rel=1e-2)
    assert abs(run.energies["error"]) < 1e-3
    with pytest.raises(ValueError, match="read-only"):
        run.spheres.positions[0] = 0

    run.save(tmp_path / "half")
    again = fdem.resume(tmp_path / "half", threads=2)
    with pytest.raises(RuntimeError, match="has a law of a program: set it again"):
        again.advance(1)
    with pytest.raises(ValueError, match="1 columns of memory"):
        again.set_sphere_law(law, reach=0.01, memory=2, replace=True)
    again.set_sphere_law(law, reach=0.01, memory=1, replace=True)
    again.advance(50)
    run.advance(50)
    assert again.state_hash == run.state_hash and seen[-1] == (2, 36100.0)
    run.clear_sphere_law()
    run.advance(10)
    assert len(seen) == 18100


def test_laws_of_spheres_that_fail():
    def raises(pairs):
        raise LookupError(f"no table for {pairs.spheres.tolist()}")

    for law, error, message in [
        (raises, LookupError, r"no table for \[\[0, 1\]\]"),
        (lambda pairs: None, ValueError, "has returned nothing"),
        (lambda pairs: np.zeros(3), ValueError, r"forces of the shape \(1, 3\), one row for each couple, not \(3,\)"),
        (lambda pairs: np.full((1, 3), np.nan), RuntimeError, "it gives spheres 0 and 1 a value of NaN"),
        (lambda pairs: pairs.radii.fill(0), ValueError, "read-only"),
    ]:
        run = fdem.Simulation(falling(2))
        run.set_sphere_law(law)
        with pytest.raises(error, match=message):
            run.advance(1)
    with pytest.raises(ValueError, match="reach is -1e0, and must be at least 0"):
        run.set_sphere_law(raises, reach=-1.0)
    body = {"name": "bar", "material": "steel", "rectangle": {"min": [0, 0], "max": [1.0, 0.1]}, "mesh_size": 0.05}
    run = fdem.Simulation(fdem.Model(model={"end_time": 1e-4}, body=[body], material=[STEEL]))
    with pytest.raises(ValueError, match="law of spheres"):
        run.set_sphere_law(raises)


def test_a_law_of_spheres_goes_through_stages():
    calls = []

    def law(pairs):
        calls.append(pairs.time)
        return 0.0

    model = falling(2, end_time=4e-4).to_toml() + """
[[body]]
name = "block"
material = "steel"
box = { min = [1, 1, 1], max = [2, 2, 2] }
mesh_size = 1.0
[[body]]
name = "other"
material = "steel"
box = { min = [3, 1, 1], max = [4, 2, 2] }
mesh_size = 1.0
[[stage]]
name = "first"
duration = 2e-4
[[stage]]
name = "second"
excavate = ["other"]
"""
    run = fdem.Simulation(fdem.Model.from_toml(model))
    run.set_sphere_law(law)
    run.advance()
    assert run.stage == "second" and len(calls) == run.steps


def test_spheres_are_arrays():
    """Two spheres fall side by side, and a third lies on a wall."""
    sand = {"name": "sand", "material": "steel", "at": [[0, 0, 1.0], [0.2, 0, 1.0]], "radius": 0.05, "velocity": [0, 0, -1.0]}
    stone = {"name": "stone", "material": "steel", "at": [[1.0, 0, 0.0999]], "radius": 0.1}
    floor = {"name": "floor", "material": "steel", "plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}}
    model = fdem.Model(model={"end_time": 1e-4}, material=[STEEL | {"restitution": 0.5}], grains=[sand, stone], wall=[floor])
    run = fdem.Simulation(model)
    run.advance(3)
    spheres = run.spheres
    assert len(spheres) == 3 and spheres.numbers.tolist() == [0, 1, 2]
    assert spheres.positions.shape == spheres.velocities.shape == spheres.spins.shape == spheres.forces.shape == (3, 3)
    assert spheres.radii.tolist() == [0.05, 0.05, 0.1]
    assert spheres.masses == pytest.approx(7800 * 4 / 3 * np.pi * spheres.radii**3)
    assert spheres.groups.tolist() == [0, 0, 1] and spheres.group_names == ("sand", "stone")
    assert spheres.velocities[:2, 2] == pytest.approx(-1.0, rel=0.01)
    # Only the stone touches something: the floor.
    contacts = spheres.contacts
    assert contacts["sphere"].tolist() == [2] and contacts["kind"].tolist() == [1] and contacts["other"].tolist() == [0]
    assert contacts["normal"][0] > 0 and contacts["force"][0] == pytest.approx(spheres.forces[2])
    assert spheres.wall_names == ("floor",) and spheres.wall_forces[0] == pytest.approx(-spheres.forces[2])
    assert spheres.coordination.tolist() == [0, 0, 1]
    assert run.field("radius", "sphere").tolist() == spheres.radii.tolist()
    # The arrays are views of the columns of the run, moved without a copy, and nobody writes to them.
    assert not any(array.flags.writeable for array in (spheres.positions, spheres.radii, contacts["force"]))
    with pytest.raises(ValueError):
        spheres.positions[0, 0] = 1
    before = spheres.positions.copy()
    run.advance(3)
    assert (spheres.positions == before).all() and run.spheres.positions[0, 2] < before[0, 2]


def test_a_run_without_spheres_has_empty_arrays():
    spheres = fdem.Simulation(bar()).spheres
    assert len(spheres) == 0 and spheres.positions.shape == (0, 3) and spheres.coordination.size == 0
    assert repr(spheres) == "<fdem.Spheres: 0, 0 contacts, 0 walls>"
