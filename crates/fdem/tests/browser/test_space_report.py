"""The page of a run in three dimensions in a browser: real clicks and keys in headless Chromium, without a network.

SPACE_REPORT: the example `space_report` (default: target/release/examples/space_report beside the sources). CHROMIUM and FDEM_SHOTS: as in test_run_report.py.
"""

import json
import math
import os
import subprocess

import pytest

from canvas import UPLOADS
from test_run_report import ROOT, Watched, browser, number  # noqa: F401 (a fixture)

SPACE_REPORT = os.environ.get("SPACE_REPORT", str(ROOT / "target/release/examples/space_report"))
FACETS = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))
MODES = ("tension", "shear", "mixed")
FRAMES = 10


def run(folder, *arguments):
    subprocess.run([SPACE_REPORT, str(folder), *map(str, arguments)], check=True, capture_output=True)
    return folder / "report.html"


class Body:
    """A snapshot, and what is seen of it: found anew, by comparing facets by their vertices."""

    def __init__(self, file):
        self.__dict__.update(json.loads(file.read_text()))
        self.corners = [[self.positions[node] for node in nodes] for nodes in self.elements]
        self.broken = [crack for crack in self.cracks if crack["time"] is not None]

    def mean(self, element, name):
        nodes = self.elements[element]
        return [sum(getattr(self, name)[node][axis] for node in nodes) / 4 for axis in range(3)]

    def front(self, eye, u, v, visible=lambda element: True):
        """The element whose facet is nearest to the eye at a point of the view, among all facets of all elements, and its distance to the next edge."""
        right, up, toward = eye
        best = (-math.inf, None, 0)
        for element, corners in enumerate(self.corners):
            if not visible(element):
                continue
            flat = [[sum(a * b for a, b in zip(row, corner)) for row in (right, up, toward)] for corner in corners]
            for facet in FACETS:
                p, q, r = ((flat[k][0] - u, flat[k][1] - v, flat[k][2]) for k in facet)
                areas = (q[0] * r[1] - r[0] * q[1], r[0] * p[1] - p[0] * r[1], p[0] * q[1] - q[0] * p[1])
                total = sum(areas)
                if total == 0 or min(a / total for a in areas) < 0:
                    continue
                depth = (areas[0] * p[2] + areas[1] * q[2] + areas[2] * r[2]) / total
                if depth > best[0]:
                    best = (depth, element, min(a / total for a in areas))
        return best


@pytest.fixture(scope="session")
def plate(tmp_path_factory):
    """A plate that a block strikes: its page, its last snapshot and its first."""
    folder = tmp_path_factory.mktemp("plate")
    page = run(folder, 6, FRAMES)
    return page, Body(folder / f"expected_{FRAMES - 1:04}.json"), Body(folder / "expected_0000.json")


class Space(Watched):
    def eye(self):
        """Directions of the view, and a function from pixels of the page to metres to the right and up."""
        state = {**self.page.evaluate("fdem.space()"), **self.state(), **self.page.evaluate("fdem.canvas()")}
        s, c, t, u = math.sin(state["yaw"]), math.cos(state["yaw"]), math.sin(state["pitch"]), math.cos(state["pitch"])
        rows = ((c, s, 0), (-t * s, t * c, u), (u * s, -u * c, t))
        middle = [sum(a * b for a, b in zip(row, state["middle"])) for row in rows]

        def metres(x, y):
            right = state["pan"][0] + (x - state["left"] - state["width"] / 2) / state["scale"]
            up = state["pan"][1] - (y - state["top"] - (state["height"] - state["foot"]) / 2) / state["scale"]
            return right * state["unit"] + middle[0], up * state["unit"] + middle[1]

        return rows, metres

    def space(self):
        return self.page.evaluate("fdem.space()")

    def points(self, count):
        """Points of the view, on a grid."""
        box = self.page.locator("#canvas").bounding_box()
        return [
            (box["x"] + box["width"] * (0.15 + 0.7 * i / count), box["y"] + box["height"] * (0.2 + 0.55 * j / count))
            for i in range(count)
            for j in range(count)
        ]

    def pick(self, x, y):
        self.page.mouse.click(x, y)
        return self.page.evaluate("fdem.picked()")

    def colours(self):
        """Counts of the colours on the canvas."""
        self.pixels()
        data = self.page.evaluate(
            """(() => {
              const canvas = document.getElementById("canvas"), gl = canvas.getContext("webgl2"), data = new Uint8Array(4 * canvas.width * canvas.height);
              gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, data);
              const counts = {};
              for (let k = 0; k < data.length; k += 4) {
                const [r, g, b] = data.subarray(k, k + 3), kind = r > 1.6 * g && b > 1.6 * g ? "magenta" : r > 1.25 * g && g > 1.6 * b ? "orange" : "other";
                counts[kind] = (counts[kind] ?? 0) + 1;
              }
              return counts;
            })()"""
        )
        return data


