"""How well the panel follows a stent that is dragged, in the test host.

usage: bench_dragging.py [SURFACE CENTERLINE] [--units cm] [--subdivisions N ...] [--no-tree] [--frames MS ...]

Per vessel: redeployments per second, each waited for; then a hand that does not wait, which moves 60 times a second: surface
and number updates per second, the longest silence of the event loop from choosing the vessel to the full answer, and how long
after the hand has stopped that comes. Undrawn, and with --frames also beside frames that take so many milliseconds each,
during which nothing else advances, as in software: how many there are, and how many of them carry a new surface. The artery that
is named, or else a synthetic one, then each of its triangles cut into four N times (--subdivisions, default 2; 0: not at all),
and a phantom tree of about 300 branches where there is one.
"""

import argparse
import os
import sys
import time
from pathlib import Path

import numpy as np
import slicer
import vtk

sys.path.insert(0, str(Path(__file__).parent))
from sdfstent_host import Host

MOVES = 60
FOLLOWED_S = 10.0
LONG = 120.0
SYNTHETIC = "branching_pulmonary_artery"
LENGTHS = (6.0, 10.0, 14.0, 20.0)


def theArtery(arguments):
    from SDFStentSlicer import SampleVessels

    if not arguments.surface:
        return SampleVessels.addSampleVessel(SYNTHETIC, "Artery")
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


def subdivided(vessel, times):
    """The vessel's node, each triangle cut into four so many times."""
    refine = vtk.vtkLinearSubdivisionFilter()
    refine.SetInputData(vessel.GetPolyData())
    refine.SetNumberOfSubdivisions(times)
    refine.Update()
    vessel.SetAndObservePolyData(refine.GetOutput())
    return vessel


def theVessels(arguments):
    """Name and a function that adds vessel and centerline to the scene, per case."""
    from SDFStentSlicer import SampleVessels

    from benchmarks.phantoms import vascular_tree

    yield "artery", lambda: theArtery(arguments)
    for times in filter(None, arguments.subdivisions):

        def fine(times=times):
            vessel, centerline = theArtery(arguments)
            return subdivided(vessel, times), centerline

        yield "artery, subdivided", fine
    if arguments.tree:
        made = vascular_tree()
        yield (
            "tree",
            lambda: SampleVessels.addVessel(made.surface, made.faces, made.centerline, "Tree"),
        )


def thePanel(host, nodes):
    """The panel with a vessel and a stent that were deployed once, and places along the longest branch."""
    panel = host.openPanel(host.loadModule(Path(__file__).parents[1] / "SDFStent.py"))
    logic, parameters = panel.logic, panel._parameterNode
    panel.silence = Silence(host)
    parameters.vessel, parameters.centerline = nodes
    host.processUntil(lambda: not panel.lesions.isBusy, LONG)
    host.processUntil(lambda: not panel.preparation.isRunning, LONG)
    panel.silence.report("vessel chosen and prepared")
    logic.addStent(parameters, length=14.0)
    panel.silence.report("stent added")
    panel.session.start()
    host.processUntil(lambda: not panel.session.isBusy, LONG)
    panel.silence.report("first deployment")
    tree = logic._inputs.centerline(parameters)
    leaf = tree.leaves[np.argmax(tree.arc_length[tree.leaves])]
    chain = tree.ancestry(leaf)
    way = chain[np.linspace(0.2 * len(chain), 0.8 * len(chain), MOVES).astype(int)]
    radius = float(np.nanmedian(tree.inscribed_radius[way]))
    parameters.stent.diameter = round(2.4 * radius, 1)  # the first one's suits the whole vessel
    return panel, tree.points[way]


class Silence:
    """The longest time for which the event loop did not turn, and the most CPU time of all threads in between.

    On cores that nobody else uses the two are about the same; on shared ones the second says what it would be.
    """

    def __init__(self, host):
        import qt  # there once the host has started

        self._host = host
        self.forget()
        self._timer = qt.QTimer()
        self._timer.setInterval(0)
        self._timer.connect("timeout()", self._turn)
        self._timer.start()

    def _turn(self):
        now = np.array([time.perf_counter(), time.process_time()])
        self._longest, self._last = np.maximum(self._longest, now - self._last), now

    def report(self, title):
        """Print and forget it."""
        self._host.process()
        wall, cpu = 1e3 * self._longest
        print(f"  {title}: event loop away for at most {wall:.0f} ms, {cpu:.0f} ms of CPU time")
        self.forget()

    def pause(self):
        """Do not look: a timer that is always due keeps Qt's own loop from returning, for 5 ms in the mean of 10."""
        self._timer.stop()

    def resume(self):
        """Look again, from now on."""
        self._timer.start()
        self.forget()

    def forget(self):
        """Begin anew."""
        self._longest = np.zeros(2)
        self._last = np.array([time.perf_counter(), time.process_time()])


