"""The page of `sdfstent app` in a real browser: the synthetic patient treated by clicks."""

import base64
import io
import json
import re
import stat
import zipfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from tube_files import write_wall

playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")

from app_server import CHROMIUM, IS_APP_INSTALLED, QUIET, AppServer, get  # noqa: E402
from PIL import Image  # noqa: E402
from polydata_cases import read_by_vtk  # noqa: E402
from segmentations import FORK, named, voxels, write  # noqa: E402

from benchmarks.phantoms import (  # noqa: E402
    branching_pulmonary_artery,
    cavopulmonary_connection,
    straight_tube,
)
from SDFStentLib.files import (  # noqa: E402
    add_arrays,
    encode_vtp,
    polydata_from_arrays,
    polydata_from_lines,
    set_face_names,
)
from SDFStentLib.flow import Inflow, known_flow  # noqa: E402
from SDFStentLib.plan import Plan, save_plan  # noqa: E402
from SDFStentLib.stent import AtCenter, InputFile, Stent  # noqa: E402

DAMAGED = {
    "cut.stl": (
        b"solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0\n",
        "cut short, write it again",
    ),
    "boasting.stl": (bytes(83) + b"\x80" + bytes(200), "got 284; it is cut short"),
    "beyond.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99\n", "expected point indices from 0 to 2"),
    "cut.ply": (b"ply\nformat ascii 1.0\nelement vertex 9\n", "expected a header that ends"),
    "cut.json": (b"{", "cut.json: expected a JSON document"),
    "other.json": (b"[]", "this is no plan"),
}
"""Contents that a browser sends, and what is said of them."""

UNNAMED = """() => [...document.querySelectorAll('input, select, button, img')]
.filter(one => !(one.labels?.length || one.ariaLabel || one.alt || one.textContent.trim()))
.map(one => one.outerHTML)"""
"""What a screen reader could only call by its kind."""

REMEMBERED = """label => { window.texts = [];
new MutationObserver(() => window.texts.push(label.innerText)).observe(
  label, {childList: true, characterData: true, subtree: true}); }"""
"""All texts that a label shows from now on, however shortly."""
EDITED_WHILE_WORKING = """range => { window.taken = 0;
const labels = [...document.querySelectorAll('.suffix')];
const working = labels.find(one => one.textContent === 'Working...');
const isWorking = () => working.style.display !== 'none';
new MutationObserver(() => { window.taken += isWorking(); }).observe(
  document.querySelector('[data-name="stentTable"]'),
  {subtree: true, childList: true, characterData: true});
window.dragging = setInterval(() => { if (isWorking()) {
  range.stepUp(); range.dispatchEvent(new Event('input')); } }, 100); }"""
"""Drag a slider while a file is made; count how often the list of stents shows it meanwhile."""
EDITED_AND_CLICKED = """button => {
const range = document.querySelector('[data-name="diameterSlider"] input[type="range"]');
for (const value of [11, 11.5, 12, 12.5]) {
  range.value = value; range.dispatchEvent(new Event('input')); }
button.click(); }"""
"""Faster than a hand, as it looks through a slow network."""
SENT_LATE = """button => {
const {state} = window.trame; const flush = state.flush.bind(state);
window.attempts = 0; state.dirtyKeys.add('surfacePath');
state.flush = async () => { window.attempts += 1; if (window.attempts > 3) await flush(); };
button.click(); }"""
DROPPED = """files => { const dataTransfer = new DataTransfer();
for (const [name, content] of files)
  dataTransfer.items.add(new File([Uint8Array.from(atob(content), c => c.charCodeAt(0))], name));
for (const kind of ['dragover', 'drop']) document.querySelector('.screen').dispatchEvent(
  new DragEvent(kind, {dataTransfer, bubbles: true, cancelable: true})); }"""
"""Files that fall on the view."""
PATIENCE_MS = 300_000
"""Nothing is waited for longer, and so long only for what fails: a busy machine takes its time."""
playwright.expect.set_options(timeout=PATIENCE_MS)

pytestmark = [
    pytest.mark.skipif(not IS_APP_INSTALLED, reason="the extra app is not installed"),
    pytest.mark.skipif(
        CHROMIUM is None, reason="no Chromium: apt-get install chromium, or name it in CHROMIUM"
    ),
]


def polydata_from_vtp(content, folder):
    """What is in such a file."""
    (folder / "kept.vtp").write_bytes(content)
    return read_by_vtk(folder / "kept.vtp")


@pytest.fixture(scope="module")
def a_browser():
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=list(QUIET))
        yield browser
        browser.close()