def test_a_click_reads_the_element_that_is_seen_there(browser, plate):  # noqa: F811
    path, last, _ = plate
    with Space(browser, path) as watched:
        watched.arrived(FRAMES - 1)
        for yaw, pitch in ((None, None), (2.6, -0.3)):
            if yaw is not None:
                watched.page.evaluate(f"fdem.turn({yaw}, {pitch})")
            eye, metres = watched.eye()
            hits, misses = 0, 0
            for x, y in watched.points(9):
                _, element, margin = last.front(eye, *metres(x, y))
                picked = watched.pick(x, y)
                if element is None:
                    assert picked == -1
                    misses += 1
                elif margin > 0.05:
                    # An element right behind a facet of two elements that touch is as near.
                    assert picked == element or abs(last.front(eye, *metres(x, y))[0] - last.front(eye, *metres(x, y), lambda k: k == picked)[0]) < 1e-5
                    hits += picked == element
            assert hits > 12 and misses > 5, (hits, misses)
        x, y = next(point for point in watched.points(9) if watched.pick(*point) >= 0)
        element = watched.pick(x, y)
        nodes = last.elements[element]
        assert watched.fact("element") == f"{element:,}"
        assert watched.fact("body") == ["plate", "block"][last.bodies[element]]
        assert watched.fact("material") == ["rock", "steel"][last.materials[element]]
        assert watched.fact("fragment") == str(last.fragments[element])
        xx, yy, zz, xy, yz, xz = last.stresses[element]
        mises = math.sqrt(((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * (xy**2 + yz**2 + xz**2))
        stress = max(abs(x) for row in last.stresses for x in row)
        place = last.mean(element, "positions")
        for name, expected, scale in (
            ("x", place[0], 0.2),
            ("y", place[1], 0.2),
            ("z", place[2], 0.2),
            ("largest principal stress", last.principal[element][0], stress),
            ("smallest principal stress", last.principal[element][1], stress),
            ("von Mises stress", mises, 2 * stress),
            ("largest shear stress", (last.principal[element][0] - last.principal[element][1]) / 2, stress),
            ("velocity", math.hypot(*last.mean(element, "velocities")), 60),
            ("displacement", math.hypot(*last.mean(element, "displacements")), 0.01),
            ("damage", last.damage[element], 1),
        ):
            assert abs(number(watched.fact(name)) - expected) <= 2e-4 * scale, name
        assert len(nodes) == 4
        watched.page.wait_for_selector("#overlay polygon", state="attached")
        watched.shot("space-picked")
        watched.check()


def test_a_run_plays_to_its_end(browser, plate):  # noqa: F811
    with Space(browser, plate[0]) as watched:
        page = watched.page
        assert watched.state()["frame"] == FRAMES - 1, "the end is shown first"
        page.select_option("#speed", "6")
        page.click("#play")
        watched.until(lambda state: state["playing"] and state["frame"] < FRAMES - 1)
        watched.until(lambda state: not state["playing"] and state["frame"] == FRAMES - 1)
        page.focus("#frame")
        page.keyboard.press("Home")
        watched.arrived(0)
        first = watched.pixels()
        # The cursor of a plot goes from the beginning of its curves to their end.
        ends = """(() => {
            const plot = document.querySelector(".plots svg"), boxes = Array.from(plot.querySelectorAll(".curve"), (curve) => curve.getBBox());
            const cursor = plot.querySelector(".cursor");
            return [Number(cursor.getAttribute("x1")), Math.min(...boxes.map((box) => box.x)), Math.max(...boxes.map((box) => box.x + box.width)), cursor.getAttribute("visibility")];
        })()"""
        at, begin, end, visibility = page.evaluate(ends)
        assert abs(at - begin) < 12 and at < end - 100 and visibility == "visible"
        page.evaluate(f"fdem.show({FRAMES - 1})")
        watched.arrived(FRAMES - 1)
        at, _, end, _ = page.evaluate(ends)
        assert at == pytest.approx(end, abs=0.2)
        page.evaluate("fdem.show(0)")
        watched.arrived(0)
        assert page.text_content("#fragments") == "2 pieces"
        page.click(f'#table-body button[data-frame="{FRAMES - 1}"]')
        watched.arrived(FRAMES - 1)
        assert watched.pixels() != first
        cells = page.locator("#table-body tr").nth(FRAMES - 1).locator("td").all_text_contents()
        last = plate[1]
        assert int(cells[2]) == max(last.fragments) + 1 > 2
        areas = [sum(crack["area"] for crack in last.broken if crack["mode"] == mode) for mode in range(3)]
        assert [float(cell) for cell in cells[4:8]] == pytest.approx([sum(areas), *areas], rel=1e-5)
        # The heaviest fragments of the plate; the block cannot break and does not count.
        pieces = page.locator("#fragments-table tbody tr")
        inside = {last.fragments[k] for k in range(len(last.fragments)) if last.bodies[k] == 0}
        assert pieces.count() == min(len(inside), 20) > 1
        masses = [float(pieces.nth(k).locator("td").nth(3).text_content()) for k in range(pieces.count())]
        assert masses == sorted(masses, reverse=True)
        assert {pieces.nth(k).locator("td").nth(1).text_content() for k in range(pieces.count())} == {"plate"}
        watched.check()


def test_the_view_turns_zooms_and_moves(browser, plate):  # noqa: F811
    with Space(browser, plate[0]) as watched:
        page = watched.page
        seen = watched.pixels()
        home = watched.space()
        box = page.locator("#canvas").bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x + 90, y + 30, steps=5)
        page.mouse.up()
        turned = watched.space()
        assert turned["yaw"] < home["yaw"] and turned["pitch"] > home["pitch"]
        watched.drawn(lambda picture: picture != seen)
        assert page.evaluate("fdem.picked()") == -1, "a drag does not pick"
        page.click("#reset")
        watched.pixels()
        assert watched.space() == home
        page.focus("#canvas")
        page.keyboard.press("r")
        watched.drawn(lambda picture: picture == seen)
        for key in ("ArrowLeft", "ArrowUp", "Shift+ArrowRight", "+"):
            before = watched.pixels()
            page.keyboard.press(key)
            watched.drawn(lambda picture, before=before: picture != before)
        assert watched.state()["zoomed"] == 1.25 and watched.state()["pan"][0] != 0
        page.keyboard.press("r")
        watched.drawn(lambda picture: picture == seen)
        place = (round(x - 60), round(y + 20))
        _, metres = watched.eye()
        before = metres(*place)
        page.mouse.move(*place)
        page.mouse.wheel(0, -300)
        watched.until(lambda state: state["zoomed"] > 1.4)
        _, metres = watched.eye()
        assert metres(*place) == pytest.approx(before, abs=1e-6), "what is under the pointer stays"
        watched.check()


def test_nothing_is_uploaded_while_the_view_turns(browser, plate):  # noqa: F811
    with Space(browser, plate[0], UPLOADS) as watched:
        page = watched.page
        page.select_option("#cut-axis", "1")
        seen = [watched.pixels()]
        loaded = page.evaluate("uploads")
        assert loaded > 0
        page.evaluate("fdem.turn(2.1, 0.2)")
        seen.append(watched.pixels())
        page.click("#zoom-in")
        seen.append(watched.pixels())
        page.focus("#canvas")
        for key in ("ArrowLeft", "Shift+ArrowRight"):
            page.keyboard.press(key)
            seen.append(watched.pixels())
        page.select_option("#solid", "translucent")
        seen.append(watched.pixels())
        assert len(set(seen)) == 6 and page.evaluate("uploads") == loaded
        page.locator("#cut").fill("300")
        watched.drawn(lambda picture: picture != seen[-1])
        assert page.evaluate("uploads") > loaded
        watched.check()


def test_a_cut_shows_the_inside(browser, plate):  # noqa: F811
    path, last, _ = plate
    with Space(browser, path) as watched:
        page = watched.page
        whole = watched.pixels()
        for axis in "012":
            page.select_option("#cut-axis", axis)
            # The plate is at the bottom, the block above it.
            page.locator("#cut").fill("150" if axis == "2" else "500")
            watched.drawn(lambda picture: picture != whole)
            space = watched.space()
            assert space["section"] > 20 and page.is_hidden("#cut-open")
            normal, far = space["plane"][:3], space["plane"][3] * space["unit"] + sum(a * b for a, b in zip(space["plane"], space["middle"]))
            eye, metres = watched.eye()
            crossed = 0
            for x, y in watched.points(8):
                u, v = metres(x, y)
                picked = watched.pick(x, y)
                if picked < 0:
                    continue
                corners = last.corners[picked]
                sides = [sum(a * b for a, b in zip(normal, corner)) - far for corner in corners]
                assert min(sides) < 1e-6, "what is beyond the plane is not seen"
                if min(sides) < 0 < max(sides):
                    # The point of the plane that is seen there.
                    depth = (far - sum(n * (u * r + v * w) for n, r, w in zip(normal, eye[0], eye[1]))) / sum(n * t for n, t in zip(normal, eye[2]))
                    point = [u * r + v * w + depth * t for r, w, t in zip(*eye)]
                    crossed += inside(point, corners)
            assert crossed > 4, (axis, crossed)
        watched.shot("space-cut")
        cut = watched.pixels()
        page.check("#cut-flip")
        watched.drawn(lambda picture: picture != cut)
        page.uncheck("#cut-flip")
        watched.drawn(lambda picture: picture == cut)
        page.focus("#cut")
        page.keyboard.press("ArrowLeft")
        watched.drawn(lambda picture: picture != cut)
        assert page.text_content("#cut-text").startswith("z = ")
        page.select_option("#cut-axis", "view")
        before = watched.space()["plane"]
        page.evaluate("fdem.turn(1.5, 0.2)")
        assert watched.space()["plane"] == before
        page.click("#cut-here")
        assert watched.space()["plane"] != before
        page.evaluate("fdem.turn(Math.PI / 6, Math.PI / 9)")
        page.select_option("#cut-axis", "none")
        page.keyboard.press("Escape")
        watched.drawn(lambda picture: picture == whole)
        watched.check()


def inside(point, corners):
    """Whether a point is in a tetrahedron, by its volumes with each facet."""

    def volume(a, b, c, d):
        u, v, w = ([x - y for x, y in zip(p, a)] for p in (b, c, d))
        return u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0]) + u[2] * (v[0] * w[1] - v[1] * w[0])

    total = volume(*corners)
    parts = [volume(*(point if k == j else corner for j, corner in enumerate(corners))) / total for k in range(4)]
    return min(parts) > -1e-3


