"""How well a page of `sdfstent app` follows a slider that is dragged in a real browser, and what it takes.

usage: bench_page.py [SURFACE CENTERLINE] [--units cm] [--seconds S] [--pages N] [--other]

Of the vessel that is named, or else the synthetic one: frames and number updates per second while the mouse drags the diameter
to and fro, drawn in software where there is no GPU; the memory of the page's process and of the server. With --pages so many
are opened one after another and closed, and what is left of them is told; with --other a second page deploys all the while.
Needs the extra `app`, playwright and a Chromium (or its path in the variable CHROMIUM).
"""

import argparse
import math
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import psutil
from playwright.sync_api import sync_playwright

PROJECT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(PROJECT), str(PROJECT / "tests")]

from app_server import CHROMIUM, QUIET, AppServer  # noqa: E402

EVENTS_PER_S = 40
"""Of the mouse: a hand's come 30 to 60 times a second, and each costs the driver time that a user would not need."""

WIDER = 0.1
"""Part of the suggested diameter by which it is dragged to and fro: stents that nobody would choose fold, and take long."""

DEPLOY_AGAIN = """() => {
setInterval(() => document.querySelector('[data-name="deployButton"]').click(), 100); }"""

COUNT = """() => { window.numbers = 0; window.frameTimes = [];
const label = document.querySelector('[data-name="lumenLabel"]'), screen = document.querySelector('.screen');
new MutationObserver(() => { window.numbers += 1; }).observe(label, {childList: true, characterData: true, subtree: true});
new MutationObserver(() => { window.frameTimes.push(performance.now() / 1000); }).observe(
  screen, {attributeFilter: ['src'], subtree: true});
window.stopped = window.answered = 0;
document.addEventListener('pointerup', () => { window.stopped = performance.now() / 1000; }, {capture: true});
const certificate = document.querySelector('[data-name="certificateLabel"]');
new MutationObserver(() => { if (window.stopped && !window.answered && certificate.textContent.includes('ertified'))
  window.answered = performance.now() / 1000; }).observe(certificate, {childList: true, characterData: true, subtree: true}); }"""
"""Counts what the browser is given to show, and when. Who waits for it from outside looks twice a second only."""


def inMillimeters(path, units, folder):
    """A surface or lines in another unit as a file in mm, in double precision."""
    from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLPolyDataWriter

    reader = vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    polyData, scale = reader.GetOutput(), {"mm": 1.0, "cm": 10.0}[units]
    points = scale * vtk_to_numpy(polyData.GetPoints().GetData()).astype(np.float64)
    polyData.GetPoints().SetData(numpy_to_vtk(points, deep=True))
    for name in ("Radius", "MaximumInscribedSphereRadius"):
        array = polyData.GetPointData().GetArray(name)
        if array is not None:
            vtk_to_numpy(array)[:] *= scale
    writer = vtkXMLPolyDataWriter()
    writer.SetFileName(str(folder / path.name))
    writer.SetInputData(polyData)
    writer.Write()
    return folder / path.name