@pytest.fixture(scope="module")
def the_folder(tmp_path_factory):
    """What the pages may open: a damaged file, a mesh, the synthetic patient in cm and a plan."""
    folder = tmp_path_factory.mktemp("folder")
    (folder / "cm").mkdir()
    artery = branching_pulmonary_artery()
    write_wall(folder / "cm" / "wall.vtp", artery.points / 10, artery.triangles)
    line = artery.centerline
    paths = [line.ancestry(leaf) for leaf in line.leaves]
    lines = polydata_from_lines(line.points / 10, paths)
    add_arrays(lines, {"Radius": line.inscribed_radius / 10}, None)
    (folder / "cm" / "lines.vtp").write_bytes(encode_vtp(lines))
    files = {"surface": {"file": "cm/wall.vtp"}, "centerline": {"file": "cm/lines.vtp"}}
    center = (line.points[line.ancestry(line.leaves[0])[40]] / 10).tolist()
    stent = {"name": "Planned", "diameter": 9, "length": 12, "placement": {"center": center}}
    plan = {
        "schema": "sdfstent-plan",
        "version": 2,
        "inputs": {**files, "units": "cm", "frame": None},
    }
    plan = {**plan, "stents": [stent], "settings": {}}
    (folder / "plan.json").write_text(json.dumps(plan), encoding="utf-8")
    tube = straight_tube(radius=4.0, length=12.0, edge_length=2.0)
    write_wall(folder / "mesh.vtp", tube.points - [0, 0, 6], tube.triangles)
    (folder / "damaged.vtp").write_text("<VTKFile type='PolyData'><PolyData>", encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def the_server(tmp_path_factory, the_folder):
    workshop = tmp_path_factory.mktemp("workshop")
    plan = the_folder / "plan.json"
    server = AppServer(workshop, plan, "--folder", the_folder, "--keep", "300")
    yield server
    said = server.interrupt()
    assert said == ""
    assert list(workshop.iterdir()) == []


def is_centerline(red, green, blue):
    return (blue > red + 35) & (blue < red + 80) & (blue > green + 20)  # seen through the wall


def is_selected_lesion(red, green, blue):
    return (red > blue + 110) & (red > green + 60)


def is_mark(red, green, blue):
    return (red > green + 40) & (green > blue + 90)


TELL_REFUSED = """window.addEventListener('unhandledrejection', event => {
  console.error(JSON.stringify(event.reason));
});"""
"""What a call was refused with is an object, of which the browser tells no more than that."""


SEEN_FOR_LONG = "window.performance.now = () => 10000"
"""One that fails before, ms, is not loaded again by itself."""


class Visit:
    """A page in the browser, by the names of the panel's widgets."""

    def __init__(self, browser, address, size=(960, 600)):
        """The fewer pixels, the less there is to draw."""
        self.context = browser.new_context(viewport={"width": size[0], "height": size[1]})
        self.context.set_default_timeout(PATIENCE_MS)
        self.page = self.context.new_page()
        self.asked, self.errors = [], []
        self.page.on("request", lambda request: self.asked.append(request.url))
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.on("console", self._on_console)
        self.page.add_init_script(TELL_REFUSED)
        self.page.goto(address)
        self.named("deployButton").wait_for()

    def _on_console(self, message):
        if message.type in ("error", "warning"):
            self.errors.append(message.text)

    def left(self):
        """The errors until the page is left; what it says while its line is cut is no user's."""
        errors = list(self.errors)
        self.context.close()
        return errors

    def named(self, name):
        return self.page.locator(f'[data-name="{name}"]')

    def text(self, name):
        return self.named(name).inner_text()

    def until_drawn(self):
        """Wait until the view's picture is as large as the view: that may take its time."""
        for _attempt in range(500):
            screen = self.page.locator(".screen").bounding_box()
            size = np.array([screen["height"], screen["width"]])
            if np.abs(self.picture().shape - size).max() < 1:
                return
            self.page.wait_for_timeout(200)
        raise AssertionError(f"the view is {screen}, its picture {self.picture().shape}")

    def number(self, name):
        return self.named(name).locator('input[type="number"]')

    def slider(self, name):
        return self.named(name).locator('input[type="range"]')

    def until(self, name, words):
        """Wait until a widget shows these words."""
        try:
            self.named(name).filter(has_text=words).wait_for()
        except playwright.TimeoutError as error:
            said = [self.text(one) for one in ("message", "statusLabel", "lumenLabel", name)]
            raise AssertionError(f"{name} does not say {words}: {said}") from error

    def open_parts(self):
        """Unfold all parts of the panel."""
        closed = self.page.locator("details[data-name$=CollapsibleButton]:not([open])")
        closed.evaluate_all("all => all.forEach(one => { one.open = true; })")

    def until_empty(self, name):
        """Wait until a table has no rows."""
        rows = self.named(name).locator("tbody tr")
        playwright.expect(rows).to_have_count(0)

    def open_section(self):
        """Unfold where files are opened."""
        self.named("opening").evaluate("one => { one.open = true; }")

    def deploy(self):
        """Deploy, and wait until the surface is certified."""
        self.named("deployButton").click()
        self.until("certificateLabel", "Certified")

    def archive(self, name="savePlanButton"):
        """The ZIP that a button gives."""
        return zipfile.ZipFile(io.BytesIO(self.saved(name)))

    def click_lesion(self):
        """Click the first one, once they are found: until then their row says so."""
        self.until("lesionTable", "%")
        self.named("lesionTable").locator("td").first.click()

    def add_stent(self):
        rows = self.named("stentTable").locator("tbody tr")
        count = rows.count()
        self.named("addStentButton").click()
        try:
            rows.nth(count).wait_for()
        except playwright.TimeoutError as error:
            said = [self.text(one) for one in ("message", "statusLabel", "stentTable")]
            raise AssertionError(
                f"there were {count} stents, no other was added: {said}"
            ) from error

    def seen(self, is_of_it, share=0.9):
        """A pixel of the view that has the color of something, so far down."""
        frame = self.page.locator(".screen").bounding_box()
        for _attempt in range(1000):
            picture = self.page.screenshot(clip=frame)
            colors = np.array(Image.open(io.BytesIO(picture)).convert("RGB"), dtype=int)
            rows, columns = np.nonzero(is_of_it(*np.moveaxis(colors[:, :-120], 2, 0)))
            if len(rows) > 20:  # the axes in the corner were left out
                at = int(share * len(rows))
                return frame["x"] + float(columns[at]), frame["y"] + float(rows[at])
            self.page.wait_for_timeout(200)
        raise AssertionError("there is nothing of that color")

    def picture(self):
        """Where the vessel is seen in the picture of the view, (rows, columns)."""
        picture = Image.open(io.BytesIO(self.saved("pictureButton"))).convert("RGB")
        red, _, blue = np.moveaxis(np.array(picture, dtype=int), 2, 0)
        return red > blue + 20

    def center(self):
        """Where the one stent of the plan is, in RAS."""
        placed, turn = self.placed()
        return np.array(placed["center"]) * turn

    def placed(self):
        """The placement of the one stent of the plan, and what turns its points into RAS."""
        plan = json.loads(self.archive().read("plan.json"))
        turn = (-1, -1, 1) if plan["inputs"]["frame"] == "LPS" else (1, 1, 1)
        return plan["stents"][0]["placement"], turn

    def saved(self, name):
        try:
            with self.page.expect_download() as download:
                self.named(name).click()
        except playwright.TimeoutError as error:
            said = [self.text(one) for one in ("message", "statusLabel", name)]
            raise AssertionError(f"{name} gave no file: {said}") from error
        return Path(download.value.path()).read_bytes()


@pytest.fixture(scope="module")
def the_visit(a_browser, the_server):
    visit = Visit(a_browser, the_server.address)
    visit.until("stentTable", "Planned")  # the plan that the server was started with
    visit.until("stentTable", "9.0 mm")
    visit.until("lesionTable", "%")
    yield visit
    assert visit.left() == []
    own = (the_server.address, "data:", "blob:")
    assert [url for url in visit.asked if not url.startswith(own)] == []


@pytest.fixture
def a_visit(the_visit):
    """The one page, with the synthetic patient opened anew."""
    the_visit.open_section()
    the_visit.named("autoUpdateCheckBox").locator("input").uncheck()
    the_visit.named("demoButton").click()
    playwright.expect(the_visit.named("opening")).not_to_have_attribute("open", "")
    the_visit.until_empty("stentTable")
    the_visit.until("lesionTable", "%")
    the_visit.open_parts()
    return the_visit


def test_a_lesion_is_treated_by_two_stents_and_the_shell_repeats_the_plan(a_visit, tmp_path):
    from SDFStentLib.files import read_surface
    from SDFStentLib.plan import load_plan, run_plan

    screen = a_visit.page.locator(".screen").bounding_box()
    a_visit.click_lesion()
    a_visit.seen(is_selected_lesion)
    figure = a_visit.page.locator(".results figure")
    playwright.expect(figure).to_contain_text("Lesion 1: red lumen, dashed healthy vessel")
    playwright.expect(figure.locator("path")).to_have_count(2)
    figure.locator("svg").hover()
    a_visit.until("pointed", "healthy vessel")
    a_visit.seen(is_mark)
    a_visit.add_stent()
    a_visit.add_stent()
    a_visit.number("lengthSlider").fill("12")
    a_visit.number("lengthSlider").press("Enter")
    a_visit.deploy()
    a_visit.until("atHand", "certified for meshing")
    told = a_visit.text("atHand").splitlines()
    assert re.fullmatch(r"narrowest [\d.]+ -> [\d.]+ mm", told[1])
    assert len(told) <= 8
    twice = re.compile("Minimum lumen.*Minimum lumen", re.DOTALL)
    playwright.expect(a_visit.named("lumenLabel")).to_have_text(twice)
    assert a_visit.text("lumenLabel").count("Minimum lumen diameter") == 2
    assert "certificate" not in a_visit.text("statusLabel")
    assert a_visit.page.locator(".screen").bounding_box() == screen  # the view stays as it was
    lines = a_visit.page.locator(".results svg path")
    playwright.expect(lines).to_have_count(3)
    assert all(path.get_attribute("d").startswith("M") for path in lines.all())
    plot = a_visit.page.locator(".results svg")
    box = plot.bounding_box()
    # Near its upper edge: what is told of the place must not move the plot from under the pointer.
    a_visit.page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.1 * box["height"])
    a_visit.until("pointed", "before")
    assert plot.bounding_box() == box
    pointed = a_visit.text("pointed")
    a_visit.seen(is_mark)
    table = a_visit.page.locator(".results table")
    columns = table.locator("th").all_text_contents()
    seen = [row.locator("td").all_text_contents() for row in table.locator("tbody tr").all()]
    archive = a_visit.archive()
    archive.extractall(tmp_path)
    (tmp_path / "page.vtp").write_bytes(a_visit.saved("save-surface"))
    result = run_plan(load_plan(tmp_path / "plan.json"))
    assert [stent.stent.length for stent in result.treatment.stents][1] == 12
    by_page = read_surface(tmp_path / "page.vtp").points
    np.testing.assert_allclose(result.treatment.points, by_page, rtol=0, atol=1e-9)
    stent = result.treatment.stents[1]  # the one that was chosen last
    before, after = stent.around_before, stent.around_after
    rows = np.array([[float(text or "nan") for text in row] for row in seen])
    stations = np.abs(before.arc_length - rows[:, :1]).argmin(axis=1)
    measured = {
        "Before (mm)": before.inscribed_diameter,
        "After (mm)": after.inscribed_diameter,
        "Equivalent before (mm)": before.equivalent_diameter,
        "Equivalent after (mm)": after.equivalent_diameter,
    }
    assert len(rows) > 12
    for name, values in measured.items():
        of_page = rows[:, columns.index(name)]
        np.testing.assert_allclose(of_page, values[stations], rtol=0, atol=0.0501)
    told = re.fullmatch(r"(\S+) mm, before (\S+), after (\S+), prescribed .*", pointed)
    at = np.abs(before.arc_length - float(told[1])).argmin()
    values = [float(told[2]), float(told[3])]
    measured = [one.inscribed_diameter[at] for one in (before, after)]
    np.testing.assert_allclose(values, measured, rtol=0, atol=0.0501)
    report = a_visit.saved("save-report").decode()
    assert result.treatment.certificate.sentence()[:40] in report