class Counter:
    """How often a function, or a method of all objects of a class, was called."""

    def __init__(self, owner, name):
        self.count = 0
        function = getattr(owner, name)

        def counted(*arguments, **keywords):
            self.count += 1
            return function(*arguments, **keywords)

        setattr(owner, name, counted)


def followDrawn(host, panel, places, counters, milliseconds):
    """The same beside frames that cost something."""
    surfaces, carried = counters["surface updates"], []
    with host.drawing(milliseconds / 1000) as frames:
        frames.onFrame = lambda: carried.append(surfaces.count)
        print(f"  frames of {milliseconds:g} ms")
        follow(host, panel, places, counters)
    share = np.mean(np.diff(carried) > 0)
    print(f"  {len(carried)} frames, {100 * share:.0f} % with a new surface")


def follow(host, panel, places, counters):
    """A hand that moves 60 times a second and does not wait, back and forth; then it stops."""
    parameters = panel._parameterNode
    parameters.autoUpdate = True
    way = np.concatenate([places, places[::-1]])
    before = {name: counter.count for name, counter in counters.items()}
    panel.silence.forget()
    start = time.perf_counter()
    # Ends: with the time.
    while (elapsed := time.perf_counter() - start) < FOLLOWED_S:
        place = way[int(60 * elapsed) % len(way)]
        parameters.stent.handle.SetNthControlPointPositionWorld(0, *place)
        host.process(max(0.0, 1 / 60 - (time.perf_counter() - start - elapsed)))
    seconds = time.perf_counter() - start
    for name, counter in counters.items():
        print(f"  dragged: {(counter.count - before[name]) / seconds:.1f} {name} a second")
    panel.silence.report("dragged")
    fullAnswer(host, panel, "the hand stopped")
    parameters.stent.handle.SetNthControlPointPositionWorld(0, *places[len(places) // 10])
    parameters.stent.handle.InvokeEvent(parameters.stent.handle.PointEndInteractionEvent)
    fullAnswer(host, panel, "a handle was let go")
    parameters.stent.diameter += 0.2
    fullAnswer(host, panel, "another diameter was set there")
    parameters.autoUpdate = False


def fullAnswer(host, panel, since):
    """Wait for everything: surface, certificate, numbers, lesions, table and plot."""
    start, worked = time.perf_counter(), time.process_time()
    host.processUntil(lambda: not panel.session.isBusy, LONG)
    answer, cpu = time.perf_counter() - start, time.process_time() - worked
    if "prescribed" not in panel._parameterNode.lumenSummary:
        raise RuntimeError(f"No answer came: {panel._parameterNode.status}")
    print(f"  full answer {answer:.2f} s after {since}; {cpu:.2f} s of CPU time")
    panel.silence.report("full answer")


def redeployments(host, panel, places):
    """How long each takes from the moved handle to the surface; the median counts."""
    session, parameters = panel.session, panel._parameterNode
    parameters.autoUpdate = True
    panel.silence.pause()
    wall, cpu = [], []
    for move, place in enumerate(places):
        start, worked = time.perf_counter(), time.process_time()
        with slicer.util.NodeModify(parameters):
            parameters.stent.length = LENGTHS[move % len(LENGTHS)]
        parameters.stent.handle.SetNthControlPointPositionWorld(0, *place)
        host.processUntil(lambda: not session.isRunning and not session._timer.isActive())
        wall.append(time.perf_counter() - start)
        cpu.append(time.process_time() - worked)
    parameters.autoUpdate = False
    session.cancel()
    panel.silence.resume()
    print(
        f"  redeployments: {1 / np.median(wall):.1f} a second ({1e3 * np.median(cpu):.0f} ms of CPU time each; median of "
        f"{len(places)}), slowest {1e3 * max(wall):.0f} ms"
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("surface", nargs="?")
    parser.add_argument("centerline", nargs="?")
    parser.add_argument("--units", default="mm")
    parser.add_argument("--subdivisions", type=int, nargs="+", default=[2])
    parser.add_argument("--no-tree", dest="tree", action="store_false")
    parser.add_argument("--frames", type=float, nargs="+", default=[], metavar="MS")
    arguments = parser.parse_args()
    host = Host.start()
    host.sitsOutWaits = True
    host.loadModule(Path(__file__).parents[1] / "SDFStent.py")
    print(f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}")
    from SDFStentSlicer import Results
    from SDFStentSlicer.SurfaceOutput import SurfaceOutput

    counters = {
        "surface updates": Counter(SurfaceOutput, "showChanged"),
        "number updates": Counter(Results, "showPreviewed"),
    }
    for name, nodes in theVessels(arguments):
        vessel, centerline = nodes()
        print(f"{name}: {vessel.GetPolyData().GetNumberOfPolys():,} triangles")
        panel, places = thePanel(host, (vessel, centerline))
        redeployments(host, panel, places)  # the first time weights are made
        redeployments(host, panel, places)
        follow(host, panel, places, counters)
        for milliseconds in arguments.frames:
            followDrawn(host, panel, places, counters, milliseconds)
        host.closePanel(panel)
        host.newScene()


if __name__ == "__main__":
    main()
