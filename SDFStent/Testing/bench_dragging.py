"""Frames per second while a stent is dragged over a real artery, in the test host.

usage: bench_dragging.py [SURFACE CENTERLINE] [--units cm]

Moves the placement point 60 times along the centerline, with stents of 6 to 20 mm, through the panel with its timers; deploys in
full at every sixth place; goes back and forth over the steps of a deployment. Prints redeployments and shown steps per second, with and without drawing, and
where the time goes: the library, the scene (MRML, normals, stent model), the drawing, the rest (panel, timers, conversion).
Drawing is off-screen and, without a GPU, in software; "drawing alone" redraws an unchanged scene and is the limit that the
machine sets, whatever the module does. Without arguments the synthetic pulmonary artery is used.
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np
import slicer

sys.path.insert(0, str(Path(__file__).parent))
from sdfstent_host import Host

MOVES = 60
STEPS = 120
LENGTHS = (6.0, 10.0, 14.0, 20.0)


class Clock:
    """Seconds per name."""

    def __init__(self):
        self.seconds = {}

    def add(self, name, start):
        self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - start

    def timed(self, name, function):
        def run(*arguments, **keywords):
            start = time.perf_counter()
            try:
                return function(*arguments, **keywords)
            finally:
                self.add(name, start)

        return run

    def timedGenerator(self, name, function):
        """The same for a generator: only the time inside it counts."""

        def run(*arguments, **keywords):
            iterator = function(*arguments, **keywords)
            while True:
                start = time.perf_counter()
                try:
                    value = next(iterator)
                except StopIteration:
                    return
                finally:
                    self.add(name, start)
                yield value

        return run

    def report(self, title, count, seconds):
        shares = {name: value / seconds for name, value in self.seconds.items()}
        shares["rest"] = 1 - sum(shares.values())
        text = ", ".join(f"{name} {100 * share:.0f} %" for name, share in shares.items())
        print(f"{title}: {count / seconds:.1f} per second ({text})")
        self.seconds.clear()


def theArtery(arguments):
    from SDFStentSlicer import SampleVessels

    if not arguments.surface:
        return SampleVessels.addSampleVessel("branching_pulmonary_artery", "Artery")
    from SDFStentLib.files import polydata_from_arrays, read_centerline, read_surface

    surface = read_surface(arguments.surface, arguments.units)
    centerline = read_centerline(arguments.centerline, arguments.units)
    polyDatas = (
        polydata_from_arrays(surface.points.astype(np.float32), surface.triangles),
        SampleVessels.centerlinePolyData(getattr(centerline, "centerline", centerline)),
    )
    nodes = [slicer.mrmlScene.AddNewNodeByClass("vtkMRMLModelNode") for _ in polyDatas]
    for node, polyData in zip(nodes, polyDatas, strict=True):
        node.SetAndObservePolyData(polyData)
        node.CreateDefaultDisplayNodes()
    return nodes


def thePanel(host, arguments):
    """The panel with a vessel and a stent that were deployed once, and places along the longest branch."""
    panel = host.openPanel(host.loadModule(Path(__file__).parents[1] / "SDFStent.py"))
    logic, parameters = panel.logic, panel._parameterNode
    parameters.vessel, parameters.centerline = theArtery(arguments)
    logic.addStent(parameters, length=14.0)
    logic.deploy(parameters)
    tree = logic._inputs.centerline(parameters)
    leaf = tree.leaves[np.argmax(tree.arc_length[tree.leaves])]
    chain = tree.points[tree.ancestry(leaf)]
    return panel, chain[np.linspace(0.2 * len(chain), 0.8 * len(chain), MOVES).astype(int)]


def drag(host, panel, places, draw):
    """Move the handle, wait until the vessel has followed, draw once."""
    session, parameters = panel.session, panel._parameterNode
    parameters.autoUpdate = True
    for move, place in enumerate(places):
        with slicer.util.NodeModify(parameters):
            parameters.stent.length = LENGTHS[move % len(LENGTHS)]
        parameters.stent.handle.SetNthControlPointPositionWorld(0, *place)
        host.processUntil(lambda: not session.isRunning and not session._timer.isActive())
        draw()


def deploy(panel, places, draw):
    """Deploy in full at a few places, up to the certificate, every radius step shown; returns how many there were."""
    parameters, steps = panel._parameterNode, 0
    for place in places:
        parameters.stent.handle.SetNthControlPointPositionWorld(0, *place)
        shown = 0.0
        for fraction in panel.logic.steps(parameters):
            if fraction > shown:
                shown, steps = fraction, steps + 1
                draw()
            if fraction == 1.0:
                break
    return steps


def step(panel, draw):
    """Go back and forth over the expansion."""
    for percent in np.abs(np.linspace(-100, 100, STEPS)):
        panel.logic.showStep(panel._parameterNode, percent)
        draw()


def drawOnly(draw):
    for _ in range(MOVES):
        draw()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("surface", nargs="?")
    parser.add_argument("centerline", nargs="?")
    parser.add_argument("--units", default="mm")
    host = Host.start()
    panel, places = thePanel(host, parser.parse_args())
    view, mesh = host.application.view, panel._parameterNode.outputVessel.GetPolyData()
    view.render(mesh.GetBounds())
    print(f"{mesh.GetNumberOfPolys():,} triangles, stents of {LENGTHS[0]:g} to {LENGTHS[-1]:g} mm")
    print(f"drawn by {renderer(view.window)}, {' x '.join(map(str, view.window.GetSize()))} pixels")

    from SDFStentSlicer import Results
    from SDFStentSlicer.Stenting import Stenting
    from SDFStentSlicer.SurfaceOutput import SurfaceOutput

    clock = Clock()
    Stenting.__init__ = clock.timed("library", Stenting.__init__)
    Stenting.steps = clock.timedGenerator("library", Stenting.steps)
    Stenting.at = clock.timed("library", Stenting.at)
    SurfaceOutput.show = clock.timed("scene", SurfaceOutput.show)
    Results.showEnd = clock.timed("scene", Results.showEnd)
    draw = clock.timed("drawing", view.window.Render)
    for title, count, work in (
        ("redeployments, drawn", MOVES, lambda: drag(host, panel, places, draw)),
        ("redeployments, not drawn", MOVES, lambda: drag(host, panel, places, lambda: None)),
        ("radius steps computed and shown, drawn", 0, lambda: deploy(panel, places[::6], draw)),
        (
            "radius steps computed and shown, not drawn",
            0,
            lambda: deploy(panel, places[::6], lambda: None),
        ),
        ("radius steps shown, drawn", STEPS, lambda: step(panel, draw)),
        ("radius steps shown, not drawn", STEPS, lambda: step(panel, lambda: None)),
        ("drawing alone, nothing changed", MOVES, lambda: drawOnly(draw)),
    ):
        clock.seconds.clear()
        start = time.perf_counter()
        count = work() or count
        clock.report(title, count, time.perf_counter() - start)
        panel._parameterNode.autoUpdate = False
        panel.session.cancel()


def renderer(window):
    lines = [line for line in window.ReportCapabilities().splitlines() if "renderer" in line]
    return lines[0].partition(":")[2].strip() if lines else window.GetClassName()


if __name__ == "__main__":
    main()
