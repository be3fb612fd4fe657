"""The report in a browser: real clicks and keys in headless Chromium, without a network.

FDEM: the command (default `fdem`). CHROMIUM: the browser (default: chromium, chromium-browser or google-chrome on the path). FDEM_BED: the
25,000 spheres of the DEM round robin (default: among the shared data beside this repository; without them a gas is made instead).
FDEM_SHOTS: a folder that screenshots are kept in.
"""

import csv
import math
import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from playwright.sync_api import expect, sync_playwright

from canvas import KEPT, picture

# Longest wait for a change of the page, ms. A slow machine draws a frame in seconds; by default an expectation waits for five.
PATIENCE = 120_000
expect.set_options(timeout=PATIENCE)

FDEM = os.environ.get("FDEM", "fdem")
ROOT = Path(__file__).resolve().parents[4]
EXAMPLES = ROOT / "examples"
BED = Path(os.environ.get("FDEM_BED", ROOT.parent / "shared/data/roundrobin/penetration/25KParticles.txt"))
ARGUMENTS = [
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--no-sandbox",
    "--disable-dev-shm-usage",
]


def chromium():
    names = ("chromium", "chromium-browser", "google-chrome")
    found = os.environ.get("CHROMIUM") or next(filter(None, map(shutil.which, names)), None)
    assert found, "no Chromium: name one by CHROMIUM"
    return found


def contacts(packing, folder, *options):
    """Runs the command; the page, and the couples as it writes them."""
    couples = folder / "couples.csv"
    page = folder / "report.html"
    line = [FDEM, "contacts", str(packing), "-q", "-o", str(couples), "--report", str(page), *options]
    subprocess.run(line, check=True, capture_output=True)
    with open(couples, newline="") as rows:
        return page, list(csv.DictReader(rows))


class Network:
    """A packing and its couples, as their files have them."""

    def __init__(self, centres, couples):
        self.centres = centres
        self.contacts = {}
        for couple in couples:
            numbers = (float(couple["distance"]), float(couple["overlap"]))
            i, j = int(couple["i"]), int(couple["j"])
            self.contacts.setdefault(i, {})[j] = numbers
            self.contacts.setdefault(j, {})[i] = numbers

    def nearest_to_the_eye(self):
        """At the first view: turned by 30 degrees, seen 20 degrees from above. Nothing stands before this one."""
        turn, tilt = math.radians(30), math.radians(20)
        toward = (math.sin(turn) * math.cos(tilt), -math.cos(turn) * math.cos(tilt), math.sin(tilt))
        depth = lambda k: sum(a * b for a, b in zip(self.centres[k], toward))
        return max(range(len(self.centres)), key=depth)


def of_gas(folder, count):
    """The page and the network of a gas of spheres."""
    packing = folder / "gas.csv"
    subprocess.run([FDEM, "generate", "gas", "-n", str(count), "-o", str(packing)], check=True, capture_output=True)
    with open(packing, newline="") as rows:
        centres = [tuple(float(row[axis]) for axis in "xyz") for row in csv.DictReader(rows)]
    page, couples = contacts(packing, folder)
    return page, Network(centres, couples)


@pytest.fixture(scope="session")
def bed(tmp_path_factory):
    """A real bed of 25,000 spheres. A software renderer takes a second for each of its pictures."""
    folder = tmp_path_factory.mktemp("bed")
    if not BED.exists():
        return of_gas(folder, 25000)
    rows = [line.split() for line in BED.read_text().splitlines()[1:]]
    centres = [tuple(map(float, row[1:])) for row in rows if len(row) == 4]
    page, couples = contacts(BED, folder, "--skip-bad-lines")
    assert len(couples) == 53876
    return page, Network(centres, couples)


@pytest.fixture(scope="session")
def gas(tmp_path_factory):
    return of_gas(tmp_path_factory.mktemp("gas"), 3000)


@pytest.fixture(scope="session")
def browser():
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium(), args=ARGUMENTS)
        yield browser
        browser.close()