def test_a_page_without_the_inside_says_so(browser, tmp_path):  # noqa: F811
    path = run(tmp_path, 8, 0, 0)
    with Space(browser, path) as watched:
        page = watched.page
        assert "The page has those at the surface" in page.text_content("#inside")
        assert not page.evaluate("fdem.solid()") and page.is_hidden("#cut-open")
        before = watched.pixels()
        page.select_option("#cut-axis", "0")
        watched.drawn(lambda picture: picture != before)
        assert page.is_visible("#cut-open") and watched.space()["section"] == 0
        assert watched.space()["facets"] == 12 * 64
        page.fill("#find-id", str(6 * (4 + 8 * (4 + 8 * 4))))
        page.keyboard.press("Enter")
        assert "is not in this frame" in page.text_content("#picked")
        watched.check()


def test_fields_have_their_colours_and_legends(browser, plate):  # noqa: F811
    with Space(browser, plate[0]) as watched:
        page = watched.page
        seen = {}
        for key in page.locator("#field option").evaluate_all("all => all.map((one) => one.value)"):
            page.select_option("#field", key)
            name = page.locator(f'#field option[value="{key}"]').text_content()
            assert (name in page.text_content("#legends")) == (key not in ("body", "material", "fragment"))
            seen[key] = watched.pixels()
        # The two bodies have different materials.
        assert len(seen) >= 9 and len(set(seen.values())) == len(seen) - 1 and seen["body"] == seen["material"]
        page.select_option("#field", "von_mises")
        same = page.text_content("#legends .ends")
        page.select_option("#range", "frame")
        assert page.text_content("#legends .ends") != same
        for name in ("cracks", "outlines", "mesh"):
            before = watched.pixels()
            page.click(f"#show-{name}")
            watched.drawn(lambda picture, before=before: picture != before)
            page.click(f"#show-{name}")
            watched.drawn(lambda picture, before=before: picture == before)
        watched.check()


