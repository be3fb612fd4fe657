"""The page of a run in a browser: real clicks and keys in headless Chromium, without a network.

FDEM: the command (default: target/release/fdem beside the sources). RUN_REPORT: the example `run_report` (default: target/release/examples/run_report beside the sources). CHROMIUM: the browser (default: chromium,
chromium-browser or google-chrome on the path). FDEM_SHOTS: a folder that screenshots are kept in.
"""

import json
import math
import os
import shutil
import subprocess
import time
from pathlib import Path

import pytest
from playwright.sync_api import sync_playwright

from canvas import KEPT, UPLOADS, picture

ROOT = Path(__file__).resolve().parents[4]
RUN_REPORT = os.environ.get("RUN_REPORT", str(ROOT / "target/release/examples/run_report"))
FDEM = os.environ.get("FDEM", str(ROOT / "target/release/fdem"))
ARGUMENTS = [
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--no-sandbox",
    "--disable-dev-shm-usage",
]
# Longest wait for a change of the page, s; a busy machine needs most of it.
PATIENCE = 120
PREFIXES = {"G": 1e9, "M": 1e6, "k": 1e3, "": 1.0, "m": 1e-3, "µ": 1e-6, "n": 1e-9}


def chromium():
    names = ("chromium", "chromium-browser", "google-chrome")
    found = os.environ.get("CHROMIUM") or next(filter(None, map(shutil.which, names)), None)
    assert found, "no Chromium: name one by CHROMIUM"
    return found


def run(folder, *arguments):
    subprocess.run([RUN_REPORT, str(folder), *map(str, arguments)], check=True, capture_output=True)
    return folder / "report.html"


@pytest.fixture(scope="session")
def disc(tmp_path_factory):
    """A disc of 6 * 12² elements in 60 frames, its last snapshot and its first."""
    folder = tmp_path_factory.mktemp("disc")
    page = run(folder, 12, 60)
    return page, json.loads((folder / "expected_0059.json").read_text()), json.loads((folder / "expected_0000.json").read_text())


@pytest.fixture(scope="session")
def browser():
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium(), args=ARGUMENTS)
        yield browser
        browser.close()


class Watched:
    """A page that keeps account of what it asked for and complained of."""

    def __init__(self, browser, path, script=None, **options):
        self.context = browser.new_context(viewport={"width": 1360, "height": 960}, **options)
        self.page = self.context.new_page()
        self.page.set_default_timeout(1000 * PATIENCE)
        self.requests, self.complaints = [], []
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.on("console", lambda message: self.complaints.append(message.text) if message.type in ("error", "warning") else None)
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.add_init_script(KEPT)
        if script:
            self.page.add_init_script(script)
        self.page.goto(path.as_uri())
        self.page.wait_for_selector("html[data-ready]")

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self.context.close()

    def state(self):
        return self.page.evaluate("fdem.state()")

    def until(self, condition):
        """Waits for what the page says of its state. The page allows no scripts but its own: it cannot wait itself."""
        end = time.monotonic() + PATIENCE
        while not condition(self.state()):
            assert time.monotonic() < end, self.state()
            self.page.wait_for_timeout(20)

    def drawn(self, condition):
        """Waits until the canvas is as it should be, and returns its picture."""
        end = time.monotonic() + PATIENCE
        while not condition(seen := self.pixels()):
            assert time.monotonic() < end, "the canvas is not as it should be"
            self.page.wait_for_timeout(50)
        return seen

    def arrived(self, frame):
        """The frame is shown."""
        self.until(lambda state: state["frame"] == frame)

    def fact(self, name):
        return self.page.text_content(f'#picked dd[data-fact="{name}"]')

    def pixels(self):
        return picture(self.page)

    def check(self):
        """Nothing but the file itself and pictures inside it; no complaint, but those of the software renderer about its speed."""
        asked = [url for url in self.requests if not url.startswith(("file:", "data:", "blob:"))]
        assert asked == []
        assert [text for text in self.complaints if "GPU stall" not in text and "swiftshader" not in text.lower()] == []

    def shot(self, name):
        if "FDEM_SHOTS" in os.environ:
            self.page.screenshot(path=Path(os.environ["FDEM_SHOTS"]) / f"{name}.png", full_page=name.endswith("whole"))