class Watched:
    """A page that keeps account of what it asked for and complained of."""

    def __init__(self, browser, path, script=None, **options):
        self.context = browser.new_context(viewport={"width": 1360, "height": 900}, **options)
        self.page = self.context.new_page()
        self.page.set_default_timeout(PATIENCE)
        self.requests, self.complaints = [], []
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.on("console", lambda message: self.complaints.append(message.text) if message.type in ("error", "warning") else None)
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("dialog", lambda dialog: (self.complaints.append(dialog.message), dialog.dismiss()))
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

    def picked(self, fact):
        return self.page.text_content(f'#picked dd[data-fact="{fact}"]')

    def check(self):
        """Nothing but the file itself and pictures inside it; no complaint, but those of the software renderer about its speed."""
        asked = [url for url in self.requests if not url.startswith(("file:", "data:", "blob:"))]
        assert asked == []
        assert [text for text in self.complaints if "GPU stall" not in text and "swiftshader" not in text.lower()] == []

    def shot(self, name):
        if "FDEM_SHOTS" in os.environ:
            self.page.screenshot(path=Path(os.environ["FDEM_SHOTS"]) / f"{name}.png", full_page=name.endswith("whole"))


def test_a_click_names_the_element_and_all_its_contacts(browser, bed):
    path, network = bed
    with Watched(browser, path) as watched:
        page = watched.page
        watched.shot("light")
        nearest = network.nearest_to_the_eye()
        page.mouse.click(*page.evaluate(f"fdem.project({nearest})"))
        expected = network.contacts.get(nearest, {})
        assert watched.picked("id") == str(nearest)
        assert watched.picked("contacts") == str(len(expected))
        rows = page.locator("#picked tbody tr").all()
        shown = {int(row.locator("td").nth(0).text_content()): row.locator("td").all_text_contents()[1:3] for row in rows}
        assert {k: tuple(map(float, numbers)) for k, numbers in shown.items()} == expected
        # Marks are drawn with the next frame.
        expect(page.locator("#overlay circle.mine")).to_have_count(1)
        expect(page.locator("#overlay circle.neighbour")).to_have_count(len(expected))
        watched.shot("picked")
        # A contact in the list leads to the other element.
        if expected:
            other = next(iter(shown))
            page.click(f'#picked button[aria-label="select element {other}"]')
            assert watched.picked("contacts") == str(len(network.contacts[other]))
        page.keyboard.press("Escape")
        assert page.evaluate("fdem.picked()") == -1
        expect(page.locator("#overlay circle")).to_have_count(0)
        watched.check()


def test_an_id_finds_its_element(browser, gas):
    path, network = gas
    with Watched(browser, path) as watched:
        page = watched.page
        busiest = max(network.contacts, key=lambda k: len(network.contacts[k]))
        page.fill("#find-id", str(busiest))
        page.keyboard.press("Enter")
        assert watched.picked("contacts") == str(len(network.contacts[busiest]))
        page.check("#isolate")
        assert page.evaluate("fdem.shown()") == 1 + len(network.contacts[busiest])
        watched.shot("isolated")
        page.fill("#find-id", "99999999")
        page.keyboard.press("Enter")
        assert page.evaluate("document.getElementById('find-id').validationMessage") == "There is no element 99999999"
        assert page.evaluate("fdem.picked()") == busiest
        page.click("#clear")
        assert page.evaluate("fdem.shown()") == len(network.centres)
        watched.check()


def test_mouse_and_keys_turn_and_zoom(browser, gas):
    with Watched(browser, gas[0]) as watched:
        page = watched.page
        first = watched.state()
        box = page.locator("#canvas").bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x + 120, y + 40, steps=4)
        page.mouse.up()
        turned = watched.state()
        assert turned["yaw"] != first["yaw"] and turned["pitch"] != first["pitch"]
        assert page.evaluate("fdem.picked()") == -1, "a drag is no click"
        page.mouse.wheel(0, -300)
        page.wait_for_function(f"fdem.state().scale > {turned['scale']}")
        page.focus("#canvas")
        page.keyboard.press("r")
        home = watched.state()
        assert (home["yaw"], home["pitch"], home["pan"]) == (first["yaw"], first["pitch"], [0, 0])
        page.keyboard.press("ArrowLeft")
        page.keyboard.press("ArrowDown")
        page.keyboard.press("+")
        page.keyboard.press("Shift+ArrowRight")
        keyed = watched.state()
        assert keyed["yaw"] != home["yaw"] and keyed["pitch"] != home["pitch"] and keyed["scale"] > home["scale"]
        assert keyed["pan"] != [0, 0]
        page.click("#zoom-out")
        assert watched.state()["scale"] < keyed["scale"]
        page.click("#reset")
        assert watched.state()["yaw"] == first["yaw"]
        watched.check()