def test_all_that_the_loop_needs_is_seen_without_scrolling(a_browser, the_server):
    visit = Visit(a_browser, the_server.address, (1280, 800))
    visit.until("lesionTable", "%")
    names = ("lesionTable", "stentTable", "suggestButton", "diameterSlider", "lengthSlider")
    boxes = {name: visit.named(name).bounding_box() for name in (*names, "deployButton")}
    assert all(box["y"] >= 0 and box["y"] + box["height"] <= 800 for box in boxes.values()), boxes
    clicks = ("lesionTable", "tbody td"), ("suggestButton", None)
    for name, inside in clicks:  # and a drag: from the vessel to the result
        one = visit.named(name)
        one = one.locator(inside).first if inside else one
        playwright.expect(one).to_be_enabled()  # the driver scrolls to what it has to wait for
        one.click()
        if name == "suggestButton":  # what is beneath moves down by a row
            playwright.expect(visit.named("stentTable").locator("tbody tr")).to_have_count(2)
    box = visit.slider("diameterSlider").bounding_box()
    middle = box["y"] + box["height"] / 2
    visit.page.mouse.move(box["x"] + 0.3 * box["width"], middle)
    visit.page.mouse.down()
    visit.page.mouse.move(box["x"] + 0.35 * box["width"], middle, steps=5)
    visit.page.mouse.up()
    visit.until("atHand", "certified")
    tiles = visit.named("tiles")
    playwright.expect(tiles).to_contain_text(re.compile(r"Narrowest lumen\s*[\d.]+ mm\s*before"))
    playwright.expect(tiles).to_be_in_viewport(ratio=1)
    assert visit.page.evaluate("document.querySelector('.panel').scrollTop + scrollY") == 0
    visit.open_parts()
    assert visit.page.evaluate(UNNAMED) == []
    assert visit.page.get_by_role("main").count() == 1
    visit.click_lesion()
    visit.seen(is_selected_lesion)
    visit.named("fitButton").click()
    split, mouse = visit.named("split"), visit.page.mouse
    begin = split.bounding_box()["x"]
    split.press("ArrowLeft")
    assert split.bounding_box()["x"] == begin - 20
    mouse.move(begin - 17, 400)
    mouse.down()
    mouse.move(603, 400)
    mouse.up()
    assert abs(split.bounding_box()["x"] - 603) < 4
    visit.until_drawn()
    sides = []
    for side in ("fromAnterior", "fromPosterior", "fromLeft"):
        visit.named(side).click()
        sides.append(visit.picture())
    assert sides[0].sum() > 1000
    behind = sides[1][:, ::-1]  # nothing is nearer, so nothing looks larger
    assert (sides[0] ^ behind).mean() < 0.02 < (sides[0] ^ sides[2]).mean()
    visit.page.emulate_media(color_scheme="dark")
    visit.seen(lambda red, green, blue: red + green + blue < 150)
    assert (sides[2] ^ visit.picture()).mean() < 0.02
    assert visit.left() == []