def test_cracks_are_seen_on_their_own(browser, plate):  # noqa: F811
    path, last, _ = plate
    with Space(browser, path) as watched:
        page = watched.page
        items = page.locator("#legends .cracks span").all_text_contents()
        areas = {MODES[mode]: sum(crack["area"] for crack in last.broken if crack["mode"] == mode) for mode in range(3)}
        units = {"m²": 1, "cm²": 1e-4, "mm²": 1e-6}
        for item in items:
            name, value, unit = item.split()
            assert float(value) * units[unit] == pytest.approx(areas.pop(name), rel=6e-3)
        assert all(area == 0 for area in areas.values())
        page.select_option("#solid", "hidden")
        hidden = watched.colours()
        assert hidden.get("magenta", 0) + hidden.get("orange", 0) > 3000, hidden
        watched.shot("space-cracks")
        eye, metres = watched.eye()
        found = 0
        for x, y in watched.points(8):
            picked = watched.pick(x, y)
            if picked < 0:
                continue
            mine = [crack for crack in last.broken if picked in crack["elements"]]
            assert mine, "only elements at cracks are picked"
            told = [watched.fact("crack" if k == 0 else f"crack {k + 1}") for k in range(len(mine))]
            modes = sorted(text.split(",")[0] for text in told)
            assert modes == sorted(MODES[crack["mode"]] for crack in mine)
            openings = sorted(number(text.split("opening ")[1]) for text in told)
            scale = max(abs(crack["opening"]) for crack in last.broken)
            assert openings == pytest.approx(sorted(crack["opening"] for crack in mine), abs=1e-2 * scale)
            found += 1
        assert found > 3
        page.keyboard.press("Escape")
        before = watched.pixels()
        page.select_option("#solid", "translucent")
        watched.drawn(lambda picture: picture != before)
        watched.shot("space-translucent")
        page.uncheck("#show-cracks")
        assert watched.colours().get("magenta", 0) < hidden.get("magenta", 0) / 10 + 50
        watched.check()


