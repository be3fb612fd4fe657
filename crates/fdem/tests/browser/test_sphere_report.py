"""The pages of runs with spheres and discs in a browser: real clicks and keys in headless Chromium, without a network.

SPHERE_REPORT: the example `sphere_report` (default: target/release/examples/sphere_report beside the sources). CHROMIUM and FDEM_SHOTS: as in test_run_report.py.
"""

import json
import math
import os
import subprocess

import pytest

from canvas import UPLOADS
from test_run_report import ROOT, Watched, browser, number  # noqa: F401 (a fixture)

SPHERE_REPORT = os.environ.get("SPHERE_REPORT", str(ROOT / "target/release/examples/sphere_report"))
FRAMES = 3


def run(folder, *arguments):
    subprocess.run([SPHERE_REPORT, str(folder), *map(str, arguments)], check=True, capture_output=True)
    return folder / "report.html", json.loads((folder / "expected.json").read_text())


@pytest.fixture(scope="session")
def box(tmp_path_factory):
    """512 spheres in a box above a block: the page, and the last spheres."""
    return run(tmp_path_factory.mktemp("box"), 8, FRAMES)


@pytest.fixture(scope="session")
def floor(tmp_path_factory):
    """144 discs on a floor."""
    return run(tmp_path_factory.mktemp("floor"), 12, FRAMES, "flat")


def seen(page, k):
    """Where sphere k is on the page, and its radius there."""
    return page.evaluate(f"fdem.sphereAt({k})")


def test_a_click_reads_the_sphere_that_is_seen_there(browser, box):  # noqa: F811
    path, last = box
    with Watched(browser, path) as watched:
        page = watched.page
        watched.arrived(FRAMES - 1)
        assert page.evaluate("fdem.spheres().count") == len(last["numbers"]) == 512
        assert page.evaluate("fdem.spheres().chains") == last["contacts"]
        # Spheres at the front right edge are seen from the front, the right and above.
        front = [k for k, (x, y, z) in enumerate(last["positions"]) if y < 0.02 and z > 0.145]
        assert len(front) == 8
        for k in front:
            x, y, radius = seen(page, k)
            page.mouse.click(x, y - radius / 3)
            assert page.evaluate("fdem.pickedSphere()") == last["numbers"][k]
            assert page.evaluate("fdem.picked()") == -1
            assert watched.fact("sphere") == f"{last['numbers'][k]:,}"
            assert watched.fact("group") == ["sand", "gravel"][last["groups"][k]]
            assert number(watched.fact("radius")) == pytest.approx(last["radii"][k], rel=1e-3)
            assert number(watched.fact("velocity")) == pytest.approx(math.hypot(*last["velocities"][k]), abs=1e-3)
            assert number(watched.fact("z")) == pytest.approx(last["positions"][k][2], abs=1e-4)
        page.wait_for_selector("#overlay circle", state="attached")
        watched.shot("spheres-picked")
        # The sphere stays selected in the frame before, and its place is another.
        page.click("#previous")
        watched.arrived(FRAMES - 2)
        assert page.evaluate("fdem.pickedSphere()") == last["numbers"][front[-1]]
        page.keyboard.press("Escape")
        assert page.evaluate("fdem.pickedSphere()") == -1
        # The ring goes with the next drawing.
        page.wait_for_selector("#overlay circle", state="detached")
        watched.check()


def test_fields_chains_and_walls_are_drawn(browser, box):  # noqa: F811
    path, _ = box
    with Watched(browser, path) as watched:
        page = watched.page
        drawn = [watched.pixels()]
        for field in ("force", "radius", "coordination", "group", "spin"):
            page.select_option("#sphere-field", field)
            drawn.append(watched.drawn(lambda picture: picture not in drawn))
        watched.shot("spheres-spin")
        assert "spheres: spin" in page.text_content("#legends")
        for box_of in ("show-chains", "show-walls", "show-spheres"):
            page.click(f"#{box_of}")
            drawn.append(watched.drawn(lambda picture: picture not in drawn))
        assert "normal force" in page.text_content("#legends")
        watched.shot("spheres-chains")
        # Hidden spheres are not picked.
        x, y, _ = seen(page, 511)
        page.mouse.click(x, y)
        assert page.evaluate("fdem.pickedSphere()") == -1
        watched.check()


def test_nothing_is_uploaded_while_the_view_turns(browser, box):  # noqa: F811
    with Watched(browser, box[0], UPLOADS) as watched:
        page = watched.page
        before = watched.pixels()
        loaded = page.evaluate("uploads")
        page.evaluate("fdem.turn(2.1, 0.2)")
        turned = watched.drawn(lambda picture: picture != before)
        page.click("#zoom-in")
        watched.drawn(lambda picture: picture not in (before, turned))
        assert page.evaluate("uploads") == loaded
        watched.check()


def test_near_spheres_are_squares_and_stay_at_the_edge_of_the_view(browser, box):  # noqa: F811
    with Watched(browser, box[0]) as watched:
        page = watched.page
        for _ in range(10):
            page.click("#zoom-in")
        watched.pixels()
        assert seen(page, 0)[2] > 60, "larger than points are"
        watched.shot("spheres-near")
        watched.check()


def test_a_cut_takes_spheres_away(browser, box):  # noqa: F811
    with Watched(browser, box[0]) as watched:
        page = watched.page
        whole = watched.pixels()
        page.select_option("#cut-axis", "1")
        watched.drawn(lambda picture: picture != whole)
        # What was in front is gone: a click there picks a sphere behind it, or none.
        x, y, _ = seen(page, 3)
        page.mouse.click(x, y)
        assert page.evaluate("fdem.pickedSphere()") != 3
        watched.check()


def test_discs_are_circles_that_can_be_picked(browser, floor):  # noqa: F811
    path, last = floor
    with Watched(browser, path) as watched:
        page = watched.page
        watched.arrived(FRAMES - 1)
        assert page.evaluate("fdem.spheres()") == {"count": 144, "chains": last["contacts"], "walls": 3}
        for k in range(0, 144, 13):
            x, y, radius = seen(page, k)
            page.mouse.click(x + 0.4 * radius, y)
            assert page.evaluate("fdem.pickedSphere()") == last["numbers"][k]
            assert number(watched.fact("y")) == pytest.approx(last["positions"][k][1], abs=1e-4)
        before = watched.pixels()
        page.click("#show-chains")
        watched.drawn(lambda picture: picture != before)
        watched.shot("discs-chains")
        watched.check()