def test_what_is_edited_while_a_report_is_made_is_taken_at_once(a_visit):
    a_visit.add_stent()
    a_visit.slider("lengthSlider").evaluate(EDITED_WHILE_WORKING)
    assert b"<html" in a_visit.saved("save-report")
    taken = a_visit.page.evaluate("clearInterval(window.dragging), window.taken")
    assert taken > 0


@pytest.mark.parametrize("button", ["savePlanButton", "openButton"])
def test_what_is_edited_just_before_a_click_belongs_to_what_was_there(a_visit, the_folder, button):
    """A plan is saved with it; one that is opened by the click does not get it."""
    a_visit.add_stent()
    a_visit.open_section()
    a_visit.page.fill("#surfacePath", str(the_folder / "plan.json"))
    with a_visit.page.expect_download() as download:
        a_visit.named(button).evaluate(EDITED_AND_CLICKED)
        if button == "openButton":
            a_visit.until("stentTable", "Planned")
            a_visit.named("savePlanButton").click()
    archive = zipfile.ZipFile(download.value.path())
    (stent,) = json.loads(archive.read("plan.json"))["stents"]
    assert stent["diameter"] == (9.0 if button == "openButton" else 12.5)


def test_a_click_waits_while_what_was_edited_cannot_be_sent_yet(a_visit):
    """As when a call is under way: the first attempts to send what is edited send nothing."""
    a_visit.add_stent()
    with a_visit.page.expect_download() as download:
        a_visit.named("savePlanButton").evaluate(SENT_LATE)
    assert a_visit.page.evaluate("window.attempts") > 3
    assert zipfile.is_zipfile(download.value.path())


def test_what_is_opened_while_the_section_is_being_unfolded_folds_it(a_visit):
    a_visit.named("opening").evaluate("""one => {
        one.open = true;  // the browser tells the page of it later, after the click
        one.querySelector('[data-name="demoButton"]').click(); }""")
    playwright.expect(a_visit.named("opening")).not_to_have_attribute("open", "")


def test_a_page_has_loaded_what_it_uses_of_vtk_and_no_more(the_visit, the_server):
    paths = {Path(one.path).name for page in the_server.pages() for one in page.memory_maps()}
    loaded = {name.partition(".")[0] for name in paths}
    assert "vtkRenderingOpenGL2" in loaded
    assert not {"vtkRenderingLICOpenGL2", "vtkIOOggTheora", "vtkInfovisLayout"} & loaded


def test_numbers_follow_a_slider_while_it_is_dragged_and_expansion_goes_back(a_visit):
    a_visit.add_stent()
    a_visit.named("autoUpdateCheckBox").locator("input").check()
    a_visit.slider("diameterSlider").focus()
    before = float(a_visit.number("diameterSlider").input_value())
    a_visit.named("lumenLabel").evaluate(REMEMBERED)
    for _ in range(5):
        a_visit.page.keyboard.press("ArrowRight")
        a_visit.page.wait_for_timeout(100)
    a_visit.until("certificateLabel", "ertified")
    assert any("(preview)" in text for text in a_visit.page.evaluate("window.texts"))
    after = float(a_visit.number("diameterSlider").input_value())
    assert after == pytest.approx(before + 0.5, abs=0.06)
    a_visit.until("lumenLabel", f"prescribed {after:g} mm")
    a_visit.until("lumenLabel", f"{after:.1f} mm")
    playwright.expect(a_visit.slider("expansionSlider")).to_have_value("100")
    a_visit.slider("expansionSlider").fill("0")
    playwright.expect(a_visit.number("expansionSlider")).to_have_value("0")


def by_mouse(visit, way):
    """Drag along places in the window."""
    mouse = visit.page.mouse
    mouse.move(*way[0])
    visit.page.wait_for_timeout(300)  # a hand rests before it presses
    mouse.down()
    for place in way[1:]:
        mouse.move(*place)
        visit.page.wait_for_timeout(30)
    mouse.up()


def by_finger(visit, way):
    """The same on a screen that is touched."""
    session = visit.context.new_cdp_session(visit.page)
    steps = ["touchStart", *["touchMove"] * (len(way) - 1), "touchEnd"]
    for kind, place in zip(steps, [*way, None], strict=True):
        points = [dict(zip("xy", place, strict=True))] if place else []
        session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
        visit.page.wait_for_timeout(30)