def test_fragments_move_apart_and_bodies_are_hidden(browser, plate):  # noqa: F811
    path, last, _ = plate
    with Space(browser, path) as watched:
        page = watched.page
        assert page.text_content("#fragments") == f"{max(last.fragments) + 1} pieces"
        page.select_option("#field", "fragment")
        whole = watched.pixels()
        page.locator("#explode").fill("40")
        apart = watched.drawn(lambda picture: picture != whole)
        assert page.text_content("#explode-text") == "40 %"
        watched.shot("space-apart")
        page.select_option("#cut-axis", "1")
        watched.drawn(lambda picture: picture != apart)
        page.select_option("#cut-axis", "none")
        page.locator("#explode").fill("0")
        watched.drawn(lambda picture: picture == whole)
        # The block is hidden: what is behind it is seen and picked.
        page.click("#bodies-field summary")
        facets = watched.space()["facets"]
        page.uncheck('#bodies input[data-body="1"]')
        assert watched.space()["facets"] == facets - 12 * 9
        watched.drawn(lambda picture: picture != whole)
        eye, metres = watched.eye()
        for x, y in watched.points(6):
            picked = watched.pick(x, y)
            _, element, margin = last.front(eye, *metres(x, y), lambda k: last.bodies[k] == 0)
            assert picked < 0 or last.bodies[picked] == 0
            assert (picked < 0) == (element is None) or margin < 0.05
        page.click("#no-bodies")
        assert watched.space()["facets"] == 0
        page.click("#all-bodies")
        assert watched.space()["facets"] == facets
        page.keyboard.press("Escape")
        watched.drawn(lambda picture: picture == whole)
        watched.check()