class Dragged:
    """A page with a stent at the tightest lesion."""

    def __init__(self, browser, address):
        self.page = browser.new_page(viewport={"width": 1280, "height": 800})
        self.tools = self.page.context.new_cdp_session(self.page)
        start = time.perf_counter()
        self.page.goto(address)
        self.named("deployButton").wait_for(timeout=120_000)
        print(f"page ready after {time.perf_counter() - start:.1f} s")
        self.named("lesionTable").filter(has_text="%").wait_for(timeout=120_000)
        self.named("lesionTable").locator("td").first.click()
        self.named("addStentButton").click()
        self.named("stentTable").locator("tbody tr").first.wait_for()

    def named(self, name):
        return self.page.locator(f'[data-name="{name}"]')

    def deploy(self):
        self.named("deployButton").click()
        self.named("atHand").filter(has_text="certified").wait_for(timeout=120_000)

    def moveMouse(self, x, y):
        """As the driver does, which also asks the page twice at every move whether something is dragged and dropped."""
        place = {"x": x, "y": y, "button": "left", "buttons": 1}
        self.tools.send("Input.dispatchMouseEvent", {"type": "mouseMoved", **place})

    def drag(self, seconds, server):
        """Drag the diameter to and fro with the mouse; frames and number updates per second, and the CPU of both sides."""
        self.named("autoUpdateCheckBox").locator("input").check()
        slider = self.named("diameterSlider").locator('input[type="range"]')
        slider.scroll_into_view_if_needed()
        box = slider.bounding_box()
        low, high, begun = (
            float(slider.evaluate(f"one => one.{key}")) for key in ("min", "max", "value")
        )

        def placeOf(diameter):
            return box["x"] + box["width"] * (diameter - low) / (high - low)

        y = box["y"] + box["height"] / 2
        self.page.mouse.move(placeOf(begun), y)
        self.page.mouse.down()
        sides = {
            "pages": server.pages(),
            "server": [psutil.Process(server.process.pid)],
            "browser": browsers(),
            "its driver, which is not there otherwise": drivers(),
        }
        self.page.evaluate(COUNT)
        before = {name: cpu(processes) for name, processes in sides.items()}
        start, events = time.perf_counter(), 0
        while (now := time.perf_counter() - start) < seconds:
            self.moveMouse(placeOf(begun * (1 + WIDER * math.sin(2 * now))), y)
            events += 1
            time.sleep(max(0.0, start + now + 1 / EVENTS_PER_S - time.perf_counter()))
        numbers, found = self.page.evaluate("[window.numbers, window.frameTimes]")
        took = time.perf_counter() - start
        spent = {name: cpu(processes) - before[name] for name, processes in sides.items()}
        self.page.mouse.up()
        self.page.wait_for_function("window.answered", timeout=120_000)
        answer = self.page.evaluate("window.answered - window.stopped")
        gaps = np.diff(found) if len(found) > 1 else np.array([np.inf])
        for name, value in spent.items():
            print(
                f"CPU of {name}: {value / took:.2f} cores, {1000 * value / max(len(found), 1):.0f} ms a frame"
            )
        print(
            f"{events / took:.0f} events/s: {len(found) / took:.1f} frames/s (longest gap {gaps.max():.2f} s), "
            f"{numbers / took:.1f} number updates/s, full answer after {answer:.2f} s"
        )


def browsers():
    """Everything that this process has started and that is no Python."""
    found = psutil.Process().children(recursive=True)
    return [process for process in found if "chrom" in process.name()]


def drivers():
    """This process, and what it drives the browser with."""
    found = psutil.Process().children(recursive=True)
    return [psutil.Process(), *(process for process in found if "node" in process.name())]


def cpu(processes):
    """Seconds that they have used."""
    return sum(sum(process.cpu_times()[:2]) for process in processes if process.is_running())


def tellMemory(server):
    for process, name in [
        (psutil.Process(server.process.pid), "server"),
        *((p, "page") for p in server.pages()),
    ]:
        info = process.memory_full_info()
        print(f"{name}: {info.rss / 1e6:.0f} MB resident, {info.uss / 1e6:.0f} MB its own")


def openAndClose(browser, server, count):
    """So many pages one after another; what there was before the first and after the last."""
    tellLeft(server, 0)
    for _number in range(count):
        page = browser.new_page()
        page.goto(server.address)
        page.locator('[data-name="deployButton"]').wait_for(timeout=120_000)
        page.close()
    end = time.perf_counter() + 30
    while server.pages() and time.perf_counter() < end:
        time.sleep(0.2)
    tellLeft(server, count)


def tellLeft(server, count):
    process = psutil.Process(server.process.pid)
    print(
        f"after {count} pages: {len(server.pages())} processes, {len(list(server.folder.iterdir()))} folders, "
        f"{process.num_fds()} open files, {process.memory_info().rss / 1e6:.0f} MB"
    )


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--units", default="mm")
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--pages", type=int, default=0)
    parser.add_argument("--other", action="store_true")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name, sync_playwright() as driver:
        folder = Path(name)
        given = [inMillimeters(path, arguments.units, folder) for path in arguments.files]
        begins = [given[0], "--centerline", given[1]] if given else ["--demo"]
        server = AppServer(folder / "workshop", *begins, "--keep", "0.5")
        try:
            browser = driver.chromium.launch(executable_path=CHROMIUM, args=QUIET)
            if arguments.pages:
                openAndClose(browser, server, arguments.pages)
            else:
                other = Dragged(browser, server.address) if arguments.other else None
                dragged = Dragged(browser, server.address)
                if other is not None:
                    other.page.evaluate(DEPLOY_AGAIN)
                dragged.drag(arguments.seconds, server)
                tellMemory(server)
            browser.close()
        finally:
            print(server.interrupt(), end="")


if __name__ == "__main__":
    main()