def test_a_click_on_the_centerline_places_the_handle_and_mouse_and_finger_drag_it(a_visit):
    a_visit.add_stent()
    place = a_visit.named("placeWidget")
    place.click()
    screen = a_visit.page.locator(".screen").bounding_box()
    a_visit.page.mouse.click(screen["x"] + 5, screen["y"] + 5)
    a_visit.until("message", "expected a click on the centerline, got one beside it")
    playwright.expect(place).to_have_attribute("aria-pressed", "true")
    x, y = a_visit.seen(is_centerline)
    a_visit.page.mouse.click(x, y)
    playwright.expect(place).to_have_attribute("aria-pressed", "false")
    playwright.expect(a_visit.named("message")).to_have_text("")
    line = branching_pulmonary_artery().centerline
    for drag, up in (by_mouse, 10), (by_finger, -10):  # the main pulmonary artery, and back
        before = moved = a_visit.center()
        x, y = a_visit.seen(lambda red, green, blue: (blue > red + 80) & (blue > green + 30))
        drag(a_visit, [(x, y - up * step) for step in range(7)])
        for _attempt in range(600):  # let go, it is moved onto the line
            moved = a_visit.center()
            beside = np.linalg.norm(line.project(moved).point - moved)
            if beside < 1e-4 and np.linalg.norm(moved - before) > 2:
                break
            a_visit.page.wait_for_timeout(300)
        assert beside < 1e-4
        assert np.linalg.norm(moved - before) > 2


def test_a_wrong_file_is_a_sentence_and_the_page_goes_on(a_visit, the_folder):
    a_visit.open_section()
    for path, sentence in (
        ("/etc/passwd", "expected a file in a folder that was named at the start"),
        (the_folder / "damaged.vtp", "damaged.vtp"),
        (the_folder / "none.vtp", "none.vtp: expected a file, got none"),
    ):
        a_visit.page.fill("#surfacePath", str(path))
        a_visit.named("openButton").click()
        a_visit.until("message", sentence)
    upload = a_visit.named("surfacePath-upload")
    upload.set_input_files({"name": "notes.txt", "mimeType": "text/plain", "buffer": b"no"})
    a_visit.until("message", "notes.txt: expected a file that ends in .vtp")
    with (the_folder / "large.vtp").open("wb") as large:
        large.truncate(257 * 2**20)  # of nothing, on no disk
    upload.set_input_files(the_folder / "large.vtp")
    a_visit.until("message", "large.vtp: expected a file of at most 256 MB")
    a_visit.page.locator(".panel").evaluate("panel => panel.scrollTo(0, panel.scrollHeight)")
    playwright.expect(a_visit.named("demoButton")).not_to_be_in_viewport()
    playwright.expect(a_visit.named("message")).to_be_in_viewport(ratio=1)


@pytest.mark.parametrize("name", DAMAGED)
def test_a_damaged_file_that_is_sent_is_a_sentence_and_the_page_goes_on(the_visit, name):
    content, sentence = DAMAGED[name]
    the_visit.open_section()
    upload, path = the_visit.named("surfacePath-upload"), the_visit.page.locator("#surfacePath")
    upload.set_input_files({"name": name, "mimeType": "", "buffer": content})
    playwright.expect(path).to_have_value(re.compile(rf"uploads/{name}$"))
    the_visit.named("openButton").click()
    the_visit.until("message", sentence)
    assert "uploads" not in the_visit.text("message")


def test_a_plan_that_was_saved_is_opened_again_from_the_browsers_own_files(a_visit):
    a_visit.add_stent()
    archive = a_visit.archive()
    a_visit.open_section()
    upload, path = a_visit.named("surfacePath-upload"), a_visit.page.locator("#surfacePath")
    names = ("surface.vtp", "centerline.vtp")
    files = [(name, base64.b64encode(archive.read(name)).decode()) for name in names]
    a_visit.page.evaluate(DROPPED, files)
    playwright.expect(path).to_have_value(re.compile("uploads/surface.vtp$"))
    line = a_visit.page.locator("#centerlinePath")
    playwright.expect(line).to_have_value(re.compile("uploads/centerline.vtp$"))
    a_visit.page.evaluate(DROPPED, [("notes.txt", "")])
    a_visit.until("message", "notes.txt: expected a file that ends in .vtp")
    content = archive.read("plan.json")
    upload.set_input_files({"name": "plan.json", "mimeType": "", "buffer": content})
    playwright.expect(path).to_have_value(re.compile("uploads/plan.json$"))
    a_visit.named("removeStentButton").click()
    a_visit.until_empty("stentTable")
    a_visit.named("openButton").click()
    a_visit.until("stentTable", "Stent 1")
    playwright.expect(a_visit.named("message")).to_have_text("")
    again = a_visit.archive()
    assert again.read("surface.vtp") == archive.read("surface.vtp")
    placed = [json.loads(one.read("plan.json"))["stents"] for one in (archive, again)]
    assert placed[0] == placed[1]


def test_a_segmentation_that_is_dropped_becomes_a_vessel_with_its_centerline(a_visit, tmp_path):
    mask, low = voxels(FORK, 0.9)
    other = np.zeros_like(mask)
    other[:4, :4, :4] = True
    stack = np.stack([mask, other], axis=-1).astype(np.uint8)
    texts = named(artery=(1, 0), heart=(1, 1))
    scan = write(tmp_path / "two.seg.nrrd", stack, low, 0.9, texts=texts)
    ct = np.random.default_rng(1).integers(-1000, 400, mask.shape).astype(np.int16)
    path = a_visit.page.locator("#surfacePath")
    for file in (write(tmp_path / "ct.nii.gz", ct), scan):
        content = base64.b64encode(file.read_bytes()).decode()
        a_visit.page.evaluate(DROPPED, [(file.name, content)])
        playwright.expect(path).to_have_value(re.compile(f"uploads/{file.name}$"))
        a_visit.named("openButton").click()
        if file is not scan:
            a_visit.until("message", "ct.nii.gz: expected a segmentation")
            assert "uploads" not in a_visit.text("message")
    a_visit.until("message", "Segment: choose one of 2, then Open.")
    a_visit.named("lesionTable").wait_for()  # the former vessel is still there
    segment = a_visit.page.locator("#segment")
    assert segment.locator("option").all_inner_texts() == ["1 (artery)", "1 (heart)"]
    a_visit.named("openButton").click()
    a_visit.until("preparing", "Surface and centerline, ")
    a_visit.named("stopButton").click()
    playwright.expect(a_visit.named("preparing")).to_have_count(0)
    a_visit.named("openButton").click()
    a_visit.until("message", "Voxels of 0.9 mm: diameters")
    playwright.expect(a_visit.named("opening")).not_to_have_attribute("open", "")
    a_visit.add_stent()
    a_visit.deploy()
    plan = json.loads(a_visit.archive().read("plan.json"))
    assert plan["inputs"]["frame"] == "LPS"
    a_visit.open_parts()
    a_visit.named("extractButton").click()  # another one in place of the first
    a_visit.until("centerlineSelector", re.compile(r"surface\w* centerline"))
    again = a_visit.archive()
    assert json.loads(again.read("plan.json"))["inputs"]["centerline"]["file"] == "centerline.vtp"
    a_visit.named("undoButton").click()
    assert again.read("centerline.vtp") != a_visit.archive().read("centerline.vtp")