def test_everything_is_reached_by_the_keyboard(browser, plate):  # noqa: F811
    with Space(browser, plate[0]) as watched:
        page = watched.page
        page.evaluate("fdem.show(4)")
        watched.arrived(4)
        page.select_option("#cut-axis", "0")
        reached = []
        for _ in range(32):
            page.keyboard.press("Tab")
            reached.append(page.evaluate("document.activeElement.id || document.activeElement.tagName"))
            assert page.evaluate("getComputedStyle(document.activeElement).outlineStyle") != "none", reached
        names = "theme canvas zoom-in reset field range solid show-cracks show-outlines show-mesh cut-axis cut cut-flip explode SUMMARY find-id play previous next frame speed"
        for name in names.split():
            assert name in reached, (name, reached)
        unnamed = page.evaluate(
            """Array.from(document.querySelectorAll("input, select, button")).filter((one) => !one.labels?.length && !one.getAttribute("aria-label") && !one.textContent.trim()).map((one) => one.id)"""
        )
        assert unnamed == []
        watched.check()


def test_dark_mode_and_a_narrow_window(browser, plate):  # noqa: F811
    background = "getComputedStyle(document.body).backgroundColor"
    with Space(browser, plate[0], color_scheme="dark") as watched:
        page = watched.page
        dark, seen = page.evaluate(background), watched.pixels()
        watched.shot("space-dark-whole")
        page.select_option("#solid", "hidden")
        watched.shot("space-dark-cracks")
        page.select_option("#solid", "opaque")
        page.click("#theme")
        assert page.evaluate(background) != dark
        watched.drawn(lambda picture: picture != seen)
        page.click("#theme")
        watched.drawn(lambda picture: picture == seen)
        for width in (700, 360):
            page.set_viewport_size({"width": width, "height": 800})
            page.wait_for_timeout(100)
            assert page.evaluate("document.documentElement.scrollWidth") <= width
            watched.shot(f"space-{width}-whole")
        x, y = page.evaluate("fdem.project(0)")
        assert 0 < x < 360
        watched.check()


def test_without_webgl_the_rest_of_the_page_stands(browser, plate):  # noqa: F811
    with Space(browser, plate[0], "HTMLCanvasElement.prototype.getContext = () => null") as watched:
        page = watched.page
        assert page.evaluate("document.querySelector('#preview img').naturalWidth") >= 600
        assert "no WebGL2" in page.text_content("#why") and not page.is_visible("#player")
        assert page.locator("#table-body tr").count() == FRAMES and page.locator(".plots svg").count() == 3
        watched.check()


def test_a_browser_that_cannot_inflate(browser, plate):  # noqa: F811
    with Space(browser, plate[0], "delete window.DecompressionStream") as watched:
        watched.page.evaluate("fdem.show(2)")
        watched.arrived(2)
        assert watched.space()["facets"] > 0
        watched.check()


def test_the_surface_of_many_elements_is_small_and_drawn(browser, tmp_path):  # noqa: F811
    path = run(tmp_path, 40, 0, 0)
    assert path.stat().st_size < 2_000_000
    with Space(browser, path) as watched:
        assert "384,000 elements" in watched.page.text_content(".lead")
        assert watched.space()["facets"] == 12 * 40**2
        before = watched.pixels()
        watched.page.evaluate("fdem.turn(2, 0.3)")
        watched.drawn(lambda picture: picture != before)
        picked = [watched.pick(*point) for point in watched.points(4)]
        assert sum(element >= 0 for element in picked) > 4
        watched.check()