def test_a_cut_hides_the_centres_beyond_it(browser, gas):
    path, network = gas
    with Watched(browser, path) as watched:
        page = watched.page
        page.select_option("#clip-axis", "2")
        text = page.text_content("#clip-text")
        place = float(re.search(r"= (\S+)", text).group(1))
        below = sum(centre[2] <= place for centre in network.centres)
        shown = page.evaluate("fdem.shown()")
        assert abs(shown - below) <= 5, "six digits of the place are shown"
        page.check("#clip-flip")
        assert abs(page.evaluate("fdem.shown()") + shown - len(network.centres)) <= 5
        page.focus("#clip")
        page.keyboard.press("End")
        assert page.evaluate("fdem.shown()") == 0
        page.keyboard.press("Home")
        assert page.evaluate("fdem.shown()") == len(network.centres)
        page.uncheck("#clip-flip")
        page.evaluate("document.getElementById('clip').value = 620")
        page.keyboard.press("ArrowRight")
        watched.shot("cut")
        watched.check()


def test_colours_and_parts_can_be_chosen(browser, gas):
    with Watched(browser, gas[0]) as watched:
        page = watched.page
        seen = [picture(watched.page)]
        for by, legend in (("overlap", "largest overlap"), ("size", "radius"), ("coordination", "contacts of an element")):
            page.select_option("#colour-by", by)
            assert legend in page.text_content("#legends")
            seen.append(picture(watched.page))
        assert len(set(seen[:3])) == 3
        page.uncheck("#show-elements")
        contacts_only = picture(watched.page)
        watched.shot("contacts")
        page.uncheck("#show-contacts")
        nothing = picture(watched.page)
        assert len({seen[-1], contacts_only, nothing}) == 3
        page.check("#show-elements")
        page.focus("#size")
        page.keyboard.press("Home")
        assert page.text_content("#size-text") == "5 %"
        watched.check()


def test_the_table_is_sorted_filtered_and_paged(browser, gas):
    path, network = gas
    with Watched(browser, path) as watched:
        page = watched.page
        count = len(network.centres)
        assert page.text_content("#table-count") == f"{count:,} of {count:,} elements"
        column = lambda k: page.locator(f"#table-body tr > :nth-child({k})").all_text_contents()
        assert column(1) == [str(k) for k in range(50)]
        assert [float(x) for x in column(2)] == [centre[0] for centre in network.centres[:50]]
        contacts_head = page.locator("#table-head button", has_text="contacts")
        contacts_head.click()
        contacts_head.click()
        degrees = sorted((len(network.contacts.get(k, {})) for k in range(count)), reverse=True)
        assert [int(x) for x in column(6)] == degrees[:50]
        assert page.get_attribute("#table-head th:nth-child(6)", "aria-sort") == "descending"
        page.click("#next")
        assert [int(x) for x in column(6)] == degrees[50:100]
        page.click("#last")
        assert int(column(6)[-1]) == degrees[-1]
        page.fill("#filter-id", "1234")
        matching = [k for k in range(count) if str(k).startswith("1234")]
        assert page.text_content("#table-count") == f"{len(matching)} of {count:,} elements"
        page.click('#table-body button[aria-label="select element 1234"]')
        assert watched.picked("contacts") == str(len(network.contacts.get(1234, {})))
        assert page.locator('#table-body tr[aria-selected="true"]').count() == 1
        watched.check()


def test_dark_mode_by_system_and_by_hand(browser, gas):
    background = "getComputedStyle(document.body).backgroundColor"
    with Watched(browser, gas[0], color_scheme="dark") as watched:
        page = watched.page
        dark = page.evaluate(background)
        watched.shot("dark-whole")
        page.click("#theme")
        light = page.evaluate(background)
        assert dark != light
        assert page.get_attribute("#theme", "aria-pressed") == "false"
        page.click("#theme")
        assert page.evaluate(background) == dark
        watched.check()
    with Watched(browser, gas[0], color_scheme="light") as watched:
        assert watched.page.evaluate(background) == light
        watched.shot("light-whole")