def test_a_page_may_begin_with_a_segmentation(a_browser, tmp_path):
    mask, low = voxels(FORK, 0.9)
    stack = np.stack([mask, np.roll(mask, 1, axis=0)], axis=-1).astype(np.uint8)
    texts = named(artery=(1, 0), heart=(1, 1))
    scan = write(tmp_path / "two.seg.nrrd", stack, low, 0.9, texts=texts)
    server = AppServer(tmp_path / "workshop", scan)
    visit = Visit(a_browser, server.address)
    visit.until("message", "Segment: choose one of 2, then Open.")
    visit.open_section()
    visit.named("openButton").click()
    visit.until("message", "Voxels of 0.9 mm: diameters")
    visit.add_stent()
    visit.context.close()
    server.close()


def test_a_fontan_is_told_from_each_caval_vein_and_its_inlets_are_set_in_the_page(
    a_visit, the_folder
):
    write_fontan(the_folder)
    a_visit.open_section()
    a_visit.page.fill("#surfacePath", str(the_folder / "fontan.json"))
    a_visit.named("openButton").click()
    a_visit.until("stentTable", "16.0 mm")
    a_visit.named("deployButton").click()
    a_visit.until("lumenLabel", "power loss of the connection")
    told = a_visit.text("lumenLabel")
    for vein, flow in (("inferior", "30.0"), ("superior", "20.0")):
        assert re.search(rf"from {vein} caval vein, {flow} mL/s drop .* -> .*; power loss", told)
    assert "indexed" in told
    a_visit.until("tiles", "Power lost")
    assert a_visit.number("bodySurfaceSpinBox").input_value() == "1.20"
    ends = a_visit.named("inletComboBox")
    playwright.expect(ends.locator("option")).to_have_count(4)
    ends.select_option(label="superior caval vein: 1.2 L/min")
    box = a_visit.number("inletFlowSpinBox")
    playwright.expect(box).to_have_value("1.20")
    box.fill("0.6")
    box.press("Enter")
    a_visit.until("lumenLabel", "from superior caval vein, 10.0 mL/s")
    playwright.expect(a_visit.number("flowMeanSpinBox")).to_have_value("2.40")
    ends.select_option(label="left pulmonary artery")
    playwright.expect(a_visit.named("inletCheckBox").locator("input")).not_to_be_checked()
    a_visit.named("unusualFlowCheckBox").locator("input").check()
    archive = a_visit.archive()
    flow = json.loads(archive.read("plan.json"))["flow"]
    assert [one["mean"] for one in flow["inlets"]] == pytest.approx([30.0, 10.0])
    assert (flow["bsa"], flow["unusual"]) == (1.2, True)
    # Another patient's vessel has no part in this flow.
    a_visit.open_section()
    a_visit.named("demoButton").click()
    a_visit.until("lesionTable", "40 %")
    playwright.expect(a_visit.number("flowMeanSpinBox")).to_have_value("0.00")
    playwright.expect(a_visit.number("bodySurfaceSpinBox")).to_have_value("0.00")


def test_a_stent_is_kept_at_a_lesion_and_on_a_branch(a_visit):
    a_visit.add_stent()
    a_visit.named("placementComboBox").select_option(label="At a lesion")
    a_visit.until("landmarkComboBox", "40 %")
    box = a_visit.number("landmarkSpinBox")
    box.fill("2")
    box.press("Enter")
    playwright.expect(box).to_have_value("2.0")
    assert a_visit.placed()[0] == {"lesion": 1, "offset": 2.0}
    a_visit.named("placementComboBox").select_option(label="On a branch")
    a_visit.named("landmarkComboBox").select_option(label="right pulmonary artery")
    box.fill("9.5")
    box.press("Enter")
    playwright.expect(box).to_have_value("9.5")
    assert a_visit.placed()[0] == {"branch": 3, "distance": 9.5}
    a_visit.deploy()


def write_fontan(folder):
    """The connection of both caval veins, and a plan with a stent in the conduit and two inlets."""
    fontan = cavopulmonary_connection(1.4)
    arrays = {"ModelFaceID": fontan.face_ids}
    wall = polydata_from_arrays(fontan.points, fontan.triangles, cell_arrays=arrays)
    set_face_names(wall, fontan.faces.names)
    line = fontan.centerline
    lines = polydata_from_lines(line.points, [line.ancestry(leaf) for leaf in line.leaves])
    for name, polydata in (("fontan", wall), ("fontan_lines", lines)):
        (folder / f"{name}.vtp").write_bytes(encode_vtp(polydata))
    stent = Stent(16.0, placement=AtCenter(fontan.throat.point), length=30.0)
    inlets = Inflow("inferior caval vein", 30.0), Inflow("superior caval vein", 20.0)
    plan = Plan(
        stents=(stent,),
        surface=InputFile(str(folder / "fontan.vtp")),
        centerline=InputFile(str(folder / "fontan_lines.vtp")),
        flow=known_flow(inlets=inlets, bsa=1.2),
    )
    save_plan(plan, folder / "fontan.json")


def test_alternatives_are_made_renamed_and_compared(a_visit):
    a_visit.click_lesion()
    a_visit.add_stent()
    a_visit.named("plansCollapsibleButton").evaluate("one => { one.open = true; }")
    a_visit.named("duplicatePlanButton").click()
    plans = a_visit.named("planTable").locator("tbody tr")
    playwright.expect(plans).to_have_count(2)
    a_visit.page.once("dialog", lambda dialog: dialog.accept("Wider"))
    plans.nth(1).locator("td").first.dblclick()
    a_visit.until("planTable", "Wider")
    a_visit.number("diameterSlider").fill("7.5")
    a_visit.number("diameterSlider").press("Enter")
    comparison = a_visit.archive("comparePlansButton")
    (page,) = (name for name in comparison.namelist() if name.endswith(".html"))
    assert b"Wider" in comparison.read(page)
    kept = []

    def keep(download):
        kept.append(download.suggested_filename)

    a_visit.page.on("download", keep)
    button = a_visit.named("comparePlansButton")
    words = button.inner_text()
    button.click()
    a_visit.until("comparePlansButton", "Stop")
    button.click()
    playwright.expect(button).to_have_text(words)
    a_visit.saved("savePlanButton")  # made later, and the only one
    assert kept == ["plan.zip"]
    a_visit.page.remove_listener("download", keep)