def number(text):
    """In SI units."""
    value, _, unit = text.partition(" ")
    if unit in ("", "m", "Pa", "m/s"):
        return float(value)
    assert unit[1:] in ("m", "Pa", "m/s"), text
    return float(value) * PREFIXES[unit[0]]


def test_a_click_reads_the_element_as_it_was_simulated(browser, disc):
    path, last, first = disc
    with Watched(browser, path) as watched:
        page = watched.page
        page.evaluate("fdem.show(59)")
        watched.arrived(59)
        for element in (3, 400, len(last["triangles"]) - 2):
            page.mouse.click(*page.evaluate(f"fdem.project({element})"))
            assert watched.state() and page.evaluate("fdem.picked()") == element
            assert watched.fact("element") == f"{element:,}"
            assert watched.fact("body") == ["left half", "right half"][last["bodies"][element]]
            assert watched.fact("material") == "sandstone"
            nodes = last["triangles"][element]
            mean = lambda name, axis: sum(last[name][node][axis] for node in nodes) / 3
            xx, yy, zz, xy, _, _ = last["stresses"][element]
            middle, radius = (xx + yy) / 2, math.hypot((xx - yy) / 2, xy)
            mises = math.sqrt(((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * xy**2)
            stress = max(abs(x) for row in last["stresses"] for x in row)
            for name, expected, scale in (
                ("x", mean("positions", 0), 0.05),
                ("y", mean("positions", 1), 0.05),
                ("largest principal stress", middle + radius, stress),
                ("smallest principal stress", middle - radius, stress),
                ("von Mises stress", mises, 2 * stress),
                ("largest shear stress", radius, stress),
                ("velocity", math.hypot(mean("velocities", 0), mean("velocities", 1)), 10),
                ("displacement", math.hypot(mean("displacements", 0), mean("displacements", 1)), 0.01),
                ("damage", last["damage"][element], 1),
            ):
                assert abs(number(watched.fact(name)) - expected) <= 1e-4 * scale, name
            page.wait_for_selector("#overlay polygon", state="attached")
        watched.shot("run-picked")
        # The same element at the beginning.
        element = page.evaluate("fdem.picked()")
        page.focus("#frame")
        page.keyboard.press("Home")
        watched.arrived(0)
        x = sum(first["positions"][node][0] for node in first["triangles"][element]) / 3
        assert abs(number(watched.fact("x")) - x) <= 5e-6
        page.keyboard.press("Escape")
        assert page.evaluate("fdem.picked()") == -1
        page.wait_for_selector("#overlay polygon", state="detached")
        page.fill("#find-id", "17")
        page.keyboard.press("Enter")
        assert watched.fact("element") == "17"
        page.fill("#find-id", "999999")
        page.keyboard.press("Enter")
        assert watched.fact("element") == "17"
        assert "from 0 to 863" in page.evaluate("document.getElementById('find-id').validationMessage")
        watched.check()


def test_a_run_plays_pauses_and_begins_again(browser, disc):
    with Watched(browser, disc[0]) as watched:
        page = watched.page
        assert watched.state()["frame"] == 59, "the end is shown first"
        page.select_option("#speed", "24")
        page.click("#play")
        assert page.text_content("#play") == "Pause"
        watched.until(lambda state: 5 <= state["frame"] < 40)
        page.click("#play")
        rested = watched.state()
        assert not rested["playing"] and page.text_content("#play") == "Play"
        page.wait_for_timeout(400)
        watched.until(lambda state: state["frame"] == state["wanted"])
        assert abs(watched.state()["frame"] - rested["frame"]) <= 1
        page.click("#play")
        watched.until(lambda state: not state["playing"])
        assert watched.state()["frame"] == 59, "it stops at the end"
        assert page.is_disabled("#next") and page.input_value("#frame") == "59"
        assert page.text_content("#when") == "2.000 ms, step 100,000"
        page.click("#play")
        watched.until(lambda state: state["frame"] < 20)
        # A key on the view stops it.
        page.focus("#canvas")
        page.keyboard.press(" ")
        assert not watched.state()["playing"]
        watched.check()


def test_frames_by_slider_buttons_keys_and_table(browser, disc):
    with Watched(browser, disc[0]) as watched:
        page = watched.page
        page.focus("#frame")
        page.keyboard.press("End")
        watched.arrived(59)
        page.click("#previous")
        watched.arrived(58)
        page.click("#next")
        watched.arrived(59)
        page.focus("#canvas")
        page.keyboard.press(",")
        watched.arrived(58)
        page.keyboard.press(".")
        watched.arrived(59)
        box = page.locator("#frame").bounding_box()
        page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        watched.until(lambda state: abs(state["frame"] - 30) <= 1)
        page.click('#table-body button[data-frame="45"]')
        watched.arrived(45)
        assert page.locator('#table-body tr[aria-current="true"]').count() == 1
        assert page.text_content('#table-body tr[aria-current="true"] td') == "45"
        watched.check()


def test_fields_cracks_and_mesh_can_be_chosen(browser, disc):
    path, last, _ = disc
    with Watched(browser, path) as watched:
        page = watched.page
        page.evaluate("fdem.show(59)")
        watched.arrived(59)
        seen = {}
        for key in page.locator("#field option").evaluate_all("all => all.map((one) => one.value)"):
            page.select_option("#field", key)
            name = page.locator(f'#field option[value="{key}"]').text_content()
            assert (name in page.text_content("#legends")) == (key not in ("body", "material"))
            seen[key] = watched.pixels()
        assert len(seen) >= 8 and len(set(seen.values())) == len(seen)
        page.select_option("#field", "max_principal")
        same = page.text_content("#legends .ends")
        page.select_option("#range", "frame")
        assert page.text_content("#legends .ends") != same
        own = watched.pixels()
        assert own != seen["max_principal"]
        lengths = {}
        for crack in last["cracks"]:
            if crack["time"] is not None:
                lengths[crack["mode"]] = lengths.get(crack["mode"], 0) + crack["length"]
        items = page.locator("#legends .cracks span").all_text_contents()
        assert [item.split()[0] for item in items] == ["tension", "shear", "mixed"]
        for mode, item in enumerate(items):
            assert number(" ".join(item.split()[1:])) == pytest.approx(lengths[mode], rel=6e-3)
        page.uncheck("#show-cracks")
        whole = watched.pixels()
        assert whole != own and page.locator("#legends .cracks").count() == 0
        page.check("#show-mesh")
        assert watched.pixels() != whole
        watched.shot("run-mesh")
        watched.check()


def test_the_view_zooms_and_moves(browser, disc):
    with Watched(browser, disc[0]) as watched:
        page = watched.page
        home = watched.state()
        place = page.evaluate("fdem.project(500)")
        page.mouse.move(*place)
        page.mouse.wheel(0, -400)
        near = watched.state()
        assert near["zoomed"] > 1.4
        after = page.evaluate("fdem.project(500)")
        assert max(abs(a - b) for a, b in zip(place, after)) < 1.5, "what is under the pointer stays"
        page.mouse.down()
        page.mouse.move(place[0] + 60, place[1] - 25, steps=4)
        page.mouse.up()
        moved = page.evaluate("fdem.project(500)")
        assert moved[0] - after[0] == pytest.approx(60, abs=0.1) and moved[1] - after[1] == pytest.approx(-25, abs=0.1)
        assert page.evaluate("fdem.picked()") == -1, "a drag does not pick"
        page.click("#zoom-in")
        assert watched.state()["zoomed"] == pytest.approx(1.25 * near["zoomed"])
        page.click("#reset")
        assert {k: watched.state()[k] for k in ("pan", "zoomed")} == {k: home[k] for k in ("pan", "zoomed")}
        page.focus("#canvas")
        page.keyboard.press("+")
        page.keyboard.press("ArrowLeft")
        assert watched.state()["zoomed"] == 1.25 and watched.state()["pan"] != home["pan"]
        page.keyboard.press("r")
        assert watched.state()["zoomed"] == 1
        watched.check()


def test_a_frame_that_is_left_out_is_named(browser, tmp_path):
    with Watched(browser, run(tmp_path, 3, 122)) as watched:
        text = watched.page.text_content("#thinned")
        assert text == "121 of 122 frames are in this page; frame 120 is left out."
        watched.check()


def test_outlines_are_drawn_and_can_be_hidden(browser, disc):
    with Watched(browser, disc[0]) as watched:
        page = watched.page
        page.uncheck("#show-outlines")
        without = watched.pixels()
        page.check("#show-outlines")
        with_outlines = watched.drawn(lambda picture: picture != without)
        page.uncheck("#show-outlines")
        watched.drawn(lambda picture: picture == without)
        page.check("#show-outlines")
        watched.drawn(lambda picture: picture == with_outlines)
        watched.check()


def test_a_picture_is_that_of_the_canvas_alone(browser, disc):
    """The round corners of the view were in the pictures that tests compare. The browser does not always paint them in the same way."""
    with Watched(browser, disc[0]) as watched:
        before = watched.pixels()
        watched.page.evaluate("document.querySelector('.view').style.borderRadius = document.getElementById('canvas').style.borderRadius = '90px'")
        assert watched.pixels() == before
        watched.page.click("#zoom-in")
        watched.drawn(lambda picture: picture != before)
        watched.page.click("#reset")
        watched.drawn(lambda picture: picture == before)
        watched.check()


def test_summary_plots_and_what_is_left_out_are_text(browser, disc):
    path, last, _ = disc
    with Watched(browser, path, java_script_enabled=True) as watched:
        page = watched.page
        assert page.text_content("h1") == "A disc that splits"
        assert "864 elements" in page.text_content(".lead")
        assert page.locator("#thinned").count() == 0, "all frames are in the page"
        assert page.locator(".plots svg").count() == 6
        assert page.locator(".plots svg title").all_text_contents()[0] == "Energies"
        rows = page.locator("#table-body tr")
        assert rows.count() == 60
        cells = rows.nth(59).locator("td").all_text_contents()
        total = sum(crack["length"] for crack in last["cracks"] if crack["time"] is not None)
        assert float(cells[3]) == pytest.approx(total, rel=1e-5)
        assert [cells[0], cells[1], cells[2]] == ["59", "100,000", "0.002"]
        pieces = page.locator("#fragments-table tbody tr")
        assert pieces.count() == 2
        shares = [float(pieces.nth(k).locator("td").nth(4).text_content()) for k in range(2)]
        assert shares == pytest.approx([50, 50], rel=1e-3)
        watched.check()


def test_a_sample_of_a_large_mesh_is_shown_and_picked(browser, tmp_path):
    model = """
        [model]
        end_time = 2e-5
        [[body]]
        name = "block"
        material = "rock"
        rectangle = { min = [0, 0], max = [1, 1] }
        mesh_size = 0.04
        velocity = [3, 0]
        [[material]]
        name = "rock"
        density = 2700
        youngs_modulus = 10e9
        poissons_ratio = 0.2
        [output]
        frames = 2
        shown_elements = 200
    """
    (tmp_path / "block.toml").write_text(model)
    subprocess.run([FDEM, "run", "block.toml", "-q", "-o", "run"], cwd=tmp_path, check=True, capture_output=True)
    elements = json.loads((tmp_path / "run/run.json").read_text())["elements"]
    assert elements > 1000
    with Watched(browser, tmp_path / "run/report.html") as watched:
        page = watched.page
        assert f"The mesh has {elements:,} elements. The view shows a sample" in page.text_content("#sample")
        assert f"{elements:,} elements" in page.text_content(".lead")
        numbers = page.evaluate("Array.from({ length: fdem.triangles() }, (_, k) => fdem.number(k))")
        assert 50 < len(numbers) <= 200
        assert numbers == sorted(set(numbers)) and numbers[0] >= 0 and numbers[-1] < elements
        x, y = page.evaluate("fdem.project(30)")
        page.mouse.click(x, y)
        picked = page.evaluate("fdem.picked()")
        assert picked in numbers and watched.fact("element") == f"{picked:,}"
        assert number(watched.fact("velocity")) == pytest.approx(3, rel=1e-3)
        page.wait_for_selector("#overlay polygon", state="attached")
        # An element that is not shown is reported; the view continues.
        missing = next(k for k in range(elements) if k not in numbers)
        page.fill("#find-id", str(missing))
        page.keyboard.press("Enter")
        assert f"Element {missing:,} is not in the sample" in page.text_content("#picked")
        page.wait_for_selector("#overlay polygon", state="detached")
        page.fill("#find-id", str(numbers[-1]))
        page.keyboard.press("Enter")
        assert watched.fact("element") == f"{numbers[-1]:,}"
        before = watched.pixels()
        page.select_option("#field", "body")
        assert watched.pixels() != before
        watched.shot("run-sample")
        watched.check()


def test_dark_mode_by_system_and_by_hand(browser, disc):
    background = "getComputedStyle(document.body).backgroundColor"
    with Watched(browser, disc[0], color_scheme="dark") as watched:
        page = watched.page
        page.evaluate("fdem.show(40)")
        watched.arrived(40)
        dark, seen = page.evaluate(background), watched.pixels()
        watched.shot("run-dark-whole")
        page.click("#theme")
        assert page.evaluate(background) != dark and watched.pixels() != seen
        watched.shot("run-light-whole")
        page.click("#theme")
        assert page.evaluate(background) == dark
        # Texts of plots are seen on both.
        ink = page.evaluate("getComputedStyle(document.querySelector('.plots .ink')).fill")
        assert ink == page.evaluate("getComputedStyle(document.body).color")
        assert page.evaluate("getComputedStyle(document.querySelector('.plots .paper')).fill") == "none"
        watched.check()


def test_everything_is_reached_by_the_keyboard(browser, disc):
    with Watched(browser, disc[0]) as watched:
        page = watched.page
        # At the ends one of the buttons has nothing to do.
        page.evaluate("fdem.show(10)")
        watched.arrived(10)
        reached = []
        for _ in range(22):
            page.keyboard.press("Tab")
            reached.append(page.evaluate("document.activeElement.id"))
            assert page.evaluate("getComputedStyle(document.activeElement).outlineStyle") != "none", reached
        for name in ("theme", "canvas", "field", "range", "show-cracks", "show-outlines", "show-mesh", "find-id", "play", "previous", "next", "frame", "speed", "zoom-in", "reset"):
            assert name in reached, reached


def test_without_webgl_a_picture_stands_in(browser, disc):
    with Watched(browser, disc[0], "HTMLCanvasElement.prototype.getContext = () => null") as watched:
        page = watched.page
        assert page.is_visible("#preview img") and not page.is_visible("#player")
        assert page.evaluate("document.querySelector('#preview img').naturalWidth") >= 600
        assert "no WebGL2" in page.text_content("#why")
        watched.check()


def test_a_browser_that_cannot_inflate(browser, disc):
    with Watched(browser, disc[0], "delete window.DecompressionStream") as watched:
        watched.page.evaluate("fdem.show(59)")
        watched.arrived(59)
        watched.check()


def test_a_single_frame(browser, tmp_path):
    with Watched(browser, run(tmp_path, 3, 1)) as watched:
        page = watched.page
        assert watched.state()["frame"] == 0 and page.is_disabled("#play")
        page.mouse.click(*page.evaluate("fdem.project(20)"))
        assert watched.fact("element") == "20"
        watched.check()


def test_nothing_is_uploaded_while_the_view_of_many_elements_moves(browser, tmp_path):
    path = run(tmp_path, 60, 4)
    assert path.stat().st_size < 6_000_000
    with Watched(browser, path, UPLOADS) as watched:
        page = watched.page
        assert "21,600 elements" in page.text_content(".lead")
        seen = [watched.pixels()]
        loaded = page.evaluate("uploads")
        assert loaded > 0
        page.click("#zoom-in")
        seen.append(watched.pixels())
        page.focus("#canvas")
        page.keyboard.press("ArrowLeft")
        seen.append(watched.pixels())
        assert len(set(seen)) == 3 and page.evaluate("uploads") == loaded
        page.select_option("#field", "velocity")
        watched.drawn(lambda picture: picture != seen[-1])
        assert page.evaluate("uploads") > loaded
        watched.check()