def lightness(colour):
    red, green, blue = map(int, re.findall(r"\d+", colour)[:3])
    return 2 * red + 5 * green + blue


def test_large_values_stand_out_in_the_dark(browser, gas):
    """On dark paper the largest overlaps were the darkest."""
    for scheme in ("light", "dark"):
        with Watched(browser, gas[0], color_scheme=scheme) as watched:
            page = watched.page
            page.select_option("#colour-by", "overlap")
            bar = page.evaluate("document.querySelector('.legend .bar').style.background")
            colours = re.findall(r"rgb\([^)]*\)", bar)
            assert (lightness(colours[0]) < lightness(colours[-1])) == (scheme == "dark")
            watched.shot(f"overlap-{scheme}")
            watched.check()


def test_legends_hide_no_elements(browser, gas):
    with Watched(browser, gas[0]) as watched:
        legends, canvas = (watched.page.locator(name).bounding_box() for name in ("#legends", "#canvas"))
        assert legends["y"] >= canvas["y"] + canvas["height"] - 1
        assert canvas["height"] > 300
        watched.check()


def test_the_view_zooms_to_the_element_that_is_picked(browser, gas):
    path, network = gas
    with Watched(browser, path) as watched:
        page = watched.page
        assert page.is_disabled("#zoom-to")
        page.fill("#find-id", "1234")
        page.keyboard.press("Enter")
        before = watched.state()
        page.click("#zoom-to")
        assert watched.state()["scale"] > 2 * before["scale"]
        box = page.locator("#canvas").bounding_box()
        x, y = page.evaluate("fdem.project(1234)")
        assert abs(x - box["x"] - box["width"] / 2) < 1 and abs(y - box["y"] - box["height"] / 2) < 1
        watched.shot("zoomed")
        page.focus("#canvas")
        page.keyboard.press("r")
        assert watched.state()["scale"] == pytest.approx(before["scale"])
        page.keyboard.press("z")
        assert watched.state()["scale"] > 2 * before["scale"]
        watched.check()


def test_spheres_and_walls(browser, tmp_path):
    path = tmp_path / "walls.html"
    files = [EXAMPLES / "balls.csv", EXAMPLES / "floor.stl"]
    table = tmp_path / "bodies.csv"
    subprocess.run(
        [FDEM, "contacts", *map(str, files), "--report", str(path), "-o", str(tmp_path / "c.csv"), "--body-table", str(table)],
        check=True,
        capture_output=True,
    )
    with open(table, newline="") as rows:
        rows = list(csv.DictReader(rows))
    floor = max(max(int(row["i"]), int(row["j"])) for row in rows)
    ball = min(int(row["i"]) for row in rows if int(row["j"]) == floor)
    expected = {str(floor if int(row["i"]) == ball else int(row["i"])) for row in rows if int(row["j"]) == floor and int(row["i"]) == ball}
    with Watched(browser, path) as watched:
        page = watched.page
        assert "bodies" in page.text_content("header .lead")
        page.mouse.click(*page.evaluate(f"fdem.project({ball})"))
        picked = int(watched.picked("id"))
        page.evaluate(f"fdem.pick({ball})")
        assert picked >= 0 and watched.picked("id") == str(ball)
        heads = page.locator("#picked thead th").all_text_contents()
        assert heads == ["id", "depth", "shared boundary", "couples of elements"]
        assert expected <= set(page.locator("#picked tbody td:first-child").all_text_contents())
        page.evaluate(f"fdem.pick({floor})")
        assert page.locator('#picked dd[data-fact="radius"]').count() == 0
        seen = set()
        for surfaces in ("1", "0.3", "0"):
            page.select_option("#surfaces", surfaces)
            seen.add(picture(watched.page))
        assert len(seen) == 3
        page.select_option("#surfaces", "0.3")
        watched.shot("walls")
        watched.check()


@pytest.mark.parametrize("case", ["plane", "image"])
def test_meshes_and_images(browser, tmp_path, case):
    path = tmp_path / "bodies.html"
    file, options = {"plane": ("squares.msh", []), "image": ("grains.npy", ["--labels"])}[case]
    subprocess.run([FDEM, "contacts", str(EXAMPLES / file), "--report", str(path), *options], check=True, capture_output=True)
    with Watched(browser, path) as watched:
        page = watched.page
        nothing = picture(watched.page)
        page.uncheck("#show-elements")
        assert picture(watched.page) != nothing
        page.check("#show-elements")
        page.evaluate("fdem.pick(0)")
        assert int(watched.picked("contacts")) > 0
        assert (page.locator("#surfaces").count() == 1) == (case == "plane")
        watched.shot(f"bodies-{case}")
        watched.check()