def test_a_page_that_hangs_holds_up_no_other(a_visit, the_server):
    known = {page.pid for page in the_server.pages()}
    address = get(the_server.address)[2]
    (other,) = (page for page in the_server.pages() if page.pid not in known)
    other.suspend()
    try:
        with ThreadPoolExecutor() as pool:
            asked = pool.submit(get, address)
            a_visit.click_lesion()
            a_visit.add_stent()
            a_visit.deploy()
            assert not asked.done()
            other.resume()
            assert asked.result()[0] == 200
    finally:
        other.kill()


def test_a_segment_and_a_mesh_of_ones_own_are_kept_by_the_browser(a_visit, the_folder, tmp_path):
    a_visit.page.evaluate("document.querySelectorAll('details').forEach(d => { d.open = true; })")
    a_visit.named("segmentEndsSelector").select_option("New points")
    place = a_visit.named("segmentPlaceWidget")
    playwright.expect(place).to_be_enabled()
    place.click()
    for share in (0.95, 0.02):
        playwright.expect(place).to_have_attribute("aria-pressed", "true")
        a_visit.page.mouse.click(*a_visit.seen(is_centerline, share))
    playwright.expect(place).to_have_attribute("aria-pressed", "false")
    a_visit.click_lesion()
    a_visit.add_stent()
    a_visit.deploy()
    a_visit.named("statusLabel").evaluate(REMEMBERED)
    segment = a_visit.archive("writeSegmentButton")
    a_visit.until("statusLabel", "Wrote segment, in cm;")
    walls = [name for name in segment.namelist() if name.endswith("mesh-surfaces/wall.vtp")]
    assert [name.split("/")[-3] for name in sorted(walls)] == ["after", "before"]
    assert all(b"<PolyData>" in segment.read(name) for name in walls)
    struts = polydata_from_vtp(a_visit.saved("saveDeviceButton"), tmp_path)
    a_visit.until("statusLabel", "Wrote stents.vtp.")
    a_visit.named("loadMeshButton").click()
    a_visit.page.fill("#chosenPath", str(the_folder / "mesh.vtp"))
    a_visit.named("chooser").get_by_role("button", name="OK").click()
    chosen = a_visit.named("deviceMeshSelector").locator("option:checked")
    playwright.expect(chosen).to_have_text("mesh")
    own = polydata_from_vtp(a_visit.saved("saveDeviceButton"), tmp_path)
    given = polydata_from_vtp((the_folder / "mesh.vtp").read_bytes(), tmp_path)
    assert own.GetNumberOfCells() == given.GetNumberOfCells() != struts.GetNumberOfCells()
    number = a_visit.named("flowMeanSpinBox").locator("input").first
    number.fill("3")
    number.blur()
    a_visit.until("lumenLabel", "At the mean flow of 50 mL/s (3 L/min)")
    assert json.loads(a_visit.saved("write0DButton"))["vessels"]
    a_visit.until("statusLabel", "Wrote network.json.")
    a_visit.page.locator(".panel").evaluate("panel => panel.scrollTo(0, panel.scrollHeight)")
    playwright.expect(a_visit.named("statusLabel")).not_to_be_in_viewport()
    playwright.expect(a_visit.named("said")).to_have_text("Wrote network.json.")
    playwright.expect(a_visit.named("said")).to_be_in_viewport(ratio=1)
    assert [text for text in a_visit.page.evaluate("window.texts") if "sdfstent-" in text] == []


def test_a_window_of_another_size_shows_what_was_looked_at(a_visit):
    def middle():
        a_visit.until_drawn()
        picture = a_visit.picture()
        (down, across), side = np.array(picture.shape) // 2, picture.shape[0] // 4
        return picture[down - side : down + side, across - side : across + side].mean()

    size = a_visit.page.viewport_size
    a_visit.click_lesion()
    a_visit.add_stent()
    a_visit.deploy()
    a_visit.named("fitButton").click()
    whole = middle()
    a_visit.click_lesion()
    for _attempt in range(100):  # the view goes there a moment later
        chosen = middle()
        if abs(chosen - whole) > 0.025:
            break
    assert abs(chosen - whole) > 0.025
    a_visit.page.set_viewport_size({"width": size["width"], "height": size["height"] - 120})
    assert middle() == pytest.approx(chosen, abs=0.02)
    a_visit.page.set_viewport_size(size)
    assert middle() == pytest.approx(chosen, abs=0.02)
    a_visit.named("fitButton").click()
    a_visit.page.set_viewport_size({"width": size["width"], "height": size["height"] - 120})
    shrunk = middle()
    a_visit.named("fitButton").click()
    assert middle() == pytest.approx(shrunk, abs=0.01)
    a_visit.page.set_viewport_size(size)


def test_a_page_that_is_loaded_again_has_its_stents(a_visit):
    a_visit.add_stent()
    a_visit.named("split").press("ArrowRight")
    width = a_visit.named("split").get_attribute("aria-valuenow")
    a_visit.until_drawn()  # a call under way would be told as refused
    a_visit.page.reload()
    a_visit.named("stentTable").locator("tbody tr").first.wait_for()
    a_visit.until("stentTable", "Stent 1")
    playwright.expect(a_visit.named("split")).to_have_attribute("aria-valuenow", width)


def test_a_page_that_has_failed_says_so_and_goes_on_by_itself(a_browser, the_folder, tmp_path):
    files = (the_folder / "cm" / "wall.vtp", "--centerline", the_folder / "cm" / "lines.vtp")
    server = AppServer(tmp_path / "workshop", *files, "--units", "cm")
    visit = Visit(a_browser, server.address)
    visit.until("lesionTable", "%")
    assert visit.text("message") == ""
    visit.click_lesion()
    visit.add_stent()
    diameter = visit.number("diameterSlider").input_value()
    (kept,) = (tmp_path / "workshop-state" / "sdfstent" / "plans").glob("*/plan.json")
    assert stat.S_IMODE(kept.parent.stat().st_mode) == 0o700
    while not json.loads(kept.read_text(encoding="utf-8"))["stents"]:
        visit.page.wait_for_timeout(100)
    (page,) = server.pages()
    address = visit.page.url
    visit.page.evaluate(SEEN_FOR_LONG)
    page.kill()
    visit.page.locator(".gone").wait_for()
    visit.until("stentTable", "Stent 1")  # nothing is lost
    playwright.expect(visit.number("diameterSlider")).to_have_value(diameter)
    assert visit.page.url == address
    assert visit.text("message") == ""
    (page,) = server.pages()
    page.kill()
    visit.page.locator(".gone").get_by_role("button").click()
    visit.until("stentTable", "Stent 1")
    server.process.kill()
    visit.page.locator(".gone").wait_for()
    visit.context.close()


def test_files_in_cm_are_shown_in_mm_and_saved_as_they_are(a_visit, the_folder, tmp_path):
    from SDFStentLib.files import read_surface
    from SDFStentLib.plan import load_plan, run_plan

    a_visit.open_section()
    a_visit.page.fill("#surfacePath", str(the_folder / "cm" / "wall.vtp"))
    a_visit.page.fill("#centerlinePath", str(the_folder / "cm" / "lines.vtp"))
    a_visit.named("openButton").click()
    a_visit.until("message", "name the unit of the file")
    for row in (0, -1):  # a mouse that comes over a row of lesions takes no message away
        a_visit.page.evaluate("row => window.trame.trigger('hover', ['lesionTable', row])", row)
    a_visit.until("message", "name the unit of the file")
    playwright.expect(a_visit.named("opening")).not_to_have_attribute("open", "")
    a_visit.open_section()
    a_visit.page.select_option("#fileUnits", "cm")
    a_visit.named("openButton").click()
    a_visit.click_lesion()
    a_visit.add_stent()
    a_visit.deploy()
    a_visit.archive().extractall(tmp_path)
    given = (the_folder / "cm" / "wall.vtp").read_bytes()
    assert (tmp_path / "surface.vtp").read_bytes() == given
    plan = load_plan(tmp_path / "plan.json")
    assert plan.units == "cm"
    (tmp_path / "page.vtp").write_bytes(a_visit.saved("save-surface"))
    result = run_plan(plan)
    by_page = read_surface(tmp_path / "page.vtp", "cm").surface.points
    np.testing.assert_allclose(result.treatment.points, by_page, rtol=0, atol=1e-9)
    stent = plan.stents[0]
    a_visit.until("lumenLabel", f"prescribed {round(stent.diameter, 2):g} mm")
    assert float(a_visit.number("diameterSlider").input_value()) == pytest.approx(stent.diameter)


def test_a_comma_is_taken_for_a_point_and_what_does_not_fit_is_said(a_visit):
    a_visit.add_stent()
    box = a_visit.number("diameterSlider")
    for typed, value in (("7,5", "7.50"), ("6.5", "6.50")):
        box.click()
        box.press("Control+a")
        box.press_sequentially(typed)
        box.press("Enter")
        playwright.expect(box).to_have_value(value)
    box.press("Control+a")
    box.press_sequentially("99")
    box.press("Enter")
    a_visit.page.get_by_text("got 99").first.wait_for()
    playwright.expect(box).to_have_value("6.50")


def test_the_lesion_under_the_mouse_is_marked_in_the_view_and_named_in_full(a_visit):
    a_visit.until("lesionTable", "%")
    row = a_visit.named("lesionTable").locator("tbody tr").first
    playwright.expect(row).to_contain_text("left pulmonary artery")
    cell = row.locator("td").first
    assert cell.evaluate("one => one.scrollWidth <= one.clientWidth")
    row.hover()
    a_visit.seen(is_selected_lesion)
    playwright.expect(a_visit.named("suggestButton")).to_be_disabled()  # it is not chosen


def test_keys_move_a_stent_end_placing_take_back_and_choose_rows(a_visit):
    keyboard, rows = a_visit.page.keyboard, a_visit.named("stentTable").locator("tbody tr")
    a_visit.add_stent()
    rows.first.click()
    places = [a_visit.center()]
    for key in ("ArrowRight", "ArrowLeft", "Shift+ArrowRight"):
        rows.first.focus()  # the browser's own window asked where to keep the plan
        keyboard.press(key)
        places.append(a_visit.center())
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    np.testing.assert_allclose(steps, [1, 1, 0.2], atol=0.02)
    place = a_visit.named("placeWidget")
    place.click()
    playwright.expect(place).to_have_attribute("aria-pressed", "true")
    keyboard.press("Escape")
    playwright.expect(place).to_have_attribute("aria-pressed", "false")
    a_visit.add_stent()
    rows.first.focus()
    keyboard.press("ArrowDown")
    keyboard.press("Delete")
    playwright.expect(rows).to_have_count(1)
    playwright.expect(a_visit.named("undoButton")).to_be_enabled()
    keyboard.press("Control+z")
    playwright.expect(rows).to_have_count(2)
    rows.first.focus()
    keyboard.press("Enter")
    playwright.expect(rows.first).to_have_attribute("aria-selected", "true")
    keyboard.press("ArrowDown")
    keyboard.press("Enter")
    playwright.expect(rows.nth(1)).to_have_attribute("aria-selected", "true")
    a_visit.slider("diameterSlider").focus()  # there an arrow changes the number
    before = a_visit.number("diameterSlider").input_value()
    keyboard.press("ArrowRight")
    playwright.expect(a_visit.number("diameterSlider")).not_to_have_value(before)
    a_visit.named("loadPlanButton").click()
    playwright.expect(a_visit.named("chooser")).to_be_visible()
    keyboard.press("Escape")
    playwright.expect(a_visit.named("chooser")).not_to_be_attached()
    for show in (lambda: keyboard.press("?"), a_visit.named("keysButton").click):
        show()
        playwright.expect(a_visit.named("keys")).to_be_visible()
        keyboard.press("Escape")
        playwright.expect(a_visit.named("keys")).to_be_hidden()