def test_everything_is_reached_by_the_keyboard(browser, gas):
    with Watched(browser, gas[0]) as watched:
        page = watched.page
        reached = []
        for _ in range(24):
            page.keyboard.press("Tab")
            reached.append(page.evaluate("document.activeElement.id"))
            outline = page.evaluate("getComputedStyle(document.activeElement).outlineStyle")
            assert outline != "none", reached
        for name in ("theme", "canvas", "show-elements", "colour-by", "size", "clip-axis", "zoom-in", "reset", "find-id", "isolate"):
            assert name in reached, reached


def test_without_webgl_a_picture_stands_in(browser, gas):
    script = "HTMLCanvasElement.prototype.getContext = () => null"
    with Watched(browser, gas[0], script) as watched:
        page = watched.page
        assert page.is_visible("#preview img")
        assert page.evaluate("document.querySelector('#preview img').naturalWidth") > 500
        assert "no WebGL2" in page.text_content("#why")
        page.fill("#find-id", "12")
        page.keyboard.press("Enter")
        assert watched.picked("contacts") == str(len(gas[1].contacts.get(12, {})))
        watched.shot("picture")
        watched.check()


def test_a_browser_that_cannot_inflate(browser, gas):
    with Watched(browser, gas[0], "delete window.DecompressionStream") as watched:
        watched.page.fill("#find-id", "12")
        watched.page.keyboard.press("Enter")
        assert watched.picked("contacts") == str(len(gas[1].contacts.get(12, {})))
        watched.check()


def test_discs_are_flat_and_hostile_names_are_text(browser, tmp_path):
    name = "<img src=x onerror=alert(1)>.csv"
    (tmp_path / name).write_text("id,x,y,radius\n-7,0,0,1\n9007199254740993,1.5,0,1\n12,5,0,0.1\n")
    path, _ = contacts(tmp_path / name, tmp_path)
    with Watched(browser, path) as watched:
        page = watched.page
        assert page.text_content("h1") == name
        assert page.locator("h1 img").count() == 0
        page.mouse.click(*page.evaluate("fdem.project(1)"))
        assert watched.picked("id") == "9007199254740993"
        assert page.locator("#picked tbody td").all_text_contents() == ["-7", "1.5", "0.5"]
        before = watched.state()
        page.focus("#canvas")
        page.keyboard.press("ArrowLeft")
        after = watched.state()
        assert after["yaw"] == before["yaw"] and after["pan"] != before["pan"]
        watched.shot("flat")
        watched.check()


def test_contacts_across_a_face_have_their_shift(browser, tmp_path):
    packing = tmp_path / "ends.csv"
    packing.write_text("id,x,y,r\n10,0.25,2,0.5\n20,3.5,2,0.5\n")
    path, couples = contacts(packing, tmp_path, "--periodic", "x", "--box", "0,4,0,4")
    assert [couples[0]["sx"], couples[0]["sy"]] == ["-1", "0"]
    with Watched(browser, path) as watched:
        page = watched.page
        page.mouse.click(*page.evaluate("fdem.project(0)"))
        assert page.locator("#picked tbody td").all_text_contents() == ["20", "0.75", "0.25", "-1 0"]
        page.mouse.click(*page.evaluate("fdem.project(1)"))
        assert page.locator("#picked tbody td").all_text_contents() == ["10", "0.75", "0.25", "1 0"]
        watched.check()


@pytest.mark.parametrize("rows", ["", "0,0,0,1\n", "0,0,0,0\n0,0,0,0\n"])
def test_none_one_and_points_in_one_place(browser, tmp_path, rows):
    packing = tmp_path / "few.csv"
    packing.write_text("x,y,z,r\n" + rows)
    path, _ = contacts(packing, tmp_path)
    with Watched(browser, path) as watched:
        assert watched.page.text_content("#table-count").startswith(str(rows.count("\n")))
        assert math.isfinite(watched.state()["scale"])
        watched.check()
